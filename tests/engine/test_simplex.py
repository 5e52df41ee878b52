"""Simplex noise: continuous, bounded, and the same on the GPU."""

from __future__ import annotations

import numpy as np

from planetfall.engine.surface.simplex import SIMPLEX_BOUND, SIMPLEX_SCALE, simplex_in_cell, simplex_noise, skew


def test_bounded_and_without_jumps():
    rng = np.random.default_rng(1)
    points = rng.uniform(-50.0, 50.0, (40_000, 3))
    noise = simplex_noise(points)
    assert np.abs(noise).max() < SIMPLEX_BOUND
    assert abs(noise.mean()) < 0.01
    # The steepest slope there can be is 4 corners' worth of 8 r t^3 |x| + t^4 with gradients below sqrt(3).
    step = rng.normal(size=points.shape)
    step *= 1e-6 / np.linalg.norm(step, axis=1, keepdims=True)
    steepest = SIMPLEX_SCALE * 4 * np.sqrt(3.0) * (0.5**4 + 8 * 0.5 * 0.5**3)
    assert np.abs(simplex_noise(points + step) - noise).max() <= 1e-6 * steepest


def test_the_bound_holds_for_the_worst_gradients():
    f = np.random.default_rng(2).random((100_000, 3))
    f.sort(axis=1)
    f = f[:, ::-1]  # one of the six simplices of the cell stands for all: x >= y >= z
    origin = f - f.sum(axis=1, keepdims=True) / 6.0
    most = np.zeros(len(f))
    for number, corner in enumerate(([0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 1, 1])):
        offset = origin - corner + number / 6.0
        most += np.maximum(0.5 - (offset**2).sum(axis=1), 0.0) ** 4 * np.abs(offset).sum(axis=1)
    assert SIMPLEX_SCALE * most.max() < SIMPLEX_BOUND


def test_the_gpu_agrees(run_compute):
    rng = np.random.default_rng(3)
    cell = rng.integers(-(2**31), 2**31, (5000, 3)).astype(np.int32)
    f = rng.random((5000, 3)).astype(np.float32)
    out = run_compute(
        "n = simplex_noise(cell, f);", {"cell": cell, "f": f}, {"n": "float"}, header='#include "common/simplex.glsl"'
    )
    assert np.abs(out["n"] - simplex_in_cell(cell.astype(np.int64), f.astype(np.float64))).max() <= 2e-6


def test_skewed_cells_are_unit_cubes():
    # The simplex lattice's basis is that of the body-centred cubic lattice; its points have whole skewed coordinates.
    basis = np.eye(3) - 1.0 / 6.0
    np.testing.assert_allclose(skew(np.array([[2, -1, 5], [0, 7, 3]]) @ basis), [[2, -1, 5], [0, 7, 3]], atol=1e-12)
