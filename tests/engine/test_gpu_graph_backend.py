"""The frame graph on OpenGL: a small frame through compute, raster and history, counted and freed."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.gpu import FormatError
from planetfall.engine.gpu.graph_backend import GLBackend
from planetfall.engine.gpu.textures import FORMATS
from planetfall.engine.gpu.timers import DELAY, GpuTimers
from planetfall.engine.graph import BarrierKind, BufferSpec, GraphBackend, GraphBuilder, PassTimers, TextureSpec
from planetfall.engine.graph.resources import BYTES_PER_TEXEL

FILL = """
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) writeonly uniform image2D target;
layout(std430, binding = 0) buffer Total { uint total; };
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, imageSize(target)))) return;
    imageStore(target, p, vec4(float(p.x + 100 * p.y)));
    atomicAdd(total, 1u);
}
"""
SHADE = """
layout(binding = 0) uniform sampler2D source;
layout(binding = 1) uniform sampler2D last;
layout(std430, binding = 0) buffer Total { uint total; };
out vec4 o;
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    o = vec4(texelFetch(source, p, 0).x, float(total), texelFetch(last, p, 0).z + 1.0, 1.0);
}
"""


def small_frame(scope, backend, size):
    gpu = scope.gpu
    gpu.shaders.add_virtual("test/fill.comp", FILL)
    gpu.shaders.add_virtual("test/shade.frag", SHADE)
    fill, shade = scope.compute("test/fill.comp"), scope.fullscreen("test/shade.frag")
    zero = np.zeros(1, "u4")

    def bind_fill(io):
        target, total = io.texture("values"), io.buffer("total")

        def run():
            total.write(zero)
            target.bind_to_image(0, read=False, write=True)
            total.bind_to_storage_buffer(0)
            fill.run_over(*target.size)

        return run

    def bind_shade(io):
        source, last, total, valid = io.texture("values"), io.history("shaded"), io.buffer("total"), io.history_valid
        framebuffer = io.framebuffer(colors=("shaded",), depth="depth")

        def run():
            if not valid.value:
                last.write(np.zeros((*reversed(last.size), 4), "f4"))
            framebuffer.use()
            source.use(0)
            last.use(1)
            total.bind_to_storage_buffer(0)
            shade.render()

        return run

    builder = GraphBuilder()
    made = (TextureSpec("values", "r32f"), BufferSpec("total", 16))
    builder.add_pass("fill", bind=bind_fill, creates=made, kind="compute")
    builder.add_pass(
        "shade",
        bind=bind_shade,
        creates=(TextureSpec("shaded", "rgba32f", lifetime="history"), TextureSpec("depth", "depth32f")),
        reads=("values", "total"),
        history=("shaded",),
    )
    builder.export("shaded")
    return builder.compile(backend, size)


def test_a_frame_runs_and_leaves_nothing(gpu, scope):
    owner = gpu.scope("graph")
    backend = GLBackend(owner)
    assert isinstance(backend, GraphBackend)
    assert backend.max_texture_size == gpu.caps.max_texture_size
    plan = small_frame(scope, backend, (12, 10))
    assert gpu.counts()["graph"] == {"texture": 4, "buffer": 1, "framebuffer": 2}
    for frame in range(1, 4):
        shown = plan.resource("shaded")
        plan.execute()
        shown = plan.resource("shaded")
        picture = np.frombuffer(shown.read(), "f4").reshape(10, 12, 4)
        np.testing.assert_array_equal(picture[..., 0], np.arange(12) + 100 * np.arange(10)[:, None])
        np.testing.assert_array_equal(picture[0, 0, 1:3], [120, frame])
    assert plan.memory_bytes() == 12 * 10 * (4 + 4 + 2 * 16) + 16
    plan.resize((20, 6))
    plan.execute()
    picture = np.frombuffer(plan.resource("shaded").read(), "f4").reshape(6, 20, 4)
    np.testing.assert_array_equal(picture[0, 0, 1:3], [120, 1])
    assert gpu.counts()["graph"] == {"texture": 4, "buffer": 1, "framebuffer": 2}
    assert gpu.ctx.error == "GL_NO_ERROR"
    plan.release()
    assert "graph" not in gpu.counts()
    owner.release()


def test_times_come_late_without_waiting(gpu, scope):
    owner = gpu.scope("graph")
    plan = small_frame(scope, GLBackend(owner), (16, 16))
    plan.gpu_timing = True
    assert gpu.counts()["graph"]["query"] == 1
    for frame in range(20):
        plan.execute()
        times = [report.gpu_ms for report in plan.passes]
        gpu.ctx.finish()
        if frame < DELAY - 1:
            assert times == [None, None]
    assert all(ms is not None and 0 <= ms < 1000 for ms in times)
    plan.gpu_timing = False
    assert "query" not in gpu.counts()["graph"]
    plan.release()
    owner.release()


def test_timers_with_gaps(gpu):
    timers = GpuTimers(gpu, 3)
    typed: PassTimers = timers
    out: list[float | None] = [-1.0, -1.0, -1.0]
    for frame in range(30):
        typed.begin(0)
        typed.end(0)
        if frame % 2:
            typed.begin(1)  # its pass raised before the end
        if frame >= 12:  # before that the ring may overflow unread
            gpu.ctx.finish()
        typed.collect(out)
    assert isinstance(out[0], float) and out[0] >= 0 and out[1:] == [None, None]
    timers.release()
    timers.release()
    assert gpu.ctx.error == "GL_NO_ERROR"


def test_formats_agree_with_the_graph():
    assert {name: kind.texel_bytes for name, kind in FORMATS.items()} == BYTES_PER_TEXEL


def test_sizes_and_limits(gpu):
    owner = gpu.scope("graph")
    backend = GLBackend(owner)
    spec = TextureSpec("pyramid", "rgba16f", size=(8, 4), levels=10, layers=2, filter="linear", wrap="repeat")
    texture = backend.create_texture(spec, (8, 4))
    assert backend.bytes_of(texture) == spec.bytes_for((8, 4)) == (32 + 8 + 2 + 1) * 2 * 8
    buffer = backend.create_buffer(BufferSpec("b", 100))
    assert backend.bytes_of(buffer) == 100
    volume = TextureSpec("volume", "r16f", size=(4, 4, 4))
    assert backend.bytes_of(backend.create_texture(volume, (4, 4, 4))) == 128
    with pytest.raises(FormatError, match="beyond this GPU's limit"):
        backend.create_texture(spec, (10**6, 4))
    for kinds in (BarrierKind.TEXTURE, BarrierKind.BUFFER, BarrierKind.TEXTURE | BarrierKind.BUFFER):
        backend.barrier(kinds)
    assert gpu.ctx.error == "GL_NO_ERROR"
    backend.release(texture)
    assert gpu.counts()["graph"] == {"buffer": 1, "texture": 1}
    owner.release()
