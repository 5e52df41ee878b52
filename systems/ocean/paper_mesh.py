"""The sea as Michelic (2018) and Michelic et al. (2019) print it: methods "paper_2018" and "paper_2019".

A projected grid of 80 x 80 points at sea level, cut by the size of its squares on screen, displaced by the printed wave
function at each vertex, with the printed normal; pixels get what lies between the vertices. The formulas are the
papers'; the way that they are computed is ours: feet and depths once per snap of the proxy, only patches that are seen,
phases from an anchor in float64. So the two papers' arcs, arccos and arcsin, give the same picture here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...components import Ocean, Planet
from ...engine.frame import Frame, Proxy, ViewParts
from ...engine.frame.gbuffer import GBUFFER
from ...engine.gpu import GpuScope
from ...engine.gpu.bindings import SEA_GRID_BLOCK
from ...engine.gpu.layout import IVec4, Vec4
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.settings import revision
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.projected_grid import FINEST, ProjectedGrid, Tessellation, grid_axes, grid_offset
from ...engine.surface.selection import spacing_angle
from ...engine.system import Setup
from .wave_passes import SeaWaves, WaveView

__all__ = ["PAPER_CORNERS", "PaperSeaPasses", "PaperSeaView"]

PAPER_CORNERS = 80
"""Points a side, as printed."""
_POWER = 4
_CALM_BYTES, _WAVY_BYTES = 16, 20
_MOST_VERTICES = 1 << 20


@dataclass
class SeaGridBlock:
    """GLSL: ``generated/sea_grid.glsl``, ``sea_grid``. The third axis is the anchor's direction."""

    u: Vec4
    """first axis; w: z_s"""
    v: Vec4
    """second axis"""
    spacing: Vec4
    """(wanted angle between vertices, their smallest distance in m, proxy above the sea in m, 1 / half the steps)"""
    sea: Vec4
    """(how far waves move a point in m, 0, 0, 0)"""
    counts: IVec4
    """half the steps a side, n of the warp"""


