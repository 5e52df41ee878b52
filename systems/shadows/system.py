"""ShadowSystem: keeps a clipmap of the ground around each camera and provides the contract sun_visibility from it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...components import Ocean, Planet, Terrain
from ...engine.blocks.bindings import SHADOW_MAP_BLOCK, SHADOW_MAP_UNIT
from ...engine.blocks.layout import zeros
from ...engine.frame import Frame, Proxy, View, ViewInfo, ViewParts
from ...engine.frame.contracts import provide_contracts, withdraw_contracts
from ...engine.frame.published import HEIGHT_FIELD, SURFACE_HEIGHT
from ...engine.frame.unseen import Unseen
from ...engine.gpu import Compute, GpuScope
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from ...engine.settings import PartRevision, Settings, revision, with_overrides
from ...engine.system import Setup, System
from ...engine.world import World
from .block import MOST_LEVELS, ShadowBlock, ShadowWindow
from .windows import BLOCK, Level, Part, Reach, Windows, reach_of

__all__ = ["ShadowSystem"]

_NO_SEA_M = -1.0e9
_NO_WINDOW = zeros(ShadowWindow)
_LAYERS = 16
_SUN_STEP_RAD = 1.0e-4
"""A sun that has moved less casts the same shadows: a hundredth of its disc."""
_STEPS = 32
"""Of a sweep within one level, as in finish.comp."""
_TEXELS_PER_ROW = 0.71
"""Texels a side per row of the picture: more could not be seen."""
_LEAST = 64
_AT_ONCE = 6
"""Levels of the first picture after a cut, the coarsest: ridges that throw their shadows over kilometres."""
_FADE_S = 0.25
"""New fine levels come in over this time."""
_HEIGHTS, _LIMBS, _HORIZONS, _SKY, _MAP = (f"shadows.{name}" for name in ("heights", "limbs", "horizons", "sky", "map"))
_WINDOWS = "shadows.windows"
"""A view's uniform block, lent to the graph."""
_FORMATS = {_HEIGHTS: "r32f", _LIMBS: "rg32f", _HORIZONS: "rgba32ui", _SKY: "r8", _MAP: "rgba32f"}


class _GroundKey(NamedTuple):
    """What casts shadows. field: id of the ground's heights; shown: shadows, shelter; radius: revision of the
    planet's."""

    field: int
    sea_m: float
    shown: tuple[bool, bool]
    radius: int


class _PlaceKey(NamedTuple):
    """What the windows are placed for. camera, sun: as bytes; proxy: its generation."""

    camera: bytes
    pixel_rad: float
    proxy: int
    sun: bytes


class _View(ViewParts):
    """One view's windows, and what is left to do for them."""

    def __init__(self, of: GpuScope, size: int) -> None:
        super().__init__(of)
        self.windows = Windows(size, _LAYERS)
        self.ubo = self.gpu.uniform_block(ShadowBlock, SHADOW_MAP_BLOCK)
        self.scratch = [self.gpu.texture((size, size), "rg32f") for _ in range(2)]
        self.block: ShadowBlock
        self.sun: Any = None
        self.sun_number = 0
        self.finest = 0.0  # level that may be shown, counted from the finest wanted; eased
        self.ground: _GroundKey | None = None
        self.place: _PlaceKey | None = None  # what the windows were placed for
        self.at_once = True
        self.textures: tuple[Any, ...] = ()
        self.complete = False
        self.asked = False  # whether anybody reads the map in this frame

    def forget(self) -> None:
        """Nothing that comes depends on what was: neither projection nor sun are held either."""
        self.windows.forget()
        self.complete = False
        self.sun = None


