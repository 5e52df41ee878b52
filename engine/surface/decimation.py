"""Fewer vertices along the axis that is foreshortened: per-cell decimation of the rings.

A square cell far out on a plain is seen at a flat angle: its edges across the view have the wanted length in pixels,
those along the view a small fraction of it. So each cell may skip vertices along each of its axes, by powers of two.
How much it would like to skip is measured on its own displaced vertices (common/measure_cells.comp); what it may skip
follows from its neighbours, so that both sides of an edge use the same vertices. This module has the topology, the
rule (the oracle of common/agree_cells.comp) and the index lists.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .lattice import FACE_AXES
from .selection import CellSet, neighbours_of

Ints = NDArray[np.int64]

MOST = 3
"""A cell keeps at least every 8th vertex."""
VARIANTS = 2 * (MOST + 1) ** 2
"""Index lists: variant = 2 * (skip along i * (MOST + 1) + skip along j) + (1 where diagonals fall)."""


@dataclass(frozen=True, eq=False)
class Topology:
    """Who lies beside whom, row by row as the cells it was made for; edges 0: i - 1, 1: i + 1, 2: j - 1, 3: j + 1."""

    delta: Ints
    """(N, 4): by how many levels the neighbour is coarser; 0 where it is equal, finer or absent."""
    beside: Ints
    """(N, 4): the row of an equal or coarser neighbour, -1 for none."""
    axis: Ints
    """(N, 4): which axis of the neighbour, 0: i or 1: j, runs along the edge (other faces name it differently)."""
    bits: int
    """log2 of the quads along a cell's side."""

    def packed(self) -> NDArray[np.uint32]:
        """(N, 8) uint32 for the GPU: the four rows (0xffffffff: none), then delta | axis << 8 of the four edges."""
        rows = np.where(self.beside < 0, 0xFFFFFFFF, self.beside)
        return np.concatenate([rows, self.delta | self.axis << 8], axis=1).astype(np.uint32)


def topology(cells: CellSet) -> Topology:
    """The topology of a selection."""
    face, level, i, j = (a.astype(np.int64) for a in (cells.face, cells.level, cells.i, cells.j))
    delta, beside = neighbours_of(face, level, i, j)
    along = np.abs(FACE_AXES[face][:, [1, 1, 0, 0]])  # (N, 4, 3): edges 0 and 1 run along j, 2 and 3 along i
    first = np.abs(FACE_AXES[face[np.maximum(beside, 0)], 0])
    axis = np.where((along * first).sum(axis=-1) > 0, 0, 1)
    return Topology(delta, beside, axis, int(cells.quads).bit_length() - 1)


def agree(wanted: ArrayLike, cells: Topology) -> tuple[Ints, Ints]:
    """What the cells skip, (N, 2), and by which powers of two edge indices are rounded down, (N, 4), from what they
    want.

    Along an edge to a coarser neighbour a cell never skips more than the neighbour does; along one to an equal
    neighbour both use the coarser spacing. So the vertices on an edge are the same lattice points on both sides.
    """
    skip = np.minimum(np.asarray(wanted, dtype=np.int64), min(MOST, cells.bits))
    known, beside, delta, axis = cells.beside >= 0, np.maximum(cells.beside, 0), cells.delta, cells.axis
    coarser = known & (delta > 0)
    rows, edges = np.nonzero(coarser)
    limit = np.full_like(skip, cells.bits)
    np.minimum.at(limit, (beside[rows, edges], axis[rows, edges]), cells.bits - delta[rows, edges])
    skip = np.minimum(skip, limit)
    while True:
        allowed = np.where(coarser, delta + skip[beside, axis], cells.bits)
        fixed = np.minimum(skip, np.stack([allowed[:, 2:].min(axis=1), allowed[:, :2].min(axis=1)], axis=1))
        if np.array_equal(fixed, skip):
            break
        skip = fixed
    beyond = np.where(known, delta + skip[beside, axis], 0)
    return skip, np.maximum(skip[:, [1, 1, 0, 0]], beyond)


def variant_skips(variant: ArrayLike) -> tuple[Ints, Ints]:
    """By which powers of two cells of these variants skip along i and along j."""
    return np.divmod(np.asarray(variant, dtype=np.int64) >> 1, MOST + 1)


def falling(variant: ArrayLike, k: ArrayLike, l: ArrayLike, quads: int) -> NDArray[np.bool_]:
    """Whether the diagonal of quad (k along i, l along j), counted in steps of the variant, runs from its upper left to
    its lower right corner instead of the other way. k and l broadcast.

    All of a cell's do or none, but for the last quad: where both edges beside it are rounded down far enough, a falling
    diagonal would pass on the wrong side of the quad's first corner.
    """
    skip_i, skip_j = variant_skips(variant)
    last_k, last_l = (quads // np.minimum(1 << skip, quads) - 1 for skip in (skip_i, skip_j))
    last = (np.asarray(k) == last_k) & (np.asarray(l) == last_l)
    return (np.asarray(variant) % 2 == 1) & ~last


def decimated_indices(quads: int) -> tuple[NDArray[np.uint32], NDArray[np.uint32]]:
    """One index list for all variants, and (first, count) of each, (VARIANTS, 2).

    Triangles counter-clockwise seen from outside, on all faces; vertex (k along i, l along j) has index
    l (quads + 1) + k.
    """
    lists: list[NDArray[np.uint32]] = []
    ranges: list[tuple[int, int]] = []
    first = 0
    for variant in range(VARIANTS):
        step_i, step_j = (min(1 << int(skip), quads) for skip in variant_skips(variant))
        k, l = (n.ravel() for n in np.meshgrid(np.arange(quads // step_i), np.arange(quads // step_j)))
        a = l * step_j * (quads + 1) + k * step_i
        b, c = a + step_i, a + step_j * (quads + 1)
        d = c + step_i
        rise, fall = np.stack([a, b, d, a, d, c], axis=1), np.stack([a, b, c, b, d, c], axis=1)
        lists.append(np.where(falling(variant, k, l, quads)[:, None], fall, rise).astype(np.uint32).ravel())
        ranges.append((first, lists[-1].size))
        first += lists[-1].size
    return np.concatenate(lists), np.array(ranges, np.uint32)
