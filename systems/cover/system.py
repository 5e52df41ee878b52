"""CoverSystem: trees and shrubs on the ground near the camera, their light and their shadows.

Each tree is two quads in which a fragment shader follows the pixel's ray to the tree's lobes: four triangles a tree,
whatever it looks like. What stands where is made on the CPU (stand.py), a few plots a frame.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...components import Cover, Ocean, Planet, Terrain, Wind
from ...components.season import in_season
from ...engine.blocks.bindings import COVER_BLOCK, COVER_UNIT, FLAG_BUFFER, RADIANCE_IMAGE, TILE_BUFFER, TREE_BUFFER
from ...engine.display import reflectance
from ...engine.frame import Frame, View, ViewInfo, ViewParts
from ...engine.frame.contracts import bind_contracts, contract_reads, provide_contracts, withdraw_contracts
from ...engine.frame.gbuffer import GBUFFER, GBUFFER_UNITS, Surface, tiles_of
from ...engine.frame.instances import InstancePass
from ...engine.frame.published import HEIGHT_FIELD
from ...engine.gpu import GpuScope, Program
from ...engine.gpu.growing import GrowingBuffer
from ...engine.graph import BufferSpec, GraphBuilder, PassIO
from ...engine.settings import revision, with_overrides
from ...engine.space.camera import CameraStamp
from ...engine.surface.crowns import crown_share
from ...engine.system import Setup, System
from ...engine.wavelengths import wavelengths_of
from .felling import grows
from .growth import Growing
from .near import Near
from .programs import PlantPrograms
from .records import TREE_DTYPE, Close, in_detail, seen, within
from .season import LIKE_BARK, SUMMER, TWIGS_OPEN, Leaves, leaves_at
from .shadow_map import CoverMapBlock, Forest, ShadowMap
from .snow import SnowFall
from .species import tallest_m
from .stand import LAYERS, NOTHING, SHRUBS, Plants
from .sway import STILL, sway_at

__all__ = ["CoverSystem"]

_PLACE, _MAP = "cover.place", "cover.map"
_COLOURS = ("broadleaf_albedo", "conifer_albedo", "bark_albedo", "species")
_SHRUBS_M = 200.0
"""How far shrubs are drawn."""
GRASS_GIVEN_M = 0.3
"""Height of grass for which assets/shaders/terrain/grass.glsl has its sizes."""
_BREEZE = Wind()
_BUDGET_MS = 4.0
"""A frame's time for making plots, while somebody looks."""
_CLOSE_M = 30.0
"""How far a camera goes before it is asked again which plants are near enough to be drawn."""


class _CloseKey(NamedTuple):
    """What the plants around a place follow from."""

    revision: tuple[int, ...]
    reach_m: float
    snow: SnowFall


class _CoverView(ViewParts):
    """What one view has of it."""

    def __init__(self, of: GpuScope, shadow_texels: int) -> None:
        super().__init__(of)
        self.nears = tuple(Near(layer) for layer in LAYERS)
        self.plants, self.revision = NOTHING, ()
        self._close: tuple[_CloseKey, NDArray[np.float64], Close] | None = None
        self.sway, self.leaves = STILL, SUMMER
        self.forest = Forest(np.zeros(3), np.zeros(3), np.zeros(4), np.zeros(4), 0.0)
        self.forest_key: tuple[int, int, Leaves] | None = None
        self.key: tuple[_CloseKey, CameraStamp] | None = None
        self.count, self.detailed, self.shown = 0, (0, 0, 0), NOTHING
        self.trees = GrowingBuffer(self.gpu, TREE_DTYPE.itemsize)
        self.shadows = ShadowMap(self.gpu, shadow_texels)
        self.frame: Frame | None = None

    def gather(self) -> None:
        """All layers in one, when one has changed."""
        revision = tuple(near.revision for near in self.nears)
        if revision != self.revision:
            self.plants, self.revision = Plants.of([near.plants for near in self.nears]), revision

    def look(self, frame: Frame, reach_m: float, snow: SnowFall) -> None:
        """Find the plants in the picture, when they, the camera or the snow have changed."""
        near = _CloseKey(self.revision, reach_m, snow)
        if self.key == (near, frame.camera.stamp):
            return
        self.key = near, frame.camera.stamp
        close = self._within(frame.camera.position_m, near)
        rows, crown_m, self.shown = seen(close, frame.camera)
        self.trees.write(rows)
        self.count, trees = len(rows), len(rows) - int(np.count_nonzero(self.shown.drawn_apart))
        self.detailed = (*in_detail(rows[:trees], crown_m[:trees], frame.pixel_rad), trees)

    def _within(self, place_m: NDArray[np.float64], key: _CloseKey) -> Close:
        """What may be in a picture from there: a third of all."""
        if self._close is None or key != self._close[0] or np.linalg.norm(place_m - self._close[1]) > _CLOSE_M:
            close = within(self.plants, place_m, key.reach_m, _CLOSE_M, key.snow)
            self._close = key, place_m, close
        return self._close[2]

    def other_since(self, revision: tuple[int, ...]) -> Plants | None:
        """As Near has it, of all layers."""
        if len(revision) != len(self.nears):
            return None
        parts = [near.other_since(of) for near, of in zip(self.nears, revision, strict=True)]
        known = [part for part in parts if part is not None]
        return Plants.of(known) if len(known) == len(parts) else None


