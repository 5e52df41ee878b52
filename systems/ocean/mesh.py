"""SeaMeshPasses: cells of the lattice at sea level, moved by waves, into the G-buffer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ...components import Ocean, Planet
from ...engine.frame import Frame, ViewInfo, ViewParts
from ...engine.frame.seen import ground_seen
from ...engine.frame.snapping import HeldScale, goes_on, snap_ahead
from ...engine.gpu import GpuScope
from ...engine.gpu.cell_mesh import VERTEX_DTYPE, CellMesh
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import revision
from ...engine.surface.decimation import topology
from ...engine.system import Setup
from .mesh_choice import SeaAhead, SeaChoice, SeaMaking, choose_sea
from .shading import GBUFFER, SEA_TOP
from .wave_passes import SeaWaves, WaveView

__all__ = ["SeaMeshPasses", "SeaView"]

_WATER_ONLY = (-1.0e29, 3.0e38)  # ocean/vertices.comp marks cells without water


class SeaView(ViewParts):
    """One view's cells and what they were made for."""

    def __init__(self, of: GpuScope, name: str, quads: int, making: SeaMaking) -> None:
        super().__init__(of)
        self.mesh = CellMesh(self.gpu, name, quads)
        self.ahead = SeaAhead(self.gpu, name, quads, making)
        self.waves = WaveView(self.gpu)
        self.key: tuple[Any, ...] = ()
        self.made: tuple[Any, ...] | None = None
        self.prepared = -1  # the selection that `ahead` has the vertices of in the frame of the snap
        self.wanted: tuple[Any, ...] = ()
        self.culled: tuple[Any, ...] | None = None
        self.displaced: tuple[Any, ...] | None = None
        self.choice = SeaChoice()
        self.held = HeldScale()
        self.from_below = False
        self.list: Any = None  # buffer of the cells to displace, on the GPU

    @property
    def moving(self) -> tuple[Any, ...]:
        """What the displaced vertices depend on."""
        return (self.made, self.culled, self.waves.moment)


