"""Raw OpenGL through the context's own loader, for the few calls that moderngl lacks.

No PyOpenGL: function addresses come from the glcontext object inside the moderngl context, so this works alike on EGL,
GLX and WGL and on contexts lent by a host. This is the only module that touches the private ``ctx.mglo._context``.
"""

from __future__ import annotations

import ctypes as c
import sys
from collections.abc import Callable
from typing import Any

import moderngl

from .errors import GpuError

__all__ = ["GL"]

# WINFUNCTYPE (stdcall) exists on Windows only; on 64 bits both are the same call.
_FUNCTION_TYPE: Any = getattr(c, "WINFUNCTYPE", c.CFUNCTYPE) if sys.platform.startswith("win") else c.CFUNCTYPE

enum = uint = bitfield = c.c_uint
int_ = sizei = c.c_int
boolean = c.c_ubyte

# Names as in the GL headers, without the prefix.
LOWER_LEFT, ZERO_TO_ONE, NEGATIVE_ONE_TO_ONE = 0x8CA1, 0x935F, 0x935E
CLIP_ORIGIN, CLIP_DEPTH_MODE = 0x935C, 0x935D
TEXTURE0, TEXTURE_2D, TEXTURE_3D, TEXTURE_2D_ARRAY = 0x84C0, 0x0DE1, 0x806F, 0x8C1A
TEXTURE_BASE_LEVEL, TEXTURE_MAX_LEVEL = 0x813C, 0x813D
DEPTH_COMPONENT, DEPTH_COMPONENT32F, FLOAT = 0x1902, 0x8CAC, 0x1406
DEPTH_TEST, BLEND, CULL_FACE, PROGRAM_POINT_SIZE = 0x0B71, 0x0BE2, 0x0B44, 0x8642
SCISSOR_TEST, STENCIL_TEST, FRAMEBUFFER_SRGB, DEPTH_CLAMP, RASTERIZER_DISCARD = 0x0C11, 0x0B90, 0x8DB9, 0x864F, 0x8C89
POLYGON_OFFSET_FILL, SAMPLE_ALPHA_TO_COVERAGE, SAMPLE_MASK, COLOR_LOGIC_OP = 0x8037, 0x809E, 0x8E51, 0x0BF2
PRIMITIVE_RESTART, PRIMITIVE_RESTART_FIXED_INDEX = 0x8F9D, 0x8D69
FRONT, BACK, FRONT_AND_BACK, POINT, LINE, FILL, CCW = 0x0404, 0x0405, 0x0408, 0x1B00, 0x1B01, 0x1B02, 0x0901
MAX_TEXTURE_SIZE, MAX_3D_TEXTURE_SIZE, MAX_ARRAY_TEXTURE_LAYERS = 0x0D33, 0x8073, 0x88FF
MAX_UNIFORM_BLOCK_SIZE, MAX_SHADER_STORAGE_BLOCK_SIZE = 0x8A30, 0x90DE
SHADER_STORAGE_BUFFER_OFFSET_ALIGNMENT = 0x90DF
MAX_COMBINED_TEXTURE_IMAGE_UNITS = 0x8B4D
COMPUTE_WORK_GROUP_SIZE = 0x8267
TIMESTAMP, QUERY_RESULT, QUERY_RESULT_AVAILABLE = 0x8E28, 0x8866, 0x8867
CURRENT_PROGRAM = 0x8B8D
COLOR, DEPTH, COLOR_BUFFER_BIT, NEAREST, READ_FRAMEBUFFER = 0x1800, 0x1801, 0x4000, 0x2600, 0x8CA8
SAMPLE_BUFFERS, DRAW_BUFFER1 = 0x80A8, 0x8826


