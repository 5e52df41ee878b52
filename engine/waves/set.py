"""WaveSet: the waves of a sea, and how one is made from what a scene says: explicit waves, or a wind and a swell.

A wave starts at its origin, a point of the planet, and runs over the whole sphere as rings around it, to the antipode;
a quarter turn away its crests are straight. docs/ocean.md has the formulas and their sources.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..settings import SettingError
from ..space import direction, local_axes
from .spectrum import STILL_M_S, slope_variance, swell_waves, wind_waves

__all__ = ["MOST_WAVES", "SeaState", "WaveError", "WaveSet", "make_waves", "waves_of"]

Floats = NDArray[np.float64]

MOST_WAVES = 1000
STEEPEST = 1.0
"""Limit of the sum of Q A k: a point of the surface then never moves past its neighbour."""
_HIGHEST_SHARE = 0.1
_STEEP = 0.95
"""The sum of Q A k of a spectrum: a little less, so that folds stay away where waves fade or the bed rises as well."""
_ROUNDING = 1e-9
"""By which a sum of numbers typed to sixteen digits may be above the limit."""

_FADE_EXPLICIT = (1.0, 8.0)
"""Wavelengths from its origin at which a wave somebody placed begins and ends to appear: "several wave fronts"."""
_FADE_SPECTRUM = (300.0, 2000.0)
"""The same of a wave of a spectrum, which has to look straight: over the 100 wavelengths that a view resolves, a crest
with a radius of 1000 wavelengths turns by 6 degrees, less than what waves differ in direction."""
_FADE_MOST_RAD = (0.05, 0.4)
"""On small planets the fade ends here, so that most of the planet has every wave."""

NO_ICE = 2.0
"""Sine of a latitude that there is not."""

_SPECTRUM_TILT = 0.25
"""Origins lie at a quarter turn from the place of the wind, give or take this share of it: their calm surroundings and
those of their antipodes then don't lie in one circle."""
_LONGEST_SHARE = 0.05
"""The longest wave of a spectrum is this share of the planet's radius at most."""


class WaveError(SettingError):
    """Waves that can't be. The message says which, what is expected and what was found."""


class SeaState(Protocol):
    """What `waves_of` reads; the component Ocean has it. Units are in the names, angles in degrees.

    waves: explicit ones, each with origin (latitude, longitude), amplitude_m, wavelength_m, steepness, speed_rad_s
    (None: that of deep water, running away from the origin); while there are any, wind and swell make none.
    """

    sea_level_m: float
    wind_speed_m_s: float
    wind_direction_deg: float
    wind_at: tuple[float, float]
    fetch_m: float
    wave_count: int
    wave_seed: int
    choppiness: float
    swell_height_m: float
    swell_period_s: float
    swell_direction_deg: float
    gravity_m_s2: float
    ice_latitude_deg: float
    waves: Any


@dataclass(frozen=True, eq=False)
class WaveSet:
    """N waves, longest first. All arrays are float64 and read-only.

    origins: (N, 3) unit. amplitude_m, wavelength_m, steepness (Q), speed_rad_s (phi): (N,). With phi > 0 crests run
    towards the origin, with phi < 0 away from it. radius_m: from the planet's centre to the calm sea. fade: (n0, n1),
    from how many wavelengths of its origin (and of the antipode) a wave begins and ends to appear.
    slope_variance_beyond: mean square slope, both directions together, of what is shorter than these waves.
    ice_sine: of the latitude from which on the sea is frozen and still.
    """

    origins: Floats
    amplitude_m: Floats
    wavelength_m: Floats
    steepness: Floats
    speed_rad_s: Floats
    radius_m: float
    fade: tuple[float, float] = _FADE_EXPLICIT
    slope_variance_beyond: float = 0.0
    ice_sine: float = NO_ICE

    def __len__(self) -> int:
        return len(self.wavelength_m)

    @cached_property
    def wave_number_per_m(self) -> Floats:
        """k = 2 pi / wavelength, rad/m (N,)."""
        return 2.0 * np.pi / self.wavelength_m

    @property
    def fade_most_rad(self) -> tuple[float, float]:
        """Angles from the origin at which a wave begins and ends to appear at the latest."""
        return _FADE_MOST_RAD

    @cached_property
    def fade_rad(self) -> Floats:
        """Angles from the origin, (N, 2), between which each wave appears."""
        reach = self.wavelength_m[:, None] * np.array(self.fade) / self.radius_m
        return np.minimum(reach, np.array(_FADE_MOST_RAD))

    @cached_property
    def fade_edges(self) -> Floats:
        """(N, 2): e0, e1 of smoothstep(e0, e1, |v -+ o|^2 / 2), which is 1 - cos of the angle: `fade_rad` as such."""
        return 2.0 * np.sin(0.5 * self.fade_rad) ** 2

    @cached_property
    def slope_variance(self) -> float:
        """Mean square slope of these waves, both directions together: the sum of (A k)^2 / 2."""
        return 0.5 * float(np.sum((self.amplitude_m * self.wave_number_per_m) ** 2))

    @cached_property
    def significant_height_m(self) -> float:
        """Four standard deviations of the surface's height."""
        return 4.0 * math.sqrt(0.5 * float(np.sum(self.amplitude_m**2)))

    @cached_property
    def highest_m(self) -> float:
        """No crest is higher above the calm sea, and no trough deeper: the sum of all amplitudes."""
        return float(np.sum(self.amplitude_m))

    @cached_property
    def farthest_m(self) -> float:
        """No point is moved sideways by more: the sum of Q A."""
        return float(np.sum(self.steepness * self.amplitude_m))


