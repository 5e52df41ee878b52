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

from ....engine.frame import Frame, ViewParts, Views
from ....engine.frame.seen import ground_seen
from ....engine.frame.snapping import HeldScale, goes_on, snap_ahead
from ....engine.frame.snapping import at_once as snaps_at_once
from ....engine.gpu import GpuScope
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.gpu.layout import Vec4
from ....engine.graph import GraphBuilder, PassIO
from ....engine.surface.decimation import topology
from .base import Backend, Ground, heights_seen
from .grid_ahead import GridAhead, GridMaking
from .grid_choice import Choice, choose
from .grid_fade import FadePrograms, SnapFade
from .grid_queries import heights_on_cells, triangles_of_cells

__all__ = ["GridBackend"]

GRID_BINDING = 3
_LEAP = 2.0  # snaps over more than this many heights above the ground don't fade


@dataclass
class TerrainGridBlock:
    """What the vertex pass knows of the grid. GLSL: ``generated/terrain_grid.glsl``, ``terrain_grid``."""

    spacing: Vec4 = (0.01, 1.0, 1.0, 0.0)
    """(wanted spacing of vertices per metre of distance, smallest spacing in m, proxy altitude above the ground in m,
    0)"""
    faded: Vec4 = (0.01, 1.0, 1.0, 0.0)
    """The same of the selection that fades out, and its share in what is drawn."""
    moved_m: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """xyz: the anchor's foot, from that of the selection that fades out."""


_UNFADED = (TerrainGridBlock().faded, TerrainGridBlock().moved_m)


class _GridView(ViewParts):
    """One view's cells and what they were made for."""

    def __init__(self, of: GpuScope, quads: int, making: GridMaking, fades: bool) -> None:
        super().__init__(of)
        self.mesh = CellMesh(self.gpu, "terrain", quads)
        self.ahead = GridAhead(self.gpu, quads, making)
        self.choice = Choice()
        self.faded = Choice()  # the one before, which fades out
        self.held = HeldScale()
        self.key: tuple[Any, ...] = ()
        self.made = -1  # the selection whose vertices exist
        self.prepared = -1  # the one that `ahead` has the vertices of in the frame of the snap
        self.wanted: tuple[Any, ...] = ()  # what the visible list depends on
        self.culled: tuple[Any, ...] | None = None  # what it was made for
        self.keep_dh_m = (-3.0e38, 3.0e38)
        self.fade = SnapFade(self.gpu, self.mesh) if fades else None
        self.bind_octaves: Callable[[], None] = lambda: None

    def drawn_mesh(self) -> CellMesh:
        """What is drawn: the overlay of two selections for a moment after a snap."""
        return self.fade.mesh if self.fade is not None and self.fade.running else self.mesh

    def reserve(self) -> bool:
        """Room for the next snap, while nothing of it is there. True where buffers of the graph grew."""
        return self.ahead.mesh.reserve(self.mesh.capacity) | self.reserve_fade(self.mesh.capacity)

    def reserve_fade(self, room: int) -> bool:
        """Room for the next fade, unless one is there."""
        fade = self.fade
        idle = fade is not None and not (fade.running or fade.laying or fade.pending)
        return fade is not None and idle and fade.mesh.reserve(room)

    def drawn(self) -> tuple[int, ...]:
        """Says which cells are drawn."""
        mesh = self.drawn_mesh()
        return (int(mesh is self.mesh), mesh.selection)


def _leaps(proxy: Any) -> bool:
    """Whether the old grid was made for another place than the proxy's."""
    return bool(proxy.cell.snap_distance_m > _LEAP * proxy.cell.altitude_above_ground_m)


