"""OurSea: the sea by our method, cells of the lattice at sea level, moved by waves, into the G-buffer."""

from __future__ import annotations

from collections.abc import Callable

from ...engine.blocks.bindings import MOVED_CELLS_BUFFER
from ...engine.frame import Frame, View, ViewInfo
from ...engine.frame.gbuffer import GBUFFER
from ...engine.gpu import GpuScope
from ...engine.gpu.cell_mesh import VERTEX_DTYPE
from ...engine.graph import BufferSpec, GraphBuilder, PassIO, TextureSpec
from ...engine.system import Setup
from .mesh import SeaMaking, SeaMesh
from .method import SeaMethod
from .wave_passes import SeaWaves

__all__ = ["OurSea"]


class OurSea(SeaMethod):
    """Draws the cells displaced where that can be seen; waves are shaded pixel by pixel."""

    def __init__(self, gpu: GpuScope, setup: Setup, waves: SeaWaves) -> None:
        super().__init__(gpu, setup, waves)
        self._making = SeaMaking(gpu, setup.settings, setup.world, waves)
        defines = self._making.programs.defines
        # Fetching a wave costs as much as evaluating it where lanes can't share the fetch.
        each = 5 if gpu.caps.is_software else 2
        self._displace = gpu.compute("ocean/displace.comp", defines={**defines, "SEA_VERTICES": each})
        calm, moving = defines, {**defines, "SEA_MOVES": 1}
        self._surfaces = [
            gpu.program(vertex="ocean/gbuffer.vert", fragment="ocean/gbuffer.frag", defines=d) for d in (calm, moving)
        ]
        # Seen from above and, under water, from below.
        self._draw_state = gpu.state(depth_test=True, depth_func=">", cull=None)

    def view(self, view: View) -> SeaMesh:
        """One view's cells."""
        return view.state(self, lambda: SeaMesh(self.gpu, self._making, view))

    def update(self, frame: Frame) -> None:
        frame.view.structure += self.view(frame.view).update(frame)

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        sea = self.view(view.view)
        mesh, name, moves = sea.mesh, self.gpu.owner, sea.waves.moves
        seen = view.view.seen.ground
        sea.declare(builder, name)
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
        self.waves.declare(builder, view, sea.waves)

    def statistics(self) -> dict[str, int]:
        sea: SeaMesh | None = self.views[0].found(self)
        return {} if sea is None else sea.mesh.statistics()

    def _bind_displace(self, io: PassIO, sea: SeaMesh) -> Callable[[], None]:
        cells, displaced = io.buffer("ocean.cells"), io.buffer("ocean.displaced")
        sea.displaced = None

        def run() -> None:
            sea.mesh.bind_made()
            displaced.bind_to_storage_buffer(3)
            cells.bind_to_storage_buffer(MOVED_CELLS_BUFFER)
            self._displace.run_indirect(cells)
            sea.displaced = sea.moving

        return run

    def _bind_gbuffer(self, io: PassIO, sea: SeaMesh) -> Callable[[], None]:
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
