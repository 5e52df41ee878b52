"""The frame graph: passes declare what they create, read and write; a plan runs what somebody looks at.

docs/frame-graph.md has the rules. `GraphBuilder` collects, `compile` makes a `Plan`, `Plan.execute` runs a frame.
"""

from .analysis import Analysis
from .backend import BarrierKind, GraphBackend, PassTimers
from .builder import GraphBuilder
from .declaration import PassDecl
from .errors import GraphError
from .names import Scope, base_name, qualified
from .null_backend import NullBackend
from .pass_io import Flag, PassIO, Slot
from .plan import Plan
from .report import PassReport
from .resources import BYTES_PER_TEXEL, BufferSpec, ImportSpec, TextureSpec
from .stages import STAGES

__all__ = [
    "BYTES_PER_TEXEL",
    "STAGES",
    "Analysis",
    "BarrierKind",
    "BufferSpec",
    "Flag",
    "GraphBackend",
    "GraphBuilder",
    "GraphError",
    "ImportSpec",
    "NullBackend",
    "PassDecl",
    "PassIO",
    "PassReport",
    "PassTimers",
    "Plan",
    "Scope",
    "Slot",
    "TextureSpec",
    "base_name",
    "qualified",
]
