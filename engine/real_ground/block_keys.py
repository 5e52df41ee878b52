"""Rows and columns of blocks and pages as arrays: which are among which, and which lie around them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice

__all__ = ["among", "around", "inner", "names_of", "numbers_of", "parents_of", "reached_by"]

Ints = NDArray[np.int64]


def names_of(keys: Ints) -> Ints:
    """One number a block (..., 2), in the order of rows and columns."""
    names: Ints = (keys[..., 0] << 32) + keys[..., 1] + (1 << 31)
    return names


def numbers_of(names: Ints, known: Ints) -> Ints:
    """Where names (...) are among known ones (M,), which are sorted; -1: they aren't."""
    if not len(known):
        return np.full(names.shape, -1, np.int64)
    at = np.minimum(np.searchsorted(known, names), len(known) - 1)
    found: Ints = np.where(known[at] == names, at, -1)
    return found


def among(names: Ints, known: Ints) -> NDArray[np.bool_]:
    """Which of names (...) are among known ones (M,), which are sorted."""
    return numbers_of(names, known) >= 0


def parents_of(keys: Ints, factor: int) -> Ints:
    """Blocks (M, 2) of the next coarser level that blocks (N, 2) are in."""
    return np.unique(keys[:, :2] // factor, axis=0)


def around(lattice: Lattice, keys: Ints, side: int) -> Ints:
    """(N, 9, 2): blocks of `side` samples a side (N, 2) and those beside them, around the world."""
    columns = -(-lattice.period // side) if lattice.period else 0
    step = np.arange(-1, 2)
    beside = np.stack(np.meshgrid(step, step, indexing="ij"), axis=-1).reshape(-1, 2)
    found: Ints = keys[:, None, :2] + beside
    if columns:
        found[..., 1] %= columns
    return found


def reached_by(lattice: Lattice, keys: Ints, side: int) -> Ints:
    """Blocks (M, 2), sorted: those of `keys` (N, 2) and those around them, within the world."""
    columns = -(-lattice.period // side) if lattice.period else 0
    found = around(lattice, keys, side).reshape(-1, 2)
    found = found[(found[:, 0] >= 0) & (found[:, 0] <= int((lattice.down - lattice.phase_y) // side))]
    if columns > 1:  # the last one is narrow: what is beside its neighbour is beside it as well
        ends = (columns - 2, 0), (0, columns - 2)
        found = np.concatenate([found, *(found[found[:, 1] == a] + (0, b - a) for a, b in ends)])
    return np.unique(found, axis=0)


def inner(lattice: Lattice, keys: Ints, full: Ints, side: int) -> NDArray[np.bool_]:
    """Of which of blocks `keys` (N, 2) all around are among `full` (M, 2)."""
    known = np.sort(names_of(full))
    return np.asarray(among(names_of(around(lattice, keys, side)), known).all(axis=1), dtype=np.bool_)
