"""How rough the ground is at each scale: rms height differences over a distance, on land."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.field import HeightField

__all__ = ["relief_statistics"]

Floats = NDArray[np.float64]


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
