"""TerrainPatch: a piece of ground in a local frame, for physics engines and meshes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..engine.space import local_axes
from ..engine.surface.lattice import FULL, FULL_BITS, STEP_RAD, canonical_lattice, cell_center, cell_of, direction_of
from ..systems.terrain import height_march
from ..systems.terrain.height import TerrainField

__all__ = ["TerrainPatch", "aligned_patch", "lattice_size", "tangent_patch"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_POINTS = 4097
"""Along a side."""
_FEWEST_QUADS = 8
"""Of aligned patches: small batches of heights are summed in another order and would differ in their last bit."""


@dataclass(frozen=True)
class TerrainPatch:
    """A square grid of ground in a local frame, ready for a mesh or a physics engine's height field.

    origin_m: the frame's origin, planet-centred (3,), on the ground at the middle unless a frame was given. axes: rows
    are the frame's unit axes x, y, z in planet axes (3, 3); by default east, north, up at the origin. A point of the
    planet is origin_m + point @ axes. x_m: the grid's coordinates along its rows and columns from its middle (n,); of
    an aligned patch nominal, its lattice being up to 20 degrees askew. positions_m: points in the frame (n, n, 3); z
    falls away with the planet's curve. normals: in the frame (n, n, 3); (0, 0, 3) if they were not asked for.
    heights_m: above the reference sphere (n, n). cell: (face, level, i, j) of an aligned patch on the planet's lattice,
    else None. border: rings of points beyond the cell.

    Not aligned: row i is at y = x_m[i], column j at x = x_m[j]. Aligned: columns follow the lattice's i, rows its j.
    """

    origin_m: Floats
    axes: Floats
    x_m: Floats
    positions_m: Floats
    normals: Floats
    heights_m: Floats
    cell: tuple[int, int, int, int] | None = None
    border: int = 0

    def __repr__(self) -> str:
        n, low, high = len(self.x_m), self.heights_m.min(), self.heights_m.max()
        cell = "" if self.cell is None else f", cell {self.cell}"
        return f"<TerrainPatch {n} x {n} points, {np.ptp(self.x_m):g} m wide, heights {low:.1f} to {high:.1f} m{cell}>"

    def triangles(self) -> NDArray[np.int32]:
        """Corner indices (2 (n - 1)^2, 3) into positions_m.reshape(-1, 3), counter-clockwise from above."""
        n = len(self.x_m)
        a = (np.arange(n - 1)[:, None] * n + np.arange(n - 1)).ravel()
        return np.concatenate([np.stack([a, a + 1, a + n + 1], 1), np.stack([a, a + n + 1, a + n], 1)]).astype(np.int32)

    def to_planet(self, points: Floats) -> Floats:
        """Planet-centred metres (N, 3) of points (N, 3) of the frame."""
        return self.origin_m + points @ self.axes

    def to_frame(self, positions_m: Floats) -> Floats:
        """The frame's coordinates (N, 3) of planet-centred positions (N, 3)."""
        return (positions_m - self.origin_m) @ self.axes.T


Frame = tuple[Floats, Floats]


def tangent_patch(
    field: TerrainField, up: Floats, size_m: float, count: int, frame: Frame | None, normals: bool
) -> TerrainPatch:
    """A grid of `count` points a side on the plane that touches the sphere at `up` (3,), seen from the centre."""
    north, east = local_axes(up)
    grid_axes = np.stack([east, north, up])
    x = np.linspace(-0.5 * size_m, 0.5 * size_m, count)
    feet = np.stack([*np.meshgrid(x, x), np.full((count, count), field.radius_m)], axis=-1).reshape(-1, 3)
    feet /= np.linalg.norm(feet, axis=1)[:, None]
    if frame is None:
        frame = (up * (field.radius_m + float(field.height(up[None])[0])), grid_axes)
    return _patch(field, feet @ grid_axes, x, frame, normals)


def lattice_size(radius_m: float, size_m: float, spacing_m: float) -> tuple[int, int]:
    """(log2 of lattice steps between points, level of the cell) that come nearest to a size and spacing in metres."""
    shift = int(np.clip(round(float(np.log2(spacing_m / (radius_m * STEP_RAD)))), 0, FULL_BITS - 4))
    quads_log2 = max(round(float(np.log2(size_m / spacing_m))), _FEWEST_QUADS.bit_length() - 1)
    return shift, max(FULL_BITS - shift - quads_log2, 0)


def aligned_patch(
    field: TerrainField, up: Floats, size_m: float, spacing_m: float, border: int, frame: Frame | None, normals: bool
) -> TerrainPatch:
    """The cell of the planet's lattice that contains `up` (3,): about `size_m` wide, points about `spacing_m` apart.

    Points are a power of two of lattice steps apart and the cell a power of two of that. A point is a function of its
    lattice integers alone: patches that share a border share its points to the last bit, whenever they were made.
    """
    shift, level = lattice_size(field.radius_m, size_m, spacing_m)
    face, i, j = (int(v) for v in cell_of(up, level))
    step, size = 1 << shift, 1 << (FULL_BITS - level)
    along = np.arange(-border, (size >> shift) + border + 1) * step
    columns, rows = np.meshgrid(i * size + along, j * size + along)
    feet = direction_of(*_canonical(face, columns.ravel(), rows.ravel()))
    if frame is None:
        middle = np.asarray(cell_center(face, level, i, j))
        north, east = local_axes(middle)
        ground = field.radius_m + float(field.height(middle[None])[0])
        frame = (middle * ground, np.stack([east, north, middle]))
    x: Floats = np.asarray((along - size // 2) * (0.9 * field.radius_m * STEP_RAD), dtype=np.float64)
    patch = _patch(field, feet, x, frame, normals)
    return TerrainPatch(
        patch.origin_m, patch.axes, x, patch.positions_m, patch.normals, patch.heights_m, (face, level, i, j), border
    )


def _canonical(face: int, i_full: Ints, j_full: Ints) -> tuple[Ints, Ints, Ints]:
    """One name for points that several faces have; rings beyond a face have no other name."""
    faces = np.full(i_full.shape, face)
    inside = (np.minimum(i_full, j_full) >= 0) & (np.maximum(i_full, j_full) <= FULL)
    i_full, j_full = i_full.copy(), j_full.copy()
    faces[inside], i_full[inside], j_full[inside] = canonical_lattice(face, i_full[inside], j_full[inside])
    return faces, i_full, j_full


def _patch(field: TerrainField, feet: Floats, x: Floats, frame: Frame, normals: bool) -> TerrainPatch:
    origin, axes = frame
    count = len(x)
    heights = field.height(feet)
    away = feet * (field.radius_m + heights)[:, None] - origin
    # Not a matrix product: its sums may depend on a point's place in the array.
    positions = np.stack([away[:, 0] * a[0] + away[:, 1] * a[1] + away[:, 2] * a[2] for a in axes], axis=-1)
    out = np.zeros((0, 0, 3))
    if normals:
        out = (height_march.surface_normal(field, feet)[1] @ axes.T).reshape(count, count, 3)
    return TerrainPatch(origin, axes, x, positions.reshape(count, count, 3), out, heights.reshape(count, count))
