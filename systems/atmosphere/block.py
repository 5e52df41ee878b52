"""The air's uniform block (binding 5): what every shader that lights or looks through air reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from ...engine.gpu.layout import Vec4
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
    """One planet's air. GLSL: ``#include "generated/air_model.glsl"``, instance ``air_model``. rgb: three wavelengths.

    The defaults are no air: nothing scatters, nothing is taken away.
    """

    radii: Vec4 = (6.36e6, 6.42e6, 6.0e4, 1.0 / 6.0e4)
    """(ground's radius, top's radius, thickness, 1 / thickness), metres"""
    rayleigh: Vec4 = (0.0, 0.0, 0.0, 8000.0)
    """rgb: scattering of gas per metre at the floor; w: its scale height in metres"""
    mie_scattering: Vec4 = (0.0, 0.0, 0.0, 1200.0)
    """rgb: scattering of haze per metre at the floor; w: its scale height in metres"""
    mie_extinction: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """rgb: extinction of haze per metre at the floor; w: asymmetry g"""
    absorption: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """rgb: absorption per metre at the layer's centre; w: unused"""
    absorber: Vec4 = (25.0e3, 15.0e3, 1.0 / 15.0e3, 0.0)
    """(height of the layer's centre, half width, 1 / half width, unused), metres"""
    ground: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """rgb: albedo of the ground; w: unused"""
    sun: Vec4 = (8.8e5, 0.0, 0.0, 0.004675)
    """x: longest way from the floor to the top, along the horizon; w: the sun's angular radius in radians"""
    mie_moments: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """Legendre moments 1 to 4 of the haze's phase function"""
    night: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """rgb: radiance of the night sky's own light overhead, W m^-2 sr^-1 nm^-1; w: unused"""


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
    half_width = model.absorption_half_width_m
    return AirBlock(
        radii=(model.radius_m, model.top_radius_m, model.thickness_m, 1.0 / model.thickness_m),
        rayleigh=(*model.rayleigh_scattering, model.rayleigh_height_m),
        mie_scattering=(*model.mie_scattering, model.mie_height_m),
        mie_extinction=(*model.mie_extinction, model.asymmetry),
        absorption=(*model.absorption, 0.0),
        absorber=(model.absorption_center_m, half_width, 1.0 / half_width, 0.0),
        ground=(*model.ground_albedo, 0.0),
        sun=(model.longest_path_m, 0.0, 0.0, model.sun_angular_radius_rad),
        mie_moments=tuple(cornette_shanks_moments(model.asymmetry)),
        night=(*night, 0.0),
    )
