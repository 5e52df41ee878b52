"""Spherical Gerstner waves in extended precision, straight from their definition: the truth for sampled heights.

No code of the library's: a wave at the angle x from its origin moves a point of the calm sea up by A sin(k r x + phi t)
and away from the origin by Q A cos of it. Deep water, beyond the fade around origins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["displaced"]

Floats = NDArray[np.float64]
LONG = np.longdouble


def displaced(
    calm: Floats,
    origins: Floats,
    amplitude_m: Floats,
    wavelength_m: Floats,
    steepness: Floats,
    speed_rad_s: Floats,
    radius_m: float,
    time_s: float,
) -> NDArray[np.longdouble]:
    """Positions (M, 3) from the planet's centre, metres, of points of the calm sea in unit directions (M, 3)."""
    v = np.asarray(calm, dtype=LONG)
    v /= np.sqrt((v * v).sum(axis=1))[:, None]
    place = v * LONG(radius_m)
    turn = 8 * np.arctan(LONG(1))
    for k in range(len(wavelength_m)):
        o = np.asarray(origins[k], dtype=LONG)
        o /= np.sqrt((o * o).sum())
        cosine = v @ o
        outward = v * cosine[:, None] - o
        sine = np.sqrt((outward * outward).sum(axis=1))
        way = LONG(radius_m) * np.arctan2(sine, cosine)
        cycles = way / LONG(wavelength_m[k]) + LONG(speed_rad_s[k]) * LONG(time_s) / turn
        theta = turn * (cycles - np.floor(cycles))
        a, q = LONG(amplitude_m[k]), LONG(steepness[k])
        place += v * (a * np.sin(theta))[:, None] + outward / sine[:, None] * (q * a * np.cos(theta))[:, None]
    return place
