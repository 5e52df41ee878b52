"""The frame graph's OpenGL backend."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeVar

import moderngl

from ..graph.backend import BarrierKind
from . import gl as G
from .textures import texture_bytes
from .timers import GpuTimers

if TYPE_CHECKING:
    from ..graph.resources import BufferSpec, TextureSpec
    from .scope import GpuScope
    from .touching import CommandWatch

__all__ = ["BARRIERS", "GLBackend"]

BARRIERS = "PLANETFALL_BARRIERS"
"""Environment variable: "all" puts a barrier before every pass, to see whether one is missing."""

T = TypeVar("T", bound="moderngl.Texture | moderngl.Buffer | moderngl.Framebuffer")

# Texture fetch, image access, pixel buffer, texture update, framebuffer.
_TEXTURE_BITS = 0x08 | 0x20 | 0x80 | 0x100 | 0x400
# Vertex, index, uniform, indirect command, pixel buffer, buffer update, storage.
_BUFFER_BITS = 0x01 | 0x02 | 0x04 | 0x40 | 0x80 | 0x200 | 0x2000
_BITS = {0: 0, BarrierKind.TEXTURE: _TEXTURE_BITS, BarrierKind.BUFFER: _BUFFER_BITS,
         BarrierKind.TEXTURE | BarrierKind.BUFFER: _TEXTURE_BITS | _BUFFER_BITS}  # fmt: skip


class GLBackend:
    """Implements engine.graph's GraphBackend on a scope: what the graph owns is counted under the scope's owner."""

    def __init__(self, scope: GpuScope) -> None:
        self.scope = scope
        self._gpu = scope.gpu
        self.barriers_everywhere = os.environ.get(BARRIERS, "").strip().lower() == "all"
        self._memory_barrier = self._gpu.gl.function("glMemoryBarrier", None, G.bitfield)

    @property
    def max_texture_size(self) -> int:
        """GL_MAX_TEXTURE_SIZE in texels."""
        return self._gpu.caps.max_texture_size

    def create_texture(self, spec: TextureSpec, size: tuple[int, ...]) -> moderngl.Texture:
        """moderngl's texture of that spec; FormatError beyond the GPU's limits."""
        levels = spec.levels_for(size)
        made = self.scope.texture(
            size, spec.format, levels=levels, layers=spec.layers, filter=spec.filter, wrap=spec.wrap
        )
        self._label(made, spec.name)
        return self._followed(made)

    def create_buffer(self, spec: BufferSpec) -> moderngl.Buffer:
        """moderngl's buffer of that size."""
        made = self.scope.buffer(reserve=spec.size_bytes, dynamic=True)
        self._label(made, spec.name)
        return self._followed(made)

    def framebuffer(self, colors: Sequence[moderngl.Texture], depth: moderngl.Texture | None) -> moderngl.Framebuffer:
        """A framebuffer on textures made here."""
        return self._followed(self.scope.framebuffer(colors, depth))

    def release(self, obj: moderngl.Texture | moderngl.Buffer | moderngl.Framebuffer) -> None:
        """Free a texture, buffer or framebuffer."""
        self.scope.free(obj)

    def bytes_of(self, obj: moderngl.Texture | moderngl.Buffer) -> int:
        """Bytes of a texture (all levels and layers) or buffer."""
        return obj.size if isinstance(obj, moderngl.Buffer) else texture_bytes(obj)

    def barrier(self, kinds: int) -> None:
        """glMemoryBarrier with all bits that the kinds stand for."""
        if self._gpu.watch is not None:
            self._gpu.watch.barrier(bool(kinds & BarrierKind.TEXTURE), bool(kinds & BarrierKind.BUFFER))
        self._memory_barrier(_BITS[kinds])

    def begin_frame(self) -> None:
        """Clip control and a known state; see Gpu.begin_frame."""
        self._gpu.begin_frame()

    def end_frame(self) -> None:
        """Default state; see Gpu.end_frame."""
        self._gpu.end_frame()

    @property
    def watch(self) -> CommandWatch | None:
        """See engine.graph.watching; None unless authors ask for it."""
        return self._gpu.watch

    def create_timers(self, count: int) -> GpuTimers:
        """Timestamps for `count` passes."""
        return self.scope.own_timers(GpuTimers(self._gpu, count))

    def _followed(self, made: T) -> T:
        return made if self._gpu.watch is None else self._gpu.watch.follow(made)

    def _label(self, obj: moderngl.Texture | moderngl.Buffer, name: str) -> None:
        if self._gpu.ctx.supports_labels:  # shows in graphics debuggers
            obj.label = name
