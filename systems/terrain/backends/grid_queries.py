"""The height of the drawn ground, for the cells of the projected grid."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....engine.frame import Proxy
from ....engine.gpu.cell_mesh import CellMesh
from ....engine.surface.decimation import decimated_indices, falling, variant_skips
from ....engine.surface.lattice import FULL_BITS, locate
from ....engine.surface.projected_grid import FINEST, ProjectedGrid, Tessellation

__all__ = ["heights_on_cells", "heights_on_patches", "triangles_of_cells"]


def heights_on_cells(mesh: CellMesh, unit: NDArray[np.float64], proxy: Proxy) -> NDArray[np.float64]:
    """Heights (N,) of the triangle of the drawn mesh below each unit direction (N, 3), intersected with its radius in
    f64; NaN where none was drawn. Reads back from the GPU."""
    result = np.full(len(unit), np.nan)
    cells, vertices = mesh.read_cells(), mesh.read_vertices()
    radius = proxy.cell.radius_m
    face, i_full, j_full = locate(unit)
    index_of = {(int(c["face"]), int(c["level"]), int(c["i"]), int(c["j"])): k for k, c in enumerate(cells)}
    levels = sorted({int(level) for level in cells["level"]}, reverse=True)
    for n in range(len(unit)):
        for level in levels:
            shift = FULL_BITS - level
            i, j = int(i_full[n]) >> shift, int(j_full[n]) >> shift
            found = index_of.get((int(face[n]), level, i, j))
            if found is not None:
                a = (float(i_full[n]) / 2.0**shift - i) * mesh.quads
                b = (float(j_full[n]) / 2.0**shift - j) * mesh.quads
                result[n] = _height_on_quads(vertices[found], cells[found], mesh.quads, a, b, unit[n], proxy) - radius
                break
    return result


def _height_on_quads(
    vertices: NDArray[np.void], cell: np.void, quads: int, a: float, b: float, unit: NDArray[np.float64], proxy: Proxy
) -> float:
    """Distance from the centre along `unit` of the drawn patch near grid coordinates (a, b)."""
    side = quads + 1
    mask = [(int(cell["edge_mask"]) >> (8 * e)) & 255 for e in range(4)]
    step_x, step_y = (1 << int(s) for s in variant_skips(cell["variant"]))

    def vertex(x: int, y: int) -> NDArray[np.float64]:
        # The same rule as cell_masked_vertex in common/cells.glsl.
        across = mask[0] if x == 0 else mask[1] if x == quads else 0
        along = mask[2] if y == 0 else mask[3] if y == quads else 0
        x, y = (x >> along) << along, (y >> across) << across
        return proxy.anchor_m + vertices[y * side + x]["position_m"].astype(np.float64)

    middle_x, middle_y = (min(int(c) // s, quads // s - 1) for c, s in ((a, step_x), (b, step_y)))
    best, best_error = np.nan, np.inf
    # Masked edges and heights shift triangles a little: look at the neighbours too.
    for y in range(max(middle_y - 1, 0), min(middle_y + 2, quads // step_y)):
        for x in range(max(middle_x - 1, 0), min(middle_x + 2, quads // step_x)):
            left, right, low, high = x * step_x, (x + 1) * step_x, y * step_y, (y + 1) * step_y
            p, q, s, t = vertex(left, low), vertex(right, low), vertex(right, high), vertex(left, high)
            falls = bool(falling(cell["variant"], x, y, quads))
            for triangle in ((p, q, t), (q, s, t)) if falls else ((p, q, s), (p, s, t)):
                matrix = np.column_stack(triangle)
                scale = np.abs(matrix).max()
                try:
                    weights = np.linalg.solve(matrix / scale, unit)
                except np.linalg.LinAlgError:
                    continue  # two corners were moved onto one another along a coarser edge
                if abs(weights.sum()) < 1e-12:
                    continue
                outside = -min(float(weights.min() / weights.sum()), 0.0)
                if outside < best_error:
                    best, best_error = scale / float(weights.sum()), outside
    return best


def triangles_of_cells(cells: NDArray[np.void], quads: int) -> NDArray[np.int64]:
    """Triangles (N, 3) of cells (read_cells) as numbers of vertices, cell after cell; those without area left out."""
    indices, ranges = decimated_indices(quads)
    side = quads + 1
    mask = cells["edge_mask"].astype(np.int64)[:, None]
    y, x = np.divmod(np.arange(side**2), side)
    # The same rule as cell_masked_vertex in common/cells.glsl.
    across = np.where(x == 0, mask & 255, np.where(x == quads, mask >> 8 & 255, 0))
    along = np.where(y == 0, mask >> 16 & 255, np.where(y == quads, mask >> 24 & 255, 0))
    vertex = ((y >> across) << across) * side + ((x >> along) << along)
    vertex += (np.arange(len(cells)) * side**2)[:, None]
    found = [np.zeros((0, 3), np.int64)]
    for variant in np.unique(cells["variant"]):
        first, count = ranges[variant].astype(int)
        patch = indices[first : first + count].astype(np.int64)
        found.append(vertex[cells["variant"] == variant][:, patch].reshape(-1, 3))
    triangles = np.concatenate(found)
    a, b, c = triangles.T
    return triangles[(a != b) & (b != c) & (c != a)]


def heights_on_patches(
    grid: ProjectedGrid, cut: Tessellation, vertices_m: NDArray[np.float64], unit: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Heights (N,) of the paper grid's triangle below each unit direction (N, 3); NaN beyond the grid.

    vertices_m: of all patches, planet-centred (V, 3).
    """
    result = np.full(len(unit), np.nan)
    places = grid.locate(unit)
    known = np.flatnonzero(np.isfinite(places[:, 0]))
    square = np.clip(places[known] // FINEST, 0, grid.patches - 1).astype(np.int64)
    row_of = np.empty((grid.patches, grid.patches), np.int64)
    row_of[cut.i, cut.j] = np.arange(len(cut))
    faces = cut.faces()
    owner = np.searchsorted(cut.first, faces[:, 0], side="right") - 1
    order = np.argsort(owner, kind="stable")
    faces, ends = faces[order], np.searchsorted(owner[order], np.arange(len(cut) + 1))
    for n, (i, j) in zip(known, square, strict=True):
        row = row_of[i, j]
        corners = vertices_m[faces[ends[row] : ends[row + 1]]]
        # The line along the direction meets a triangle where the shares of its corners have one sign.
        shares = np.stack([_volume(unit[n], corners[:, k - 2], corners[:, k - 1]) for k in range(3)], axis=1)
        total = shares.sum(axis=1)
        with np.errstate(divide="ignore", invalid="ignore"):
            least = (shares / total[:, None]).min(axis=1)
        best = int(np.nanargmax(least))
        weights = shares[best] / total[best]
        result[n] = float(np.linalg.norm(weights @ corners[best])) - grid.radius_m
    return result


def _volume(direction: NDArray[np.float64], a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.cross(a, b) @ direction
