"""Samples of a lattice interpolated from a file in another coordinate system.

Each sample is put where the file's pixels are, by PROJ, in float64: at every _STEP-th sample, and cubically between
(with a look at places between, which says whether that is right to _RIGHT of a pixel; else each one by itself).
There the cubic convolution of Keys (1981) goes through 4 x 4 pixels, kept within the range of the nearest four and a
share of it (`over`): no pit beside a wall.

A sample belongs to a file if its nearest pixel does. Pixels around a file's border come from the files beside it, where
these have the same grid of pixels, and else go on straight from the two next to the border: so tiles join.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .found import Found
from .geo_system import System
from .geo_tags import GeoHeader
from .lattice import Lattice

__all__ = ["Pixels", "pixel_places", "warped", "within"]

Floats = NDArray[np.float64]
Weights = tuple[Floats, Floats, Floats, Floats]
Pixels = Callable[[slice, slice], Floats]
"""Values (channels, rows, columns) of pixels, NaN where there is none; slices may leave the file."""

_BLOCK = 120
_STEP = 40
_RIGHT = 1e-3
_EDGE = 0.51
"""Of a pixel: half of it, and a rest for what is rounded, so that nothing is left between tiles."""
_REACH = 2
_AROUND = 1 + 2 * _REACH
"""Pixels around those that samples lie between: one more for the cubic, and those that what is missing follows from."""


def warped(
    found: Found, header: GeoHeader, system: System, pixels: Pixels, channels: int = 1, over: float = 0.05
) -> NDArray[np.float32]:
    """Values (channels, rows, columns) of a window of a lattice, NaN where the file has none. Each sample's is the same
    in whichever window it is asked for."""
    out = np.full((channels, found.rows, found.columns), np.nan, np.float32)
    for block, inner, outer in _blocks(found):
        x, y = pixel_places(block, header, system)
        _fill(out[(slice(None), *outer)], x[inner], y[inner], header, pixels, over)
    return out


def within(found: Found, header: GeoHeader, system: System) -> NDArray[np.bool_]:
    """Which samples (rows, columns) of a window lie within a file's pixels, gaps or not."""
    out = np.zeros((found.rows, found.columns), bool)
    for block, inner, outer in _blocks(found):
        out[outer] = _inside(*pixel_places(block, header, system), header)[inner]
    return out


