"""The air's uniform block: what every shader that lights or looks through air reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...engine.blocks.layout import Vec3, Vec4
from .model import AirModel

__all__ = ["AIRGLOW_PER_SR", "AirBlock", "air_block"]

AIRGLOW_PER_SR = 1.0e-9
"""Radiance of Earth's airglow overhead, as a share of the sun's irradiance per steradian.

The dark sky overhead has V = 21.9 per square arc second, two thirds of it airglow (Benn and Ellison 1998): 22.35. That
is 49.1 magnitudes below the sun (-26.74), 2.3e-20 of its irradiance from 2.35e-11 sr."""


class _NightLit(Protocol):
    night_light: float


@dataclass
class AirBlock:
    """One planet's air. GLSL: ``#include "generated/air_model.glsl"``, instance ``air_model``. Vec3: three wavelengths;
    per metre: at the floor."""

    radius_m: float
    """of the ground"""
    top_radius_m: float
    thickness_m: float
    per_thickness: Annotated[float, "1/m"]
    rayleigh_per_m: Vec3
    """scattering of gas"""
    rayleigh_height_m: float
    """scale height"""
    mie_scattering_per_m: Vec3
    """scattering of haze"""
    mie_height_m: float
    mie_extinction_per_m: Vec3
    mie_asymmetry: float
    absorption_per_m: Vec3
    """at the layer's centre"""
    absorber_height_m: float
    """of the layer's centre"""
    ground_albedo: Vec3
    absorber_slope_per_m: float
    """1 / half width of the layer, whose density is a tent"""
    night_radiance: Annotated[Vec3, "W m^-2 sr^-1 nm^-1"]
    """of the night sky's own light overhead"""
    longest_path_m: float
    """from the floor to the top, along the horizon"""
    mie_moments: Vec4
    """Legendre moments 1 to 4 of the haze's phase function"""
    sun_radius_rad: float
    """the sun's angular radius"""


def cornette_shanks_moments(asymmetry: float) -> list[float]:
    """Legendre moments 1 to 4 (2 pi times the integral of p P_l) of Cornette and Shanks' phase function.

    It is 3 / 2 (1 + nu^2) / (2 + g^2) times Henyey and Greenstein's, whose moments are g^l; nu^2 P_l is a sum of
    P_(l-2), P_l and P_(l+2) by the recurrence of Legendre's polynomials.
    """
    g = asymmetry
    found = []
    for n in range(1, 5):
        up = (n + 1) * (n + 2) / ((2 * n + 1) * (2 * n + 3))
        level = (n + 1) ** 2 / ((2 * n + 1) * (2 * n + 3)) + n * n / ((2 * n + 1) * (2 * n - 1))
        down = n * (n - 1) / ((2 * n + 1) * (2 * n - 1))
        # g^(n-2) for n = 1 stands beside a factor of 0.
        two_below = g ** (n - 2) if n >= 2 else 0.0
        found.append(1.5 / (2.0 + g * g) * (g**n * (1.0 + level) + up * g ** (n + 2) + down * two_below))
    return found


def air_block(model: AirModel, atmosphere: _NightLit, sun_irradiance: ArrayLike = (1.0, 1.0, 1.0)) -> AirBlock:
    """The block of this air. sun_irradiance: (3,), W m^-2 nm^-1: the night light is a share of it."""
    night = float(atmosphere.night_light) * AIRGLOW_PER_SR * np.asarray(sun_irradiance, dtype=np.float64)
    return AirBlock(
        radius_m=model.radius_m,
        top_radius_m=model.top_radius_m,
        thickness_m=model.thickness_m,
        per_thickness=1.0 / model.thickness_m,
        rayleigh_per_m=tuple(model.rayleigh_scattering),
        rayleigh_height_m=model.rayleigh_height_m,
        mie_scattering_per_m=tuple(model.mie_scattering),
        mie_height_m=model.mie_height_m,
        mie_extinction_per_m=tuple(model.mie_extinction),
        mie_asymmetry=model.asymmetry,
        absorption_per_m=tuple(model.absorption),
        absorber_height_m=model.absorption_center_m,
        ground_albedo=tuple(model.ground_albedo),
        absorber_slope_per_m=1.0 / model.absorption_half_width_m,
        night_radiance=tuple(night),
        longest_path_m=model.longest_path_m,
        mie_moments=tuple(cornette_shanks_moments(model.asymmetry)),
        sun_radius_rad=model.sun_angular_radius_rad,
    )
