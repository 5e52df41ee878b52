"""Rows and columns of blocks and pages as arrays: which are among which, and which lie around them."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice

__all__ = ["among", "inner", "keys_of", "names_of", "numbers_of", "parents_of", "reached_by"]

Ints = NDArray[np.int64]


def names_of(keys: Ints) -> Ints:
    """One number a block (..., 2), in the order of rows and columns."""
    names: Ints = (keys[..., 0] << 32) + keys[..., 1] + (1 << 31)
    return names


def keys_of(names: Ints) -> Ints:
    """(..., 2) rows and columns of names (...)."""
    return np.stack([names >> 32, (names & 0xFFFFFFFF) - (1 << 31)], axis=-1)


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
    return keys_of(np.unique(names_of(keys[:, :2] // factor)))


def reached_by(lattice: Lattice, keys: Ints, side: int) -> Ints:
    """Blocks (M, 2), sorted: those of `keys` (N, 2) and those around them, within the world. Numbers are sorted, since
    sorting pairs takes ten times as long; and of a million blocks all nine around each would be 150 MB."""
    columns = -(-lattice.period // side) if lattice.period else 0
    names, row = names_of(keys[:, :2]), 1 << 32
    names = np.unique(np.concatenate([names - row, names, names + row]))
    found = keys_of(names[(names >= 0) & (names >> 32 <= int((lattice.down - lattice.phase_y) // side))])
    parts = []
    for step in (-1, 0, 1):
        column = found[:, 1] + step
        parts.append(np.stack([found[:, 0], column % columns if columns else column], axis=1))
    if columns > 1:  # the last one is narrow: what is beside its neighbour is beside it as well
        for part in parts[:3]:
            for a, b in ((columns - 2, 0), (0, columns - 2)):
                parts.append(part[part[:, 1] == a] + (0, b - a))
    return keys_of(np.unique(np.concatenate([names_of(part) for part in parts])))


def inner(lattice: Lattice, keys: Ints, full: Ints, side: int) -> NDArray[np.bool_]:
    """Of which of blocks `keys` (N, 2) all around are among `full` (M, 2)."""
    known, columns = np.sort(names_of(full)), -(-lattice.period // side) if lattice.period else 0
    found = np.ones(len(keys), dtype=np.bool_)
    for down, across in product((-1, 0, 1), repeat=2):
        beside = keys[:, :2] + (down, across)
        if columns:
            beside[:, 1] %= columns
        found &= among(names_of(beside), known)
    return found
