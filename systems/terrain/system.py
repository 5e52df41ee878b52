"""TerrainSystem: the ground, drawn on the cells of the projected grid.

Selection and vertices depend on the proxy alone; a frame in which the proxy holds only culls and draws, and a frame
in which the camera holds too only draws.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ...components import Ocean, Planet, Terrain
from ...engine.contracts import bind_contracts, contract_reads
from ...engine.gpu.cell_mesh import CellMesh
from ...engine.gpu.layout import Vec4
from ...engine.graph import GraphBuilder, PassIO
from ...engine.settings import SettingError, revision, with_overrides
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.decimation import topology
from ...engine.surface.selection import chord_limit_m, select_rings, spacing_angle
from ...engine.system import Frame, Setup, System, ViewInfo
from .debug_passes import TerrainDebugPasses
from .height import TerrainField, TerrainParams, octave_table
from .material import TerrainMaterialBlock, material_block

GRID_BINDING = 3
OCTAVES_BINDING = 4
MATERIAL_BINDING = 7
_DECIMATED_SHARE = 0.8  # of edge_px: larger ones save vertices, but the ground jumps more at a snap
_RG16_SNORM = 0x8F99  # moderngl takes the texture for an unsigned one
_SHAPE = tuple(f.name for f in fields(TerrainParams) if f.name in {g.name for g in fields(Terrain)})
_FINEST_M = 0.02
_MOST_CELLS = 12000  # a telephoto lens near the ground would ask for ten times as many: its triangles get longer
_DEEP_M = 2.0  # a cell this far below the sea is hidden by it, whatever the curvature of both meshes
GBUFFER = ("gbuffer.normal", "gbuffer.attributes", "gbuffer.surface")


@dataclass
class TerrainGridBlock:
    """What the vertex and shading passes know of the grid. GLSL: ``generated/terrain_grid.glsl``, ``terrain_grid``."""

    spacing: Vec4 = (0.01, 1.0, 1.0, 0.0)
    """(wanted spacing of vertices per metre of distance, smallest spacing in m, proxy altitude above the ground in m,
    0)"""


class _GridView:
    """One view's cells and what they were made for."""

    def __init__(self, mesh: CellMesh) -> None:
        self.mesh = mesh
        self.octaves: Any = None
        self.key: tuple[Any, ...] = ()
        self.made = -1  # the selection whose vertices exist
        self.wanted: tuple[Any, ...] = ()  # what the visible list depends on
        self.culled: tuple[Any, ...] | None = None  # what it was made for
        self.keep_dh_m = (-3.0e38, 3.0e38)
        self.eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.edge_rad = 0.01
        self.chord_m = 1.0


