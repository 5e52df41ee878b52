"""What a forest is told and what it answers."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class NodeFacts:
    """What is measured of a node's ground, (N,) each; heights above the reference sphere in metres."""

    low_m: Floats
    high_m: Floats
    error_m: Floats
    """Largest distance of the true ground from the node's mesh."""


@dataclass(frozen=True, eq=False)
class Selection:
    """Tiles to draw, nearest first, and tiles to make. Arrays have N rows and are not to be written."""

    keys: Ints
    """(N,)."""
    morph: NDArray[np.float32]
    """(N,): 1 as the parent looks, 0 as the tile itself does."""
    edge_skip: NDArray[np.uint8]
    """(N, E): by how many levels the neighbour is coarser; vertices are rounded down to multiples of 2^skip."""
    edge_morph: NDArray[np.float32]
    """(N, E): the morph of an edge; the same for both tiles of one level, 0 where levels differ."""
    distance_m: Floats
    """(N,), to the nearest point of the tile's hull."""
    wanted: Ints
    """(M,): tiles to make, most urgent first, parents before children."""
    moving: bool
    """Whether morphs still run, or would if time went on."""
    revision: int
    """Grows when keys, skips or morphs change."""
    error_px: float
    """The error that was allowed: the wanted one, or more to stay within max_tiles."""
    levels: Ints = field(default_factory=lambda: np.zeros(0, np.int64))
    """(N,)."""

    def __len__(self) -> int:
        return len(self.keys)
