"""The test helper itself: values go to the GPU and back unharmed."""

from __future__ import annotations

import numpy as np
import pytest


@pytest.mark.parametrize("components", [1, 2, 3, 4])
@pytest.mark.parametrize("dtype", [np.float32, np.int32, np.uint32])
def test_round_trip(run_compute, components, dtype):
    bits = np.random.default_rng(1).integers(0, 2**32, (100, components), np.uint32)
    if dtype is np.float32:
        bits &= 0x7F7FFFFF  # no NaN, whose payload a driver may change
        bits |= 0x00800000  # no denormals, which may be flushed
    x = bits.view(dtype)
    x = x[:, 0] if components == 1 else x
    out = run_compute("y = x;", {"x": x}, {"y": (components, dtype)})
    assert out["y"].dtype == dtype
    np.testing.assert_array_equal(out["y"], x)


def test_special_values_and_broadcast(run_compute):
    x = np.array([np.inf, -np.inf, np.nan, 0.0, 1.5])
    out = run_compute(
        "y = x; v = b * scale + float(index);",
        {"x": x, "b": (1.0, 2.0, 3.0)},
        {"y": "float", "v": "vec3"},
        header="uniform float scale;",
        uniforms={"scale": 2.0},
    )
    np.testing.assert_array_equal(out["y"], x)
    np.testing.assert_array_equal(out["v"][2], [4.0, 6.0, 8.0])
