"""Rays against spheres, held against exact rational arithmetic."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

import numpy as np
import pytest

from planetfall.engine.space import ray_sphere, ray_sphere_from

RADII = (1e3, 6.371e6, 7e7)


def exact_root(value: Fraction) -> Fraction:
    """Square root to about 40 digits."""
    scale = 10**80
    return Fraction(isqrt(value.numerator * scale // value.denominator), 10**40)


def exact_hit(height: float, mu: float, radius: float) -> list[float]:
    """Distances > 0 at which the ray crosses the sphere, sorted."""
    h, m, r = Fraction(height), Fraction(mu), Fraction(radius)
    b = (r + h) * m
    discriminant = b * b - h * (2 * r + h)
    if discriminant < 0:
        return []
    root = exact_root(discriminant)
    return sorted(float(t) for t in (-b - root, -b + root) if t > 0)


@pytest.mark.parametrize("radius", RADII)
def test_against_exact_arithmetic(radius):
    rng = np.random.default_rng(8)
    height = 10.0 ** rng.uniform(-2, 9, 600) * rng.choice([1, 1, 1, -1], 600)
    height = np.where(height < -0.9 * radius, -0.01, height)
    mu = rng.uniform(-1, 1, 600)
    grazing = -np.sqrt(np.maximum(height, 0) * (2 * radius + np.maximum(height, 0))) / (radius + np.maximum(height, 0))
    some = rng.random(600) < 0.5
    mu = np.where(some & (height > 0), np.clip(grazing * (1 + 10.0 ** rng.uniform(-9, -1, 600)), -1, 1), mu)
    found = ray_sphere(height, mu, radius)
    for k in range(600):
        expected = exact_hit(height[k], mu[k], radius)
        assert bool(found.hit[k]) == bool(expected)
        if not expected:
            assert np.isinf(found.near_m[k])
            continue
        # Grazing rays: a relative error e of the cosine moves the hit by e / sqrt(D), whoever computes it.
        slack = 1e-14
        if len(expected) == 2:
            slack += 1e-15 * ((expected[1] + expected[0]) / (expected[1] - expected[0])) ** 2
        assert found.near_m[k] == pytest.approx(expected[0], rel=slack)
        assert found.far_m[k] == pytest.approx(expected[-1], rel=slack)


@pytest.mark.parametrize("radius", RADII)
def test_level_rays(radius):
    outside, inside, on = ray_sphere([1e-2, -1e-2, 0.0], 0.0, radius).hit
    assert not outside
    assert inside
    assert not on
    exit_m = ray_sphere(-1e-2, 0.0, radius).near_m
    assert exit_m == pytest.approx(exact_hit(-1e-2, 0.0, radius)[0], rel=1e-14)
    assert ray_sphere(-1e-2, -0.0, radius).near_m == exit_m


def test_from_the_surface():
    hit = ray_sphere(0.0, [-0.5, 0.5, -1.0], 1e3)
    np.testing.assert_array_equal(hit.hit, [True, False, True])
    np.testing.assert_allclose(hit.near_m[[0, 2]], 0.0)
    np.testing.assert_allclose(hit.far_m[[0, 2]], [1e3, 2e3])


def test_straight_up_and_down():
    for radius in RADII:
        down = ray_sphere(2.0, -1.0, radius)
        assert down.near_m == pytest.approx(2.0, rel=1e-15)
        assert down.far_m == pytest.approx(2.0 + 2 * radius, rel=1e-15)
        assert not ray_sphere(2.0, 1.0, radius).hit
        assert ray_sphere(-2.0, 1.0, radius).near_m == pytest.approx(2.0, rel=1e-15)


def test_from_vectors():
    origins = np.array([[0, 0, 6.371e6 + 100.0], [0, 0, 6.371e6 + 100.0], [0, 0, 0]])
    directions = np.array([[0, 0, -1.0], [1.0, 0, 0], [0, 1.0, 0]])
    hit = ray_sphere_from(origins, directions, 6.371e6)
    np.testing.assert_array_equal(hit.hit, [True, False, True])
    np.testing.assert_allclose(hit.near_m[[0, 2]], [100.0, 6.371e6])
    assert not np.isnan(hit.near_m).any()
