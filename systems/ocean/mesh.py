"""SeaMesh: the sea's cells around a view's proxy, and what moves them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...components import Ocean, Planet
from ...engine.blocks.bindings import MOVED_CELLS_BUFFER
from ...engine.frame import Frame, Proxy, View
from ...engine.frame.published import HEIGHT_FIELD, SEA_TOP_M, SURFACE_HEIGHT
from ...engine.frame.snapping import Scale, SnapAhead
from ...engine.gpu import GpuScope
from ...engine.gpu.cell_mesh import CellPrograms
from ...engine.graph import BufferSpec, PassIO
from ...engine.settings import Settings
from ...engine.snapped import CellChoice, SnappedMesh
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.selection import MOST_CELLS, chord_limit_m, rows_in, select_rings, spacing_angle
from ...engine.world import World
from .method import Displaced, SeaSurface
from .wave_passes import SeaWaves, WaveView

__all__ = ["SeaMaking", "SeaMesh"]

_MOST_SKIPPED = 1  # powers of two


@dataclass(kw_only=True)
class SeaChoice(CellChoice):
    """A selection and what its vertices depend on."""

    above_sea_m: float
    smallest_m: float
    moves: bool
    reach_m: tuple[float, float]
    """How far waves may move a point: upwards, and in all."""


class SeaCells(NamedTuple):
    """What the sea's cells depend on beside proxy and scale. hides: whether the sea hides its bed."""

    surface: SeaSurface
    min_spacing_m: float
    hides: bool


class SeaMaking:
    """What makes the sea's vertices, shared by all views."""

    def __init__(self, gpu: GpuScope, settings: Settings, world: World, waves: SeaWaves) -> None:
        self.world, self.waves = world, waves
        self.programs = CellPrograms(gpu, int(settings["terrain.quads"]), "ocean/vertices.comp")
        self.list = gpu.compute("ocean/list_cells.comp", defines=self.programs.defines)
        self.most = int(settings["terrain.decimation"])
        self.prepares = int(settings["proxy.ahead_frames"]) > 0


