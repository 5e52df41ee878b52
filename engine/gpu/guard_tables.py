"""What the state guard reads and how each value is set again: tables of GL names and prepared calls."""

from __future__ import annotations

import ctypes as c
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from . import gl as G
from .errors import GpuError

__all__ = ["ATTRIBUTES_OF_CONTEXT", "ATTRIBUTES_OF_FRAMEBUFFER", "BLEND_PER_BUFFER", "ERROR_NAMES", "Calls", "Item"]

ERROR_NAMES = {
    0x0500: "GL_INVALID_ENUM",
    0x0501: "GL_INVALID_VALUE",
    0x0502: "GL_INVALID_OPERATION",
    0x0503: "GL_STACK_OVERFLOW",
    0x0504: "GL_STACK_UNDERFLOW",
    0x0505: "GL_OUT_OF_MEMORY",
    0x0506: "GL_INVALID_FRAMEBUFFER_OPERATION",
    0x0507: "GL_CONTEXT_LOST",
}

# moderngl's cached state; assigning one of them also calls GL.
ATTRIBUTES_OF_CONTEXT = (
    "front_face", "cull_face", "depth_func", "wireframe", "multisample", "provoking_vertex", "polygon_offset",
    "depth_clamp_range", "default_texture_unit",
)  # fmt: skip
ATTRIBUTES_OF_FRAMEBUFFER = ("viewport", "scissor", "color_mask", "depth_mask")

_BLEND = 0x0BE2
BLEND_PER_BUFFER = (_BLEND, 0x8009, 0x883D, 0x80C9, 0x80C8, 0x80CB, 0x80CA)
"""Per draw buffer: enabled, equation rgb and alpha, source and destination rgb, source and destination alpha."""

# glEnable/glDisable, all draw buffers and viewports alike
_CAPABILITIES = (
    0x0B71,  # DEPTH_TEST
    0x0B44,  # CULL_FACE
    0x0C11,  # SCISSOR_TEST
    0x0B90,  # STENCIL_TEST
    0x8DB9,  # FRAMEBUFFER_SRGB
    0x8F9D,  # PRIMITIVE_RESTART
    0x8D69,  # PRIMITIVE_RESTART_FIXED_INDEX
    0x884F,  # TEXTURE_CUBE_MAP_SEAMLESS
    0x864F,  # DEPTH_CLAMP
    0x8C89,  # RASTERIZER_DISCARD
    0x8642,  # PROGRAM_POINT_SIZE
    0x809D,  # MULTISAMPLE
    0x8037,  # POLYGON_OFFSET_FILL
    0x2A02,  # POLYGON_OFFSET_LINE
    0x2A01,  # POLYGON_OFFSET_POINT
    0x809E,  # SAMPLE_ALPHA_TO_COVERAGE
    0x8E51,  # SAMPLE_MASK
    0x8C36,  # SAMPLE_SHADING
    0x0BF2,  # COLOR_LOGIC_OP
)
_BUFFERS = (  # target, binding name
    (0x8892, 0x8894),  # ARRAY
    (0x8893, 0x8895),  # ELEMENT_ARRAY: belongs to the vertex array, which is bound again before this is read
    (0x8F36, 0x8F36),  # COPY_READ
    (0x8F37, 0x8F37),  # COPY_WRITE
    (0x88EB, 0x88ED),  # PIXEL_PACK
    (0x88EC, 0x88EF),  # PIXEL_UNPACK
    (0x8F3F, 0x8F43),  # DRAW_INDIRECT
    (0x90EE, 0x90EF),  # DISPATCH_INDIRECT
)
_PIXEL_BUFFERS = (0x88EB, 0x88EC)
_INDEXED_BUFFERS = ((0x8A11, 0x8A28), (0x90D2, 0x90D3))  # UNIFORM, SHADER_STORAGE: beside the indexed ones
_PIXEL_STORE = (*range(0x0D00, 0x0D06), 0x806B, 0x806C, *range(0x0CF0, 0x0CF6), 0x806D, 0x806E)
_ALIGNMENTS = (0x0D05, 0x0CF5)

