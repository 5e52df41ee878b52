"""How rough the ground is at each scale: rms height differences over a distance, on land."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.field import HeightField

__all__ = ["EARTH_LAND_RELIEF_M", "relief_statistics"]

Floats = NDArray[np.float64]

EARTH_LAND_RELIEF_M = {1.0: 0.14, 10.0: 1.4, 100.0: 9.2, 1e3: 42.0, 1e4: 193.0, 1e5: 880.0}
"""Rms height differences of Earth's land at distances in metres, put together from published measurements.

No table known to us spans 1 m to 100 km, so this joins one measured value and two measured exponents:
- 30 m: half of all land slopes less than 5.5 degrees in ASTER GDEM v3 (Tang, Ma, Shao and Peng, "Global Land Slope
  Frequency Dataset", Global Change Research Data Publishing and Repository). With exponentially distributed slopes
  the rms slope is 0.0963 * sqrt(2) / ln 2 = 0.196, in one direction 0.139: 4.2 m over 30 m.
- above: increments grow as distance^0.66 on continents (Gagnon, Lovejoy and Schertzer 2006, "Multifractal earth
  topography", Nonlinear Processes in Geophysics 13), measured on elevation models from 40 m to planetary scale.
- below: as distance^1, land is smooth at its shortest scales (Crooks, Bar-Yam, Buldyrev and Stanley 2018, "Comparison
  of the roughness scaling of the surface topography of Earth and Venus", arXiv:1809.02457, find exponent 1 there).
The join is ours; a factor of two is what it is good for.
"""


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
