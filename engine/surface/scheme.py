"""How the sphere is cut into a tree of cells: the protocol, and the tangent-warped cube's quadtree.

Roots cover the sphere; every cell has four children that cover it exactly; all edges are arcs of great circles, and
cells of a level meet edge to edge, across the borders of roots too. A node is an int64 key (see keys.py).
"""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import lattice
from .keys import child_number, children_of, level_of, pack_path, parent_of, path_of, root_of, roots_of

__all__ = ["QuadScheme", "Scheme", "compact_bits", "spread_bits"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Scheme(Protocol):
    """A way to cut the sphere; schemes inherit from it. Vectorised: keys are arrays (N,) of int64.

    The tree is the same for all schemes (keys.py): `root_keys()`, `level`, `parent`, `children`, `child_number`.
    """

    def root_keys(self) -> Ints:
        """(roots,)."""
        return roots_of(self.roots)

    level = staticmethod(level_of)
    parent = staticmethod(parent_of)
    children = staticmethod(children_of)
    child_number = staticmethod(child_number)

    name: str
    """For tables and messages."""
    roots: int
    """How many cells level 0 has."""
    edges: int
    """Edges, and corners, of a cell: E."""
    edge_corners: Ints
    """(E, 2): which two corners each edge lies between."""
    finest_level: int
    """The deepest level whose cells have corners on the integer lattice; at most keys.MAX_LEVEL."""

    def pack(self, root: ArrayLike, level: ArrayLike, i: ArrayLike, j: ArrayLike) -> Ints:
        """Keys from root, level and place in the root."""
        ...

    def unpack(self, keys: ArrayLike) -> tuple[Ints, Ints, Ints, Ints]:
        """(root, level, i, j)."""
        ...

    def neighbour(self, keys: ArrayLike, edge: ArrayLike) -> Ints:
        """The cells of the same level across an edge; keys and edge broadcast."""
        ...

    def corners(self, keys: ArrayLike) -> Floats:
        """(N, E, 3) unit vectors. Cells that share a corner have the same bits."""
        ...

    def center(self, keys: ArrayLike) -> Floats:
        """(N, 3) unit vectors, somewhere in the middle."""
        ...

    def at(self, directions: ArrayLike, level: ArrayLike) -> Ints:
        """The cells of a level that contain unit directions (N, 3)."""
        ...

    def spacing_rad(self, level: ArrayLike, segments: int) -> Floats:
        """Angle of the longest distance between neighbouring vertices of a tile with `segments` a side."""
        ...


def spread_bits(value: ArrayLike) -> Ints:
    """Put a zero bit before each of the lowest 32 bits."""
    value = np.asarray(value, dtype=np.int64)
    value = (value | value << 16) & 0x0000FFFF0000FFFF
    value = (value | value << 8) & 0x00FF00FF00FF00FF
    value = (value | value << 4) & 0x0F0F0F0F0F0F0F0F
    value = (value | value << 2) & 0x3333333333333333
    return (value | value << 1) & 0x5555555555555555


def compact_bits(value: ArrayLike) -> Ints:
    """Every other bit, the lowest among them: undoes `spread_bits`."""
    value = np.asarray(value, dtype=np.int64) & 0x5555555555555555
    value = (value | value >> 1) & 0x3333333333333333
    value = (value | value >> 2) & 0x0F0F0F0F0F0F0F0F
    value = (value | value >> 4) & 0x00FF00FF00FF00FF
    value = (value | value >> 8) & 0x0000FFFF0000FFFF
    return (value | value >> 16) & 0x00000000FFFFFFFF


class QuadScheme(Scheme):
    """The six quadtrees of the tangent-warped cube (lattice.py).

    Root = face; cell (i, j) of level L covers lattice points I in [i, i + 1] 2^(30 - L), J likewise. Child number
    i & 1 | (j & 1) << 1. Corners (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1); edges 0: i - 1, 1: i + 1, 2: j - 1,
    3: j + 1.
    """

    name = "quadtree"
    roots = 6
    edges = 4
    edge_corners: Ints = np.array([[0, 2], [1, 3], [0, 1], [2, 3]], dtype=np.int64)
    finest_level = 28

    def pack(self, root: ArrayLike, level: ArrayLike, i: ArrayLike, j: ArrayLike) -> Ints:
        """Keys from face, level and cell."""
        return pack_path(root, level, spread_bits(i) | spread_bits(j) << 1)

    def unpack(self, keys: ArrayLike) -> tuple[Ints, Ints, Ints, Ints]:
        """(face, level, i, j)."""
        path = path_of(keys)
        return root_of(keys), level_of(keys), compact_bits(path), compact_bits(path >> 1)

    def neighbour(self, keys: ArrayLike, edge: ArrayLike) -> Ints:
        """The cells of the same level across an edge."""
        face, level, i, j = self.unpack(keys)
        face, i, j = lattice.neighbour(face, level, i, j, edge)
        return self.pack(face, level, i, j)

    def corners(self, keys: ArrayLike) -> Floats:
        """(N, 4, 3)."""
        face, level, i, j = self.unpack(keys)
        size = np.int64(1) << (lattice.FULL_BITS - level)[..., None]
        i_full = (i[..., None] + np.array([0, 1, 0, 1])) * size
        j_full = (j[..., None] + np.array([0, 0, 1, 1])) * size
        return lattice.direction_of(*lattice.canonical_lattice(face[..., None], i_full, j_full))

    def center(self, keys: ArrayLike) -> Floats:
        """(N, 3), the middle in lattice coordinates."""
        return lattice.cell_center(*self.unpack(keys))

    def at(self, directions: ArrayLike, level: ArrayLike) -> Ints:
        """The cells of a level that contain directions (N, 3)."""
        face, i, j = lattice.cell_of(directions, level)
        return self.pack(face, level, i, j)

    def spacing_rad(self, level: ArrayLike, segments: int) -> Floats:
        """A segment's length along the middle of a face; nowhere are vertices farther apart."""
        return (np.pi / 2) / segments * np.exp2(-np.asarray(level, dtype=np.float64))
