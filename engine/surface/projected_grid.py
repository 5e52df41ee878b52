"""The projected grid as Michelic (2018) and Michelic et al. (2019) print it: warp, offset, turn, projection,
tessellation.

A square grid of points (x, y) in [-1, 1]^2 is warped to a hemisphere, z = (1 - x^n)(1 - y^n), shifted by z_s
(engine/surface/coverage.py), turned so that its third axis points at the proxy, and projected onto the sphere:
direction = (x, y, z + z_s) / |..|. Each square of the grid is a patch; patches are cut into 1 to 64 segments a side by
their size on screen. Points are named by integers, so both patches at an edge have the same ones.

float64 and numpy only; assets/shaders/terrain/paper/grid.glsl is the GPU's side.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..blocks.layout import Vec3
from .coverage import Coverage

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

MOST_LEVEL = 6
"""A patch has at most 2^6 segments a side: the limit of GL's tessellation shaders, gl_MaxTessGenLevel."""
FINEST = 1 << MOST_LEVEL
LOWEST_OFFSET = -0.95
"""z_s of the warped grid stays above -1, where the middle of the grid would lie at the centre of the planet."""


@dataclass
class GridBlock:
    """What common/paper/places.glsl reads of a grid."""

    first_axis: Vec3
    z_s: float
    second_axis: Vec3
    spacing_rad: Annotated[float, "wanted between vertices, seen from the proxy"]
    third_axis: Annotated[Vec3, "towards the middle of the grid"]
    smallest_spacing_m: Annotated[float, "of vertices"]
    middle_m: Annotated[Vec3, "the middle's foot from the anchor's"]
    per_half: Annotated[float, "1 / half_steps"]
    proxy_height_m: Annotated[float, "above the surface that is drawn"]
    half_steps: Annotated[int, "half the steps a side"]
    power: Annotated[int, "n of the warp"]


def grid_axes(direction: ArrayLike) -> Floats:
    """Rows u, v, w (3, 3): w towards the proxy, v = normalize(w x b), u = v x w; b is the axis least aligned with w.

    They are right-handed. u = w x v, as printed, turns the grid over.
    """
    w = np.asarray(direction, dtype=np.float64)
    w = w / np.linalg.norm(w)
    v = np.asarray(np.cross(w, np.eye(3)[int(np.argmin(np.abs(w)))]), dtype=np.float64)
    v = v / np.linalg.norm(v)
    return np.stack([np.asarray(np.cross(v, w), dtype=np.float64), v, w])


def grid_offset(seen: Coverage) -> float:
    """z_s for the warped grid, whose corners cover less than its edge midpoints where it is negative."""
    return max(seen.grid_offset, LOWEST_OFFSET)


@dataclass(frozen=True, eq=False)
class Tessellation:
    """Patches, coarsest last. All arrays have a row per patch."""

    i: Ints
    j: Ints
    level: Ints
    """A patch has 2^level segments a side."""
    edge_level: Ints
    """(N, 4): 2^edge_level segments along edges i, i + 1, j, j + 1; the neighbour there has the same."""
    first: Ints
    """Its first vertex; it has (2^level + 1)^2."""
    vertices: int
    """Of all patches."""
    triangles: int
    """Of all patches, before any is dropped and with the flat ones along edges with fewer segments."""
    coarser: float
    """How many times longer than asked edges had to be to stay below the most vertices."""

    def __len__(self) -> int:
        return len(self.level)

    def packed(self) -> NDArray[np.uint32]:
        """(N, 2) for the GPU: i | j << 8 | level << 16 | 3 bits for each edge level from bit 19 on; first vertex."""
        edges = self.edge_level
        word = self.i | self.j << 8 | self.level << 16
        for edge in range(4):
            word = word | edges[:, edge] << (19 + 3 * edge)
        return np.stack([word, self.first], axis=1).astype(np.uint32)

    def faces(self) -> Ints:
        """All triangles (N, 3) as numbers of vertices, those without area left out: what triangles.comp writes."""
        found = [np.zeros((0, 3), np.int64)]
        for level in range(MOST_LEVEL + 1):
            rows = np.flatnonzero(self.level == level)
            side = 1 << level
            b, a = np.divmod(np.arange((side + 1) ** 2), side + 1)
            skip = level - self.edge_level[rows]
            across = np.where(a == 0, skip[:, 0:1], np.where(a == side, skip[:, 1:2], 0))
            along = np.where(b == 0, skip[:, 2:3], np.where(b == side, skip[:, 3:4], 0))
            vertex = ((b >> across) << across) * (side + 1) + ((a >> along) << along) + self.first[rows, None]
            y, x = np.divmod(np.arange(side**2), side)
            low = y * (side + 1) + x
            high = low + side + 1
            quads = np.stack([low, low + 1, high + 1, low, high + 1, high], axis=1).ravel()
            found.append(vertex[:, quads].reshape(-1, 3))
        triangles = np.concatenate(found)
        a, b, c = triangles.T
        return triangles[(a != b) & (b != c) & (c != a)]

    def by_level(self) -> Ints:
        """How many patches there are of each level, (MOST_LEVEL + 1,)."""
        return np.bincount(self.level, minlength=MOST_LEVEL + 1)


