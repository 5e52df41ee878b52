"""Shaders that the driver compiles in threads of its own, ahead of their first use.

moderngl asks for a program's state at once, which waits for its compiler: one program after the other, on one
processor. Where the driver has threads (GL_KHR_parallel_shader_compile), a program is handed to it here as soon as its
sources are known. moderngl makes it again at its first use, out of the driver's cache. docs/drivers.md has what it
saves on NVIDIA's driver, the only one where it was measured and is used.
"""

from __future__ import annotations

import ctypes as c
import os
from collections.abc import Mapping

import moderngl

from . import gl as G
from .caps import Capabilities

__all__ = ["SWITCH", "CompileAhead", "compiles_ahead"]

SWITCH = "PLANETFALL_COMPILE_AHEAD"
"""Environment variable: 1 or 0 overrules what is known of the driver."""

_KINDS = {
    "vertex": 0x8B31,
    "fragment": 0x8B30,
    "geometry": 0x8DD9,
    "tess_control": 0x8E88,
    "tess_evaluation": 0x8E87,
    "compute": 0x91B9,
}
_LINK_STATUS = 0x8B82
_EXTENSIONS = ("GL_KHR_parallel_shader_compile", "GL_ARB_parallel_shader_compile")
_AS_MANY_AS_THE_DRIVER_LIKES = 0xFFFFFFFF


def compiles_ahead(ctx: moderngl.Context, caps: Capabilities) -> bool:
    """Whether programs are handed to the driver before they are used."""
    asked = os.environ.get(SWITCH, "")
    if asked in ("0", "1"):
        return asked == "1"
    return "NVIDIA" in caps.vendor and not ctx.extensions.isdisjoint(_EXTENSIONS)


class CompileAhead:
    """The GL programs under way, by name. They are never used: they fill the driver's cache."""

    def __init__(self, gl: G.GL) -> None:
        self._gl = gl
        for name in ("glMaxShaderCompilerThreadsKHR", "glMaxShaderCompilerThreadsARB"):
            if gl.has(name):
                gl.function(name, None, G.uint)(_AS_MANY_AS_THE_DRIVER_LIKES)
                break

    def begin(self, sources: Mapping[str, str]) -> int:
        """Hand over the text of each stage; the program's name for `wait` or `drop`. Asks for nothing, so waits not."""
        gl = self._gl
        create = gl.function("glCreateShader", G.uint, G.enum)
        source = gl.function("glShaderSource", None, G.uint, G.sizei, c.POINTER(c.c_char_p), c.POINTER(G.int_))
        compile_, attach = (
            gl.function("glCompileShader", None, G.uint),
            gl.function("glAttachShader", None, G.uint, G.uint),
        )
        delete = gl.function("glDeleteShader", None, G.uint)
        program: int = gl.function("glCreateProgram", G.uint)()
        for stage, text in sources.items():
            shader = create(_KINDS[stage])
            source(shader, 1, (c.c_char_p * 1)(text.encode()), None)
            compile_(shader)
            attach(program, shader)
            delete(shader)  # goes with the program
        gl.function("glLinkProgram", None, G.uint)(program)
        return program

    def wait(self, program: int) -> None:
        """Until the driver is done with it, well or badly; then it goes."""
        self._gl.program_integers(program, _LINK_STATUS)
        self.drop(program)

    def drop(self, program: int) -> None:
        """Nobody needs it any more."""
        self._gl.function("glDeleteProgram", None, G.uint)(program)
