"""Vertices of tiles as they are drawn, quadtree and icosphere, against extended precision, level by level."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Ocean, Renderer, Scene, Terrain
from ...engine.surface.icosphere import vector_of
from ...engine.surface.lattice import FULL
from ...engine.surface.triangle_patch import vertex_place
from ...systems.terrain.backends.paper_quadtree import PaperQuadtreeBackend
from .. import exact
from .positions import PIXEL_RAD

SIZE = (192, 108)
_SMALLER = 1080 / SIZE[1]
OVERRIDES: dict[str, Any] = {
    "terrain.backend": "quadtree",
    "terrain.edge_px": 10.0 / _SMALLER,
    "terrain.error_px": 1.0 / _SMALLER,
    "terrain.min_spacing_m": 0.03,
    "terrain.slots": 8192,
}
"""Tiles as a picture of 1080 rows has them: vertices are 5 to 20 of its pixels apart."""


def smooth(scene: Scene) -> Scene:
    """The same planet with hardly any relief and no sea: places are what is measured, not heights."""
    scene.planet.remove(Ocean)
    terrain = scene.planet[Terrain]
    terrain.layers, terrain.lowest_m, terrain.highest_m = 1, -1.0, 1.0
    return scene


def worst_px_by_level(renderer: Renderer, camera: Camera) -> dict[int, float]:
    """The largest angle, in pixels of PIXEL_RAD, between where a vertex is drawn and where it belongs, by the level of
    its tile. Vertices that morph or are masked along an edge are left out.

    Where it belongs: on its lattice point's zenith, or for method "paper" on the normal between the chunk's corners.
    """
    renderer.settle(camera)
    renderer.render(camera)
    system: Any = renderer.system("terrain")
    mesh = system.backend.view(renderer.views[0]).mesh
    proxy = renderer.views[0].proxy
    position = renderer.camera_state(camera).position_m
    with renderer.current():
        vertices = mesh.read_vertices()
    offset = (position - proxy.anchor_m).astype(np.float32)
    still = (mesh.rows["morph"] == 0.0) & (mesh.rows["edge_morph"] == 0.0).all(axis=1)
    seen = vertices["position_m"][still] - offset
    directions = _directions(mesh, mesh.keys[still], isinstance(system.backend, PaperQuadtreeBackend))
    radius = proxy.cell.radius_m + proxy.anchor_height_m + vertices["dh_m"][still].astype(exact.Real)
    truth = directions * radius[..., None] - position.astype(exact.Real)
    angle = exact.angle_between(seen, truth) / PIXEL_RAD
    # Nearer than this the near plane hides a vertex.
    angle[np.linalg.norm(truth.astype(np.float64), axis=-1) < 0.05] = 0.0
    on_edge = _on_edges(mesh.shape)
    skips = mesh.rows["edge_skip"][still][:, None] >> (8 * np.arange(on_edge.shape[1])).astype(np.uint32) & 255
    angle[(on_edge[None] & (skips > 0)[:, None]).any(axis=2)] = 0.0
    levels = mesh.shape.scheme.level(mesh.keys[still])
    return {int(level): float(angle[levels == level].max()) for level in np.unique(levels)}


def _on_edges(shape: Any) -> NDArray[np.bool_]:
    """(vertices, edges)."""
    n = shape.segments
    if shape.scheme.edges == 3:
        p, q = vertex_place(np.arange(shape.vertices), n)
        return np.stack([q == 0, p + q == n, p == 0], axis=1)
    b, a = np.divmod(np.arange((n + 1) ** 2), n + 1)
    return np.stack([a == 0, a == n, b == 0, b == n], axis=1)


def _directions(mesh: Any, keys: NDArray[np.int64], printed: bool) -> NDArray[np.longdouble]:
    if mesh.shape.scheme.edges == 3:
        vectors = vector_of(*mesh.shape.points(keys)).astype(exact.Real)
        return vectors / np.sqrt((vectors * vectors).sum(axis=-1, keepdims=True))
    if not printed:
        return exact.lattice_direction(*mesh.shape.points(keys))
    face, i, j = (p.reshape(len(keys), mesh.shape.side, mesh.shape.side) for p in mesh.shape.points(keys))
    assert (i <= FULL).all() and (j <= FULL).all()
    ends = [0, -1]
    corner = exact.lattice_direction(face[:, ends][:, :, ends], i[:, ends][:, :, ends], j[:, ends][:, :, ends])
    t = np.linspace(0.0, 1.0, mesh.shape.side).astype(exact.Real)[:, None]
    along = corner[:, :, :1] * (1 - t) + corner[:, :, 1:] * t  # (N, 2, side, 3)
    up = along[:, :1] * (1 - t)[:, None] + along[:, 1:] * t[:, None]
    up = up.reshape(len(keys), -1, 3)
    return up / np.sqrt((up * up).sum(axis=-1, keepdims=True))
