"""PLANETFALL_VALIDATE=1: what passes declare is what they do, and each lie that is planted is found."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.gpu import Gpu, ShaderError
from planetfall.engine.gpu.context import VALIDATE
from planetfall.engine.gpu.graph_backend import BARRIERS, GLBackend
from planetfall.engine.graph import BufferSpec, GraphBuilder, GraphError, TextureSpec
from planetfall.engine.graph.watching import unused
from planetfall.engine.hosts.headless import create_headless

pytestmark = [
    pytest.mark.gpu,
    pytest.mark.skipif(shutil.which("glslangValidator") is None, reason="glslang is not installed"),
]

STORE = """
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0, r32f) writeonly uniform image2D u_target;
layout(std430, binding = 0) buffer Total { uint total; };
void main() {
    imageStore(u_target, ivec2(gl_GlobalInvocationID.xy), vec4(1.0));
    atomicAdd(total, 1u);
}
"""
COPY = """
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 0) uniform sampler2D u_source;
layout(binding = 0, r32f) writeonly uniform image2D u_copy;
void main() {
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    imageStore(u_copy, p, texelFetch(u_source, p, 0));
}
"""
SHADE = """
layout(binding = 0) uniform sampler2D u_source;
layout(binding = 1) uniform sampler2D u_last;
out vec4 o_color;
void main() {
    ivec2 p = ivec2(gl_FragCoord.xy);
    o_color = texelFetch(u_source, p, 0) + texelFetch(u_last, p, 0);
}
"""


@pytest.fixture
def gpu(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(VALIDATE, "1")
    ctx = create_headless()
    made = Gpu(ctx, [pf.ASSETS / "shaders"])
    yield made
    made.release()
    ctx.release()


class Lies:
    """Two compute passes and a draw; what is said of them, and what they do, can be changed."""

    def __init__(self, gpu: Gpu) -> None:
        self.scope = gpu.scope("test")
        for name, text in (("store.comp", STORE), ("copy.comp", COPY), ("shade.frag", SHADE)):
            gpu.shaders.add_virtual(name, text)
        self.store, self.copy = self.scope.compute("store.comp"), self.scope.compute("copy.comp")
        self.shade = self.scope.fullscreen("shade.frag")
        self.own = self.scope.texture((16, 16), "r32f")
        self.reads = {"copy": ("values",), "shade": ("copied",)}
        self.history: tuple[str, ...] = ("shaded",)
        self.clears = self.overwrites = self.twice = False
        self.private: tuple[bool, bool] | None = None

    def run(self, frames: int = 3):
        size = (16, 16)
        builder = GraphBuilder()
        values, copied = TextureSpec("values", "r32f", size), TextureSpec("copied", "r32f", size)
        builder.add_pass(
            "store", kind="compute", system="test", bind=self.bind_store, creates=(values, BufferSpec("total", 4))
        )
        builder.add_pass(
            "copy", kind="compute", system="test", bind=self.bind_copy, reads=self.reads["copy"], after=("store",),
            creates=(copied,),
        )  # fmt: skip
        builder.add_pass(
            "shade", system="test", bind=self.bind_shade, reads=self.reads["shade"], after=("copy",),
            history=self.history, creates=(TextureSpec("shaded", "rgba32f", size, "history"),),
        )  # fmt: skip
        builder.export("shaded")
        builder.export("values")
        plan = builder.compile(GLBackend(self.scope), size)
        for _ in range(frames):
            plan.execute()
        return plan

    def bind_store(self, io):
        self.values = values = io.texture("values")
        self.total = total = io.buffer("total")

        def run():
            if self.clears:
                total.write(np.zeros(1, "u4"))
            (self.own if self.private else values).bind_to_image(0, read=False, write=True)
            total.bind_to_storage_buffer(0)
            for _ in range(2 if self.twice else 1):
                self.store.run_over(16, 16)
            if self.private and self.private[0]:
                self.scope.gpu.barrier()

        return run

    def bind_copy(self, io):
        copied = io.texture("copied")

        def run():
            (self.own if self.private else self.values).use(0)
            (self.values if self.overwrites else copied).bind_to_image(0, read=False, write=True)
            self.copy.run_over(16, 16)

        return run

    def bind_shade(self, io):
        framebuffer, copied = io.framebuffer(colors=("shaded",)), self.values
        last = io.history("shaded") if self.history else self.own
        copied = io.texture("copied") if self.reads["shade"] else self.values

        def run():
            framebuffer.use()
            copied.use(0)
            last.use(1)
            self.shade.render()

        return run


def test_a_graph_that_says_what_it_does(gpu: Gpu):
    plan = Lies(gpu).run()
    assert unused([plan.watching]) == []


def test_without_the_switch_nobody_listens(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delenv(VALIDATE, raising=False)
    ctx = create_headless()
    gpu = Gpu(ctx, [pf.ASSETS / "shaders"])
    assert gpu.watch is None and gpu.shaders.check is None and Lies(gpu).run().watching is None
    gpu.release()
    ctx.release()


def test_an_undeclared_read(gpu: Gpu):
    lies = Lies(gpu)
    lies.reads["copy"] = ()
    with pytest.raises(GraphError, match=r"pass 'copy' .* reads 'values' \('u_source' of copy.comp\).*reads="):
        lies.run()


def test_an_undeclared_write(gpu: Gpu):
    lies = Lies(gpu)
    lies.overwrites = True
    with pytest.raises(GraphError, match=r"pass 'copy' .* writes 'values' \('u_copy' of copy.comp\).*writes="):
        lies.run()


def test_a_draw_from_what_was_not_declared(gpu: Gpu):
    lies = Lies(gpu)
    lies.reads["shade"] = ()
    with pytest.raises(GraphError, match=r"pass 'shade' .* reads 'values' \('u_source' of shade.frag\)"):
        lies.run()


def test_what_is_declared_and_never_done(gpu: Gpu):
    lies = Lies(gpu)
    lies.reads["shade"] = ("copied", "total")
    assert unused([lies.run().watching]) == ["pass 'shade' declares that it reads 'total' and never does"]


def test_the_processor_writes_too(gpu: Gpu):
    lies = Lies(gpu)
    lies.clears = True
    assert unused([lies.run().watching]) == []


@pytest.mark.parametrize("waits", [True, False])
def test_an_object_of_no_graph_needs_a_barrier_of_its_own(gpu: Gpu, waits: bool):
    lies = Lies(gpu)
    lies.private, lies.reads["copy"] = (waits, True), ()
    if waits:
        lies.run()
    else:
        with pytest.raises(GraphError, match=r"pass 'copy' .* \('u_source' of copy.comp\).*store.comp has stored"):
            lies.run()


def test_two_dispatches_of_a_pass_that_add_to_the_same_need_a_barrier_between(gpu: Gpu):
    lies = Lies(gpu)
    lies.twice = True
    with pytest.raises(GraphError, match=r"pass 'store' .*'Total' of store.comp.*Gpu.barrier\(\)"):
        lies.run()


@pytest.mark.parametrize(
    ("text", "why"),
    [
        (COPY.replace("ivec2 p", "float length = 1.0; ivec2 p"), "'length'"),
        (COPY.replace("ivec2 p", "float x = 1; ivec2 p"), "cannot convert"),
        (
            COPY.replace("void", "shared vec4 s_all[4096];\nvoid").replace("ivec2 p", "s_all[0] = vec4(0.0); ivec2 p"),
            "bytes that a work group shares: 65536 of at most 32768",
        ),
        (COPY.replace("ivec2 p", "if (gl_LocalInvocationIndex > 3u) return; barrier(); ivec2 p"), "barrier"),
    ],
)
def test_a_shader_that_others_may_refuse(gpu: Gpu, text: str, why: str):
    gpu.shaders.add_virtual("other.comp", text)
    with pytest.raises(ShaderError, match=f"(?s)other compilers may refuse it.*{why}"):
        gpu.scope("test").compute("other.comp")


# -- the product ----------------------------------------------------------------------------------------------------

CONTRACTS = {
    "atmosphere.camera", "atmosphere.first", "atmosphere.second", "atmosphere.extinction", "clouds.shadow",
    "clouds.sky", "clouds.view", "shadows.map", "shadows.windows",
}  # fmt: skip
"""What implements a contract is bound for every pass that includes one: which of it a shader reads is the affair of who
implements it."""


def frames(scene: pf.Scene, quality: str, views: tuple[str, ...], overrides=None, count: int = 3):
    """Runs them; what each plan has watched."""
    found = []
    with pf.Renderer(scene, (96, 54), quality, overrides) as renderer:
        for name in views:
            for _ in range(count):
                renderer.render(pf.view(name), dt_s=0.03)
                found.append(renderer.graph.watching)
    return found


def test_passes_do_what_they_declare_and_their_shaders_pass(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv(VALIDATE, "1")
    assert len(frames(pf.load_scene("earth"), "low", ("near", "under"))) == 6


@pytest.mark.slow
def test_nothing_is_declared_and_never_done(monkeypatch: pytest.MonkeyPatch):
    from planetfall.benchmarks.measure.descent import descent

    monkeypatch.setenv(VALIDATE, "1")
    scene = pf.load_scene("earth")
    views = ("near", "coast", "beach", "under", "orbit", "limb", "shafts", "cloud_shadows", "night")
    found = frames(scene, "low", views)
    flight = descent(scene, 60, 44.0, 48.0)
    with pf.Renderer(scene, (96, 54), "low") as renderer:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        for camera in flight.cameras[1:]:
            renderer.render(camera, sun=flight.sun, dt_s=flight.frame_s)
            found.append(renderer.graph.watching)
        for camera in flight.cameras[::-6]:  # so fast that no snap is prepared
            renderer.render(camera, sun=flight.sun, dt_s=6.0 * flight.frame_s)
            found.append(renderer.graph.watching)
    left = [text for text in unused(found) if not any(repr(name) in text for name in CONTRACTS)]
    assert left == []


@pytest.mark.slow
@pytest.mark.parametrize("planet", ["asteroid", "earth", "hazy", "mars", "moon", "small"])
@pytest.mark.parametrize("quality", pf.qualities())
def test_every_program_of_every_planet_passes(monkeypatch: pytest.MonkeyPatch, planet: str, quality: str):
    monkeypatch.setenv(VALIDATE, "1")
    views = ("near", "orbit", "dusk", "under") if planet in ("earth", "hazy", "small") else ("near", "orbit", "dusk")
    frames(pf.load_scene(planet), quality, views, count=2)


def test_barriers_everywhere_change_no_picture(monkeypatch: pytest.MonkeyPatch):
    """On a processor none can be missed; on a GPU this is the test of them."""
    scene = pf.load_scene("earth")

    def pictures() -> list[np.ndarray]:
        with pf.Renderer(scene, (96, 54), "low") as renderer:
            renderer.settle(pf.view("space"))  # the air's tables
            return [renderer.render(pf.view("coast"), dt_s=0.03, outputs=("radiance",))["radiance"] for _ in range(4)]

    as_compiled = pictures()
    monkeypatch.setenv(BARRIERS, "ALL")
    for shown, expected in zip(pictures(), as_compiled, strict=True):
        np.testing.assert_array_equal(shown, expected)


def test_every_pass_has_its_barrier_where_that_is_asked_for(monkeypatch: pytest.MonkeyPatch, gpu: Gpu):
    monkeypatch.setenv(BARRIERS, "all")
    plan = Lies(gpu).run(1)
    assert [barrier is not None for _, _, barrier in plan._running[0]] == [True] * 3