@dataclass(frozen=True, eq=False)
class ProjectedGrid:
    """A grid of `corners` x `corners` points, projected around a proxy."""

    corners: int
    power: int
    """n of the warp: 4 or 2."""
    z_s: float
    axes: Floats
    """Rows u, v, w (3, 3) in planet axes; w is the proxy's direction and the anchor's."""
    radius_m: float

    @property
    def patches(self) -> int:
        """Patches a side."""
        return self.corners - 1

    def steps(self) -> int:
        """Integer places a side: every patch has 64."""
        return self.patches * FINEST

    def planar(self, i: ArrayLike, j: ArrayLike) -> Floats:
        """Warped and shifted points (..., 3) in the grid's own axes, of integer places 0..steps()."""
        half = self.steps() // 2
        x = (np.asarray(i, dtype=np.int64) - half) / half
        y = (np.asarray(j, dtype=np.int64) - half) / half
        z = (1.0 - x**self.power) * (1.0 - y**self.power) + self.z_s
        return np.stack(np.broadcast_arrays(x, y, z), axis=-1)

    def directions(self, i: ArrayLike, j: ArrayLike) -> Floats:
        """Unit directions (..., 3) in planet axes of integer places."""
        g = self.planar(i, j)
        return g / np.linalg.norm(g, axis=-1, keepdims=True) @ self.axes

    def foot_offsets_m(self, i: ArrayLike, j: ArrayLike) -> Floats:
        """radius (direction - w), (..., 3) in planet axes, without cancellation."""
        g = self.planar(i, j)
        length = np.linalg.norm(g, axis=-1)
        aside = g[..., 0] ** 2 + g[..., 1] ** 2
        fall = np.where(g[..., 2] > 0.0, -aside / (length * (length + np.abs(g[..., 2]))), g[..., 2] / length - 1.0)
        turned = np.stack([g[..., 0] / length, g[..., 1] / length, fall], axis=-1)
        return self.radius_m * (turned @ self.axes)

    def middle_m(self, anchor: Floats) -> Floats:
        """radius (w - anchor), (3,): what a foot's offset from the middle needs to be one from an anchor's foot."""
        return self.radius_m * (self.axes[2] - anchor)

    def locate(self, directions: Floats) -> Floats:
        """Places (N, 2) in steps, not whole, that unit directions (N, 3) are projected from; NaN where none is.

        On the way out from the middle of the sphere along a direction, s times its parts in the grid's axes, the warped
        grid is where (1 - x^n)(1 - y^n) + z_s = z: the left side falls as s grows. Where z falls faster, behind the
        grid's border, there is nothing to find.
        """
        parts = np.asarray(directions, dtype=np.float64) @ self.axes.T

        def above(s: Floats) -> Floats:
            x, y, z = (parts * s[:, None]).T
            return (1.0 - x**self.power) * (1.0 - y**self.power) + self.z_s - z

        aside = np.abs(parts[:, :2]).max(axis=1)
        with np.errstate(divide="ignore"):
            most = 1.0 / aside  # the border
        most = np.minimum(most, (1.0 + abs(self.z_s)) / np.maximum(np.abs(parts[:, 2]), 1e-300))
        low, high = np.zeros(len(parts)), most * (1.0 + 1e-12)
        found = (above(low) > 0.0) & (above(high) <= 0.0)
        for _ in range(60):
            middle = 0.5 * (low + high)
            beyond = above(middle) <= 0.0
            high, low = np.where(beyond, middle, high), np.where(beyond, low, middle)
        half = self.steps() // 2
        places = half * (1.0 + parts[:, :2] * (0.5 * (low + high))[:, None])
        return np.where(found[:, None], places, np.nan)

    def covered_rad(self) -> float:
        """The smallest central angle between w and the grid's border."""
        places = np.arange(self.steps() + 1)
        g = self.planar(places, 0)  # all four sides are alike
        return float(np.arctan2(np.hypot(g[:, 0], g[:, 1]), g[:, 2]).min())

    def tessellate(
        self,
        above_ground_m: float,
        ground_m: float,
        edge_rad: float,
        most_vertices: int = 1 << 21,
        proxy: Floats | None = None,
    ) -> Tessellation:
        """How finely each patch is cut, by the angle under which its edges are seen from the proxy: edge_rad is the
        wanted one. proxy: its direction (3,), None: over the middle of the grid.

        An edge counts as a sphere of its length about its middle, whichever way it lies, on the sphere of the ground
        at the proxy's foot; so nothing depends on where the camera looks. Segments are powers of two.
        Where all patches together would have more than `most_vertices` vertices, edges get longer by steps of 2^(1/4).
        """
        place = np.arange(self.corners, dtype=np.int64) * FINEST
        feet = self.foot_offsets_m(place[:, None], place[None, :])
        above = self.axes[2] if proxy is None else proxy
        scale = (self.radius_m + ground_m) / self.radius_m
        eye = above * above_ground_m - scale * self.middle_m(above)

        def wanted(a: Floats, b: Floats) -> Floats:
            middle = 0.5 * scale * (a + b) - eye
            return scale * np.linalg.norm(a - b, axis=-1) / np.linalg.norm(middle, axis=-1) / edge_rad

        along_i, along_j = wanted(feet[1:], feet[:-1]), wanted(feet[:, 1:], feet[:, :-1])
        coarser = 1.0
        while True:
            level_i, level_j = _level(along_i / coarser), _level(along_j / coarser)
            # Edges of patch (i, j): its low and high side in i run along j, and the other way round.
            edges = np.stack([level_j[:-1], level_j[1:], level_i[:, :-1], level_i[:, 1:]], axis=-1).reshape(-1, 4)
            level = edges.max(axis=1)
            counts = ((1 << level) + 1) ** 2
            vertices = int(counts.sum())
            if vertices <= most_vertices or not level.any():
                break
            coarser *= 2.0**0.25
        order = np.argsort(-level, kind="stable")
        i, j = np.divmod(np.arange(self.patches**2), self.patches)
        counts = counts[order]
        return Tessellation(
            i=i[order],
            j=j[order],
            level=level[order],
            edge_level=edges[order],
            first=np.concatenate([[0], np.cumsum(counts[:-1])]),
            vertices=vertices,
            triangles=int((2 * 4**level).sum()),
            coarser=coarser,
        )


def _level(segments: Floats) -> Ints:
    return np.clip(np.ceil(np.log2(np.maximum(segments, 1e-9))), 0, MOST_LEVEL).astype(np.int64)


__all__ = [
    "FINEST",
    "LOWEST_OFFSET",
    "MOST_LEVEL",
    "ProjectedGrid",
    "Tessellation",
    "grid_axes",
    "grid_offset",
]