class CoverSystem(System):
    """Needs a planet with Terrain and Cover."""

    name: ClassVar[str] = "cover"
    needs: ClassVar[tuple[type, ...]] = (Planet, Terrain, Cover)

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world, self._planet = setup.gpu, setup.world, setup.planet
        self._settings, self._nm, self._views = setup.settings, wavelengths_of(setup.settings), setup.views
        format = str(setup.settings.get("sky.radiance_format", "rgba32f"))
        # Its text, for shaders; each view has a block of its own.
        self._gpu.uniform_block(CoverMapBlock, COVER_BLOCK, "cover_map")
        self._numbers = InstancePass(self._gpu, "cover/instance.vert", Surface.COVER)
        self._numbered: Any = None
        self._list = self._gpu.compute("cover/list_tiles.comp")
        self._gpu.shaders.provide("cover_light", "cover/light.glsl", owner=self.name)
        provide_contracts(self._world, self.name, self)
        self._shade_defines = {"RADIANCE_FORMAT": format, "LIGHT_EVERY": int(setup.settings["cover.light_every"])}
        self._programs: dict[bool, PlantPrograms] = {}
        self._draw_state = self._gpu.state(depth_test=True, depth_func=">", cull=None)
        self._colours: tuple[bool, int] | None = None
        self._snow: tuple[tuple[float, ...], NDArray[np.float64]] = (), np.zeros(3)

    def release(self) -> None:
        self._gpu.shaders.withdraw(self.name)
        withdraw_contracts(self._world, self.name)

    # -- contracts ---------------------------------------------------------------------------------------------------

    def contract_reads(self) -> tuple[str, ...]:
        """See engine.contracts.ContractSource."""
        return (_PLACE, _MAP)

    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.contracts.ContractSource."""
        heights, place = io.imported(_MAP), io.imported(_PLACE)

        def run() -> None:
            heights.value.use(COVER_UNIT)
            place.value.bind_to_uniform_block(COVER_BLOCK)

        return run

    def _view(self, view: View) -> _CoverView:
        return view.state(self, lambda: _CoverView(self._gpu, int(self._settings["cover.shadow_texels"])))

    # -- a frame -----------------------------------------------------------------------------------------------------

    def update(self, frame: Frame) -> None:
        view, component = self._view(frame.view), frame.world.get(frame.planet, Cover)
        own_ground = frame.world.get(frame.planet, Terrain)
        terrain = with_overrides(own_ground, "terrain", frame.settings)
        cover = in_season(with_overrides(component, "cover", frame.settings), terrain)
        view.frame = frame
        view.sway = sway_at(self._wind(frame), frame.camera.position_m, frame.time_s)
        self._use_programs(cover, revision(component, *_COLOURS))
        self._now.warm_up.step(frame)
        view.shadows.use(cover.species, self._nm, revision(component, "species"))
        height = float(np.linalg.norm(frame.camera.position_m))
        direction = frame.camera.position_m / height
        view.leaves = leaves_at(cover.season, float(direction[2]))
        ground: Any = frame.world.try_resource(HEIGHT_FIELD)
        ocean = frame.world.try_get(frame.planet, Ocean)
        sea = None if ocean is None else ocean.sea_level_m
        growing = Growing.of(terrain, sea, cover.savanna, cover.riparian)
        snow = SnowFall.of(growing, frame.world.get(frame.planet, Planet).radius_m, cover)
        forest_key = (revision(component), revision(own_ground), view.leaves)
        if forest_key != view.forest_key:
            view.forest_key = forest_key
            view.forest = self._forest(cover, view.leaves, snow, terrain.snow_albedo)
        reach = float(self._settings["cover.reach_m"])
        if (
            not hasattr(ground, "moisture")  # none, or printed ground, which knows no climate: nothing grows on it
            or max(cover.density, cover.shrubs) <= 0.0
            or not self._near_ground(ground, height, direction, reach, cover)
        ):
            for near in view.nears:
                near.clear()
        else:
            key = (ground, grows(component), growing)
            budget = None if frame.settling or frame.one_shot else _BUDGET_MS
            for near in view.nears:
                own = min(reach, _SHRUBS_M) if near.layer is SHRUBS else reach
                near.refresh(key, direction, own, ground, growing, cover, terrain.seed, budget)
        view.gather()
        if not len(view.plants):
            view.shadows.place(frame.camera.position_m, view.forest, view.sway, False)
        view.look(frame, reach, snow)

    @staticmethod
    def _wind(frame: Frame) -> Wind:
        return frame.world.try_get(frame.planet, Wind) or _BREEZE

    @staticmethod
    def _near_ground(ground: Any, height_m: float, direction: Any, reach_m: float, cover: Cover) -> bool:
        if height_m - ground.radius_m > ground.highest_m + reach_m:
            return False
        above = height_m - ground.radius_m - float(ground.height(direction[None])[0])
        return above < reach_m + 2.0 * tallest_m(cover)

    def _use_programs(self, cover: Cover, changed: int) -> None:
        own = bool(cover.species)
        if (own, changed) == self._colours:
            return
        self._colours = own, changed
        if own not in self._programs:
            self._programs[own] = PlantPrograms(self._gpu, cover, self._shade_defines, self._nm)
        self._now = self._programs[own]
        self._now.use_colours(cover)

    def _snow_of(self, albedo: tuple[float, ...]) -> NDArray[np.float64]:
        if albedo != self._snow[0]:
            self._snow = albedo, reflectance(np.array([albedo]), self._nm)[0]
        return self._snow[1]

    def _forest(self, cover: Cover, leaves: Leaves, snow: SnowFall, snow_albedo: tuple[float, ...]) -> Forest:
        broadleaf, conifer, bark = self._now.albedos

        def half(sine: float) -> NDArray[np.float64]:
            turned, bare = leaves_at(cover.season, sine)
            seen = broadleaf + turned * (self._now.autumn.mean(axis=0) - broadleaf)
            return np.append(seen + LIKE_BARK * bare * (bark - seen), 1.0 - TWIGS_OPEN * bare)

        tall, flowers = cover.grass_m / GRASS_GIVEN_M, cover.flowers * (1.0 - leaves.bare)
        return Forest(
            broadleaf,
            conifer,
            half(1.0),
            half(-1.0),
            crown_share(cover.density, cover.height_m, cover.spacing_m),
            cover.height_m,
            cover.spacing_m,
            cover.grass,
            tall,
            flowers,
            cover.savanna,
            cover.variety,
            np.append(self._snow_of(snow_albedo), cover.snow),
            snow.winters(),
        )

    def settled(self, view: View) -> bool:
        return all(near.complete for near in self._view(view).nears)

    def refining(self, view: View) -> str:
        return "" if self.settled(view) else "trees"

    # -- passes ------------------------------------------------------------------------------------------------------

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        own, tiles = self._view(view.view), tiles_of(view.size)
        builder.import_(
            _PLACE, "buffer", help="where the map of the trees' shadows lies", lent=own.shadows.block.buffer
        )
        builder.import_(_MAP, "texture", help="m, towards the sun of their highest leaf", lent=own.shadows.heights)

        def any_near() -> bool:
            return len(own.plants) > 0

        builder.add_pass(
            "cover.gbuffer",
            system=self.name,
            bind=lambda io: self._bind_gbuffer(io, own),
            reads=(_PLACE,),
            writes=("gbuffer.depth", *GBUFFER, _MAP),
            stage="plants",
            only_while=view.view.seen.ground,
            when=any_near,
            help="trees in the picture, two quads each; and the map of their shadows when it has changed",
        )
        builder.add_pass(
            "cover.tiles",
            system=self.name,
            kind="compute",
            bind=lambda io: self._bind_tiles(io, tiles),
            reads=("gbuffer.tile_flags",),
            creates=(
                BufferSpec("cover.tile_list", 16 + 4 * tiles[0] * tiles[1], "persistent", help="dispatch and tiles"),
            ),
            only_while=view.view.seen.ground,
            when=any_near,
            help="tiles with trees or near ground",
        )
        builder.add_pass(
            "cover.shade",
            system=self.name,
            kind="compute",
            bind=self._bind_shade,
            reads=("gbuffer.depth", *GBUFFER, "cover.tile_list", *contract_reads(self._world)),
            writes=("scene.radiance",),
            stage="plants",
            only_while=view.view.seen.ground,
            when=any_near,
            help="light of trees; their shadows on ground, water and one another",
        )
        self._numbers.declare(
            builder,
            self.name,
            lambda: own.shown.instances,
            lambda program: self._draw(program, own),
            "plants",
            any_near,
        )

    def _bind_gbuffer(self, io: PassIO, view: _CoverView) -> Callable[[], None]:
        target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")

        def run() -> None:
            frame = view.frame
            if frame is None:
                return
            camera, on = frame.camera, bool(self._settings["cover.shadows"])
            if on:
                reach = float(self._settings["cover.reach_m"])
                sun, bare = frame.sun.direction, view.leaves.bare
                shadows, other = view.shadows, view.other_since(view.shadows.revision)
                shadows.draw(view.plants, view.revision, camera.position_m, sun, reach, bare, other)
            view.shadows.place(camera.position_m, view.forest, view.sway, on)
            if not view.count:
                return
            target.use()
            self._draw_state.apply()
            view.shadows.block.buffer.bind_to_uniform_block(COVER_BLOCK)
            view.trees.buffer.bind_to_storage_buffer(TREE_BUFFER)
            ends = (0, *view.detailed, view.count)
            for program, quads, first, end in zip(self._now.trees, self._now.quads, ends, ends[1:], strict=False):
                if first < end:
                    program.set("u_first", first)
                    program.set("u_season", tuple(view.leaves))
                    quads.render(moderngl.TRIANGLES, vertices=12, instances=end - first)

        return run

    def _draw(self, program: Program, view: _CoverView) -> None:
        """The trees in the picture again, as whole quads, with another program."""
        if self._numbered is None:
            self._numbered = self._gpu.vertex_array(program)
        view.shadows.block.buffer.bind_to_uniform_block(COVER_BLOCK)
        view.trees.buffer.bind_to_storage_buffer(TREE_BUFFER)
        program.set("u_first", 0)
        self._numbered.render(moderngl.TRIANGLES, vertices=12, instances=view.count)

    def _bind_tiles(self, io: PassIO, tiles: tuple[int, int]) -> Callable[[], None]:
        flags, listed = io.buffer("gbuffer.tile_flags"), io.buffer("cover.tile_list")

        def run() -> None:
            flags.bind_to_storage_buffer(FLAG_BUFFER)
            listed.bind_to_storage_buffer(1)
            self._list.set("u_tiles", tiles)
            self._list.run(1, 1, 1)

        return run

    def _bind_shade(self, io: PassIO) -> Callable[[], None]:
        radiance, tiles = io.texture("scene.radiance"), io.buffer("cover.tile_list")
        textures = [(unit, io.texture(name)) for name, unit in GBUFFER_UNITS.items()]
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            radiance.bind_to_image(RADIANCE_IMAGE, read=True, write=True)
            tiles.bind_to_storage_buffer(TILE_BUFFER)
            for unit, texture in textures:
                texture.use(unit)
            self._now.shade.run_indirect(tiles)

        return run

    def statistics(self) -> dict[str, int]:
        view: _CoverView | None = self._views[0].found(self)
        return {} if view is None else {"trees": view.count}