class ShadowSystem(System):
    """Shadows that the ground casts, and its shelter from the sky. Needs Planet and Terrain, and Terrain.shadows or
    Terrain.occlusion.

    Pass ``shadows.clipmap``: heights of new texels, and shadows of levels that moved or whose sun did.
    """

    name: ClassVar[str] = "shadows"
    needs: ClassVar[tuple[type, ...]] = (Planet, Terrain)

    def __init__(self) -> None:
        self._world: World | None = None

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world = setup.gpu, setup.world
        gpu = setup.gpu
        self._most = int(setup.settings["shadows.size"])
        self._finest_m = float(setup.settings["shadows.finest_m"])
        self._per_pixel = float(setup.settings["shadows.texels_per_pixel"])
        self._new_levels = int(setup.settings["shadows.levels_per_frame"])
        # Its text, for shaders; each view has a block of its own.
        gpu.uniform_block(ShadowBlock, SHADOW_MAP_BLOCK, "shadow_map")
        self._heights = gpu.compute("shadows/heights.comp")
        self._first = gpu.compute("shadows/sweep.comp", defines={"FIRST": 1})
        self._sweep = gpu.compute("shadows/sweep.comp")
        self._finish = gpu.compute("shadows/finish.comp")
        self._occlusion = gpu.compute("shadows/occlusion.comp")
        self.on = False
        """Whether anything casts shadows in this scene at this quality."""
        self._terrain: PartRevision | None = None
        self._unseen = Unseen(Planet, Terrain, Ocean)
        self._switch(self._wanted(setup.world, setup.planet, setup.settings))

    def release(self) -> None:
        self._switch((False, False))

    def _wanted(self, world: World, planet: int, settings: Settings) -> tuple[bool, bool]:
        terrain = world.get(planet, Terrain)
        stamp = PartRevision.of(terrain)
        if stamp != self._terrain:
            self._terrain = stamp
            chosen = with_overrides(terrain, "terrain", settings)
            self._chosen = (bool(chosen.shadows), bool(chosen.occlusion))
        return self._chosen

    def _switch(self, wanted: tuple[bool, bool]) -> None:
        """Provide the contract, or leave it to its default."""
        on = any(wanted)
        if on == self.on:
            return
        self.on = on
        self.structure += 1
        assert self._world is not None
        if on:
            self._gpu.shaders.provide("sun_visibility", "shadows/sun_visibility.glsl", owner=self.name)
            provide_contracts(self._world, self.name, self)
        else:
            self._gpu.shaders.withdraw(self.name)
            withdraw_contracts(self._world, self.name)

    # -- contracts ---------------------------------------------------------------------------------------------------

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.contracts.ContractSource."""
        return (_WINDOWS, _MAP)

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.contracts.ContractSource."""
        texture, windows = io.texture(_MAP), io.imported(_WINDOWS)

        def run() -> None:
            texture.use(SHADOW_MAP_UNIT)
            windows.value.bind_to_uniform_block(SHADOW_MAP_BLOCK)

        return run

    # -- frame -------------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        # Things in space are lit through the map, whose place is the proxy's.
        known: _View | None = frame.view.found(self)
        if self._unseen.rests(frame) and (known is None or known.place == self._place_of(frame)):
            if known is not None:
                known.asked = False
            return
        shown = self._wanted(frame.world, frame.planet, frame.settings)
        self._switch(shown)
        if not self.on:
            return
        view = self._of(frame.view, frame.size[1])
        view.asked = False
        sea = frame.world.try_get(frame.planet, Ocean)
        body = frame.world.get(frame.planet, Planet)
        sea_m = _NO_SEA_M if sea is None else float(sea.sea_level_m)
        field = frame.world.try_resource(HEIGHT_FIELD)
        ground = _GroundKey(id(field), sea_m, shown, revision(body, "radius_m"))
        if ground != view.ground or frame.cut:
            view.ground = ground
            view.forget()
        view.at_once = frame.settling or frame.cut or frame.one_shot or view.sun is None
        place = self._place_of(frame)
        if place == view.place and view.complete and view.finest == 0.0 and self._done(view):
            return  # turning the camera changes nothing
        view.place = place
        self._place(view, frame, frame.view.proxy, place.pixel_rad, sea_m, shown)

    @staticmethod
    def _place_of(frame: Frame) -> _PlaceKey:
        camera, proxy = frame.camera, frame.view.proxy
        pixel_rad = frame.pixel_rad
        return _PlaceKey(camera.position_m.tobytes(), pixel_rad, proxy.generation, frame.sun.direction.tobytes())

    def _of(self, view: View, rows: int) -> _View:
        """The windows of a view, as large as its picture can show."""
        size = BLOCK * max(min(round(_TEXELS_PER_ROW * rows / BLOCK), self._most // BLOCK), _LEAST // BLOCK)
        found: _View | None = view.found(self)
        if found is not None and found.windows.size == size:
            return found
        view.forget(self)
        view.structure += 1
        return view.state(self, lambda: _View(self._gpu, size))

    def _place(
        self, view: _View, frame: Frame, proxy: Proxy, pixel_rad: float, sea_m: float, shown: tuple[bool, bool]
    ) -> None:
        """Where the windows are to be, and what that leaves to do."""
        field, sun, at_once = frame.world.resource(HEIGHT_FIELD), frame.sun, view.at_once
        radius = frame.world.get(frame.planet, Planet).radius_m
        direction, altitude = frame.camera.direction, frame.camera.distance_m - radius
        windows = view.windows
        reach = reach_of(
            direction,
            altitude,
            # Half: mountains beside the camera may be nearer than the ground below.
            0.5 * (altitude - max(proxy.ground_m, sea_m)),
            pixel_rad,
            radius,
            (max(field.lowest_m, sea_m), field.highest_m),
            windows.size,
            self._finest_m,
            self._per_pixel,
            windows.projection,
        )
        if view.sun is None or (
            view.sun is not sun and float(np.abs(sun.direction - view.sun.direction).max()) > _SUN_STEP_RAD
        ):
            # One sun at a time: the sweep under way ends first.
            if at_once or all(level.swept == view.sun_number for level in windows.levels):
                view.sun = sun
                view.sun_number += 1
        elif sun.angular_radius_rad != view.sun.angular_radius_rad:
            view.sun, view.sun_number = sun, view.sun_number + 1
        # A single picture wants all of them; a window's first one the coarse ones, and more of them frame by frame.
        whole = frame.settling or frame.one_shot
        complete = windows.follow(reach, MOST_LEVELS if whole else _AT_ONCE if at_once else self._new_levels)
        view.complete = complete
        self._write(view, reach, proxy, radius, sea_m, shown, frame.dt_s)

    def _write(
        self, view: _View, reach: Reach, proxy: Proxy, radius: float, sea_m: float, shown: tuple[bool, bool],
        dt_s: float,
    ) -> None:  # fmt: skip
        windows, sun = view.windows, view.sun
        assert sun is not None
        levels = windows.levels[::-1]  # finest first
        axes, anchor = reach.projection.axes, proxy.lattice.direction
        p0 = reach.projection.place(anchor)
        finest = levels[0].power
        frequency = math.ldexp(1.0, finest)
        missing = float(reach.finest - finest)
        # Counted from the finest wanted level: what is there now comes in slowly, what is not can't be shown.
        step = 32.0 if view.at_once else dt_s / _FADE_S
        view.finest = max(missing, view.finest - step)
        x0, y0 = p0.tolist()
        texel_m = radius * reach.projection.scale(p0) / frequency
        place = [math.ldexp(x0, finest), math.ldexp(y0, finest)]
        whole = [math.floor(v) for v in place]
        side = windows.side
        rows = [_NO_WINDOW] * MOST_LEVELS
        for k, level in enumerate(levels):
            power, (x, y) = level.power, level.corner
            rows[k] = ShadowWindow((math.ldexp(x0, power) - x, math.ldexp(y0, power) - y), (x % side, y % side))
        view.block = ShadowBlock(
            axis_x=axes[0],
            radius_m=radius,
            axis_y=axes[1],
            sea_level_m=sea_m,
            axis_z=axes[2],
            anchor_divisor=1.0 + float(axes[2] @ anchor),
            sun_direction=axes @ sun.direction,
            sun_radius_rad=sun.angular_radius_rad,
            anchor_place=p0,
            foot=reach.foot - p0,
            anchor_texel=whole,
            anchor_rest=(place[0] - whole[0], place[1] - whole[1]),
            frequency=frequency,
            texel_m=texel_m,
            texels_per_footprint_m=1.0 / (self._per_pixel * texel_m),
            finest_shown=view.finest - missing,
            half_texels=windows.half,
            levels=len(levels),
            window_texels=windows.size,
            power=finest,
            side=side,
            shadows=shown[0],
            shelter=shown[1],
            windows=rows,
        )
        view.ubo.write(view.block)

    def settled(self, view: View) -> bool:
        own = self._read(view)
        return own is None or (own.complete and self._done(own))

    def progress(self, view: View) -> float:
        """Share of the levels that are there, 0..1."""
        own = self._read(view)
        return 1.0 if own is None else sum(not level.fresh for level in own.windows.levels) / MOST_LEVELS

    def refining(self, view: View) -> str:
        return "" if self.settled(view) else f"shadows {100.0 * self.progress(view):.0f} %"

    def _read(self, view: View) -> _View | None:
        """That view's map, if somebody reads it: else the pass is not in the graph."""
        found: _View | None = view.found(self)
        return found if self.on and found is not None and found.asked else None

    @staticmethod
    def _done(view: _View) -> bool:
        return not any(
            level.fresh or level.shift != (0, 0) or level.swept != view.sun_number for level in view.windows.levels
        )

    # -- passes ------------------------------------------------------------------------------------------------------

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        if not self.on:
            return
        own = self._of(view.view, view.size[1])
        side = (own.windows.side, own.windows.side)
        assert self._world is not None
        builder.import_(_WINDOWS, "buffer", help="where the levels of the map are", lent=own.ubo.buffer)
        builder.add_pass(
            "shadows.clipmap",
            kind="compute",
            system=self.name,
            reads=(_WINDOWS,),
            bind=lambda io: self._bind(io, view.view, own),
            creates=tuple(
                TextureSpec(
                    name,
                    kind,
                    side,
                    "persistent",
                    layers=_LAYERS,
                    filter="linear" if name == _MAP else "nearest",
                    wrap="repeat",
                )
                for name, kind in _FORMATS.items()
            ),
            when=lambda: self._needed(own),
            only_while=view.view.seen.planet,
            help="heights around the camera, and from where the sun is seen",
        )

    def _needed(self, view: _View) -> bool:
        view.asked = True
        return not self._done(view)

    def _bind(self, io: PassIO, of: View, view: _View) -> Callable[[], None]:
        textures = tuple(io.texture(name) for name in _FORMATS)
        if any(a is not b for a, b in zip(textures, view.textures, strict=False)) or not view.textures:
            view.textures = textures
            for level in view.windows.levels:
                level.fresh, level.swept = [view.windows.whole], -1

        def run() -> None:
            self._work(of, view)

        return run

    def _work(self, of: View, view: _View) -> None:
        assert self._world is not None
        self._world.resource(SURFACE_HEIGHT)(of)
        view.ubo.bind()
        levels = view.windows.levels
        count = len(levels)
        sweeps = count if view.at_once else self._new_levels
        for place, level in enumerate(levels):
            number = count - 1 - place
            fresh = level.fresh
            if fresh:
                self._fill(view, level, number)
            if level.swept == view.sun_number:
                parts = view.windows.unlit(
                    level, view.sun_number, view.windows.way_of(level, view.sun.direction), _STEPS
                )
                for part in parts:
                    self._cast(view, number, part, view.windows.way_of(level, view.sun.direction))
            elif fresh or sweeps > 0:
                sweeps -= 0 if fresh else 1
                self._cast(view, number, view.windows.whole, None)
            else:
                break  # finer levels look into this one
            level.shift, level.swept = (0, 0), view.sun_number

    def _fill(self, view: _View, level: Level, number: int) -> None:
        heights, _, horizons, sky, _ = view.textures
        heights.bind_to_image(0, read=False, write=True)
        self._heights.set("u_level", number)
        for part in level.fresh:
            self._run_over(self._heights, part)
        self._gpu.barrier()
        parts, level.fresh = level.fresh, []
        if not view.block.shelter:
            return
        heights.use(0)
        horizons.use(1)
        horizons.bind_to_image(0, read=False, write=True)
        sky.bind_to_image(1, read=False, write=True)
        self._occlusion.set("u_level", number)
        with self._gpu.apart():  # what is read is the coarser level's
            for part in parts:
                self._run_over(self._occlusion, view.windows.spread(part))
        self._gpu.barrier()

    def _cast(self, view: _View, number: int, part: Part, way: Any) -> None:
        """Shadows of a part of a level. way: as of Windows.way_of; None: make everything that may be needed."""
        heights, limbs, _, sky, packed = view.textures
        windows = view.windows
        parts = [part] * 3 if way is None else [windows.ahead(part, steps, way) for steps in (32, 20, 2)]
        one, other = view.scratch
        turns = ((heights, one), (one, other), (other, one)) if view.block.shadows else ()
        for k, (source, result) in enumerate(turns):
            program = self._sweep if k else self._first
            source.use(0)
            result.bind_to_image(0, read=False, write=True)
            self._run(program, number, parts[k], 4**k)
        one.use(0)
        limbs.use(1)
        heights.use(2)
        sky.use(3)
        limbs.bind_to_image(0, read=False, write=True)
        packed.bind_to_image(1, read=False, write=True)
        self._run(self._finish, number, part, 1)

    def _run(self, program: Compute, number: int, part: Part, step: int) -> None:
        program.set("u_level", number)
        program.set("u_step", step)
        self._run_over(program, part)
        self._gpu.barrier()

    @staticmethod
    def _run_over(program: Compute, part: Part) -> None:
        program.set("u_corner", part[:2])
        program.set("u_size", part[2:])
        program.run_over(*part[2:])
