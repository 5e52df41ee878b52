"""Cirrus: how thick its ice is, how fine and how bent its fibres are, and how bright it is against the sky."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from filaments import fan_share, filaments, width_px
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components import Atmosphere, Clouds, Ocean, Terrain

pytestmark = pytest.mark.gpu

Floats = NDArray[np.float64]

PLACES = ((47.0, 11.0), (-33.0, 60.0), (5.0, -20.0), (62.0, 150.0), (-55.0, 120.0))
"""Latitude and longitude in degrees."""
RADIUS_M, CAMERA_M, SHEET_M = 6.36e6, 100.0, 11.25e3
FIBRES = {"clouds.fibre_texels": 2048}
ROWS = 80
"""Of 90, from the top: the rest is less than 15 degrees above the horizon."""
PIXEL_640_RAD = 2.0 * np.tan(np.radians(30.0)) * 16.0 / 9.0 / 640.0
"""Of a picture 640 wide, 60 degrees high."""


def cirrus_scene() -> pf.Scene:
    """Earth's air and cirrus, and nothing else; more of it than on the average."""
    scene = preset_scene("earth", True)
    clouds = scene.planet[Clouds]
    clouds.layers[0].coverage = 0.9
    clouds.coverage = 0.0
    for kind in (Terrain, Ocean):
        scene.planet.remove(kind)
    return scene


@pytest.fixture(scope="module")
def probe() -> Iterator[pf.CloudProbe]:
    scene = cirrus_scene()
    scene.planet.remove(Atmosphere)
    with pf.CloudProbe(scene, quality="low", overrides=FIBRES) as found:
        yield found


def depths(probe: pf.CloudProbe, place: tuple[float, float], count: int, pixel_m: float) -> Floats:
    """(count, count): optical depth straight up above a square of the ground, in pixels of pixel_m."""
    up = np.asarray(pf.direction(*place))
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east)
    aside = (np.arange(count) - 0.5 * (count - 1)) * pixel_m / RADIUS_M
    ways = up + aside[None, :, None] * east + aside[:, None, None] * np.cross(up, east)
    ways = (ways / np.linalg.norm(ways, axis=2, keepdims=True)).reshape(-1, 3)
    _, left = probe.march(ways * (RADIUS_M + CAMERA_M), ways, up, air=False, pixel_rad=pixel_m / SHEET_M)
    return -np.log(np.maximum(left[:, 0], 1e-6)).reshape(count, count)


def crop(probe: pf.CloudProbe, place: tuple[float, float], elevation_deg: float, count: int) -> Floats:
    """(count, count): optical depth along rays, as in so much of a picture 640 wide that looks north."""
    up = np.asarray(pf.direction(*place))
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east)
    north, tilt = np.cross(up, east), np.radians(elevation_deg)
    ahead, above = np.cos(tilt) * north + np.sin(tilt) * up, np.cos(tilt) * up - np.sin(tilt) * north
    aside = (np.arange(count) - 0.5 * (count - 1)) * PIXEL_640_RAD
    ways = (ahead + aside[None, :, None] * east - aside[:, None, None] * above).reshape(-1, 3)
    _, left = probe.march(np.broadcast_to(up * (RADIUS_M + CAMERA_M), ways.shape), ways, up, air=False,
                          pixel_rad=PIXEL_640_RAD)  # fmt: skip
    return -np.log(np.maximum(left[:, 0], 1e-6)).reshape(count, count)


@pytest.fixture(scope="module")
def sheets(probe: pf.CloudProbe) -> list[Floats]:
    """25 km above each place."""
    return [depths(probe, place, 128, 200.0) for place in PLACES]


def test_optical_depth_is_that_of_cirrus(sheets: list[Floats]) -> None:
    """What is seen as cloud has 0.05 to 0.8 (Sassen and Cho 1992: thin cirrus begins at 0.03): none has more, most has
    less than half of that, and there is much between thin and thick."""
    found = np.concatenate([sheet.ravel() for sheet in sheets])
    seen = found[found > 0.03]
    assert len(seen) > 0.2 * len(found)
    assert found.max() <= 0.8
    assert np.quantile(seen, 0.5) < 0.4
    assert np.quantile(seen, 0.95) > 2.0 * np.quantile(seen, 0.5)


def test_fibres_run_all_ways(sheets: list[Floats]) -> None:
    """In plan, so that no perspective turns anything: over 25 km the directions spread by 30 degrees or more."""
    assert np.median([filaments(sheet).spread_deg for sheet in sheets]) >= 30.0


def test_fibres_are_as_fine_as_in_photographs(probe: pf.CloudProbe) -> None:
    """A photograph 640 wide has filaments of 1 to 3 pixels. Straight above, a pixel is 23 m wide: the profile of a
    filament has half its height over at most three of them; its autocorrelation is 1.41 times as wide."""
    pixel_m = PIXEL_640_RAD * SHEET_M
    widths = [width_px(depths(probe, place, 128, pixel_m)) for place in PLACES]
    assert np.median(widths) <= 3.0 * np.sqrt(2.0)


@pytest.fixture(scope="module")
def skies() -> list[tuple[Floats, Floats]]:
    """Luminance of the sky with cirrus and without, (rows, columns), at each place, away from a sun 50 degrees high."""
    found = []
    with_ice, without = cirrus_scene(), cirrus_scene()
    without.planet.remove(Clouds)
    for place in PLACES:
        camera = pf.Camera.at(*place, CAMERA_M, heading_deg=20.0, pitch_deg=42.0)
        sun = pf.Sun(elevation_deg=50.0, azimuth_deg=200.0, latitude_deg=place[0], longitude_deg=place[1])
        pictures = []
        for scene in (with_ice, without):
            overrides = FIBRES if scene is with_ice else {}
            with pf.Renderer(scene, (160, 90), "medium", overrides) as renderer:
                renderer.settle(camera, sun=sun)
                arrays = renderer.render(camera, sun=sun, outputs=("radiance",))
                pictures.append(np.asarray(arrays["radiance"], np.float64) @ [0.2126, 0.7152, 0.0722])
        found.append((pictures[0], pictures[1]))
    return found


def test_it_is_no_brighter_than_one_and_a_half_skies(skies: list[tuple[Floats, Floats]]) -> None:
    """More than 40 degrees from the sun (all of these pictures): 1.6 times the sky at most, but for one pixel in fifty,
    above ten degrees; and it is seen: a tenth has more than 1.08 times."""
    ratio = np.concatenate([(ice / sky)[:ROWS].ravel() for ice, sky in skies])
    assert np.quantile(ratio, 0.98) <= 1.6
    assert np.quantile(ratio, 0.9) > 1.08


def test_it_is_no_zoom_blur(skies: list[tuple[Floats, Floats]]) -> None:
    """Parallel fibres in perspective all run towards one point: a fan. Here there is no such point."""
    shares = [fan_share(filaments((ice / sky)[:ROWS])) for ice, sky in skies]
    assert np.median(shares) < 0.5
