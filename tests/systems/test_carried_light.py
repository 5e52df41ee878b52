"""Renderers that carry light at 610, 550 and 440 nm: what they draw of numbers given at 680, 550 and 440 nm."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from air_kit import TINY, at, bare, settled

import planetfall as pf
from planetfall.engine.wavelengths import DISPLAY_NM, GIVEN_NM, carried_air, carried_sunlight, carried_water
from planetfall.systems.composite.photometry import expose

pytestmark = pytest.mark.gpu

GIVEN, DISPLAY = {"light.wavelengths": "given"}, {"light.wavelengths": "display"}


def drawn(scene: pf.Scene, camera: pf.Camera, overrides: dict[str, Any]) -> np.ndarray:
    with pf.Renderer(scene, (32, 18), "low", {**TINY, **overrides}) as renderer:
        assert renderer.wavelengths_nm == (DISPLAY_NM if overrides is DISPLAY else GIVEN_NM)
        return settled(renderer, camera)


def moved(scene: pf.Scene) -> pf.Scene:
    """The same with numbers that are those at 610 nm."""
    for kind, carried in ((pf.Atmosphere, carried_air), (pf.Ocean, carried_water)):
        part = scene.planet.get(kind)
        if part is not None:
            scene.planet.add(carried(part, DISPLAY_NM))
    scene.sun = replace(scene.sun, irradiance=tuple(carried_sunlight(scene.sun.irradiance, DISPLAY_NM)))
    return scene


@pytest.mark.parametrize("sea_m", [None, 0.0], ids=["air", "sea"])
def test_numbers_are_moved_once_and_all_of_them(sea_m: float | None) -> None:
    """To the bit what is drawn of the moved numbers where nothing moves."""
    camera = at(2000.0, pitch_deg=-10.0)
    found, wanted = drawn(bare(sea_m=sea_m), camera, DISPLAY), drawn(moved(bare(sea_m=sea_m)), camera, GIVEN)
    np.testing.assert_array_equal(found[..., 1:], wanted[..., 1:])
    if sea_m is None:  # albedos are colours, whose shares of light differ
        np.testing.assert_array_equal(found, wanted)
    assert not np.allclose(found[..., 0], drawn(bare(sea_m=sea_m), camera, GIVEN)[..., 0], rtol=0.05)


def test_pictures_are_about_as_bright_and_blue_either_way() -> None:
    camera = at(2000.0, pitch_deg=5.0)
    found = expose(drawn(bare(), camera, DISPLAY), 15.0, DISPLAY_NM)
    given = expose(drawn(bare(), camera, GIVEN), 15.0, GIVEN_NM)
    np.testing.assert_allclose(found.mean(axis=(0, 1)), given.mean(axis=(0, 1)), rtol=0.15)


def test_a_red_thing_is_red() -> None:
    """A sphere of (0.9, 0.02, 0.02) in the sun where there is no air."""
    with pf.load_scene("moon") as scene:
        scene.planet.remove(pf.Terrain)
        radius = scene.planet.planet.radius_m
        scene.add(pf.Transform((radius + 1000.0, 0.0, 0.0)), pf.Shape("box", (8.0, 8.0, 8.0), color=(0.9, 0.02, 0.02)))
        camera = pf.Camera((radius + 1020.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        scene.sun = pf.Sun(direction=(1.0, 0.0, 0.5))
        with pf.Renderer(scene, (32, 18), "low") as renderer:
            out = renderer.render(camera, outputs=("radiance", "surface"))
            shown = expose(out["radiance"][out["surface"] == 3], 15.0, renderer.wavelengths_nm).mean(axis=0)
    # Gloss adds a little white.
    assert shown[0] > 10.0 * shown[1:].max() and shown[1] == pytest.approx(shown[2], abs=0.02 * shown[0])
