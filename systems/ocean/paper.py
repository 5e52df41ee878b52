"""The sea as Michelic (2018) and Michelic et al. (2019) print it: methods "paper_2018" and "paper_2019".

A projected grid of 80 x 80 points at sea level, cut by the size of its squares on screen, displaced by the printed wave
function at each vertex, with the printed normal; pixels get what lies between the vertices. The formulas are the
papers'; the way that they are computed is ours: feet and depths once per snap of the proxy, only patches that are seen,
phases from an anchor in float64. So the two papers' arcs, arccos and arcsin, give the same picture here, unless
`Ocean.printed_arcs` has them evaluated as they stand, in single precision.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from ...components import Ocean, Planet
from ...engine.blocks.bindings import COUNT_BUFFER, PATCH_BUFFER, SEA_GRID_BLOCK, VERTEX_BUFFER, VISIBLE_BUFFER
from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.gbuffer import GBUFFER
from ...engine.frame.published import HEIGHT_FIELD, SURFACE_HEIGHT
from ...engine.gpu import GpuScope
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.snapped import PatchDetail, PatchMesh, PatchPrograms
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.projected_grid import FINEST, GridBlock, ProjectedGrid, grid_axes, grid_offset
from ...engine.surface.selection import spacing_angle
from ...engine.system import Setup
from .method import Displaced, SeaMethod, SeaSurface
from .wave_passes import SeaWaves, WaveView
from .wave_record import MOST_RECORD_BYTES, RecordPacker, fade_lengths

__all__ = ["PAPER_CORNERS", "PaperSea"]

PAPER_CORNERS = 80
"""Points a side, as printed."""
_POWER = 4
_CALM_BYTES, _WAVY_BYTES = 16, 20
_MOST_VERTICES = 1 << 20


@dataclass
class SeaGridBlock(GridBlock):
    """GLSL: ``generated/sea_grid.glsl``, ``sea_grid``."""

    reach_m: Annotated[float, "how far waves move a point"]


class PaperSeaView(PatchMesh):
    """One view's grid."""

    def __init__(self, of: GpuScope, programs: PatchPrograms, printed: bool) -> None:
        super().__init__(of, "ocean", programs, _CALM_BYTES, 48)
        self.ubo = self.gpu.uniform_block(SeaGridBlock, SEA_GRID_BLOCK)
        self.packer = RecordPacker(printed)
        self.waves = WaveView(self.gpu, self.packer)
        self.records = self.gpu.buffer(reserve=MOST_RECORD_BYTES, dynamic=True)
        self.displaced: Displaced | None = None
        self.array: Any = None

    def surface(self, frame: Frame) -> SeaSurface:
        return SeaSurface.of(frame)

    def detail(self, frame: Frame) -> PatchDetail:
        return PatchDetail(float(frame.settings["terrain.edge_px"]), frame.pixel_rad, PAPER_CORNERS, _POWER)

    @property
    def moving(self) -> Displaced:
        """What the displaced vertices depend on."""
        return Displaced(self.made, self.culled, self.waves.moment)


