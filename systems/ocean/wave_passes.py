"""SeaWaves: the waves of the moment on the GPU, and how the sea lies in each of its pixels."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...components import Ocean, Planet, Wind
from ...components.wind import blown
from ...engine.blocks.bindings import COAST_NORMAL_IMAGE, SEA_MOVED_UNIT, SWELL_BUFFER, TILE_BUFFER, WAVE_BLOCK
from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.gbuffer import GBUFFER_UNITS, TILE_PX, tiles_of
from ...engine.gpu import GpuScope
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import revision, with_overrides
from ...engine.system import Setup
from ...engine.warm_up import WarmUp
from ...engine.waves import WaveSet, waves_of
from .swell_tile import SWELL_BYTES
from .wave_block import WAVE_LAYOUT, SeaMesh, WavePacker

__all__ = ["SeaWaves", "WaveMoment", "WaveView", "highest_likely_m"]

MANY = 48
"""From so many waves on the long ones of each tile of the picture are summed at a few nodes of it."""
_LONG_RUNS = 256
"""From so many waves on a software renderer takes twice as many pixels a lane."""

_READ_WHERE_SHADED = {"ocean.shade", "terrain.shade", "cover.shade"}
"""Passes that read the sea's normals and roughness only where it is shaded (`ocean.shade_every`)."""

_RG16_SNORM = 0x8F99  # moderngl takes it for rgba
VISIBLE_PX = 0.25
"""A displacement that is nowhere longer than this on screen is left out."""


def likely_m(waves: WaveSet) -> float:
    """All crests at once are far out of reach of many waves: seven standard deviations once in 1e11 places."""
    return 7.0 * waves.significant_height_m / 4.0


def highest_likely_m(waves: WaveSet) -> float:
    """No crest is higher above the calm sea."""
    return min(waves.highest_m, likely_m(waves))


class WaveMoment(NamedTuple):
    """What the phases of a view's waves were worked out for. placed: how often they had been placed."""

    placed: int
    time_s: float


class _WavesKey(NamedTuple):
    """What waves are made for. sea, wind: their revisions."""

    sea: int
    wind: int
    radius_m: float


class _ProgramKey(NamedTuple):
    file: str
    moves: bool
    swell: bool
    run: int
    every: int


class WaveView:
    """The waves around one view's anchor."""

    def __init__(self, gpu: GpuScope, block: WavePacker | None = None) -> None:
        self.buffer = gpu.buffer(reserve=WAVE_LAYOUT.size, dynamic=True)
        self.block = WavePacker() if block is None else block
        self.waves: WaveSet | None = None
        self.anchor: NDArray[np.float64] = np.array([0.0, 0.0, 1.0])
        self.placed = 0
        self.moment: WaveMoment | None = None
        self.moves = False
        self.reach_m = (0.0, 0.0)
        """How far a point may be moved: upwards, and in all."""


