"""The air in a host's context, beside other renderers, and with hosts that leave odd state behind."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import moderngl
import numpy as np
import pytest
import test_guard as guard
from air_kit import HAZY, at, bare, job_of, radiance, renderer_of, settled

import planetfall as pf
from planetfall.components import Atmosphere
from planetfall.engine.gpu import Gpu
from planetfall.engine.gpu.guard import StateGuard
from planetfall.engine.hosts.headless import create_headless

pytestmark = pytest.mark.gpu

CAMERA = at(3000.0, pitch_deg=5.0)
host = guard.host


@pytest.fixture(autouse=True)
def no_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANETFALL_CACHE", "")


@pytest.fixture
def ctx() -> Iterator[moderngl.Context]:
    made = create_headless()
    yield made
    assert made.error == "GL_NO_ERROR"
    made.release()


def test_everything_of_the_host_is_as_it_was(gpu: Gpu, host: dict[str, Any]) -> None:
    """The host has textures and samplers on every unit, buffers at every binding, images at every unit."""
    with renderer_of(bare()) as alone:
        wanted = settled(alone, CAMERA)
    gpu.ctx.__enter__()
    raw = guard.Raw(gpu)
    with StateGuard(gpu, guard.UNITS, guard.UBOS, guard.SSBOS, guard.IMAGES):
        guard.set_everything_odd(raw, gpu.ctx, host)
        before = guard.snapshot(raw, gpu.ctx)
        renderer = renderer_of(bare(), ctx=gpu.ctx)
        assert guard.differences(before, guard.snapshot(raw, gpu.ctx)) == {}
        first = radiance(renderer, CAMERA)  # with the first look's tables, made under the host's state
        assert guard.differences(before, guard.snapshot(raw, gpu.ctx)) == {}
        assert np.abs(first - wanted).mean() < 0.05 * wanted.mean()
        np.testing.assert_array_equal(settled(renderer, CAMERA), wanted)
        renderer.scene.planet[pf.Atmosphere].mie_asymmetry = 0.7
        radiance(renderer, CAMERA)
        renderer.reload_shaders()
        renderer.scene.planet.remove(pf.Atmosphere)
        radiance(renderer, CAMERA)
        renderer.release()
        assert guard.differences(before, guard.snapshot(raw, gpu.ctx)) == {}


def test_several_renderers_in_one_context(ctx: moderngl.Context) -> None:
    """Two airs and no air, in turns, one of them refining: each picture is what the renderer alone would draw."""
    scenes = [bare(), bare(Atmosphere(mie_scattering_per_m=HAZY, mie_extinction_per_m=HAZY)), bare()]
    scenes[2].planet.remove(pf.Atmosphere)
    wanted = []
    for scene in scenes:
        with renderer_of(scene) as alone:
            wanted.append(settled(alone, CAMERA))
    assert not np.array_equal(wanted[0], wanted[1])
    together = [renderer_of(scene, ctx=ctx) for scene in scenes]
    for _ in range(2000):
        for renderer in together:
            radiance(renderer, CAMERA)
        if all(job_of(r).done for r in together[:2]):
            break
    for renderer, picture in zip(together, wanted, strict=True):
        np.testing.assert_array_equal(radiance(renderer, CAMERA), picture)
    together[0].release()
    np.testing.assert_array_equal(radiance(together[1], CAMERA), wanted[1])
    for renderer in together[1:]:
        renderer.release()


@pytest.mark.parametrize("shared_context", [True, False])
def test_two_renderers_of_one_scene(ctx: moderngl.Context, shared_context: bool) -> None:
    """A map and a view of one world, say. Each draws with its own tables, and nothing of one goes with the other."""
    scene = bare()
    with renderer_of(scene) as alone:
        wanted = settled(alone, CAMERA)
    low = at(200.0, pitch_deg=30.0)
    first, second = (renderer_of(scene, ctx=ctx if shared_context else None) for _ in range(2))
    radiance(first, CAMERA)
    radiance(second, low)
    np.testing.assert_array_equal(settled(first, CAMERA), wanted)
    settled(second, low)
    first.resize((20, 10))
    radiance(first, CAMERA)
    first.resize((32, 18))
    np.testing.assert_array_equal(radiance(first, CAMERA), wanted)
    second.release()
    first.resize((20, 10))
    radiance(first, CAMERA)
    first.resize((32, 18))
    np.testing.assert_array_equal(radiance(first, CAMERA), wanted)
    first.release()


def test_into_the_hosts_framebuffer(ctx: moderngl.Context) -> None:
    renderer = renderer_of(bare(), ctx=ctx, size=(40, 30))
    target = ctx.framebuffer([ctx.texture((80, 60), 4)])
    for viewport in ((0, 0, 40, 30), (40, 30, 40, 30), (0, 0, 80, 60)):
        target.clear()
        renderer.render_to(target, CAMERA, viewport=viewport)
        picture = np.frombuffer(target.read(components=4), np.uint8).reshape(60, 80, 4)
        x, y, width, height = viewport
        inside = picture[y : y + height, x : x + width, :3]
        assert inside.max() > 50
        outside = picture[..., :3].astype(int).sum() - inside.astype(int).sum()
        assert outside == 0
    renderer.release()