def make_waves(
    origins: ArrayLike,
    amplitude_m: ArrayLike,
    wavelength_m: ArrayLike,
    steepness: ArrayLike,
    speed_rad_s: ArrayLike,
    radius_m: float,
    *,
    fade: tuple[float, float] = _FADE_EXPLICIT,
    slope_variance_beyond: float = 0.0,
    ice_sine: float = NO_ICE,
) -> WaveSet:
    """A checked set, sorted. origins: (N, 3), any length but zero; the others (N,). Raises WaveError."""
    if not (math.isfinite(radius_m) and radius_m > 0.0):
        raise WaveError(f"waves: radius_m: expected a positive number, found {radius_m!r}")
    names = ("amplitude_m", "wavelength_m", "steepness", "speed_rad_s")
    columns = [np.array(v, dtype=np.float64).reshape(-1) for v in (amplitude_m, wavelength_m, steepness, speed_rad_s)]
    places = np.array(origins, dtype=np.float64).reshape(-1, 3)
    count = len(places)
    if count > MOST_WAVES:
        raise WaveError(f"waves: expected {MOST_WAVES} waves at most, found {count}")
    for name, column in zip(names, columns, strict=True):
        if len(column) != count:
            raise WaveError(f"waves: {name}: expected {count} numbers, one for each origin, found {len(column)}")
        low = {"wavelength_m": np.nextafter(0.0, 1.0), "speed_rad_s": -np.inf}.get(name, 0.0)
        bad = np.flatnonzero(~(np.isfinite(column) & (column >= low)))
        if bad.size:
            what = {"wavelength_m": "a positive number", "speed_rad_s": "a finite number"}.get(name, "0 or more")
            raise WaveError(f"waves[{bad[0]}].{name}: expected {what}, found {column[bad[0]]}")
    length = np.linalg.norm(places, axis=1)
    bad = np.flatnonzero(~(np.isfinite(length) & (length > 0.0)))
    if bad.size:
        raise WaveError(f"waves[{bad[0]}].origin: expected a direction, found {places[bad[0]].tolist()}")
    amplitude, wavelength, q, speed = columns
    too_long = np.flatnonzero(wavelength > radius_m)
    if too_long.size:
        raise WaveError(
            f"waves[{too_long[0]}].wavelength_m: expected at most the radius of the sea, {radius_m:.12g} m, "
            f"found {wavelength[too_long[0]]:.12g}"
        )
    if float(np.sum(amplitude)) > _HIGHEST_SHARE * radius_m:
        raise WaveError(
            f"waves: amplitude_m: expected {_HIGHEST_SHARE * radius_m:.6g} m at most of all waves together, a "
            f"{1.0 / _HIGHEST_SHARE:.0f}th of the sea's radius, found {float(np.sum(amplitude)):.6g}"
        )
    steep = float(np.sum(q * amplitude * (2.0 * np.pi / wavelength)))
    if steep > STEEPEST + _ROUNDING:
        raise WaveError(
            f"waves: the sum of steepness x amplitude_m x 2 pi / wavelength_m is {steep:.6g}; above {STEEPEST:g} the "
            f"surface intersects itself. Multiply all steepness by {STEEPEST / steep:.4g} or less"
        )
    order = np.argsort(-wavelength, kind="stable")
    arrays = [places / length[:, None], amplitude, wavelength, q, speed]
    made = [np.ascontiguousarray(a[order]) for a in arrays]
    for array in made:
        array.flags.writeable = False
    places, amplitude, wavelength, q, speed = made
    return WaveSet(
        places, amplitude, wavelength, q, speed, float(radius_m), fade, float(slope_variance_beyond), ice_sine
    )


