"""The mesh that a renderer's last frame drew, read back: vertices, lattice points, edges; and the truth at them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Renderer
from ...engine.space import CameraState
from ...engine.surface.decimation import decimated_indices
from ...engine.surface.lattice import FULL_BITS, locate
from ...systems.terrain.backends.grid_mesh import GridSpacing
from .. import exact

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class DrawnMesh:
    """All cells of the selection. Arrays of vertices have the shape (cells, (quads + 1)^2, ...)."""

    record: NDArray[np.void]
    vertices: NDArray[np.void]
    visible: Ints
    quads: int
    radius_m: float
    anchor: Any
    """engine.surface.lattice_anchor.LatticeAnchor"""
    anchor_height_m: float
    anchor_m: Floats
    generation: int
    spacing: GridSpacing

    @classmethod
    def of(cls, renderer: Renderer) -> DrawnMesh:
        """Of the last frame. RuntimeError when it drew no ground."""
        system: Any = renderer.system("terrain")
        mesh = None if system is None else system.drawn_mesh(renderer.views[0])
        if mesh is None or mesh.count == 0:
            raise RuntimeError("the last frame selected no ground: nothing to measure")
        assert system is not None
        proxy = renderer.views[0].proxy
        return cls(
            record=mesh.read_cells().copy(),
            vertices=mesh.read_vertices().copy(),
            visible=mesh.read_visible().astype(np.int64),
            quads=mesh.quads,
            radius_m=proxy.cell.radius_m,
            anchor=proxy.lattice,
            anchor_height_m=proxy.anchor_height_m,
            anchor_m=proxy.anchor_m.copy(),
            generation=proxy.generation,
            spacing=system.backend.view(renderer.views[0]).choice.spacing,
        )

    @property
    def side(self) -> int:
        """Vertices along a cell's edge."""
        return self.quads + 1

    @cached_property
    def offsets_m(self) -> Floats:
        """From the anchor, as drawn, widened to f64."""
        return self.vertices["position_m"].astype(np.float64)

    @cached_property
    def lattice(self) -> tuple[Ints, Ints, Ints]:
        """face, I, J of all vertices, (cells, vertices)."""
        cells = self.record
        shift = FULL_BITS - cells["level"].astype(np.int64)
        step = (np.int64(1) << (shift - (self.quads.bit_length() - 1)))[:, None]
        b, a = np.divmod(np.arange(self.side**2), self.side)
        i = (cells["i"].astype(np.int64) << shift)[:, None] + a * step
        j = (cells["j"].astype(np.int64) << shift)[:, None] + b * step
        return np.broadcast_to(cells["face"].astype(np.int64)[:, None], i.shape), i, j

    def within(self, position_m: Floats, distance_m: float) -> NDArray[np.bool_]:
        """Which vertices lie within a distance of a planet-centred position."""
        return np.linalg.norm(self.offsets_m - (position_m - self.anchor_m), axis=-1) <= distance_m

    @cached_property
    def used(self) -> NDArray[np.bool_]:
        """Which vertices (cells, vertices) some triangle uses."""
        found = np.zeros(self.vertices.size, bool)
        found[self.triangles(np.arange(len(self.record))).ravel()] = True
        return found.reshape(self.vertices.shape)

    def grid_spacing(self, chosen: NDArray[np.bool_]) -> Floats:
        """The band limit of vertices (terrain/grid_spacing.glsl)."""
        face, i, j = (a[chosen] for a in self.lattice)
        foot = self.anchor.foot_offset64(face, i, j)
        scale = 1.0 + self.anchor_height_m / self.radius_m
        grid = self.spacing
        distance_m = np.sqrt((foot * foot).sum(axis=-1) * scale * scale + grid.proxy_height_m**2)
        return np.maximum(grid.smallest_m, grid.per_distance * distance_m)

    def directions(self, chosen: NDArray[np.bool_]) -> Floats:
        """Exact unit directions (N, 3) of vertices, rounded to f64."""
        face, i, j = (a[chosen] for a in self.lattice)
        return exact.lattice_direction(face, i, j).astype(np.float64)

    def triangles(self, cells: Ints) -> Ints:
        """Triangles (N, 3) of cells as drawn, as flat vertex numbers; those without area along seams left out."""
        indices, ranges = decimated_indices(self.quads)
        found = []
        for variant in np.unique(self.record["variant"][cells]):
            first, count = ranges[variant].astype(int)
            patch = indices[first : first + count].astype(np.int64).reshape(-1, 3)
            of = cells[self.record["variant"][cells] == variant]
            found.append((self._masked(of)[:, patch] + (of * self.side**2)[:, None, None]).reshape(-1, 3))
        triangles = np.concatenate(found) if found else np.zeros((0, 3), np.int64)
        a, b, c = triangles.T
        return triangles[(a != b) & (b != c) & (c != a)]

    def _masked(self, cells: Ints) -> Ints:
        """Vertex numbers (cells, vertices) that stand for each vertex: cell_masked_vertex of common/cells.glsl."""
        mask = self.record["edge_mask"][cells].astype(np.int64)
        edges = np.stack([(mask >> (8 * e)) & 255 for e in range(4)], axis=1)
        y, x = np.divmod(np.arange(self.side**2), self.side)
        across = np.where(x == 0, edges[:, 0:1], np.where(x == self.quads, edges[:, 1:2], 0))
        along = np.where(y == 0, edges[:, 2:3], np.where(y == self.quads, edges[:, 3:4], 0))
        return ((y >> across) << across) * self.side + ((x >> along) << along)