_POINTER_FUNCTION: Any = c.PYFUNCTYPE  # keeps the interpreter lock: state reads are too short to be worth giving it up
if sys.platform.startswith("win") and sys.maxsize <= 2**32:
    _POINTER_FUNCTION = getattr(c, "WINFUNCTYPE", c.CFUNCTYPE)  # 32-bit Windows has another calling convention


class Calls:
    """Prepared GL functions of one context."""

    def __init__(self, gl: G.GL) -> None:
        self._gl = gl
        u, i, p, long = c.c_uint, c.c_int, c.c_void_p, c.c_ssize_t
        self.error = self.prepare("glGetError", result=u)
        self.get = self.prepare("glGetIntegerv", u, p)
        self.get_float = self.prepare("glGetFloatv", u, p)
        self.get_double = self.prepare("glGetDoublev", u, p)
        self.get_indexed = self.prepare("glGetIntegeri_v", u, u, p)
        self.get_indexed_long = self.prepare("glGetInteger64i_v", u, u, p)
        self.active_texture = self.prepare("glActiveTexture", u)
        self.bind_texture = self.prepare("glBindTexture", u, u)
        self.bind_sampler = self.prepare("glBindSampler", u, u)
        self.bind_buffer = self.prepare("glBindBuffer", u, u)
        self.bind_buffer_base = self.prepare("glBindBufferBase", u, u, u)
        self.bind_buffer_range = self.prepare("glBindBufferRange", u, u, u, long, long)
        self.bind_image_texture = self.prepare("glBindImageTexture", u, u, i, c.c_ubyte, i, u, u)
        if gl.has("glBindSamplers"):
            self.bind_samplers = self.prepare("glBindSamplers", u, i, p)
            self.bind_buffers_base = self.prepare("glBindBuffersBase", u, u, i, p)
            self.bind_image_textures = self.prepare("glBindImageTextures", u, i, p)
        self.enable = self.prepare("glEnable", u)
        self.disable = self.prepare("glDisable", u)
        self._enable_indexed = self.prepare("glEnablei", u, u)
        self._disable_indexed = self.prepare("glDisablei", u, u)
        self._blend_equation = self.prepare("glBlendEquationSeparate", u, u)
        self._blend_function = self.prepare("glBlendFuncSeparate", u, u, u, u)
        self._blend_equation_indexed = self.prepare("glBlendEquationSeparatei", u, u, u)
        self._blend_function_indexed = self.prepare("glBlendFuncSeparatei", u, u, u, u, u)
        self.color_mask = self.prepare("glColorMask", *[c.c_ubyte] * 4)
        self.color_mask_indexed = self.prepare("glColorMaski", u, *[c.c_ubyte] * 4)
        self._word = c.c_int()

    def prepare(self, name: str, *arguments: Any, result: Any = None) -> Any:
        """An entry point with argument types of our own (pointers as addresses)."""
        address = self._gl.address(name)  # not gl.function(): it keeps one signature per name, and others use theirs
        if not address:
            raise GpuError(f"this OpenGL driver has no function {name}")
        return _POINTER_FUNCTION(result, *arguments)(address)

    def integer(self, name: int) -> int:
        self.get(name, c.addressof(self._word))
        return self._word.value

    def indexed_integer(self, name: int, index: int) -> int:
        self.get_indexed(name, index, c.addressof(self._word))
        return self._word.value

    def blend(self, enabled: int, functions: Sequence[int]) -> None:
        """Blending of all draw buffers; functions: equations (2), then factors (4)."""
        (self.enable if enabled else self.disable)(_BLEND)
        self._blend_equation(*functions[:2])
        self._blend_function(*functions[2:])

    def blend_indexed(self, buffer: int, enabled: int, functions: Sequence[int]) -> None:
        (self._enable_indexed if enabled else self._disable_indexed)(_BLEND, buffer)
        self._blend_equation_indexed(buffer, *functions[:2])
        self._blend_function_indexed(buffer, *functions[2:])


