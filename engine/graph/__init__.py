"""The frame graph: passes declare what they create, read and write; a plan runs what somebody looks at."""

from .backend import BarrierKind, GraphBackend, PassTimers
from .errors import GraphError
from .null_backend import NullBackend
from .resources import BufferSpec, ImportSpec, TextureSpec

__all__ = [
    "BarrierKind",
    "BufferSpec",
    "GraphBackend",
    "GraphError",
    "ImportSpec",
    "NullBackend",
    "PassTimers",
    "TextureSpec",
]