class SeaWaves:
    """Part of OceanSystem: keeps the wave block, and runs the pass that gives sea pixels their normals."""

    def __init__(self, name: str) -> None:
        self._name = name
        self._held: tuple[_WavesKey, WaveSet] | None = None
        self._many = self._long = False

    def setup(self, setup: Setup) -> None:
        self._gpu = setup.gpu
        # Fetching a wave costs as much as evaluating it where lanes can't share the fetch. With fewer waves long runs
        # save less than what they leave out is worth: how waves bend, and what a pixel shows of them, along a run.
        self._runs = (8, 16) if setup.gpu.caps.is_software else (2, 2)
        self._shade_every = int(setup.settings["ocean.shade_every"])
        self._programs: dict[_ProgramKey, Any] = {}
        self._warm_up: WarmUp | None = None
        self._footprint_px = float(setup.settings["ocean.footprint_px"])
        self._held = None

    def _program(self, file: str, moves: bool, swell: bool, every: int = 1) -> Any:
        """every: SHADE_EVERY."""
        run = self._runs[self._long]
        if every > 1:  # A row of a tile has 8 of them; at one of four a tile is one vector of 8 lanes.
            run = min(run, 8) if every == 2 else max(min(run, 8) // 2, 2)
        key = _ProgramKey(file, moves, swell, run, every)
        found = self._programs.get(key)
        if found is None:
            defines = {"SEA_RUN": run, "SEA_LANES": TILE_PX[0] * TILE_PX[1] // run // every, "SHADE_EVERY": every}
            if moves:
                defines["SEA_MOVES"] = 1
            if swell:
                defines["SEA_SWELL"] = 1
            found = self._programs[key] = self._gpu.compute(file, defines=defines)
        return found

    def _ahead(self, many: bool) -> Iterator[Callable[[], object]]:
        """What this number of waves needs, whether they can be seen to move or not."""
        for moves in (False, True):
            if many:
                yield partial(self._program, "ocean/swell.comp", moves, True)
            for every in {1, 2} if self._shade_every == 2 else {self._shade_every}:
                yield partial(self._program, "ocean/surface.comp", moves, many, every)

    @property
    def warm(self) -> bool:
        """Whether the shaders of a flight are there."""
        return self._warm_up is not None and self._warm_up.done

    def of(self, frame: Frame) -> WaveSet:
        """The waves of the frame's planet."""
        ocean, planet = frame.world.get(frame.planet, Ocean), frame.world.get(frame.planet, Planet)
        wind = frame.world.try_get(frame.planet, Wind)
        key = _WavesKey(revision(ocean), -1 if wind is None else revision(wind), planet.radius_m)
        if self._held is None or self._held[0] != key:
            blowing = blown(with_overrides(ocean, "ocean", frame.settings), wind)
            self._held = key, waves_of(blowing, planet.radius_m)
        return self._held[1]

    def reach(self, frame: Frame, above_sea_m: float, pixel_rad: float) -> tuple[bool, tuple[float, float]]:
        """Whether waves can be seen to move from so high, and how far they may move a point: upwards, and in all."""
        waves = self.of(frame)
        up_m = highest_likely_m(waves)
        far_m = math.hypot(up_m, min(waves.farthest_m, likely_m(waves)))
        moves = far_m > VISIBLE_PX * pixel_rad * max(above_sea_m - up_m, 0.1)
        return moves, (up_m, far_m) if moves else (0.0, 0.0)

    def place(
        self,
        view: WaveView,
        frame: Frame,
        above_sea_m: float,
        pixel_rad: float,
        eye_m: tuple[float, ...],
        angle_rad: float,
        smallest_m: float,
    ) -> bool:
        """Reduce the waves to the anchor of the view's proxy; True where waves come into sight or leave it."""
        waves = self.of(frame)
        proxy = frame.view.proxy
        radius = frame.world.get(frame.planet, Planet).radius_m
        moves, reach_m = self.reach(frame, above_sea_m, pixel_rad)
        many, long = len(waves) >= MANY, len(waves) >= _LONG_RUNS
        changed = (moves, many, long) != (view.moves, self._many, self._long)
        if self._warm_up is None or (many, long) != (self._many, self._long):
            self._warm_up = WarmUp(self._ahead(many))
        view.moves, self._many, self._long = moves, many, long
        view.reach_m = reach_m
        view.waves, view.anchor = waves, proxy.lattice.direction
        view.placed += 1
        view.block.place(waves, view.anchor, radius, SeaMesh(eye_m, angle_rad, smallest_m, self._footprint_px))
        return changed

    def update(self, frame: Frame, view: WaveView) -> None:
        """Upload the phases of the moment."""
        assert view.waves is not None
        moment = WaveMoment(view.placed, frame.time_s)
        if moment != view.moment:
            view.moment = moment
            self._gpu.upload(view.buffer, view.block.at(view.waves, frame.time_s))
        view.buffer.bind_to_uniform_block(WAVE_BLOCK)
        if self._warm_up is not None:
            self._warm_up.step(frame)

    def declare(self, builder: GraphBuilder, info: ViewInfo, view: WaveView) -> None:
        seen = info.view.seen.ground
        of_pixels = ("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface", "gbuffer.tiles_sea")
        reads = (*of_pixels, *(("ocean.moved",) if view.moves else ()))
        if self._many:
            across, down = tiles_of(info.size)
            room = (across * down + 8) * SWELL_BYTES
            builder.add_pass(
                "ocean.swell",
                kind="compute",
                system=self._name,
                bind=lambda io: self._bind_swell(io, view),
                reads=reads,
                creates=(BufferSpec("ocean.swell", room, help="long waves of each tile, at nodes"),),
                only_while=seen,
                help="slopes of the waves that are long on a tile of the picture",
            )
        builder.add_pass(
            "ocean.surface",
            kind="compute",
            system=self._name,
            bind=lambda io: self._bind_surface(io, info.view, view),
            reads=(*reads, *(("ocean.swell",) if self._many else ())),
            creates=(
                TextureSpec("ocean.rough", "rgba16f", help="slopes that pixels don't show: variances, mixed; Jacobian"),
            ),
            writes=("gbuffer.normal",),
            stage="detail",
            only_while=seen,
            help="normals of all waves that pixels can show, roughness of the rest",
        )

    def _bind_pixels(self, io: PassIO, view: WaveView) -> Callable[[], None]:
        names = ["gbuffer.depth", "gbuffer.attributes", "gbuffer.surface"]
        textures = [(GBUFFER_UNITS[name], io.texture(name)) for name in names]
        if view.moves:
            textures.append((SEA_MOVED_UNIT, io.texture("ocean.moved")))
        tiles = io.buffer("gbuffer.tiles_sea")

        def bind() -> None:
            for unit, texture in textures:
                texture.use(unit)
            tiles.bind_to_storage_buffer(TILE_BUFFER)

        return bind

    def _bind_swell(self, io: PassIO, view: WaveView) -> Callable[[], None]:
        bind, swell = self._bind_pixels(io, view), io.buffer("ocean.swell")
        program = self._program("ocean/swell.comp", view.moves, True)
        across, down = tiles_of(io.size)
        groups = -(-across * down // 8)

        def run() -> None:
            bind()
            swell.bind_to_storage_buffer(SWELL_BUFFER)
            program.run(groups, 1, 1)

        return run

    def _bind_surface(self, io: PassIO, of: View, view: WaveView) -> Callable[[], None]:
        bind, tiles = self._bind_pixels(io, view), io.buffer("gbuffer.tiles_sea")
        normal, rough = io.texture("gbuffer.normal"), io.texture("ocean.rough")
        swell = io.buffer("ocean.swell") if self._many else None
        readers = io.readers("gbuffer.normal") | io.readers("ocean.rough")
        asked = self._shade_every if readers <= _READ_WHERE_SHADED else 1
        program = self._program("ocean/surface.comp", view.moves, self._many, asked)
        # Where every second pixel is shaded, a still picture shades all.
        every = self._program("ocean/surface.comp", view.moves, self._many) if asked == 2 else program

        def run() -> None:
            bind()
            if swell is not None:
                swell.bind_to_storage_buffer(SWELL_BUFFER)
            normal.bind_to_image(COAST_NORMAL_IMAGE, read=False, write=True, format=_RG16_SNORM)
            rough.bind_to_image(1, read=False, write=True)
            (every if of.frame.checkerboard is None else program).run_indirect(tiles)

        return run
