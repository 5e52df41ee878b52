"""Callbacks: what changed, and when all has settled."""

from __future__ import annotations

from typing import Any

import pytest

import planetfall as pf

pytestmark = pytest.mark.gpu


def test_changes_are_told_once_and_by_name(gpu: Any) -> None:
    with pf.load_scene("asteroid") as scene, pf.Renderer(scene, (64, 36), "low", ctx=gpu.ctx) as renderer:
        told: list[frozenset[str]] = []
        renderer.watch.changed.append(told.append)
        camera = pf.Camera.at(10.0, 20.0, 3.0 * scene.planet.radius_m, 0.0, -90.0, planet=scene.planet)
        for _ in range(3):
            renderer.render(camera)
        assert told == []
        scene.environment[pf.Composite].bloom = 0.02
        renderer.render(camera)
        renderer.render(camera)
        assert told == [{"Composite"}]
        scene.planet[pf.Terrain].seed += 1
        scene.sun.irradiance = (1.0, 1.0, 1.0)
        renderer.render(camera)
        assert told[1:] == [{"Terrain", "Sun"}]
        terrain = scene.planet.remove(pf.Terrain)
        renderer.render(camera)
        scene.planet.add(terrain)
        renderer.render(camera)
        assert told[2:] == [{"Terrain"}, {"Terrain"}]
        moon = scene.companions.add(pf.Scene("speck", {"planet": pf.Planet(radius_m=500.0)}), pf.Orbit(1e6))
        renderer.render(camera)
        told.clear()
        moon.orbit.phase_deg = 10.0
        renderer.render(camera)
        assert told == [{"Orbit"}]
        renderer.watch.changed.clear()
        scene.environment[pf.Composite].bloom = 0.03
        renderer.render(camera)
        assert len(told) == 1


def test_settled_is_told_when_it_comes_to_rest(gpu: Any) -> None:
    with (
        pf.load_scene("asteroid") as scene,
        pf.Renderer(scene, (64, 36), "low", overrides={"composite.antialiasing": "temporal"}, ctx=gpu.ctx) as renderer,
    ):
        scene.environment[pf.Exposure].mode = "fixed"
        told: list[int] = []
        frames = 0
        renderer.watch.settled.append(lambda: told.append(frames))
        camera = pf.Camera.at(10.0, 20.0, 3.0 * scene.planet.radius_m, 0.0, -90.0, planet=scene.planet)
        for _ in range(40):
            frames += 1
            renderer.render(camera, dt_s=0.1)
        assert len(told) == 1 and told[0] > 2  # the samples of a still picture are gathered first
        scene.planet[pf.Terrain].seed += 1
        for _ in range(40):
            frames += 1
            renderer.render(camera, dt_s=0.1)
        assert len(told) == 2 and told[1] > 41
