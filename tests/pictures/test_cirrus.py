"""Cirrus: how thick its ice is, how fine and how bent its fibres are, and how bright it is against the sky."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from filaments import fan_share, filaments, width_px
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.scenes import preset_scene
from planetfall.components import Atmosphere, Clouds

pytestmark = pytest.mark.gpu

Floats = NDArray[np.float64]

PLACES = ((47.0, 11.0), (-33.0, 60.0), (5.0, -20.0), (62.0, 150.0), (-75.0, 0.0))
"""Latitude and longitude in degrees."""
CAMERA_M = 100.0


@pytest.fixture(scope="module")
def probe() -> Iterator[pf.CloudProbe]:
    """Earth's cirrus alone, all of the sky under it, without air."""
    with preset_scene("earth", True) as scene:
        layer = scene.planet[Clouds].layers[0]
        layer.coverage = 0.9
        scene.planet[Clouds].coverage, scene.planet[Clouds].layers = 0.0, (layer,)
        scene.planet.remove(Atmosphere)
        with pf.CloudProbe(scene, quality="low", overrides={"clouds.fibre_texels": 2048}) as found:
            yield found


def depths(probe: pf.CloudProbe, place: tuple[float, float], count: int, pixel_m: float) -> Floats:
    """(count, count): vertical optical depth of the sheet above a square of the ground, in pixels of pixel_m."""
    up = np.asarray(pf.direction(*place))
    east = np.cross([0.0, 0.0, 1.0], up)
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    radius, height_m = 6.36e6, 11e3
    aside = (np.arange(count) - 0.5 * (count - 1)) * pixel_m / radius
    ways = up + aside[None, :, None] * east + aside[:, None, None] * north
    ways = (ways / np.linalg.norm(ways, axis=2, keepdims=True)).reshape(-1, 3)
    _, left = probe.march(ways * (radius + CAMERA_M), ways, up, air=False, pixel_rad=pixel_m / height_m)
    return -np.log(left[:, 0]).reshape(count, count)


@pytest.fixture(scope="module")
def wide(probe: pf.CloudProbe) -> list[Floats]:
    """100 km above each place."""
    return [depths(probe, place, 128, 800.0) for place in PLACES]
