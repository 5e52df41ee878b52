"""Clear air as the reference sees it: parameters, densities and phase functions. Nothing here is the library's.

Three kinds of matter share a shell between the sphere of `radius_m` and `thickness_m` above it, where all densities
are cut: molecules (Rayleigh) and dust (Mie) thin out as exp(-h / H); an absorber that does not scatter (ozone) has a
density that rises and falls linearly around a height, a tent. Below the sphere densities are held at the sphere's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
PerWavelength = tuple[float, ...]


@dataclass(frozen=True)
class AirParameters:
    """One planet's clear air. Tuples are per wavelength; the reference never asks how many nor which ones they are."""

    radius_m: float
    thickness_m: float
    rayleigh_scattering_per_m: PerWavelength
    rayleigh_scale_height_m: float
    mie_scattering_per_m: PerWavelength
    mie_extinction_per_m: PerWavelength
    mie_scale_height_m: float
    mie_asymmetry: float
    absorption_per_m: PerWavelength
    absorption_center_m: float
    absorption_half_width_m: float
    ground_albedo: PerWavelength
    sun_angular_radius_rad: float

    @property
    def wavelengths(self) -> int:
        """How many: where shapes of answers say 3 wavelengths, the usual number is meant."""
        return len(self.rayleigh_scattering_per_m)

    @property
    def extinction_per_m(self) -> Floats:
        """(3 kinds, W wavelengths) extinction at density 1: Rayleigh, Mie, absorber."""
        return np.array([self.rayleigh_scattering_per_m, self.mie_extinction_per_m, self.absorption_per_m], dtype=float)

    @property
    def scattering_per_m(self) -> Floats:
        """(2 kinds, W wavelengths) scattering at density 1: Rayleigh, Mie."""
        return np.array([self.rayleigh_scattering_per_m, self.mie_scattering_per_m], dtype=float)

    @property
    def kink_heights_m(self) -> Floats:
        """Heights inside the shell at which a density is not smooth: the floor and the tent's three corners."""
        center, half = self.absorption_center_m, self.absorption_half_width_m
        kinks = np.array([0.0, center - half, center, center + half])
        return np.unique(kinks[(kinks >= 0.0) & (kinks < self.thickness_m)])

    @property
    def break_heights_m(self) -> Floats:
        """Heights between which Gauss-Legendre rules stay exact: kinks, and a few scale heights each, growing upwards.

        A panel may span more scale heights where the density is already small against the column below it.
        """
        steps = np.array([4.0, 8.0, 12.0, 16.0, 24.0, 40.0])
        scales = [self.rayleigh_scale_height_m * steps, self.mie_scale_height_m * steps]
        breaks = np.concatenate([self.kink_heights_m, *scales])
        return np.unique(breaks[breaks < self.thickness_m])

    def level(self, height_m: ArrayLike) -> Floats:
        """h (2 R + h): the square of the distance from the centre less R squared, without cancellation (m^2)."""
        h = np.asarray(height_m, dtype=float)
        return h * (2.0 * self.radius_m + h)

    def height(self, level_m2: Floats) -> Floats:
        """The inverse of `level` (metres)."""
        r = self.radius_m
        return level_m2 / (r + np.sqrt(np.maximum(r * r + level_m2, 0.0)))


def densities(air: AirParameters, height_m: Floats) -> Floats:
    """Relative densities (..., 3) of molecules, dust and absorber at heights (...), without the cut at the top."""
    h = np.maximum(height_m, 0.0)
    rayleigh = np.exp(-h / air.rayleigh_scale_height_m)
    mie = np.exp(-h / air.mie_scale_height_m)
    return np.stack([rayleigh, mie, absorber_density(air, h)], axis=-1)


def absorber_density(air: AirParameters, height_m: Floats) -> Floats:
    """The tent: 1 at its centre, 0 half a width away from it."""
    if air.absorption_half_width_m <= 0.0:
        return np.zeros_like(height_m)
    return np.maximum(1.0 - np.abs(height_m - air.absorption_center_m) / air.absorption_half_width_m, 0.0)


def rayleigh_phase(cosine: ArrayLike) -> Floats:
    """3 / (16 pi) (1 + c^2), per steradian."""
    c = np.asarray(cosine, dtype=float)
    return 3.0 / (16.0 * np.pi) * (1.0 + c * c)


def mie_phase(cosine: ArrayLike, asymmetry: float) -> Floats:
    """Cornette and Shanks 1992: 3 / (8 pi) (1 - g^2) (1 + c^2) / ((2 + g^2) (1 + g^2 - 2 g c)^1.5), per steradian."""
    c, g = np.asarray(cosine, dtype=float), asymmetry
    return 3.0 / (8.0 * np.pi) * (1.0 - g * g) * (1.0 + c * c) / ((2.0 + g * g) * (1.0 + g * g - 2.0 * g * c) ** 1.5)


EARTH_BRUNETON = AirParameters(
    radius_m=6_360_000.0,
    thickness_m=60_000.0,
    rayleigh_scattering_per_m=(5.802339381712381e-6, 1.355776244792022e-5, 3.3100005976367735e-5),
    rayleigh_scale_height_m=8000.0,
    mie_scattering_per_m=(3.996e-6, 3.996e-6, 3.996e-6),
    mie_extinction_per_m=(4.44e-6, 4.44e-6, 4.44e-6),
    mie_scale_height_m=1200.0,
    mie_asymmetry=0.8,
    absorption_per_m=(6.497166e-7, 1.8809e-6, 8.501668e-8),
    absorption_center_m=25_000.0,
    absorption_half_width_m=15_000.0,
    ground_albedo=(0.1, 0.1, 0.1),
    sun_angular_radius_rad=0.00935 / 2.0,
)
"""The air of Bruneton's demo of 2017 (680, 550 and 440 nm), a usual yardstick."""


def _times(values: PerWavelength, factor: float) -> PerWavelength:
    return tuple(value * factor for value in values)


def scaled(air: AirParameters, radius_m: float, thickness_m: float) -> AirParameters:
    """The same air squeezed into another shell: heights in proportion, vertical optical depths unchanged."""
    squeeze = thickness_m / air.thickness_m
    return AirParameters(
        radius_m=radius_m,
        thickness_m=thickness_m,
        rayleigh_scattering_per_m=_times(air.rayleigh_scattering_per_m, 1.0 / squeeze),
        rayleigh_scale_height_m=air.rayleigh_scale_height_m * squeeze,
        mie_scattering_per_m=_times(air.mie_scattering_per_m, 1.0 / squeeze),
        mie_extinction_per_m=_times(air.mie_extinction_per_m, 1.0 / squeeze),
        mie_scale_height_m=air.mie_scale_height_m * squeeze,
        mie_asymmetry=air.mie_asymmetry,
        absorption_per_m=_times(air.absorption_per_m, 1.0 / squeeze),
        absorption_center_m=air.absorption_center_m * squeeze,
        absorption_half_width_m=air.absorption_half_width_m * squeeze,
        ground_albedo=air.ground_albedo,
        sun_angular_radius_rad=air.sun_angular_radius_rad,
    )


SMALL_PLANET = scaled(EARTH_BRUNETON, radius_m=60_000.0, thickness_m=2_000.0)
"""A planet of 60 km radius under 2 km of air as dense, seen straight up, as Earth's."""
