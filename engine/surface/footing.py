"""The tiles that have to be there for fine ground at one place: a chain of nodes down to it, and what supports it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .keys import NO_NODE, children_of, level_of, parent_of
from .scheme import Scheme

Ints = NDArray[np.int64]


def footing(scheme: Scheme, direction: ArrayLike, level: int) -> Ints:
    """Keys of all tiles without which the tile of a level below a direction (3,) can't be drawn, parents first.

    To split a node its neighbours have to exist (nodes.py), so their parents have to be split, and so on upwards: a
    few dozen tiles a level.
    """
    deepest = scheme.at(np.asarray(direction, dtype=np.float64)[None], level)
    split = np.unique(parent_of(deepest))
    found = [deepest]
    while split[-1] != NO_NODE:
        found.append(children_of(split).ravel())
        beside = scheme.neighbour(split[:, None], np.arange(scheme.edges)).ravel()
        split = np.unique(parent_of(np.concatenate([split, beside])))
    keys = np.unique(np.concatenate([scheme.root_keys(), *found]))
    return keys[np.argsort(level_of(keys), kind="stable")]
