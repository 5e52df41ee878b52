"""Which cells to draw: rings of cells around a direction whose spacing doubles with distance.

A cell is split while its vertex spacing is larger than the wanted angle times its distance, so on screen the spacing of
an unforeshortened surface lies between half the wanted number of pixels and that number. Nothing but the proxy decides:
all cells and vertices are lattice points, so a new selection keeps most of the old vertices. The projected grid's rings
and a quadtree's leaves are the same thing here; the metric is that of Lindner's patches (spacing in pixels at the
nearest point), on the lattice.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .lattice import FACE_AXES, FULL_BITS, cell_center, cell_edge_m, neighbour
from .lattice_anchor import LatticeAnchor
from .nearest import NearestPoint
from .scheme import spread_bits

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

NEAR_FACTOR = 4.0
"""Cells nearer than this many altitudes are measured at their own height, where a height function is given."""
LOWEST_CLEARANCE = 0.25
"""... but never as nearer in height than this fraction of the altitude."""
COARSENING_STEPS_PER_OCTAVE = 4
"""When there would be too many cells the wanted angle grows in steps of 2^(1/4), so that it seldom changes."""
MOST_CELLS = 12000
"""What ground and sea ask for at most. A telephoto lens near the ground would have ten times as many: its triangles get
longer."""
LARGEST_SPACING_RAD = 0.05
"""Vertices are never farther apart than this angle, however few pixels a picture has: 3 degrees, seen from the
proxy."""
LARGEST_SHARE = 0.03
"""Of the planet's radius: a spacing of vertices that still shows mountain belts from far away."""
LARGEST_SAG_PX = 0.2
"""Nor may a planet seen from far away lose more of its round outline to chords than this."""


def spacing_angle(edge_px: float, pixel_rad: float, altitude_m: float, radius_m: float) -> float:
    """The angle between vertices to ask of `select_rings` for edges of at most edge_px pixels in a picture.

    A chord of angle a at distance d falls (a d)^2 / (8 r) short of the sphere; from far away d is about the altitude.
    """
    sag = np.sqrt(8.0 * radius_m * LARGEST_SAG_PX * pixel_rad / max(altitude_m, 1e-3))
    # From far away the whole planet has few vertices anyway: enough of them for what varies over it, if pixels show
    # that.
    face = max(LARGEST_SHARE * radius_m / max(altitude_m, 1e-3), 3.0 * pixel_rad)
    return float(min(edge_px * pixel_rad, LARGEST_SPACING_RAD, face, max(sag, 1e-4)))


def chord_limit_m(pixel_rad: float, radius_m: float) -> float:
    """Square of an edge's length per distance at which the sphere bulges LARGEST_SAG_PX above it: L^2 / (8 r d)."""
    return 8.0 * radius_m * LARGEST_SAG_PX * pixel_rad


@dataclass(frozen=True, eq=False)
class CellSet:
    """The leaves of a selection, nearest first. All arrays have N rows."""

    face: NDArray[np.int32]
    level: NDArray[np.int32]
    i: NDArray[np.int32]
    j: NDArray[np.int32]
    edge_delta: NDArray[np.uint8]
    """(N, 4): by how many levels the neighbour across edge 0: i - 1, 1: i + 1, 2: j - 1, 3: j + 1 is coarser; 0 if it
    is of the same level, finer or absent. Vertices along such an edge are rounded down to multiples of 2^delta."""
    spacing_m: Floats
    """Distance between neighbouring vertices along the longest edge."""
    distance_m: Floats
    """From the proxy to the nearest point of the cell."""
    quads: int
    """Quads along a cell's edge."""
    spacing_angle_rad: float
    """The angle that was used: the wanted one, or a larger one to stay below max_cells."""

    def __len__(self) -> int:
        return len(self.face)

    def packed(self) -> NDArray[np.int32]:
        """(N, 4) int32 for the GPU: i; j; face | level << 8; the four edge deltas, edge 0 in the lowest byte."""
        delta = self.edge_delta.astype(np.int32)
        edges = delta[:, 0] | delta[:, 1] << 8 | delta[:, 2] << 16 | delta[:, 3] << 24
        return np.stack([self.i, self.j, self.face | self.level << 8, edges], axis=1)


