"""Automatic exposure: which EV100 a picture asks for. Float64 twin of composite/meter.comp; see docs/exposure.md."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.wavelengths import Nanometres
from .photometry import SATURATION, luminance

__all__ = ["night_key", "target_ev100", "white_luminance"]

Array = NDArray[np.float64]

_LIT_STOPS = 10.0
"""Darker than this against the brightest thousandth says nothing: space around a planet."""
_SUNLIT_STOPS = 5.0
"""What is darker than this against the highlights is in another light: the night side of a planet."""
_HIGHLIGHT = 1.1
"""Exposed light of the 99th percentile: anti-aliasing leaves a picture's own near 1, where a camera has its white."""
_GREY = 0.18
_MOST_LIFT_EV = 1.0
_MOST_CLOSED_EV = 1.0
"""A sun in the picture darkens it by so much."""
_SUNLIT_SHARE = 0.001
"""Highlights over white that faces the sun, below which the sun lights nothing but itself."""
_MEDIANS = (0.25, 0.85)
"""Exposed light that the median may have at most: of a picture without anything white, and of snow or cloud alone."""
_WHITE_SHARES = (0.1, 0.6)
"""Highlights over white under this sun: those of dark ground or sea, and those of snow."""
_LOWEST_SINE = 0.01
"""Of the sun's elevation: a dusk sky counts as what a sun that has just risen would light."""


def white_luminance(sun_irradiance: ArrayLike, sun_sine: float, nm: Nanometres) -> float:
    """cd m^-2 of white level ground in this sunlight (3,), in W m^-2 nm^-1 at the wavelengths
    `nm`, without air. sun_sine: of its elevation."""
    return float(luminance(sun_irradiance, nm)) / np.pi * max(sun_sine, _LOWEST_SINE)


def night_key(luminance_cd_m2: float) -> float:
    """How bright the picture of a scene should be against one in sunlight: night looks dark (Krawczyk et al. 2005,
    eq. 11)."""
    key = 1.03 - 2.0 / (2.0 + np.log10(luminance_cd_m2 + 1.0))
    return float(np.clip(key / 0.68, 0.02, 1.0))


def target_ev100(luminances: ArrayLike, white_cd_m2: float, sun_cd_m2: float, compensation_ev: float = 0.0) -> float:
    """The EV100 that a picture of these luminances (any shape, cd m^-2) asks for, exact where the shader counts in bins
    of 0.1 EV. white_cd_m2: `white_luminance`; sun_cd_m2: of white ground that faces the sun, above which is sun or
    glint. ValueError for a picture that is all black, which has no exposure of its own."""
    seen = np.sort(np.asarray(luminances, np.float64).ravel())
    found = seen[seen > 0.0]
    if found.size == 0:
        raise ValueError("all luminances are 0: a black picture asks for the lowest EV100 there is")
    shown = found[found <= sun_cd_m2] if np.any(found <= sun_cd_m2) else found
    peak = shown[max(shown.size - 1 - int(0.001 * seen.size), 0)]
    lit = shown[shown >= peak * 2.0**-_LIT_STOPS]
    highlight = float(np.percentile(lit, 99.0))
    median = float(np.median(lit[lit >= highlight * 2.0**-_SUNLIT_STOPS]))
    key = night_key(highlight)
    ev = np.log2(highlight / (_HIGHLIGHT * key * SATURATION))
    ev -= np.clip(ev - np.log2(median / (_GREY * key * SATURATION)), 0.0, _MOST_LIFT_EV)
    low, high = _WHITE_SHARES
    t = np.clip((highlight / white_cd_m2 - low) / (high - low), 0.0, 1.0)
    most = _MEDIANS[0] + (_MEDIANS[1] - _MEDIANS[0]) * t * t * (3.0 - 2.0 * t)
    ev = max(ev, np.log2(median / (most * key * SATURATION)))
    closed = _MOST_CLOSED_EV if highlight > _SUNLIT_SHARE * sun_cd_m2 else np.inf
    ev += np.clip(np.log2(seen.mean() / (4.0 * SATURATION)) - ev, 0.0, closed)
    return float(ev - compensation_ev)
