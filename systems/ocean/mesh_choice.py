"""Which cells the sea has for a proxy, and their vertices for the next one, made over some frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...components import Ocean, Planet
from ...engine.gpu import GpuScope
from ...engine.gpu.cell_mesh import CellMesh
from ...engine.graph import PassIO
from ...engine.snap_ahead import SnapAhead
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.decimation import topology
from ...engine.surface.selection import CellSet, chord_limit_m, select_rings, spacing_angle
from ...engine.system import Frame
from .wave_passes import SeaWaves

__all__ = ["SeaAhead", "SeaChoice", "SeaMaking", "choose_sea"]

_MOST_CELLS = 12000  # as for the ground
_MOST_SKIPPED = 1  # powers of two


@dataclass
class SeaChoice:
    """A selection and what its vertices depend on."""

    cells: CellSet | None = None
    above_sea_m: float = 1.0
    eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    """The proxy, from its anchor."""
    edge_rad: float = 0.01
    chord_m: float = 1.0
    smallest_m: float = 0.0
    moves: bool = False
    reach_m: tuple[float, float] = (0.0, 0.0)
    """How far waves may move a point: upwards, and in all."""


def choose_sea(
    frame: Frame, waves: SeaWaves, proxy: Any, quads: int, edge_px: float, pixel_angle: float, from_below: bool
) -> SeaChoice:
    """The sea's cells for a proxy. from_below: the camera is under water."""
    ocean = frame.world.get(frame.planet, Ocean)
    radius = frame.world.get(frame.planet, Planet).radius_m
    ground = frame.world.resources.get("height_field")
    angle_rad = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, radius)
    above_sea = max(abs(proxy.cell.altitude_m - ocean.sea_level_m), 0.05)
    smallest_m = float(frame.settings["terrain.min_spacing_m"])
    height = ocean.sea_level_m + above_sea - proxy.anchor_height_m
    moves, reach_m = waves.reach(frame, above_sea, pixel_angle)
    crest = ocean.sea_level_m + reach_m[0]
    cells = select_rings(
        proxy.lattice,
        above_sea,
        ocean.sea_level_m,
        radius,
        angle_rad,
        quads,
        # As far as the ground is drawn: beyond its horizon the sea still hides the bed behind peaks.
        coverage_rad=proxy_coverage(
            proxy.cell.covered_altitude_m,
            proxy.cell.covered_sideways_rad,
            radius,
            max(crest, -np.inf if ground is None else ground.highest_m),
            ground.lowest_m if from_below and ground is not None else ocean.sea_level_m,
        ).half_angle_rad,
        min_spacing_m=smallest_m,
        max_cells=_MOST_CELLS,
    )
    # At the limb chords of the sea must not hang below the bed, which has the same lattice.
    chord_m = 0.05 * chord_limit_m(pixel_angle, radius)
    eye_m = tuple(proxy.lattice.direction * height)
    return SeaChoice(cells, above_sea, eye_m, angle_rad, chord_m, smallest_m, moves, reach_m)


@dataclass
class SeaMaking:
    """What makes vertices, shared by all views."""

    vertices: Any
    measure: Any
    agree: Any
    most: int

    def skipped(self, choice: SeaChoice) -> int:
        """Powers of two that a cell may skip: chords of eight edges would cut off the waves that are there to be seen;
        two of them a pixel's height."""
        return min(self.most, _MOST_SKIPPED) if choice.moves else self.most


class SeaAhead:
    """One view's next snap (engine/snap_ahead.py)."""

    def __init__(self, gpu: GpuScope, name: str, quads: int, making: SeaMaking) -> None:
        self._making = making
        self.mesh = CellMesh(gpu, f"{name}_ahead", quads)
        self.choice = SeaChoice()
        self.key: tuple[Any, ...] = ()
        self.scale = (0.0, 0.0)
        self._number = -1
        self._uploaded = self._agreed = False
        self._done = 0  # cells with vertices
        self._snap: SnapAhead | None = None

    def complete(self, key: tuple[Any, ...]) -> bool:
        """Whether the mesh is the one for this key."""
        return self._agreed and key == self.key

    def update(
        self, snap: SnapAhead, key: tuple[Any, ...], scale: tuple[float, float], choose: Callable[[], SeaChoice]
    ) -> bool:
        """CPU work of one frame: first the choice, then its upload. True where buffers of the graph grew."""
        self._snap = snap
        if snap.phase != "sea":
            return False
        if snap.number != self._number or key != self.key:
            self._number, self.key, self.scale = snap.number, key, scale
            self._uploaded = self._agreed = False
            self.choice = choose()
            return False
        if self._uploaded:
            return False
        assert self.choice.cells is not None
        self._uploaded, self._done = True, 0
        return self.mesh.upload(self.choice.cells, topology(self.choice.cells))

    @property
    def due(self) -> bool:
        """Whether the GPU has something to do in this frame."""
        snap = self._snap
        return snap is not None and snap.phase == "sea" and self._uploaded and snap.number == self._number

    def bind(self, io: PassIO) -> Callable[[], None]:
        """The pass that makes a share of the vertices."""
        if self.mesh.attach_vertices(io):
            self._done, self._agreed = 0, False

        def run() -> None:
            snap = self._snap
            if not self.due or snap is None:
                return  # the graph runs every pass once
            made, mesh, choice = self._making, self.mesh, self.choice
            count = min(snap.part("sea", mesh.count, mesh.part_step), mesh.count - self._done)
            if count > 0:
                snap.bind_anchor()
                if snap.bind_heights is not None:
                    snap.bind_heights()
                made.vertices.set("u_reach", choice.reach_m)
                mesh.make_part(
                    made.vertices, made.measure, choice.eye_m, choice.edge_rad, choice.chord_m, made.skipped(choice),
                    self._done, count,
                )  # fmt: skip
                snap.restore_anchor()
                self._done += count
            if self._done >= mesh.count:
                mesh.agree(made.agree)
                self._agreed = True
                snap.finish("sea")

        return run
