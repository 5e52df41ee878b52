"""Spectra of a wind sea and of swell, cut into waves.

JONSWAP: Hasselmann et al. 1973, "Measurements of wind-wave growth and swell decay during the Joint North Sea Wave
Project"; full development: Pierson and Moskowitz 1964; directions: Hasselmann, Dunckel and Ewing 1980; slopes: Cox and
Munk 1954.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

__all__ = ["STILL_M_S", "growth", "jonswap", "slope_variance", "spread", "swell_waves", "wind_waves"]

Floats = NDArray[np.float64]
Waves = tuple[Floats, Floats, Floats]

PEAKEDNESS = 3.3
"""gamma, the mean of JONSWAP's measurements."""
DEVELOPED = 0.855
"""Peak frequency times wind / g of a sea that has stopped growing: Pierson and Moskowitz' 0.877 for a wind at 19.5 m
height, which is 1.026 times that at 10 m."""
STILL_M_S = 0.5
"""Below this wind there is no wind sea: ripples need about 1 m/s to begin."""
_SAMPLES = 4096
_FREQUENCIES = 0.7
"""The lowest frequency, as a share of the peak's: below it JONSWAP has a thousandth of its energy."""
_SHORTEST_M = 0.1
"""Shorter waves are ripples, which surface tension rules; they count as slope variance."""


def growth(wind_speed_m_s: float, fetch_m: float, gravity_m_s2: float) -> tuple[float, float]:
    """(peak frequency rad/s, variance of the height m^2) of a wind sea, by JONSWAP's laws of growth with fetch.

    With x = g F / U^2: peak = 22 x^(-1/3) g / U, variance = 1.6e-7 x U^4 / g^2, up to the x at which the peak is that
    of a fully developed sea. At full development the significant height is 0.209 U^2 / g.
    """
    u, g = wind_speed_m_s, gravity_m_s2
    x = min(g * fetch_m / u**2, (22.0 / DEVELOPED) ** 3)
    return 22.0 * x ** (-1.0 / 3.0) * g / u, 1.6e-7 * x * u**4 / g**2


def jonswap(frequency_rad_s: Floats, peak_rad_s: float) -> Floats:
    """Shape of the spectrum over angular frequency: w^-5 exp(-5/4 (p/w)^4) gamma^r; only proportions matter."""
    ratio = frequency_rad_s / peak_rad_s
    width = np.where(ratio <= 1.0, 0.07, 0.09)
    bump = np.exp(-((ratio - 1.0) ** 2) / (2.0 * width**2))
    return ratio**-5.0 * np.exp(-1.25 * ratio**-4.0) * PEAKEDNESS**bump


def slope_variance(wind_speed_m_s: float) -> float:
    """Mean square slope of the sea, both directions together: 0.003 + 0.00512 U (Cox and Munk 1954, clean surface)."""
    return 0.003 + 0.00512 * wind_speed_m_s


def spread(share: Floats, power: Floats) -> Floats:
    """Angles (N,) from the mean direction below which `share` (N,), 0..1, of the energy runs: cos^(2 s)(angle / 2).

    power: s (N,). Waves against the wind, beyond 120 degrees, are left out: a hundredth of the energy, or short.
    """
    angles = np.linspace(-2.0 * np.pi / 3.0, 2.0 * np.pi / 3.0, 721)
    density = np.cos(0.5 * angles) ** (2.0 * power[:, None])
    total = np.cumsum(0.5 * (density[:, 1:] + density[:, :-1]), axis=1)
    below = np.concatenate([np.zeros((len(power), 1)), total / total[:, -1:]], axis=1)
    return np.array([np.interp(u, row, angles) for u, row in zip(share, below, strict=True)])


