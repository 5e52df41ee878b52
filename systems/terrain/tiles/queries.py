"""The height of the drawn ground, on the tiles of a view."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ....engine.frame import Proxy
from ....engine.surface.keys import container_of
from .shape import TileShape

__all__ = ["heights_on_tiles"]

Floats = NDArray[np.float64]


class DrawnTiles(Protocol):
    """Tiles as they are drawn: a TileMesh, or what does as one."""

    keys: NDArray[np.int64]
    shape: TileShape

    def read_vertices(self) -> NDArray[np.void]:
        """(tiles, vertices) of VERTEX_DTYPE."""
        ...


def heights_on_tiles(mesh: DrawnTiles, unit: Floats, proxy: Proxy) -> Floats:
    """Heights (N,) above the reference sphere of the drawn triangle below or above each unit direction (N, 3), in f64;
    NaN where no tile was selected. Reads back from the GPU."""
    scheme, radius = mesh.shape.scheme, proxy.cell.radius_m
    order = np.argsort(mesh.keys)
    deepest = int(scheme.level(mesh.keys).max())
    at = container_of(scheme.at(unit, np.full(len(unit), deepest)), mesh.keys[order])
    vertices = mesh.read_vertices()["position_m"].astype(np.float64)
    triangles = mesh.shape.indices.reshape(-1, 3).astype(np.int64)
    heights = np.full(len(unit), np.nan)
    for row in np.unique(at[at >= 0]):
        places = np.flatnonzero(at == row)
        corner = vertices[order[row]][triangles]  # (T, 3, 3), from the anchor
        corner = corner[(np.abs(np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])) > 0.0).any(axis=1)]
        for place in places:
            heights[place] = _reach(corner, proxy.anchor_m, unit[place]) - radius
    return heights


def _reach(corner: Floats, anchor_m: Floats, zenith: Floats) -> float:
    """Distance from the planet's centre along a zenith to the triangle (of (T, 3, 3)) that it meets best."""
    a, u, v = corner[:, 0], corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]
    normal = np.cross(u, v)
    area = (normal * normal).sum(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        reach = ((anchor_m + a) * normal).sum(axis=1) / (normal @ zenith)
        point = zenith * reach[:, None] - anchor_m - a
        along_v = (np.cross(normal, u) * -point).sum(axis=1) / -area
        along_u = (np.cross(normal, v) * point).sum(axis=1) / -area
        outside = -np.minimum(np.minimum(along_u, along_v), 1.0 - along_u - along_v)
    outside[~np.isfinite(outside) | (reach <= 0.0)] = np.inf
    return float(reach[int(outside.argmin())])
