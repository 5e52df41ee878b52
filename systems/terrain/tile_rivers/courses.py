"""Where in their cells streams run: in the middle of the valley's floor, with bends in place of the cells' corners."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..drainage.routing import Flow
from .cells import GridCells, Indices

__all__ = ["curved", "offsets_of"]

Floats = NDArray[np.float64]

_MOST_AWAY = 0.35
"""Cells from a cell's middle to the stream, at most."""
_BETWEEN = 4
"""Places of a curve from cell to cell."""
_ROUNDS = 6
"""Means with both neighbours along a stream: bends are some cells long."""


def curved(places: Floats, ways: Floats, level_m: Floats) -> tuple[Floats, Floats]:
    """Places (M, 2) on a curve through these (K, 2), along `ways` (K, 2) there (cubics of Hermite), and levels (M,)
    between theirs (K,)."""
    t = np.arange(_BETWEEN)[:, None] / _BETWEEN
    s = 1.0 - t
    a, b, u, v = places[:-1, None], places[1:, None], ways[:-1, None], ways[1:, None]
    between = a + t * t * (3.0 - 2.0 * t) * (b - a) + t * s * (s * u - t * v)
    level = level_m[:-1, None] + t[:, 0] * np.diff(level_m)[:, None]
    return np.concatenate([between.reshape(-1, 2), places[-1:]]), np.append(level.ravel(), level_m[-1])


def offsets_of(cells: GridCells, flow: Flow, main: Indices, at: Indices) -> tuple[Floats, Floats]:
    """(K, 2) offsets in columns and rows of streams from the middles of their cells `at` (K,), rising, and which way
    (K, 2) they run there, so far as from cell to cell. main (N + 1,): of the streams that come to each cell the
    largest, -1: none.

    Across the stream the lowest place is a parabola's, through the heights a cell to the left, here and to the right.
    """
    own = np.arange(len(at))
    index = np.full(len(cells.sea), -1)
    index[at] = own
    below, above = flow.receiver[at], main[at]
    below = np.where(below == cells.out, at, below)
    above = np.where(above < 0, at, above)
    middle = np.stack([cells.column[at], cells.row[at]], axis=1).astype(np.float64)

    def middles(of: Indices) -> Floats:
        return np.stack([cells.column[of], cells.row[of]], axis=1).astype(np.float64)

    way = middles(below) - middles(above)
    length = np.maximum(np.hypot(*way.T), 1e-9)[:, None]
    aside = np.stack([-way[:, 1], way[:, 0]], axis=1) / length
    left, right = _heights(cells, middle - aside), _heights(cells, middle + aside)
    bent = left - 2.0 * cells.height_m[at] + right
    valley = np.isfinite(bent) & (bent > 1e-6)
    away = np.where(valley, 0.5 * (left - right) / np.where(valley, bent, 1.0), 0.0)
    places = middle + np.clip(away, -_MOST_AWAY, _MOST_AWAY)[:, None] * aside
    # What ends in the sea ends in the middle of its cell; springs stay where they are.
    up, down = index[above], index[below]
    for _ in range(_ROUNDS):
        before = np.where((up >= 0)[:, None], places[up], places)
        after = np.where((down >= 0)[:, None], places[down], middles(below))
        off = 0.25 * before + 0.5 * places + 0.25 * after - middle
        far = np.maximum(np.hypot(*off.T) / _MOST_AWAY, 1.0)[:, None]
        places = middle + off / far
    before = np.where((up >= 0)[:, None], places[up], places)
    after = np.where((down >= 0)[:, None], places[down], middles(below))
    return places - middle, 0.5 * (after - before)


def _heights(cells: GridCells, places: Floats) -> Floats:
    """(K,) between the cells' middles, linear along both axes; NaN where one of the four is missing."""
    heights = cells.grid.height_m
    corner = np.floor(places).astype(np.int64)
    i = np.clip(corner[:, 0], 0, heights.shape[1] - 2)
    j = np.clip(corner[:, 1], 0, heights.shape[0] - 2)
    inside = (places >= 0.0).all(axis=1) & (places <= np.array(heights.shape[::-1]) - 1.0).all(axis=1)
    x, y = places[:, 0] - i, places[:, 1] - j
    low = heights[j, i] * (1.0 - x) + heights[j, i + 1] * x
    high = heights[j + 1, i] * (1.0 - x) + heights[j + 1, i + 1] * x
    return np.where(inside, low * (1.0 - y) + high * y, np.nan)
