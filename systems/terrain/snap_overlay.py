"""Debug view: the ground's mesh before and after the last snap, one over the other (Michelic 2018, figure 15).

Red edges were there before, green ones are there now, yellow ones both. Costs a read-back at each snap, and nothing
unless somebody looks.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.frame import View, ViewParts
from ...engine.gpu import GpuScope
from ...engine.graph import GraphBuilder, PassIO, TextureSpec
from .backends import Backend

__all__ = ["SnapOverlay"]

_BEFORE, _AFTER = (1.0, 0.0, 0.0), (0.0, 0.9, 0.0)


@dataclass
class _Mesh:
    stamp: object
    array: Any
    buffers: tuple[Any, Any]
    anchor_m: NDArray[np.float64]


class _Kept(ViewParts):
    """Of one view: the mesh after the last snap, and the one before."""

    def __init__(self, of: GpuScope) -> None:
        super().__init__(of)
        self.meshes: list[_Mesh] = []

    def free(self, mesh: _Mesh) -> None:
        for part in (mesh.array, *mesh.buffers):
            self.gpu.free(part)


class SnapOverlay:
    """Declares ``debug.snap_overlay``. gpu: the terrain's scope."""

    def __init__(self, gpu: GpuScope) -> None:
        self._gpu = gpu
        self._lines: Any = None

    def declare(self, builder: GraphBuilder, backend: Backend, view: View) -> None:
        builder.add_pass(
            "terrain.snap_overlay",
            system="terrain",
            bind=lambda io: self._bind(io, backend, view),
            reads=backend.draw_reads(view),
            creates=(TextureSpec("debug.snap_overlay", "rgba8"), TextureSpec("debug.snap_depth", "depth32f")),
            help="the mesh before the last snap in red and after it in green",
        )

    def _bind(self, io: PassIO, backend: Backend, view: View) -> Callable[[], None]:
        if self._lines is None:
            self._lines = self._gpu.program(vertex="terrain/snap_overlay.vert", fragment="terrain/snap_overlay.frag")
        target = io.framebuffer(colors=("debug.snap_overlay",), depth="debug.snap_depth")
        solid = self._gpu.state(depth_test=True, depth_func=">=", write_color=False)
        lines = self._gpu.state(depth_test=True, depth_func=">=", wireframe=True, blend="additive", write_depth=False)
        draw = backend.bind_draw(io, view, "terrain/wireframe.frag")

        def run() -> None:
            anchor_m = view.proxy.anchor_m
            meshes = self._refresh(backend, view, anchor_m)
            target.use()
            target.clear(0.02, 0.02, 0.03, 1.0, depth=0.0)
            solid.apply()
            draw()
            lines.apply()
            for mesh, color in zip(meshes, (_AFTER, _BEFORE), strict=False):
                self._lines.set("u_shift", tuple(float(v) for v in mesh.anchor_m - anchor_m))
                self._lines.set("u_color", color)
                mesh.array.render()

        return run

    def _refresh(self, backend: Backend, view: View, anchor_m: NDArray[np.float64]) -> list[_Mesh]:
        """The mesh of this frame and the one before it, of the same backend."""
        kept = view.state(self, lambda: _Kept(self._gpu))
        meshes, gpu = kept.meshes, kept.gpu
        stamp = (backend, backend.mesh_stamp(view))
        if meshes and meshes[0].stamp == stamp:
            return meshes
        if meshes and meshes[0].stamp[0] is not backend:  # type: ignore[index]
            while meshes:
                kept.free(meshes.pop())
        found = backend.read_mesh(view)
        if found is None:
            return meshes
        positions, triangles = found
        vertices = gpu.buffer(positions.astype("<f4").tobytes())
        indices = gpu.buffer(triangles.astype("<u4").tobytes())
        array = gpu.vertex_array(self._lines, [(vertices, "3f", "in_position")], index=indices)
        meshes.insert(0, _Mesh(stamp, array, (vertices, indices), anchor_m.copy()))
        while len(meshes) > 2:
            kept.free(meshes.pop())
        return meshes
