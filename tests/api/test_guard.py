"""The state guard: every binding is set to something odd, arbitrary work is done, everything must be as it was."""

from __future__ import annotations

import ctypes as c
import logging
from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np
import pytest

from planetfall.engine.blocks.bindings import OWN, POINTS, points
from planetfall.engine.gpu import Gpu
from planetfall.engine.gpu.guard import StateGuard

pytestmark = pytest.mark.gpu

UNITS, UBOS, SSBOS, IMAGES = (POINTS[k] for k in ("texture unit", "uniform block", "storage buffer", "image"))
TARGETS = {0x0DE1: 0x8069, 0x806F: 0x806A, 0x8513: 0x8514, 0x8C1A: 0x8C1D}

# Read here by names of our own, not by the guard's tables.
INTEGERS = {
    "program": 0x8B8D, "vao": 0x85B5, "active texture": 0x84E0, "draw fbo": 0x8CA6, "read fbo": 0x8CAA,
    "array buffer": 0x8894, "element buffer": 0x8895, "uniform buffer": 0x8A28, "storage buffer": 0x90D3,
    "pack buffer": 0x88ED, "unpack buffer": 0x88EF, "draw indirect": 0x8F43, "dispatch indirect": 0x90EF,
    "copy read": 0x8F36, "copy write": 0x8F37, "renderbuffer": 0x8CA7, "depth func": 0x0B74, "depth mask": 0x0B72,
    "cull": 0x0B45, "front": 0x0B46, "provoking": 0x8E4F, "patch": 0x8E72, "restart index": 0x8F9E, "logic": 0x0BF0,
    "stencil func": 0x0B92, "stencil ref": 0x0B97, "stencil value mask": 0x0B93, "stencil fail": 0x0B94,
    "stencil zfail": 0x0B95, "stencil zpass": 0x0B96, "stencil write": 0x0B98, "back func": 0x8800,
    "back fail": 0x8801, "back zfail": 0x8802, "back zpass": 0x8803, "back ref": 0x8CA3, "back value mask": 0x8CA4,
    "back write": 0x8CA5, "stencil clear": 0x0B91, "clip origin": 0x935C, "clip depth": 0x935D, "read buffer": 0x0C02,
    "polygon mode": 0x0B40, "read clamp": 0x891C,
    **{f"pack {name:x}": name for name in (*range(0x0D00, 0x0D06), 0x806B, 0x806C)},
    **{f"unpack {name:x}": name for name in (*range(0x0CF0, 0x0CF6), 0x806D, 0x806E)},
    **{f"draw buffer {i}": 0x8825 + i for i in range(8)},
}  # fmt: skip
CAPABILITIES = (
    0x0B71, 0x0B44, 0x0C11, 0x0B90, 0x8DB9, 0x8F9D, 0x8D69, 0x884F, 0x864F, 0x8642, 0x809D, 0x8037, 0x2A02,
    0x2A01, 0x809E, 0x8E51, 0x8C36, 0x0BF2, 0x8C89,
)  # fmt: skip
FLOATS = {"clear": (0x0C22, 4), "blend colour": (0x8005, 4), "clear depth": (0x0B73, 1), "range": (0x0B70, 2),
          "viewport": (0x0BA2, 4), "scissor": (0x0C10, 4), "offset factor": (0x8038, 1), "offset units": (0x2A00, 1),
          "line width": (0x0B21, 1), "point size": (0x0B11, 1), "sample shading": (0x8C37, 1)}  # fmt: skip
BLEND = (0x0BE2, 0x8009, 0x883D, 0x80C9, 0x80C8, 0x80CB, 0x80CA)


class Raw:
    """GL calls for the test, each with the signature it wants."""

    def __init__(self, gpu: Gpu) -> None:
        self.gl = gpu.gl

    def __call__(self, name: str, *arguments: Any) -> None:
        types: dict[type, Any] = {float: c.c_double, int: c.c_int64}
        kinds = [types.get(type(a), c.c_void_p) for a in arguments]
        if name in ("glClearColor", "glBlendColor", "glPointSize", "glMinSampleShading"):
            kinds = [c.c_float] * len(arguments)
        c.CFUNCTYPE(None, *kinds)(self.gl.address(name))(*arguments)

    def get(self, function: str, kind: Any, count: int, *names: int) -> tuple[Any, ...]:
        buffer = (kind * 16)()
        self(function, *names, buffer)
        return tuple(buffer[:count])

    def integer(self, name: int) -> int:
        return self.get("glGetIntegerv", c.c_int, 1, name)[0]

    def indexed(self, name: int, index: int, count: int = 1) -> tuple[int, ...]:
        return self.get("glGetIntegeri_v", c.c_int, count, name, index)


