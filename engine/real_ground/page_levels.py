"""The levels of a set, from its finest one in memory: each a quarter as fine as the one before, or what divides the
columns around the world."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice, directions_at
from .pages import PageLevel, pages_of
from .raw_level import RawLevel, factor_of
from .real_ground import World, sample_level

__all__ = ["heights_of", "levels_of", "next_factor"]

_WIDEST_STEP_DEG = 0.14
"""Levels end at samples so far apart: the margin of the last one is 1000 km wide on Earth."""


def next_factor(lattice: Lattice) -> int:
    """How many samples of a level make one of the next; 0: it is the last."""
    return factor_of(lattice) if lattice.step_deg < _WIDEST_STEP_DEG else 0


def levels_of(raw: RawLevel, exact: bool) -> list[tuple[PageLevel, int]]:
    """Pages of a set's levels, the coarsest first, and how many times finer each is than the next. exact: the finest
    one holds the samples of files."""
    raws, factors = [raw], []
    while raws[-1].blocks and (factor := next_factor(raws[-1].lattice)):
        factors.append(factor)
        raws.append(raws[-1].coarser(factor))
    factors.append(0)
    found: list[tuple[PageLevel, int]] = []
    coarser: PageLevel | None = None
    for number in range(len(raws) - 1, -1, -1):
        level = pages_of(raws[number], None if coarser is None else heights_of(coarser), exact and number == 0)
        if level is None:
            return []
        found.append((level, factors[number]))
        coarser = level
    return found


def heights_of(level: PageLevel) -> Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]:
    """Heights (N,) of a level at latitudes and longitudes (N,), NaN where it has none."""

    def heights(latitude_deg: NDArray[np.float64], longitude_deg: NDArray[np.float64]) -> NDArray[np.float64]:
        world = World(directions_at(latitude_deg, longitude_deg))
        out = np.full(len(latitude_deg), np.nan)
        found = sample_level(level, world, np.arange(len(out)))
        if found is not None:
            out[found.at] = found.height
        return out

    return heights
