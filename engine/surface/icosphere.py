"""The integer lattice on the icosahedron: 20 roots of four children each, neighbours, canonical points.

The twelve corners are integer vectors with two neighbouring Fibonacci numbers for the golden ratio, so the solid is
regular to 1e-13 and nothing about it is rounded. A lattice point of a root with corners V0, V1, V2 has integers
a + b + c = FULL; its vector a V0 + b V1 + c V2 is an integer vector below 2^53, exact in float64 whatever the order of
the sum and with or without fused multiply-add. The point's direction is a function of that vector alone, and on the 30
edges and 12 corners both sides have the same vector: it is the canonical name of a point.

Why flat coordinates: the lines of the lattice are great circles (a cell is the hull of its corners, pushed out to
the sphere), the inverse is a 3 x 3 product, sums are exact. Cells of a level differ in area by a factor of 1.98 (the
cube's: 1.41); dividing edges by equal angles, P = sum of sin(a_i) V_i, would bring 1.18, no straight lines and no
closed inverse, for 3 % fewer triangles at equal longest edges. A selection looks at the true size of each cell
anyhow.

Nodes are (root, level, i, j, o): with n = 2**level cells along an edge and b, c counted in cells, the upright one
(o = 0) has corners (i, j), (i + 1, j), (i, j + 1), the inverted one (o = 1) (i + 1, j + 1), (i, j + 1), (i + 1, j):
the upright one turned by half a turn. Corners are counter-clockwise seen from outside; edge e runs from corner e to
corner e + 1. Everything is vectorised.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .keys import MAX_LEVEL, level_of, pack_path, path_of, root_of
from .scheme import Scheme, compact_bits, spread_bits

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FULL_BITS = 30
FULL = 1 << FULL_BITS

SHORT, LONG = 2178309, 3524578
"""Fibonacci numbers 32 and 33. Their ratio is the golden one to 1e-13."""


def _corners() -> Ints:
    corners = []
    for axis in range(3):
        for first in (SHORT, -SHORT):
            for second in (LONG, -LONG):
                corner = [0, 0, 0]
                corner[(axis + 1) % 3], corner[(axis + 2) % 3] = first, second
                corners.append(corner)
    return np.array(corners, dtype=np.int64)


CORNERS: Ints = _corners()
"""(12, 3): the corners of the icosahedron, in planet axes, as integers."""
CORNERS.setflags(write=False)


def _roots() -> Ints:
    """All triples of corners that are neighbours of one another, the lowest first, counter-clockwise."""
    squares = ((CORNERS[:, None] - CORNERS[None]) ** 2).sum(axis=2)
    # Five edges are exactly 2 SHORT long, the rest differ from that by parts in 1e13.
    near = (squares > 0) & (squares < 6 * SHORT**2)
    found = []
    for a in range(12):
        for b in range(a + 1, 12):
            for c in range(b + 1, 12):
                if near[a, b] and near[b, c] and near[a, c]:
                    turned = np.linalg.det(CORNERS[[a, b, c]].astype(np.float64)) > 0
                    found.append([a, b, c] if turned else [a, c, b])
    return np.array(found, dtype=np.int64)


ROOTS: Ints = _roots()
"""(20, 3): which corners are V0, V1, V2 of each root; V0 is the lowest."""
ROOTS.setflags(write=False)
ROOT_VECTORS: Ints = CORNERS[ROOTS]
"""(20, 3, 3): V0, V1, V2 of each root as rows."""
_VECTORS_F: Floats = ROOT_VECTORS.astype(np.float64)
_INVERSES: Floats = np.linalg.inv(_VECTORS_F).astype(np.float64)  # direction @ inverse = weights of V0, V1, V2
_NORMALS: Floats = np.asarray(_VECTORS_F.sum(axis=1) / np.sqrt((_VECTORS_F.sum(axis=1) ** 2).sum(axis=1))[:, None])

EDGE_OVER_HEIGHT = float(2 * SHORT / np.linalg.norm(_VECTORS_F[0].mean(axis=0)))
"""Length of an edge over the distance of a root's plane from the centre, 1.3232: the longest vertex spacing is this
angle over the number of segments along a root's edge; the shortest is 0.68 times as long."""


def _across() -> tuple[Ints, Ints]:
    """Root and edge beside each edge of each root, (20, 3) each. Both run along it in opposite directions."""
    root, edge = np.zeros((20, 3), np.int64), np.zeros((20, 3), np.int64)
    where = {(int(ROOTS[r, e]), int(ROOTS[r, (e + 1) % 3])): (r, e) for r in range(20) for e in range(3)}
    for (a, b), (r, e) in where.items():
        root[r, e], edge[r, e] = where[b, a]
    return root, edge


