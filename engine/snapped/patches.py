"""PatchMesh: a printed projected grid around a view's proxy, cut into patches by their size on screen; ground and sea.

Vertices are made at a snap, all of them at once; a frame in which the camera moves lists the triangles of what is seen.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable

from moderngl import Buffer

from ..blocks.bindings import (
    COUNT_BUFFER,
    INDEX_BUFFER,
    PATCH_ARGUMENTS_BUFFER,
    PATCH_BUFFER,
    VERTEX_BUFFER,
    VISIBLE_BUFFER,
)
from ..frame import Frame, ViewParts
from ..gpu import GpuScope
from ..gpu.preprocess import Defines
from ..graph import BufferSpec, GraphBuilder, PassIO
from ..surface.projected_grid import Tessellation
from .choice import MeshKey, PatchDetail, PatchesShown

__all__ = ["PatchMesh", "PatchPrograms"]

_CULL_BUFFERS = ("visible", "counts", "arguments", "triangles")


class PatchPrograms:
    """Files of compute shaders, shared by all views: of the vertices, which patches are seen, the arguments of draws
    and dispatches (with `defines`), and the triangles."""

    def __init__(
        self, gpu: GpuScope, vertices: str, cull: str, arguments: str, triangles: str, defines: Defines | None = None
    ) -> None:
        self.vertices, self.cull, self.triangles = (gpu.compute(file) for file in (vertices, cull, triangles))
        self.arguments = gpu.compute(arguments, defines)


class PatchMesh(ViewParts):
    """One view's. name: of buffers and passes. vertex_bytes: of one vertex; argument_bytes: of all arguments."""

    def __init__(
        self, of: GpuScope, name: str, programs: PatchPrograms, vertex_bytes: int, argument_bytes: int
    ) -> None:
        super().__init__(of)
        self.name, self._programs = name, programs
        self._vertex_bytes, self._argument_bytes = vertex_bytes, argument_bytes
        self.key: MeshKey | None = None
        self._detail: PatchDetail | None = None
        self._held = False
        self.cut: Tessellation | None = None
        self.selection = 0
        self.made = -1
        self._wanted: PatchesShown | None = None
        self.culled: PatchesShown | None = None
        self.patches: Buffer
        """Of patch words."""
        self.patch_capacity, self.vertex_capacity, self.triangle_capacity = 0, 1 << 16, 1 << 17
        self.buffers: dict[str, Buffer] = {}
        """Those of the graph, by the last part of their names."""

    @abstractmethod
    def surface(self, frame: Frame) -> tuple[object, ...]:
        """What the grid depends on beside proxy and detail."""

    @abstractmethod
    def detail(self, frame: Frame) -> PatchDetail:
        """How fine it is cut."""

    def _asked(self, frame: Frame) -> tuple[MeshKey, PatchDetail]:
        return MeshKey(frame.view.proxy.generation, self.surface(frame)), self.detail(frame)

    def rests(self, frame: Frame) -> bool:
        """Whether the grid is the one for that frame, vertices and all."""
        return self.made == self.selection and (self.key, self._detail) == self._asked(frame)

    def follow(self, frame: Frame) -> bool:
        """Whether the grid is to be projected anew: for another key, and unless it is frozen, another detail."""
        key, detail = self._asked(frame)
        self._held = frame.frozen and key == self.key
        if self._held or (key, detail) == (self.key, self._detail):
            return False
        self.key, self._detail = key, detail
        return True

    def take(self, cut: Tessellation) -> bool:
        """Upload the patches. True where buffers of the graph changed."""
        self.cut, data, changed = cut, cut.packed(), False
        self.selection += 1
        if len(cut) != self.patch_capacity:
            if self.patch_capacity:
                self.gpu.free(self.patches)
            self.patches, self.patch_capacity = self.gpu.buffer(reserve=data.nbytes, dynamic=True), len(cut)
            changed = True
        self.patches.write(data.tobytes())
        if cut.vertices > self.vertex_capacity or cut.triangles > self.triangle_capacity:
            self.vertex_capacity = max(self.vertex_capacity, cut.vertices * 3 // 2)
            self.triangle_capacity = max(self.triangle_capacity, cut.triangles * 3 // 2)
            changed = True
        return changed

    def look(self, frame: Frame) -> None:
        """What may be seen in this frame; while it is frozen, what could be seen before."""
        if frame.view.seen.ground() and not (self._held and self.culled == self._wanted):
            self._wanted = PatchesShown(self.selection, frame.camera.stamp)

    def declare(self, builder: GraphBuilder, system: str, bind_heights: Callable[[], object]) -> None:
        """The passes up to the indirect draw. bind_heights: binds what the height function reads."""
        name, size = self.name, self.vertex_capacity * self._vertex_bytes
        builder.add_pass(
            f"{name}.vertices",
            kind="compute",
            system=system,
            bind=lambda io: self._bind_vertices(io, bind_heights),
            creates=(BufferSpec(f"{name}.vertices", size, "persistent", "of all patches"),),
            when=lambda: self.made != self.selection,
            help="what the printed grid has at the vertices of all patches, on a snap of the proxy",
        )
        builder.add_pass(
            f"{name}.cull",
            kind="compute",
            system=system,
            bind=self._bind_cull,
            reads=(f"{name}.vertices",),
            creates=(
                BufferSpec(f"{name}.visible", 4 * max(self.patch_capacity, 1), "persistent", "patches, by level"),
                BufferSpec(f"{name}.counts", 32, "persistent", "visible patches of each level"),
                BufferSpec(f"{name}.arguments", self._argument_bytes, "persistent", "the indirect draw and dispatches"),
                BufferSpec(f"{name}.triangles", self.triangle_capacity * 12, "persistent", "indices of what is seen"),
            ),
            when=lambda: self.culled != self._wanted,
            help="triangles of the patches that are not outside the frustum",
        )

    def _attach(self, io: PassIO, names: tuple[str, ...]) -> bool:
        """Take the plan's buffers. True where they are others than before: empty ones."""
        before = [self.buffers.get(n) for n in names]
        self.buffers |= {n: io.buffer(f"{self.name}.{n}") for n in names}
        return before != [self.buffers[n] for n in names]

    def _bind_vertices(self, io: PassIO, bind_heights: Callable[[], object]) -> Callable[[], None]:
        if self._attach(io, ("vertices",)):
            self.made = -1
        made = self.buffers["vertices"]

        def run() -> None:
            cut, vertices = self.cut, self._programs.vertices
            assert cut is not None
            bind_heights()
            self.patches.bind_to_storage_buffer(PATCH_BUFFER)
            made.bind_to_storage_buffer(VERTEX_BUFFER)
            vertices.set("u_count", cut.vertices)
            vertices.set("u_patches", cut.by_level())
            vertices.run(-(-cut.vertices // 64), 1, 1)
            self.made = self.selection

        return run

    def _bind_cull(self, io: PassIO) -> Callable[[], None]:
        if self._attach(io, _CULL_BUFFERS):
            self.culled = None
        visible, counts, arguments, triangles = (self.buffers[n] for n in _CULL_BUFFERS)

        def run() -> None:
            cut, programs, barrier = self.cut, self._programs, self.gpu.barrier
            assert cut is not None
            levels = cut.by_level()
            counts.write(bytes(32))
            self.patches.bind_to_storage_buffer(PATCH_BUFFER)
            visible.bind_to_storage_buffer(VISIBLE_BUFFER)
            counts.bind_to_storage_buffer(COUNT_BUFFER)
            programs.cull.set("u_count", len(cut))
            programs.cull.set("u_patches", levels)
            programs.cull.run(-(-len(cut) // 64), 1, 1)
            barrier()
            arguments.bind_to_storage_buffer(PATCH_ARGUMENTS_BUFFER)
            programs.arguments.run(1, 1, 1)
            barrier()
            triangles.bind_to_storage_buffer(INDEX_BUFFER)
            programs.triangles.set("u_patches", levels)
            programs.triangles.run_indirect(arguments, 20)
            self.culled = self._wanted

        return run
