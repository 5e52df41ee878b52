"""Nothing grows: resizes, renderers that come and go, presets, long flights; lost contexts. Short here, whole with
--slow."""

from __future__ import annotations

import ctypes
import gc
import os
import random
from collections.abc import Callable
from pathlib import Path

import moderngl
import numpy as np
import pytest

import planetfall as pf
from planetfall.app.tweak_store import SceneStore
from planetfall.engine.gpu.gl import GL
from planetfall.engine.hosts.headless import create_headless
from planetfall.scene.presets import load_parts
from planetfall.systems.tweak import Workbench

pytestmark = pytest.mark.gpu

SIZE = (48, 27)
whole = pytest.param(1.0, marks=[pytest.mark.slow, pytest.mark.timeout(3600)], id="whole")
short = pytest.param(0.02, id="short")


def resident_mib() -> float:
    return int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


def live_objects(ctx: moderngl.Context) -> dict[str, int]:
    """How many objects of each kind there are in the context, asked name by name of OpenGL itself."""
    gl = GL(ctx)
    probes = (ctx.buffer(reserve=4), ctx.texture((1, 1), 1), ctx.renderbuffer((1, 1)))
    highest = 200 + max(probe.glo for probe in probes)  # framebuffers, programs and arrays are fewer than these
    for probe in probes:
        probe.release()
    kinds = ("Buffer", "Texture", "Framebuffer", "Renderbuffer", "VertexArray", "Sampler", "Query", "Program", "Shader")
    found = {}
    for kind in kinds:
        exists = gl.function(f"glIs{kind}", ctypes.c_ubyte, ctypes.c_uint)
        found[kind] = sum(exists(name) for name in range(1, highest))
    return found


def assert_no_more(ctx: moderngl.Context, before: dict[str, int]) -> None:
    """Not equal: whether OpenGL keeps a program with its shaders depends on which was in use last."""
    now = live_objects(ctx)
    more = {kind: (before[kind], count) for kind, count in now.items() if count > before[kind]}
    assert not more, f"kinds of objects and how many there were and are: {more}"


