"""Cells of a whole sphere, six faces of n x n, for what runs from neighbour to neighbour.

A face's cell (i, j) has its middle at s = w(2 (i + 1/2) / n - 1), t likewise, in the direction normalize(s x + t y + z)
of the face's axes (engine/surface/lattice.py). The warp w(u) = u (3 + u^2) / 4 makes cells nearly alike, as tan(pi/4
u) does, from operations that every machine rounds alike: edges differ by 1.4, areas by 1.6. A cell is named by one
number, (face n + j) n + i.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import NDArray

from ....engine.surface.lattice import to_face, to_planet

__all__ = ["NO_CELL", "CellGrid", "Cells", "cell_grid"]

Floats = NDArray[np.float64]
Cells = NDArray[np.int32]

NO_CELL = -1
"""In place of the neighbour that is not there: diagonally across a corner of the cube."""

_AROUND = ((0, -1), (-1, 0), (1, 0), (0, 1), (-1, -1), (1, -1), (-1, 1), (1, 1))
"""Steps (i, j) to the neighbours: four across edges, then four across corners."""


def _warp(u: Floats) -> Floats:
    return u * (3.0 + u * u) * 0.25


def _unwarp(s: Floats) -> Floats:
    """Inverse of `_warp` for |s| <= 1, by Newton's method: 1e-15 after four steps."""
    u = np.arctan(s) * (4.0 / np.pi)
    for _ in range(4):
        u = u - (_warp(u) - s) / (0.75 + 0.75 * u * u)
    return u