@dataclass
class Item:
    """A value of GL state: how it is read (function, names, word position) and set from its 32-bit words.

    first: set before anything is read on exit, because other values belong to it.
    always: set even if it reads the same, because restoring something else changes it.
    neutral: what uploads and read-backs inside the guard rely on (a pixel buffer or row length of the host's would
    redirect or skew them); set on entry where the host's differs.
    """

    name: str
    reads: list[tuple[Callable[..., Any], tuple[int, ...], int]]
    restore: Callable[[Any], None]
    words: int = 1
    first: bool = False
    always: bool = False
    neutral: int | None = None
    offset: int = field(default=0, init=False)


def build_items(calls: Calls, draw_buffers: int, has_clip_control: bool) -> list[Item]:
    """All values that are read one by one, in the order in which they are set again."""
    u, i = c.c_uint, c.c_int
    get, prepare = calls.get, calls.prepare
    items: list[Item] = []

    def one(name: str, value: int, setter: Callable[[int], Any], **how: Any) -> None:
        items.append(Item(name, [(get, (value,), 0)], lambda words: setter(int(words[0]) & 0xFFFFFFFF), **how))

    def several(name: str, values: Sequence[int], setter: Callable[..., Any], lead: tuple[int, ...] = ()) -> None:
        def restore(words: Any) -> None:
            setter(*lead, *(int(w) & 0xFFFFFFFF for w in words))

        items.append(Item(name, [(get, (v,), k) for k, v in enumerate(values)], restore, words=len(values)))

    def wide(name: str, value: int, count: int, kind: str, setter: Callable[..., Any]) -> None:
        """One GL value of several numbers, of kind int32, float32 or float64."""
        dtype = np.dtype(kind)
        reader = {"int32": get, "float32": calls.get_float, "float64": calls.get_double}[kind]

        def restore(words: Any) -> None:
            setter(*words.view(dtype).tolist())

        items.append(Item(name, [(reader, (value,), 0)], restore, words=count * dtype.itemsize // 4))

    bind_framebuffer = prepare("glBindFramebuffer", u, u)
    one("draw framebuffer", 0x8CA6, lambda v: bind_framebuffer(0x8CA9, v), first=True)
    one("read framebuffer", 0x8CAA, lambda v: bind_framebuffer(0x8CA8, v), first=True)
    one("vertex array", 0x85B5, prepare("glBindVertexArray", u), first=True)
    one("program", 0x8B8D, prepare("glUseProgram", u))
    for target, binding in _BUFFERS:
        neutral = 0 if target in _PIXEL_BUFFERS else None
        one(f"buffer {target:#x}", binding, lambda v, target=target: calls.bind_buffer(target, v), neutral=neutral)
    bind_renderbuffer = prepare("glBindRenderbuffer", u, u)
    one("renderbuffer", 0x8CA7, lambda v: bind_renderbuffer(0x8D41, v))

    draw_buffer, set_draw_buffers = prepare("glDrawBuffer", u), prepare("glDrawBuffers", i, c.c_void_p)

    def restore_draw_buffers(words: Any) -> None:
        if calls.integer(0x8CA6):
            set_draw_buffers(draw_buffers, np.ascontiguousarray(words).ctypes.data)
        else:  # the window's own framebuffer has one, and GL_BACK is not allowed in the list
            draw_buffer(int(words[0]) & 0xFFFFFFFF)

    items.append(
        Item("draw buffers", [(get, (0x8825 + k,), k) for k in range(draw_buffers)], restore_draw_buffers, draw_buffers)
    )
    one("read buffer", 0x0C02, prepare("glReadBuffer", u))

    for capability in _CAPABILITIES:
        one(
            f"capability {capability:#x}",
            capability,
            lambda v, capability=capability: (calls.enable if v else calls.disable)(capability),
        )
    pixel_store = prepare("glPixelStorei", u, i)
    for name in _PIXEL_STORE:
        neutral = 4 if name in _ALIGNMENTS else 0
        one(f"pixel store {name:#x}", name, lambda v, name=name: pixel_store(name, v), neutral=neutral)

    one("depth function", 0x0B74, prepare("glDepthFunc", u))
    one("depth mask", 0x0B72, prepare("glDepthMask", c.c_ubyte))
    one("cull face", 0x0B45, prepare("glCullFace", u))
    one("front face", 0x0B46, prepare("glFrontFace", u))
    one("provoking vertex", 0x8E4F, prepare("glProvokingVertex", u))
    patch_parameter = prepare("glPatchParameteri", u, i)
    one("patch vertices", 0x8E72, lambda v: patch_parameter(0x8E72, v))
    one("logic operation", 0x0BF0, prepare("glLogicOp", u))
    one("primitive restart index", 0x8F9E, prepare("glPrimitiveRestartIndex", u))
    clamp_color = prepare("glClampColor", u, u)
    one("read colour clamp", 0x891C, lambda v: clamp_color(0x891C, v))
    one("clear stencil", 0x0B91, prepare("glClearStencil", i))
    polygon_mode = prepare("glPolygonMode", u, u)
    wide("polygon mode", 0x0B40, 2, "int32", lambda mode, _same: polygon_mode(0x0408, mode))
    if has_clip_control:
        several("clip control", (G.CLIP_ORIGIN, G.CLIP_DEPTH_MODE), prepare("glClipControl", u, u))

    stencil_func, stencil_op = prepare("glStencilFuncSeparate", u, u, i, u), prepare("glStencilOpSeparate", u, u, u, u)
    stencil_mask = prepare("glStencilMaskSeparate", u, u)
    several("stencil function front", (0x0B92, 0x0B97, 0x0B93), stencil_func, (G.FRONT,))
    several("stencil function back", (0x8800, 0x8CA3, 0x8CA4), stencil_func, (G.BACK,))
    several("stencil operation front", (0x0B94, 0x0B95, 0x0B96), stencil_op, (G.FRONT,))
    several("stencil operation back", (0x8801, 0x8802, 0x8803), stencil_op, (G.BACK,))
    several("stencil mask front", (0x0B98,), stencil_mask, (G.FRONT,))
    several("stencil mask back", (0x8CA5,), stencil_mask, (G.BACK,))

    wide("scissor box", 0x0C10, 4, "int32", prepare("glScissor", i, i, i, i))
    wide("viewport", 0x0BA2, 4, "float32", _viewport(calls))
    wide("clear colour", 0x0C22, 4, "float32", prepare("glClearColor", *[c.c_float] * 4))
    wide("blend colour", 0x8005, 4, "float32", prepare("glBlendColor", *[c.c_float] * 4))
    wide("line width", 0x0B21, 1, "float32", prepare("glLineWidth", c.c_float))
    wide("point size", 0x0B11, 1, "float32", prepare("glPointSize", c.c_float))
    wide("sample shading", 0x8C37, 1, "float32", prepare("glMinSampleShading", c.c_float))
    factor, units = 0x8038, 0x2A00
    polygon_offset = prepare("glPolygonOffset", c.c_float, c.c_float)
    items.append(
        Item(
            "polygon offset",
            [(calls.get_float, (factor,), 0), (calls.get_float, (units,), 1)],
            lambda words: polygon_offset(*words.view(np.float32).tolist()),
            words=2,
        )
    )
    wide("clear depth", 0x0B73, 1, "float64", prepare("glClearDepth", c.c_double))
    wide("depth range", 0x0B70, 2, "float64", prepare("glDepthRange", c.c_double, c.c_double))

    for target, binding in _INDEXED_BUFFERS:
        one(f"buffer {target:#x}", binding, lambda v, target=target: calls.bind_buffer(target, v), always=True)
    one("active texture", 0x84E0, calls.active_texture, always=True)
    return items


def _viewport(calls: Calls) -> Callable[..., None]:
    """Sets viewport 0, and the others with it as glViewport does, exact for fractional ones as well."""
    whole = calls.prepare("glViewport", *[c.c_int] * 4)
    exact = calls.prepare("glViewportIndexedf", c.c_uint, *[c.c_float] * 4)

    def restore(x: float, y: float, width: float, height: float) -> None:
        whole(int(x), int(y), int(width), int(height))
        if any(v != int(v) for v in (x, y, width, height)):
            exact(0, x, y, width, height)

    return restore
