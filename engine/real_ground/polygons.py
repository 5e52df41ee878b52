"""Polygons on a map of degrees: whether places lie in them, and which share of a raster's samples does.

Both count how often edges wind around a place, outer rings one way and holes the other, so polygons may overlap and
share edges; both are exact but for how rows of samples are cut, and the same on every machine.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

__all__ = ["Polygons"]

Floats = NDArray[np.float64]
_BAND_EDGES = 8
_ROWS = 4
"""Lines of each row of samples along which the share is exact."""


class Polygons:
    """Each an outer ring and holes (N, 2), longitude and latitude in degrees, closed."""

    def __init__(self, polygons: Iterable[tuple[Floats, ...]]) -> None:
        parts = []
        for rings in polygons:
            for number, ring in enumerate(rings):
                x, y = (ring - ring[0]).T
                left = float((x[:-1] * y[1:] - x[1:] * y[:-1]).sum()) > 0.0
                turned = ring if left == (number == 0) else ring[::-1]
                parts.append(np.concatenate([turned[:-1], turned[1:]], axis=1))
        edges = np.concatenate([np.zeros((0, 4)), *parts])
        self.edges = edges
        """(E, 4) longitude and latitude of both ends"""
        self.bounds = (
            (np.inf, np.inf, -np.inf, -np.inf)
            if not len(edges)
            else tuple(float(f(edges[:, k::2])) for f in (np.min, np.max) for k in (0, 1))
        )
        """west, south, east, north"""
        self._edges = edges[edges[:, 1] != edges[:, 3]]
        self._low = np.minimum(self._edges[:, 1], self._edges[:, 3])
        self._high = np.maximum(self._edges[:, 1], self._edges[:, 3])
        self._sign = np.where(self._edges[:, 3] > self._edges[:, 1], 1.0, -1.0)
        self._list_bands()

    def _list_bands(self) -> None:
        """Edges by bands of latitude, so that a place looks at few of them."""
        count = max(min(len(self._edges) // _BAND_EDGES, 1 << 14), 1)
        south, north = self.bounds[1], self.bounds[3]
        self._per_deg = count / max(north - south, 1e-300) if len(self._edges) else 1.0
        self._bands = count
        first, last = self._band(self._low), self._band(self._high)
        many = last - first + 1
        edge = np.repeat(np.arange(len(many)), many)
        band = np.arange(len(edge)) - np.repeat(np.cumsum(many) - many, many) + first[edge]
        order = np.argsort(band, kind="stable")
        self._listed = edge[order]
        self._begin = np.searchsorted(band[order], np.arange(count + 1))

    def _band(self, latitude_deg: Floats) -> NDArray[np.int64]:
        if not len(self._edges):
            return np.zeros(len(latitude_deg), np.int64)
        found = np.floor((latitude_deg - self.bounds[1]) * self._per_deg).astype(np.int64)
        return np.clip(found, 0, self._bands - 1)

    def turns_deg(self, west_deg: float, east_deg: float) -> list[float]:
        """Whole turns by which places between these longitudes come to where polygons are."""
        if not len(self.edges):
            return []
        return [360.0 * k for k in range(-2, 3) if west_deg + 360.0 * k <= self.bounds[2]
                and east_deg + 360.0 * k >= self.bounds[0]]  # fmt: skip

    def boxed(self, longitude_deg: Floats, latitude_deg: Floats) -> NDArray[np.bool_]:
        """(N,) whether places are within the bounds."""
        west, south, east, north = self.bounds
        found = np.zeros(len(longitude_deg), dtype=bool)
        for turn in self.turns_deg(-180.0, 180.0):
            found |= (longitude_deg + turn >= west) & (longitude_deg + turn <= east)
        return found & (latitude_deg >= south) & (latitude_deg <= north)

    def inside(self, longitude_deg: Floats, latitude_deg: Floats) -> NDArray[np.bool_]:
        """(N,) whether places lie in any of them."""
        found = np.zeros(len(longitude_deg), dtype=bool)
        for turn in self.turns_deg(-180.0, 180.0):
            at = np.flatnonzero((latitude_deg >= self.bounds[1]) & (latitude_deg <= self.bounds[3]) & ~found)
            for start in range(0, len(at), 4096):
                part = at[start : start + 4096]
                found[part] = self._wound(longitude_deg[part] + turn, latitude_deg[part])
        return found

    def _wound(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        band = self._band(y)
        begin, many = self._begin[band], self._begin[band + 1] - self._begin[band]
        place = np.repeat(np.arange(len(x)), many)
        edge = self._listed[np.arange(len(place)) - np.repeat(np.cumsum(many) - many, many) + begin[place]]
        on = (y[place] >= self._low[edge]) & (y[place] < self._high[edge])
        place, edge = place[on], edge[on]
        ax, ay, bx, by = self._edges[edge].T
        right = ax + (y[place] - ay) / (by - ay) * (bx - ax) > x[place]
        turns = np.bincount(place[right], self._sign[edge[right]], len(x))
        return turns > 0.5

    def shares(self, column: Floats, row: Floats, rows: int, columns: int) -> Floats:
        """(rows, columns) which share of each sample of a raster lies in them: at row k and column i of a sample's
        middle. column, row: edges' ends (E, 2) in samples from the first one's middle."""
        top, bottom = row.min(axis=1), row.max(axis=1)
        near = np.flatnonzero((bottom > -0.5) & (top < rows - 0.5) & (column.max(axis=1) > -0.5) & (top < bottom))
        if not near.size:
            return np.zeros((rows, columns))
        x, y = column[near] + 0.5, (row[near] + 0.5) * _ROWS
        low, high = y.min(axis=1), y.max(axis=1)
        # Lines lie in the middle of their part of a row.
        first = np.clip(np.ceil(low - 0.5), 0, rows * _ROWS).astype(np.int64)
        last = np.clip(np.ceil(high - 0.5), 0, rows * _ROWS).astype(np.int64)
        many = last - first
        edge = np.repeat(np.arange(len(many)), many)
        line = np.arange(len(edge)) - np.repeat(np.cumsum(many) - many, many) + first[edge]
        t = (line + 0.5 - y[edge, 0]) / (y[edge, 1] - y[edge, 0])
        at = np.clip(x[edge, 0] + t * (x[edge, 1] - x[edge, 0]), 0.0, float(columns))
        sign = np.where(y[edge, 1] < y[edge, 0], 1.0, -1.0)  # rows go south
        cell = np.minimum(at.astype(np.int64), columns - 1)
        number, size = line * columns + cell, rows * _ROWS * columns
        part = np.bincount(number, sign * (at - cell), size).reshape(-1, columns)
        whole = np.bincount(number, sign, size).reshape(-1, columns)
        # All samples to the west of a crossing.
        whole = np.cumsum(whole[:, ::-1], axis=1)[:, ::-1] - whole
        share = np.clip(part + whole, 0.0, 1.0)
        return share.reshape(rows, _ROWS, columns).mean(axis=1)