@dataclass(frozen=True)
class CellGrid:
    """Six faces of `across`^2 cells."""

    across: int

    @property
    def count(self) -> int:
        """All cells."""
        return 6 * self.across * self.across

    def directions(self, cells: Cells | None = None) -> Floats:
        """Unit directions (N, 3) of cells' middles; of all by default."""
        number = np.arange(self.count) if cells is None else np.asarray(cells, dtype=np.int64)
        row, i = np.divmod(number, self.across)
        face, j = np.divmod(row, self.across)
        return self._at(face, i, j)

    def within(self, cells: Cells, offsets: Floats) -> Floats:
        """Unit directions (N, 3) beside the middles of cells (N,), by offsets (N, 2) in cells, -1/2..1/2."""
        row, i = np.divmod(np.asarray(cells, dtype=np.int64), self.across)
        face, j = np.divmod(row, self.across)
        return self._at(face, i + offsets[:, 0], j + offsets[:, 1])

    def offsets(self, cells: Cells, directions: Floats) -> Floats:
        """Offsets (N, 2) in cells of directions (N, 3), near cells (N,), from the middles of these."""
        row, i = np.divmod(np.asarray(cells, dtype=np.int64), self.across)
        face, j = np.divmod(row, self.across)
        local = to_face(face, directions)
        place = (_unwarp(local[:, :2] / local[:, 2:]) * 0.5 + 0.5) * self.across - 0.5
        return place - np.stack([i, j], axis=1)

    def _at(self, face: NDArray[np.int64], i: Floats | NDArray[np.int64], j: Floats | NDArray[np.int64]) -> Floats:
        s, t = (_warp((2.0 * k + 1.0) / self.across - 1.0) for k in (i, j))
        vector = to_planet(face, np.stack([s, t, np.ones_like(s)], axis=-1))
        x, y, z = vector.T
        return vector / np.sqrt(x * x + y * y + z * z)[:, None]

    def locate(self, directions: Floats) -> Cells:
        """The cell (N,) that holds each direction (N, 3); on a border, either."""
        x, y, z = directions.T
        face = np.argmax(np.stack([x, -x, y, -y, z, -z]), axis=0)
        local = to_face(face, directions)
        place = _unwarp(local[:, :2] / local[:, 2:])
        i, j = np.clip(np.floor((place * 0.5 + 0.5) * self.across), 0, self.across - 1).astype(np.int64).T
        return ((face * self.across + j) * self.across + i).astype(np.int32)

    @cached_property
    def _beyond(self) -> Cells:
        """(6, 4, n) numbers of the cells across each face's edges: i = -1, i = n, j = -1, j = n, along each edge."""
        n = self.across
        found = np.empty((6, 4, n), dtype=np.int32)
        along = _warp((2.0 * np.arange(n) + 1.0) / n - 1.0)
        # A little beyond the edge lies the cell there, at the same place along it.
        over = np.full(n, 1.0 + 0.25 / n)
        for face in range(6):
            for side, (s, t) in enumerate(((-over, along), (over, along), (along, -over), (along, over))):
                local = np.stack([s, t, np.ones(n)], axis=-1)
                found[face, side] = self.locate(to_planet(np.full(n, face), local))
        return found

    def neighbours(self, cells: Cells) -> Cells:
        """Numbers (N, 8) of the cells around each, NO_CELL where three faces meet; the first four across edges."""
        n = self.across
        number = np.asarray(cells, dtype=np.int32)
        found = number[:, None] + np.array([dj * n + di for di, dj in _AROUND], dtype=np.int32)
        row, i = np.divmod(number, n)
        face, j = np.divmod(row, n)
        at = np.flatnonzero((i == 0) | (i == n - 1) | (j == 0) | (j == n - 1))
        i, j, face = i[at], j[at], face[at]
        for k, (di, dj) in enumerate(_AROUND):
            beside, along = (i + di < 0) | (i + di == n), (j + dj < 0) | (j + dj == n)
            side, place = np.where(beside, di > 0, 2 + (dj > 0)), np.where(beside, j + dj, i + di)
            across = np.where(beside & along, NO_CELL, self._beyond[face, side, np.clip(place, 0, n - 1)])
            found[at, k] = np.where(beside | along, across, found[at, k])
        return found

    def _bordered(self) -> Cells:
        """(6, n + 2, n + 2): numbers of cells, [face, j + 1, i + 1], with those across the edges around them."""
        n = self.across
        named = np.full((6, n + 2, n + 2), NO_CELL, dtype=np.int32)
        named[:, 1:-1, 1:-1] = np.arange(self.count, dtype=np.int32).reshape(6, n, n)
        for side, place in enumerate(((slice(1, -1), 0), (slice(1, -1), -1), (0, slice(1, -1)), (-1, slice(1, -1)))):
            named[(slice(None), *place)] = self._beyond[:, side]
        return named

    def interpolated(self, values: Floats, directions: Floats) -> Floats:
        """Of values (count,) at the cells' middles those in directions (N, 3): linear along both of a face's axes."""
        n = self.across
        named = self._bordered().astype(np.int64)
        spread = np.where(named == NO_CELL, 0.0, values[named])
        # No cell lies across a corner: the mean of the three that meet there, the same from all three faces.
        for row, column in ((0, 0), (0, -1), (-1, 0), (-1, -1)):
            inner_row, inner_column = (1 if row == 0 else -2), (1 if column == 0 else -2)
            beside = spread[:, row, inner_column] + spread[:, inner_row, column]
            spread[:, row, column] = (beside + spread[:, inner_row, inner_column]) / 3.0
        x, y, z = directions.T
        face = np.argmax(np.stack([x, -x, y, -y, z, -z]), axis=0)
        local = to_face(face, directions)
        place = (_unwarp(local[:, :2] / local[:, 2:]) * 0.5 + 0.5) * n + 0.5
        corner = np.clip(np.floor(place), 0, n).astype(np.int64)
        (fi, fj), (i, j) = (place - corner).T, corner.T
        low = spread[face, j, i] * (1.0 - fi) + spread[face, j, i + 1] * fi
        high = spread[face, j + 1, i] * (1.0 - fi) + spread[face, j + 1, i + 1] * fi
        return low * (1.0 - fj) + high * fj

    def areas(self, directions: Floats) -> Floats:
        """Areas (N,) of the cells with these middles, in squares of the radius."""
        local = np.sort(np.abs(directions), axis=1)
        high = local[:, 2]
        u, v = (_unwarp(local[:, k] / high) for k in (0, 1))
        # The plane's area by that of the sphere, times the warp's own.
        warped = 0.75 * (1.0 + u * u) * 0.75 * (1.0 + v * v)
        return (2.0 / self.across) ** 2 * warped * high * high * high


@lru_cache(maxsize=2)
def cell_grid(across: int) -> CellGrid:
    """The same object for equal sizes: its table of borders is made once."""
    return CellGrid(across)
