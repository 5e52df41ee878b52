"""A plausible night sky without a catalogue: places, magnitudes and colours of stars, float64 numpy, no GL.

Counts. The number of stars brighter than V magnitude m over the whole sky follows log10 N = 3.94 + 0.5 (m - 6.5), that
is 8768 to magnitude 6.5. From Sky Catalogue 2000 and Tycho counts per magnitude: 22 to 1.5, 93 to 2.5, 283 to 3.5, 893
to 4.5, 2822 to 5.5, 8768 to 6.5; the law is within 27 % of all of them and within 2 % of the last four. The star of
rank k gets the magnitude at which the law reaches k: every sky has these counts, and a brightest star of -1.4 (Sirius
-1.46).

Places. Uniform in (z, longitude), which is uniform in area, thinned away from the galactic plane: counts of bright
stars fall by about 3 from plane to pole. All from integer hashes of (seed, rank, try), so that a sky depends on its
seed only, and a larger sky contains the smaller one.

Colours. Planck spectra at the three wavelengths; temperatures drawn by the shares of the spectral classes among the
stars of the Yale Bright Star Catalogue (B 19 %, A 22 %, F 14 %, G 14 %, K 26 %, M 5 %, rounded).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.wavelengths import GIVEN_NM, Nanometres

__all__ = [
    "GALACTIC_AXES",
    "STARS_TO_6_5",
    "VEGA_IRRADIANCE",
    "StarField",
    "count_to",
    "make_stars",
    "planck_ratio",
    "star_irradiance",
]

Array = NDArray[np.float64]

VEGA_IRRADIANCE = 3.63e-11
"""W m^-2 nm^-1 at 550 nm of a star of V = 0 (Bessell, Castelli and Plez 1998: 3.63e-9 erg cm^-2 s^-1 A^-1)."""
STARS_TO_6_5 = 8768.0
_CLASSES = (  # share, temperature range in K
    (0.19, 11000.0, 25000.0),  # B
    (0.22, 7500.0, 11000.0),  # A
    (0.14, 6000.0, 7500.0),  # F
    (0.14, 5300.0, 6000.0),  # G
    (0.26, 3900.0, 5300.0),  # K
    (0.05, 3000.0, 3900.0),  # M
)


def _galactic_axes() -> Array:
    # North galactic pole and longitude of the celestial pole, J2000 (Hipparcos and Tycho catalogues, vol. 1, 1.5.3).
    ascension, declination, pole_longitude = np.radians([192.85948, 27.12825, 122.93192])

    def turn(angle: float) -> Array:
        return np.array([[np.cos(angle), np.sin(angle), 0.0], [-np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])

    tip = np.pi / 2 - declination
    lean = np.array([[1.0, 0.0, 0.0], [0.0, np.cos(tip), np.sin(tip)], [0.0, -np.sin(tip), np.cos(tip)]])
    return turn(np.pi / 2 - pole_longitude) @ lean @ turn(ascension + np.pi / 2)


GALACTIC_AXES: Array = _galactic_axes()
"""(3, 3): galactic = GALACTIC_AXES @ inertial (equatorial). Galactic x: centre of the Milky Way, z: its north pole."""


@dataclass(frozen=True, eq=False)
class StarField:
    """directions: (N, 3) unit, inertial frame. magnitudes: (N,), V, ascending. irradiance: (N, 3) W m^-2 nm^-1."""

    directions: Array
    magnitudes: Array
    irradiance: Array


def count_to(magnitude: float) -> float:
    """Stars brighter than a V magnitude over the whole sky."""
    return float(STARS_TO_6_5 * 10.0 ** (0.5 * (magnitude - 6.5)))


def planck_ratio(temperature_k: Array, wavelength_nm: float) -> Array:
    """Planck radiance per wavelength, relative to that at 550 nm."""
    c2 = 1.438777e7  # nm K

    def planck(nm: float) -> Array:
        return 1.0 / (nm**5 * np.expm1(c2 / (nm * np.asarray(temperature_k, dtype=np.float64))))

    return planck(wavelength_nm) / planck(550.0)


def star_irradiance(magnitude: Array, temperature_k: Array, nm: Nanometres = GIVEN_NM) -> Array:
    """(N, 3) W m^-2 nm^-1 at the wavelengths `nm` of stars of a V magnitude and a colour temperature."""
    green = VEGA_IRRADIANCE * 10.0 ** (-0.4 * np.asarray(magnitude, dtype=np.float64))
    return np.stack([green * planck_ratio(temperature_k, wavelength) for wavelength in nm], axis=-1)


def _uniform(seed: int, rank: NDArray[np.uint64], salt: int) -> Array:
    """Uniform in [0, 1) from integers alone (the finalizer of SplitMix64, Steele et al. 2014)."""
    with np.errstate(over="ignore"):
        start = np.uint64((seed * 0xD1342543DE82EF95 + salt * 0x2545F4914F6CDD1D) % 2**64)
        x = rank * np.uint64(0x9E3779B97F4A7C15) + start
        x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
        x ^= x >> np.uint64(31)
    return (x >> np.uint64(11)).astype(np.float64) * 2.0**-53


def _spread(galactic_z: Array) -> Array:
    """Density of stars against the sine of the galactic latitude, 1 in the plane."""
    return 0.3 + 0.7 * np.exp(-np.abs(galactic_z) / 0.25)


def make_stars(count: int, seed: int = 1, nm: Nanometres = GIVEN_NM) -> StarField:
    """The `count` brightest stars of the sky of this seed, their light at the wavelengths `nm`. About 2 ms per
    10 000."""
    rank = np.arange(1, count + 1, dtype=np.uint64)
    magnitudes = 6.5 + 2.0 * np.log10(rank.astype(np.float64) / STARS_TO_6_5)
    directions = np.zeros((count, 3))
    todo = np.arange(count)
    for attempt in range(16):
        if not len(todo):
            break
        ranks = rank[todo]
        z = 2.0 * _uniform(seed, ranks, 8 * attempt + 1) - 1.0
        longitude = 2.0 * np.pi * _uniform(seed, ranks, 8 * attempt + 2)
        flat = np.sqrt(np.maximum(1.0 - z * z, 0.0))
        directions[todo] = np.stack([flat * np.cos(longitude), flat * np.sin(longitude), z], axis=-1)
        keep = _uniform(seed, ranks, 8 * attempt + 3) < _spread(directions[todo] @ GALACTIC_AXES[2])
        todo = todo[~keep]
    temperatures = _temperatures(_uniform(seed, rank, 4), _uniform(seed, rank, 5))
    return StarField(directions, magnitudes, star_irradiance(magnitudes, temperatures, nm))


def _temperatures(choice: Array, within: Array) -> Array:
    edges = np.cumsum([share for share, _, _ in _CLASSES])
    index = np.minimum(np.searchsorted(edges, choice * edges[-1], side="right"), len(_CLASSES) - 1)
    low = np.array([c[1] for c in _CLASSES])[index]
    high = np.array([c[2] for c in _CLASSES])[index]
    return low * (high / low) ** within