def snapshot(raw: Raw, ctx: moderngl.Context) -> dict[str, Any]:
    state: dict[str, Any] = {name: raw.integer(value) for name, value in INTEGERS.items()}
    state |= {f"cap {cap:x}": raw.integer(cap) for cap in CAPABILITIES}
    state |= {name: raw.get("glGetDoublev", c.c_double, n, value) for name, (value, n) in FLOATS.items()}
    for i in range(8):
        state[f"blend {i}"] = [raw.indexed(name, i)[0] for name in BLEND]
        state[f"mask {i}"] = raw.indexed(0x0C23, i, 4)
    for i in range(UBOS):
        state[f"ubo {i}"] = [raw.get("glGetInteger64i_v", c.c_int64, 1, 0x8A28 + k, i)[0] for k in range(3)]
    for i in range(SSBOS):
        state[f"ssbo {i}"] = [raw.get("glGetInteger64i_v", c.c_int64, 1, 0x90D3 + k, i)[0] for k in range(3)]
    for i in range(IMAGES):
        state[f"image {i}"] = [raw.indexed(name, i)[0] for name in (*range(0x8F3A, 0x8F3F), 0x906E)]
    for unit in (*range(UNITS), ctx.default_texture_unit):
        raw("glActiveTexture", 0x84C0 + unit)
        for target, binding in TARGETS.items():
            state[f"unit {unit} {target:x}"] = raw.integer(binding)
        state[f"unit {unit} sampler"] = raw.integer(0x8919)
    raw("glActiveTexture", state["active texture"])
    mglo = ctx.mglo
    state["moderngl"] = {
        name: getattr(mglo, name)
        for name in ("front_face", "cull_face", "depth_func", "wireframe", "multisample", "polygon_offset", "fbo")
    }
    state["moderngl fbo"] = ctx.fbo
    return state


@pytest.fixture
def host(gpu: Gpu) -> Iterator[dict[str, Any]]:
    """Objects of a make-believe host; the context is put back in order afterwards."""
    ctx, made = gpu.ctx, []
    ctx.__enter__()  # another test may have left its own context current

    def keep(obj: Any) -> Any:
        made.append(obj)
        return obj

    units = [*range(UNITS), ctx.default_texture_unit]
    result = {
        "2d": [keep(ctx.texture((4, 4), 4)) for _ in units],
        "3d": [keep(ctx.texture3d((4, 4, 4), 4)) for _ in units],
        "cube": [keep(ctx.texture_cube((4, 4), 4)) for _ in units],
        "array": [keep(ctx.texture_array((4, 4, 3), 4)) for _ in units],
        "samplers": [keep(ctx.sampler()) for _ in units],
        "buffers": [keep(ctx.buffer(reserve=4096)) for _ in range(24)],
        "program": keep(
            ctx.program(
                vertex_shader="#version 430 core\nvoid main() { gl_Position = vec4(0.0); }",
                fragment_shader="#version 430 core\nlayout(location = 0) out vec4 o; void main() { o = vec4(1.0); }",
            )
        ),
    }
    result["vao"] = keep(ctx.vertex_array(result["program"], [], index_buffer=result["buffers"][20]))
    colors = [keep(ctx.texture((16, 8), 4)) for _ in range(8)]
    result["fbo"] = keep(ctx.framebuffer(colors))
    result["read fbo"] = keep(ctx.framebuffer([keep(ctx.texture((16, 8), 4)), keep(ctx.texture((16, 8), 4))]))
    result["renderbuffer"] = keep(ctx.renderbuffer((4, 4)))
    yield result
    ctx.detect_framebuffer(0).use()
    for obj in reversed(made):
        obj.release()
    assert ctx.error == "GL_NO_ERROR"