ACROSS_ROOT, ACROSS_EDGE = _across()


def vector_of(root: ArrayLike, b: ArrayLike, c: ArrayLike) -> Ints:
    """The integer vectors (..., 3) of lattice points: their canonical names. b and c count from V0, b + c <= FULL."""
    root, b, c = (np.asarray(x, dtype=np.int64) for x in (root, b, c))
    v = ROOT_VECTORS[root]
    a = FULL - b - c
    return a[..., None] * v[..., 0, :] + b[..., None] * v[..., 1, :] + c[..., None] * v[..., 2, :]


def unit(vectors: ArrayLike) -> Floats:
    """Directions (..., 3) of integer vectors, operation by operation as the shader does it."""
    v = np.asarray(vectors).astype(np.float64)
    length = np.sqrt(v[..., 0] * v[..., 0] + v[..., 1] * v[..., 1] + v[..., 2] * v[..., 2])
    return v / length[..., None]


def direction_of(root: ArrayLike, b: ArrayLike, c: ArrayLike) -> Floats:
    """Unit directions (..., 3) of lattice points; the same bits from each root that contains the point."""
    return unit(vector_of(root, b, c))


def locate(directions: ArrayLike) -> tuple[Ints, Floats, Floats]:
    """Root and fractional lattice coordinates (root, b, c) of directions (..., 3), which need not be unit vectors.

    b, c >= 0 and b + c <= FULL, good to about 4e-7 of a lattice step.
    """
    direction = np.asarray(directions, dtype=np.float64)
    root = np.argmax(direction @ _NORMALS.T, axis=-1)
    weights = np.maximum((direction[..., None, :] @ _INVERSES[root])[..., 0, :], 0.0)
    weights = weights * (FULL / weights.sum(axis=-1, keepdims=True))
    b, c = weights[..., 1], weights[..., 2]
    over = np.maximum(b + c - FULL, 0.0)  # by rounding
    return root, np.where(b >= c, b - over, b), np.where(b >= c, c, c - over)


def snap(directions: ArrayLike) -> tuple[Ints, Ints, Ints]:
    """A lattice point (root, b, c) less than one step away from each direction."""
    root, b, c = locate(directions)
    whole_b, whole_c = np.rint(b).astype(np.int64), np.rint(c).astype(np.int64)
    over = np.maximum(whole_b + whole_c - FULL, 0)
    return root, whole_b - np.where(whole_b >= whole_c, over, 0), whole_c - np.where(whole_b >= whole_c, 0, over)


# Corners of the upright cell in cells, and of the inverted one.
_UPRIGHT = np.array([[0, 0], [1, 0], [0, 1]])
_CORNER_B = np.stack([_UPRIGHT[:, 0], 1 - _UPRIGHT[:, 0]])
_CORNER_C = np.stack([_UPRIGHT[:, 1], 1 - _UPRIGHT[:, 1]])
# Where the neighbour across edge e lies: of the upright cell below, beyond the slanted edge, and left.
_STEP_I, _STEP_J = np.array([0, 0, -1]), np.array([-1, 0, 0])


