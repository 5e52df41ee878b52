"""SeaShading: light of the sea's pixels, from the G-buffer that the mesh passes filled; water before the lens."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...components import Cover, Ocean, Planet, Wind
from ...components.wind import blown
from ...engine.blocks.bindings import (
    DEPTH_UNIT,
    FLAG_BUFFER,
    LENS_BUFFER,
    OCEAN_BLOCK,
    RADIANCE_IMAGE,
    SCENE_UNIT,
    SKY_MAP_UNIT,
    SURFACE_UNIT,
    TILE_BUFFER,
)
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.frame.contracts import bind_contracts, contract_reads
from ...engine.frame.gbuffer import GBUFFER, GBUFFER_UNITS, TILE_PX, tiles_of
from ...engine.frame.published import AIR_TOP_M, HEIGHT_FIELD, SEA_TOP_M
from ...engine.gpu import GpuScope
from ...engine.gpu.upsample_shaded import UpsampleShaded
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import revision, with_overrides
from ...engine.space.axes import direction, heading_pitch_axes
from ...engine.surface.nested import NESTED_BASE_M
from ...engine.system import Setup
from ...engine.warm_up import WarmUp
from ...engine.wavelengths import wavelengths_of
from ...engine.waves import WaveSet
from .block import OceanBlock, drifted, ocean_block, whitecap_anchor
from .labels import SeaLabels
from .lens import LENS_REACH_M, lens_plane, wet_rows
from .wave_passes import highest_likely_m

__all__ = ["SeaShading"]

_SKY_MAP = (64, 64)  # SKY_MAP_SIDE of ocean/look/sky_map.glsl
_KINDS = ("open", "mirror", "rich", "below", "limb")
_LENS = "ocean.lens_light"
_OF_CORNERS = ("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface", "gbuffer.tile_flags")
"""What ocean.light reads where rivers and lakes lie above the sea."""
_HIGH = 0.25
"""Share of the air's thickness from which on pixels may have to ask for the air before them."""
_PATTERN_M = 0.5
"""Pixels that are wider show no pattern of foam (FOAM_COARSE_M of ocean/look/foam.glsl)."""
_RIPPLE_CELLS = 0.75
"""Of a cell of noise: pixels that are wider show none of its waves (ocean/look/ripples.glsl)."""
_CONTRACTS = {"water": "ocean/water.glsl", "waterline": "ocean/waterline.glsl"}


class _MadeFor(NamedTuple):
    """What the water's block follows from. sea, wind: their revisions; proxy: its generation."""

    sea: int
    wind: int
    proxy: int


class _ShadeKey(NamedTuple):
    """Which variant of ocean/shade.comp. limb: from above the air; far: with nothing near."""

    kind: str
    limb: bool
    far: bool
    glows: bool
    cover: bool


