"""Live knobs: a renderer that is retuned, there and back, shows to the bit what one made with those values does."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from air_kit import bare
from cloud_kit import COARSE, cloudy

import planetfall as pf
from planetfall.quality import LIVE

BACKENDS = ("grid", "quadtree", "icosphere")
OTHER = {"terrain.edge_px": 40.0, "terrain.error_px": 1.0, "terrain.min_spacing_m": 2.0, "clouds.fine_steps": 320}
"""What knobs are changed to; all others to twice what they are."""
FINER: dict[str, dict[str, Any]] = {"grid": {"terrain.edge_px": 3.0}, "quadtree": {}, "icosphere": {}}
"""The grid's vertices are never farther apart than 0.05 rad, which is 4 pixels of so small a picture."""
PRINTED = ("paper grid", "paper quadtree", "paper icosphere", "paper sea")
"""As the sources print them: ground and sea know one knob, where it asks for less than a pixel or so; clouds none."""
CASES = [
    *((knob, kind) for knob in LIVE for kind in (BACKENDS if knob.startswith("terrain.") else ("clouds",))),
    *(("terrain.edge_px", kind) for kind in PRINTED),
]


def made(kind: str, changes: Mapping[str, Any]) -> pf.Renderer:
    """A renderer of a landscape with that backend, of a sea without air, or of clouds without ground."""
    paper, of = kind.startswith("paper"), kind.removeprefix("paper ")
    quality = "paper" if paper else "low"
    if of == "clouds":
        return pf.Renderer(cloudy(coverage=0.6, radius_m=1e6), (64, 36), quality, {**COARSE, **changes})
    if of == "sea":
        scene = bare(radius_m=1e6)
        scene.planet.remove(pf.Atmosphere)
        scene.planet.add(pf.Ocean(sea_level_m=0.0))
        return pf.Renderer(scene, (160, 90), quality, changes)
    given = {"terrain.backend": of, **({} if paper else FINER[of]), **changes}
    return pf.Renderer(pf.load_scene("moon"), (160, 90), quality, given)


def settled(renderer: pf.Renderer, kind: str) -> dict[str, Any]:
    """The settled picture, and how many triangles it took."""
    altitude_m, pitch_deg = (500.0, 20.0) if kind == "clouds" else (1.7, -20.0)
    camera = pf.Camera.at(10.0, 20.0, altitude_m, pitch_deg=pitch_deg, above="ground")
    renderer.settle(camera)
    return {**renderer.render(camera, outputs=("color", "distance")), "triangles": renderer.stats.get("triangles", 0)}


@functools.cache
def fresh(kind: str) -> dict[str, Any]:
    """What a renderer shows that nobody retunes."""
    with made(kind, {}) as renderer:
        return settled(renderer, kind)


def assert_equal(shown: Mapping[str, Any], wanted: Mapping[str, Any]) -> None:
    assert shown["triangles"] == wanted["triangles"]
    for name in ("distance", "color"):
        np.testing.assert_array_equal(shown[name], wanted[name])


@pytest.mark.parametrize(("knob", "kind"), CASES)
def test_retuned_is_as_made_so(knob: str, kind: str) -> None:
    with made(kind, {}) as renderer:
        before = settled(renderer, kind)
        value = renderer.settings[knob]
        other = 1.0 if kind in PRINTED else OTHER.get(knob, 2 * value)
        assert other != value
        renderer.retune({knob: other})
        there = settled(renderer, kind)
        renderer.retune({knob: value})
        back = settled(renderer, kind)
    with made(kind, {knob: other}) as renderer:
        wanted = settled(renderer, kind)
    if kind in ("clouds", *PRINTED):
        assert any(np.any(wanted[name] != before[name]) for name in wanted), "the knob has to change something"
    elif knob != "terrain.error_px" or kind != "grid":
        assert wanted["triangles"] != before["triangles"], "the knob has to change something"
    assert_equal(there, wanted)
    assert_equal(back, fresh(kind))
