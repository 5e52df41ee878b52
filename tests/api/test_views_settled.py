"""Several views: each is told of when it has come to rest, and says of itself how far it is."""

from __future__ import annotations

from typing import Any

import pytest

import planetfall as pf

pytestmark = pytest.mark.gpu

SIZE = (64, 36)
_AIR = "atmosphere"
_FRAMES = 600
"""Tables take as many as the time of a frame allows: on a busy machine hundreds."""


def told_of(renderer: pf.Renderer, number: int) -> dict[str, tuple[bool, float, str]]:
    """What systems say of a view. Those of the air work on what all views share, in whoever's frame it is."""
    view = renderer.views[number]
    return {s.name: (s.settled(view), s.progress(view), s.refining(view)) for s in renderer.running if s.name != _AIR}


@pytest.mark.parametrize("backend", ["grid", "quadtree"])
def test_a_view_that_keeps_still_is_told_of_once_while_another_flies(gpu: Any, backend: str) -> None:
    overrides = {"terrain.backend": backend, "composite.antialiasing": "temporal", "exposure.mode": "fixed"}
    scene = pf.load_scene("moon")
    with scene, pf.Renderer(scene, SIZE, "low", overrides, ctx=gpu.ctx) as renderer, renderer.add_view(SIZE) as flying:
        told: list[str] = []
        drawn = ""
        renderer.watch.settled.append(lambda: told.append(drawn))
        still = pf.Camera.at(10.0, 20.0, 3000.0, pitch_deg=-20.0, above="ground")
        after = 0
        for number in range(_FRAMES):
            drawn = "still"
            renderer.render(still, 0.0, dt_s=0.1)
            drawn = "flying"
            place = pf.Camera.at(10.0, 20.0 + 0.002 * number, 3000.0, pitch_deg=-20.0, above="ground")
            flying.render(place, 0.0, dt_s=0.1)
            after += bool(told)
            if after == 25:
                break
        assert told == ["still"]


def test_what_is_said_of_a_view_is_not_changed_by_another_ones_frame(gpu: Any) -> None:
    scene = pf.load_scene("earth")
    scene.planet.add(pf.Clouds())
    overrides = {"terrain.backend": "quadtree", "composite.antialiasing": "temporal", "exposure.mode": "fixed"}
    above = pf.Camera.at(10.0, 20.0, 9000.0, pitch_deg=-30.0)
    sky = pf.Camera.at(35.0, 170.0, -3.0, pitch_deg=8.0)  # from below the sea: no clouds, and other ground
    with scene, pf.Renderer(scene, SIZE, "low", overrides, ctx=gpu.ctx) as renderer, renderer.add_view(SIZE) as other:
        weather = 0
        for number in range(12):
            renderer.render(above, 0.0, dt_s=0.1)
            said, own = renderer.refining, told_of(renderer, 0)
            weather += "weather" in said
            other.render(sky, 0.0, dt_s=0.1)
            assert told_of(renderer, 0) == own, number
            assert [text for text in renderer.refining if "air" not in text] == [t for t in said if "air" not in t]
            assert "weather" not in other.refining
        assert weather
