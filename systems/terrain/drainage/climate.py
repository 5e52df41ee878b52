"""Rain and temperature of a planet's ground, from latitude, height and the way that air has come.

A sketch of what makes deserts and rain forests where they are, not a weather model. Air moves with three belts of winds
a hemisphere (trades, westerlies, polar easterlies). It takes up water over the sea, loses it as rain, most of it where
belts meet and rise and where it climbs mountains, and gets a part back from wet ground; behind mountains little is
left. Operations are + - x / sqrt alone, so that equal grounds have equal rain to the bit on every machine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....components import Terrain
from .cells import NO_CELL, CellGrid

__all__ = ["ACROSS", "ClimateParams", "climate_params", "rain_mm", "runoff_mm", "snow_line_m", "temperature_c", "winds"]

Floats = NDArray[np.float64]

ACROSS = 192
"""Cells a side of a face on which air moves: 52 km on Earth. Rates below are per cell of these."""

LAPSE_K_PER_M = 0.0065
"""Of the standard atmosphere (ISO 2533)."""
SNOW_LINE_C = -6.0
"""Mean of the year where snow lasts: 28 degrees at the equator's sea level for Earth's line of 5200 m."""
HOTTEST_C = 45.0
"""A line far up says that there is no snow, not that seas boil."""

_STEPS = 160
"""Cells that air comes from."""
_UPTAKE, _MOIST = 0.12, 0.85
"""Over the sea air takes up this share of what it has less than this share of what it can hold."""
_BACK = 0.7
"""Share of rain on land that the air gets back: 73 of 113 in a thousand km^3 on Earth, the rest runs off (Trenberth et
al. 2007); a little more, since air here has one height and loses no water aloft."""
_CLIMBING_M = 2200.0
"""Climbing so far, air loses most of its water: the scale height of vapour."""
_SATURATED_MM = 5.8e4
"""Rain of a year where all the water of saturated air of 28 degrees fell in one cell: land has 0.8 m in the mean."""


@dataclass(frozen=True)
class ClimateParams:
    """What a planet's rain and temperature depend on beside its ground: see the knobs of the same names of Terrain."""

    snow_line_m: float
    snow_line_pole_m: float
    humidity: float
    sea: bool = True
    """without one nothing rains"""


def climate_params(terrain: Terrain, sea: bool = True) -> ClimateParams:
    """What the rain depends on, beside heights: nothing rains on a planet without Ocean."""
    return ClimateParams(terrain.snow_line_m, terrain.snow_line_pole_m, terrain.humidity, sea)


def temperature_c(directions: Floats, height_m: Floats, params: ClimateParams) -> Floats:
    """Means of the year (N,) at heights (N,), from the snow line that the ground's materials show."""
    found = SNOW_LINE_C + LAPSE_K_PER_M * (snow_line_m(directions, params) - np.maximum(height_m, 0.0))
    return np.minimum(found, HOTTEST_C)


def snow_line_m(directions: Floats, params: ClimateParams) -> Floats:
    """Heights (N,) from which on snow lasts: those of the equator and of the poles, and between them as the ground's
    materials have it."""
    square = directions[:, 2] * directions[:, 2]
    rise_m = (params.snow_line_pole_m - params.snow_line_m) * square * (0.4 + 0.6 * np.sqrt(square))
    return params.snow_line_m + rise_m


def winds(directions: Floats) -> Floats:
    """Level winds (N, 3) at the ground, about 1 where they are strong: easterly trades that converge at the equator,
    westerlies that blow polewards, polar easterlies. They turn at 30 and 60 degrees."""
    x, y, sine = directions.T
    level = np.sqrt(np.maximum(x * x + y * y, 1e-12))
    high = np.abs(sine)
    eastward = np.maximum(9.0 * (high - 0.5) * (0.866 - high) * (1.0 + 0.3 * high), -0.9)
    northward = 6.0 * sine * (high - 0.5) * (0.9 - high)
    return np.stack(
        [
            (-eastward * y - northward * sine * x) / level,
            (eastward * x - northward * sine * y) / level,
            northward * level,
        ],
        axis=1,
    )


