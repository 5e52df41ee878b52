"""The march through homogeneous clouds at the edges of what it may be asked."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from air_tables import over_the_pole, towards
from cloud_tables import even, planet_of

import planetfall as pf

CASES = {
    "asteroid": (1e3, [(0.1, 0.3, 10.0), (0.2, 1.3, 1e-3)]),
    "earth": (6.36e6, [(1500.0, 4000.0, 0.02), (3000.0, 9000.0, 2e-4)]),
    "a metre on earth": (6.36e6, [(2000.0, 2001.0, 1.0)]),
    "giant, deep and thick": (7e7, [(3.5e6, 7e6, 10.0)]),
}


def _questions(radius_m: float, heights: list[float], count: int) -> tuple[Any, Any, Any]:
    """Cameras on, next to and far from every boundary; rays at random, straight up and down, and tangent to spheres."""
    rng = np.random.default_rng(11)
    near = np.concatenate([np.array(heights) + d for d in (-1e-3, 0.0, 1e-3)])
    away = 10.0 ** rng.uniform(-3.0, 1.5, count) * radius_m
    height = np.maximum(np.where(rng.random(count) < 0.6, rng.choice(near, count), away), 0.0)
    zenith = np.degrees(np.arccos(rng.uniform(-1.0, 1.0, count)))
    sphere = radius_m + rng.choice(heights, count)
    tangent = 180.0 - np.degrees(np.arcsin(np.minimum(sphere / (radius_m + height), 1.0)))
    kind = rng.random(count)
    zenith = np.where(kind < 0.4, tangent, np.where(kind < 0.5, rng.choice([0.0, 90.0, 180.0], count), zenith))
    sun = np.degrees(np.arccos(rng.uniform(-1.0, 1.0, count)))
    sun = np.where(rng.random(count) < 0.3, rng.choice([0.0, 89.9, 90.0, 90.5, 180.0], count), sun)
    azimuth = np.where(rng.random(count) < 0.3, rng.choice([0.0, 180.0], count), rng.uniform(0.0, 360.0, count))
    return over_the_pole(height, radius_m), towards(zenith, azimuth), towards(sun)


@pytest.mark.parametrize("name", list(CASES))
def test_light_is_finite_and_no_brighter_than_droplets_can_make_it(name: str) -> None:
    radius_m, layers = CASES[name]
    clouds = even(*layers[0], 1.0, 0.85)
    clouds.layers = [
        pf.CloudLayer(base_m=b, top_m=t, extinction_per_m=e, asymmetry=0.85, density_model="uniform")
        for b, t, e in layers[1:]
    ]
    question = _questions(radius_m, [0.0, *(h for layer in layers for h in layer[:2])], 1500)
    # The peak of the phase function: what a slab of any depth under a sun of irradiance 1 cannot reach by itself; a rim
    # towards the sun adds up light of a way that is longer than that of the sun. Twice as much is left for rounding.
    most = 2.0 * (1.0 + 0.85) / (4.0 * np.pi * 0.15**2)
    with pf.CloudProbe(planet_of(clouds, radius_m), quality="medium") as probe:
        for visibility in ("disc", "point"):
            for orders in (1, None):
                light, through = probe.march(*question, orders=orders, sun_visibility=visibility)
                assert np.isfinite(light).all()
                assert np.isfinite(through).all()
                assert (light >= 0.0).all()
                assert light.max() < most
                assert ((through >= 0.0) & (through <= 1.0)).all()


def test_the_picture_is_continuous_where_a_camera_goes_through_a_boundary() -> None:
    # In steps of 1 m about base and top: no step changes light by more than twice what the larger of its neighbours
    # does. A ray that begins to touch a shell gains length as a square root: its first step is 1.4 times the second.
    with pf.CloudProbe(planet_of(even(1000.0, 2000.0, 5e-3, 1.0, 0.8)), quality="high") as probe:
        for boundary in (1000.0, 2000.0):
            for zenith in (10.0, 60.0, 89.0, 91.5, 120.0, 170.0):
                height = boundary + np.arange(-6.0, 7.0) + 0.5
                light, _ = probe.march(over_the_pole(height), towards([zenith]), towards([50.0]))
                steps = np.abs(np.diff(light[:, 0]))
                beside = np.maximum(steps[:-2], steps[2:])
                # Single precision has seven digits of light that hundreds of steps add up to.
                assert (steps[1:-1] <= 2.0 * beside + 1e-5 * light.max()).all(), (boundary, zenith)
