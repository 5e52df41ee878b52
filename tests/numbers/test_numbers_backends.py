"""What all backends promise of a picture: no holes, no pops, ground where it truly is."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure.ground import picture_error
from planetfall.benchmarks.measure.holes import find_holes
from planetfall.benchmarks.measure.popping import popping

BACKENDS = ("grid", "quadtree", "icosphere")


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_holes(backend: str) -> None:
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, (96, 54), "low", {"terrain.backend": backend}) as renderer:
        found = find_holes(renderer, 12, np.random.default_rng(3))
    assert found.pixels > 10_000
    assert found.holes == 0, found.where


@pytest.mark.slow
@pytest.mark.timeout(1800)
@pytest.mark.parametrize("planet", ["earth", "moon", "asteroid"])
@pytest.mark.parametrize("backend", BACKENDS)
def test_no_holes_over_many_cameras(backend: str, planet: str) -> None:
    with pf.Renderer(pf.load_scene(planet), (96, 54), "low", {"terrain.backend": backend}) as renderer:
        found = find_holes(renderer, 700, np.random.default_rng(4))
    assert found.holes == 0, found.where


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_pops_in_low_flight(backend: str) -> None:
    scene = pf.load_scene("earth")
    flight = pf.path("low", scene)
    with pf.Renderer(scene, (160, 90), "medium", {"terrain.backend": backend}) as renderer:
        found = popping(renderer, [flight.camera_at(20.0 + k / 15.0) for k in range(13)], frame_s=1.0 / 15.0)
    assert found.changed > 0.0, "nothing was chosen anew: the flight is too short to show anything"
    assert found.p999_px <= 1.0


def test_pops_are_seen() -> None:
    """The measure itself: tiles exchanged without any morph, far coarser than promised, do pop."""
    scene = pf.load_scene("earth")
    flight = pf.path("low", scene)
    overrides = {"terrain.backend": "quadtree", "terrain.error_px": 16.0, "terrain.edge_px": 60.0}
    with pf.Renderer(scene, (160, 90), "medium", overrides) as renderer:
        found = popping(renderer, [flight.camera_at(20.0 + k / 2.0) for k in range(9)], frame_s=0.5)
    assert found.worst_px > 1.0


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("place", ["near", "high", "orbit"])
def test_ground_is_where_it_is(backend: str, place: str) -> None:
    with pf.Renderer(pf.load_scene("earth"), (320, 180), "high", {"terrain.backend": backend}) as renderer:
        renderer.settle(pf.view(place))
        found = picture_error(renderer, pf.view(place), np.random.default_rng(5), 3000)
    assert found is not None
    assert found.p99_px <= 1.0


def test_the_hole_finder_finds_holes() -> None:
    """Nothing where all is well; and the far side of the planet, of which held tiles have nothing."""
    scene = pf.load_scene("moon")
    scene.environment.add(pf.DebugView("holes"))
    here = pf.Camera.at(10.0, 20.0, 3e5, pitch_deg=-60.0)
    far = pf.Camera.at(-10.0, 200.0, 3e5, pitch_deg=-60.0)
    with pf.Renderer(scene, (96, 54), "low", {"terrain.backend": "quadtree"}) as renderer:
        renderer.settle(here)
        assert not (renderer.render(here)["color"] == (255, 0, 255)).all(axis=-1).any()
        scene.environment[pf.DebugView].freeze = True
        renderer.render(here)
        shown = (renderer.render(far)["color"] == (255, 0, 255)).all(axis=-1)
        assert shown.mean() > 0.5