class _SeaView(ViewParts):
    """The water as one view sees it."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.ubo = self.gpu.uniform_block(OceanBlock, OCEAN_BLOCK)
        self.block: OceanBlock
        self.wind: NDArray[np.float64]
        self.wind_m_s: float
        self.made_for: _MadeFor | None = None
        self.near_water = False
        """Whether the water may reach its lens; wet_rows: of the picture, with water before them."""
        self.wet_rows: tuple[int, int] = (0, 0)
        self.high = self.far = False
        """Whether it is above most of the air, and whether its pixels are too wide for any pattern."""


class SeaShading:
    """Part of OceanSystem: the water's uniform block, the shader contracts ``water`` and ``waterline``, and the passes
    that turn the G-buffer's sea into radiance."""

    def __init__(self, name: str) -> None:
        self._name = name

    def setup(self, setup: Setup) -> None:
        self._world = setup.world
        self._gpu = setup.gpu
        self._shaders = setup.gpu.shaders
        for contract, file in _CONTRACTS.items():
            self._shaders.provide(contract, file, owner=self._name)
        self._views = setup.views
        setup.gpu.uniform_block(OceanBlock, OCEAN_BLOCK, "ocean")  # its text, for shaders; each view has its own
        self._top: tuple[WaveSet, float] | None = None
        self._classify = setup.gpu.compute("ocean/classify.comp")
        self._light = setup.gpu.compute("ocean/light.comp")
        self._sky = setup.gpu.compute("ocean/sky.comp")
        self._list = setup.gpu.compute("ocean/list_tiles.comp")
        self._shade: dict[_ShadeKey, Any] = {}
        self._turns, self._ripples = int(setup.settings["ocean.reflections"]), bool(setup.settings["ocean.ripples"])
        self._shade_every = int(setup.settings["ocean.shade_every"])
        self._between: UpsampleShaded | None = None
        if self._shade_every > 1:
            self._between = UpsampleShaded(setup.gpu, "SURFACE_SEA", self._shade_every, setup.settings)
        self._labels = SeaLabels(setup.gpu, setup.world)
        self._glows = False
        self._warm_up = WarmUp(self._ahead())
        stored = str(setup.settings.get("sky.radiance_format", "rgba32f"))
        self._under = setup.gpu.compute("ocean/under.comp", defines={"SCENE_FORMAT": stored})
        self._under_light = setup.gpu.compute("ocean/under_light.comp")

    def _shader(self, kind: str, high: bool, far: bool) -> Any:
        """The shader of a kind of tiles, from above all air, with nothing near; made when it is first needed."""
        wanted = {
            "OCEAN_LIMB": kind == "limb" or (high and kind in ("mirror", "rich")),
            "OCEAN_RIPPLES": (self._ripples and not far) or kind == "below",
            "OCEAN_FAR": far,
            "OCEAN_GLOW": self._glows,
            "OCEAN_RICH": kind == "rich",
            "OCEAN_BELOW": kind == "below",
            "OCEAN_COVER": not far and kind != "below" and bool(self._world.query(Cover)),
        }
        key = _ShadeKey(kind, wanted["OCEAN_LIMB"], far, self._glows, wanted["OCEAN_COVER"])
        if key not in self._shade:
            defines: dict[str, Any] = {
                "SHADE_EVERY": self._shade_every,
                **{name: 1 for name, on in wanted.items() if on},
            }
            if self._turns and kind in ("mirror", "rich"):
                defines["OCEAN_REFLECTIONS"] = self._turns
            self._shade[key] = self._gpu.compute("ocean/shade.comp", defines=defines)
        return self._shade[key]

    @staticmethod
    def _needed(kind: str, sea: _SeaView) -> bool:
        return sea.near_water if kind == "below" else sea.high or kind != "limb"

    def _of(self, view: View) -> _SeaView:
        return view.state(self, lambda: _SeaView(self._gpu))

    def _ahead(self) -> Iterator[Callable[[], object]]:
        """What a flight between space and the water needs, from the highest down; diving alone asks for more."""
        for high, far in ((True, True), (False, True), (False, False)):
            for kind in _KINDS:
                if kind != "below" and (high or kind != "limb"):
                    yield partial(self._shader, kind, high, far)
        yield partial(self._shader, "below", False, False)
        if self._between is not None:
            yield partial(self._between.program, True)

    @property
    def warm(self) -> bool:
        """Whether the shaders of a flight are there."""
        return self._warm_up.done

    def release(self) -> None:
        self._shaders.withdraw(self._name)
        self._views.forget(self)
        self._world.remove_resource(SEA_TOP_M)

    def begin(self, frame: Frame, waves: WaveSet) -> None:
        """Tell the others how high the water reaches."""
        level_m = frame.world.get(frame.planet, Ocean).sea_level_m
        if self._top is None or self._top[0] is not waves:
            self._top = (waves, highest_likely_m(waves) + LENS_REACH_M)
        frame.world.set_resource(SEA_TOP_M, level_m + self._top[1])

    def update(self, frame: Frame, waves: WaveSet) -> None:
        """Write and bind the water's block."""
        if frame.checkerboard is not None and self._shade_every == 2:
            frame.checkered.add("ocean")
        ocean = frame.world.get(frame.planet, Ocean)
        proxy = frame.view.proxy
        radius = frame.world.get(frame.planet, Planet).radius_m
        wind = frame.world.try_get(frame.planet, Wind)
        of_wind = -1 if wind is None else revision(wind)
        own, made_for = self._of(frame.view), _MadeFor(revision(ocean), of_wind, proxy.generation)
        if made_for != own.made_for:
            own.made_for = made_for
            ocean = blown(with_overrides(ocean, "ocean", frame.settings), wind)
            own.block = ocean_block(ocean, waves, proxy.lattice.direction, radius, wavelengths_of(frame.settings))
            own.wind = heading_pitch_axes(direction(*ocean.wind_at), ocean.wind_direction_deg, 0.0)[0]
            own.wind_m_s = ocean.wind_speed_m_s
            own.block.whitecaps.heading = tuple(own.wind)
        held = own.block
        held.whitecaps.anchor = whitecap_anchor(proxy.lattice.direction, radius, own.wind, own.wind_m_s, frame.time_s)
        held.drifting = drifted(proxy.lattice.direction, radius, own.wind, frame.time_s)
        held.lens = lens_plane(
            waves,
            highest_likely_m(waves),
            frame.camera.position_m,
            frame.time_s,
            frame.world.try_resource(HEIGHT_FIELD),
            ocean.sea_level_m,
        )
        own.near_water = held.lens.height_m < LENS_REACH_M
        if own.near_water:
            own.wet_rows = wet_rows(held.lens, frame.camera, frame.size[1])
        altitude_m = frame.camera.distance_m - radius
        own.high = altitude_m > _HIGH * float(frame.world.try_resource(AIR_TOP_M) or 0.0)
        # No sea is nearer than this, so no pixel of it narrower.
        nearest_m = altitude_m - float(frame.world.resource(SEA_TOP_M))
        widest_m = max(_PATTERN_M, _RIPPLE_CELLS * NESTED_BASE_M * 2.0**held.ripple_octave)
        pixel = frame.pixel_rad
        own.far = nearest_m * pixel > widest_m
        self._glows = any(value > 0.0 for value in (*held.glow_radiance, held.crust_share))
        self._warm_up.step(frame)
        own.ubo.write(held)
        own.ubo.bind()

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        across, down = tiles_of(view.size)
        count = across * down
        corners = (across + 1, 5 * (down + 1))
        groups = (-(-corners[0] // 8), -(-corners[1] // 40))
        seen, own = view.view.seen.ground, self._of(view.view)
        builder.add_pass(
            "ocean.classify",
            system=self._name,
            bind=lambda io: self._bind_classify(io, own, across, down, groups),
            kind="compute",
            reads=("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface", "gbuffer.tile_flags"),
            creates=(
                BufferSpec("ocean.tile_flags", 4 * count, help="what each tile's sea needs"),
                BufferSpec("ocean.tiles_open", 16 + 4 * count, help="dispatch and tiles of deep open water"),
                BufferSpec("ocean.tiles_mirror", 16 + 4 * count, help="the same with ground that it may mirror"),
                BufferSpec("ocean.tiles_rich", 16 + 4 * count, help="dispatch and tiles with shallows, foam or ice"),
                BufferSpec("ocean.tiles_below", 16 + 4 * count, help="dispatch and tiles of the surface from below"),
                BufferSpec("ocean.tiles_limb", 16 + 4 * count, help="open water with air that changes within a tile"),
                BufferSpec("ocean.light_groups", 24, help="dispatches of ocean.light: none where no sea is seen"),
            ),
            only_while=seen,
            help="tiles of the sea by what they need",
        )
        builder.add_pass(
            "ocean.light",
            system=self._name,
            bind=self._bind_light,
            kind="compute",
            reads=("ocean.light_groups", *_OF_CORNERS, *contract_reads(self._world)),
            creates=(
                TextureSpec("ocean.light", "rgba32f", corners, filter="linear", help="sun, sky, air above, by tile"),
                TextureSpec("ocean.sky", "rgba32f", _SKY_MAP, filter="linear", help="the sky that the sea mirrors"),
            ),
            only_while=seen,
            help="light on the sea at the corners of tiles, and a map of the sky",
        )
        builder.add_pass(
            "ocean.shade",
            system=self._name,
            bind=lambda io: self._bind_shade(io, view.view, own),
            kind="compute",
            reads=(
                "gbuffer.depth",
                *GBUFFER,
                "ocean.rough",
                "ocean.light",
                "ocean.sky",
                *(f"ocean.tiles_{k}" for k in _KINDS),
                *contract_reads(self._world),
            ),
            writes=("scene.radiance",),
            stage="water",
            only_while=seen,
            help="light of sea pixels",
        )
        self._labels.declare(builder, self._name, seen)
        builder.add_pass(
            "ocean.under",
            system=self._name,
            bind=lambda io: self._bind_under(io, own, across),
            kind="compute",
            reads=("gbuffer.depth", "gbuffer.surface", *contract_reads(self._world)),
            writes=("scene.radiance",),
            stage="underwater",
            creates=(BufferSpec(_LENS, 48, "persistent", help="light in the water around the lens"),),
            when=lambda: own.near_water,
            only_while=seen,
            help="water between the lens and what a pixel shows",
        )

    def _bind_classify(
        self, io: PassIO, own: _SeaView, across: int, down: int, light_groups: tuple[int, int]
    ) -> Callable[[], None]:
        textures = [io.texture(n) for n in ("gbuffer.depth", "gbuffer.attributes", "gbuffer.surface")]
        buffers = [io.buffer(f"ocean.{n}") for n in ("tile_flags", *(f"tiles_{k}" for k in _KINDS), "light_groups")]
        shown = io.buffer("gbuffer.tile_flags")

        def run() -> None:
            for unit, texture in enumerate(textures):
                texture.use(unit)
            for unit, buffer in zip((0, 1, 2, 3, 5, 6, 7), buffers, strict=True):
                buffer.bind_to_storage_buffer(unit)
            shown.bind_to_storage_buffer(4)
            self._classify.set("u_tiles", (across, down))
            self._classify.set("u_high", int(own.high))
            self._classify.run(-(-across * down // 64), 1, 1)
            self._gpu.barrier()
            self._list.set("u_tiles", (across, down))
            self._list.set("u_light_groups", light_groups)
            self._list.set("u_sky_groups", (_SKY_MAP[0] // 8, _SKY_MAP[1] // 8))
            self._list.run(1, 1, 1)

        return run

    def _bind_light(self, io: PassIO) -> Callable[[], None]:
        light, sky, groups = io.texture("ocean.light"), io.texture("ocean.sky"), io.buffer("ocean.light_groups")
        textures = [(GBUFFER_UNITS[name], io.texture(name)) for name in _OF_CORNERS[:3]]
        flags = io.buffer(_OF_CORNERS[3])
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            for unit, texture in textures:
                texture.use(unit)
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            light.bind_to_image(0, read=False, write=True)
            self._light.run_indirect(groups)
            sky.bind_to_image(0, read=False, write=True)
            self._sky.run_indirect(groups, 12)

        return run

    def _bind_shade(self, io: PassIO, view: View, own: _SeaView) -> Callable[[], None]:
        radiance = io.texture("scene.radiance")
        units = GBUFFER_UNITS | {
            "ocean.rough": 4,
            "scene.radiance": SCENE_UNIT,
            "ocean.sky": SKY_MAP_UNIT,
            "ocean.light": 7,
        }
        textures = [(unit, io.texture(name)) for name, unit in units.items()]
        parts = [(k, io.buffer(f"ocean.tiles_{k}")) for k in _KINDS]
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            radiance.bind_to_image(RADIANCE_IMAGE, read=False, write=True)
            for unit, texture in textures:
                texture.use(unit)
            with self._gpu.apart():  # each pixel reads and stores its own
                needed = [(kind, tiles) for kind, tiles in parts if self._needed(kind, own)]
                for kind, tiles in needed:
                    tiles.bind_to_storage_buffer(TILE_BUFFER)
                    self._shader(kind, own.high, own.far).run_indirect(tiles)
            if self._between is not None and self._between.leaves_out(view.frame.checkerboard):
                self._between.run(radiance, [tiles for _, tiles in needed], by_lens=own.near_water)

        return run

    def _bind_under(self, io: PassIO, own: _SeaView, across: int) -> Callable[[], None]:
        radiance, depth, surface = (io.texture(n) for n in ("scene.radiance", "gbuffer.depth", "gbuffer.surface"))
        light, bind_air = io.buffer(_LENS), bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            depth.use(DEPTH_UNIT)
            surface.use(SURFACE_UNIT)
            radiance.bind_to_image(RADIANCE_IMAGE, read=True, write=True)
            light.bind_to_storage_buffer(LENS_BUFFER)
            self._under_light.run()
            self._gpu.barrier()
            first, end = own.wet_rows[0] // TILE_PX[1], -(-own.wet_rows[1] // TILE_PX[1])
            if first < end:
                self._under.set("u_first_row", first * TILE_PX[1])
                self._under.run(across, end - first, 1)

        return run