def waves_of(sea: SeaState, planet_radius_m: float) -> WaveSet:
    """The waves of a sea: `sea.waves` if there are any, or those of its wind and swell. Raises WaveError.

    Equal states give equal waves. Neither wind nor swell is a smooth sea: a set without waves.
    """
    radius = planet_radius_m + sea.sea_level_m
    total = slope_variance(sea.wind_speed_m_s)
    ice_sine = math.sin(math.radians(sea.ice_latitude_deg)) if sea.ice_latitude_deg < 90.0 else NO_ICE
    if sea.waves:
        return _explicit(sea, radius, total, ice_sine)
    if not 1 <= sea.wave_count <= MOST_WAVES:
        raise WaveError(f"wave_count: expected a whole number from 1 to {MOST_WAVES}, found {sea.wave_count}")
    rng = np.random.default_rng(sea.wave_seed)
    longest = _LONGEST_SHARE * radius
    swell_count = 0
    if sea.swell_height_m > 0.0:
        # Of a wind sea one wave in five is swell: few, as they differ little. Without wind all are.
        calm = sea.wind_speed_m_s <= STILL_M_S
        swell_count = sea.wave_count if calm else min(round(0.2 * sea.wave_count), 40)
    wind_count = sea.wave_count - swell_count if sea.wind_speed_m_s > STILL_M_S else 0
    parts = [
        (sea.wind_direction_deg, wind_waves(
            wind_count, sea.wind_speed_m_s, sea.fetch_m, sea.gravity_m_s2, longest, rng
        )),
        (sea.swell_direction_deg, swell_waves(
            swell_count, sea.swell_height_m, sea.swell_period_s, sea.gravity_m_s2, longest, rng
        )),
    ]  # fmt: skip
    origins = np.concatenate([_origins(sea.wind_at, heading, part[2], rng) for heading, part in parts])
    amplitude = np.concatenate([part[0] for _, part in parts])
    wavelength = np.concatenate([part[1] for _, part in parts])
    k = 2.0 * np.pi / wavelength
    # Away from the origins, which lie upwind.
    speed = -np.sqrt(sea.gravity_m_s2 * k)
    steepness = _steepness(amplitude * k, k, sea.choppiness)
    beyond = max(total - 0.5 * float(np.sum((amplitude * k) ** 2)), 0.1 * total)
    return make_waves(
        origins,
        amplitude,
        wavelength,
        steepness,
        speed,
        radius,
        fade=_FADE_SPECTRUM,
        slope_variance_beyond=beyond,
        ice_sine=ice_sine,
    )


def _explicit(sea: SeaState, radius_m: float, total: float, ice_sine: float) -> WaveSet:
    waves: Sequence[Any] = tuple(sea.waves)
    wavelength = np.array([w.wavelength_m for w in waves], dtype=np.float64)
    amplitude = np.array([w.amplitude_m for w in waves], dtype=np.float64)
    deep = [-math.sqrt(sea.gravity_m_s2 * 2.0 * math.pi / w.wavelength_m) for w in waves]
    speed = [d if w.speed_rad_s is None else w.speed_rad_s for w, d in zip(waves, deep, strict=True)]
    there = 0.5 * float(np.sum((amplitude * 2.0 * np.pi / wavelength) ** 2))
    return make_waves(
        [direction(*w.origin) for w in waves],
        amplitude,
        wavelength,
        [w.steepness for w in waves],
        speed,
        radius_m,
        slope_variance_beyond=max(total - there, 0.1 * total),
        ice_sine=ice_sine,
    )


def _origins(at: tuple[float, float], heading_deg: float, angles_rad: Floats, rng: np.random.Generator) -> Floats:
    """Origins (N, 3) of waves that run at `at` along the heading plus angles (clockwise): about a quarter turn back."""
    place = direction(*at)
    distance = 0.5 * np.pi * (1.0 + _SPECTRUM_TILT * rng.uniform(-1.0, 1.0, len(angles_rad)))
    north, east = local_axes(place)
    heading = math.radians(heading_deg) + angles_rad[:, None]
    ahead = north * np.cos(heading) + east * np.sin(heading)
    return place * np.cos(distance)[:, None] - ahead * np.sin(distance)[:, None]


def _steepness(slopes: Floats, k: Floats, choppiness: float) -> Floats:
    """Q (N,): `choppiness`, as far as the sum of Q A k stays below the limit.

    Q = 1 moves points in circles, as water does. Where that is too much for all waves together, the short ones get
    less of it, Q = min(choppiness, c / k): their sideways movement is too small to be seen.
    """
    if not len(k) or choppiness <= 0.0:
        return np.zeros_like(k)
    if choppiness * float(np.sum(slopes)) <= _STEEP:
        return np.full_like(k, choppiness)
    low, high = 0.0, choppiness * float(np.max(k))
    for _ in range(60):
        middle = 0.5 * (low + high)
        if float(np.sum(slopes * np.minimum(choppiness, middle / k))) <= _STEEP:
            low = middle
        else:
            high = middle
    return np.minimum(choppiness, low / k)
