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

from ....components import DebugView, Ocean, Planet
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.gpu.layout import Vec4
from ....engine.graph import GraphBuilder, PassIO
from ....engine.planet_seen import planet_seen
from ....engine.surface.coverage import proxy_coverage
from ....engine.surface.decimation import topology
from ....engine.surface.selection import CellSet, chord_limit_m, select_rings, spacing_angle
from ....engine.system import Frame
from .base import Backend, Ground, heights_seen
from .grid_fade import FadePrograms, SnapFade
from .grid_queries import heights_on_cells, triangles_of_cells

__all__ = ["GridBackend"]

GRID_BINDING = 3
_DECIMATED_SHARE = 0.8  # of edge_px: larger ones save vertices, but the ground jumps more at a snap
_FINEST_M = 0.02
_LEAP = 2.0  # snaps over more than this many heights above the ground don't fade
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
        self.spacing: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)  # what the block of the grid says of it
        self.chord_m = 1.0
        self.fade: SnapFade | None = None
        self.cells: CellSet | None = None
        self.anchor_m = np.zeros(3)
        self.anchor_height_m = 0.0
        self.bind_octaves: Callable[[], None] = lambda: None

    def drawn_mesh(self) -> CellMesh:
        """What is drawn: the overlay of two selections for a moment after a snap."""
        return self.fade.mesh if self.fade is not None and self.fade.running else self.mesh

    def drawn(self) -> tuple[int, ...]:
        """Says which cells are drawn."""
        mesh = self.drawn_mesh()
        return (int(mesh is self.mesh), mesh.selection)


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
        self._fade_s = float(settings["terrain.fade_s"])
        self._fading = FadePrograms(gpu, self._agree, self._defines) if self._fade_s > 0.0 else None
        self._programs: dict[tuple[str, bool], Any] = {}

    def view(self, index: int) -> _GridView:
        """One view's cells."""
        view = self._views.get(index)
        if view is None:
            view = self._views[index] = _GridView(CellMesh(self.gpu, "terrain", self._quads))
            if self._fading is not None:
                view.fade = SnapFade(self.gpu, view.mesh)
        return view

    def update(self, frame: Frame, ground: Ground, bind_octaves: Callable[[], None]) -> None:
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        view = self.view(frame.view_index)
        view.bind_octaves = bind_octaves
        camera = frame.camera
        pixel_angle = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        edge_px = float(frame.settings["terrain.edge_px"])
        key = (proxy.generation, ground.revision, edge_px, pixel_angle)
        fade = view.fade
        at_once = frame.cut or frame.settling or frame.one_shot
        if fade is not None:
            fade.advance(frame.dt_s)
            if at_once or key[1:] != view.key[1:]:
                fade.stop()
        if key != view.key:
            may_fade = fade is not None and not at_once and key[1:] == view.key[1:]
            may_fade = may_fade and view.made == view.mesh.selection and view.mesh.count > 0
            # The old grid has to have been made for this place: nobody sees a fade after a leap.
            may_fade = may_fade and proxy.cell.snap_distance_m <= _LEAP * proxy.cell.altitude_above_ground_m
            view.key = key
            angle = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, proxy.cell.radius_m)
            view.chord_m = chord_limit_m(pixel_angle, proxy.cell.radius_m)
            self._select(view, frame, ground, proxy, angle, may_fade)
        tangents = (camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        view.keep_dh_m = heights_seen(frame, proxy.anchor_height_m)
        wanted = (*view.drawn(), axes, tangents, view.keep_dh_m)
        frozen = any(shown.freeze for _, (shown,) in frame.world.query(DebugView))
        fading = fade is not None and fade.running
        seen = planet_seen(frame.world, frame.view_index)()
        if seen and not (frozen and view.culled == view.wanted and not fading):
            view.wanted = wanted
        if self.block.spacing != view.spacing:
            self.block.spacing = view.spacing
            self._ubo.write(self.block)
        self._ubo.bind()

    def _select(
        self, view: _GridView, frame: Frame, ground: Ground, proxy: Any, angle_rad: float, may_fade: bool
    ) -> None:
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
        fade = view.fade
        if may_fade and fade is not None and view.cells is not None:
            fade.keep(view.cells, view.anchor_m, view.anchor_height_m)
        if view.mesh.upload(cells, topology(cells)):
            self.structure += 1
        view.cells, view.anchor_m, view.anchor_height_m = cells, proxy.anchor_m.copy(), proxy.anchor_height_m
        if fade is not None:
            if not may_fade:
                fade.stop()
            elif fade.begin(cells, view.anchor_m, view.anchor_height_m, self._fade_s):
                self.structure += 1
        view.spacing = (angle_rad, smallest, above_ground, 0.0)

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
        fade, programs = grid.fade, self._fading
        reads, creates = ("terrain.bounds",), mesh.cull_buffers()
        if fade is not None and programs is not None:
            builder.add_pass(
                "terrain.fade",
                kind="compute",
                system="terrain",
                bind=lambda io: fade.bind(io, programs),
                reads=("terrain.vertices",),
                creates=fade.buffers(),
                when=lambda: fade.pending,
                help="the overlay of the old and the new selection, after a snap",
            )
            reads, creates = (*reads, "terrain_fade.bounds"), (*creates, *fade.mesh.cull_buffers())
        builder.add_pass(
            "terrain.cull",
            kind="compute",
            system="terrain",
            bind=lambda io: self._bind_cull(io, grid),
            reads=reads,
            creates=creates,
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
        fresh = grid.mesh.attach_visible(io)
        if grid.fade is not None:
            fresh = grid.fade.mesh.attach_visible(io) or fresh
        if fresh:  # else what is in them still holds, which a freeze hangs on
            grid.culled = None

        def run() -> None:
            grid.drawn_mesh().cull(self._cull, grid.keep_dh_m)
            grid.culled = grid.wanted

        return run

    def draw_reads(self) -> tuple[str, ...]:
        names = ("vertices", "visible", "arguments")
        final = tuple(f"terrain.{n}" for n in names)
        return final if self._fading is None else (*final, *(f"terrain_fade.{n}" for n in (*names, "starts")))

    def bind_draw(self, io: PassIO, view_index: int, fragment: str) -> Callable[[], None]:
        view = self.view(view_index)
        mesh, fade = view.mesh, view.fade
        patches = mesh.vertex_array(self._program(fragment, False))
        if fade is None:
            return lambda: mesh.draw(patches)
        moving = self._program(fragment, True)
        overlaid = fade.mesh.vertex_array(moving)

        def draw() -> None:
            if fade.running:
                fade.bind_draw()
                moving.set("u_fade", fade.part)
                fade.mesh.draw(overlaid)
            else:
                mesh.draw(patches)

        return draw

    def _program(self, fragment: str, fades: bool) -> Any:
        key = (fragment, fades)
        if key not in self._programs:
            defines = {**self._defines, **({"TERRAIN_FADE": 1} if fades else {})}
            self._programs[key] = self.gpu.program(vertex="terrain/gbuffer.vert", fragment=fragment, defines=defines)
        return self._programs[key]

    def statistics(self) -> dict[str, int]:
        grid = self._views.get(0)
        return {} if grid is None else grid.drawn_mesh().statistics()

    def drawn_mesh(self, view_index: int = 0) -> CellMesh | None:
        grid = self._views.get(view_index)
        return None if grid is None else grid.mesh

    def mesh_stamp(self, view_index: int) -> object:
        return self.view(view_index).mesh.selection

    def read_mesh(self, view_index: int) -> tuple[NDArray[np.float32], NDArray[np.int64]] | None:
        mesh = self.view(view_index).mesh
        vertices = mesh.read_vertices()["position_m"].reshape(-1, 3)
        return vertices, triangles_of_cells(mesh.read_cells(), mesh.quads)

    def height_drawn(self, directions: NDArray[np.float64], proxy: Any, view_index: int = 0) -> NDArray[np.float64]:
        mesh = self.drawn_mesh(view_index)
        if mesh is None or mesh.count == 0:
            return super().height_drawn(directions, proxy)
        return heights_on_cells(mesh, directions, proxy)
