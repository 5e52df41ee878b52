"""Gpu: one OpenGL context, and the owners of objects on it."""

from __future__ import annotations

from .device import Device
from .scope import GpuScope

__all__ = ["Gpu"]


class Gpu(Device):
    """Takes a current moderngl context (its own or a host's) and adds what moderngl lacks.

    ctx: the context. gl: raw calls. caps: limits and names. shaders: the library over `shader_roots`. work: counters.
    GLVersionError below OpenGL 4.3. Without clip control (4.3 without ARB_clip_control) every shader gets the define
    PF_FRAG_DEPTH and writes the same depth values itself, at the price of early depth tests.
    """

    def scope(self, owner: str) -> GpuScope:
        """A new scope whose objects are counted under `owner`."""
        return GpuScope(self, owner)
