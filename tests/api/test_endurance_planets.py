"""Nothing grows with several planets either: planets that come and go, sizes, renderers, presets. Short here, whole
with --slow."""

from __future__ import annotations

import random

import numpy as np
import pytest
from test_endurance import SIZE, assert_no_more, live_objects, short, slope, whole

import planetfall as pf
from planetfall.app.tweak_store import SceneStore
from planetfall.engine.hosts.headless import create_headless
from planetfall.render.memory_budget import MIB
from planetfall.systems.tweak import Edit, Workbench

pytestmark = pytest.mark.gpu

MOON_M = 1.7374e6


def globe(name: str, radius_m: float, seed: int) -> pf.Scene:
    """A globe of rock, without what takes long to make."""
    rock = pf.Terrain(seed=seed, highest_m=0.001 * radius_m, lowest_m=-0.001 * radius_m, layers=6, land_share=0.5)
    return pf.Scene(name, {"planet": pf.Planet(radius_m=radius_m), "terrain": rock})


def pair() -> pf.Scene:
    """Two globes, the smaller one before a camera at 1.5e7 m on the x axis."""
    scene = globe("earth", 6.371e6, 3)
    scene.companions.add(globe("moon", MOON_M, 7), pf.Orbit(distance_m=3e7, period_s=0.0))
    return scene


AHEAD = pf.Camera((1.5e7, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 30.0, ev100=13.0)
"""The Moon as a disc of a quarter of the picture."""
OVER_MOON = pf.Camera((2.6e7, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 60.0, ev100=13.0)
"""So near that the Moon is the camera's planet."""
BACK = pf.Camera((2.6e7, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 60.0, ev100=13.0)
"""From there, Earth as a disc."""


@pytest.mark.parametrize("share", [short, whole])
def test_planets_come_and_go(share: float) -> None:
    """A third planet is added, seen and taken out, by the panel's steps and by the scene's own calls; so is the last
    companion."""
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture(SIZE, 4)])
    scene = pair()
    store = SceneStore(scene)
    bench = Workbench(store)
    rock = globe("rock", 5e5, 9)
    parts = store.expect("rock", rock, pf.Orbit(distance_m=2.2e7, period_s=0.0))
    renderer = pf.Renderer(scene, SIZE, "low", ctx=ctx)

    def draw() -> None:
        renderer.render_to(target, AHEAD)
        assert ctx.error == "GL_NO_ERROR"

    def work(turn: int) -> None:
        if turn % 2:
            scene.companions.add(rock, pf.Orbit(distance_m=2.2e7, period_s=0.0))
        else:
            assert bench.do([Edit(heading, "", None, part) for heading, part in parts.items()], "add") == ""
        draw()
        assert renderer.planets["rock"].gpu.counts()
        scene.companions.remove("rock")
        moon = scene.companions.remove("moon")
        draw()
        assert list(renderer.planets) == ["earth"]
        scene.companions.join(moon)
        draw()

    work(0)
    before = live_objects(ctx)
    if share == 1.0:
        slope(work, 100, 100.0)
    else:
        work(1)
    assert_no_more(ctx, before)
    renderer.release()
    scene.release()
    assert rock.world.closed
    target.release()
    ctx.release()


@pytest.mark.parametrize("share", [short, whole])
def test_resizes(share: float) -> None:
    """The window's sizes, and those of the discs, which follow the field of view."""
    rng = random.Random(7)
    with pair() as scene, pf.Renderer(scene, SIZE, "low") as renderer:

        def work(turn: int) -> None:
            width = int(2 ** rng.uniform(0.0, 12.0))
            height = int(2 ** rng.uniform(0.0, min(12.0, np.log2(512_000 / width))))
            renderer.resize((1, 1) if turn == 0 else (4096, 64) if turn == 1 else (width, height))
            if turn % 5 == 0:
                seen = (AHEAD, OVER_MOON, BACK)[turn // 5 % 3]
                narrow = pf.Camera(seen.position_m, seen.forward, seen.up, rng.uniform(5.0, 60.0), ev100=13.0)
                renderer.render(narrow)

        def settle_down() -> dict[str, dict[str, int]]:
            renderer.resize(SIZE)
            for camera in (OVER_MOON, BACK, AHEAD):
                renderer.render(camera)
            return {name: r.gpu.counts() for name, r in renderer.planets.items()}

        for turn in range(16):
            work(turn)
        counts = settle_down()
        slope(work, int(500 * share), 200.0)
        assert settle_down() == counts
        assert renderer.ctx.error == "GL_NO_ERROR"


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_renderers_come_and_go() -> None:
    """In a host's context, over either planet; qualities and planets are switched in between."""
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture(SIZE, 4)])

    def work(turn: int) -> None:
        with pair() as scene:
            quality = ("low", "medium")[turn % 4 == 3]
            with pf.Renderer(scene, SIZE, quality, ctx=ctx) as renderer:
                renderer.render_to(target, (AHEAD, OVER_MOON, BACK)[turn % 3])
                members = dict(renderer.planets)
            assert renderer.gpu.counts() == {} and [m.gpu.counts() for m in members.values()] == [{}]
        assert ctx.error == "GL_NO_ERROR"

    for turn in range(4):
        work(turn)
    before = live_objects(ctx)
    slope(work, 200, 100.0)
    assert_no_more(ctx, before)
    target.release()
    ctx.release()


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_presets_are_switched() -> None:
    """Scenes of several planets, one after the other in place, as the panel loads them."""
    from planetfall.scene.presets import load_companions, load_parts
    from planetfall.scene.scene import scene_of

    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture(SIZE, 4)])
    scene = pf.load_scene("mars")
    store = SceneStore(scene)
    bench = Workbench(store)
    renderer = pf.Renderer(scene, SIZE, "low", ctx=ctx)

    def work(turn: int) -> None:
        name = ("mars_moons", "earth_moon", "moon")[turn % 3]
        state = load_parts(name)
        for told, orbit in load_companions(name):
            state |= store.expect(told.name, scene_of(told), orbit)
        held = [heading for heading in store.parts() if heading not in store.quality]
        assert bench.to(state, "load", {*held, *state}) == ""
        renderer.render_to(target, pf.Camera.at(20.0, 0.0, scene.planet.radius_m))
        assert ctx.error == "GL_NO_ERROR" and len(scene.planets) == (3, 2, 1)[turn % 3]

    for turn in range(3):
        work(turn)
    before = live_objects(ctx)
    slope(work, 60, 150.0)
    assert_no_more(ctx, before)
    renderer.release()
    scene.release()
    target.release()
    ctx.release()


def test_a_budget_for_memory_holds_for_each_planet() -> None:
    """As docs/several-planets.md says: two planets take no more than twice the budget, none more than its own."""
    with pair() as scene, pf.Renderer(scene, (160, 90), "medium", {"memory.budget_mib": 40}) as renderer:
        target = renderer.ctx.simple_framebuffer((160, 90))
        for camera in (AHEAD, OVER_MOON, BACK):
            renderer.render_to(target, camera)
            members = renderer.planets
            alone = {name: sum(m.gpu.memory_bytes().values()) for name, m in members.items() if name != "earth"}
            whole_mib = sum(renderer.memory_bytes.values()) / MIB
            assert list(alone) == ["moon"] and 0 < alone["moon"] <= 40 * MIB
            assert alone["moon"] / MIB < whole_mib <= 80.0 and whole_mib - alone["moon"] / MIB <= 40.0
        assert members["moon"].memory.budget_mib == renderer.memory.budget_mib == 40
        renderer.gpu.leave(target)
        target.release()