def select_rings(
    anchor: LatticeAnchor | ArrayLike,
    altitude_above_ground_m: float,
    anchor_height_m: float,
    radius_m: float,
    spacing_angle_rad: float,
    quads: int = 16,
    coverage_rad: float = np.pi,
    min_spacing_m: float = 0.01,
    max_cells: int = 1 << 16,
    height_at: Callable[[Floats], Floats] | None = None,
) -> CellSet:
    """Select the cells for a proxy `altitude_above_ground_m` above the ground point of the anchor.

    `spacing_angle_rad` is the wanted distance between vertices as an angle (edge length in pixels times the angle of a
    pixel); `coverage_rad` the central angle beyond which cells are dropped (measured to their nearest point);
    `min_spacing_m` the finest vertex spacing; `height_at` maps unit directions (N, 3) to heights (N,), and is asked
    only about the middles of cells near the proxy.

    Cost: about 0.1 ms a level plus 0.5 us a cell. Raises ValueError for values that make no sense.
    """
    direction = anchor.direction if isinstance(anchor, LatticeAnchor) else np.asarray(anchor, dtype=np.float64)
    direction = direction / np.linalg.norm(direction)
    positive = {
        "altitude_above_ground_m": altitude_above_ground_m,
        "radius_m": radius_m,
        "radius_m + anchor_height_m": radius_m + anchor_height_m,
        "spacing_angle_rad": spacing_angle_rad,
        "coverage_rad": coverage_rad,
        "min_spacing_m": min_spacing_m,
        "max_cells": max_cells,
    }
    for name, value in positive.items():
        if not (np.isfinite(value) and value > 0):
            raise ValueError(f"select_rings: {name} must be positive and finite, found {value!r}")
    if not np.all(np.isfinite(direction)):
        raise ValueError(f"select_rings: anchor must be a finite, non-zero direction, found {anchor!r}")
    if quads < 2 or quads & (quads - 1) or quads > 256:
        raise ValueError(f"select_rings: quads must be a power of two from 2 to 256, found {quads}")
    bits = quads.bit_length() - 1
    finest = int(np.clip(np.floor(np.log2(radius_m * (np.pi / 2) / (quads * min_spacing_m))), 0, FULL_BITS - bits))
    search = _Search(
        direction, altitude_above_ground_m, anchor_height_m, radius_m, quads, coverage_rad, finest, height_at
    )
    angle = float(spacing_angle_rad)
    while True:
        found = search.run(angle, 4 * max_cells)
        count = len(found[0])
        if count <= max_cells:
            break
        # Cells go with the inverse square of the angle.
        steps = max(1, int(COARSENING_STEPS_PER_OCTAVE * 0.5 * np.log2(count / max_cells)))
        coarser = angle * 2.0 ** (steps / COARSENING_STEPS_PER_OCTAVE)
        if coarser > 1e6:
            break
        angle = coarser
    found, delta = _balance(found, bits, search)
    return search.finish(found, delta, angle)


_Leaves = tuple[Ints, Ints, Ints, Ints]


class _Search:
    """One selection: walks down the six trees level by level, each level in one go."""

    def __init__(
        self,
        direction: Floats,
        altitude_m: float,
        anchor_height_m: float,
        radius_m: float,
        quads: int,
        coverage_rad: float,
        finest: int,
        height_at: Callable[[Floats], Floats] | None,
    ) -> None:
        self.nearest = NearestPoint(direction, FACE_AXES)
        self.altitude_m = altitude_m
        self.camera_height_m = anchor_height_m + altitude_m
        sphere_m = radius_m + anchor_height_m
        # |P u - S v|^2 = (P - S)^2 + P S |u - v|^2
        self.product_m2 = sphere_m * (sphere_m + altitude_m)
        self.radius_m = radius_m
        self.quads = quads
        self.finest = finest
        self.height_at = height_at
        self.coverage2 = 4.0 * np.sin(min(coverage_rad, np.pi) / 2) ** 2 * (1 + 1e-12) + 1e-30
        if coverage_rad >= np.pi:
            self.coverage2 = np.inf

    def run(self, angle: float, limit: int) -> _Leaves:
        """Leaves (face, level, i, j) for this angle; stops early with too many when there are more than `limit`."""
        face, i, j = np.arange(6), np.zeros(6, np.int64), np.zeros(6, np.int64)
        leaves: list[tuple[Ints, int, Ints, Ints]] = []
        total = 0
        for level in range(self.finest + 1):
            chord2 = self.chord2(face, level, i, j)
            keep = chord2 <= self.coverage2
            if not keep.all():
                face, i, j, chord2 = face[keep], i[keep], j[keep], chord2[keep]
            if level == self.finest:
                leaves.append((face, level, i, j))
                break
            split = self._split(face, level, i, j, chord2, angle)
            whole = ~split
            leaves.append((face[whole], level, i[whole], j[whole]))
            total += len(leaves[-1][0])
            face, i, j = children(face[split], i[split], j[split])
            if not len(face) or total + len(face) > limit:
                leaves.append((face, level + 1, i, j))
                break
        return (
            np.concatenate([a[0] for a in leaves]),
            np.repeat([a[1] for a in leaves], [len(a[0]) for a in leaves]),
            np.concatenate([a[2] for a in leaves]),
            np.concatenate([a[3] for a in leaves]),
        )

    def chord2(self, face: Ints, level: int | Ints, i: Ints, j: Ints) -> Floats:
        """Squared unit chords from the proxy's direction to the nearest points of cells."""
        scale = (np.pi / 2) * np.exp2(-np.asarray(level, dtype=np.float64))
        low = np.stack([i, j]) * scale - np.pi / 4
        return self.nearest.chord_squared(face, np.tan(low), np.tan(low + scale))

    def _split(self, face: Ints, level: int, i: Ints, j: Ints, chord2: Floats, angle: float) -> NDArray[np.bool_]:
        edge_m = float(cell_edge_m(level, self.radius_m))
        reach2 = (edge_m / (self.quads * angle)) ** 2
        across2 = chord2 * self.product_m2
        split = across2 + self.altitude_m**2 < reach2
        if self.height_at is None or edge_m > 2 * self.altitude_m:
            return split
        # Near the proxy the ground's own height counts. Nothing can make a cell nearer than the lowest clearance.
        lowest = LOWEST_CLEARANCE * self.altitude_m
        near = (across2 < (NEAR_FACTOR * self.altitude_m) ** 2) & (across2 + lowest**2 < reach2)
        if near.any():
            height = np.asarray(self.height_at(cell_center(face[near], level, i[near], j[near])), dtype=np.float64)
            clearance = np.maximum(self.camera_height_m - height, lowest)
            split[near] = across2[near] + clearance**2 < reach2
        return split

    def finish(self, leaves: _Leaves, delta: Ints, angle: float) -> CellSet:
        """Distances and the order of the final leaves."""
        face, level, i, j = leaves
        distance_m = np.sqrt(self.chord2(face, level, i, j) * self.product_m2 + self.altitude_m**2)
        order = np.argsort(distance_m, kind="stable")
        return CellSet(
            face=face[order].astype(np.int32),
            level=level[order].astype(np.int32),
            i=i[order].astype(np.int32),
            j=j[order].astype(np.int32),
            edge_delta=delta[order].astype(np.uint8),
            spacing_m=cell_edge_m(level[order], self.radius_m) / self.quads,
            distance_m=distance_m[order],
            quads=self.quads,
            spacing_angle_rad=angle,
        )


