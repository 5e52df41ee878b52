"""From radiance at three wavelengths to luminance, exposure and display colour: float64 twin of common/color.glsl.

docs/exposure.md explains the choices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.display import display_color
from ...engine.wavelengths import SUNLIGHT, Nanometres

__all__ = [
    "LUMINANCE_WEIGHTS",
    "SATURATION",
    "SOLAR_ILLUMINANCE_LX",
    "ev100_for_saturation",
    "expose",
    "luminance",
    "luminance_per_radiance",
]

Array = NDArray[np.float64]

SOLAR_ILLUMINANCE_LX = 133.1e3
"""Sunlight outside the air as seen by the eye (Darula, Kittler and Gueymard 2005: 133.1-133.3 klx)."""
LUMINANCE_WEIGHTS: Array = np.array([0.2126, 0.7152, 0.0722])
"""Rec. 709 weights of red, green and blue."""
SATURATION = 1.2
"""Luminance that exposes to 1 at EV100 0, in cd m^-2 (Lagarde and de Rousiers 2014: 78 / (100 * 0.65))."""


def luminance_per_radiance(nm: Nanometres) -> Array:
    """cd m^-2 per W m^-2 sr^-1 nm^-1 (3,), for light of the sun's colour."""
    return SOLAR_ILLUMINANCE_LX / np.array(SUNLIGHT[nm])


def luminance(radiance: ArrayLike, nm: Nanometres) -> Array:
    """cd m^-2 (...) of a radiance (..., 3) at the wavelengths `nm`."""
    light = np.asarray(radiance, dtype=np.float64) * luminance_per_radiance(nm)
    return np.maximum(display_color(light, nm) @ LUMINANCE_WEIGHTS, 0.0)


def expose(radiance: ArrayLike, ev100: float, nm: Nanometres) -> Array:
    """Linear display colour (..., 3) of a radiance (..., 3) at the wavelengths `nm`: 1 is where a camera of this
    exposure saturates."""
    light = np.asarray(radiance, dtype=np.float64) * luminance_per_radiance(nm)
    return np.maximum(display_color(light, nm), 0.0) / (SATURATION * 2.0**ev100)


def ev100_for_saturation(luminance_cd_m2: float) -> float:
    """The EV100 at which this luminance exposes to 1."""
    return float(np.log2(luminance_cd_m2 / SATURATION))