class SeaMesh(SnappedMesh[SeaChoice]):
    """One view's calm sea, the waves on it, and which of its cells these may be seen to move."""

    phases: ClassVar[tuple[str, ...]] = ("sea",)
    ahead_reads = ("terrain_ahead.bounds",)  # where the ground has a mesh like this one
    keep_dh_m = (-1.0e29, 3.0e38)  # ocean/vertices.comp marks cells without water

    def __init__(self, of: GpuScope, making: SeaMaking, view: View) -> None:
        super().__init__(of, "ocean", making.programs, making.prepares)
        self._making, self._of = making, view
        self.waves = WaveView(self.gpu)
        self.displaced: Displaced | None = None
        self._rows = self.gpu.buffer(reserve=4 * self.mesh.capacity, dynamic=True)  # of the ground's cells
        self._list: Any = None  # buffer of the cells to displace, on the GPU

    @property
    def moving(self) -> Displaced:
        """What the displaced vertices depend on."""
        return Displaced(self.made, self.culled, self.waves.moment)

    def update(self, frame: Frame) -> bool:
        """Choose the cells; True where passes or buffers changed."""
        self.hides = self._hides(frame)
        snapped, changed = self.follow(frame)
        if snapped:
            made = self.choice
            assert made is not None
            changed |= self._making.waves.place(
                self.waves, frame, made.above_sea_m, self.scale.pixel_rad, made.eye_m, made.edge_rad, made.smallest_m
            )
        self.look(frame)
        return changed

    @staticmethod
    def _hides(frame: Frame) -> bool:
        """Whether the sea hides its bed."""
        # From below the surface is seen until the line of sight, which the bed may bend, has come up to it.
        radius = frame.world.get(frame.planet, Planet).radius_m
        return frame.camera.distance_m - radius >= frame.world.resource(SEA_TOP_M)

    def surface(self, frame: Frame) -> SeaCells:
        return SeaCells(SeaSurface.of(frame), float(frame.settings["terrain.min_spacing_m"]), self._hides(frame))

    def choose(self, frame: Frame, proxy: Proxy, scale: Scale) -> SeaChoice:
        ocean = frame.world.get(frame.planet, Ocean)
        radius = frame.world.get(frame.planet, Planet).radius_m
        ground = frame.world.try_resource(HEIGHT_FIELD)
        angle_rad = spacing_angle(*scale, proxy.cell.altitude_m, radius)
        above_sea = max(abs(proxy.cell.altitude_m - ocean.sea_level_m), 0.05)
        smallest_m = float(frame.settings["terrain.min_spacing_m"])
        height = ocean.sea_level_m + above_sea - proxy.anchor_height_m
        moves, reach_m = self._making.waves.reach(frame, above_sea, scale.pixel_rad)
        crest = ocean.sea_level_m + reach_m[0]
        cells = select_rings(
            proxy.lattice,
            above_sea,
            ocean.sea_level_m,
            radius,
            angle_rad,
            self.mesh.quads,
            # As far as the ground is drawn: beyond its horizon the sea still hides the bed behind peaks.
            coverage_rad=proxy_coverage(
                proxy.cell.covered_altitude_m,
                proxy.cell.covered_sideways_rad,
                radius,
                max(crest, -np.inf if ground is None else ground.highest_m),
                ground.lowest_m if not self.hides and ground is not None else ocean.sea_level_m,
            ).half_angle_rad,
            min_spacing_m=smallest_m,
            max_cells=MOST_CELLS,
        )
        # At the limb chords of the sea must not hang below the bed, which has the same lattice.
        chord_m = 0.05 * chord_limit_m(scale.pixel_rad, radius)
        return SeaChoice(
            cells=cells,
            proxy=proxy,
            eye_m=tuple(proxy.lattice.direction * height),
            edge_rad=angle_rad,
            chord_m=chord_m,
            above_sea_m=above_sea,
            smallest_m=smallest_m,
            moves=moves,
            reach_m=reach_m,
        )

    def most_skipped(self, choice: SeaChoice) -> int:
        # Chords of eight edges would cut off the waves that are there to be seen; two of them a pixel's height.
        return min(self._making.most, _MOST_SKIPPED) if choice.moves else self._making.most

    def bind(self, choice: SeaChoice, first: int, snap: SnapAhead | None) -> None:
        vertices, bind_heights = self._making.programs.vertices, None
        if snap is not None:
            bind_heights = snap.bind_heights
        elif (found := self._making.world.try_resource(SURFACE_HEIGHT)) is not None:
            bind_heights = partial(found, self._of)
        if bind_heights is not None:
            bind_heights()
        vertices.set("u_reach_up_m", choice.reach_m[0])
        vertices.set("u_reach_m", choice.reach_m[1])
        beside = snap is not None and self._beside_ground(choice, first, snap)
        if not beside:  # nothing is read there, but something has to be bound, and it may be no other pass's
            self.mesh.bind_bounds(7)
        self._rows.bind_to_storage_buffer(6)
        vertices.set("u_first", first if beside else -1)

    def _beside_ground(self, choice: SeaChoice, first: int, snap: SnapAhead) -> bool:
        """Bind the ground's boxes and which of them is whose, if the ground has been made: most of a coast's cells, and
        all inland, then need no depths."""
        ground = snap.ground
        made = None if ground is None else ground.made(snap)
        if ground is None or made is None:
            return False
        if first == 0:
            rows = rows_in(choice.cells, made.cells).astype("<i4").tobytes()
            if self._rows.size < len(rows):
                self.gpu.free(self._rows)
                self._rows = self.gpu.buffer(reserve=4 * self.ahead.mesh.capacity, dynamic=True)
            self._rows.write(rows)
        ground.mesh.bind_bounds(7)
        return True

    def lists(self) -> tuple[BufferSpec, ...]:
        cells = BufferSpec("ocean.cells", 16 + 4 * self.mesh.capacity, "persistent", "cells to displace")
        return (cells,) if self.waves.moves else ()

    def bind_cull(self, io: PassIO) -> Callable[[], None]:
        cells, cull = io.buffer("ocean.cells") if self.waves.moves else None, super().bind_cull(io)
        if cells is not self._list:  # else what is in it still holds
            self.culled, self._list = None, cells

        def run() -> None:
            cull()
            if cells is not None:
                self.gpu.barrier()
                cells.bind_to_storage_buffer(MOVED_CELLS_BUFFER)
                self._making.list.run(1, 1, 1)

        return run
