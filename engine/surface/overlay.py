"""The overlay of two selections: the finer of both everywhere, and where each cell lies in either.

On a snap the ground changes from one selection's triangles to another's. The overlay has all vertices of both, so it
can take on either surface, and lead from one to the other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .lattice import FULL_BITS, cell_corners
from .selection import CellSet, cell_keys

Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
_EDGE_CORNERS = np.array([[0, 2], [1, 3], [0, 1], [2, 3]])
"""Of edges i - 1, i + 1, j - 1, j + 1."""


@dataclass(frozen=True, eq=False)
class Overlay:
    """Cells that cover what the new selection covers."""

    cells: CellSet
    old_row: Ints
    """(N,): the old selection's cell that contains each; -1 where it has none."""
    new_row: Ints
    """(N,): the new selection's cell that contains each."""


def overlay(old: CellSet, new: CellSet) -> Overlay:
    """Of two selections with the same number of quads."""
    in_old, in_new = _containing(new, old), _containing(old, new)
    # Old cells that lie within a coarser new one take its place, if they cover all of it.
    finer = (in_new >= 0) & (old.level > new.level[np.maximum(in_new, 0)])
    rows = np.flatnonzero(finer)
    share = np.zeros(len(new))
    np.add.at(share, in_new[rows], 0.25 ** (old.level[rows] - new.level[in_new[rows]]).astype(np.float64))
    whole = share == 1.0  # sums of powers of two are exact
    rows = rows[whole[in_new[rows]]]
    kept = np.flatnonzero(~whole)
    columns = {
        name: np.concatenate([getattr(new, name)[kept], getattr(old, name)[rows]])
        for name in ("face", "level", "i", "j", "edge_delta", "spacing_m", "distance_m")
    }
    order = np.argsort(columns["distance_m"], kind="stable")
    cells = CellSet(
        **{name: column[order] for name, column in columns.items()},
        quads=new.quads,
        spacing_angle_rad=new.spacing_angle_rad,
    )
    old_row = np.concatenate([in_old[kept], rows])[order]
    new_row = np.concatenate([kept, in_new[rows]])[order]
    return Overlay(cells, old_row, new_row)


def held_edges(cells: CellSet, beside: Ints, still: Bools) -> Bools:
    """(N, 4): the edges along which some cell of `still` (N,) lies on either side; all of an edge, and with it the
    edges of all finer cells beyond. beside (N, 4): engine.surface.decimation.Topology's."""
    held = np.repeat(still[:, None], 4, axis=1)
    rows, edges = np.nonzero(beside >= 0)
    others = beside[rows, edges]
    # Nothing is handed on beyond the neighbours of still cells.
    near = still.copy()
    near[others[still[rows]]] = near[rows[still[others]]] = True
    pairs = near[others]
    rows, edges, others = rows[pairs], edges[pairs], others[pairs]
    if not len(rows):
        return held
    # Which of the neighbour's edges it is: the great circle that passes through the middle of ours.
    middle = _edges(cells, rows)[np.arange(len(rows)), edges].sum(axis=1)
    corners = _edges(cells, others)
    circle = np.cross(corners[:, :, 0], corners[:, :, 1])
    circle /= np.linalg.norm(circle, axis=-1, keepdims=True)
    facing = np.abs((circle * middle[:, None]).sum(axis=-1)).argmin(axis=1)
    while True:
        ours, theirs = held[rows, edges], held[others, facing]
        if np.array_equal(ours, theirs):
            return held
        held[rows[theirs], edges[theirs]] = True
        held[others[ours], facing[ours]] = True


def _edges(cells: CellSet, rows: Ints) -> NDArray[np.float64]:
    """Ends of the four edges of cells, (n, 4, 2, 3)."""
    return cell_corners(cells.face[rows], cells.level[rows], cells.i[rows], cells.j[rows])[:, _EDGE_CORNERS]


def _containing(inner: CellSet, outer: CellSet) -> Ints:
    """For each of `inner` the row of `outer` that contains it or equals it; -1 for none."""
    key, start = cell_keys(inner), cell_keys(outer)
    order = np.argsort(start)
    row = order[np.maximum(np.searchsorted(start[order], key, side="right") - 1, 0)]
    size = np.int64(1) << 2 * (FULL_BITS - outer.level[row].astype(np.int64))
    inside = (key >= start[row]) & (key - start[row] < size) & (inner.level >= outer.level[row])
    return np.where(inside, row, -1)