def drawn_heights(mesh: DrawnMesh, directions: Floats) -> Floats:
    """Heights (N,) of the drawn triangles below or above unit directions (N, 3); NaN where no cell was selected."""
    cells = _cells_below(mesh, directions)
    heights = np.full(len(directions), np.nan)
    for cell in np.unique(cells[cells >= 0]):
        places = np.flatnonzero(cells == cell)
        corner = mesh.offsets_m.reshape(-1, 3)[mesh.triangles(np.array([cell]))]  # (T, 3, 3), from the anchor
        u, v = corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
        normal = np.cross(u, v)
        zenith = directions[places]
        # Where the line along each zenith meets each triangle's plane, and how far outside the triangle that is.
        reach = ((mesh.anchor_m + corner[:, 0]) * normal).sum(axis=1)[:, None] / (normal @ zenith.T)  # (T, n)
        point = zenith * reach[..., None] - mesh.anchor_m - corner[:, :1]
        area = (normal * normal).sum(axis=1)[:, None]
        along_v = np.einsum("tk,tnk->tn", np.cross(normal, u), point) / area
        along_u = -np.einsum("tk,tnk->tn", np.cross(normal, v), point) / area
        outside = -np.minimum(np.minimum(along_u, along_v), 1.0 - along_u - along_v)
        best = outside.argmin(axis=0)
        heights[places] = reach[best, np.arange(len(places))] - mesh.radius_m
    return heights


def _cells_below(mesh: DrawnMesh, directions: Floats) -> Ints:
    """Row of the selected cell that contains each direction, or -1."""
    face, i_full, j_full = locate(directions)
    found = np.full(len(directions), -1)
    levels = mesh.record["level"].astype(np.int64)
    for level in np.unique(levels):
        rows = np.flatnonzero(levels == level)
        size = 2.0 ** (FULL_BITS - level)
        last = (1 << int(level)) - 1
        wanted = _cell_key(face, np.minimum(i_full // size, last), np.minimum(j_full // size, last))
        known = _cell_key(*(mesh.record[name][rows] for name in ("face", "i", "j")))
        order = np.argsort(known)
        at = np.minimum(np.searchsorted(known[order], wanted), len(order) - 1)
        inside = known[order][at] == wanted
        found[inside] = rows[order][at][inside]
    return found


def _cell_key(face: Any, i: Any, j: Any) -> NDArray[np.int64]:
    face, i, j = (np.asarray(a).astype(np.int64) for a in (face, i, j))
    return face << 60 | i << 30 | j  # i and j stay below 2^30


def some(chosen: NDArray[np.bool_], rng: np.random.Generator, most: int) -> NDArray[np.bool_]:
    """At most that many of the chosen, at random."""
    places = np.flatnonzero(chosen)
    if len(places) <= most:
        return chosen
    kept = np.zeros(chosen.size, bool)
    kept[rng.choice(places, most, replace=False)] = True
    return kept.reshape(chosen.shape)


def height_errors(mesh: DrawnMesh, field: Any, chosen: NDArray[np.bool_]) -> Floats:
    """GPU height minus the f64 twin's of chosen vertices, metres."""
    drawn = mesh.anchor_height_m + mesh.vertices["dh_m"][chosen].astype(np.float64)
    return drawn - field.height(mesh.directions(chosen))


def vertex_normals(mesh: DrawnMesh, chosen: NDArray[np.bool_]) -> Floats:
    """Drawn normals of chosen vertices, unit, planet axes."""
    words = mesh.vertices["normal"][chosen].astype(np.uint32)
    e = np.stack([(words & 0xFFFF).astype(np.uint16).view(np.int16), (words >> 16).astype(np.uint16).view(np.int16)], 1)
    e = np.maximum(e.astype(np.float64) / 32767.0, -1.0)
    n = np.concatenate([e, 1.0 - np.abs(e).sum(axis=1, keepdims=True)], axis=1)
    fold = np.maximum(-n[:, 2:], 0.0)
    n[:, :2] -= np.where(n[:, :2] < 0.0, -fold, fold)
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def true_normals(field: Any, radius_m: float, directions: Floats, footprint_m: Floats | None) -> Floats:
    """Normals (N, 3) of the f64 surface at a footprint."""
    heights, gradients = field.height_gradient(directions, footprint_m)
    normal = directions - gradients * (radius_m / (radius_m + heights))[:, None]
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def angles_deg(a: Floats, b: Floats) -> Floats:
    """Angles between unit vectors, accurate for small ones."""
    return np.degrees(2.0 * np.arcsin(np.minimum(np.linalg.norm(a - b, axis=-1) / 2.0, 1.0)))


def camera_coordinates(camera: CameraState, points_from_camera_m: Floats) -> Floats:
    """(right, up, forward) of camera-relative points (..., 3)."""
    return points_from_camera_m @ camera.axes.T


def screen(camera: CameraState, local: Floats, size: tuple[int, int]) -> Floats:
    """Pixels (..., 2) of camera coordinates with forward > 0, row 0 on top."""
    width, height = size
    x = (local[..., 0] / local[..., 2] - camera.tan_left) / (camera.tan_right - camera.tan_left)
    y = (camera.tan_top - local[..., 1] / local[..., 2]) / (camera.tan_top - camera.tan_bottom)
    return np.stack([x * width, y * height], axis=-1)
