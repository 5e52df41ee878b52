"""Where drops end that run down the ground, on grounds where that is known; and the shape of networks."""

from __future__ import annotations

from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure.land import bifurcation, descend
from planetfall.benchmarks.measure.queries import land

RADIUS_M = 1000.0


def ground(height: Callable[[np.ndarray], np.ndarray]) -> SimpleNamespace:
    """A field of a body of a kilometre without rivers: height of z."""
    return SimpleNamespace(radius_m=RADIUS_M, params=SimpleNamespace(rivers=None), height=lambda d: height(d[:, 2]))


def north(count: int = 200) -> np.ndarray:
    """Places between 6 and 60 degrees north."""
    rng = np.random.default_rng(2)
    z, longitude = rng.uniform(0.1, 0.87, count), rng.uniform(0.0, 2.0 * np.pi, count)
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(longitude), across * np.sin(longitude), z], axis=1)


def test_all_drops_come_to_the_sea_down_an_even_slope() -> None:
    found = descend(ground(lambda z: 50.0 * z), north())
    assert found.sea == found.arrived == 1.0 and found.pit == found.lost == 0.0
    latitude = np.arcsin(north()[:, 2])
    assert found.median_way_m == pytest.approx(np.median(latitude) * RADIUS_M, abs=26.0)


@pytest.mark.parametrize(("depth_m", "arrives"), [(1.0, True), (12.0, False)])
def test_shallow_pits_are_crossed_and_deep_ones_are_not(depth_m: float, arrives: bool) -> None:
    """Furrows along the contour, a hundred metres apart, on a slope of a twentieth; the lowest are in the sea."""
    field = ground(lambda z: 60.0 * z + depth_m * np.sin(np.arcsin(z) * RADIUS_M * (2.0 * np.pi / 100.0)))
    found = descend(field, north())
    assert (found.arrived == 1.0) if arrives else (found.pit >= (north()[:, 2] > 0.3).mean())


def test_a_bowl_keeps_its_drops() -> None:
    assert descend(ground(lambda z: 100.0 - 50.0 * z), north()).pit == 1.0


def test_rivers_take_drops_that_pits_keep_without_them() -> None:
    """On the preset earth, two to three times as many come to a stream, a lake or the sea."""
    shares = []
    for knob in (0.0, 1.0):
        with pf.load_scene("earth") as scene:
            terrain = scene.planet[pf.Terrain]
            terrain.erosion = terrain.rivers = knob
            field = scene.planet.height_field()
            shares.append(descend(field, land(pf.TerrainSampler(scene), 200, np.random.default_rng(1))))
    assert shares[1].arrived > 1.5 * shares[0].arrived
    assert shares[0].water == shares[0].floor == 0.0 < shares[1].floor


def test_orders_of_a_small_network() -> None:
    """Two pairs of springs that join, and the two joined streams: four of first order, two of second, one of third."""
    receiver = np.array([4, 4, 5, 5, 6, 6, 7, 7])
    assert bifurcation(receiver, np.arange(7)) == [2.0, 2.0]
