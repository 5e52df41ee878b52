"""Heights in float64: what an earth looks like in numbers, bounds, gradients, params."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from planetfall.systems.terrain.height import (
    TerrainField,
    TerrainParams,
    height,
    height_and_gradient,
    layer_weight,
    relief_statistics,
)
from planetfall.systems.terrain.height_relief import EARTH_LAND_RELIEF_M, EARTH_LAND_UNRELATED_M

EARTH = TerrainParams()
WORLDS = {
    "earth": EARTH,
    "mars": TerrainParams(3.39e6, 5, 12000.0, -8000.0, 16, 0.6, plains=0.7, mountains=0.6, roughness=0.8),
    "moon": TerrainParams(1.737e6, 7, 8000.0, -7000.0, 16, 0.5, plains=0.3, mountains=0.0, roughness=2.0),
    "asteroid": TerrainParams(500.0, 9, 50.0, -50.0, 8, 0.5, plains=0.0, mountains=0.0, roughness=4.0),
    "giant": TerrainParams(7e7, 2),
    "one layer": TerrainParams(layers=1),
    "above the sphere": TerrainParams(6e6, 1, 3000.0, 500.0),
}


def sphere(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def tangents(d):
    t = np.cross(d, np.roll(d, 1, axis=1) + 0.1)
    t /= np.linalg.norm(t, axis=1)[:, None]
    return t, np.cross(d, t)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_earth_has_land_seas_and_peaks(seed):
    params = TerrainParams(seed=seed)
    d = sphere(12000)
    h = height(d, params)
    assert 0.25 <= np.mean(h > 0.0) <= 0.40
    assert h.min() <= -4000.0
    assert np.mean((h > 0) & (h < 500)) > 0.4 * np.mean(h > 0), "most land is low plains"
    # Climb from the highest samples: peaks are narrow.
    top, step = d[np.argsort(h)[-40:]], 4000.0 / params.radius_m
    rng = np.random.default_rng(1)
    for _ in range(25):
        near = top[:, None] + step * rng.normal(size=(len(top), 8, 3))
        near = np.concatenate([top[:, None], near / np.linalg.norm(near, axis=2)[..., None]], axis=1)
        heights = height(near.reshape(-1, 3), params).reshape(len(top), -1)
        top, step = near[np.arange(len(top)), heights.argmax(axis=1)], step * 0.93
    assert height(top, params).max() >= 6000.0


def test_relief_up_to_100_m_is_within_a_factor_of_two_of_measured_land():
    """Further away it is rougher; the preset `earth` is not: see test_numbers_ground."""
    distances = [d for d in EARTH_LAND_RELIEF_M if d <= 100.0]
    found = relief_statistics(TerrainField(EARTH), EARTH.radius_m, distances, count=6000)
    ratio = found / np.array([EARTH_LAND_RELIEF_M[d] for d in distances])
    assert len(ratio) == 3 and (ratio > 0.5).all() and (ratio < 2.0).all(), ratio


def test_measured_relief_follows_from_its_sources():
    """The table, from the numbers of the publications that it names."""
    slope = np.tan(np.radians(5.5)) / np.log(2.0)  # mean of exponentially distributed slopes with that median
    at_30_m = 30.0 * slope  # rms slope sqrt(2) slope; in one of two directions 1 / sqrt(2) of it
    h, alpha, c1 = 0.66, 1.79, 0.12
    k2 = c1 * (2.0**alpha - 2.0) / (alpha - 1.0)
    assert 1.0 + 2.0 * h - k2 == pytest.approx(2.1, abs=0.01), "the published exponent of the spectrum"
    for distance, metres in EARTH_LAND_RELIEF_M.items():
        exponent = h - 0.5 * k2 if distance > 30.0 else 1.0
        assert metres == pytest.approx(at_30_m * (distance / 30.0) ** exponent, rel=0.02)
    middles = np.arange(250.0, 6500.0, 500.0)
    area = np.array([80780, 29530, 15726, 7794, 5283, 4649, 3351, 1691, 749, 899, 877, 167, 18])  # 1000 km^2
    deviation = np.sqrt(np.cov(middles, fweights=area))
    assert pytest.approx(np.sqrt(2.0) * deviation, rel=0.01) == EARTH_LAND_UNRELATED_M


@pytest.mark.parametrize("name", WORLDS)
def test_no_ground_outside_the_bounds(name):
    params = WORLDS[name]
    h = height(sphere(4000, 5), params)
    assert np.isfinite(h).all()
    assert h.max() < params.highest_m and h.min() > params.lowest_m
    assert h.max() - h.min() > 0.25 * (params.highest_m - params.lowest_m), "and it uses them"


@pytest.mark.parametrize("name", WORLDS)
def test_gradients_are_derivatives(name):
    params = WORLDS[name]
    d = sphere(60, 7)
    _, gradient = height_and_gradient(d, params)
    np.testing.assert_allclose((gradient * d).sum(axis=1), 0.0, atol=1e-12)
    step = 0.02 * params.scale * 0.5 ** (params.layers - 16) / params.radius_m
    for t in tangents(d):
        after, before = (height(d * np.cos(step) + s * t * np.sin(step), params) for s in (1.0, -1.0))
        slope = (after - before) / (2.0 * step * params.radius_m)
        error = np.abs((gradient * t).sum(axis=1) - slope)
        assert np.median(error) < 5e-6 and error.max() < 1e-3  # the rounded crests bend within a step


def test_batches_single_points_and_blocks_agree():
    d = sphere(1501)
    h = height(d, EARTH)
    np.testing.assert_allclose([height(d[i : i + 1], EARTH)[0] for i in range(0, 1501, 50)], h[::50], atol=1e-8)
    np.testing.assert_allclose(height_and_gradient(d, EARTH)[0], h, atol=1e-8)
    assert height(np.empty((0, 3)), EARTH).shape == (0,)


@pytest.mark.parametrize("name", WORLDS)
def test_pairs_have_the_bits_that_each_place_has_alone_and_are_remembered(name, monkeypatch):
    field, d = TerrainField(WORLDS[name]), sphere(60)
    alone = np.array([height(place[None], WORLDS[name])[0] for place in d])
    pairs = np.concatenate([height(d[i : i + 2], WORLDS[name]) for i in range(0, 60, 2)])
    assert (pairs == alone).all()
    assert (field.height(d[:2]) == alone[:2]).all()
    monkeypatch.setattr("planetfall.systems.terrain.height.height", None)  # is not asked again
    assert field.height(d[1:2]) == alone[1] and TerrainField(WORLDS[name]).height(d[:1]) == alone[0]
    assert (field.height(d[1::-1]) == alone[1::-1]).all()
    monkeypatch.undo()
    for place in d:  # however many are asked for
        field.height(place[None])
    assert (field.height(d[:2]) == alone[:2]).all() and len(field._known) < 20


def test_poles_and_seams_are_ordinary_places():
    for axis in np.concatenate([np.eye(3), -np.eye(3), sphere(2)]):
        near = axis + 1e-7 * sphere(200, 3)  # within a metre
        h = height(near / np.linalg.norm(near, axis=1)[:, None], EARTH)
        assert np.ptp(h) < 5.0


def test_band_limit_takes_short_layers_only():
    d = sphere(50)
    _, full = height_and_gradient(d, EARTH)
    _, fine = height_and_gradient(d, EARTH, 0.9)
    _, broad = height_and_gradient(d, EARTH, 5000.0)
    np.testing.assert_allclose(fine, full, atol=1e-12)
    assert np.linalg.norm(broad, axis=1).mean() < np.linalg.norm(full, axis=1).mean()
    h0, each = height_and_gradient(d, EARTH, np.full(50, 5000.0))
    np.testing.assert_allclose(each, broad)
    np.testing.assert_allclose(h0, height(d, EARTH), atol=1e-8)
    np.testing.assert_array_equal(layer_weight(np.array([1.9, 2.0, 4.0, 9.0]), 1.0), [0.0, 0.0, 1.0, 1.0])


def test_equal_params_give_equal_ground_and_seeds_differ():
    d = sphere(100)
    np.testing.assert_array_equal(height(d, TerrainParams(seed=4)), height(d, TerrainParams(seed=4)))
    assert np.abs(height(d, TerrainParams(seed=4)) - height(d, TerrainParams(seed=5))).max() > 1000.0


def test_params_from_any_object_with_the_fields():
    thing = SimpleNamespace(seed=3, highest_m=5000, lowest_m=-4000, layers=12, mountains=0.5, unrelated=1)
    params = TerrainParams.from_component(thing, 3e6)
    assert params == TerrainParams(3e6, 3, 5000.0, -4000.0, 12, mountains=0.5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"layers": 17}, r"layers: expected 1 to 16, found 17"),
        ({"land_share": float("nan")}, r"land_share: expected 0.02 to 0.98, found nan"),
        ({"lowest_m": 9000.0}, r"lowest_m \(9000.0\) has to be a finite number below highest_m \(9000.0\)"),
        ({"radius_m": 0.0}, r"radius_m: expected a positive number of metres, found 0.0"),
        ({"lowest_m": -7e6}, r"lowest_m: -7000000.0 is below the centre"),
    ],
)
def test_bad_params_say_what_and_why(change, message):
    with pytest.raises(ValueError, match=message):
        TerrainParams(**change)
