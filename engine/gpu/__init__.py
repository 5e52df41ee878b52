"""The GPU: context, shaders, buffers, textures and state, on moderngl and a little raw OpenGL."""

from ..blocks.layout import StructLayout
from .context import Gpu
from .errors import FormatError, GLLimitError, GLVersionError, GpuError, ShaderError, ShaderMessage
from .program import Compute, Fullscreen, Program, VertexArray
from .scope import GpuScope
from .shaders import ShaderLibrary
from .state import State
from .uniforms import UniformBlock

__all__ = [
    "Compute",
    "FormatError",
    "Fullscreen",
    "GLLimitError",
    "GLVersionError",
    "Gpu",
    "GpuError",
    "GpuScope",
    "Program",
    "ShaderError",
    "ShaderLibrary",
    "ShaderMessage",
    "State",
    "StructLayout",
    "UniformBlock",
    "VertexArray",
]