def set_everything_odd(raw: Raw, ctx: moderngl.Context, host: dict[str, Any]) -> None:
    # moderngl's own state first
    host["fbo"].use()
    ctx.enable_only(moderngl.CULL_FACE | moderngl.PROGRAM_POINT_SIZE)
    ctx.front_face, ctx.cull_face, ctx.depth_func, ctx.multisample = "cw", "front", "!=", False
    ctx.polygon_offset, ctx.wireframe, ctx.provoking_vertex = (1.5, 2.5), True, moderngl.FIRST_VERTEX_CONVENTION
    host["fbo"].viewport, host["fbo"].scissor = (1, 2, 11, 5), (2, 1, 5, 3)
    raw("glBindFramebuffer", 0x8CA8, host["read fbo"].glo)
    raw("glReadBuffer", 0x8CE1)
    raw("glDrawBuffers", 8, (c.c_uint * 8)(0x8CE2, 0, 0x8CE0, 0, 0, 0x8CE7, 0, 0))
    raw("glUseProgram", host["program"].glo)
    raw("glBindVertexArray", host["vao"].glo)
    buffers = [b.glo for b in host["buffers"]]
    for i in range(UBOS):
        raw("glBindBufferRange", 0x8A11, i, buffers[i], 256 * i, 64 + 16 * i)
    raw("glBindBufferBase", 0x8A11, 3, buffers[3])
    for i in range(SSBOS):
        raw("glBindBufferRange", 0x90D2, i, buffers[8 + i], 256 * (i + 1), 32 + 16 * i)
    raw("glBindBufferBase", 0x90D2, 5, buffers[13])
    targets = (0x8892, 0x8F36, 0x8F37, 0x88EB, 0x88EC, 0x8F3F, 0x90EE, 0x8A11, 0x90D2)
    for k, target in enumerate(targets):
        raw("glBindBuffer", target, buffers[14 + k % 10])
    raw("glBindRenderbuffer", 0x8D41, host["renderbuffer"].glo)
    for i in range(IMAGES):
        source = host["3d" if i % 2 else "2d"][i]
        access, kind = (0x88B8, 0x88B9, 0x88BA)[i % 3], 0x8058 if i % 2 else 0x8236
        raw("glBindImageTexture", i, source.glo, 0, i % 2, i % 3, access, kind)
    for row, unit in enumerate((*range(UNITS), ctx.default_texture_unit)):
        raw("glActiveTexture", 0x84C0 + unit)
        for target, name in zip(TARGETS, ("2d", "3d", "cube", "array"), strict=True):
            raw("glBindTexture", target, host[name][row].glo)
        host["samplers"][row].use(unit)
    raw("glActiveTexture", 0x84C0 + 5)
    for i in range(8):
        raw("glEnablei" if i % 2 else "glDisablei", 0x0BE2, i)
        raw("glBlendEquationSeparatei", i, 0x800A + i % 2, 0x8007 + i % 2)
        raw("glBlendFuncSeparatei", i, 0x0300 + i % 4, 1, 0x0306, 0x0302 + i % 2)
        raw("glColorMaski", i, i & 1, i >> 1 & 1, i >> 2 & 1, 1 - (i & 1))
    for k, cap in enumerate(CAPABILITIES[:-1]):  # all but raster discard
        if cap not in (0x0B44, 0x8642, 0x809D, 0x0C11):
            raw("glEnable" if k % 3 else "glDisable", cap)
    raw("glEnable", 0x0B90)
    raw("glDepthMask", 0)
    raw("glPrimitiveRestartIndex", 12345)
    raw("glPatchParameteri", 0x8E72, 7)
    raw("glLogicOp", 0x1506)
    raw("glStencilFuncSeparate", 0x0404, 0x0201, 3, 0xF0)
    raw("glStencilFuncSeparate", 0x0405, 0x0204, 5, 0x0F)
    raw("glStencilOpSeparate", 0x0404, 0x1E01, 0x1E02, 0x1E03)
    raw("glStencilOpSeparate", 0x0405, 0x8507, 0x150A, 0x8508)
    raw("glStencilMaskSeparate", 0x0404, 0x3C)
    raw("glStencilMaskSeparate", 0x0405, 0xC3)
    raw("glClearStencil", 9)
    raw("glClipControl", 0x8CA2, 0x935F)
    raw("glClampColor", 0x891C, 0)
    for k, name in enumerate((0x0D02, 0x0D03, 0x0D04, 0x806B, 0x806C, 0x0CF2, 0x0CF3, 0x0CF4, 0x806D, 0x806E)):
        raw("glPixelStorei", name, 3 + k)
    raw("glPixelStorei", 0x0D05, 2)
    raw("glPixelStorei", 0x0CF5, 8)
    raw("glPixelStorei", 0x0D00, 1)
    raw("glPixelStorei", 0x0CF1, 1)
    raw("glClearColor", 0.1, 0.2, 0.3, 0.4)
    raw("glBlendColor", 0.5, 0.6, 0.7, 0.8)
    raw("glClearDepth", 0.3)
    raw("glDepthRange", 0.1, 0.7)
    raw("glPointSize", 3.0)
    raw("glMinSampleShading", 0.25)


