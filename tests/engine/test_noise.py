"""Lattice noise: the numpy batches against the plain definition, and GLSL against numpy."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.noise import (
    NOISE_BOUND,
    Lattice,
    Scratch,
    gradient_noise,
    gradient_noise_derivative,
    octave_offset,
    pcg3d,
)

NOISE = '#include "common/noise.glsl"'


@pytest.fixture
def points():
    rng = np.random.default_rng(3)
    return rng.uniform(-40.0, 40.0, (700, 3))


def test_offsets_depend_on_seed_octave_and_axis_only():
    offsets = np.array([octave_offset(seed, k) for seed in (0, 1, 2**31 - 1) for k in range(8)])
    assert len(np.unique(offsets)) == offsets.size
    np.testing.assert_array_equal(octave_offset(7, 3), octave_offset(7, 3))
    assert (offsets >= 0).all() and (offsets < 4096).all()
    np.testing.assert_array_equal(offsets, offsets * 2.0**24 // 1 * 2.0**-24)


@pytest.mark.parametrize("count", [1, 3, 700])
def test_batches_agree_with_the_definition(points, count):
    p = points[:count]
    lattice = Lattice.of([8.0, 2.0, 0.5], [octave_offset(1, k) for k in range(3)])
    value = lattice.cells(p.T.copy()).noise()
    again = lattice.cells(p.T.copy(), Scratch()).noise()
    with_slope, slope = lattice.cells(p.T.copy()).noise_derivative()
    for k in range(3):
        expected, derivative = gradient_noise_derivative(p * lattice.frequency[k] + lattice.offset[k])
        for found in (value[k], again[k], with_slope[k]):
            np.testing.assert_allclose(found, expected, atol=1e-14)
        np.testing.assert_allclose(slope[:, k].T, derivative, atol=1e-13)
    assert np.abs(value).max() < NOISE_BOUND


def test_points_of_their_own_for_each_octave(points):
    lattice = Lattice.of([4.0, 1.0], np.zeros((2, 3)))
    where = np.stack([points[:300].T, points[300:600].T], axis=1)
    value = lattice.cells(where).noise()
    np.testing.assert_allclose(value[0], gradient_noise(points[:300] / 4.0), atol=1e-14)
    np.testing.assert_allclose(value[1], gradient_noise(points[300:600]), atol=1e-14)


def test_derivatives_are_derivatives(points):
    lattice, h = Lattice.of([1.0], np.zeros((1, 3))), 1e-5
    _, slope = lattice.cells(points.T.copy()).noise_derivative()
    _, jacobian = lattice.cells(points.T.copy()).vector_derivative()
    for axis in range(3):
        step = np.zeros((3, 1))
        step[axis] = h
        after, before = lattice.cells(points.T + step), lattice.cells(points.T - step)
        np.testing.assert_allclose((after.noise() - before.noise())[0] / (2 * h), slope[axis, 0], atol=1e-7)
        np.testing.assert_allclose((after.vector() - before.vector())[:, 0] / (2 * h), jacobian[:, axis, 0], atol=1e-6)


def test_value_and_slope_are_continuous_across_cells():
    rng = np.random.default_rng(1)
    p = rng.uniform(-5, 5, (200, 3))
    p[:, 1] = np.round(p[:, 1])
    below, above = p.copy(), p.copy()
    below[:, 1] -= 1e-9
    above[:, 1] += 1e-9
    (v0, d0), (v1, d1) = gradient_noise_derivative(below), gradient_noise_derivative(above)
    np.testing.assert_allclose(v0, v1, atol=1e-8)
    np.testing.assert_allclose(d0, d1, atol=1e-7)


def test_hash_has_the_same_bits_on_the_gpu(run_compute):
    words = np.random.default_rng(2).integers(0, 2**32, (500, 3), np.uint32)
    expected = np.stack(pcg3d(*words.T), axis=1)
    out = run_compute(
        "h = uvec3(lattice_hash(w.x * 1664525u + 1013904223u, w.y * 1664525u + 1013904223u,"
        " w.z * 1664525u + 1013904223u));",
        {"w": words},
        {"h": "uvec3"},
        header=NOISE,
    )
    np.testing.assert_array_equal(out["h"].view(np.int32), expected.view(np.int32) >> 8)


def test_gradient_noise_on_the_gpu(run_compute, points):
    cell = np.floor(points)
    fraction = (points - cell).astype(np.float32)
    value, slope = gradient_noise_derivative(cell + fraction.astype(np.float64))
    out = run_compute(
        "n = gradient_noise(cell, f); v = gradient_noise_value(cell, f);",
        {"cell": cell.astype(np.int32), "f": fraction},
        {"n": "vec4", "v": "float"},
        header=NOISE,
    )
    np.testing.assert_allclose(out["n"][:, 3], value, atol=2e-7)
    np.testing.assert_allclose(out["v"], value, atol=2e-7)
    np.testing.assert_allclose(out["n"][:, :3], slope, atol=3e-6)


def test_vector_noise_on_the_gpu(run_compute, points):
    cell = np.floor(points)
    fraction = (points - cell).astype(np.float32)
    corners = Lattice.of([1.0], np.zeros((1, 3))).cells((cell + fraction).T.copy())
    value, jacobian = corners.vector_derivative()
    out = run_compute(
        "mat3 j; v = vector_noise(cell, f, j); a = j[0]; b = j[1]; c = j[2];",
        {"cell": cell.astype(np.int32), "f": fraction},
        dict.fromkeys("vabc", "vec3"),
        header=NOISE,
    )
    np.testing.assert_allclose(out["v"], value[:, 0].T, atol=2e-7)
    for axis, name in enumerate("abc"):
        np.testing.assert_allclose(out[name], jacobian[:, axis, 0].T, atol=3e-6)


def test_noise_in_fixed_point(run_compute):
    """A millimetre of the ground: belts magnify noise by up to 250 km, and the wide warp moves places by 1100 km, by
    which the ground of belts rises a tenth. At both ends of cells, too, where weights must not wrap around."""
    rng, count = np.random.default_rng(6), 4000
    cell = rng.integers(-(2**20), 2**20, (count, 3)).astype(np.int32)
    part = rng.integers(0, 2**32, (count, 3), np.uint32)
    ends = np.array([0, 1, 2**31 - 1, 2**31, 2**32 - 2, 2**32 - 1], np.uint32)
    part[: count // 4] = rng.choice(ends, (count // 4, 3))
    place = cell + part * 2.0**-32
    corners = Lattice.of([1.0], np.zeros((1, 3))).cells(place.T.copy())
    (value, slope), (vector, jacobian) = gradient_noise_derivative(place), corners.vector_derivative()
    out = run_compute(
        "vec3 g; n = gradient_noise(cell, f, g); s = g; mat3 j; v = vector_noise(cell, f, j); a = j[0]; b = j[1];"
        " c = j[2];",
        {"cell": cell, "f": part},
        {"n": "int", "s": "vec3", "v": "ivec3", **dict.fromkeys("abc", "vec3")},
        header='#include "common/noise_fixed.glsl"',
    )
    np.testing.assert_allclose(out["n"] * 2.0**-30, value, rtol=0, atol=4e-9)
    np.testing.assert_allclose(out["v"] * 2.0**-30, vector[:, 0].T, rtol=0, atol=9e-9)
    np.testing.assert_allclose(out["s"], slope, atol=3e-6)
    for axis, name in enumerate("abc"):
        np.testing.assert_allclose(out[name], jacobian[:, axis, 0].T, atol=3e-6)


@pytest.mark.parametrize("way", [1e-6, 1e-3, 0.1, 1.0])
def test_changes_of_noise_are_as_exact_as_the_way_is_short(run_compute, way):
    """Within a cell, of its corners too: a difference of two noises would be wrong by 1e-7 however short the way."""
    rng = np.random.default_rng(5)
    cell, start = rng.integers(-40, 40, (2000, 3)), rng.uniform(0.0, 1.0, (2000, 3)).astype(np.float32)
    start[:300] = np.round(start[:300])
    step = (rng.uniform(-way, way, start.shape)).astype(np.float32)
    step = (np.clip(start + step.astype(np.float64), 0.0, 1.0) - start).astype(np.float32)
    out = run_compute(
        "c = gradient_noise_change(cell, f, d, n); mat3 j; v = vector_noise_change(cell, f, d, w, j); a = j[0];",
        {"cell": cell.astype(np.int32), "f": start, "d": step},
        {"c": "float", "n": "vec4", "v": "vec3", "w": "vec3", "a": "vec3"},
        header='#include "common/noise_change.glsl"',
    )
    from_, to = cell + start.astype(np.float64), cell + start.astype(np.float64) + step
    lattice = Lattice.of([1.0], np.zeros((1, 3)))
    before, after = lattice.cells(from_.T.copy()), lattice.cells(to.T.copy())
    value, slope = gradient_noise_derivative(to)
    vectors, jacobian = after.vector_derivative()
    length = np.linalg.norm(step, axis=1)
    # Float64 rounds too: 1e-16 of a noise is 1e-10 of a way of 1e-6.
    assert (np.abs(out["c"] - (value - before.noise()[0])) <= 1e-6 * length + 1e-15).all()
    assert (np.abs(out["v"] - (vectors - before.vector())[:, 0].T).max(axis=1) <= 1e-6 * length + 1e-15).all()
    np.testing.assert_allclose(out["n"], np.column_stack([slope, value]), atol=3e-6)
    np.testing.assert_allclose(out["w"], vectors[:, 0].T, atol=3e-7)
    np.testing.assert_allclose(out["a"], jacobian[:, 0, 0].T, atol=3e-6)
