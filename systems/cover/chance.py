"""Chance that hangs on integers alone: the same on every machine, wherever it is asked from."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["draws", "patches"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_MIX = (np.uint64(0xFF51AFD7ED558CCD), np.uint64(0xC4CEB9FE1A85EC53))
_WORDS = (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB, 0xD6E8FEB86659FD93)


def _mixed(x: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """The finaliser of MurmurHash3 (Appleby, public domain)."""
    for factor in _MIX:
        x = (x ^ (x >> np.uint64(33))) * factor
    return x ^ (x >> np.uint64(33))


def draws(seed: int, face: Ints | int, i: Ints, j: Ints, count: int) -> Floats:
    """(count, ...) numbers of [0, 1), uniform and independent, for integer places (face, i, j)."""
    with np.errstate(over="ignore"):
        words = zip((seed, face, i, j), _WORDS, strict=True)
        x = np.zeros(np.broadcast(i, j).shape, dtype=np.uint64)
        for value, word in words:
            x = _mixed(x ^ (np.asarray(value).astype(np.int64).astype(np.uint64) * np.uint64(word)))
        out = [_mixed(x + np.uint64(k + 1) * np.uint64(_WORDS[0])) for k in range(count)]
    return np.stack([(o >> np.uint64(11)).astype(np.float64) * 2.0**-53 for o in out])


def patches(seed: int, face: Ints, x: Floats, y: Floats) -> Floats:
    """Smooth noise 0..1 of period 1 at places (x, y) of a face's lattice: value noise, for groups and clearings."""
    i, j = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    u, v = x - i, y - j
    u, v = u * u * (3.0 - 2.0 * u), v * v * (3.0 - 2.0 * v)
    corner = [[draws(seed, face, i + a, j + b, 1)[0] for b in (0, 1)] for a in (0, 1)]
    near = corner[0][0] + v * (corner[0][1] - corner[0][0])
    far = corner[1][0] + v * (corner[1][1] - corner[1][0])
    return near + u * (far - near)
