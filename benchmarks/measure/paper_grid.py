"""The projected grid's paper mode: its vertices against float64, and what it drops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer
from ...engine.surface.projected_grid import FINEST, MOST_LEVEL, ProjectedGrid, Tessellation
from ...systems.terrain.backends.paper_grid import PaperGridBackend
from ...systems.terrain.paper_ground import PaperField
from .drawn import camera_coordinates

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_VERTEX = np.dtype([("position_m", "f4", 3), ("dh_m", "f4"), ("normal", "u4"), ("attributes", "u1", 4)])


@dataclass(frozen=True, eq=False)
class PaperMesh:
    """All vertices of the last frame's grid and which patches were drawn."""

    grid: ProjectedGrid
    cut: Tessellation
    field: PaperField
    vertices: NDArray[np.void]
    patch: Ints
    """Of each vertex."""
    i: Ints
    j: Ints
    """Integer place of each vertex."""
    drawn: NDArray[np.bool_]
    """Of each patch."""
    anchor_m: Floats
    anchor_height_m: float
    eye_m: Floats
    """The proxy, planet-centred."""

    @classmethod
    def of(cls, renderer: Renderer) -> PaperMesh:
        """Of the last frame. RuntimeError when the ground was drawn by something else."""
        system: Any = renderer.system("terrain")
        backend = None if system is None else system.backend
        if not isinstance(backend, PaperGridBackend):
            raise RuntimeError("the ground is not drawn by the projected grid's paper mode")
        view = backend.view(renderer.views[0])
        cut, grid = view.cut, view.grid
        assert cut is not None and grid is not None
        side = (1 << cut.level) + 1
        patch = np.repeat(np.arange(len(cut)), side**2)
        local = np.arange(cut.vertices) - cut.first[patch]
        b, a = np.divmod(local, side[patch])
        step = FINEST >> cut.level[patch]
        with renderer.current():
            vertices = np.frombuffer(view.buffers["vertices"].read(cut.vertices * _VERTEX.itemsize), _VERTEX).copy()
            counts = np.frombuffer(view.buffers["counts"].read(4 * (MOST_LEVEL + 1)), "u4").astype(np.int64)
            visible = np.frombuffer(view.buffers["visible"].read(4 * len(cut)), "u4").astype(np.int64)
        drawn = np.zeros(len(cut), bool)
        first = 0
        for level in range(MOST_LEVEL, -1, -1):
            drawn[visible[first : first + counts[level]]] = True
            first += int(np.count_nonzero(cut.level == level))
        proxy = renderer.views[0].proxy
        field = renderer.world.resource("height_field")
        return cls(
            grid, cut, field, vertices, patch, cut.i[patch] * FINEST + a * step, cut.j[patch] * FINEST + b * step,
            drawn, proxy.anchor_m.copy(), proxy.anchor_height_m, proxy.cell.position_m,
        )  # fmt: skip

    def true_positions_m(self, chosen: Ints) -> Floats:
        """Planet-centred (N, 3) of vertices, in float64: the grid's directions and the twin's heights."""
        directions = self.grid.directions(self.i[chosen], self.j[chosen])
        return directions * (self.grid.radius_m + self.field.height(directions))[:, None]


@dataclass(frozen=True)
class VertexError:
    """How far vertices are from where float64 has them, as seen from the proxy."""

    worst_px: float
    p99_px: float
    worst_m: float
    vertices: int


def vertex_error(
    renderer: Renderer, camera: Camera, rng: np.random.Generator, most: int = 20_000, rows: int = 1080
) -> VertexError:
    """Of the vertices that the camera's grid has, in pixels of a picture with so many rows."""
    renderer.render(camera)
    mesh = PaperMesh.of(renderer)
    chosen = rng.choice(mesh.cut.vertices, min(most, mesh.cut.vertices), replace=False)
    truth = mesh.true_positions_m(chosen)
    drawn = mesh.anchor_m + mesh.vertices["position_m"][chosen].astype(np.float64)
    off = np.linalg.norm(drawn - truth, axis=1)
    state = renderer.camera_state(camera)
    pixel = state.pixel_rad(rows)
    pixels = off / np.linalg.norm(truth - mesh.eye_m, axis=1) / pixel
    return VertexError(float(pixels.max()), float(np.quantile(pixels, 0.99)), float(off.max()), len(chosen))


@dataclass(frozen=True)
class Culling:
    """What the frustum test dropped."""

    dropped_seen: int
    """Patches that were dropped although some point between lowest and highest ground lies in the picture."""
    kept_unseen: int
    patches: int
    drawn: int


def culling(renderer: Renderer, camera: Camera, points: int = 9, heights: int = 5) -> Culling:
    """Every patch against points x points of its own at several heights between the planet's lowest and highest
    ground. What it keeps and no point is in the picture may still be seen between the points."""
    renderer.render(camera)
    mesh, state = PaperMesh.of(renderer), renderer.camera_state(camera)
    place = (np.arange(points) * FINEST) // (points - 1)
    a, b = (n.ravel() for n in np.meshgrid(place, place))
    directions = mesh.grid.directions(mesh.cut.i[:, None] * FINEST + a, mesh.cut.j[:, None] * FINEST + b)
    seen = np.zeros(len(mesh.cut), bool)
    for height in np.linspace(mesh.field.lowest_m, mesh.field.highest_m, heights):
        where = (directions * (mesh.grid.radius_m + height)).reshape(-1, 3) - state.position_m
        x, y, z = camera_coordinates(state, where).T
        inside = (z > 0.0) & (x >= state.tan_left * z) & (x <= state.tan_right * z)
        inside &= (y >= state.tan_bottom * z) & (y <= state.tan_top * z)
        seen |= inside.reshape(directions.shape[:2]).any(axis=1)
    return Culling(
        int((seen & ~mesh.drawn).sum()), int((mesh.drawn & ~seen).sum()), len(mesh.cut), int(mesh.drawn.sum())
    )
