"""A cubic through four samples whose slopes are limited, so that it hardly leaves the range of the two in the middle.

Twin of assets/shaders/terrain/limited_cubic.glsl. At a sample with the steps a before and b after it, the slope is

    m = c g(q),   c = (a + b) / 2,   q = 2 a b / (a^2 + b^2),   g(q) = 2 q / (1 + q^2)

q is the limiter of van Albada, van Leer and Roberts (1982) by c; g keeps c where steps are alike (1 - g is of the
fourth order in a - b, so the curve is Catmull-Rom's there), and is 0 where one of them is. With it

- where both steps rise, m is at most 2.1 of the smaller one;
- where one rises and the other falls, m has the sign of the smaller step, and is at most 0.296 of the larger one.

Hermite's cubic over a step of 1 whose slopes are within [-0.296, 2.1] leaves [0, 1] by 0.0149 at most. Across a cell it
is applied twice, rows first, so a surface leaves the range of a cell's four corners by at most

    0.0149 + 0.0149 (1 + 2 * 0.0149) = 0.0303 of it,

less than the 5 % that are promised. The row curves at an edge, and the slopes across it, are the same from both sides:
the surface and its gradient are continuous, but for the turn of the limiter where both steps vanish.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["OVERSHOOT", "limited_cubic", "limited_slope"]

Floats = NDArray[np.float64]
Taps = Sequence[Floats] | Floats

OVERSHOOT = 0.05
"""Of the range of a cell's four corners: a surface never leaves it by more."""


def limited_slope(a: Floats, b: Floats) -> Floats:
    """The slope by sample at a sample with steps a and b, any shape."""
    return _slope(a, b)[0]


def _slope(a: Floats, b: Floats) -> tuple[Floats, Floats, Floats]:
    """The slope and its derivatives by a and b."""
    size = np.abs(a) + np.abs(b)
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y = (np.where(size > 0.0, v / size, 0.0) for v in (a, b))
    p, q, s = x * y, x * x + y * y, x + y
    top, below = 2.0 * p * s * q, np.maximum(q * q + 4.0 * p * p, 1e-30)
    found = top / below
    by = []
    for u, v in ((x, y), (y, x)):
        d_top = 2.0 * (v * s * q + p * q + 2.0 * p * s * u)
        by.append((d_top - found * (4.0 * u * q + 8.0 * p * v)) / below)
    return size * found, by[0], by[1]


def limited_cubic(taps: Taps, t: Floats, d_taps: Taps | None = None) -> tuple[Floats, Floats, Floats | None]:
    """The curve through four taps (4, ...) at t (...) between the second and the third: its value, its derivative by t,
    and, of taps that change by d_taps (4, ...), its change."""
    a, b, c = taps[1] - taps[0], taps[2] - taps[1], taps[3] - taps[2]
    (m0, m0_a, m0_b), (m1, m1_b, m1_c) = _slope(a, b), _slope(b, c)
    rest = 1.0 - t
    step, in0, in1 = t * t * (3.0 - 2.0 * t), t * rest * rest, t * t * rest
    value = taps[1] + (step * b + in0 * m0 - in1 * m1)
    slope = 6.0 * t * rest * b + rest * (1.0 - 3.0 * t) * m0 - t * (2.0 - 3.0 * t) * m1
    if d_taps is None:
        return value, slope, None
    da, db, dc = d_taps[1] - d_taps[0], d_taps[2] - d_taps[1], d_taps[3] - d_taps[2]
    change = d_taps[1] + step * db + in0 * (m0_a * da + m0_b * db) - in1 * (m1_b * db + m1_c * dc)
    return value, slope, change
