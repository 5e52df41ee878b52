"""Elevation from tiles in place of the procedural ground, in numpy: of heights, of bounds on slopes, and of gradients.

The ground around shows by what the tiles leave of it: all of it outside, nothing inside, both over a margin. Where
nothing of it shows it is not evaluated.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .height_model import Model, TerrainConstants

__all__ = ["margin_slopes", "real_gradients", "real_heights", "real_slopes", "unlimited"]

Floats = NDArray[np.float64]


def real_heights(points: Floats, model: Model, around: Callable[[Floats, Model], Floats]) -> Floats:
    """Heights (N,) at points (3, N). around: those of the procedural ground."""
    real = model.params.real
    if real is None:
        return around(points, model)
    height, rest = real.heights(points)
    at = np.flatnonzero(rest > 0.0)
    if at.size:
        height[at] += rest[at] * around(points[:, at], model)
    return height


def real_slopes(
    points: Floats, model: Model, around: Callable[[Floats, Model], tuple[Floats, Floats]]
) -> tuple[Floats, Floats]:
    """Heights (N,) and slopes (N,) that the ground hardly ever exceeds. around: those of the procedural ground."""
    real = model.params.real
    if real is None:
        return around(points, model)
    height, rest = real.heights(points)
    slope = real.slopes(points, model.params.radius_m)
    at = np.flatnonzero(rest > 0.0)
    if at.size:
        there, steep = around(points[:, at], model)
        height[at] += rest[at] * there
        slope[at] += rest[at] * steep + margin_slopes(points, model, at, there)
    return height, slope


def margin_slopes(points: Floats, model: Model, at: NDArray[np.int64], around_m: Floats) -> Floats:
    """What passing from real ground to the one around, around_m (M,) high, makes of slopes (M,) at points[:, at]."""
    real = model.params.real
    out = np.zeros(len(at))
    if real is None:
        return out
    _, rest = real.heights(points[:, at])
    faded = np.flatnonzero(rest < 1.0)
    if faded.size:
        found = real.gradients(points[:, at[faded]], model.params.radius_m, None)
        total = found.d_height + found.d_rest * around_m[faded]
        out[faded] = 2.0 * np.linalg.norm(total, axis=0)
    return out


def unlimited(k: TerrainConstants, h: Floats) -> Floats:
    """The height (N,) whose limit is h (N,)."""
    over, under = np.maximum(h - k.knee_high_m, 0.0), np.maximum(k.knee_low_m - h, 0.0)
    more = over * over / np.maximum(k.room_high_m - over, 1e-9) if k.room_high_m > 0.0 else 0.0
    less = under * under / np.maximum(k.room_low_m - under, 1e-9) if k.room_low_m > 0.0 else 0.0
    return h + more - less


def real_gradients(
    points: Floats,
    model: Model,
    footprint_m: Floats | None,
    around: Callable[[Floats, Model, Floats | None], tuple[Floats, Floats]],
) -> tuple[Floats, Floats]:
    """Heights (N,) and gradients (3, N) as the footprint (N,) shows them. around: those of the procedural ground."""
    real = model.params.real
    if real is None:
        return around(points, model, footprint_m)
    found = real.gradients(points, model.params.radius_m, footprint_m)
    height, gradient = found.height_m, found.d_height
    at = np.flatnonzero((found.rest > 0.0) | (found.seen_rest > 0.0))
    if at.size:
        there, slope = around(points[:, at], model, None if footprint_m is None else footprint_m[at])
        height[at] += found.rest[at] * there
        gradient[:, at] += found.seen_rest[at] * slope + found.d_rest[:, at] * there
    return height, gradient