def arbitrary_work(gpu: Gpu) -> None:
    """What a renderer does, and more, through moderngl and the Gpu."""
    ctx = gpu.ctx
    scope = gpu.scope("work")
    gpu.begin_frame()
    color, depth = scope.texture((32, 32), "rgba16f"), scope.texture((32, 32), "depth32f")
    fbo = scope.framebuffer([color], depth)
    fbo.use()
    fbo.viewport, fbo.scissor = (0, 0, 20, 20), (1, 1, 4, 4)
    fbo.clear(depth=0.0)
    gpu.state(depth_test=True, blend="alpha", cull="back", wireframe=True).apply()
    ctx.enable_only(moderngl.BLEND | moderngl.DEPTH_TEST)
    ctx.enable(moderngl.RASTERIZER_DISCARD)
    ctx.blend_equation, ctx.blend_func = moderngl.MAX, moderngl.ADDITIVE_BLENDING
    ctx.front_face, ctx.cull_face, ctx.depth_func, ctx.multisample = "ccw", "back", "<", True
    ctx.polygon_offset, ctx.wireframe, ctx.provoking_vertex = (3.0, 4.0), False, moderngl.LAST_VERTEX_CONVENTION
    ctx.patch_vertices, ctx.depth_clamp_range = 4, (0.2, 0.3)
    volume, layers = scope.texture((8, 8, 8), "rgba8"), scope.texture((8, 8), "rgba8", layers=3)
    sampler, cube = scope.sampler(), ctx.texture_cube((4, 4), 4)
    for unit in (*range(UNITS), ctx.default_texture_unit):
        for texture in (color, volume, layers, cube):
            texture.use(unit)
        sampler.use(unit)
    for i in range(UBOS):
        scope.buffer(np.arange(64, dtype=np.float32)).bind_to_uniform_block(i)
    for i in range(SSBOS):
        volume.bind_to_image(i)
        scope.buffer(np.arange(64, dtype=np.float32)).bind_to_storage_buffer(i)
    gpu.shaders.add_virtual("test/guard.vert", "void main() { gl_Position = vec4(0.5); }")
    gpu.shaders.add_virtual("test/guard.frag", "layout(location = 0) out vec4 o; void main() { o = vec4(0.5); }")
    program = scope.program("test/guard.vert", "test/guard.frag")
    array = scope.vertex_array(program, [], index=scope.buffer(np.zeros(3, np.uint32)))
    array.render(moderngl.POINTS, vertices=1)
    fbo.read(components=4, dtype="f2")
    volume.read()
    color.write(np.zeros((32, 32, 4), np.float16))
    ctx.detect_framebuffer(0).use()
    cube.release()
    gpu.leave(fbo)
    scope.release()
    gpu.end_frame()


def differences(before: dict[str, Any], after: dict[str, Any]) -> dict[str, tuple[Any, Any]]:
    return {name: (before[name], after[name]) for name in before if before[name] != after[name]}


