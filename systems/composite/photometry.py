"""From radiance at three wavelengths to luminance, exposure and display colour: float64 twin of common/color.glsl.

docs/exposure.md explains the choices.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.display import display_color

__all__ = [
    "LUMINANCE_PER_RADIANCE",
    "LUMINANCE_WEIGHTS",
    "SATURATION",
    "SOLAR_ILLUMINANCE_LX",
    "SOLAR_IRRADIANCE",
    "ev100_for_saturation",
    "expose",
    "luminance",
]

Array = NDArray[np.float64]

SOLAR_IRRADIANCE: Array = np.array([1.474, 1.8504, 1.91198])
"""W m^-2 nm^-1 of sunlight outside the air at 680, 550, 440 nm (ASTM G173, as in Bruneton 2017)."""
SOLAR_ILLUMINANCE_LX = 133.1e3
"""The same sunlight as seen by the eye (Darula, Kittler and Gueymard 2005: 133.1-133.3 klx)."""
LUMINANCE_PER_RADIANCE: Array = SOLAR_ILLUMINANCE_LX / SOLAR_IRRADIANCE
"""cd m^-2 per W m^-2 sr^-1 nm^-1, one number for each wavelength, for light of the sun's colour."""
LUMINANCE_WEIGHTS: Array = np.array([0.2126, 0.7152, 0.0722])
"""Rec. 709 weights of red, green and blue."""
SATURATION = 1.2
"""Luminance that exposes to 1 at EV100 0, in cd m^-2 (Lagarde and de Rousiers 2014: 78 / (100 * 0.65))."""


def luminance(radiance: ArrayLike) -> Array:
    """cd m^-2 (...) of a radiance (..., 3)."""
    return np.maximum(display_color(np.asarray(radiance) * LUMINANCE_PER_RADIANCE) @ LUMINANCE_WEIGHTS, 0.0)


def expose(radiance: ArrayLike, ev100: float) -> Array:
    """Linear display colour (..., 3) of a radiance (..., 3): 1 is where a camera of this exposure saturates."""
    light = np.asarray(radiance, dtype=np.float64) * LUMINANCE_PER_RADIANCE
    return np.maximum(display_color(light), 0.0) / (SATURATION * 2.0**ev100)


def ev100_for_saturation(luminance_cd_m2: float) -> float:
    """The EV100 at which this luminance exposes to 1."""
    return float(np.log2(luminance_cd_m2 / SATURATION))
