"""Which tiles to make, most urgent first: those that the selection lacks, and what comes next."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .hulls import Hulls, visible_share
from .keys import children_of
from .nodes import UNKNOWN, NodeTable, node_shape
from .refinement import STEP

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Mask = NDArray[np.bool_]

FINER_ERROR = 0.5
"""The error of an unknown child as a fraction of its parent's."""
AHEAD_S = 1.0
"""What will be needed in this time, at the same velocity, is made in advance."""
AHEAD_CALLS = 4
"""... looked for in every fourth call."""
AHEAD_URGENCY = 0.25
OUT_OF_VIEW_URGENCY = 0.5
MAX_WANTED = 256
MAX_FORESEEN = 16
"""Of so many most urgent nodes two levels are wanted at once,"""
SURE = 2.0
"""... of children whose predicted error is so many times the wanted one."""


class Known(NamedTuple):
    """What follows from the facts of all nodes, row by row of the table."""

    hulls: Hulls
    weights: Floats
    """Share of a node times its distance, metres."""
    kids_known: Mask
    missing_roots: Ints
    """Keys."""


class Foresight:
    """Names tiles to make, and marks in the table what may still be of use. `occluder`: radius of the hiding sphere."""

    def __init__(self, table: NodeTable, occluder: float) -> None:
        self.table, self.occluder = table, occluder
        self._ahead: tuple[Ints, Floats] = np.zeros(0, np.int64), np.zeros(0)

    def wanted(
        self,
        known: Known,
        share: Floats,
        lacking: Mask,
        drawn: Mask,
        eye: Floats,
        velocity: Floats | None,
        planes: Floats | None,
        call: int,
    ) -> Ints:
        """What to make, most urgent first."""
        table, hulls, kids_known = self.table, known.hulls, known.kids_known
        needed = np.flatnonzero(lacking)
        urgency = self._urgency(share, needed)
        if planes is not None and len(needed):
            middle = 0.5 * (table.low + table.high)[needed]
            around = table.reach[needed] * table.high[needed] + (table.high - table.low)[needed]
            side = (table.planes[0, needed] * middle[:, None] - eye) @ planes.T
            urgency = urgency * np.where((side < -around[:, None]).any(axis=1), OUT_OF_VIEW_URGENCY, 1.0)
        if velocity is not None and velocity.any():
            if call % AHEAD_CALLS == 0:
                ahead = known.weights / np.maximum(hulls.distance(eye + velocity * AHEAD_S), 1e-3)
                soon = drawn & (ahead > 1.0) & (share <= 1.0)
                table.used[table.kids[np.flatnonzero(soon & kids_known)]] = call + AHEAD_CALLS
                later = np.flatnonzero(soon & ~kids_known)
                self._ahead = later, AHEAD_URGENCY * np.minimum(ahead[later], 4.0)
            later, priority = self._ahead
            still = drawn[later] & ~kids_known[later] & (share[later] <= 1.0)
            needed = np.concatenate([needed, later[still]])
            urgency = np.concatenate([urgency, priority[still]])
        missing = known.missing_roots
        if not len(needed):
            return missing
        order = np.argsort(-urgency, kind="stable")[: MAX_WANTED // 2]
        rows = needed[order]
        lacks = table.kids[rows] == UNKNOWN
        table.used[table.kids[rows][~lacks]] = call
        first = children_of(table.key[rows])[lacks]
        second = self._foreseen(known, rows, share[rows], lacks, eye)
        return np.concatenate([missing, first, second])[:MAX_WANTED]

    def _urgency(self, share: Floats, needed: Ints) -> Floats:
        """Shares of nodes, but more than those of the nodes that wait for them."""
        if not len(needed):
            return np.zeros(0)
        supports = self.table.supports
        share = share.copy()
        rows = np.flatnonzero(share > 1.0)
        while len(rows):
            to, least = supports[rows], STEP * share[rows][:, None]
            row, column = np.nonzero((share[to] < least) & (to > UNKNOWN))
            rows = to[row, column]
            np.maximum.at(share, rows, least[row, 0])
        return share[needed]

    def _foreseen(self, known: Known, rows: Ints, share: Floats, missing: Mask, eye: Floats) -> Ints:
        """Children of missing children that will want to be split for all that is known: more levels at once."""
        table = self.table
        near = np.flatnonzero(share * FINER_ERROR > SURE)[:MAX_FORESEEN]
        if not len(near):
            return np.zeros(0, np.int64)
        parent, number = np.nonzero(missing[near])
        if not len(parent):
            return np.zeros(0, np.int64)
        rows = rows[near][parent]
        keys = children_of(table.key[rows])[np.arange(len(rows)), number]
        center, reach, normals = node_shape(table.scheme, keys)
        low, high = table.low[rows] - table.error_m[rows], table.high[rows] + table.error_m[rows]
        hulls = Hulls.of(center, reach, normals, low, high, self.occluder)
        distance = np.maximum(hulls.distance(eye), 1e-3)
        found = FINER_ERROR * known.weights[rows] * visible_share(distance, eye, hulls, self.occluder) / distance
        return children_of(keys[found > SURE]).ravel()
