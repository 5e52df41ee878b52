"""Pictures of what tiles hold: samples by their places, in degrees, set over set."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice

__all__ = ["SetPicture"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_BEYOND = 1e-6
"""What samples weigh beyond their tile: all, where two tiles end a sample apart; hardly anything, where they share a
row of samples or lie over one another."""


class SetPicture:
    """What one set shows in a picture (rows, columns) or (rows, columns, channels).

    corner: north and west of the picture, degrees; scale: pixels by degree. smooth: between samples that are farther
    apart than pixels values go on straight, from one tile to the next, too; else a pixel shows the nearest sample.
    """

    def __init__(
        self, shape: tuple[int, ...], lattice: Lattice, corner: tuple[float, float], scale: float, smooth: bool
    ) -> None:
        self._lattice, self._corner, self._scale, self._smooth = lattice, corner, scale, smooth
        # Sums, so that what lies between two tiles is made of both.
        self._sum = np.zeros(shape, np.float32)
        self._weight = np.zeros(shape[:2], np.float32)
        self._shown = np.zeros(shape[:2], np.bool_)

    def draw(self, values: NDArray[Any], there: NDArray[np.bool_], first: tuple[int, int]) -> None:
        """Samples of a tile (rows, columns) or (rows, columns, channels), and which of them there are. first: its first
        column and row."""
        lattice, (north, west) = self._lattice, self._corner
        rows, columns = np.arange(values.shape[0]) + first[1], np.arange(values.shape[1]) + first[0]
        latitude = lattice.place(np.zeros(len(rows)), rows)[0]
        longitude = lattice.place(columns, np.zeros(len(columns)))[1]
        longitude -= 360.0 * np.floor((longitude[0] - west + 1e-6) / 360.0)
        step_px = lattice.step_deg * self._scale
        down = _Taps((north - latitude) * self._scale, step_px, self._shown.shape[0], self._smooth)
        across = _Taps((longitude - west) * self._scale, step_px, self._shown.shape[1], self._smooth)
        if not len(down.pixels) or not len(across.pixels):
            return
        box = slice(down.pixels[0], down.pixels[-1] + 1), slice(across.pixels[0], across.pixels[-1] + 1)
        for row, by_row in down.taps:
            for column, by_column in across.taps:
                part = np.ix_(row, column)
                weight = np.where(there[part], by_row[:, None] * by_column, 0.0).astype(np.float32)
                found = values[part]
                wide = weight.reshape(weight.shape + (1,) * (found.ndim - 2))
                self._sum[box] += wide * np.where(wide > 0.0, found, 0)
                self._weight[box] += weight
        near = there[np.ix_(down.nearest, across.nearest)]
        self._shown[box] |= near & (down.inside[:, None] & across.inside)

    def onto(self, picture: NDArray[Any]) -> None:
        """Over what a picture shows so far."""
        shown = self._shown & (self._weight > 0.0)
        weight = self._weight[shown]
        picture[shown] = self._sum[shown] / weight.reshape(weight.shape + (1,) * (picture.ndim - 2))


class _Taps:
    """Of pixels along one side of a picture the samples that they show. at: places of samples, pixels, going up;
    step_px: between samples where there is one alone."""

    def __init__(self, at: Floats, step_px: float, count: int, smooth: bool) -> None:
        before = max(at[1] - at[0] if len(at) > 1 else step_px, 1.0)
        after = max(at[-1] - at[-2] if len(at) > 1 else step_px, 1.0)
        around = np.concatenate([[at[0] - before], at, [at[-1] + after]])
        self.pixels: Ints = np.arange(
            max(int(np.floor(around[0])), 0), min(int(np.ceil(around[-1])), count), dtype=np.int64
        )
        middles = self.pixels + 0.5
        k = np.clip(np.searchsorted(around, middles, side="right") - 1, 0, len(at))
        apart = around[k + 1] - around[k]
        t = np.clip((middles - around[k]) / apart, 0.0, 1.0)
        last = len(at) - 1
        nearest = np.where(t < 0.5, k - 1, k)
        self.inside: NDArray[np.bool_] = (nearest >= 0) & (nearest <= last)
        """Whether the nearest sample is one of the tile's."""
        self.nearest: Ints = np.clip(nearest, 0, last)
        t = np.where((apart > 1.0) & smooth, t, np.where(t < 0.5, 0.0, 1.0))
        inner = np.where((k > 0) & (k <= last), 1.0, _BEYOND)
        self.taps: tuple[tuple[Ints, Floats], ...] = (
            (np.clip(k - 1, 0, last), inner * np.where(k > 0, 1.0 - t, 0.0)),
            (np.clip(k, 0, last), inner * np.where(k <= last, t, 0.0)),
        )
        """Two samples of each pixel, and their shares."""