class TriangleScheme(Scheme):
    """The icosphere's 20 trees of triangles.

    In `pack` and `unpack` j carries the orientation in its lowest bit: j = 2 * row + o. Children 0 to 2 lie at the
    corners of the same number, child 3 in the middle, turned by half a turn. Edge e runs from corner e to e + 1.
    """

    name = "icosphere"
    roots = 20
    edges = 3
    edge_corners: Ints = np.array([[0, 1], [1, 2], [2, 0]], dtype=np.int64)
    finest_level = MAX_LEVEL

    def pack(self, root: ArrayLike, level: ArrayLike, i: ArrayLike, j: ArrayLike) -> Ints:
        """Keys of nodes; j = 2 * row + o."""
        i, j, level = (np.asarray(x, dtype=np.int64) for x in (i, j, level))
        row = j >> 1
        # A bit a level. Where i and row agree, the parent's orientation is that bit; elsewhere it is the node's own.
        # So orientations spread upwards from the leaf, whose own stands below the lowest bit.
        known = ~(i ^ row) << 1 | 1
        turned = (i << 1 & known) | (j & 1)
        for step in (1, 2, 4, 8, 16):
            turned = turned | (turned << step & ~known)
            known = known | known << step
        before, mask = turned >> 1, (np.int64(1) << level) - 1
        middle = ~(i ^ row) & (before ^ turned)
        low, high = ((i ^ before) | middle) & mask, ((row ^ before) | middle) & mask
        return pack_path(root, level, spread_bits(low) | spread_bits(high) << 1)

    def unpack(self, keys: ArrayLike) -> tuple[Ints, Ints, Ints, Ints]:
        """(root, level, i, j) of keys; j = 2 * row + o."""
        path = path_of(keys)
        low, high = compact_bits(path), compact_bits(path >> 1)
        # Every middle child turns what lies in it.
        turned = low & high
        for step in (1, 2, 4, 8, 16):
            turned = turned ^ turned >> step
        before = turned >> 1
        i, row = (low & ~high) ^ before, (high & ~low) ^ before
        return root_of(keys), level_of(keys), i, row << 1 | (turned & 1)

    def neighbour(self, keys: ArrayLike, edge: ArrayLike) -> Ints:
        """The node of the same level across an edge, across the edges of roots too."""
        return self.across(keys, edge)[0]

    def across(self, keys: ArrayLike, edge: ArrayLike) -> tuple[Ints, Ints]:
        """The node of the same level across an edge, and which of its edges that is. It runs the other way round."""
        root, level, i, j = self.unpack(keys)
        edge = np.asarray(edge, dtype=np.int64)
        root, level, i, j, edge = np.broadcast_arrays(root, level, i, j, edge)
        row, turned = j >> 1, j & 1
        count = np.int64(1) << level
        sign = 1 - 2 * turned
        next_i, next_row = i + sign * _STEP_I[edge], row + sign * _STEP_J[edge]
        last = i + row == count - 1
        outside = (turned == 0) & np.stack([row == 0, last, i == 0])[edge, *np.indices(edge.shape)]
        # How many cells the edge's start lies before this one: from V0 to V1, V1 to V2, V2 to V0.
        along = count - 1 - np.stack([i, row, count - 1 - row])[edge, *np.indices(edge.shape)]
        other = ACROSS_EDGE[root, edge]
        zero = np.zeros_like(along)
        pick = (other, *np.indices(edge.shape))
        border_i = np.stack([along, count - 1 - along, zero])[pick]
        border_row = np.stack([zero, along, count - 1 - along])[pick]
        new_root = np.where(outside, ACROSS_ROOT[root, edge], root)
        new_i, new_row = np.where(outside, border_i, next_i), np.where(outside, border_row, next_row)
        return self.pack(new_root, level, new_i, new_row << 1 | np.where(outside, 0, 1 - turned)), np.where(
            outside, other, edge
        )

    def corner_points(self, keys: ArrayLike) -> tuple[Ints, Ints, Ints]:
        """Root (...,) and lattice coordinates b and c (..., 3) of the corners of nodes."""
        root, level, i, j = self.unpack(keys)
        size = (np.int64(FULL) >> level)[..., None]
        b = (i[..., None] + _CORNER_B[j & 1]) * size
        c = ((j >> 1)[..., None] + _CORNER_C[j & 1]) * size
        return root, b, c

    def corners(self, keys: ArrayLike) -> Floats:
        """Unit directions (..., 3, 3) of the corners, counter-clockwise seen from outside."""
        root, b, c = self.corner_points(keys)
        return direction_of(root[..., None], b, c)

    def center(self, keys: ArrayLike) -> Floats:
        """Unit directions (..., 3) of the nodes' middles in lattice coordinates."""
        root, b, c = self.corner_points(keys)
        return unit(vector_of(root[..., None], b, c).sum(axis=-2))

    def spacing_rad(self, level: ArrayLike, segments: int) -> Floats:
        """The longest vertex spacing on a level as an angle, for nodes of so many segments a side."""
        return EDGE_OVER_HEIGHT / segments * np.exp2(-np.asarray(level, dtype=np.float64))

    def at(self, directions: ArrayLike, level: ArrayLike) -> Ints:
        """The nodes of a level that contain the directions (..., 3)."""
        root, b, c = locate(directions)
        level = np.asarray(level, dtype=np.int64)
        count = np.int64(1) << level
        x, y = b * (count / FULL), c * (count / FULL)
        i = np.minimum(np.floor(x).astype(np.int64), count - 1)
        row = np.minimum(np.floor(y).astype(np.int64), count - 1 - i)
        turned = ((x - i) + (y - row) > 1.0) & (i + row < count - 1)
        return self.pack(root, level, i, row << 1 | turned)
