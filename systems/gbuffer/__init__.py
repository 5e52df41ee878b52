"""The G-buffer that surfaces draw into, the arrays made from it, and the copy to a host's framebuffer."""

from .system import GBufferSystem

__all__ = ["GBufferSystem"]
