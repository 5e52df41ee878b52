"""SeaMeshPasses: cells of the lattice at sea level, moved by waves, into the G-buffer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...components import DebugView, Ocean, Planet
from ...engine.gpu.cell_mesh import VERTEX_DTYPE, CellMesh
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.planet_seen import planet_seen
from ...engine.settings import revision
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.decimation import topology
from ...engine.surface.selection import chord_limit_m, select_rings, spacing_angle
from ...engine.system import Frame, Setup, ViewInfo
from .shading import GBUFFER, SEA_TOP
from .wave_passes import SeaWaves, WaveView

__all__ = ["SeaMeshPasses", "SeaView"]

_MOST_CELLS = 12000  # as for the ground
_MOST_SKIPPED = 1  # powers of two
_WATER_ONLY = (-1.0e29, 3.0e38)  # ocean/vertices.comp marks cells without water


class SeaView:
    """One view's cells and what they were made for."""

    def __init__(self, mesh: CellMesh, waves: WaveView) -> None:
        self.mesh = mesh
        self.waves = waves
        self.key: tuple[Any, ...] = ()
        self.made: tuple[Any, ...] | None = None
        self.wanted: tuple[Any, ...] = ()
        self.culled: tuple[Any, ...] | None = None
        self.displaced: tuple[Any, ...] | None = None
        self.eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.edge_rad = 0.01
        self.chord_m = 1.0
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
        defines = {"QUADS_LOG2": self.quads.bit_length() - 1}
        self._vertices = gpu.compute("ocean/vertices.comp", defines=defines)
        self._measure = gpu.compute("common/measure_cells.comp", defines=defines)
        self._agree = gpu.compute("common/agree_cells.comp", defines=defines)
        self._most = int(setup.settings["terrain.decimation"])
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

    def view(self, waves: WaveView) -> SeaView:
        """A view without cells yet."""
        return SeaView(CellMesh(self._gpu, self._name, self.quads), waves)

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
        view.from_below = float(np.linalg.norm(camera.position_m)) - radius < frame.world.resource(SEA_TOP)
        key = (proxy.generation, revision(ocean), edge_px, pixel_angle, id(ground), view.from_below)
        changed = False
        if key != view.key:
            view.key = key
            changed = self._select(frame, view, ocean, radius, proxy, pixel_angle, edge_px, ground)
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        wanted = (view.mesh.selection, axes, camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        frozen = any(shown.freeze for _, (shown,) in frame.world.query(DebugView))
        seen = planet_seen(frame.world, frame.view_index)()
        if seen and not (frozen and view.culled == view.wanted and not changed):
            view.wanted = wanted
        return changed

    def _select(
        self,
        frame: Frame,
        view: SeaView,
        ocean: Ocean,
        radius: float,
        proxy: Any,
        pixel_angle: float,
        edge_px: float,
        ground: Any,
    ) -> bool:
        # At the limb chords of the sea must not hang below the bed, which has the same lattice.
        view.chord_m = 0.05 * chord_limit_m(pixel_angle, radius)
        angle_rad = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, radius)
        above_sea = max(abs(proxy.cell.altitude_m - ocean.sea_level_m), 0.05)
        smallest_m = float(frame.settings["terrain.min_spacing_m"])
        height = ocean.sea_level_m + above_sea - proxy.anchor_height_m
        view.eye_m, view.edge_rad = tuple(proxy.lattice.direction * height), angle_rad
        changed = self._waves.place(view.waves, frame, above_sea, pixel_angle, view.eye_m, angle_rad, smallest_m)
        crest = ocean.sea_level_m + view.waves.reach_m[0]
        cells = select_rings(
            proxy.lattice,
            above_sea,
            ocean.sea_level_m,
            radius,
            angle_rad,
            self.quads,
            # As far as the ground is drawn: beyond its horizon the sea still hides the bed behind peaks.
            coverage_rad=proxy_coverage(
                proxy.cell.highest_altitude_m,
                proxy.cell.max_sideways_rad,
                radius,
                max(crest, -np.inf if ground is None else ground.highest_m),
                ground.lowest_m if view.from_below and ground is not None else ocean.sea_level_m,
            ).half_angle_rad,
            min_spacing_m=smallest_m,
            max_cells=_MOST_CELLS,
        )
        changed |= view.mesh.upload(cells, topology(cells))
        return changed

    def declare(self, builder: GraphBuilder, view: ViewInfo, sea: SeaView) -> None:
        mesh, name, moves = sea.mesh, self._name, sea.waves.moves
        seen = planet_seen(self._world, view.index)
        builder.add_pass(
            "ocean.vertices",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_vertices(io, sea, view.index),
            creates=mesh.vertex_buffers(),
            after_optional=("terrain.vertices",),
            when=lambda: sea.made != (mesh.selection, sea.key),
            help="the calm sea's vertices and the depth below them, on a snap of the proxy",
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
            after=("gbuffer.clear",),
            after_optional=("terrain.gbuffer",),
            only_while=seen,
            help="patches of the visible sea",
        )

    def _bind_vertices(self, io: PassIO, sea: SeaView, view_index: int) -> Callable[[], None]:
        sea.mesh.attach_vertices(io)
        sea.made = None

        def run() -> None:
            bind_heights = self._world.resources.get("surface_height")
            if bind_heights is not None:
                bind_heights(view_index)
            self._vertices.set("u_reach", sea.waves.reach_m)
            # Chords of eight edges would cut off the waves that are there to be seen; two of them a pixel's height.
            most = min(self._most, _MOST_SKIPPED) if sea.waves.moves else self._most
            sea.mesh.make_vertices(
                self._vertices, self._measure, self._agree, sea.eye_m, sea.edge_rad, sea.chord_m, most
            )
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