class GridBackend(Backend):
    """Backend "grid"."""

    name: ClassVar[str] = "grid"
    prepares_snaps: ClassVar[bool] = True
    contracts: ClassVar[Mapping[str, str]] = {"vertex_spacing": "terrain/grid_vertex_spacing.glsl"}

    def __init__(self, gpu: GpuScope, settings: Mapping[str, Any], method: str, views: Views) -> None:
        super().__init__(gpu, settings, method, views)
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
        self._ahead = int(settings["proxy.ahead_frames"]) > 0
        self._fading = FadePrograms(gpu, self._agree, self._defines) if self._fade_s > 0.0 else None
        self._programs: dict[tuple[str, bool], Any] = {}
        ubo = gpu.uniform_block(TerrainGridBlock, GRID_BINDING)
        self._making = GridMaking(self._vertices, self._measure, self._agree, ubo, TerrainGridBlock(), self._most)

    def view(self, index: int) -> _GridView:
        """One view's cells."""
        return self.views[index].state(self, self._new_view)

    def _new_view(self) -> _GridView:
        return _GridView(self.gpu, self._quads, self._making, self._fading is not None)

    def update(self, frame: Frame, ground: Ground, bind_octaves: Callable[[], None]) -> None:
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        view = self.view(frame.view_index)
        view.bind_octaves = bind_octaves
        camera = frame.camera
        pixel_angle = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        edge_px = float(frame.settings["terrain.edge_px"])
        at_once = snaps_at_once(frame)
        view.prepared = -1
        snap, held = snap_ahead(frame.world, frame.view_index), view.held
        made_for = (ground.revision, float(frame.settings["terrain.min_spacing_m"]))
        if view.key[:2] == (proxy.generation, made_for):
            if not frame.frozen:
                held.follow(snap, edge_px, pixel_angle)
        elif view.ahead.complete((proxy.generation, made_for)):
            held.value = view.ahead.scale
        else:
            held.value = (edge_px, pixel_angle)
        key = (proxy.generation, made_for, *held.value)
        fade = view.fade
        if fade is not None:
            fade.advance(frame.dt_s)
            if at_once or key[1:3] != view.key[1:3]:
                fade.stop()
        if key != view.key:
            may_fade = fade is not None and not at_once and key[1:3] == view.key[1:3]
            may_fade = may_fade and view.made == view.mesh.selection and view.mesh.count > 0
            # After a leap the old grid was not made for the place, and nobody sees a fade; what waited is no leap.
            may_fade = may_fade and (view.ahead.complete(key[:2]) or not _leaps(proxy))
            view.key = key
            self._snap(view, frame, ground, proxy, may_fade)
        if goes_on(frame) and snap.proxy is None and view.prepared < 0:
            self.structure += view.reserve()
        if snap.proxy is not None:
            then = (snap.proxy.generation, made_for)
            scale = (edge_px, pixel_angle)
            grew = view.ahead.update(frame, ground, snap, then, scale, fade, view.choice)
            self.structure += grew | view.reserve_fade(snap.room)
        tangents = (camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        view.keep_dh_m = heights_seen(frame, proxy.anchor_height_m)
        wanted = (*view.drawn(), axes, tangents, view.keep_dh_m)
        fading = fade is not None and fade.running
        seen = ground_seen(frame.world, frame.view_index)()
        if seen and not (frame.frozen and view.culled == view.wanted and not fading):
            view.wanted = wanted
        self._write_block(view, ground.params.radius_m)

    def _write_block(self, view: _GridView, radius_m: float) -> None:
        block, fade = self.block, view.fade
        wanted: tuple[Vec4, ...] = (view.choice.spacing, *_UNFADED)
        if fade is not None and fade.running:
            moved_m = view.choice.foot_m(radius_m) - view.faded.foot_m(radius_m)
            wanted = (view.choice.spacing, (*view.faded.spacing[:3], 1.0 - fade.part), (*moved_m, 0.0))
        if wanted != (block.spacing, block.faded, block.moved_m):
            block.spacing, block.faded, block.moved_m = wanted
            self._ubo.write(block)
        self._ubo.bind()

    def _snap(self, view: _GridView, frame: Frame, ground: Ground, proxy: Any, may_fade: bool) -> None:
        """The grid for a proxy: the one that was prepared, or a new one at once."""
        fade, ahead, old = view.fade, view.ahead, view.choice
        prepared = ahead.complete(view.key[:2])
        laid = prepared and may_fade and fade is not None and fade.laid
        if may_fade and fade is not None and old.cells is not None and not laid:
            fade.keep(old.cells, old.anchor_m, old.anchor_height_m)
        if prepared:
            view.choice = ahead.choice
            grew = view.mesh.take(ahead.mesh)
            view.made = -1 if grew else view.mesh.selection
            view.prepared = view.mesh.selection
        else:
            view.choice = choose(frame, ground, proxy, self._quads, view.key[2], view.key[3])
            assert view.choice.cells is not None
            grew = view.mesh.upload(view.choice.cells, topology(view.choice.cells))
        new, view.faded = view.choice, old
        assert new.cells is not None
        if fade is not None:
            if not may_fade:
                fade.stop()
            elif laid:
                fade.start(self._fade_s)
            else:
                grew |= fade.begin(new.cells, new.anchor_m, new.anchor_height_m, self._fade_s)
        self.structure += grew

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
        if self._ahead:
            builder.add_pass(
                "terrain.ahead",
                kind="compute",
                system="terrain",
                bind=grid.ahead.bind,
                creates=grid.ahead.mesh.vertex_buffers(),
                after=("terrain.vertices",),
                when=lambda: grid.ahead.due,
                side_effect=True,
                help="a share of the vertices for the next snap of the proxy, before it comes",
            )
        reads, creates = ("terrain.bounds",), mesh.cull_buffers()
        if fade is not None and programs is not None:
            builder.add_pass(
                "terrain.fade",
                kind="compute",
                system="terrain",
                bind=lambda io: self._bind_fade(io, grid, fade, programs),
                reads=("terrain.vertices", *(("terrain_ahead.vertices",) if self._ahead else ())),
                creates=fade.buffers(),
                when=lambda: fade.pending or fade.laying,
                help="the overlay of the old and the new selection, at a snap or a share of it before",
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
        if grid.mesh.attach_vertices(io):  # else what is in them still holds
            grid.made = -1

        def run() -> None:
            if grid.prepared == grid.mesh.selection:  # there was no room for them yet
                grid.mesh.take_vertices(grid.ahead.mesh)
                grid.made = grid.mesh.selection
                return
            grid.bind_octaves()
            made = grid.choice
            grid.mesh.make_vertices(
                self._vertices, self._measure, self._agree, made.eye_m, made.edge_rad, made.chord_m, self._most
            )
            grid.made = grid.mesh.selection

        return run

    @staticmethod
    def _bind_fade(io: PassIO, grid: _GridView, fade: SnapFade, programs: FadePrograms) -> Callable[[], None]:
        whole = fade.bind(io, programs)

        def run() -> None:
            whole()
            grid.ahead.lay_part(fade, programs)

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

    def settled(self) -> bool:
        return not any(view.fade is not None and view.fade.running for view in self.views.states(self, _GridView))

    def statistics(self) -> dict[str, int]:
        grid = self.views.found(0, self, _GridView)
        return {} if grid is None else grid.drawn_mesh().statistics()

    def drawn_mesh(self, view_index: int = 0) -> CellMesh | None:
        grid = self.views.found(view_index, self, _GridView)
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
