"""How waves flatten in shallow water, and which ones a sample is too coarse for. The shaders have the same formulas."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["FREEZE", "footprint_weight", "open_share", "shoaling", "shoaling_slope", "smoothstep"]

Floats = NDArray[np.float64]

DEEP = 10.0
"""tanh(x) is 1 to 4e-9 from here on: deeper water is as good as bottomless."""
FREEZE = 0.02
"""Of the sine of the latitude: over so much of it ice closes and stills the waves."""
FINEST, COARSEST = 2.0, 4.0
"""Samples a wavelength: below the first a wave can't be drawn at all, from the second on it is drawn in full."""


def smoothstep(low: ArrayLike, high: ArrayLike, value: ArrayLike) -> Floats:
    """GLSL's: 0 below low, 1 above high, 3 t^2 - 2 t^3 between."""
    e0, e1, x = (np.asarray(v, dtype=np.float64) for v in (low, high, value))
    t = np.clip((x - e0) / (e1 - e0), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def shoaling(wave_number_per_m: ArrayLike, depth_m: ArrayLike) -> Floats:
    """Factor of a wave's amplitude in water of this depth: tanh(k depth), 0 on land.

    It is 1 to half a per cent from a depth of half a wavelength on, where waves begin to feel the bed, and vanishes at
    the shore, so the coast stays where sea level meets the ground. In shallows the significant height becomes a fixed
    share of the depth, a third of it in a breeze; where real waves break it is about half.
    """
    return np.tanh(np.maximum(np.asarray(wave_number_per_m) * np.asarray(depth_m), 0.0))


def shoaling_slope(wave_number_per_m: ArrayLike, depth_m: ArrayLike) -> Floats:
    """d shoaling / d depth, 1/m: k (1 - tanh^2), 0 on land."""
    k, depth = np.asarray(wave_number_per_m), np.asarray(depth_m)
    return np.where(depth > 0.0, k * (1.0 - shoaling(k, depth) ** 2), 0.0)


def open_share(ice_sine: float, directions: Floats) -> Floats:
    """Share of the depth (M,) that waves have under ice, at unit directions (M, 3): 1 before its edge, 0 within.

    ice_sine: of the latitude where it begins; above 1: nowhere. Closed ice calms waves as shallow water does.
    """
    return 1.0 - smoothstep(ice_sine, ice_sine + FREEZE, np.abs(directions[:, 2]))


def footprint_weight(wavelength_m: ArrayLike, spacing_m: ArrayLike) -> Floats:
    """Share of a wave's amplitude that samples this far apart show: smoothstep(2, 4, wavelength / spacing).

    What it leaves out, (A k)^2 / 2 (1 - weight^2), is slope variance. A window that ends: waves are sorted, longest
    first, so a loop over them stops at the first one that is too short.
    """
    spacing = np.maximum(np.asarray(spacing_m, dtype=np.float64), 1e-9)
    return smoothstep(FINEST, COARSEST, np.asarray(wavelength_m) / spacing)