class SeaMeshPasses:
    """Part of OceanSystem: chooses cells on a snap of the proxy, draws them displaced where that can be seen."""

    def __init__(self, name: str, waves: SeaWaves) -> None:
        self._name, self._waves = name, waves

    def setup(self, setup: Setup) -> None:
        gpu = self._gpu = setup.gpu
        self._world = setup.world
        self.quads = int(setup.settings["terrain.quads"])
        self._ahead = int(setup.settings["proxy.ahead_frames"]) > 0
        defines = {"QUADS_LOG2": self.quads.bit_length() - 1}
        self._vertices = gpu.compute("ocean/vertices.comp", defines=defines)
        self._measure = gpu.compute("common/measure_cells.comp", defines=defines)
        self._agree = gpu.compute("common/agree_cells.comp", defines=defines)
        self._making = SeaMaking(self._vertices, self._measure, self._agree, int(setup.settings["terrain.decimation"]))
        self._cull = gpu.compute("common/cull_cells.comp", defines=defines)
        self._list = gpu.compute("ocean/list_cells.comp", defines=defines)
        # Fetching a wave costs as much as evaluating it where lanes can't share the fetch.
        each = 5 if gpu.gpu.caps.is_software else 2
        self._displace = gpu.compute("ocean/displace.comp", defines={**defines, "SEA_VERTICES": each})
        calm, moving = defines, {**defines, "SEA_MOVES": 1}
        self._surfaces = [
            gpu.program(vertex="ocean/gbuffer.vert", fragment="ocean/gbuffer.frag", defines=d) for d in (calm, moving)
        ]
        # Seen from above and, under water, from below.
        self._draw_state = gpu.gpu.state(depth_test=True, depth_func=">", cull=None)

    def view(self) -> SeaView:
        """A view without cells yet."""
        return SeaView(self._gpu, self._name, self.quads, self._making)

    def update(self, frame: Frame, view: SeaView) -> bool:
        """Choose the cells; True where passes or buffers changed."""
        ocean = frame.world.get(frame.planet, Ocean)
        radius = frame.world.get(frame.planet, Planet).radius_m
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        camera = frame.camera
        pixel_angle = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        edge_px = float(frame.settings["terrain.edge_px"])
        ground = frame.world.resources.get("height_field")
        # From below the surface is seen until the line of sight, which the bed may bend, has come up to it.
        view.from_below = camera.distance_m - radius < frame.world.resource(SEA_TOP)
        snap, held = snap_ahead(frame.world, frame.view_index), view.held
        view.prepared = -1
        snap.take_part(True, "sea")
        smallest_m = float(frame.settings["terrain.min_spacing_m"])
        rest = (revision(ocean), (id(ground), smallest_m), view.from_below)
        if view.key[:4] == (proxy.generation, *rest):
            if not frame.frozen:
                held.follow(snap, edge_px, pixel_angle)
        elif view.ahead.complete((proxy.generation, *rest)):
            held.value = view.ahead.scale
        else:
            held.value = (edge_px, pixel_angle)
        key, changed = (proxy.generation, *rest, *held.value), False

        def choice_for(there: Any, scale: tuple[float, float]) -> SeaChoice:
            return choose_sea(frame, self._waves, there, self.quads, *scale, view.from_below)

        if key != view.key:
            view.key = key
            prepared = view.ahead.complete(key[:4])
            choice = view.choice = view.ahead.choice if prepared else choice_for(proxy, held.value)
            assert choice.cells is not None
            changed = self._waves.place(
                view.waves,
                frame,
                choice.above_sea_m,
                held.value[1],
                choice.eye_m,
                choice.edge_rad,
                choice.smallest_m,
            )
            if prepared:
                grew = view.mesh.take(view.ahead.mesh)
                view.made = None if grew else (view.mesh.selection, key)
                view.prepared = view.mesh.selection
            else:
                grew = view.mesh.upload(choice.cells, topology(choice.cells))
            changed |= grew
        if goes_on(frame) and snap.proxy is None and view.prepared < 0:
            changed |= view.ahead.mesh.reserve(view.mesh.capacity)
        if snap.proxy is not None:
            there, scale = snap.proxy, (edge_px, pixel_angle)
            changed |= view.ahead.update(snap, (there.generation, *rest), scale, lambda: choice_for(there, scale))
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        wanted = (view.mesh.selection, axes, camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        seen = ground_seen(frame.world, frame.view_index)()
        if seen and not (frame.frozen and view.culled == view.wanted and not changed):
            view.wanted = wanted
        return changed

    def declare(self, builder: GraphBuilder, view: ViewInfo, sea: SeaView) -> None:
        mesh, name, moves = sea.mesh, self._name, sea.waves.moves
        seen = ground_seen(self._world, view.index)
        builder.add_pass(
            "ocean.vertices",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_vertices(io, sea, view.index),
            creates=mesh.vertex_buffers(),
            when=lambda: sea.made != (mesh.selection, sea.key),
            help="the calm sea's vertices and the depth below them, on a snap of the proxy",
        )
        if self._ahead:
            builder.add_pass(
                "ocean.ahead",
                kind="compute",
                system=name,
                bind=sea.ahead.bind,
                creates=sea.ahead.mesh.vertex_buffers(),
                after=("ocean.vertices",),
                when=lambda: sea.ahead.due,
                side_effect=True,
                help="a share of the vertices for the next snap of the proxy, before it comes",
            )
        cells = BufferSpec("ocean.cells", 16 + 4 * mesh.capacity, "persistent", "cells to displace")
        builder.add_pass(
            "ocean.cull",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_cull(io, sea),
            reads=("ocean.bounds",),
            creates=(*mesh.cull_buffers(), *((cells,) if moves else ())),
            when=lambda: sea.culled != sea.wanted,
            help="cells of the sea that can be seen",
        )
        if moves:
            size = mesh.capacity * mesh.vertices_per_cell * VERTEX_DTYPE.itemsize
            builder.add_pass(
                "ocean.displace",
                kind="compute",
                system=name,
                bind=lambda io: self._bind_displace(io, sea),
                reads=("ocean.vertices", "ocean.cells"),
                creates=(BufferSpec("ocean.displaced", size, "persistent", "vertices of the visible cells in waves"),),
                when=lambda: sea.displaced != sea.moving,
                only_while=seen,
                help="visible vertices moved by the waves that the mesh can show",
            )
        builder.add_pass(
            "ocean.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, sea),
            reads=("ocean.displaced" if moves else "ocean.vertices", "ocean.visible", "ocean.arguments"),
            creates=(TextureSpec("ocean.moved", "rg16_snorm", help="sideways, over the largest"),) if moves else (),
            writes=("gbuffer.depth", *GBUFFER),
            stage="water",
            only_while=seen,
            help="patches of the visible sea",
        )

    def _bind_vertices(self, io: PassIO, sea: SeaView, view_index: int) -> Callable[[], None]:
        if sea.mesh.attach_vertices(io):  # else what is in them still holds
            sea.made = None

        def run() -> None:
            if sea.prepared == sea.mesh.selection:  # there was no room for them yet
                sea.mesh.take_vertices(sea.ahead.mesh)
                sea.made = (sea.mesh.selection, sea.key)
                return
            bind_heights = self._world.resources.get("surface_height")
            if bind_heights is not None:
                bind_heights(view_index)
            choice = sea.choice
            self._vertices.set("u_reach", choice.reach_m)
            self._vertices.set("u_first", -1)
            sea.mesh.make_vertices(
                self._vertices, self._measure, self._agree, choice.eye_m, choice.edge_rad, choice.chord_m,
                self._making.skipped(choice),
            )  # fmt: skip
            sea.made = (sea.mesh.selection, sea.key)

        return run

    def _bind_cull(self, io: PassIO, sea: SeaView) -> Callable[[], None]:
        cells = io.buffer("ocean.cells") if sea.waves.moves else None
        if sea.mesh.attach_visible(io) or cells is not sea.list:  # else what is in them still holds
            sea.culled, sea.list = None, cells

        def run() -> None:
            sea.mesh.cull(self._cull, _WATER_ONLY, hides=not sea.from_below)
            if cells is not None:
                self._gpu.gpu.barrier()
                cells.bind_to_storage_buffer(4)
                self._list.run(1, 1, 1)
            sea.culled = sea.wanted

        return run

    def _bind_displace(self, io: PassIO, sea: SeaView) -> Callable[[], None]:
        cells, displaced = io.buffer("ocean.cells"), io.buffer("ocean.displaced")
        sea.displaced = None

        def run() -> None:
            sea.mesh.bind_made()
            displaced.bind_to_storage_buffer(3)
            cells.bind_to_storage_buffer(4)
            self._displace.run_indirect(cells)
            sea.displaced = sea.moving

        return run

    def _bind_gbuffer(self, io: PassIO, sea: SeaView) -> Callable[[], None]:
        moves = sea.waves.moves
        patches = sea.mesh.vertex_array(self._surfaces[moves])
        if not moves:
            target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")

            def run() -> None:
                target.use()
                self._draw_state.apply()
                sea.mesh.draw(patches)

            return run
        target = io.framebuffer(colors=(*GBUFFER, "ocean.moved"), depth="gbuffer.depth")
        moved, displaced = io.framebuffer(colors=("ocean.moved",)), io.buffer("ocean.displaced")

        def run_moving() -> None:
            # Pixels that the coast's own pass turns into sea have not moved.
            moved.clear()
            target.use()
            self._draw_state.apply()
            sea.mesh.draw(patches, displaced)

        return run_moving