class GL:
    """Entry points of one context, looked up once and kept.

    ``gl.function("glClipControl", None, enum, enum)`` gives a callable; ``gl.integer(name)`` and
    ``gl.integers(name, n)`` read state. The context must be current in the calling thread.
    """

    def __init__(self, ctx: moderngl.Context) -> None:
        loader = ctx.mglo._context
        self.address: Callable[[str], int] = getattr(loader, "load_opengl_function", None) or loader.load
        """Where the driver has the entry point of a name; 0: nowhere."""
        self._functions: dict[str, Any] = {}
        self._buffer = (int_ * 16)()
        self._get_integer = self.function("glGetIntegerv", None, enum, c.POINTER(int_))

    def has(self, name: str) -> bool:
        """Whether the driver gives an address for this name (some drivers do for names they do not support)."""
        return bool(self.address(name))

    def function(self, name: str, result: Any, *arguments: Any) -> Any:
        """The entry point `name` as a ctypes function. Raises GpuError where the driver has none."""
        found = self._functions.get(name)
        if found is None:
            address = self.address(name)
            if not address:
                raise GpuError(f"this OpenGL driver has no function {name}")
            found = self._functions[name] = _FUNCTION_TYPE(result, *arguments)(address)
        return found

    def integer(self, name: int) -> int:
        """One integer of state (glGetIntegerv)."""
        self._get_integer(name, self._buffer)
        return self._buffer[0]

    def integers(self, name: int, count: int) -> tuple[int, ...]:
        """The first `count` (up to 16) integers of a state value."""
        self._get_integer(name, self._buffer)
        return tuple(self._buffer[:count])

    def clip_control(self, origin: int, depth: int) -> None:
        self.function("glClipControl", None, enum, enum)(origin, depth)

    def enable(self, capability: int, on: bool = True) -> None:
        self.function("glEnable" if on else "glDisable", None, enum)(capability)

    def texture_parameter(self, target: int, name: int, value: int) -> None:
        """glTexParameteri on the texture bound to the active unit."""
        self.function("glTexParameteri", None, enum, enum, int_)(target, name, value)

    def image_2d(self, target: int, level: int, internal: int, size: tuple[int, int], format: int, type: int) -> None:
        """Specify one level of the bound 2D texture, content undefined."""
        self.function("glTexImage2D", None, enum, int_, int_, sizei, sizei, int_, enum, enum, c.c_void_p)(
            target, level, internal, *size, 0, format, type, None
        )

    def image_3d(self, target: int, level: int, internal: int, size: tuple[int, ...], format: int, type: int) -> None:
        """Specify one level of the bound 3D or array texture, content undefined."""
        self.function("glTexImage3D", None, enum, int_, int_, sizei, sizei, sizei, int_, enum, enum, c.c_void_p)(
            target, level, internal, *size, 0, format, type, None
        )

    def generate_mipmap(self, target: int) -> None:
        self.function("glGenerateMipmap", None, enum)(target)

    def copy_layers(
        self, target: int, source: int, begin: int, into: int, first: int, size: tuple[int, int, int]
    ) -> None:
        """glCopyImageSubData: whole layers of an array or 3D texture, from `begin` on, to those from `first` on of
        another of that kind, or of itself."""
        self.function("glCopyImageSubData", None, *[uint, enum, *[int_] * 4] * 2, *[sizei] * 3)(
            source, target, 0, 0, 0, begin, into, target, 0, 0, 0, first, *size
        )

    def texture_barrier(self) -> None:
        """glTextureBarrier: what was drawn so far can be read by draws into the same texture, each pixel by itself."""
        self.function("glTextureBarrier", None)()

    def clear_color(self, place: int, integers: bool) -> None:
        """Zeros into a colour attachment of the bound framebuffer; glClear has no meaning for those of integers."""
        kind = uint if integers else c.c_float
        name = "glClearBufferuiv" if integers else "glClearBufferfv"
        self.function(name, None, enum, int_, c.POINTER(kind))(COLOR, place, (kind * 4)())

    def clear_depth(self, depth: float) -> None:
        """One depth all over the bound framebuffer."""
        number = c.c_float(depth)
        self.function("glClearBufferfv", None, enum, int_, c.POINTER(c.c_float))(DEPTH, 0, c.byref(number))

    def blit_color(self, source: int, size: tuple[int, int], corner: tuple[int, int]) -> None:
        """Colours of a framebuffer, pixel by pixel, into the bound one's from a corner on."""
        (width, height), (x, y) = size, corner
        self.function("glBindFramebuffer", None, enum, uint)(READ_FRAMEBUFFER, source)
        self.function("glBlitFramebuffer", None, *[int_] * 8, bitfield, enum)(
            0, 0, width, height, x, y, x + width, y + height, COLOR_BUFFER_BIT, NEAREST
        )

    def program_integers(self, program: int, name: int, count: int = 1) -> tuple[int, ...]:
        """glGetProgramiv."""
        self.function("glGetProgramiv", None, uint, enum, c.POINTER(int_))(program, name, self._buffer)
        return tuple(self._buffer[:count])

    def detach_shaders(self, program: int) -> None:
        """Take the stages off a linked program; those that are marked for deletion end with that."""
        attached, count = (uint * 6)(), int_()
        get = self.function("glGetAttachedShaders", None, uint, sizei, c.POINTER(int_), c.POINTER(uint))
        get(program, len(attached), c.byref(count), attached)
        detach = self.function("glDetachShader", None, uint, uint)
        for shader in attached[: count.value]:
            detach(program, shader)

    def is_object(self, kind: str, name: int) -> bool:
        """glIsTexture, glIsBuffer, glIsFramebuffer, glIsProgram, glIsVertexArray, ... for kind "Texture" and so on."""
        return bool(self.function(f"glIs{kind}", boolean, uint)(name))
