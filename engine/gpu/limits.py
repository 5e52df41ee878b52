"""What shaders need of a driver's limits, beside what OpenGL 4.3 promises (core specification, tables 23.53 to 23.73).

A stage that needs more than a driver has fails to link, somewhere, with words that name no remedy. So the context is
asked once, before anything is made.
"""

from __future__ import annotations

from dataclasses import dataclass

from . import gl as G
from .errors import GLLimitError

__all__ = ["LIMITS", "Limit", "check_limits"]


@dataclass(frozen=True)
class Limit:
    """name: GL_MAX_..., and its code. promised: by OpenGL 4.3. needed: the most that a shader of ours uses, which a
    test counts in the SPIR-V of all programs. Bytes, or a number of things."""

    what: str
    name: str
    code: int
    promised: int
    needed: int


LIMITS = (
    Limit("storage buffers that a vertex shader reads", "VERTEX_SHADER_STORAGE_BLOCKS", 0x90D6, 0, 4),
    Limit("storage buffers that a fragment shader uses", "FRAGMENT_SHADER_STORAGE_BLOCKS", 0x90DA, 8, 4),
    Limit("storage buffers that a compute shader uses", "COMPUTE_SHADER_STORAGE_BLOCKS", 0x90DB, 8, 8),
    Limit("places for storage buffers", "SHADER_STORAGE_BUFFER_BINDINGS", 0x90DD, 8, 8),
    Limit("textures that a vertex shader reads", "VERTEX_TEXTURE_IMAGE_UNITS", 0x8B4C, 16, 4),
    Limit("textures that a fragment shader reads", "TEXTURE_IMAGE_UNITS", 0x8872, 16, 16),
    Limit("textures that a compute shader reads", "COMPUTE_TEXTURE_IMAGE_UNITS", 0x91BC, 16, 16),
    Limit("texture units", "COMBINED_TEXTURE_IMAGE_UNITS", G.MAX_COMBINED_TEXTURE_IMAGE_UNITS, 96, 32),
    Limit("images that a compute shader uses", "COMPUTE_IMAGE_UNIFORMS", 0x91BD, 8, 8),
    Limit("places for images", "IMAGE_UNITS", 0x8F38, 8, 8),
    Limit("uniform blocks of a vertex shader", "VERTEX_UNIFORM_BLOCKS", 0x8A2B, 14, 14),
    Limit("uniform blocks of a fragment shader", "FRAGMENT_UNIFORM_BLOCKS", 0x8A2D, 14, 14),
    Limit("uniform blocks of a compute shader", "COMPUTE_UNIFORM_BLOCKS", 0x91BB, 14, 14),
    Limit("places for uniform blocks", "UNIFORM_BUFFER_BINDINGS", 0x8A2F, 72, 32),
    Limit("bytes of a uniform block", "UNIFORM_BLOCK_SIZE", G.MAX_UNIFORM_BLOCK_SIZE, 16384, 16384),
    Limit("invocations of a work group", "COMPUTE_WORK_GROUP_INVOCATIONS", 0x90EB, 1024, 1024),
    Limit("bytes that a work group shares", "COMPUTE_SHARED_MEMORY_SIZE", 0x8262, 32768, 32768),
)


def check_limits(gl: G.GL, renderer: str) -> None:
    """Raise GLLimitError, naming all that is missing, where the driver has less than shaders need."""
    found = [(limit, gl.integer(limit.code)) for limit in LIMITS]
    missing = [
        f"{limit.what}: needed {limit.needed}, found {has} (GL_MAX_{limit.name})"
        for limit, has in found
        if has < limit.needed
    ]
    if missing:
        raise GLLimitError(renderer, missing)
