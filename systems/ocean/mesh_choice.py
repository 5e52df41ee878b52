"""Which cells the sea has for a proxy, and their vertices for the next one, made over some frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...components import Ocean, Planet
from ...engine.frame import Frame
from ...engine.frame.snapping import SnapAhead
from ...engine.gpu import GpuScope
from ...engine.gpu.cell_mesh import CellMesh
from ...engine.mesh_ahead import MeshAhead
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.selection import CellSet, chord_limit_m, rows_in, select_rings, spacing_angle
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


class SeaAhead(MeshAhead):
    """One view's next snap."""

    phase: ClassVar[str] = "sea"

    def __init__(self, gpu: GpuScope, name: str, quads: int, making: SeaMaking) -> None:
        super().__init__(CellMesh(gpu, f"{name}_ahead", quads))
        self._gpu, self._making = gpu, making
        self._rows = gpu.buffer(reserve=4 * self.mesh.capacity, dynamic=True)
        self.choice = SeaChoice()
        self._seen = -1

    def update(
        self, snap: SnapAhead, key: tuple[Any, ...], scale: tuple[float, float], choose: Callable[[], SeaChoice]
    ) -> bool:
        """CPU work of one frame, while the ground's vertices are made: its cells are chosen in the frame before. True
        where buffers of the graph grew."""
        first, self._seen = snap.number != self._seen, snap.number
        if snap.phase not in ("ground", "sea") or (first and snap.phase == "ground"):
            return False

        def chosen() -> CellSet:
            self.choice = choose()
            assert self.choice.cells is not None
            return self.choice.cells

        return self.advance(snap, key, scale, chosen) | self.make_room(snap)

    def make(self, snap: SnapAhead, first: int, count: int) -> None:
        """See MeshAhead."""
        made, choice = self._making, self.choice
        if snap.bind_heights is not None:
            snap.bind_heights()
        made.vertices.set("u_reach", choice.reach_m)
        made.vertices.set("u_first", first if self._beside_ground(snap, first == 0) else -1)
        self.mesh.make_part(
            made.vertices, made.measure, choice.eye_m, choice.edge_rad, choice.chord_m, made.skipped(choice),
            first, count,
        )  # fmt: skip

    def _beside_ground(self, snap: SnapAhead, first: bool) -> bool:
        """Bind the ground's boxes and which of them is whose, if the ground has been made: most of a coast's cells, and
        all inland, then need no depths."""
        ground = snap.ground
        cells = None if ground is None else ground.made(snap)
        if ground is None or cells is None or self.choice.cells is None:
            return False
        if first:
            rows = rows_in(self.choice.cells, cells).astype("<i4").tobytes()
            if self._rows.size < len(rows):
                self._gpu.free(self._rows)
                self._rows = self._gpu.buffer(reserve=4 * self.mesh.capacity, dynamic=True)
            self._rows.write(rows)
        self._rows.bind_to_storage_buffer(6)
        ground.mesh.bind_bounds(7)
        return True

    def agree(self) -> None:
        """See MeshAhead."""
        self.mesh.agree(self._making.agree)
