"""The waterfalls of a table of rivers: where each comes down, how far and how wide."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .bends import unbent
from .falls import LEAST_M, STEEPNESS
from .table import CELL_STEPS, RiverTable

__all__ = ["FallList", "Falls"]

Floats = NDArray[np.float64]

_STEEP = 0.5 * STEEPNESS
"""Lines that come down by more than so much of their length are falls: all others are far flatter."""

_STEPS = 16
"""To where the warp's inverse is, beyond the first few: a few centimetres."""


@dataclass(frozen=True, eq=False)
class Falls:
    """Arrays (N,) of falls as they are drawn."""

    foot_m: Floats
    """(N, 3) planet-centred, at the level of the water below"""
    way: Floats
    """(N, 3) unit, level: the way the water goes"""
    height_m: Floats
    half_width_m: Floats
    number: NDArray[np.integer]
    """among all of the planet"""

    def __len__(self) -> int:
        return len(self.height_m)


class FallList:
    """All falls of a planet, as straight lines; where the warp draws one is found when it is first near. The preset
    earth has 8900."""

    def __init__(self, table: RiverTable) -> None:
        self._table = table
        level, half_width, lake = table.values[:, 0], table.values[:, 1], table.values[:, 5]
        to, step_m = np.maximum(table.to, 0), table.cell_m / CELL_STEPS
        drop_m = level - level[to]
        upper = np.flatnonzero((drop_m > LEAST_M) & (half_width > 0.0) & (table.to >= 0))
        upper = upper[lake[upper] + lake[to[upper]] == 0.0]
        below = to[upper]
        x, y, z = step_m * (table.place[below] - table.place[upper]).T.astype(np.float64)
        steep = drop_m[upper] ** 2 > _STEEP**2 * (x * x + y * y + z * z)
        self._lip, self._foot = upper[steep], below[steep]
        self._foot_m = table.place[self._foot] * step_m
        self._height_m = drop_m[self._lip].astype(np.float64)
        # Of those that were near: unit directions of their feet, and which way they go. NaN: not asked yet.
        self._up, self._way = (np.full((len(self._foot), 3), np.nan) for _ in range(2))
        self._moved_m = float(table.bend_m.sum()) * np.sqrt(3.0)

    def __len__(self) -> int:
        return len(self._foot)

    def around(self, place_m: Floats, within_m: float, least_rad: float, frozen_sine: float = 2.0) -> Falls:
        """Those that look higher than least_rad from somewhere within so many metres of a place (3,), and are no ice:
        that begins at a latitude of that sine."""
        table, values = self._table, self._table.values
        level_m = values[self._foot, 0].astype(np.float64)
        size = 1.0 + level_m / table.radius_m
        away_m = np.linalg.norm(self._foot_m * size[:, None] - place_m, axis=1) - within_m - self._moved_m
        liquid = np.abs(self._foot_m[:, 2]) < frozen_sine * table.radius_m
        near = np.flatnonzero((self._height_m > least_rad * away_m) & liquid)
        self._find(near[np.isnan(self._up[near, 0])])
        half_width_m = values[self._foot[near], 1].astype(np.float64)
        foot_m = self._up[near] * (table.radius_m + level_m[near])[:, None]
        return Falls(foot_m, self._way[near], self._height_m[near], half_width_m, near)

    def _find(self, missing: NDArray[np.integer]) -> None:
        """Where these falls are drawn."""
        lip, foot = self._drawn(self._lip[missing]), self._drawn(self._foot[missing])
        up = foot / self._table.radius_m
        way = foot - lip
        way -= up * (way * up).sum(axis=1)[:, None]
        length_m = np.linalg.norm(way, axis=1)[:, None]
        # One that the warp makes vertical goes somewhere all the same.
        aside = np.cross(up, np.where(np.abs(up[:, 2:]) < 0.9, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
        way = np.where(length_m > 1e-3, way, aside)
        self._up[missing], self._way[missing] = up, way / np.linalg.norm(way, axis=1)[:, None]

    def _drawn(self, nodes: NDArray[np.integer]) -> Floats:
        """(N, 3) planet-centred, on the reference sphere."""
        points = (self._table.place[nodes] * (self._table.cell_m / CELL_STEPS)).T
        x, y, z = points
        points = points * (self._table.radius_m / np.sqrt(x * x + y * y + z * z))
        return (points if self._table.given else unbent(points, self._table.radius_m, self._table.seed, _STEPS)).T
