"""Textures, buffers, framebuffers, owners, state and clip control."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from planetfall.engine.gpu import FormatError, Gpu, GpuError
from planetfall.engine.gpu import gl as G
from planetfall.engine.gpu.textures import FORMATS


@pytest.mark.parametrize("name", FORMATS)
def test_each_format_is_what_it_says(gpu, scope, name):
    kind = FORMATS[name]
    texture = scope.texture((8, 4), name, levels=1)
    texture.use(0)
    get = gpu.gl.function("glGetTexLevelParameteriv", None, G.enum, G.int_, G.enum, G.c.POINTER(G.int_))
    value = G.int_()
    get(G.TEXTURE_2D, 0, 0x1003, value)  # GL_TEXTURE_INTERNAL_FORMAT
    assert value.value == kind.internal
    framebuffer = scope.framebuffer([] if kind.is_depth else [texture], texture if kind.is_depth else None)
    assert framebuffer.size == (8, 4)
    if not kind.is_depth:
        data = np.random.default_rng(3).integers(0, 200, 8 * 4 * kind.texel_bytes, np.uint8)
        filled = scope.texture((8, 4), name, data)
        assert filled.read() == data.tobytes()
        mips = scope.texture((8, 4), name, levels=4, layers=3)
        assert mips.extra.bytes == (32 + 8 + 2 + 1) * 3 * kind.texel_bytes
        scope.texture((8, 4, 6), name, levels=2, wrap="repeat")


def test_all_levels_can_be_written_and_fetched(scope, run_compute):
    texture = scope.texture((8, 8), "r32ui", levels=4)
    for level in range(4):
        n = 8 >> level
        texture.write(np.full(n * n, 10 + level, np.uint32).tobytes(), level=level)
    out = run_compute("y = texelFetch(t, ivec2(0), int(index)).x; n = textureQueryLevels(t);", {},
                      {"y": "uint", "n": "int"}, count=4, setup=lambda _: texture.use(3),
                      header="layout(binding = 3) uniform usampler2D t;")  # fmt: skip
    np.testing.assert_array_equal(out["y"], [10, 11, 12, 13])
    assert (out["n"] == 4).all()


def test_generate_mipmaps_keeps_the_filter(gpu, scope):
    texture = scope.texture((4, 4), "r32f", np.arange(16, dtype="f4"), levels=3, filter="linear")
    before = texture.filter
    gpu.generate_mipmaps(texture)
    assert texture.filter == before
    assert np.frombuffer(texture.read(level=2), "f4")[0] == pytest.approx(7.5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (((0, 4), "r8"), "at least 1 texel"),
        (((4, 4), "rgba16"), r"unknown texture format 'rgba16': did you mean .*rgba16f"),
        (((10**6, 4), "r8"), r"beyond this GPU's limit of \d+ texels"),
        (((4, 4, 10**6), "r8"), r"beyond this GPU's limit of \d+ texels"),
        (((4, 4), "r8", None, 1, 10**6), "layers are beyond"),
        (((4, 4), "r8", b"123"), "needs 16 bytes of data, found 3"),
        (((4, 4), "r8", None, 4), "1 to 3 levels"),
        (((4, 4), "r8ui", None, 1, 1, "linear"), "integers: they cannot be filtered"),
        (((4, 4), "r8", None, 1, 1, "cubic"), "filter is one of nearest"),
        (((4, 4), "depth32f", None, 1, 2), "two-dimensional"),
        (((4,), "r8"), r"must be \(width, height\)"),
    ],
)
def test_bad_textures_are_explained(scope, arguments, message):
    with pytest.raises(FormatError, match=message):
        scope.texture(*arguments)
    assert scope.counts() == {}


def test_bad_buffers_and_framebuffers_are_explained(scope):
    with pytest.raises(FormatError, match="at least 1 byte"):
        scope.buffer()
    a, b = scope.texture((4, 4), "r8"), scope.texture((8, 4), "r8")
    with pytest.raises(FormatError, match=r"one size, found \[\(4, 4\), \(8, 4\)\]"):
        scope.framebuffer([a, b])
    with pytest.raises(FormatError, match="none"):
        scope.framebuffer()


def test_every_object_is_counted_and_really_freed(gpu):
    gpu.shaders.add_virtual("test/white.frag", "out vec4 o; void main() { o = vec4(1); }")
    before = gpu.counts()
    scope = gpu.scope("counted")
    texture = scope.texture((4, 4), "rgba8")
    buffer = scope.buffer(reserve=16)
    framebuffer = scope.framebuffer([texture])
    scope.sampler()
    screen = scope.fullscreen("test/white.frag")
    framebuffer.use()
    screen.render()
    assert gpu.counts()["counted"] == {
        "texture": 1, "buffer": 1, "framebuffer": 1, "sampler": 1, "program": 1, "vertex_array": 1,
    }  # fmt: skip
    names = {"Texture": texture.glo, "Buffer": buffer.glo, "Framebuffer": framebuffer.glo}
    names["Program"] = screen.program.mgl.glo
    assert all(gpu.gl.is_object(kind, name) for kind, name in names.items())
    extra = scope.buffer(reserve=4)
    extra.release()
    assert gpu.counts()["counted"]["buffer"] == 1
    scope.release()
    scope.release()
    assert gpu.counts() == before
    assert not any(gpu.gl.is_object(kind, name) for kind, name in names.items())
    with pytest.raises(GpuError, match="scope of 'counted' was released"):
        scope.buffer(reserve=4)
    assert gpu.ctx.error == "GL_NO_ERROR"


def test_a_bound_framebuffer_can_be_freed(gpu, scope):
    framebuffer = scope.framebuffer([scope.texture((4, 4), "r8")])
    framebuffer.use()
    scope.free(framebuffer)
    other = scope.framebuffer([scope.texture((4, 4), "r8")])  # moderngl binds the one in use again here
    other.clear(1.0)
    assert gpu.ctx.error == "GL_NO_ERROR"


def _enabled(gpu: Gpu, capability: int) -> bool:
    return bool(gpu.gl.function("glIsEnabled", G.boolean, G.enum)(capability))


def test_states_are_shared_and_applied(gpu, scope):
    framebuffer = scope.framebuffer([scope.texture((4, 4), "r8")], scope.texture((4, 4), "depth32f"))
    framebuffer.use()
    state = gpu.state(depth_test=True, depth_func="==", cull="back", blend="alpha", write_depth=False, wireframe=True)
    assert state is gpu.state(True, "==", "back", "alpha", False, True)
    state.apply()
    assert _enabled(gpu, G.DEPTH_TEST) and _enabled(gpu, G.CULL_FACE) and _enabled(gpu, G.BLEND)
    assert gpu.gl.integer(0x0B74) == 0x202 and gpu.gl.integer(0x0B72) == 0  # depth func, mask
    assert gpu.gl.integer(0x0B40) == G.LINE
    gpu.default_state.apply()
    assert not any(_enabled(gpu, c) for c in (G.DEPTH_TEST, G.CULL_FACE, G.BLEND))
    assert gpu.gl.integer(0x0B40) == G.FILL and gpu.gl.integer(0x0B72) == 1
    with gpu.raster_state(depth="greater"):
        assert gpu.gl.integer(0x0B74) == 0x206
    assert not _enabled(gpu, G.DEPTH_TEST)
    with pytest.raises(ValueError, match="unknown blend 'screen': expected one of alpha"):
        gpu.state(blend="screen")
    with pytest.raises(ValueError, match="unknown depth_func '=>'"):
        gpu.state(depth_func="=>")


def test_frame_sets_clip_control_and_gives_it_back(gpu):
    gl = gpu.gl
    if not gpu.caps.has_clip_control:
        pytest.skip("this driver has no ARB_clip_control")
    gl.clip_control(G.LOWER_LEFT, G.NEGATIVE_ONE_TO_ONE)
    gl.enable(G.SCISSOR_TEST)
    gl.enable(G.STENCIL_TEST)
    with gpu.frame():
        assert gl.integer(G.CLIP_DEPTH_MODE) == G.ZERO_TO_ONE
        assert not _enabled(gpu, G.SCISSOR_TEST) and not _enabled(gpu, G.STENCIL_TEST)
        with gpu.frame():
            pass
        assert gl.integer(G.CLIP_DEPTH_MODE) == G.ZERO_TO_ONE
    assert gl.integer(G.CLIP_DEPTH_MODE) == G.NEGATIVE_ONE_TO_ONE
    with pytest.raises(RuntimeError, match="boom"), gpu.frame():
        raise RuntimeError("boom")
    assert gl.integer(G.CLIP_DEPTH_MODE) == G.NEGATIVE_ONE_TO_ONE


def test_work_is_counted(gpu, scope):
    gpu.shaders.add_virtual("test/white.frag", "out vec4 o; void main() { o = vec4(1); }")
    gpu.shaders.add_virtual("test/nothing.comp", "layout(local_size_x = 8, local_size_y = 4) in; void main() {}")
    screen, compute = scope.fullscreen("test/white.frag"), scope.compute("test/nothing.comp")
    scope.framebuffer([scope.texture((4, 4), "r8")]).use()
    buffer = scope.buffer(reserve=16, dynamic=True)
    gpu.work.reset()
    screen.render()
    compute.run()
    compute.run_over(9, 5)
    assert compute.local_size == (8, 4, 1)
    gpu.upload(buffer, np.zeros(4, "f4"))
    assert gpu.work.snapshot() == {
        "draws": 1, "dispatches": 2, "uploads": 1, "upload_bytes": 16, "programs_built": 0,
    }  # fmt: skip


def test_render_indirect_reads_commands(gpu, scope):
    gpu.shaders.add_virtual("test/count.frag", "out vec4 o; void main() { o = vec4(0.25); }")
    program = scope.program("common/fullscreen.vert", "test/count.frag")
    vertices = scope.vertex_array(program)
    texture = scope.texture((4, 4), "r32f")
    framebuffer = scope.framebuffer([texture])
    framebuffer.clear()
    commands = scope.buffer(np.array([[3, 0, 0, 0, 0], [3, 1, 0, 0, 0], [3, 1, 0, 0, 0]], "u4"))
    with gpu.frame():
        framebuffer.use()
        gpu.state(blend="additive").apply()
        vertices.render_indirect(commands, moderngl.TRIANGLES, count=2)
    np.testing.assert_array_equal(np.frombuffer(texture.read(), "f4"), np.full(16, 0.25, "f4"))


def test_a_clear_fills_integers_and_floats_alike(gpu, scope):
    color, number = scope.texture((4, 4), "rgba8"), scope.texture((4, 4), "r8ui")
    depth = scope.texture((4, 4), "depth32f")
    color.write(b"\xff" * 64)
    number.write(b"\x07" * 16)
    framebuffer = scope.framebuffer([color, number], depth)
    with gpu.frame():
        framebuffer.use()
        gpu.state(depth_test=True, depth_func="always").apply()
        gpu.clear(framebuffer, depth=0.25)
    assert color.read() == bytes(64) and number.read() == bytes(16)
    np.testing.assert_array_equal(np.frombuffer(depth.read(), "f4"), np.full(16, 0.25, "f4"))
    assert gpu.ctx.error == "GL_NO_ERROR"


def test_colours_are_copied_into_the_viewport_alone(gpu, scope):
    pixels = np.random.default_rng(5).integers(0, 255, (3, 5, 4), np.uint8)
    source = scope.framebuffer([scope.texture((5, 3), "rgba8", pixels)])
    texture = scope.texture((9, 7), "rgba8", np.zeros((7, 9, 4), np.uint8))
    target = scope.framebuffer([texture])
    with gpu.frame():
        target.use()
        assert not gpu.copy_color(source, target), "another size takes a draw"
        target.viewport = (2, 3, 5, 3)
        target.use()
        assert gpu.copy_color(source, target)
    wanted = np.zeros((7, 9, 4), np.uint8)
    wanted[3:6, 2:7] = pixels
    np.testing.assert_array_equal(np.frombuffer(texture.read(), np.uint8).reshape(7, 9, 4), wanted)


@pytest.mark.parametrize("kind", ["samples", "colours"])
def test_what_a_copy_would_spoil_takes_a_draw(gpu, scope, kind):
    source = scope.framebuffer([scope.texture((5, 3), "rgba8")])
    ctx = gpu.ctx
    parts = [ctx.texture((5, 3), 4, samples=4)] if kind == "samples" else [ctx.texture((5, 3), 4) for _ in range(2)]
    target = ctx.framebuffer(parts)
    with gpu.frame():
        target.use()
        assert not gpu.copy_color(source, target)
    gpu.leave(target)
    for obj in (target, *parts):
        obj.release()
    assert ctx.error == "GL_NO_ERROR"
