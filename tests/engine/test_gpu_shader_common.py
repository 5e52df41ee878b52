"""common/safe.glsl and common/octahedral.glsl against float64 numpy."""

from __future__ import annotations

import numpy as np

SAFE = '#include "common/safe.glsl"'
OCT = '#include "common/octahedral.glsl"'


def _angles(high):
    small = np.geomspace(1e-12, high, 3000)
    return np.concatenate([-small[::-1], [0.0], small]).astype(np.float32)


def test_sine_and_cosine_keep_relative_accuracy(run_compute):
    x = _angles(np.pi / 2)
    out = run_compute("s = pf_sin_small(x); c = pf_cos(x); v = pf_one_minus_cos(2.0 * x);",
                      {"x": x}, {"s": "float", "c": "float", "v": "float"}, header=SAFE)  # fmt: skip
    exact = x.astype(np.float64)
    some = exact != 0
    assert np.abs(out["s"] / np.where(some, np.sin(exact), 1) - 1)[some].max() < 1.5e-7
    assert np.abs(out["c"] - np.cos(exact)).max() < 1.5e-7
    # 2 sin^2 x; below 1e-18 the square leaves f32's normal range
    large = np.abs(exact) > 1e-18
    assert np.abs(out["v"] / np.where(large, 2 * np.sin(exact) ** 2, 1) - 1)[large].max() < 4e-7
    assert (out["s"][~some] == 0).all()


def test_guards_hold_where_formulas_break(run_compute):
    x = np.array([-1e-7, 0.0, 4.0, 1.0000001, -1.0000001, 0.3], np.float32)
    out = run_compute(
        "r = safe_sqrt(x); c = clamp_cos(x); s = sin_from_cos(x); g = sign_nonzero(x); d = safe_divide(1.0, x, 7.0);",
        {"x": x},
        dict.fromkeys("rcsgd", "float"),
        header=SAFE,
    )
    np.testing.assert_allclose(out["r"], np.sqrt(np.maximum(x, 0)), rtol=1e-6)
    np.testing.assert_array_equal(out["c"], np.clip(x, -1, 1))
    np.testing.assert_allclose(out["s"], np.sqrt(np.maximum(1 - x.astype(float) ** 2, 0)), rtol=1e-6)
    np.testing.assert_array_equal(out["g"], [-1, 1, 1, 1, -1, 1])
    assert out["d"][1] == 7 and np.isfinite(out["d"]).all()


def test_safe_normalize_from_tiny_to_huge(run_compute):
    direction = np.array([1.0, -2.0, 2.0]) / 3
    v = np.concatenate([direction * np.array([[1e-30], [1.0], [1e30]]), np.zeros((1, 3))])
    out = run_compute("n = safe_normalize(v, vec3(0, 0, 1));", {"v": v}, {"n": "vec3"}, header=SAFE)
    np.testing.assert_allclose(out["n"][:3], np.broadcast_to(direction, (3, 3)), atol=3e-7)
    np.testing.assert_array_equal(out["n"][3], [0, 0, 1])


def test_mean_transmittance(run_compute):
    x = np.concatenate([[0.0], np.geomspace(1e-10, 80, 500)])
    out = run_compute("y = one_minus_exp_over(x);", {"x": x}, {"y": "float"}, header=SAFE)
    exact = np.where(x > 0, -np.expm1(-x) / np.where(x > 0, x, 1), 1)
    # exp(-x) near 1 costs a few ulp just above the switch to the series
    np.testing.assert_allclose(out["y"], exact, rtol=1e-5)


def test_octahedral_round_trip(run_compute):
    n = np.random.default_rng(2).normal(size=(4000, 3))
    n = np.concatenate([n, np.eye(3), -np.eye(3), [[1, 1, 0], [-1, 1, 0], [1, 0, -1], [0, -1, -1], [1e-9, -1e-9, -1]]])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    out = run_compute("e = oct_encode(n); d = oct_decode(e); p = oct_unpack(oct_pack(n));",
                      {"n": n}, {"e": "vec2", "d": "vec3", "p": "vec3"}, header=OCT)  # fmt: skip
    assert np.abs(out["e"]).max() <= 1.0
    np.testing.assert_allclose(out["d"], n, atol=3e-7)
    angle_deg = np.degrees(np.linalg.norm(out["p"] - n, axis=1))
    assert angle_deg.max() < 0.006
    np.testing.assert_allclose(np.linalg.norm(out["p"], axis=1), 1, atol=3e-7)