def rain_mm(grid: CellGrid, height_m: Floats, params: ClimateParams) -> Floats:
    """Rain and snow of a year (count,) on cells of these heights (count,), the sea at 0."""
    if not params.sea:
        return np.zeros(grid.count)
    directions = grid.directions()
    neighbours = grid.neighbours(np.arange(grid.count, dtype=np.int32)).astype(np.int64)
    there = neighbours != NO_CELL
    neighbours = np.where(there, neighbours, np.arange(grid.count)[:, None])
    shares = _shares(directions, neighbours, there)
    sea, ground = height_m <= 0.0, np.maximum(height_m, 0.0)
    climb = _from(shares * np.maximum(ground[:, None] - ground[neighbours], 0.0))
    holds = _vapour(temperature_c(directions, height_m, params))
    rate = np.minimum(_rising(directions) + climb / _CLIMBING_M, 0.9)
    water = np.where(sea, 0.8 * holds, 0.0)
    rain = np.zeros(grid.count)
    for _ in range(_STEPS):
        come = _from(shares * water[neighbours])
        # Cold air holds little: the rest falls.
        rain = rate * come + np.maximum((1.0 - rate) * come - holds, 0.0)
        left = come - rain
        water = np.where(sea, left + _UPTAKE * np.maximum(_MOIST * holds - left, 0.0), left + _BACK * rain)
    return _SATURATED_MM * max(2.0 * params.humidity, 0.0) * rain


def runoff_mm(rain: Floats, temperature: Floats) -> Floats:
    """What of rain (N,) runs off in a year (N,): the rest evaporates, more where it is warm (Turc 1954, catchments of
    all climates)."""
    warm = np.maximum(temperature, 0.0)
    demand = 300.0 + 25.0 * warm + 0.05 * warm * warm * warm
    ratio = rain / demand
    return np.maximum(rain - rain / np.sqrt(np.maximum(0.9 + ratio * ratio, 1.0)), 0.0)


def _shares(directions: Floats, neighbours: NDArray[np.int64], there: NDArray[np.bool_]) -> Floats:
    """(N, 8): of the air of a cell what came from each neighbour, by how well the wind blows along the way from it."""
    blowing, shares = winds(directions), np.zeros(neighbours.shape)
    for k in range(8):
        way = directions - directions[neighbours[:, k]]
        x, y, z = way.T
        length = np.sqrt(np.maximum(x * x + y * y + z * z, 1e-30))
        u, v, w = blowing.T
        along = np.maximum(x * u + y * v + z * w, 0.0) / length
        shares[:, k] = np.where(there[:, k], along * along + 1e-4, 0.0)
    return shares / _from(shares)[:, None]


def _from(parts: Floats) -> Floats:
    """Sum (N,) over neighbours (N, 8), one after the other: numpy's own sums differ between processors."""
    first, *others = parts.T
    total = first.copy()
    for other in others:
        total += other
    return total


def _rising(directions: Floats) -> Floats:
    """Share of its water that air loses in a cell where nothing but the great circulation makes it rise: much at the
    equator and in the storm tracks, little in the dry belts between."""
    high = np.abs(directions[:, 2])
    tropics = np.maximum(1.0 - (high / 0.26) * (high / 0.26), 0.0)
    far = (high - 0.8) / 0.36
    storms = np.maximum(1.0 - far * far, 0.0)
    return 0.006 + 0.065 * tropics * tropics + 0.06 * storms * storms


def _vapour(temperature: Floats) -> Floats:
    """Water that air can hold, 1 at 28 degrees, a fifth of that at 0: Clausius and Clapeyron within 10 % from -20 to 28
    degrees."""
    warm = np.maximum((temperature + 68.0) / 96.0, 0.0)
    square = warm * warm
    return square * square * warm