def wind_waves(
    count: int, wind_speed_m_s: float, fetch_m: float, gravity_m_s2: float, longest_m: float, rng: np.random.Generator
) -> Waves:
    """Amplitudes m, wavelengths m and angles rad from the wind (count,) of a wind sea.

    The band from 0.7 of the peak frequency to about count / 2 times shorter wavelengths is cut into pieces that hold
    equal shares of (energy / all energy + slope variance / all slope variance): long waves get as many as short ones.
    """
    if count == 0:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    g = gravity_m_s2
    peak, variance = growth(wind_speed_m_s, fetch_m, g)
    # On a small planet waves can't grow longer than longest_m; those that would be are the highest, and missing.
    lowest = max(_FREQUENCIES * peak, math.sqrt(2.0 * math.pi * g / longest_m))
    whole = np.linspace(_FREQUENCIES * peak, 40.0 * peak, 8 * _SAMPLES)
    density = variance / np.trapezoid(jonswap(whole, peak), whole)
    octaves = 1.0 + math.log2(count)
    shortest_m = max(2.0 * math.pi * g / peak**2 * 2.0**-octaves, _SHORTEST_M)
    highest = max(math.sqrt(2.0 * math.pi * g / shortest_m), 1.5 * lowest)
    w = np.geomspace(lowest, highest, _SAMPLES)
    energy = _running(density * jonswap(w, peak), w)
    slopes = _running(density * jonswap(w, peak) * (w**2 / g) ** 2, w)
    shares = 0.5 * (energy / energy[-1] + slopes / slopes[-1])
    edges = np.interp(np.linspace(0.0, 1.0, count + 1), shares, w)
    inside = (np.arange(count) + rng.uniform(0.2, 0.8, count)) / count
    frequency = np.interp(inside, shares, w)
    amplitude = np.sqrt(2.0 * np.diff(np.interp(edges, w, energy)))
    power = _spreading_power(frequency, peak, wind_speed_m_s, g)
    return amplitude, 2.0 * np.pi * g / frequency**2, spread(_shuffled(count, rng), power)


def swell_waves(
    count: int, height_m: float, period_s: float, gravity_m_s2: float, longest_m: float, rng: np.random.Generator
) -> Waves:
    """Amplitudes m, wavelengths m and angles rad (count,) of swell: nearly one period, nearly one direction.

    height_m: significant height. Periods vary by 8 % (standard deviation), directions by 6 degrees, as after a long way
    from a storm (a narrow Gaussian spectrum).
    """
    if count == 0:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    place = (np.arange(count) + rng.uniform(0.3, 0.7, count)) / count
    # The logistic curve's quantiles are the Gaussian's within 1 % of its width where waves lie.
    bell = np.log(place / (1.0 - place)) / 1.702
    period = period_s * np.clip(1.0 + 0.08 * bell, 0.75, 1.25)
    wavelength = np.minimum(gravity_m_s2 * period**2 / (2.0 * np.pi), longest_m)
    amplitude = np.full(count, height_m / 4.0 * math.sqrt(2.0 / count))
    turn = _shuffled(count, rng)
    turn = np.clip(turn, 0.02, 0.98)
    return amplitude, wavelength, math.radians(6.0) * np.log(turn / (1.0 - turn)) / 1.702


def _running(values: Floats, at: Floats) -> Floats:
    """The integral (trapezoids) from the first place to each."""
    return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(at))])


def _spreading_power(frequency: Floats, peak: float, wind_speed_m_s: float, gravity_m_s2: float) -> Floats:
    """s of cos^(2 s)(angle / 2), by Hasselmann et al. 1980 for JONSWAP: 10 at the peak, less for all other waves.

    6.97 w^4.06 below 1.05 peaks, 9.77 w^-(2.33 + 1.45 (U p / g - 1.17)) above, w in peaks; at least 1, which spreads by
    65 degrees: shorter waves than were measured.
    """
    ratio = frequency / peak
    fall = -2.33 - 1.45 * (wind_speed_m_s * peak / gravity_m_s2 - 1.17)
    return np.maximum(np.where(ratio < 1.05, 6.97 * ratio**4.06, 9.77 * ratio**fall), 1.0)


def _shuffled(count: int, rng: np.random.Generator) -> Floats:
    """Even shares of 0..1 in an order in which neighbours are far apart (steps of the golden ratio), jittered."""
    steps = (np.arange(count) * 0.6180339887498949 + rng.uniform()) % 1.0
    rank = np.argsort(np.argsort(steps))
    return (rank + rng.uniform(0.25, 0.75, count)) / max(count, 1)
