"""TerrainSystem: the ground. A backend selects cells and makes vertices; surface, materials and light are shared."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from typing import Any, NamedTuple

import numpy as np

from ...components import Cover, DebugView, Ocean, Planet, Terrain
from ...engine.blocks.bindings import MATERIAL_BLOCK, TERRAIN_TABLE_BLOCK
from ...engine.frame import Frame, Proxy, View, ViewInfo
from ...engine.frame.gbuffer import GBUFFER
from ...engine.frame.published import HEIGHT_FIELD, SURFACE_HEIGHT
from ...engine.frame.snapping import SnapAhead
from ...engine.frame.unseen import Unseen
from ...engine.gpu.cell_mesh import CellMesh
from ...engine.graph import GraphBuilder, PassIO
from ...engine.methods import Methods
from ...engine.real_ground.streamed_colors import StreamedColors
from ...engine.real_ground.streamed_ground import StreamedGround
from ...engine.settings import SettingError, Settings, revision, with_overrides
from ...engine.system import Setup, System
from ...engine.wavelengths import wavelengths_of
from ...engine.world import World
from .backends import Backend, Ground, GroundRevision, backend_of, use_backend
from .coasts import Coasts
from .debug_passes import TerrainDebugPasses
from .ground_params import ground_params
from .height import TerrainField, TerrainParams
from .height_table import octave_table
from .labels import GroundLabels, LabelledGround
from .land_water import LandWater
from .map_textures import MapTextures
from .material import TerrainMaterialBlock, material_block
from .material_list import list_revision, shaders
from .real_colors import ground_colors
from .real_texture import HEIGHTS_FINER
from .real_wanted import Eye
from .rivers.source import source
from .rivers.table import RiverTable
from .shading import GroundShading, ShadedGround
from .spray import Spray
from .view import MaterialKey, OctavesKey, TerrainView
from .woods_map import woods_map

_SHAPE = (
    *(f.name for f in fields(TerrainParams) if f.name in {g.name for g in fields(Terrain)}),
    *("height_map_range_m", "height_map_most_mb", "color_map", "color_map_most_mb", "color_map_unlit", "vector_map"),
    *("backend", "method"),  # of which some read tiles of elevation as they are needed
    *("rivers", "banks", "drainage_cells"),
)
_WAIT_S = 2.0
_CLIMATE = ("snow_line_m", "snow_line_pole_m", "humidity")
"""What rivers follow from as well."""
_FAR_PIXEL_M = 50.0
"""Where pixels are wider on all ground, lakes may go on beyond the tiles that show them."""
_WIDE_PIXEL_M = 10.0
"""Pixels that are wider on all coasts do with heights in float. Those are right to 0.02 m within 300 km and to 0.05 m
within 6000 km, a coast so to 0.2 pixels at a slope of 1 %."""
_FARTHER = 1.0 / 32.0
"""Wider pixels on all ground, by the longest layer of relief: terrain/coast_find.comp leaves out hardly any."""
_CLOSEST = 0.5
"""Vertices are not nearer to one another than this many times terrain.edge_px, seen from the camera."""
_SOURCES = "generated/terrain_height_sources.glsl"


class _Components(NamedTuple):
    """Ids and revisions of what the ground follows from."""

    terrain: int
    colours: int
    planet: int
    body: int
    sea: bool
    solved: int
    wetter: float


class TerrainSystem(System):
    """The ground of one planet. Needs Planet and Terrain.

    Publishes the world resource ``height_field`` (engine.surface.field.HeightField), which the proxy, flight and
    queries use.
    """

    name = "terrain"
    needs = (Planet, Terrain)

    def __init__(self) -> None:
        self._world: World
        self._methods: Methods[Backend]

    def setup(self, setup: Setup) -> None:
        self._gpu = setup.gpu
        self._world, self._views = setup.world, setup.views
        self._settings, self._nm = setup.settings, wavelengths_of(setup.settings)
        self._methods = Methods(setup.gpu, setup.views)
        # Its text, for shaders; each view has a block of its own.
        setup.gpu.uniform_block(TerrainMaterialBlock, MATERIAL_BLOCK, "terrain_material_block")
        self._materials = -1
        self._use_materials()
        self._maps = MapTextures(setup.gpu)
        self._debug = TerrainDebugPasses(setup.gpu)
        setup.world.set_resource(SURFACE_HEIGHT, self._bind_heights)
        self._draw_states = {
            out: setup.gpu.state(depth_test=True, depth_func=">", cull="back" if out else None) for out in (True, False)
        }
        self._shading = GroundShading(setup, self.name, ShadedGround(
            lambda: self.backend, lambda: self._ground.params.waters is not None, lambda: self._component.clutter,
            self._bind_octaves,
        ))  # fmt: skip
        self._coasts = Coasts(setup.gpu, setup.world, setup.settings, self._shading.shader)
        self._land_water = LandWater(setup.gpu, self._shading.shader)
        self._spray = Spray(setup.gpu, setup.world, self._nm)
        self._labels = GroundLabels(setup.world, self._shading.shader)
        self._watered = False  # whether the graph was declared with rivers
        self._unseen = Unseen(Planet, Terrain, Ocean, DebugView, ground=True)
        self._changes: _Components | None = None
        # What the ground was last asked for, and what may have brought it other rivers.
        self._field_asked: tuple[GroundRevision, tuple[bool, int] | None] | None = None
        self._field_revision: GroundRevision | None = None
        self._rivers: RiverTable | None = None
        self._rivers_taken = 0  # how many tables the ground has had
        self._colour_revision = -1
        self._refresh_field(setup.world, setup.planet, setup.settings)  # with the backend's contracts

    def release(self) -> None:
        self._methods.release()
        self._views.forget(self._spray)
        self._maps.release()
        self._gpu.shaders.withdraw(self.name)
        for key in (HEIGHT_FIELD, SURFACE_HEIGHT):
            self._world.remove_resource(key)

    @property
    def backend(self) -> Backend:
        """What selects cells and makes vertices now."""
        return self._methods.now

    def _use_method(self, name: str, method: str) -> None:
        """The backend of that name and method, in place of another; nothing else changes."""
        if use_backend(self._methods, backend_of(name, method), self._settings, self._views):
            self.backend.bind_octaves = self._bind_octaves
            self.backend.ground_stamp = self._ground_stamp
            self._field_asked = self._field_revision = None  # it may draw a ground of its own
            self.structure += 1

    def _ground_stamp(self, view: View) -> int:
        return 0 if self._maps.stream is None else self._maps.stream.stamp(view)

    def _bind_heights(self, view: View) -> None:
        """World resource ``surface_height``: binds what the shader contract of that name reads."""
        if not self.backend.bind_heights(view):
            self._bind_octaves(view)

    def _bind_octaves(self, view: View) -> None:
        self._of(view).octaves.bind_to_uniform_block(TERRAIN_TABLE_BLOCK)
        self._maps.bind()

    def _refresh_field(self, world: World, planet: int, settings: Settings) -> None:
        terrain, body = world.get(planet, Terrain), world.get(planet, Planet)
        colours = revision(terrain)
        sea = bool(world.query(Ocean))
        covers = [cover for _, (cover,) in world.query(Cover)]
        wetter = with_overrides(covers[0], "cover", settings).riparian if covers else 0.0
        changes = _Components(id(terrain), colours, id(body), revision(body), sea, source.finished, wetter)
        if changes == self._changes:
            return
        if colours != self._colour_revision:
            self._colour_revision = colours
            self._component = with_overrides(terrain, "terrain", settings)
            self._use_method(self._component.backend, self._component.method)
        self._changes = changes
        # Colours change often while somebody tunes them; only the shape asks for new cells and vertices.
        rained = self._component.rivers > 0.0
        shape = (*_SHAPE, *_CLIMATE) if rained else _SHAPE
        solved = (sea, source.finished) if rained else None
        self._wetter = wetter if rained or self._component.vector_map else 0.0
        stamp = GroundRevision(id(terrain), revision(terrain, *shape), revision(body, "radius_m"), wetter=self._wetter)
        asked = stamp, solved
        if asked == self._field_asked:
            return
        before = self._ground.params if self._field_asked is not None else None
        self._field_asked = asked
        try:
            params = ground_params(self._component, body.radius_m, sea, before)
            color = ground_colors(self._component, params, self._nm)
        except ValueError as error:
            # Once: the next frames go on with the last good ground, until something is changed again.
            raise SettingError(f"Terrain on a planet of {body.radius_m:g} m cannot be: {error}") from error
        if params.rivers is not self._rivers:
            self._rivers, self._rivers_taken = params.rivers, self._rivers_taken + 1
        # Rivers that were solved for another ground change nothing here.
        stamp = stamp._replace(rivers=self._rivers_taken if rained else None)
        if stamp == self._field_revision:
            return
        self._field_revision = stamp
        self._provide_sources(params, isinstance(color, StreamedColors))
        field = TerrainField(params)
        height = params.real or params.height_map
        woods = None if params.woods is None else woods_map(params.woods, params.radius_m)
        self._maps.show(height, color, params.waters, woods, params.radius_m, field.highest_m)
        self.structure += self._watered != (params.waters is not None)
        self._ground = Ground(params, field, stamp, self._complete_table)
        world.set_resource(HEIGHT_FIELD, self.backend.drawn_field(self._ground))

    def _provide_sources(self, params: TerrainParams, colors_stream: bool) -> None:
        """Contract ``height_sources``: shaders of the ground leave out what it is not made of."""
        wanted = {
            "CRATERED": params.craters > 0.0,
            "MAPPED": params.height_map is not None,
            "TILED": params.real is not None,
            "STREAMED": isinstance(params.real, StreamedGround),
            "COLORED": params.colored,
            "PICTURED": params.pictured,
            "PICTURES_STREAMED": colors_stream,
            "RIVERS": params.waters is not None,
            "WOODED": params.woods is not None,
            "CARVED": params.rivers is not None,
            "ERODED": params.erosion > 0.0,
        }
        shaders = self._gpu.shaders
        shaders.add_virtual(_SOURCES, "".join(f"#define TERRAIN_{name}\n" for name, on in wanted.items() if on))
        shaders.provide("height_sources", _SOURCES, owner=self.name)
        # Contract ``land_water``: so do those of the sea.
        file = "land_water.glsl"
        shaders.provide("land_water", f"terrain/{file}" if wanted["RIVERS"] else f"common/{file}", owner=self.name)

    def _use_materials(self) -> None:
        """The shaders of the list of materials as it is now."""
        if self._materials != list_revision():
            self._materials = list_revision()
            for name, text in shaders().items():
                self._gpu.shaders.add_virtual(name, text)

    def _complete_table(self, table: Any) -> None:
        self._maps.write_color(table, self._component.color_map_strength)
        table["rivers"]["wetter"] = self._wetter

    def _of(self, view: View) -> TerrainView:
        return view.state(self, lambda: TerrainView(self._gpu))

    def begin(self, frame: Frame) -> None:
        self._use_materials()
        # Before the proxy looks for the ground.
        self._refresh_field(frame.world, frame.planet, frame.settings)

    def update(self, frame: Frame) -> None:
        proxy = frame.view.proxy
        view, camera = self._of(frame.view), frame.camera
        if frame.checkerboard is not None and self._shading.shade_every() == 2:
            frame.checkered.add("terrain")
        self._stream(frame)
        altitude_m = float(np.linalg.norm(camera.position_m)) - self._ground.params.radius_m
        if self._shading.shows_rivers():
            above_m, frozen = altitude_m - self._ground.field.highest_m, self._frozen_sine(frame)
            self._spray.update(frame, self._ground.params.waters, self._component.spray, above_m, frozen)
        # A grid that the proxy wants is made unseen: turning to the ground then costs nothing.
        unseen = self._unseen.rests(frame) and view.updated == proxy.generation
        if unseen and self.backend.rests(frame):
            return
        view.updated = proxy.generation
        self._refresh_octaves(view, proxy)
        ahead = frame.view.snap
        if ahead.phase and ahead.proxy is not None:
            self._prepare_octaves(view, ahead, ahead.proxy)
        pixel = frame.pixel_rad
        narrowest_m = (altitude_m - self._ground.field.highest_m) * pixel
        sea = next((ocean.sea_level_m for _, (ocean,) in frame.world.query(Ocean)), 0.0)
        view.wide = (altitude_m - sea) * pixel > _WIDE_PIXEL_M
        view.far = narrowest_m > _FAR_PIXEL_M
        view.farther = view.wide and narrowest_m > _FARTHER * float(self._ground.field.model.wavelength_m[0])
        backend = self.backend
        backend.ground = self._ground
        backend.update(frame)
        self.structure += self._methods.changed()
        key = MaterialKey(self._ground.revision, self._colour_revision, self._materials, proxy.generation)
        if key != view.material_key:
            view.material_key = key
            view.material.write(material_block(self._component, self._ground.params, proxy.lattice.direction, self._nm))
        view.material.bind()

    @staticmethod
    def _frozen_sine(frame: Frame) -> float:
        """Of the latitude from which on water is ice; 2: nowhere."""
        for _, (ocean,) in frame.world.query(Ocean):
            if ocean.ice_latitude_deg < 90.0:
                return math.sin(math.radians(ocean.ice_latitude_deg))
        return 2.0

    def _stream(self, frame: Frame) -> None:
        """Pages of real ground and of its pictures that the view needs."""
        streams = self._maps.streams
        if not streams or frame.frozen:
            return
        camera = frame.camera
        away_m = float(np.linalg.norm(camera.position_m))
        ground_m = float(self._ground.field.height((camera.position_m / away_m)[None])[0])
        tangents = max(abs(camera.tan_left), abs(camera.tan_right)), max(abs(camera.tan_bottom), abs(camera.tan_top))
        eye = Eye(
            camera.position_m, away_m - self._ground.params.radius_m - ground_m, frame.pixel_rad, camera.forward,
            float(np.arctan(np.hypot(*tangents))),
        )  # fmt: skip
        spacing_rad = HEIGHTS_FINER * _CLOSEST * float(frame.settings["terrain.edge_px"]) * frame.pixel_rad
        for stream in streams:
            stream.update(frame.view, eye, spacing_rad, frame.dt_s, frame.settling or frame.one_shot, frame.cut)

    def _octaves_key(self, proxy: Proxy) -> OctavesKey:
        return OctavesKey(proxy.generation, self._ground.revision, self._component.color_map_strength)

    def _refresh_octaves(self, view: TerrainView, proxy: Proxy) -> None:
        key = self._octaves_key(proxy)
        if key == view.key:
            return
        if key == view.next_key:  # it was prepared
            view.octaves, view.next_octaves = view.next_octaves, view.octaves
            view.key, view.next_key = key, None
            return
        view.key = key
        view.octaves = self._write_octaves(view, view.octaves, proxy)

    def _prepare_octaves(self, view: TerrainView, ahead: SnapAhead, proxy: Proxy) -> None:
        """The table around the anchor of the snap that is being prepared, for all who make vertices for it."""
        key = self._octaves_key(proxy)
        if key == view.next_key:
            return
        view.next_key = key
        view.next_octaves = self._write_octaves(view, view.next_octaves, proxy)

        def bind() -> None:
            view.next_octaves.bind_to_uniform_block(TERRAIN_TABLE_BLOCK)
            self._maps.bind()

        ahead.bind_heights = bind

    def _write_octaves(self, view: TerrainView, buffer: Any, proxy: Proxy) -> Any:
        table = octave_table(self._ground.params, proxy.lattice.direction, proxy.anchor_height_m)
        self._complete_table(table)
        if buffer is None or buffer.size != table.nbytes:
            if buffer is not None:
                view.gpu.free(buffer)
            buffer = view.gpu.buffer(reserve=table.nbytes, dynamic=True)
        buffer.write(table.tobytes())
        return buffer

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        name, of, backend = self.name, view.view, self.backend
        seen = of.seen.ground
        backend.declare(builder, view)
        builder.add_pass(
            "terrain.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, of),
            reads=backend.draw_reads(of),
            writes=("gbuffer.depth", *GBUFFER),
            stage="opaque",
            only_while=seen,
            help="patches of all visible cells",
        )
        if self._world.query(Ocean):
            self._coasts.declare(
                builder, view, lambda: self._of(of), backend.coast_file, lambda: self._bind_heights(of), seen
            )
        self._watered = self._ground.params.waters is not None
        if self._shading.shows_rivers():
            self._land_water.declare(builder, view, lambda: self._bind_heights(of), lambda: self._of(of).wide, seen)
            self._spray.declare(builder, view, of.seen.planet)
        self._shading.declare(builder, view, seen)
        self._labels.declare(builder, self._labelled(of), seen)
        self._debug.declare(builder, backend, of, lambda: self._bind_heights(of))

    def _bind_gbuffer(self, io: PassIO, view: View) -> Callable[[], None]:
        target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")
        state = self._draw_states[self.backend.faces_out]
        draw = self.backend.bind_draw(io, view, "terrain/gbuffer.frag")

        def run() -> None:
            target.use()
            state.apply()
            draw()

        return run

    def _labelled(self, view: View) -> LabelledGround:
        backend = self.backend

        def bind() -> None:
            self._bind_octaves(view)
            backend.bind_shading()

        return LabelledGround(
            backend.labels_file,
            backend.shades_all and bool(self._world.query(Cover)),
            self._shading.shows_rivers(),
            lambda: backend.shades_all and self._component.clutter > 0.0,
            bind,
        )

    def settled(self, view: View) -> bool:
        there = all(stream.settled(view) for stream in self._maps.streams)
        return there and self.backend.settled(view) and not self._solving()

    def _solving(self) -> bool:
        """Whether rivers of the ground are still being solved."""
        return self._component.rivers > 0.0 and source.pending()

    def progress(self, view: View) -> float:
        # Whoever waits for pictures to settle need not draw while rivers are solved.
        if self._solving():
            return 0.5 * source.progress(_WAIT_S)
        return self.backend.progress(view) * math.prod(stream.progress() for stream in self._maps.streams)

    def refining(self, view: View) -> str:
        if self._solving():
            return "rivers"
        for stream in self._maps.streams:
            if not stream.settled(view):
                return f"{stream.what} {100.0 * stream.progress():.0f} %"
        return "" if self.backend.settled(view) else f"ground {100.0 * self.backend.progress(view):.0f} %"

    def statistics(self) -> dict[str, int]:
        found = self.backend.statistics()
        return found if self._views[0].seen.ground() else dict.fromkeys(found, 0)

    def drawn_mesh(self, view: View) -> CellMesh | None:
        """The mesh that the last frame drew, for queries of the drawn surface; None if the backend has no CellMesh."""
        return self.backend.drawn_mesh(view)
