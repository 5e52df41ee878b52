"""OceanSystem: a smooth sea at one level, drawn on cells of its own (shading.py lights it)."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...components import Ocean, Planet
from ...engine.gpu.cell_mesh import CellMesh
from ...engine.graph import GraphBuilder, PassIO
from ...engine.settings import revision
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.decimation import topology
from ...engine.surface.selection import chord_limit_m, select_rings, spacing_angle
from ...engine.system import Frame, Setup, System, ViewInfo
from .shading import GBUFFER, SeaShading

_MOST_CELLS = 12000  # as for the ground
_WATER_ONLY = (-1.0e29, 3.0e38)  # ocean/vertices.comp marks cells without water


class _SeaView:
    """One view's cells and what they were made for."""

    def __init__(self, mesh: CellMesh) -> None:
        self.mesh = mesh
        self.key: tuple[Any, ...] = ()
        self.made: tuple[Any, ...] | None = None
        self.wanted: tuple[Any, ...] = ()
        self.culled: tuple[Any, ...] | None = None
        self.eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
        self.edge_rad = 0.01
        self.chord_m = 1.0
        self.from_below = False


class OceanSystem(System):
    """The sea of one planet. Needs Planet and Ocean."""

    name = "ocean"
    needs = (Planet, Ocean)

    def __init__(self) -> None:
        self._views: dict[int, _SeaView] = {}
        self._shading = SeaShading(self.name)

    def setup(self, setup: Setup) -> None:
        self._gpu = setup.gpu
        self._world = setup.world
        self._quads = int(setup.settings["terrain.quads"])
        defines = {"QUADS_LOG2": self._quads.bit_length() - 1}
        self._shading.setup(setup)
        self._vertices = setup.gpu.compute("ocean/vertices.comp", defines=defines)
        self._measure = setup.gpu.compute("common/measure_cells.comp", defines=defines)
        self._agree = setup.gpu.compute("common/agree_cells.comp", defines=defines)
        self._most = int(setup.settings["terrain.decimation"])
        self._cull = setup.gpu.compute("common/cull_cells.comp", defines=defines)
        self._surface = setup.gpu.program(vertex="ocean/gbuffer.vert", fragment="ocean/gbuffer.frag", defines=defines)
        # Seen from above and, under water, from below.
        self._draw_state = setup.gpu.gpu.state(depth_test=True, depth_func=">", cull=None)

    def release(self) -> None:
        self._views.clear()

    def _view(self, index: int) -> _SeaView:
        view = self._views.get(index)
        if view is None:
            view = self._views[index] = _SeaView(CellMesh(self._gpu, self.name, self._quads))
        return view

    def update(self, frame: Frame) -> None:
        ocean = frame.world.get(frame.planet, Ocean)
        radius = frame.world.get(frame.planet, Planet).radius_m
        proxy = frame.world.resource(f"proxy.{frame.view_index}")
        view = self._view(frame.view_index)
        camera = frame.camera
        pixel_angle = (camera.tan_top - camera.tan_bottom) / frame.size[1]
        edge_px = float(frame.settings["terrain.edge_px"])
        ground = frame.world.resources.get("height_field")
        # From below the surface is seen until the line of sight, which the bed may bend, has come up to it.
        view.from_below = float(np.linalg.norm(camera.position_m)) - radius < ocean.sea_level_m
        key = (proxy.generation, revision(ocean), edge_px, pixel_angle, id(ground), view.from_below)
        if key != view.key:
            view.key = key
            # At the limb chords of the sea must not hang below the bed, which has the same lattice.
            view.chord_m = 0.05 * chord_limit_m(pixel_angle, radius)
            angle_rad = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, radius)
            above_sea = max(abs(proxy.cell.altitude_m - ocean.sea_level_m), 0.05)
            cells = select_rings(
                proxy.lattice,
                above_sea,
                ocean.sea_level_m,
                radius,
                angle_rad,
                self._quads,
                # As far as the ground is drawn: beyond its horizon the sea still hides the bed behind peaks.
                coverage_rad=proxy_coverage(
                    proxy.cell.highest_altitude_m,
                    proxy.cell.max_sideways_rad,
                    radius,
                    max(ocean.sea_level_m, -np.inf if ground is None else ground.highest_m),
                    ground.lowest_m if view.from_below and ground is not None else ocean.sea_level_m,
                ).half_angle_rad,
                min_spacing_m=float(frame.settings["terrain.min_spacing_m"]),
                max_cells=_MOST_CELLS,
            )
            height = ocean.sea_level_m + above_sea - proxy.anchor_height_m
            view.eye_m, view.edge_rad = tuple(proxy.lattice.direction * height), angle_rad
            if view.mesh.upload(cells, topology(cells)):
                self.structure += 1
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        view.wanted = (view.mesh.selection, axes, camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        self._shading.update(frame)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        sea = self._view(view.index)
        mesh, name = sea.mesh, self.name
        builder.add_pass(
            "ocean.vertices",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_vertices(io, sea, view.index),
            creates=mesh.vertex_buffers(),
            after_optional=("terrain.vertices",),
            when=lambda: sea.made != (mesh.selection, sea.key),
            help="the sea's vertices and the depth below them, on a snap of the proxy",
        )
        builder.add_pass(
            "ocean.cull",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_cull(io, sea),
            reads=("ocean.bounds",),
            creates=mesh.cull_buffers(),
            when=lambda: sea.culled != sea.wanted,
            help="cells of the sea that can be seen",
        )
        builder.add_pass(
            "ocean.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, sea),
            reads=("ocean.vertices", "ocean.visible", "ocean.arguments"),
            writes=("gbuffer.depth", *GBUFFER),
            after=("gbuffer.clear",),
            after_optional=("terrain.gbuffer",),
            help="patches of the visible sea",
        )
        self._shading.declare(builder, view)

    def _bind_vertices(self, io: PassIO, sea: _SeaView, view_index: int) -> Callable[[], None]:
        sea.mesh.attach_vertices(io)
        sea.made = None

        def run() -> None:
            bind_heights = self._world.resources.get("surface_height")
            if bind_heights is not None:
                bind_heights(view_index)
            sea.mesh.make_vertices(
                self._vertices, self._measure, self._agree, sea.eye_m, sea.edge_rad, sea.chord_m, self._most
            )
            sea.made = (sea.mesh.selection, sea.key)

        return run

    def _bind_cull(self, io: PassIO, sea: _SeaView) -> Callable[[], None]:
        sea.mesh.attach_visible(io)
        sea.culled = None

        def run() -> None:
            sea.mesh.cull(self._cull, _WATER_ONLY, hides=not sea.from_below)
            sea.culled = sea.wanted

        return run

    def _bind_gbuffer(self, io: PassIO, sea: _SeaView) -> Callable[[], None]:
        target = io.framebuffer(colors=GBUFFER, depth="gbuffer.depth")
        patches = sea.mesh.vertex_array(self._surface)

        def run() -> None:
            target.use()
            self._draw_state.apply()
            sea.mesh.draw(patches)

        return run

    def statistics(self) -> dict[str, int]:
        sea = self._views.get(0)
        return {} if sea is None else sea.mesh.statistics()