def children(face: Ints, i: Ints, j: Ints) -> tuple[Ints, Ints, Ints]:
    """The four children of each cell, one level finer."""
    return (
        np.repeat(face, 4),
        (2 * i[:, None] + np.array([0, 1, 0, 1])).ravel(),
        (2 * j[:, None] + np.array([0, 0, 1, 1])).ravel(),
    )


def morton_key(face: Ints, level: Ints, i: Ints, j: Ints) -> Ints:
    """Where a cell begins on the Z-curve through all lattice cells; it covers the next 4^(30 - level) keys."""
    shift = FULL_BITS - level
    return face << 2 * FULL_BITS | spread_bits(i << shift) | spread_bits(j << shift) << 1


def cell_keys(cells: CellSet) -> Ints:
    """`morton_key` of each cell."""
    return morton_key(*(a.astype(np.int64) for a in (cells.face, cells.level, cells.i, cells.j)))


def rows_in(cells: CellSet, others: CellSet) -> Ints:
    """Each cell's row in another selection, -1 where that hasn't it, (N,)."""
    wanted, there = cell_keys(cells), cell_keys(others)
    if not len(there):
        return np.full(len(wanted), -1)
    order = np.argsort(there)
    place = order[np.minimum(np.searchsorted(there[order], wanted), len(order) - 1)]
    return np.where((there[place] == wanted) & (others.level[place] == cells.level), place, -1)


def neighbours_of(face: Ints, level: Ints, i: Ints, j: Ints) -> tuple[Ints, Ints]:
    """By how many levels the neighbour across each edge is coarser, (N, 4), and that neighbour's row, (N, 4).

    The cells must be leaves: none may contain another. A neighbour that is finer or absent counts as 0 and row -1.
    """
    start = morton_key(face, level, i, j)
    order = np.argsort(start)
    ordered = start[order]
    around = neighbour(face[:, None], level[:, None], i[:, None], j[:, None], np.arange(4))
    key = morton_key(around[0], level[:, None], around[1], around[2])
    place = order[np.maximum(np.searchsorted(ordered, key, side="right") - 1, 0)]
    coarser = level[:, None] - level[place]
    inside = (key >= start[place]) & (key - start[place] < np.int64(1) << 2 * (FULL_BITS - level[place]))
    found = inside & (coarser >= 0)
    return np.where(found, coarser, 0), np.where(found, place, -1)


def _balance(leaves: _Leaves, most: int, search: _Search) -> tuple[_Leaves, Ints]:
    """Split leaves that are more than `most` levels coarser than a neighbour, until none is; and the edge deltas."""
    while True:
        face, level, i, j = leaves
        delta, place = neighbours_of(face, level, i, j)
        too_coarse = delta > most
        if not too_coarse.any():
            return leaves, delta
        coarse = np.unique(place[too_coarse])
        keep = np.ones(len(face), bool)
        keep[coarse] = False
        new_face, new_i, new_j = children(face[coarse], i[coarse], j[coarse])
        new_level = np.repeat(level[coarse] + 1, 4)
        covered = search.chord2(new_face, new_level, new_i, new_j) <= search.coverage2
        leaves = (
            np.concatenate([face[keep], new_face[covered]]),
            np.concatenate([level[keep], new_level[covered]]),
            np.concatenate([i[keep], new_i[covered]]),
            np.concatenate([j[keep], new_j[covered]]),
        )