def _blocks(found: Found) -> Iterator[tuple[Found, tuple[slice, slice], tuple[slice, slice]]]:
    """Squares of the lattice that a window lies in, slices of the square, and slices of the window."""
    for j in range(found.row // _BLOCK, (found.row + found.rows - 1) // _BLOCK + 1):
        for i in range(found.column // _BLOCK, (found.column + found.columns - 1) // _BLOCK + 1):
            block = Found(found.lattice, i * _BLOCK, j * _BLOCK, _BLOCK, _BLOCK)
            spans = ((block.row, found.row, found.rows), (block.column, found.column, found.columns))
            inner = [slice(max(o - b, 0), min(o + n - b, _BLOCK)) for b, o, n in spans]
            outer = [slice(s.start + b - o, s.stop + b - o) for s, (b, o, _) in zip(inner, spans, strict=True)]
            yield block, (inner[0], inner[1]), (outer[0], outer[1])


def _inside(x: Floats, y: Floats, header: GeoHeader) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        found: NDArray[np.bool_] = (x >= -_EDGE) & (x <= header.columns - 1 + _EDGE)
        return found & (y >= -_EDGE) & (y <= header.rows - 1 + _EDGE)


def _fill(
    out: NDArray[np.float32], x: Floats, y: Floats, header: GeoHeader, pixels: Pixels, over: float
) -> None:  # fmt: skip
    inside = _inside(x, y, header)
    if not inside.any():
        return
    x, y = x[inside], y[inside]
    left, right = int(np.floor(x.min())) - _AROUND, int(np.floor(x.max())) + 2 + _AROUND
    top, bottom = int(np.floor(y.min())) - _AROUND, int(np.floor(y.max())) + 2 + _AROUND
    values = pixels(slice(top, bottom), slice(left, right))
    there = ~np.isnan(values[0])
    if not there.any():
        return
    if not there.all():
        near_x = np.clip(np.rint(x), 0, header.columns - 1).astype(np.int64) - left
        near_y = np.clip(np.rint(y), 0, header.rows - 1).astype(np.int64) - top
        known = there[near_y, near_x]
        inside[inside] = known
        x, y = x[known], y[known]
        if not x.size:
            return
        values = np.stack([_grown(channel, there) for channel in values])
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    across, down = _weights(x - i), _weights(y - j)
    width = values.shape[2]
    first = (j - 1 - top) * width + (i - 1 - left)
    for channel, of in zip(values, out, strict=True):
        of[inside] = _cubic(channel.ravel(), first, width, across, down, over)


def _cubic(
    flat: Floats, first: NDArray[np.int64], width: int, across: Weights, down: Weights, over: float
) -> Floats:  # fmt: skip
    total = np.zeros(len(first))
    low, high = np.full(len(first), np.inf), np.full(len(first), -np.inf)
    for b in range(4):
        row = np.zeros(len(first))
        for a in range(4):
            taps = flat[b * width + a :].take(first)
            if a in (1, 2) and b in (1, 2):
                np.minimum(low, taps, out=low)
                np.maximum(high, taps, out=high)
            taps *= across[a]
            row += taps
        row *= down[b]
        total += row
    if over:
        room = over * (high - low)
        low -= room
        high += room
    return np.clip(total, low, high, out=total)


def _weights(t: Floats) -> Weights:
    """Of Keys' cubic convolution, a = -1/2."""
    half = 0.5 * t * (1.0 - t)
    first, last = half * (t - 1.0), -half * t
    second = 1.0 + t * t * (1.5 * t - 2.5)
    return first, second, 1.0 - first - second - last, last


def _grown(values: Floats, there: NDArray[np.bool_]) -> Floats:
    """Values with _REACH pixels more around them: straight on from the two before, along rows and columns, and from a
    corner along its diagonal."""
    out, known = values.copy(), there
    for _ in range(_REACH):
        wide, had = np.pad(out, 2, constant_values=np.nan), np.pad(known, 2)
        total, count = np.zeros(out.shape), np.zeros(out.shape, np.int64)
        for steps in (((0, 1), (0, -1), (1, 0), (-1, 0)), ((1, 1), (1, -1), (-1, 1), (-1, -1))):
            open_ = ~known & (count == 0)
            for dy, dx in steps:
                next_, after = (
                    (slice(2 + k * dy, 2 + k * dy + out.shape[0]), slice(2 + k * dx, 2 + k * dx + out.shape[1]))
                    for k in (1, 2)
                )
                at = open_ & had[next_]
                if not at.any():
                    continue
                one, two = wide[next_][at], wide[after][at]
                total[at] += np.where(np.isnan(two), one, 2.0 * one - two)
                count[at] += 1
        new = count > 0
        out[new] = total[new] / count[new]
        known = known | new
    return np.where(known, out, 0.0)


def pixel_places(block: Found, header: GeoHeader, system: System) -> tuple[Floats, Floats]:
    """Column and row (rows, columns) in a file's pixels, 0 in the middle of the first one, of a square's samples; not
    finite where its system has none."""
    lattice, rows, columns = block.lattice, block.rows, block.columns
    (nodes_y, by_row), (nodes_x, by_column) = _nodes(rows), _nodes(columns)
    x, y = _exact(lattice, block.row + nodes_y, block.column + nodes_x, header, system)
    if np.isfinite(x).all() and np.isfinite(y).all():
        x, y = (_spread(v, by_row, by_column) for v in (x, y))
        j, i = (np.unique(np.linspace(_STEP // 2, n - 1, n // _STEP + 2, dtype=np.int64)) for n in (rows, columns))
        true_x, true_y = _exact(lattice, block.row + j, block.column + i, header, system)
        off = max(np.abs(true_x - x[np.ix_(j, i)]).max(), np.abs(true_y - y[np.ix_(j, i)]).max())
        if off <= _RIGHT:
            return x, y
    return _exact(lattice, block.row + np.arange(rows), block.column + np.arange(columns), header, system)


def _spread(values: Floats, by_row: Floats, by_column: Floats) -> Floats:
    """Between nodes. By einsum, since BLAS would start threads for so little."""
    return np.einsum("ia,aj->ij", by_row, np.einsum("ab,jb->aj", values, by_column))


def _exact(
    lattice: Lattice, rows: NDArray[np.int64], columns: NDArray[np.int64], header: GeoHeader, system: System
) -> tuple[Floats, Floats]:  # fmt: skip
    latitude, longitude = lattice.place(columns[None], rows[:, None])
    latitude, longitude = np.broadcast_arrays(latitude, (longitude + 180.0) % 360.0 - 180.0)
    with np.errstate(invalid="ignore"):
        x, y = system.model(longitude.ravel(), latitude.ravel())
        column, row = header.pixel(x, y)
    return column.reshape(latitude.shape), row.reshape(latitude.shape)


@lru_cache(maxsize=8)
def _nodes(count: int) -> tuple[NDArray[np.int64], Floats]:
    """Samples, _STEP apart and two beyond each end, and the weights (count, nodes) of Lagrange's cubic through them."""
    cells = -(-(count - 1) // _STEP)
    nodes = np.arange(-1, cells + 2) * _STEP
    at = np.arange(count)
    cell = np.minimum(at // _STEP, cells - 1)
    t = (at - cell * _STEP) / _STEP
    weights = np.zeros((count, len(nodes)))
    for k, w in enumerate((
        -t * (t - 1.0) * (t - 2.0) / 6.0, (t + 1.0) * (t - 1.0) * (t - 2.0) / 2.0, -(t + 1.0) * t * (t - 2.0) / 2.0,
        (t + 1.0) * t * (t - 1.0) / 6.0,
    )):  # fmt: skip
        weights[at, cell + k] = w
    return nodes, weights
