"""Light as spectra: sunlight, ozone, air at many wavelengths, and the colour that an eye sees, adapted to sunlight.

Spectra are (..., W) at WAVELENGTHS_NM, as shares of sunlight outside the air unless a name says otherwise: 1 everywhere
is white. Nothing here is the library's.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from .air_medium import AirParameters, Floats

WAVELENGTHS_NM: Floats = np.arange(390.0, 731.0, 10.0)
USUAL_NM = (680.0, 550.0, 440.0)
"""Which wavelengths the three numbers of `AirParameters` belong to."""

SOLAR_IRRADIANCE: Floats = np.array([
    1.14716, 1.72765, 1.73054, 1.6887, 1.61253, 1.91198, 2.03474, 2.02042, 2.02212, 1.93377, 1.95809, 1.91686,
    1.8298, 1.8685, 1.8931, 1.85149, 1.8504, 1.8341, 1.8345, 1.8147, 1.78158, 1.7533, 1.6965, 1.68194, 1.64654,
    1.6048, 1.52143, 1.55622, 1.5113, 1.474, 1.4482, 1.41018, 1.36775, 1.34188, 1.31429,
])  # fmt: skip
"""W m^-2 nm^-1 outside the air (ASTM G173, means of 10 nm, as in Bruneton 2017)."""

OZONE_CROSS_SECTION_M2: Floats = np.array([
    6.636e-28, 1.527e-27, 2.763e-27, 5.52e-27, 8.451e-27, 1.582e-26, 2.316e-26, 3.669e-26, 4.924e-26, 7.752e-26,
    9.016e-26, 1.48e-25, 1.602e-25, 2.139e-25, 2.755e-25, 3.091e-25, 3.5e-25, 4.266e-25, 4.672e-25, 4.398e-25,
    4.701e-25, 5.019e-25, 4.305e-25, 3.74e-25, 3.215e-25, 2.662e-25, 2.238e-25, 1.852e-25, 1.473e-25, 1.209e-25,
    9.423e-26, 7.455e-26, 6.566e-26, 5.105e-26, 4.15e-26,
])  # fmt: skip
"""Of a molecule at 233 K (Serdyuchenko et al. 2014, means of 10 nm, as in Bruneton 2017)."""

PURE_WATER_PER_M: Floats = np.array([
    0.00851, 0.00663, 0.00473, 0.00454, 0.00495, 0.00635, 0.00922, 0.00979, 0.0106, 0.0127, 0.0150, 0.0204,
    0.0325, 0.0409, 0.0434, 0.0474, 0.0565, 0.0619, 0.0695, 0.0896, 0.1351, 0.2224, 0.2644, 0.2755, 0.2916,
    0.3108, 0.34, 0.41, 0.439, 0.465, 0.516, 0.624, 0.827, 1.231, 1.799,
])  # fmt: skip
"""Absorption (Pope and Fry 1997; from 710 nm on Smith and Baker 1981)."""

_XYZ_TO_SRGB = np.linalg.inv(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
_D65 = np.array([0.95047, 1.0, 1.08883])
_BRADFORD = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])


def observer(wavelength_nm: ArrayLike) -> Floats:
    """(3, W) the CIE 1931 observer x, y, z, by the fits of Wyman, Sloan and Shirley 2013 (multi-lobe)."""
    nm = np.asarray(wavelength_nm, dtype=np.float64)

    def lobe(middle: float, left: float, right: float) -> Floats:
        return np.exp(-0.5 * ((nm - middle) * np.where(nm < middle, left, right)) ** 2)

    x = 1.056 * lobe(599.8, 0.0264, 0.0323) + 0.362 * lobe(442.0, 0.0624, 0.0374) - 0.065 * lobe(501.1, 0.049, 0.0382)
    y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322)
    z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725)
    return np.stack([x, y, z])


def _seen() -> Floats:
    """(3, W) what turns shares of sunlight into linear sRGB: CIE XYZ, adapted from sunlight to D65 by Bradford."""
    xyz = observer(WAVELENGTHS_NM) * SOLAR_IRRADIANCE
    white = xyz.sum(axis=1)
    gains = (_BRADFORD @ _D65) / (_BRADFORD @ (white / white[1]))
    adapted = np.linalg.inv(_BRADFORD) @ (gains[:, None] * (_BRADFORD @ (xyz / white[1])))
    return _XYZ_TO_SRGB @ adapted


SEEN: Floats = _seen()


def seen_colour(spectrum: ArrayLike) -> Floats:
    """Linear sRGB (..., 3) of spectra (..., W), for an eye to which sunlight is white; may leave the gamut."""
    return np.asarray(spectrum, dtype=np.float64) @ SEEN.T


def at_wavelengths(spectrum: ArrayLike, wavelengths_nm: ArrayLike = USUAL_NM) -> Floats:
    """Values (..., K) of spectra (..., W) at some of WAVELENGTHS_NM."""
    places = np.searchsorted(WAVELENGTHS_NM, np.asarray(wavelengths_nm, dtype=np.float64))
    return np.asarray(spectrum, dtype=np.float64)[..., places]


def spectral_air(air: AirParameters) -> AirParameters:
    """The same air, known at USUAL_NM, at all WAVELENGTHS_NM.

    Gas and haze by power laws between the three (Angstrom's; beyond them the nearer one goes on), the absorber by the
    cross-sections of ozone, as much of it as its value at 550 nm says; the ground of the air is grey.
    """

    def power_law(values: tuple[float, ...]) -> tuple[float, ...]:
        known, logs = np.log(USUAL_NM), np.log(values)
        wanted = np.log(WAVELENGTHS_NM)
        exponents = np.diff(logs) / np.diff(known)
        slopes = np.where(wanted > known[1], exponents[0], exponents[1])
        return tuple(np.exp(logs[1] + slopes * (wanted - known[1])).tolist())

    ozone = OZONE_CROSS_SECTION_M2 * (air.absorption_per_m[1] / at_wavelengths(OZONE_CROSS_SECTION_M2)[1])
    return replace(
        air,
        rayleigh_scattering_per_m=power_law(air.rayleigh_scattering_per_m),
        mie_scattering_per_m=power_law(air.mie_scattering_per_m),
        mie_extinction_per_m=power_law(air.mie_extinction_per_m),
        absorption_per_m=tuple(ozone.tolist()),
        ground_albedo=(air.ground_albedo[1],) * len(WAVELENGTHS_NM),
    )


def lab(linear: ArrayLike) -> Floats:
    """CIE L*a*b* (..., 3) under D65 of linear sRGB (..., 3)."""
    t = np.asarray(linear, dtype=np.float64) @ np.linalg.inv(_XYZ_TO_SRGB).T / _D65
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t * (29 / 6) ** 2 / 3 + 4 / 29)
    x, y, z = f[..., 0], f[..., 1], f[..., 2]
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def delta_e_2000(one: ArrayLike, other: ArrayLike) -> Floats:
    """CIEDE2000 (...) between colours (..., 3) in L*a*b* (Sharma, Wu and Dalal 2005)."""
    l1, a1, b1 = np.moveaxis(np.asarray(one, dtype=np.float64), -1, 0)
    l2, a2, b2 = np.moveaxis(np.asarray(other, dtype=np.float64), -1, 0)
    mean_c = 0.5 * (np.hypot(a1, b1) + np.hypot(a2, b2))
    g = 0.5 * (1 - np.sqrt(mean_c**7 / (mean_c**7 + 25.0**7)))
    a1, a2 = a1 * (1 + g), a2 * (1 + g)
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360
    grey = c1 * c2 == 0
    turn = np.where(grey, 0.0, (h2 - h1 + 180) % 360 - 180)
    hue = np.where(grey, h1 + h2, h1 + 0.5 * turn)
    d_l, d_c, d_h = l2 - l1, c2 - c1, 2 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2))
    l, c = 0.5 * (l1 + l2) - 50, 0.5 * (c1 + c2)
    t = (
        1 - 0.17 * np.cos(np.radians(hue - 30)) + 0.24 * np.cos(np.radians(2 * hue))
        + 0.32 * np.cos(np.radians(3 * hue + 6)) - 0.20 * np.cos(np.radians(4 * hue - 63))
    )  # fmt: skip
    s_l, s_c, s_h = 1 + 0.015 * l**2 / np.sqrt(20 + l**2), 1 + 0.045 * c, 1 + 0.015 * c * t
    turned = 60 * np.exp(-((((hue % 360) - 275) / 25) ** 2))
    r = -2 * np.sqrt(c**7 / (c**7 + 25.0**7)) * np.sin(np.radians(turned))
    return np.sqrt((d_l / s_l) ** 2 + (d_c / s_c) ** 2 + (d_h / s_h) ** 2 + r * (d_c / s_c) * (d_h / s_h))
