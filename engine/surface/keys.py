"""Names of a tree's nodes: one int64 for root, level and path, in the order of a walk over the surface.

From the highest bit: the root, two bits of path a level (which child), a one, zeros (as S2 names its cells). So the
descendants of a node are an interval of keys around its own; sorted leaves lie along a space-filling curve, and a leaf
that contains a node is found by bisection. Nothing here knows how a scheme lays out its children.
All functions are vectorised over arrays of keys of any shape.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Ints = NDArray[np.int64]

MAX_LEVEL = 28
"""With 5 bits for up to 32 roots a key has 62 bits."""
NO_NODE = 0
"""What stands for no node, the parent of a root for one; no key is 0."""

_ROOT_SHIFT = 2 * MAX_LEVEL + 1


def pack_path(root: ArrayLike, level: ArrayLike, path: ArrayLike) -> Ints:
    """Keys of nodes from root, level and path: two bits a level, the child of the root in the highest."""
    root, level, path = (np.asarray(a, dtype=np.int64) for a in (root, level, path))
    below = 2 * (MAX_LEVEL - level)
    return root << _ROOT_SHIFT | path << (below + 1) | np.int64(1) << below


def roots_of(count: int) -> Ints:
    """The keys of the roots, (count,)."""
    return pack_path(np.arange(count), 0, 0)


def lowest_bit(keys: ArrayLike) -> Ints:
    """The one after the path: 4^(MAX_LEVEL - level)."""
    keys = np.asarray(keys, dtype=np.int64)
    return keys & -keys


def root_of(keys: ArrayLike) -> Ints:
    """The root that a node belongs to."""
    return np.asarray(keys, dtype=np.int64) >> _ROOT_SHIFT


def level_of(keys: ArrayLike) -> Ints:
    """0 for roots."""
    exponent = np.frexp(lowest_bit(keys).astype(np.float64))[1] - 1
    return (MAX_LEVEL - (exponent >> 1)).astype(np.int64)


def path_of(keys: ArrayLike) -> Ints:
    """Two bits a level, the child of the root in the highest."""
    keys = np.asarray(keys, dtype=np.int64)
    return (keys & ((np.int64(1) << _ROOT_SHIFT) - 1)) >> (2 * (MAX_LEVEL - level_of(keys)) + 1)


def child_number(keys: ArrayLike) -> Ints:
    """Which of its parent's four children a node is, 0 to 3; meaningless for roots."""
    keys = np.asarray(keys, dtype=np.int64)
    return keys // (2 * lowest_bit(keys)) & 3


def parent_of(keys: ArrayLike) -> Ints:
    """The parents; NO_NODE for roots."""
    keys = np.asarray(keys, dtype=np.int64)
    bit = lowest_bit(keys) << 2
    return np.where(bit > np.int64(1) << 2 * MAX_LEVEL, NO_NODE, (keys & -bit) | bit)


def ancestor_of(keys: ArrayLike, level: ArrayLike) -> Ints:
    """The ancestors of a level that is at most the nodes' own (a node itself counts)."""
    keys = np.asarray(keys, dtype=np.int64)
    bit = np.int64(1) << 2 * (MAX_LEVEL - np.asarray(level, dtype=np.int64))
    return (keys & -bit) | bit


_ODD = np.array([1, 3, 5, 7], dtype=np.int64)


def children_of(keys: ArrayLike) -> Ints:
    """(..., 4), children 0 to 3 in the order of the keys."""
    keys = np.asarray(keys, dtype=np.int64)
    bit = lowest_bit(keys)
    return (keys - bit)[..., None] + (bit >> 2)[..., None] * _ODD


def first_inside(keys: ArrayLike) -> Ints:
    """The smallest key in a node's subtree."""
    keys = np.asarray(keys, dtype=np.int64)
    return keys - lowest_bit(keys) + 1


def last_inside(keys: ArrayLike) -> Ints:
    """The largest key in a node's subtree."""
    keys = np.asarray(keys, dtype=np.int64)
    return keys + lowest_bit(keys) - 1


def container_of(keys: ArrayLike, leaves: Ints) -> Ints:
    """Where in `leaves` (sorted, none inside another) is the one that a node equals or lies in; -1 for none."""
    keys = np.asarray(keys, dtype=np.int64)
    if not len(leaves):
        return np.full(keys.shape, -1, dtype=np.int64)
    at = np.searchsorted(leaves, keys)
    before, after = np.maximum(at - 1, 0), np.minimum(at, len(leaves) - 1)
    # A node lies below or above its ancestor, never beyond the ancestor's neighbours in the order.
    found = np.where((first_inside(leaves[after]) <= keys) & (keys <= last_inside(leaves[after])), after, -1)
    return np.where((first_inside(leaves[before]) <= keys) & (keys <= last_inside(leaves[before])), before, found)