class PaperSeaView(ViewParts):
    """One view's grid."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.waves = WaveView(self.gpu)
        self.key: tuple[Any, ...] = ()
        self.cut: Tessellation | None = None
        self.selection = 0
        self.made = -1
        self.wanted: tuple[Any, ...] = ()
        self.culled: tuple[Any, ...] | None = None
        self.displaced: tuple[Any, ...] | None = None
        self.patches: Any = None
        self.patch_capacity = 0
        self.vertex_capacity = 1 << 16
        self.triangle_capacity = 1 << 17
        self.buffers: dict[str, Any] = {}
        self.array: Any = None

    @property
    def moving(self) -> tuple[Any, ...]:
        """What the displaced vertices depend on."""
        return (self.made, self.culled, self.waves.moment)


class PaperSeaPasses:
    """Part of OceanSystem: the printed grid and waves into the G-buffer, in place of our mesh and pixels' normals."""

    def __init__(self, name: str, waves: SeaWaves) -> None:
        self._name, self._waves = name, waves

    def setup(self, setup: Setup) -> None:
        self._gpu, self._world = setup.gpu, setup.world
        self._made = False

    def _make(self) -> None:
        """The shaders: most seas never need them."""
        gpu = self._gpu
        many = {"SEA_VERTICES": 5 if gpu.gpu.caps.is_software else 2}
        self._ubo = gpu.uniform_block(SeaGridBlock, SEA_GRID_BLOCK, "sea_grid")
        self._vertices = gpu.compute("ocean/paper/vertices.comp")
        self._cull = gpu.compute("ocean/paper/cull.comp")
        self._arguments = gpu.compute("ocean/paper/arguments.comp", defines=many)
        self._triangles = gpu.compute("ocean/paper/triangles.comp")
        self._displace = gpu.compute("ocean/paper/displace.comp", defines=many)
        self._surface = gpu.program("ocean/paper/gbuffer.vert", "ocean/gbuffer.frag", defines={"SEA_PAPER": 1})
        self._draw_state = gpu.gpu.state(depth_test=True, depth_func=">", cull=None)
        self._made = True

    def view(self) -> PaperSeaView:
        """A view without a grid yet."""
        if not self._made:
            self._make()
        return PaperSeaView(self._gpu)

    def update(self, frame: Frame, view: PaperSeaView) -> bool:
        """Project and cut the grid; True where buffers changed."""
        ocean = frame.world.get(frame.planet, Ocean)
        proxy, camera = frame.view.proxy, frame.camera
        pixel_angle = frame.pixel_rad
        edge_px = float(frame.settings["terrain.edge_px"])
        ground = frame.world.resources.get("height_field")
        key = (proxy.generation, revision(ocean), id(ground), edge_px, pixel_angle)
        changed = False
        held = frame.frozen and key[:3] == view.key[:3]
        if key != view.key and not held:
            view.key = key
            changed = self._project(frame, view, ocean, proxy, pixel_angle, edge_px, ground)
        axes = camera.position_m.tobytes(), camera.forward.tobytes(), camera.up.tobytes()
        if not (held and view.culled == view.wanted):
            view.wanted = (view.selection, axes, camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        self._ubo.bind()
        return changed

    def _project(
        self,
        frame: Frame,
        view: PaperSeaView,
        ocean: Ocean,
        proxy: Proxy,
        pixel_angle: float,
        edge_px: float,
        ground: Any,
    ) -> bool:
        radius = frame.world.get(frame.planet, Planet).radius_m
        above_sea = max(abs(proxy.cell.altitude_m - ocean.sea_level_m), 0.05)
        angle = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, radius)
        eye = tuple(proxy.lattice.direction * (ocean.sea_level_m + above_sea - proxy.anchor_height_m))
        self._waves.place(view.waves, frame, above_sea, pixel_angle, eye, angle, 0.0)
        assert view.waves.waves is not None
        reach_m = view.waves.waves.highest_m
        below = proxy.cell.altitude_m < ocean.sea_level_m
        seen = proxy_coverage(
            proxy.cell.highest_altitude_m,
            proxy.cell.max_sideways_rad,
            radius,
            # No farther than its own horizon: each of the few points counts.
            ocean.sea_level_m + reach_m,
            ground.lowest_m if below and ground is not None else ocean.sea_level_m,
        )
        grid = ProjectedGrid(PAPER_CORNERS, _POWER, grid_offset(seen), grid_axes(proxy.lattice.direction), radius)
        cut = view.cut = grid.tessellate(above_sea, ocean.sea_level_m, angle, _MOST_VERTICES)
        view.selection += 1
        half = grid.steps() // 2
        feet = grid.foot_offsets_m(np.array([half, half + FINEST]), np.array([half, half]))
        axes = grid.axes
        self._ubo.write(
            SeaGridBlock(
                (*(float(a) for a in axes[0]), grid.z_s),
                (*(float(a) for a in axes[1]), 0.0),
                (angle * cut.coarser, float(np.linalg.norm(feet[1] - feet[0])) / FINEST, above_sea, 1.0 / half),
                (reach_m, 0.0, 0.0, 0.0),
                (half, grid.power, 0, 0),
            )
        )
        changed = False
        data = cut.packed()
        if len(cut) != view.patch_capacity:
            if view.patches is not None:
                view.gpu.free(view.patches)
            view.patches, view.patch_capacity = view.gpu.buffer(reserve=data.nbytes, dynamic=True), len(cut)
            changed = True
        view.patches.write(data.tobytes())
        if cut.vertices > view.vertex_capacity or cut.triangles > view.triangle_capacity:
            view.vertex_capacity = max(view.vertex_capacity, cut.vertices * 3 // 2)
            view.triangle_capacity = max(view.triangle_capacity, cut.triangles * 3 // 2)
            changed = True
        return changed

    def declare(self, builder: GraphBuilder, view_index: int, view: PaperSeaView) -> None:
        name = self._name
        builder.add_pass(
            "ocean.vertices",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_vertices(io, view, view_index),
            creates=(
                BufferSpec("ocean.vertices", view.vertex_capacity * _CALM_BYTES, "persistent", "feet and depths"),
            ),
            when=lambda: view.made != view.selection,
            help="places of the printed grid at sea level and the depth below them, on a snap of the proxy",
        )
        builder.add_pass(
            "ocean.cull",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_cull(io, view),
            reads=("ocean.vertices",),
            creates=(
                BufferSpec("ocean.visible", 4 * max(view.patch_capacity, 1), "persistent", "patches, by level"),
                BufferSpec("ocean.counts", 32, "persistent", "visible patches of each level"),
                BufferSpec("ocean.arguments", 48, "persistent", "the indirect draw and the dispatches before it"),
                BufferSpec("ocean.triangles", view.triangle_capacity * 12, "persistent", "indices of what is seen"),
            ),
            when=lambda: view.culled != view.wanted,
            help="triangles of the patches that are not outside the frustum",
        )
        builder.add_pass(
            "ocean.displace",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_displace(io, view),
            reads=("ocean.vertices", "ocean.visible", "ocean.counts", "ocean.arguments"),
            creates=(BufferSpec("ocean.displaced", view.vertex_capacity * _WAVY_BYTES, "persistent", "visible ones"),),
            when=lambda: view.displaced != view.moving,
            help="the printed wave function and normal at each vertex",
        )
        builder.add_pass(
            "ocean.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, view),
            reads=("ocean.displaced", "ocean.arguments", "ocean.triangles"),
            creates=(TextureSpec("ocean.rough", "rgba16f", help="variances of slopes, mixed; Jacobian"),),
            writes=("gbuffer.depth", *GBUFFER),
            stage="water",
            help="triangles of the visible sea",
        )

    def _levels(self, view: PaperSeaView) -> Any:
        assert view.cut is not None
        return view.cut.by_level()

    def _bind_vertices(self, io: PassIO, view: PaperSeaView, index: int) -> Callable[[], None]:
        vertices = io.buffer("ocean.vertices")
        view.made = -1

        def run() -> None:
            assert view.cut is not None
            bind_heights = self._world.resources.get("surface_height")
            if bind_heights is not None:
                bind_heights(index)
            view.patches.bind_to_storage_buffer(0)
            vertices.bind_to_storage_buffer(1)
            self._vertices.set("u_count", view.cut.vertices)
            self._vertices.set("u_patches", self._levels(view))
            self._vertices.run(-(-view.cut.vertices // 64), 1, 1)
            view.made = view.selection

        return run

    def _bind_cull(self, io: PassIO, view: PaperSeaView) -> Callable[[], None]:
        visible, counts, arguments, triangles = (
            io.buffer(f"ocean.{n}") for n in ("visible", "counts", "arguments", "triangles")
        )
        view.culled = None

        def run() -> None:
            assert view.cut is not None
            levels, barrier = self._levels(view), self._gpu.gpu.barrier
            counts.write(bytes(32))
            view.patches.bind_to_storage_buffer(0)
            visible.bind_to_storage_buffer(2)
            counts.bind_to_storage_buffer(3)
            self._cull.set("u_count", len(view.cut))
            self._cull.set("u_patches", levels)
            self._cull.run(-(-len(view.cut) // 64), 1, 1)
            barrier()
            arguments.bind_to_storage_buffer(4)
            self._arguments.run(1, 1, 1)
            barrier()
            triangles.bind_to_storage_buffer(6)
            self._triangles.set("u_patches", levels)
            self._triangles.run_indirect(arguments, 20)
            view.culled = view.wanted

        return run

    def _bind_displace(self, io: PassIO, view: PaperSeaView) -> Callable[[], None]:
        names = ("vertices", "visible", "counts", "arguments", "displaced")
        vertices, visible, counts, arguments, displaced = (io.buffer(f"ocean.{n}") for n in names)
        view.displaced = None

        def run() -> None:
            for point, buffer in enumerate((view.patches, vertices, visible, counts)):
                buffer.bind_to_storage_buffer(point)
            displaced.bind_to_storage_buffer(5)
            self._displace.set("u_patches", self._levels(view))
            self._displace.run_indirect(arguments, 32)
            view.displaced = view.moving

        return run

    def _bind_gbuffer(self, io: PassIO, view: PaperSeaView) -> Callable[[], None]:
        target = io.framebuffer(colors=(*GBUFFER, "ocean.rough"), depth="gbuffer.depth")
        rough = io.framebuffer(colors=("ocean.rough",))
        displaced, arguments = io.buffer("ocean.displaced"), io.buffer("ocean.arguments")
        if view.array is not None:
            view.gpu.free(view.array)
        view.array = view.gpu.vertex_array(self._surface, index=io.buffer("ocean.triangles"), index_size=4)

        def run() -> None:
            assert view.waves.waves is not None
            variance = view.waves.waves.slope_variance_beyond
            # For pixels that the coast's own pass turns into sea.
            rough.clear(0.5 * variance, 0.5 * variance, 0.0, 1.0)
            target.use()
            self._draw_state.apply()
            displaced.bind_to_storage_buffer(1)
            self._surface.set("u_variance", variance)
            view.array.render_indirect(arguments, count=1)

        return run

    def statistics(self, view: PaperSeaView) -> dict[str, int]:
        """Patches and vertices of the grid."""
        return {} if view.cut is None else {"patches": len(view.cut), "vertices": view.cut.vertices}
