"""Float64 twin of sky/sun_disc.glsl: radiance of the sun's disc with limb darkening."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.wavelengths import GIVEN_NM, Nanometres

__all__ = ["LIMB_EXPONENTS", "disc_radiance", "limb_exponents"]

Array = NDArray[np.float64]

LIMB_EXPONENTS: Array = np.array([0.397, 0.503, 0.652])
"""Limb darkening I / I_centre = mu^a at GIVEN_NM (Hestroffer and Magnan 1998, their power law)."""


def limb_exponents(nm: Nanometres) -> Array:
    """(3,) at wavelengths of which red may be another: linear in the inverse wavelength, as they found it."""
    red, green = (1.0 / wavelength for wavelength in GIVEN_NM[:2])
    share = (green - 1.0 / nm[0]) / (green - red)
    return np.array([LIMB_EXPONENTS[1] + share * (LIMB_EXPONENTS[0] - LIMB_EXPONENTS[1]), *LIMB_EXPONENTS[1:]])


def disc_radiance(sine: Array, irradiance: Array, angular_radius_rad: float, nm: Nanometres = GIVEN_NM) -> Array:
    """Radiance (..., 3) at angles from the sun's centre given by their sines (...); 0 outside.

    Integrated over the disc with the cosine it gives back the irradiance: the mean of mu^a over a disc is 2 / (a + 2).
    """
    edge = np.sin(angular_radius_rad)
    r2 = (np.asarray(sine, dtype=np.float64) / edge) ** 2
    mu = np.sqrt(np.maximum(1.0 - r2, 0.0))[..., None]
    exponents = limb_exponents(nm)
    profile = mu**exponents * (exponents + 2.0) / 2.0
    return np.where(r2[..., None] <= 1.0, profile * np.asarray(irradiance) / (np.pi * edge**2), 0.0)
