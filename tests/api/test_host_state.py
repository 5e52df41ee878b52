"""A host's GL state and a host's process are what they were before the planet was drawn, whatever the planet has."""

from __future__ import annotations

import gc
import logging
import random
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import esper
import numpy as np
import pytest
import test_guard as guard
from test_endurance_planets import AHEAD, BACK, OVER_MOON, pair

import planetfall as pf
from planetfall.engine.blocks.bindings import points
from planetfall.engine.gpu import Gpu
from planetfall.engine.gpu.guard import StateGuard

host = guard.host
SIZE = (64, 36)


@pytest.fixture
def scene() -> Iterator[pf.Scene]:
    """All that a planet can have, so that all passes run."""
    made = pf.load_scene("earth")
    made.planet.add(pf.Clouds())
    made.add(pf.Transform(position_m=tuple(pf.view("coast", made.planet).position_m)), pf.Shape("box"))
    yield made
    made.release()


@pytest.mark.gpu
def test_no_binding_of_the_host_changes(gpu: Gpu, host: dict[str, Any], scene: pf.Scene) -> None:
    """Every unit, every indexed binding, stencil, masks of eight buffers, clip control, pixel store: odd before, the
    same after each thing that a host may call, through the whole plan."""
    gpu.ctx.__enter__()
    raw, ctx = guard.Raw(gpu), gpu.ctx
    target = ctx.framebuffer([ctx.texture((80, 60), 4)], ctx.depth_renderbuffer((80, 60)))
    target.viewport = (3, 4, 30, 20)
    camera = pf.view("coast")
    steps: list[str] = []
    with StateGuard(gpu, guard.UNITS, guard.UBOS, guard.SSBOS, guard.IMAGES):
        guard.set_everything_odd(raw, ctx, host)
        before = guard.snapshot(raw, ctx)

        def same(step: str) -> None:
            steps.append(step)
            assert guard.differences(before, guard.snapshot(raw, ctx)) == {}, step
            assert ctx.error == "GL_NO_ERROR", step
            assert target.viewport == (3, 4, 30, 20), step

        renderer = pf.Renderer(scene, SIZE, "low", ctx=ctx)
        same("made")
        renderer.render_to(target, camera, viewport=(8, 8, *SIZE))
        same("render_to")
        renderer.render_to(target, camera, viewport=(8, 8, *SIZE), dt_s=0.02, depth=pf.HostDepth(1.0, -0.1))
        same("render_to with depth")
        renderer.render(camera, outputs=("color", "distance", "surface"))
        same("render")
        renderer.pick(camera, 20.0, 30.0)
        same("pick")
        renderer.resize((40, 30))
        same("resize")
        renderer.render(camera)
        assert renderer.stats
        assert renderer.exposure is not None
        same("statistics")
        renderer.reload_shaders()
        same("reload_shaders")
        renderer.system("composite")
        scene.planet.remove(pf.Clouds)
        scene.planet.remove(pf.Ocean)
        renderer.render(camera)
        same("systems left")
        renderer.release()
        same("released")
    assert len(steps) == 10
    assert {key: n for key, n in gpu.counts().items() if key in ("terrain", "ocean", "graph")} == {}
    target.release()


@pytest.mark.gpu
def test_no_binding_of_the_host_changes_with_several_planets(gpu: Gpu, host: dict[str, Any]) -> None:
    """The same where renderers of companions are made, take turns as the camera's, draw discs, and are let go."""
    gpu.ctx.__enter__()
    raw, ctx = guard.Raw(gpu), gpu.ctx
    target = ctx.framebuffer([ctx.texture((80, 60), 4)], ctx.depth_renderbuffer((80, 60)))
    target.viewport = (3, 4, 30, 20)
    steps: list[str] = []
    with pair() as scene, StateGuard(gpu, guard.UNITS, guard.UBOS, guard.SSBOS, guard.IMAGES):
        guard.set_everything_odd(raw, ctx, host)
        before = guard.snapshot(raw, ctx)

        def same(step: str) -> None:
            steps.append(step)
            assert guard.differences(before, guard.snapshot(raw, ctx)) == {}, step
            assert ctx.error == "GL_NO_ERROR", step
            assert target.viewport == (3, 4, 30, 20), step

        renderer = pf.Renderer(scene, SIZE, "low", ctx=ctx)
        for name, camera in (("a disc", AHEAD), ("its own planet", OVER_MOON), ("the other way", BACK)):
            renderer.render_to(target, camera, viewport=(8, 8, *SIZE), dt_s=0.02)
            same(f"render_to, {name}")
            renderer.render(camera, outputs=("color", "distance", "surface"))
            same(f"render, {name}")
            renderer.pick(camera, 20.0, 30.0)
            same(f"pick, {name}")
        view = renderer.add_view((40, 30))
        view.render_to(target, AHEAD, viewport=(8, 8, 40, 30))
        same("a view more")
        renderer.resize((40, 30))
        renderer.render(AHEAD)
        same("another size")
        renderer.reload_shaders()
        assert renderer.memory_bytes
        same("reload_shaders")
        scene.companions.remove("moon")
        renderer.render(AHEAD)
        same("a planet gone")
        renderer.release()
        same("released")
    assert len(steps) == 14
    target.release()


