"""At which wavelengths light is carried, and what numbers that are given at others are there.

Components give numbers of three at GIVEN_NM. A display's red is seen around 610 nm, so a renderer carries light at
DISPLAY_NM, unless the quality knob "light.wavelengths" says "given". All numbers that are not colours go through here
on their way to shaders: air, water, sunlight. Only red moves.

Between red and green a number follows a power law, as scattering does (Angstrom's law). Ozone, sunlight and water have
bumps there, which is why sunsets and seas look as they do; they are known by measurement, and what is like them bends
as they do. docs/exposure.md says what that comes to.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = [
    "DISPLAY_NM",
    "GIVEN_NM",
    "SUNLIGHT",
    "Nanometres",
    "carried_air",
    "carried_sunlight",
    "carried_water",
    "wavelengths_of",
]

Floats = NDArray[np.float64]
Nanometres = tuple[float, float, float]
T = TypeVar("T")

GIVEN_NM: Nanometres = (680.0, 550.0, 440.0)
"""Those of components, probes and tables of truth, red first; of air, Atmosphere.wavelengths_nm."""
DISPLAY_NM: Nanometres = (610.0, 550.0, 440.0)

SUNLIGHT: Mapping[Nanometres, Nanometres] = {
    GIVEN_NM: (1.474, 1.8504, 1.91198),
    DISPLAY_NM: (1.6965, 1.8504, 1.91198),
}
"""W m^-2 nm^-1 outside the air at Earth (ASTM G173, means of 10 nm, as in Bruneton 2017)."""


class _Substance(NamedTuple):
    """What one takes away at 680, 550, 440 and about 610 nm, in any unit. near, far: numbers out of its proportions by
    up to the first factor are of it, from the second on of something else."""

    red: float
    green: float
    blue: float | None
    between: float
    near: float
    far: float

    def likeness(self, values: tuple[float, ...]) -> float:
        """0..1 for numbers at GIVEN_NM."""
        red, green, blue = values
        if min(red, green) <= 0.0 or (self.blue is not None and blue <= 0.0):
            return 0.0
        off = abs(math.log(red / green * self.green / self.red))
        if self.blue is not None:
            off = max(off, abs(math.log(blue / green * self.green / self.blue)))
        near, far = math.log(self.near), math.log(self.far)
        return min(max((far - off) / (far - near), 0.0), 1.0)

    def bend(self) -> float:
        """What there is at 610 nm over what a power law says."""
        return self.between / _power_law(self.red, self.green, _SHARE)


def wavelengths_of(settings: Mapping[str, object]) -> Nanometres:
    """Those that a renderer with these quality values carries light at; GIVEN_NM where they don't say."""
    return DISPLAY_NM if settings.get("light.wavelengths") == "display" else GIVEN_NM


def carried_sunlight(irradiance: ArrayLike, nm: Nanometres) -> Floats:
    """(3,) at `nm` of a sun's irradiance (3,) at GIVEN_NM: its proportion to ours follows a power law."""
    given = np.asarray(irradiance, dtype=np.float64)
    if nm == GIVEN_NM:
        return given
    ours = np.array(SUNLIGHT[GIVEN_NM])
    red, green, blue = (given / ours).tolist()
    return np.array([_power_law(red, green, _SHARE), green, blue]) * SUNLIGHT[nm]


def carried_air(air: T, nm: Nanometres) -> T:
    """An Atmosphere with its numbers at `nm`: a changed copy, or itself where it has nothing to change.

    Gas, haze's scattering, its absorption and the ground's albedo follow power laws, as ozone the absorber in ozone's
    proportions. Numbers of which 610 nm isn't between red and green, by wavelengths_nm, stay.
    """
    found: Any = air
    red_nm, green_nm = found.wavelengths_nm[:2]
    if nm == tuple(found.wavelengths_nm) or nm == GIVEN_NM or not green_nm < nm[0] < red_nm:
        return air
    share = math.log(nm[0] / green_nm) / math.log(red_nm / green_nm)
    known = OZONE if tuple(found.wavelengths_nm) == GIVEN_NM else None
    scattered, taken = found.mie_scattering_per_m, found.mie_extinction_per_m
    # Their difference by itself, so that haze never scatters more than it takes away.
    absorbed = tuple(max(t - s, 0.0) for t, s in zip(taken, scattered, strict=True))
    scattered = _moved(scattered, share)
    return dataclasses.replace(
        found,
        rayleigh_scattering_per_m=_moved(found.rayleigh_scattering_per_m, share),
        mie_scattering_per_m=scattered,
        mie_extinction_per_m=(scattered[0] + _moved(absorbed, share)[0], *taken[1:]),
        absorption_per_m=_moved(found.absorption_per_m, share, known),
        ground_albedo=_moved(found.ground_albedo, share),
        wavelengths_nm=(nm[0], *found.wavelengths_nm[1:]),
    )


def carried_water(ocean: T, nm: Nanometres) -> T:
    """An Ocean with its numbers at `nm`, likewise: a liquid that is green or blue as water is absorbs as water does."""
    found: Any = ocean
    if nm == GIVEN_NM:
        return ocean
    return dataclasses.replace(
        found,
        absorption_per_m=_moved(found.absorption_per_m, _SHARE, WATER),
        scattering_per_m=_moved(found.scattering_per_m, _SHARE),
        glow=_moved(found.glow, _SHARE),
    )


def _moved(values: tuple[float, ...], share: float, known: _Substance | None = None) -> tuple[float, float, float]:
    red, green, blue = values
    moved = _power_law(red, green, share)
    if known is not None:
        moved *= known.bend() ** known.likeness(values)
    return moved, green, blue


def _power_law(red: float, green: float, share: float) -> float:
    """Between two numbers, by the red one's share in logarithms; a straight line where one is 0, which no power law
    reaches."""
    if min(red, green) <= 0.0:
        return green + (red - green) * share
    return green * (red / green) ** share


_SHARE = math.log(DISPLAY_NM[0] / GIVEN_NM[1]) / math.log(GIVEN_NM[0] / GIVEN_NM[1])
"""Of 680 nm in what there is at 610 nm, 550 nm having the rest."""

OZONE = _Substance(1.209e-25, 3.5e-25, 1.582e-26, 4.305e-25, near=1.5, far=3.0)
"""m^2 of a molecule at 233 K (Serdyuchenko et al. 2014, means of 10 nm, as in Bruneton 2017). Grey is 2.9 out of its
proportions between red and green, and 22 between green and blue."""
WATER = _Substance(0.465, 0.0565, None, 0.18, near=2.0, far=6.0)
"""1/m, pure (Pope and Fry 1997). At 610 nm itself it is 0.264, beyond a steep step at 600 nm that cuts through what a
display's red sees; 0.18 is what that comes to in half a metre to 20 m of water. Its blue doesn't count: it is the first
that plankton and silt change. Grey is 8 times out of its proportions."""
