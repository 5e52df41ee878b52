"""What the context can do, read once."""

from __future__ import annotations

from dataclasses import dataclass

import moderngl

from . import gl as G
from .errors import GLVersionError

__all__ = ["REQUIRED_VERSION", "Capabilities", "check_version", "is_software"]

REQUIRED_VERSION = 430
_SOFTWARE = ("llvmpipe", "softpipe", "swrast", "swiftshader", "software rasterizer", "gdi generic")


def is_software(renderer: str) -> bool:
    """Whether a GL_RENDERER draws on the processor."""
    return any(name in renderer.lower() for name in _SOFTWARE)


@dataclass(frozen=True)
class Capabilities:
    """Limits and names of one OpenGL context. Sizes in texels and bytes."""

    version_code: int
    version: str
    renderer: str
    vendor: str
    has_clip_control: bool
    has_texture_barrier: bool
    is_software: bool
    max_texture_size: int
    max_texture_3d_size: int
    max_texture_layers: int
    max_texture_units: int
    max_uniform_block_bytes: int
    max_storage_block_bytes: int
    storage_offset_bytes: int
    """Storage buffers can be bound from multiples of this on: a power of two, at most 256."""

    @classmethod
    def read(cls, ctx: moderngl.Context, gl: G.GL) -> Capabilities:
        info = ctx.info
        clip = (ctx.version_code >= 450 or "GL_ARB_clip_control" in ctx.extensions) and gl.has("glClipControl")
        barrier = ctx.version_code >= 450 or "GL_ARB_texture_barrier" in ctx.extensions
        return cls(
            version_code=ctx.version_code,
            version=info["GL_VERSION"],
            renderer=info["GL_RENDERER"],
            vendor=info["GL_VENDOR"],
            has_clip_control=clip,
            has_texture_barrier=barrier and gl.has("glTextureBarrier"),
            is_software=is_software(info["GL_RENDERER"]),
            max_texture_size=gl.integer(G.MAX_TEXTURE_SIZE),
            max_texture_3d_size=gl.integer(G.MAX_3D_TEXTURE_SIZE),
            max_texture_layers=gl.integer(G.MAX_ARRAY_TEXTURE_LAYERS),
            max_texture_units=gl.integer(G.MAX_COMBINED_TEXTURE_IMAGE_UNITS),
            max_uniform_block_bytes=gl.integer(G.MAX_UNIFORM_BLOCK_SIZE),
            max_storage_block_bytes=gl.integer(G.MAX_SHADER_STORAGE_BLOCK_SIZE),
            storage_offset_bytes=gl.integer(G.SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT),
        )


def check_version(ctx: moderngl.Context, required: int = REQUIRED_VERSION) -> None:
    """Raise GLVersionError, naming what was found, if the context is older than `required`."""
    if ctx.version_code < required:
        info = ctx.info
        raise GLVersionError(required, ctx.version_code, info["GL_VERSION"], info["GL_RENDERER"], info["GL_VENDOR"])
