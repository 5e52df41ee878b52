"""How rough the ground is at each scale: rms height differences over a distance, on land."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.field import HeightField

__all__ = ["EARTH_LAND_RELIEF_M", "EARTH_LAND_UNRELATED_M", "relief_statistics"]

Floats = NDArray[np.float64]

EARTH_LAND_RELIEF_M = {1.0: 0.14, 10.0: 1.4, 100.0: 8.1, 1e3: 29.0, 1e4: 101.0, 1e5: 358.0}
"""Rms height differences of Earth's land at distances in metres, put together from published measurements.

No table known to us spans 1 m to 100 km, so this joins a measured value and a measured exponent:
- 30 m: half of all land slopes less than 5.5 degrees in ASTER GDEM v3 (Tang, Ma, Shao and Peng 2020, "Global Land Slope
  Frequency Dataset", Journal of Global Change Data & Discovery 4(1), 24-30, doi 10.3974/geodp.2020.01.04). With
  exponentially distributed slopes the rms slope is 0.0963 * sqrt(2) / ln 2 = 0.196, in one direction 0.139: 4.2 m over
  30 m. Exponential: mean and standard deviation are nearly equal there, 5.23 and 5.31 degrees in Oceania, 13.53 and
  15.86 in Antarctica. That flat ice is the steepest of all shows how much noise of the sensor is in it: an upper value.
- above: the mean increment grows as distance^H, H = 0.66 on continents, in a multifractal of alpha 1.79, C1 0.12
  (Gagnon, Lovejoy and Schertzer 2006, "Multifractal earth topography", Nonlinear Processes in Geophysics 13, 541-570;
  power laws hold within 45 % from planetary scale down to 40 m). The rms increment grows more slowly, as
  distance^(H - K(2) / 2) = distance^0.549 with K(2) = C1 (2^alpha - 2) / (alpha - 1) = 0.221: the spectrum's exponent
  is 1 + 2 H - K(2) = 2.10. The law meets EARTH_LAND_UNRELATED_M at 1150 km, the size of continents; 0.66 would be
  there at 200 km.
- below: as distance^1, as on smooth ground. Nobody measured that on all land; ground is rougher than that at short
  scales (boulders, rills), so these are lower values.
Read for this: abstracts of all of these; of Gagnon et al. the values of H and of the spectrum as others quote them.
The join is ours; a factor of two is what it is good for. (Crooks, Bar-Yam, Buldyrev and Stanley 2018, arXiv:1809.02457,
find a crossover from 1 at short lengths to 0.4 above 10 km, by another measure of roughness: not used.)
"""

EARTH_LAND_UNRELATED_M = 1370.0
"""Rms height difference of two points of Earth's land that have nothing to do with one another: sqrt(2) times the
standard deviation of land heights, 970 m, from areas between heights 500 m apart (Dutch, "Global Topographic Summary",
University of Wisconsin - Green Bay, of 5-minute elevations: mean height of land 862 m)."""


def relief_statistics(
    field: HeightField,
    radius_m: float,
    distances_m: Sequence[float] = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5),
    count: int = 4000,
    sea_level_m: float = 0.0,
    seed: int = 0,
) -> Floats:
    """Root mean square height difference (len(distances_m),) between points of land that far apart.

    Pairs lie anywhere on the sphere (`count` directions, evenly random) in random azimuths; both ends are above
    `sea_level_m`. NaN where no pair of land was found.
    """
    rng = np.random.default_rng(seed)
    start = rng.normal(size=(count, 3))
    start /= np.linalg.norm(start, axis=1)[:, None]
    before = field.height(start)
    start, before = start[before > sea_level_m], before[before > sea_level_m]
    side = rng.normal(size=start.shape)
    side -= start * (side * start).sum(axis=1)[:, None]
    side /= np.linalg.norm(side, axis=1)[:, None]
    result = np.full(len(distances_m), np.nan)
    for i, distance in enumerate(distances_m):
        angle = distance / radius_m
        # the far end as start + an exact small step, so that 1 m is not lost in 6371 km
        end = start - 2.0 * np.sin(0.5 * angle) ** 2 * start + np.sin(angle) * side
        after = field.height(end)
        land = after > sea_level_m
        if land.any():
            result[i] = np.sqrt(np.mean((after[land] - before[land]) ** 2))
    return result