@pytest.mark.parametrize("odd", [True, False])
def test_everything_is_restored(gpu: Gpu, host: dict[str, Any], odd: bool) -> None:
    raw, ctx = Raw(gpu), gpu.ctx
    with StateGuard(gpu, UNITS, UBOS, SSBOS, IMAGES) as outer:
        if odd:
            set_everything_odd(raw, ctx, host)
        assert ctx.error == "GL_NO_ERROR"
        guard = StateGuard(gpu, UNITS, UBOS, SSBOS, IMAGES)
        before = snapshot(raw, ctx)
        with guard:
            arbitrary_work(gpu)
            assert len(differences(before, snapshot(raw, ctx))) > (100 if odd else 3)
        assert differences(before, snapshot(raw, ctx)) == {}
        assert guard.errors == ()
        if odd:
            assert host["fbo"].viewport == (1, 2, 11, 5)
            assert host["fbo"].scissor == (2, 1, 5, 3)
    assert outer.errors == ()


def test_without_multi_bind(gpu: Gpu, host: dict[str, Any]) -> None:
    raw = Raw(gpu)
    with StateGuard(gpu):
        set_everything_odd(raw, gpu.ctx, host)
        guard = StateGuard(gpu)
        guard.multi_bind = False  # as in OpenGL 4.3 without the extension
        before = snapshot(raw, gpu.ctx)
        with guard:
            arbitrary_work(gpu)
        assert differences(before, snapshot(raw, gpu.ctx)) == {}


def test_nested_and_on_exception(gpu: Gpu, host: dict[str, Any]) -> None:
    raw = Raw(gpu)
    guard = StateGuard(gpu)
    with StateGuard(gpu):
        before = snapshot(raw, gpu.ctx)
        with pytest.raises(ZeroDivisionError), guard:
            set_everything_odd(raw, gpu.ctx, host)
            inner = snapshot(raw, gpu.ctx)
            with guard:
                arbitrary_work(gpu)
            assert differences(inner, snapshot(raw, gpu.ctx)) == {}
            raise ZeroDivisionError
        assert differences(before, snapshot(raw, gpu.ctx)) == {}


def test_target_of_the_host_keeps_its_viewport(gpu: Gpu, host: dict[str, Any]) -> None:
    target = host["read fbo"]
    target.viewport, target.color_mask = (1, 1, 3, 3), ((True, False, True, True), (True, True, True, True))
    depth_mask = target.depth_mask
    with StateGuard(gpu, framebuffers=(target,)):
        target.use()
        target.viewport, target.depth_mask, target.scissor = (0, 0, 16, 8), not depth_mask, (1, 1, 2, 2)
        target.color_mask = ((True,) * 4,) * 2
    assert target.viewport == (1, 1, 3, 3)
    assert target.depth_mask is depth_mask
    assert target.scissor == (0, 0, 16, 8)
    assert target.color_mask == ((True, False, True, True), (True, True, True, True))


def test_a_host_that_released_its_bound_framebuffer(gpu: Gpu) -> None:
    """moderngl would bind the dead name again and again, an error of each of our frames."""
    ctx: Any = gpu.ctx
    with StateGuard(gpu):
        dead = ctx.simple_framebuffer((8, 8))
        dead.use()
        dead.release()
        guard = StateGuard(gpu)
        for _ in range(2):
            with guard:
                arbitrary_work(gpu)
            assert (guard.errors_before, guard.errors) == ((), ())
        assert ctx.fbo is not dead


def test_errors_are_reported_and_cleared(gpu: Gpu, caplog: pytest.LogCaptureFixture) -> None:
    raw = Raw(gpu)
    guard = StateGuard(gpu)
    raw("glEnable", 0x1)
    with caplog.at_level(logging.WARNING), guard:
        assert guard.errors_before == ("GL_INVALID_ENUM",)
        raw("glEnable", 0x2)
    assert guard.errors == ("GL_INVALID_ENUM",)
    assert gpu.ctx.error == "GL_NO_ERROR"
    assert "left by the host" in caplog.text
    assert "our own frame" in caplog.text
    with guard:
        pass
    assert guard.errors == ()


def test_every_binding_of_the_shaders_is_covered(gpu: Gpu) -> None:
    """Binding points of the registry, those that are a pass's own among them; shaders have no others."""
    guard = StateGuard(gpu)
    covered = {
        "uniform block": guard.ubos, "storage buffer": guard.ssbos, "image": guard.images,
        "texture unit": len(guard.units) - 1,
    }  # fmt: skip
    for name, point in points().items():
        assert point < covered[point.kind], f"{name} is used, but only 0..{covered[point.kind] - 1} are restored"
    for kind, own in OWN.items():
        assert max(own) < covered[kind], kind