class PaperSea(SeaMethod):
    """The printed grid and waves into the G-buffer, in place of our mesh and pixels' normals.

    arc: 2018 or 2019, whose arc is evaluated as printed; 0: phases from an anchor."""

    def __init__(self, gpu: GpuScope, setup: Setup, waves: SeaWaves, arc: int = 0) -> None:
        super().__init__(gpu, setup, waves)
        self.arc = arc
        many = {"SEA_VERTICES": 5 if gpu.caps.is_software else 2}
        gpu.uniform_block(SeaGridBlock, SEA_GRID_BLOCK, "sea_grid")  # its text, for shaders; each view has its own
        self._patches = PatchPrograms(
            gpu,
            "ocean/paper/vertices.comp",
            "ocean/paper/cull.comp",
            "ocean/paper/arguments.comp",
            "ocean/paper/triangles.comp",
            many,
        )
        self._displace = gpu.compute("ocean/paper/displace.comp", defines=many | ({"PAPER_ARC": arc} if arc else {}))
        self._surface = gpu.program("ocean/paper/gbuffer.vert", "ocean/gbuffer.frag", defines={"SEA_PAPER": 1})
        self._draw_state = gpu.state(depth_test=True, depth_func=">", cull=None)

    def view(self, view: View) -> PaperSeaView:
        """One view's grid."""
        return view.state(self, lambda: PaperSeaView(self.gpu, self._patches, bool(self.arc)))

    def update(self, frame: Frame) -> None:
        view = self.view(frame.view)
        if view.follow(frame):
            frame.view.structure += self._project(frame, view)
        view.look(frame)
        view.ubo.bind()

    def _project(self, frame: Frame, view: PaperSeaView) -> bool:
        ocean, radius = frame.world.get(frame.planet, Ocean), frame.world.get(frame.planet, Planet).radius_m
        proxy, ground = frame.view.proxy, frame.world.try_resource(HEIGHT_FIELD)
        edge_px, pixel_rad, corners, power = view.detail(frame)
        above_sea = max(abs(proxy.cell.altitude_m - ocean.sea_level_m), 0.05)
        angle = spacing_angle(edge_px, pixel_rad, proxy.cell.altitude_m, radius)
        eye = tuple(proxy.lattice.direction * (ocean.sea_level_m + above_sea - proxy.anchor_height_m))
        self.waves.place(view.waves, frame, above_sea, pixel_rad, eye, angle, 0.0)
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
        grid = ProjectedGrid(corners, power, grid_offset(seen), grid_axes(proxy.lattice.direction), radius)
        cut = grid.tessellate(above_sea, ocean.sea_level_m, angle, _MOST_VERTICES)
        half = grid.steps() // 2
        feet = grid.foot_offsets_m(np.array([half, half + FINEST]), np.array([half, half]))
        view.ubo.write(
            SeaGridBlock(
                first_axis=tuple(grid.axes[0].tolist()),
                z_s=grid.z_s,
                second_axis=tuple(grid.axes[1].tolist()),
                third_axis=tuple(grid.axes[2].tolist()),
                middle_m=(0.0, 0.0, 0.0),
                per_half=1.0 / half,
                spacing_rad=angle * cut.coarser,
                smallest_spacing_m=float(np.linalg.norm(feet[1] - feet[0])) / FINEST,
                proxy_height_m=above_sea,
                half_steps=half,
                power=grid.power,
                reach_m=reach_m,
            )
        )
        return view.take(cut)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        name, sea, seen = self.gpu.owner, self.view(view.view), view.view.seen.ground
        sea.declare(builder, name, lambda: self._bind_heights(view.view))
        builder.add_pass(
            "ocean.displace",
            kind="compute",
            system=name,
            bind=lambda io: self._bind_displace(io, sea),
            reads=("ocean.vertices", "ocean.visible", "ocean.counts", "ocean.arguments"),
            creates=(BufferSpec("ocean.displaced", sea.vertex_capacity * _WAVY_BYTES, "persistent", "visible ones"),),
            when=lambda: sea.displaced != sea.moving,
            only_while=seen,
            help="the printed wave function and normal at each vertex",
        )
        builder.add_pass(
            "ocean.gbuffer",
            system=name,
            bind=lambda io: self._bind_gbuffer(io, sea),
            reads=("ocean.displaced", "ocean.arguments", "ocean.triangles"),
            creates=(TextureSpec("ocean.rough", "rgba16f", help="variances of slopes, mixed; Jacobian"),),
            writes=("gbuffer.depth", *GBUFFER),
            stage="water",
            only_while=seen,
            help="triangles of the visible sea",
        )

    def _bind_heights(self, view: View) -> None:
        bind = self.world.try_resource(SURFACE_HEIGHT)
        if bind is not None:
            bind(view)

    def _bind_displace(self, io: PassIO, view: PaperSeaView) -> Callable[[], None]:
        names = ("vertices", "visible", "counts", "arguments", "displaced")
        vertices, visible, counts, arguments, displaced = (io.buffer(f"ocean.{n}") for n in names)
        view.displaced = None

        def run() -> None:
            assert view.cut is not None
            view.patches.bind_to_storage_buffer(PATCH_BUFFER)
            vertices.bind_to_storage_buffer(VERTEX_BUFFER)
            visible.bind_to_storage_buffer(VISIBLE_BUFFER)
            counts.bind_to_storage_buffer(COUNT_BUFFER)
            displaced.bind_to_storage_buffer(5)
            if len(view.packer.records):
                view.gpu.upload(view.records, view.packer.records.tobytes())
            view.records.bind_to_storage_buffer(6)
            assert view.waves.waves is not None and view.waves.moment is not None
            self._displace.set("u_fade", fade_lengths(view.waves.waves))
            if self.arc:
                self._displace.set("u_time_s", view.waves.moment.time_s)
            self._displace.set("u_patches", view.cut.by_level())
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
            displaced.bind_to_storage_buffer(VERTEX_BUFFER)
            self._surface.set("u_variance", variance)
            view.array.render_indirect(arguments, count=1)

        return run

    def statistics(self) -> dict[str, int]:
        view: PaperSeaView | None = self.views[0].found(self)
        return {} if view is None or view.cut is None else {"patches": len(view.cut), "vertices": view.cut.vertices}