@pytest.mark.gpu
def test_without_the_guard_no_error_is_left(gpu: Gpu) -> None:
    """The contract of guard=False (docs/embedding.md): no error is left, the host sets the state it needs."""
    gpu.ctx.__enter__()
    target = gpu.ctx.framebuffer([gpu.ctx.texture(SIZE, 4)])
    scene = pf.load_scene("moon")
    with StateGuard(gpu), pf.Renderer(scene, SIZE, "low", ctx=gpu.ctx, guard=False) as renderer:
        renderer.render_to(target, pf.view("near"), time_s=0.0)
        picture = np.frombuffer(target.read(components=3), np.uint8)
        assert picture.max() > 40
        assert gpu.ctx.error == "GL_NO_ERROR"
    target.release()


def process_state() -> dict[str, Any]:
    root = logging.getLogger()
    return {
        "esper": (esper.current_world, sorted(w for w in esper.list_worlds() if not w.startswith("planetfall:"))),
        "log handlers": list(root.handlers),
        "log levels": (root.level, logging.getLogger("planetfall").level, logging.root.manager.disable),
        "numpy errors": np.geterr(),
        "numpy print": np.get_printoptions(),
        "numpy random": str(np.random.get_state()),  # noqa: NPY002 - what a host of old code uses
        "random": random.getstate(),
        "gc": (gc.isenabled(), gc.get_threshold(), gc.get_debug()),
    }


@pytest.mark.gpu
def test_the_process_is_as_it_was(gpu: Gpu) -> None:
    """esper's world, logging, numpy's settings, random numbers, the garbage collector, moderngl's modes."""
    esper.switch_world("a host's own world")
    old_errors = np.seterr(over="raise", invalid="call")
    gpu.ctx.__enter__()
    ctx = gpu.ctx
    try:
        random.seed(5)
        before = process_state() | {"gc_mode": ctx.gc_mode, "includes": dict(ctx.includes), "extra": ctx.extra}
        with pf.load_scene("earth") as scene:
            scene.planet.add(pf.Clouds())
            with pf.Renderer(scene, SIZE, "low", ctx=ctx) as renderer:
                camera = pf.view("coast")
                renderer.render(camera)
                renderer.settle(camera)
                scene.planet[pf.Ocean].wind_speed_m_s = 9.0
                renderer.snapshot(camera, settle=False)._repr_png_()
                pf.TerrainSampler(scene).height(pf.direction([10.0], [20.0]))
        after = process_state() | {"gc_mode": ctx.gc_mode, "includes": dict(ctx.includes), "extra": ctx.extra}
        assert {key for key in before if before[key] != after[key]} == set()
    finally:
        np.seterr(**old_errors)
        esper.switch_world("default")
        esper.delete_world("a host's own world")


def test_the_guard_covers_every_binding_that_a_shader_has() -> None:
    """By what the shaders say: a new block or unit beyond the guard's would be a host's loss."""
    limits = {"uniform": 15, "buffer": 8, "image": 8, "sampler": 21}
    highest = dict.fromkeys(limits, -1)
    for file in Path(pf.ASSETS / "shaders").rglob("*.*"):
        text = file.read_text(encoding="utf-8")
        for layout, kind in re.findall(r"layout\(([^)]*binding\s*=[^)]*)\)\s*((?:\w+\s+){1,5})", text):
            (number,) = re.findall(r"binding\s*=\s*(\w+)", layout)
            words = kind.split()
            family = (
                "image" if any("image" in w for w in words)
                else "sampler" if any("sampler" in w for w in words)
                else "buffer" if "buffer" in words else "uniform"
            )  # fmt: skip
            number = str(int(points()[number])) if number in points() else number
            if number.isdigit():
                highest[family] = max(highest[family], int(number))
    assert highest["sampler"] > 8 and highest["buffer"] > 5, "the search finds what is there"
    beyond = {name: (found, limits[name]) for name, found in highest.items() if found >= limits[name]}
    assert not beyond, f"a shader's binding is not guarded: {beyond}"