def slope(work: Callable[[int], None], turns: int, allowed_mib: float) -> None:
    """work(turn) for all turns; file handles don't grow, and memory not between the middle and the end (the first half
    fills caches: shaders of sizes and qualities seen first, pools of the allocator)."""
    for turn in range(max(turns // 2, 2)):
        work(turn)
    gc.collect()
    files, memory = open_files(), resident_mib()
    for turn in range(max(turns // 2, 2), max(turns, 4)):
        work(turn)
    gc.collect()
    assert open_files() <= files
    assert resident_mib() - memory < allowed_mib


@pytest.mark.parametrize("share", [short, whole])
def test_resizes(share: float) -> None:
    """From 1 x 1 to 4096 a side, no more than 512 000 pixels at once: those that a software renderer can bear."""
    rng = random.Random(7)
    with pf.load_scene("moon") as scene, pf.Renderer(scene, SIZE, "low") as renderer:
        view = pf.view("near")

        def work(turn: int) -> None:
            width = int(2 ** rng.uniform(0.0, 12.0))
            height = int(2 ** rng.uniform(0.0, min(12.0, np.log2(512_000 / width))))
            renderer.resize((1, 1) if turn == 0 else (4096, 64) if turn == 1 else (width, height))
            if turn % 10 == 0:
                renderer.render(view)

        # Pictures of other shapes show what this one does not, such as stars, whose objects are made when first drawn.
        for turn in range(21):
            work(turn)
        renderer.resize(SIZE)
        renderer.render(view)
        counts = renderer.gpu.counts()
        slope(work, int(1000 * share), 200.0)
        renderer.resize(SIZE)
        assert renderer.render(view)["color"].shape == (SIZE[1], SIZE[0], 3)
        assert renderer.gpu.counts() == counts
        assert renderer.ctx.error == "GL_NO_ERROR"


@pytest.mark.parametrize("share", [short, whole])
def test_renderers_come_and_go(share: float) -> None:
    """In one host's context, and with contexts of their own."""
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture(SIZE, 4)])

    def work(turn: int) -> None:
        with pf.load_scene("moon") as scene:
            with pf.Renderer(scene, SIZE, "low", ctx=None if turn % 4 == 3 else ctx) as renderer:
                if turn % 4 == 3:
                    renderer.render(pf.view("near"))
                else:
                    renderer.render_to(target, pf.view("near"))
            assert renderer.gpu.counts() == {}
        ctx.__enter__()
        assert ctx.error == "GL_NO_ERROR"

    work(0)  # OpenGL may keep the program that was last in use
    before = live_objects(ctx)
    slope(work, int(200 * share), 100.0)
    assert_no_more(ctx, before)
    target.release()
    ctx.release()


@pytest.mark.parametrize("share", [pytest.param(0.006, id="short"), whole])
def test_long_flights(share: float) -> None:
    with pf.load_scene("moon") as scene, pf.Renderer(scene, SIZE, "low") as renderer:
        frames = int(10_000 * share)
        counts: list[dict[str, dict[str, int]]] = []

        def work(turn: int) -> None:
            way = turn / frames
            camera = pf.Camera.at(
                10.0 + 30.0 * way, 360.0 * way, 10.0 ** (5.0 - 3.5 * way), 90.0, -20.0, above="ground"
            )
            renderer.render(camera, 0.02 * turn, dt_s=0.02)
            if turn >= frames // 2:
                counts.append(renderer.gpu.counts())

        slope(work, frames, 60.0)
        textures = [sum(kinds.get("texture", 0) for kinds in c.values()) for c in counts]
        buffers = [sum(kinds.get("buffer", 0) for kinds in c.values()) for c in counts]
        assert max(textures) - min(textures) <= 2 and max(buffers) - min(buffers) <= 4
        assert renderer.ctx.error == "GL_NO_ERROR"


def test_a_lost_context_is_named_and_the_scene_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANETFALL_LOST", str(tmp_path / "lost"))
    scene = pf.load_scene("moon")
    scene.planet[pf.Terrain].highest_m = 9000.0
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture(SIZE, 4)])
    renderer = pf.Renderer(scene, SIZE, "low", ctx=ctx)
    renderer.render_to(target, pf.view("near"))
    monkeypatch.setattr(renderer.context.watch, "status", lambda: 0x8254)  # GL_INNOCENT_CONTEXT_RESET
    with pytest.raises(pf.ContextLostError, match=r"lost by another program.*kept in .*camera was at") as caught:
        renderer.render_to(target, pf.view("near"))
    assert caught.value.saved is not None
    assert pf.load_scene(caught.value.saved).planet[pf.Terrain].highest_m == 9000.0
    with pytest.raises(pf.ContextLostError):
        renderer.render(pf.view("near"))
    assert len(list((tmp_path / "lost").iterdir())) == 1  # kept once
    assert pf.ContextLostError in pf.expected_errors()
    renderer.release()  # of what is gone: no error
    ctx.release()
    with pf.Renderer(scene, SIZE, "low") as again:
        assert again.render(pf.view("near"))["color"].max() > 0


def test_a_lost_context_without_a_place_to_write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "file").write_text("no folder", encoding="utf-8")
    monkeypatch.setenv("PLANETFALL_LOST", str(tmp_path / "file" / "lost"))
    with pf.load_scene("moon") as scene, pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.render(pf.view("near"))
        monkeypatch.setattr(renderer.context.watch, "status", lambda: 0x8253)
        with pytest.raises(pf.ContextLostError, match="could not be written"):
            renderer.render(pf.view("near"))
        assert isinstance(renderer.ctx, moderngl.Context)


@pytest.mark.parametrize("share", [short, whole])
def test_presets_are_switched(share: float) -> None:
    """Planets in place, as the panel does it, and qualities by a renderer anew, as the flight does it."""
    planets, qualities = ("moon", "mars", "asteroid", "small"), ("low", "medium")
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture(SIZE, 4)])
    scene = pf.load_scene("moon")
    bench = Workbench(SceneStore(scene))
    headings = (*(type(part).__name__ for part in load_parts("earth").values()), "Clouds")
    held: list[pf.Renderer] = [pf.Renderer(scene, SIZE, "low", ctx=ctx)]

    def work(turn: int) -> None:
        assert bench.to(load_parts(planets[turn % len(planets)]), "load", headings) == ""
        if turn % 3 == 2:
            held.pop().release()
            held.append(pf.Renderer(scene, SIZE, qualities[turn // 3 % 2], ctx=ctx))
        held[0].render_to(target, pf.Camera.at(20.0, 0.0, scene.planet.radius_m))
        assert ctx.error == "GL_NO_ERROR"

    work(0)
    held.pop().release()
    before = live_objects(ctx)
    held.append(pf.Renderer(scene, SIZE, "low", ctx=ctx))
    slope(work, int(100 * share), 150.0)
    held.pop().release()
    assert_no_more(ctx, before)
    scene.release()
    target.release()
    ctx.release()
