"""The projected grid: rings of cells around the proxy whose spacing doubles with distance.

Selection and vertices depend on the proxy alone; a frame in which the proxy holds only culls and draws, and a frame
in which the camera holds too only draws.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from ....components import Ocean, Planet
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.gpu.layout import Vec4
from ....engine.graph import GraphBuilder, PassIO
from ....engine.surface.coverage import proxy_coverage
from ....engine.surface.decimation import topology
from ....engine.surface.selection import chord_limit_m, select_rings, spacing_angle
from ....engine.system import Frame
from .base import Backend, Ground, heights_seen
from .grid_queries import heights_on_cells

__all__ = ["GridBackend"]

GRID_BINDING = 3
_DECIMATED_SHARE = 0.8  # of edge_px: larger ones save vertices, but the ground jumps more at a snap
_FINEST_M = 0.02
_MOST_CELLS = 12000  # a telephoto lens near the ground would ask for ten times as many: its triangles get longer


@dataclass
class TerrainGridBlock:
    """What the vertex pass knows of the grid. GLSL: ``generated/terrain_grid.glsl``, ``terrain_grid``."""

    spacing: Vec4 = (0.01, 1.0, 1.0, 0.0)
    """(wanted spacing of vertices per metre of distance, smallest spacing in m, proxy altitude above the ground in m,
    0)"""


class _GridView:
    """One view's cells and what they were made for."""

    def __init__(self, mesh: CellMesh) -> None:
        self.mesh = mesh
        self.key: tuple[Any, ...] = ()
        self.made = -1  # the selection whose vertices exist
        self.wanted: tuple[Any, ...] = ()  # what the visible list depends on
        self.culled: tuple[Any, ...] | None = None  # what it was made for
        self.keep_dh_m = (-3.0e38, 3.0e38)
        self.eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.edge_rad = 0.01
        self.chord_m = 1.0
        self.bind_octaves: Callable[[], None] = lambda: None


class GridBackend(Backend):
    """Backend "grid"."""

    name: ClassVar[str] = "grid"
    contracts: ClassVar[Mapping[str, str]] = {"vertex_spacing": "terrain/grid_vertex_spacing.glsl"}

    def __init__(self, gpu: GpuScope, settings: Mapping[str, Any], method: str) -> None:
        super().__init__(gpu, settings, method)
        self._views: dict[int, _GridView] = {}
        self._quads = int(settings["terrain.quads"])
        self._most = int(settings["terrain.decimation"])
        self.block = TerrainGridBlock()
        self._ubo = gpu.uniform_block(TerrainGridBlock, GRID_BINDING, "terrain_grid")
        self._defines = {"QUADS_LOG2": self._quads.bit_length() - 1}
        self._vertices = gpu.compute("terrain/vertices.comp", defines=self._defines)
        self._measure = gpu.compute("common/measure_cells.comp", defines=self._defines)
        self._agree = gpu.compute("common/agree_cells.comp", defines=self._defines)
        self._cull = gpu.compute("common/cull_cells.comp", defines=self._defines)
        self._programs: dict[str, Any] = {}

    def view(self, index: int) -> _GridView:
        """One view's cells."""
        view = self._views.get(index)
        if view is None:
            view = self._views[index] = _GridView(CellMesh(self.gpu, "terrain", self._quads))
        return view

    def update(self, frame: Frame, ground: Ground, bind_octaves: Callable[[], None]) -> None:
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        view = self.view(frame.view_index)
        view.bind_octaves = bind_octaves
        camera = frame.camera
        pixel_angle = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        edge_px = float(frame.settings["terrain.edge_px"])
        key = (proxy.generation, ground.revision, edge_px, pixel_angle)
        if key != view.key:
            view.key = key
            angle = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, proxy.cell.radius_m)
            view.chord_m = chord_limit_m(pixel_angle, proxy.cell.radius_m)
            self._select(view, frame, ground, proxy, angle)
        tangents = (camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        view.keep_dh_m = heights_seen(frame, proxy.anchor_height_m)
        view.wanted = (view.mesh.selection, axes, tangents, view.keep_dh_m)
        self._ubo.bind()

    def _select(self, view: _GridView, frame: Frame, ground: Ground, proxy: Any, angle_rad: float) -> None:
        field, radius_m = ground.field, frame.world.get(frame.planet, Planet).radius_m
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
        self.block.spacing = (angle_rad, smallest, above_ground, 0.0)
        self._ubo.write(self.block)

    def declare(self, builder: GraphBuilder, view_index: int) -> None:
        grid = self.view(view_index)
        mesh = grid.mesh
        builder.add_pass(
            "terrain.vertices",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_vertices(io, grid),
            creates=mesh.vertex_buffers(),
            when=lambda: grid.made != mesh.selection,
            help="heights, normals and bounds of all selected cells, on a snap of the proxy",
        )
        builder.add_pass(
            "terrain.cull",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_cull(io, grid),
            reads=("terrain.bounds",),
            creates=mesh.cull_buffers(),
            when=lambda: grid.culled != grid.wanted,
            help="cells inside the frustum and above the horizon, into an indirect draw",
        )

    def _bind_vertices(self, io: PassIO, grid: _GridView) -> Callable[[], None]:
        grid.mesh.attach_vertices(io)
        grid.made = -1

        def run() -> None:
            grid.bind_octaves()
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

    def draw_reads(self) -> tuple[str, ...]:
        return ("terrain.vertices", "terrain.visible", "terrain.arguments")

    def bind_draw(self, io: PassIO, view_index: int, fragment: str) -> Callable[[], None]:
        program = self._programs.get(fragment)
        if program is None:
            program = self._programs[fragment] = self.gpu.program(
                vertex="terrain/gbuffer.vert", fragment=fragment, defines=self._defines
            )
        mesh = self.view(view_index).mesh
        patches = mesh.vertex_array(program)
        return lambda: mesh.draw(patches)

    def statistics(self) -> dict[str, int]:
        grid = self._views.get(0)
        return {} if grid is None else grid.mesh.statistics()

    def drawn_mesh(self, view_index: int = 0) -> CellMesh | None:
        grid = self._views.get(view_index)
        return None if grid is None else grid.mesh

    def height_drawn(self, directions: NDArray[np.float64], proxy: Any) -> NDArray[np.float64]:
        mesh = self.drawn_mesh()
        if mesh is None or mesh.count == 0:
            return super().height_drawn(directions, proxy)
        return heights_on_cells(mesh, directions, proxy)
