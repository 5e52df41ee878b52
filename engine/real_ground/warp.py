"""Samples of a lattice interpolated from a file in another coordinate system.

Each sample is put where the file's pixels are, by PROJ, in float64: at every _STEP-th sample, and cubically between
(with a look at places between, which says whether that is right to _RIGHT of a pixel; else each one by itself).
There the cubic convolution of Keys (1981) goes through 4 x 4 pixels, kept within the range of the nearest four and a
share of it (`over`): no pit beside a wall.

A sample belongs to a file if its nearest pixel does. Pixels around a file's border come from the files beside it, where
these have the same grid of pixels, and else go on straight from the two next to the border: so tiles join.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .found import Found
from .geo_system import System
from .geo_tags import GeoHeader
from .lattice import Lattice

__all__ = ["Pixels", "pixel_places", "warped", "within"]

Floats = NDArray[np.float64]
Pixels = Callable[[slice, slice], Floats]
"""Values (channels, rows, columns) of pixels, NaN where there is none; slices may leave the file."""

_BLOCK = 240
_STEP = 24
_RIGHT = 1e-3
_EDGE = 0.51
"""Of a pixel: half of it, and a rest for what is rounded, so that nothing is left between tiles."""
_REACH = 2


def warped(
    found: Found, header: GeoHeader, system: System, pixels: Pixels, channels: int = 1, over: float = 0.05
) -> NDArray[np.float32]:
    """Values (channels, rows, columns) of a window of a lattice, NaN where the file has none."""
    out = np.full((channels, found.rows, found.columns), np.nan, np.float32)
    for top in range(0, found.rows, _BLOCK):
        for left in range(0, found.columns, _BLOCK):
            rows, columns = slice(top, min(top + _BLOCK, found.rows)), slice(left, min(left + _BLOCK, found.columns))
            x, y = pixel_places(found.window(rows, columns), header, system)
            _block(out[:, rows, columns], x, y, header, pixels, over)
    return out


def within(found: Found, header: GeoHeader, system: System) -> NDArray[np.bool_]:
    """Which samples (rows, columns) of a window lie within a file's pixels, gaps or not."""
    out = np.zeros((found.rows, found.columns), bool)
    for top in range(0, found.rows, _BLOCK):
        for left in range(0, found.columns, _BLOCK):
            rows, columns = slice(top, min(top + _BLOCK, found.rows)), slice(left, min(left + _BLOCK, found.columns))
            out[rows, columns] = _inside(*pixel_places(found.window(rows, columns), header, system), header)
    return out


def _inside(x: Floats, y: Floats, header: GeoHeader) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        found: NDArray[np.bool_] = (x >= -_EDGE) & (x <= header.columns - 1 + _EDGE)
        return found & (y >= -_EDGE) & (y <= header.rows - 1 + _EDGE)


def _block(
    out: NDArray[np.float32], x: Floats, y: Floats, header: GeoHeader, pixels: Pixels, over: float
) -> None:  # fmt: skip
    inside = _inside(x, y, header)
    if not inside.any():
        return
    x, y = x[inside], y[inside]
    left, right = int(np.floor(x.min())) - 1, int(np.floor(x.max())) + 3
    top, bottom = int(np.floor(y.min())) - 1, int(np.floor(y.max())) + 3
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
    flat: Floats, first: NDArray[np.int64], width: int, across: Floats, down: Floats, over: float
) -> Floats:  # fmt: skip
    total = np.zeros(len(first))
    low, high = np.full(len(first), np.inf), np.full(len(first), -np.inf)
    for b in range(4):
        row = np.zeros(len(first))
        for a in range(4):
            taps = flat[first + (b * width + a)]
            if a in (1, 2) and b in (1, 2):
                np.minimum(low, taps, out=low)
                np.maximum(high, taps, out=high)
            row += across[a] * taps
        total += down[b] * row
    room = over * (high - low)
    return np.clip(total, low - room, high + room)


def _weights(t: Floats) -> Floats:
    """Of Keys' cubic convolution (4, N), a = -1/2."""
    u = 1.0 - t
    return np.stack([
        -0.5 * t * u * u, 1.0 + t * t * (1.5 * t - 2.5), 1.0 + u * u * (1.5 * u - 2.5), -0.5 * u * t * t,
    ])  # fmt: skip


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


def pixel_places(found: Found, header: GeoHeader, system: System) -> tuple[Floats, Floats]:
    """Column and row (rows, columns) in a file's pixels, 0 in the middle of the first one, of a window's samples; not
    finite where its system has none."""
    lattice, rows, columns = found.lattice, found.rows, found.columns
    if min(rows, columns) > 3 * _STEP // 2:
        (nodes_y, by_row), (nodes_x, by_column) = _nodes(rows), _nodes(columns)
        x, y = _exact(lattice, found.row + nodes_y, found.column + nodes_x, header, system)
        if np.isfinite(x).all() and np.isfinite(y).all():
            x, y = (by_row @ v @ by_column.T for v in (x, y))
            j, i = (np.unique(np.linspace(_STEP // 2, n - 1, n // _STEP + 2, dtype=np.int64)) for n in (rows, columns))
            true_x, true_y = _exact(lattice, found.row + j, found.column + i, header, system)
            off = max(np.abs(true_x - x[np.ix_(j, i)]).max(), np.abs(true_y - y[np.ix_(j, i)]).max())
            if off <= _RIGHT:
                return x, y
    return _exact(lattice, found.row + np.arange(rows), found.column + np.arange(columns), header, system)


def _exact(
    lattice: Lattice, rows: NDArray[np.int64], columns: NDArray[np.int64], header: GeoHeader, system: System
) -> tuple[Floats, Floats]:  # fmt: skip
    latitude, longitude = lattice.place(columns[None], rows[:, None])
    latitude, longitude = np.broadcast_arrays(latitude, (longitude + 180.0) % 360.0 - 180.0)
    with np.errstate(invalid="ignore"):
        x, y = system.model(longitude.ravel(), latitude.ravel())
        column, row = header.pixel(x, y)
    return column.reshape(latitude.shape), row.reshape(latitude.shape)


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
