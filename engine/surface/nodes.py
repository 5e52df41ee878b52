"""The nodes of a forest whose facts are known: rows of arrays, with links between them.

Row 0 stands for what is never missing (the parent of a root), row 1 for what is unknown. So links can be followed
without asking whether they lead anywhere.

A node depends on its parent and on the parents of its neighbours, its `supports`: where all of them are split, all its
neighbours exist, and splitting it makes no neighbours that differ by two levels.
"""

import numpy as np
from numpy.typing import NDArray

from .keys import child_number, children_of, level_of, parent_of
from .scheme import Scheme

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

GIVEN, UNKNOWN = 0, 1
"""The two rows that are no nodes."""
ROOM = 256
"""The arrays grow by so many rows; all of them are looked at in each selection."""
SUPPORTS = 3
"""A child has at most two outer edges: its parent, and the parents of two neighbours."""


class NodeTable:
    """Known nodes. Rows are stable while a node is known; freed rows are used again."""

    def __init__(self, scheme: Scheme, balanced: bool) -> None:
        self.scheme = scheme
        self.balanced = balanced
        self.rows: dict[int, int] = {}
        self._free: list[int] = []
        self._used = 2
        self._allocate(ROOM)

    def __len__(self) -> int:
        return len(self.rows)

    def _allocate(self, size: int) -> None:
        edges = self.scheme.edges
        fresh = {
            "key": np.zeros(size, np.int64),
            "level": np.zeros(size, np.int64),
            "low_m": np.zeros(size),
            "high_m": np.zeros(size),
            "error_m": np.zeros(size),
            "capped_m": np.zeros(size),
            "planes": np.zeros((1 + edges, size, 3)),
            "reach": np.zeros(size),
            "low": np.zeros(size),
            "high": np.zeros(size),
            "tangent": np.zeros(size),
            "neighbour_keys": np.zeros((size, edges), np.int64),
            "beside": np.full((size, edges), UNKNOWN, np.int64),
            "support_keys": np.zeros((size, SUPPORTS), np.int64),
            "supports": np.full((size, SUPPORTS), UNKNOWN, np.int64),
            "kids": np.full((size, 4), UNKNOWN, np.int64),
            "known": np.zeros(size, bool),
            "split": np.zeros(size, bool),
            "morph": np.ones(size),
            "used": np.zeros(size, np.int64),
        }
        for name, array in fresh.items():
            if hasattr(self, name):
                old = getattr(self, name)
                where = (slice(None), slice(old.shape[1])) if name == "planes" else slice(len(old))
                array[where] = old
            setattr(self, name, array)
        self.supports[GIVEN] = GIVEN
        self.capped_m[GIVEN] = np.inf
        self.split[GIVEN] = True
        self.morph[GIVEN] = 0.0

    key: Ints
    level: Ints
    low_m: Floats
    high_m: Floats
    error_m: Floats
    capped_m: Floats
    """Errors, but a child's is less than its parent's by STEP."""
    planes: Floats
    """(1 + E, R, 3): centres, then inward normals of the planes through the centre of the sphere and each edge."""
    reach: Floats
    """Chord from the centre to the farthest corner."""
    low: Floats
    """Radii between which the node's mesh lies."""
    high: Floats
    tangent: Floats
    """See Hulls."""
    neighbour_keys: Ints
    """(R, E)."""
    beside: Ints
    """(R, E): rows of the neighbours."""
    support_keys: Ints
    supports: Ints
    """(R, 3): rows of the parent and of two neighbours' parents; GIVEN where there is none."""
    kids: Ints
    """(R, 4)."""
    known: NDArray[np.bool_]
    split: NDArray[np.bool_]
    """Whether the children are drawn instead (or theirs)."""
    morph: Floats
    """Of the children: 1 as this node looks, 0 as they do."""
    used: Ints
    """The last call in which it was of use."""

    def find(self, keys: Ints) -> Ints:
        """Rows of keys, UNKNOWN where there is none; GIVEN for NO_NODE."""
        get = self.rows.get
        flat = [get(k, UNKNOWN) if k else GIVEN for k in keys.ravel().tolist()]
        return np.array(flat, dtype=np.int64).reshape(keys.shape)

    def add(self, keys: Ints, low_m: Floats, high_m: Floats, error_m: Floats) -> Ints:
        """Rows of nodes, made where they are new."""
        rows = self.find(keys)
        new = np.unique(keys[rows == UNKNOWN])
        if len(new):
            self._insert(new)
            rows = self.find(keys)
        self.low_m[rows], self.high_m[rows], self.error_m[rows] = low_m, high_m, error_m
        return rows

    def _insert(self, keys: Ints) -> None:
        rows = self._take(keys)
        scheme = self.scheme
        self.key[rows], self.level[rows] = keys, level_of(keys)
        self.known[rows], self.split[rows], self.morph[rows], self.used[rows] = True, False, 1.0, 0
        self.capped_m[rows] = -1.0
        self.planes[0, rows], self.reach[rows], normals = node_shape(scheme, keys)
        self.planes[1:, rows] = normals.transpose(1, 0, 2)
        beside = scheme.neighbour(keys[:, None], np.arange(scheme.edges))
        self.neighbour_keys[rows] = beside
        self.beside[rows] = self.find(beside)
        self.support_keys[rows] = self._support_keys(keys, beside)
        self.supports[rows] = self.find(self.support_keys[rows])
        kids = self.kids[rows] = self.find(children_of(keys))
        self._link(keys, rows, rows)
        # Links of nodes whose parent was unknown were not kept up to date: nothing depends on them.
        orphans = kids[kids > UNKNOWN]
        self.supports[orphans] = self.find(self.support_keys[orphans])

    def _support_keys(self, keys: Ints, beside: Ints) -> Ints:
        parent = parent_of(keys)
        if not self.balanced:
            return np.stack([parent, np.zeros_like(parent), np.zeros_like(parent)], axis=1)
        outer = parent_of(beside)
        outer = np.where(outer == parent[:, None], 0, outer)
        # Largest first: the zeros of inner edges go.
        outer = -np.sort(-outer, axis=1)
        return np.concatenate([parent[:, None], outer[:, : SUPPORTS - 1]], axis=1)

    def _link(self, keys: Ints, rows: Ints, to: Ints) -> None:
        """Point all links to these nodes at the rows `to`."""
        parents = self.find(parent_of(keys))
        inner = parents > UNKNOWN
        self.kids[parents[inner], child_number(keys[inner])] = to[inner]
        around = self.beside[rows]
        at, edge = np.nonzero(around > UNKNOWN)
        others = around[at, edge]
        # Neighbours meet at one edge: each has the other once.
        self.beside[others, (self.neighbour_keys[others] == keys[at][:, None]).argmax(axis=1)] = to[at]
        # Whoever may be supported by a node: its children, and those of its neighbours.
        below = np.concatenate([self.kids[rows], self.kids[around].reshape(len(rows), -1)], axis=1)
        own, column = np.nonzero(below > UNKNOWN)
        below = below[own, column]
        for k in range(SUPPORTS):
            on = self.support_keys[below, k] == keys[own]
            self.supports[below[on], k] = to[own[on]]

    def _take(self, keys: Ints) -> Ints:
        count = len(keys)
        missing = self._used + max(count - len(self._free), 0) - len(self.known)
        if missing > 0:
            self._allocate(len(self.known) + max(missing, ROOM))
        again = min(count, len(self._free))
        rows = [self._free.pop() for _ in range(again)] + list(range(self._used, self._used + count - again))
        self._used += count - again
        self.rows.update(zip(keys.tolist(), rows, strict=True))
        return np.array(rows, dtype=np.int64)

    def remove(self, keys: Ints) -> None:
        """Forget nodes; unknown keys are passed over."""
        keys = np.unique(keys)
        rows = self.find(keys)
        keys, rows = keys[rows > UNKNOWN], rows[rows > UNKNOWN]
        if not len(keys):
            return
        self._link(keys, rows, np.full(len(rows), UNKNOWN))
        for key in keys.tolist():
            del self.rows[key]
        self.known[rows], self.split[rows], self.morph[rows] = False, False, 1.0
        self.kids[rows], self.beside[rows] = UNKNOWN, UNKNOWN
        self.supports[rows], self.support_keys[rows], self.key[rows] = UNKNOWN, 0, 0
        self.used[rows] = 0
        self._free.extend(rows.tolist())


def node_shape(scheme: Scheme, keys: Ints) -> tuple[Floats, Floats, Floats]:
    """Centres (N, 3), chords from there to the farthest corners (N,), and normals of the edges (N, E, 3)."""
    corners, center = scheme.corners(keys), scheme.center(keys)
    reach = np.sqrt(((corners - center[:, None]) ** 2).sum(axis=2).max(axis=1))
    return center, reach, edge_normals(corners, center, scheme.edge_corners)


def edge_normals(corners: Floats, center: Floats, edge_corners: Ints) -> Floats:
    """Inward unit normals of the edges' planes, (N, E, 3), from corners (N, E, 3) and centres (N, 3)."""
    start, end = corners[:, edge_corners[:, 0]], corners[:, edge_corners[:, 1]]
    # From the difference: corners of small cells agree in most of their digits.
    normals = np.cross(start, end - start)
    normals /= np.sqrt((normals * normals).sum(axis=2))[..., None]
    inward = np.einsum("nek,nk->ne", normals, center)
    return normals * np.sign(inward)[..., None]