class TerrainSystem(System):
    """The ground of one planet. Needs Planet and Terrain.

    Publishes the world resource ``height_field`` (engine.surface.field.HeightField), which the proxy, flight and
    queries use.
    """

    name = "terrain"
    needs = (Planet, Terrain)

    def __init__(self) -> None:
        self._views: dict[int, _GridView] = {}
        self._world: Any = None
        self._block = TerrainGridBlock()

    def setup(self, setup: Setup) -> None:
        self._gpu = setup.gpu
        self._world = setup.world
        self._quads = int(setup.settings["terrain.quads"])
        self._grid_ubo = setup.gpu.uniform_block(TerrainGridBlock, GRID_BINDING, "terrain_grid")
        self._material_ubo = setup.gpu.uniform_block(TerrainMaterialBlock, MATERIAL_BINDING, "terrain_material_block")
        defines = {"QUADS_LOG2": self._quads.bit_length() - 1}
        self._vertices = setup.gpu.compute("terrain/vertices.comp", defines=defines)
        self._measure = setup.gpu.compute("common/measure_cells.comp", defines=defines)
        self._agree = setup.gpu.compute("common/agree_cells.comp", defines=defines)
        self._most = int(setup.settings["terrain.decimation"])
        self._cull = setup.gpu.compute("common/cull_cells.comp", defines=defines)
        self._surface = setup.gpu.program(
            vertex="terrain/gbuffer.vert", fragment="terrain/gbuffer.frag", defines=defines
        )
        self._shade = setup.gpu.compute("terrain/shade.comp")
        self._coast: Any = None
        self._debug = TerrainDebugPasses(setup.gpu, defines)
        setup.gpu.gpu.shaders.provide("surface_height", "terrain/surface_height.glsl", owner=self.name)
        setup.world.set_resource("surface_height", self._bind_heights)
        self._draw_state = setup.gpu.gpu.state(depth_test=True, depth_func=">", cull="back")
        self._field_revision: tuple[int, ...] = ()
        self._colour_revision = -1
        self._material_stamp: tuple[int, ...] = ()
        self._refresh_field(setup.world, setup.planet, setup.settings)

    def release(self) -> None:
        self._views.clear()
        self._gpu.gpu.shaders.withdraw(self.name)
        for resource in ("height_field", "surface_height"):
            self._world.resources.pop(resource, None)

    def _bind_heights(self, view_index: int) -> None:
        """World resource ``surface_height``: binds what the shader contract of that name reads."""
        self._view(view_index).octaves.bind_to_uniform_block(OCTAVES_BINDING)

    def _refresh_field(self, world: Any, planet: int, settings: Mapping[str, Any]) -> None:
        terrain, body = world.get(planet, Terrain), world.get(planet, Planet)
        colours = revision(terrain)
        if colours != self._colour_revision:
            self._colour_revision = colours
            self._ground = with_overrides(terrain, "terrain", settings)
        # Colours change often while somebody tunes them; only the shape asks for new cells and vertices.
        stamp = (id(terrain), revision(terrain, *_SHAPE), revision(body, "radius_m"))
        if stamp == self._field_revision:
            return
        self._field_revision = stamp
        terrain = self._ground
        try:
            self._params = TerrainParams.from_component(terrain, body.radius_m)
        except ValueError as error:
            raise SettingError(f"Terrain on a planet of {body.radius_m:g} m cannot be: {error}") from error
        self._field = TerrainField(self._params)
        world.set_resource("height_field", self._field)

    def _view(self, index: int) -> _GridView:
        view = self._views.get(index)
        if view is None:
            view = self._views[index] = _GridView(CellMesh(self._gpu, self.name, self._quads))
        return view

    def update(self, frame: Frame) -> None:
        self._refresh_field(frame.world, frame.planet, frame.settings)
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        view = self._view(frame.view_index)
        camera = frame.camera
        pixel_angle = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        edge_px = float(frame.settings["terrain.edge_px"])
        key = (proxy.generation, self._field_revision, edge_px, pixel_angle)
        if key != view.key:
            view.key = key
            angle = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, proxy.cell.radius_m)
            view.chord_m = chord_limit_m(pixel_angle, proxy.cell.radius_m)
            self._select(view, frame, proxy, angle)
        tangents = (camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        view.keep_dh_m = self._above_sea(frame, proxy)
        view.wanted = (view.mesh.selection, axes, tangents, view.keep_dh_m)
        stamp = (*self._field_revision, self._colour_revision, frame.view_index, proxy.generation)
        if stamp != self._material_stamp:
            self._material_stamp = stamp
            self._material_ubo.write(material_block(self._ground, self._params, proxy.lattice.direction))
        self._grid_ubo.bind()
        self._material_ubo.bind()

    @staticmethod
    def _above_sea(frame: Frame, proxy: Any) -> tuple[float, float]:
        """Heights from the anchor that can be seen: from above, the sea hides all of its bed and colours it itself."""
        sea = frame.world.try_get(frame.planet, Ocean)
        radius = frame.world.get(frame.planet, Planet).radius_m
        if sea is None or float(np.linalg.norm(frame.camera.position_m)) - radius < sea.sea_level_m:
            return (-3.0e38, 3.0e38)
        return (sea.sea_level_m - proxy.anchor_height_m - _DEEP_M, 3.0e38)

    def _select(self, view: _GridView, frame: Frame, proxy: Any, angle_rad: float) -> None:
        field, radius_m = self._field, frame.world.get(frame.planet, Planet).radius_m
        # Above the ground, even for a camera (or an anchor) under water.
        above_ground = max(proxy.cell.altitude_m - proxy.ground_m, 0.01)
        # Facets may not rise above an eye that is nearer to the ground than they are wide.
        smallest = min(float(frame.settings["terrain.min_spacing_m"]), max(above_ground, _FINEST_M))
        sea = frame.world.try_get(frame.planet, Ocean)
        lowest = field.lowest_m if sea is None else max(field.lowest_m, sea.sea_level_m)
        if proxy.cell.altitude_m < lowest:
            lowest = field.lowest_m  # under water the bed is what hides
        cells = select_rings(
            proxy.lattice,
            above_ground,
            proxy.ground_m,
            radius_m,
            angle_rad,
            self._quads,
            coverage_rad=proxy_coverage(
                proxy.cell.highest_altitude_m, proxy.cell.max_sideways_rad, radius_m, field.highest_m, lowest
            ).half_angle_rad,
            min_spacing_m=smallest,
            max_cells=_MOST_CELLS,
            height_at=field.height,
        )
        view.eye_m = tuple(proxy.lattice.direction * (proxy.ground_m + above_ground - proxy.anchor_height_m))
        view.edge_rad = _DECIMATED_SHARE * angle_rad
        if view.mesh.upload(cells, topology(cells)):
            self.structure += 1
        table = octave_table(self._params, proxy.lattice.direction, proxy.anchor_height_m)
        if view.octaves is None or view.octaves.size != table.nbytes:
            if view.octaves is not None:
                self._gpu.free(view.octaves)
            view.octaves = self._gpu.buffer(reserve=table.nbytes, dynamic=True)
        view.octaves.write(table.tobytes())
        self._block.spacing = (angle_rad, smallest, above_ground, 0.0)
        self._grid_ubo.write(self._block)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        grid = self._view(view.index)
        mesh, name = grid.mesh, self.name
        builder.add_pass(
            "terrain.vertices",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_vertices(io, grid),
            creates=mesh.vertex_buffers(),
            when=lambda: grid.made != mesh.selection,
            help="heights, normals and bounds of all selected cells, on a snap of the proxy",
        )
        builder.add_pass(
            "terrain.cull",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_cull(io, grid),
            reads=("terrain.bounds",),
            creates=mesh.cull_buffers(),
            when=lambda: grid.culled != grid.wanted,
            help="cells inside the frustum and above the horizon, into an indirect draw",
        )
        builder.add_pass(
            "terrain.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, grid),
            reads=("terrain.vertices", "terrain.visible", "terrain.arguments"),
            writes=("gbuffer.depth", *GBUFFER),
            after=("gbuffer.clear",),
            help="patches of all visible cells",
        )
        if self._world.query(Ocean):
            builder.add_pass(
                "terrain.coast",
                kind="compute",
                system=name,
                bind=lambda io: self._bind_coast(io, grid),
                reads=("gbuffer.depth", "gbuffer.tiles_coast"),
                writes=GBUFFER,
                after=("gbuffer.classify",),
                help="the line between land and water, from the height function at each pixel",
            )
        builder.add_pass(
            "terrain.shade",
            system=name,
            bind=lambda io: self._bind_shade(io, grid),
            kind="compute",
            reads=("gbuffer.depth", *GBUFFER, "gbuffer.tiles_terrain", *contract_reads(self._world)),
            writes=("scene.radiance",),
            after=("sky.shade",),
            help="materials and light of terrain pixels",
        )

        self._debug.declare(builder, grid, lambda: self._bind_heights(view.index))

    def _bind_vertices(self, io: PassIO, grid: _GridView) -> Callable[[], None]:
        grid.mesh.attach_vertices(io)
        grid.made = -1

        def run() -> None:
            grid.octaves.bind_to_uniform_block(OCTAVES_BINDING)
            grid.mesh.make_vertices(
                self._vertices, self._measure, self._agree, grid.eye_m, grid.edge_rad, grid.chord_m, self._most
            )
            grid.made = grid.mesh.selection

        return run

    def _bind_cull(self, io: PassIO, grid: _GridView) -> Callable[[], None]:
        grid.mesh.attach_visible(io)
        grid.culled = None

        def run() -> None:
            grid.mesh.cull(self._cull, grid.keep_dh_m)
            grid.culled = grid.wanted

        return run

    def _bind_gbuffer(self, io: PassIO, grid: _GridView) -> Callable[[], None]:
        target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")
        patches = grid.mesh.vertex_array(self._surface)

        def run() -> None:
            target.use()
            self._draw_state.apply()
            grid.mesh.draw(patches)

        return run

    def _bind_coast(self, io: PassIO, grid: _GridView) -> Callable[[], None]:
        if self._coast is None:
            self._coast = self._gpu.compute("terrain/coast.comp")
        tiles, depth = io.buffer("gbuffer.tiles_coast"), io.texture("gbuffer.depth")
        images = [io.texture(n) for n in GBUFFER]

        def run() -> None:
            tiles.bind_to_storage_buffer(7)
            depth.use(0)
            images[1].use(2)
            images[2].use(3)
            images[0].bind_to_image(0, read=False, write=True, format=_RG16_SNORM)
            images[1].bind_to_image(1, read=False, write=True)
            images[2].bind_to_image(2, read=False, write=True)
            grid.octaves.bind_to_uniform_block(OCTAVES_BINDING)
            self._coast.run_indirect(tiles)

        return run

    def _bind_shade(self, io: PassIO, grid: _GridView) -> Callable[[], None]:
        radiance, tiles = io.texture("scene.radiance"), io.buffer("gbuffer.tiles_terrain")
        textures = [io.texture(n) for n in ("gbuffer.depth", *GBUFFER)]
        bind_air = bind_contracts(self._world, io)

        def run() -> None:
            bind_air()
            radiance.bind_to_image(0, read=False, write=True)
            tiles.bind_to_storage_buffer(7)
            for unit, texture in enumerate(textures):
                texture.use(unit)
            grid.octaves.bind_to_uniform_block(OCTAVES_BINDING)
            self._shade.run_indirect(tiles)

        return run

    def statistics(self) -> dict[str, int]:
        grid = self._views.get(0)
        return {} if grid is None else grid.mesh.statistics()

    def drawn_mesh(self, view_index: int = 0) -> CellMesh | None:
        """The mesh that the last frame drew, for queries of the drawn surface."""
        grid = self._views.get(view_index)
        return None if grid is None else grid.mesh
