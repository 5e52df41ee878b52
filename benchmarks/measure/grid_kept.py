"""How many vertices of the printed grid are found again after it has moved (Michelic et al. 2019)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer, view
from ...engine.space import CameraState
from ...engine.surface.coverage import proxy_coverage
from ...engine.surface.grid_place import cell_rad, placed, turned
from ...engine.surface.projected_grid import FINEST, MOST_LEVEL, ProjectedGrid, Tessellation
from ...engine.surface.selection import spacing_angle

Floats = NDArray[np.float64]

NEAR = 0.1
"""Of its distance from its neighbours, within which a vertex is found again."""
_FOOT = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])


@dataclass(frozen=True)
class Kept:
    """Shares of a grid's vertices that one before it had: of the points of the grid itself, and of all that its patches
    are cut into."""

    points: float
    vertices: float


@dataclass(frozen=True)
class Sight:
    """An altitude above ground, and what a camera of so many rows across 60 degrees cuts edges by."""

    altitude_m: float
    corners: int = 100
    power: int = 4
    rows: int = 360
    edge_px: float = 8.0
    radius_m: float = 6.371e6
    highest_m: float = 9000.0

    def grid(self, held: ProjectedGrid | None, camera: Floats) -> ProjectedGrid:
        """The grid of a camera above a direction (3,)."""
        seen = proxy_coverage(self.altitude_m, 0.0, self.radius_m, self.highest_m)
        return placed(held, camera, camera, seen, self.corners, self.power, self.radius_m)

    @property
    def cell_m(self) -> float:
        """Width of a cell in the middle of the grid."""
        return cell_rad(self.grid(None, _FOOT).z_s, self.corners) * self.radius_m

    def cut(self, grid: ProjectedGrid, proxy: Floats) -> Tessellation:
        """Its patches, seen from the altitude above a direction (3,)."""
        pixel_rad = 2.0 * np.tan(np.radians(30.0)) / self.rows
        angle = spacing_angle(self.edge_px, pixel_rad, self.altitude_m, self.radius_m)
        return grid.tessellate(self.altitude_m, 0.0, angle, proxy=proxy)


def kept(sight: Sight, before: ProjectedGrid, after: ProjectedGrid, way: tuple[Floats, Floats]) -> Kept:
    """way: the proxies' directions before and after."""
    whole = [_points(g, np.zeros(g.patches**2, np.int64)) for g in (before, after)]
    fine = [_points(g, _levels(g, sight.cut(g, at))) for g, at in zip((before, after), way, strict=True)]
    return Kept(*(_share(old[0], *new) for old, new in (whole, fine)))


def level_flight(sight: Sight, moves: int) -> list[Kept]:
    """A camera flies on at its altitude, askew to the grid's axes, until the grid has moved so many times."""
    grid = sight.grid(None, _FOOT)
    heading = np.cross(grid.axes[0] + 0.3 * grid.axes[1], _FOOT)
    ahead = np.cross(_FOOT, heading / np.linalg.norm(heading))
    found, step, angle, last = [], 0.1 * cell_rad(grid.z_s, grid.corners), 0.0, _FOOT
    while len(found) < moves:
        angle += step
        camera = np.cos(angle) * _FOOT + np.sin(angle) * ahead
        now = sight.grid(grid, camera)
        if now is not grid:
            found.append(kept(sight, grid, now, (last, camera)))
        grid, last = now, camera
    return found


def level_cameras(renderer: Renderer, altitude_m: float, step_m: float, steps: int) -> list[CameraState]:
    """States of a camera that flies level, from above the view "near" on, at an altitude above the scene's ground."""
    over = renderer.camera_state(view("near"))
    up = over.position_m / np.linalg.norm(over.position_m)
    radius_m = renderer.scene.planet.radius_m
    ground_m = float(renderer.scene.planet.surface_height_m(up[None])[0])
    start = over.moved(up * (radius_m + ground_m + altitude_m))
    level = start.forward - up * (start.forward @ up)
    level /= np.linalg.norm(level)
    found = []
    for k in range(steps):
        angle = k * step_m / radius_m
        above = np.cos(angle) * up + np.sin(angle) * level
        height = float(renderer.scene.planet.surface_height_m(above[None])[0])
        found.append(start.moved(above * (radius_m + height + altitude_m)))
    return found


def flown(renderer: Renderer, cameras: Sequence[CameraState]) -> tuple[list[Kept], list[Kept]]:
    """Along a flight, of the meshes that are drawn: snaps at which the grid moved, and those at which patches were cut
    anew alone."""
    moves: list[Kept] = []
    cuts: list[Kept] = []
    before: tuple[int, ProjectedGrid, Tessellation] | None = None
    for state in cameras:
        renderer.render(Camera(state.position_m, state.forward, state.up), dt_s=1.0)
        system: Any = renderer.system("terrain")
        view = system.backend.view(renderer.views[0])
        if before is not None and before[0] != view.selection:
            points = [_points(g, np.zeros(g.patches**2, np.int64)) for g in (before[1], view.grid)]
            vertices = [_points(g, _levels(g, cut)) for g, cut in (before[1:], (view.grid, view.cut))]
            shares = Kept(*(_share(old[0], *new) for old, new in (points, vertices)))
            (cuts if view.grid is before[1] else moves).append(shares)
        before = (view.selection, view.grid, view.cut)
    return moves, cuts


def most_points(sight: Sight, steps: int = 12, turns: int = 3) -> tuple[float, tuple[float, float, float]]:
    """The largest share of the grid's points that any move of half a cell or more keeps, and that move: cells along
    both axes (up to two, by `steps`), and degrees by which it is turned about its middle."""
    grid = sight.grid(None, _FOOT)
    cell = cell_rad(grid.z_s, grid.corners)
    before, _ = _points(grid, np.zeros(grid.patches**2, np.int64))
    best = (0.0, (0.0, 0.0, 0.0))
    for i in range(steps + 1):
        for j in range(i + 1):  # the grid is the same along its other axis
            a, b = 2.0 * i / steps, 2.0 * j / steps
            if max(a, b) < 0.5:
                continue
            axes = turned(turned(grid.axes, 0, a * cell), 1, b * cell)
            for twist in np.radians(np.linspace(-0.5, 0.5, turns)):
                cosine, sine = np.cos(twist), np.sin(twist)
                u, v, w = axes
                turned_axes = np.stack([cosine * u + sine * v, cosine * v - sine * u, w])
                share = _share(before, *_points(replace(grid, axes=turned_axes), np.zeros(grid.patches**2, np.int64)))
                best = max(best, (share, (a, b, float(np.degrees(twist)))))
    return best


def _levels(grid: ProjectedGrid, cut: Tessellation) -> NDArray[np.int64]:
    """Levels of patches by place."""
    found = np.zeros(grid.patches**2, np.int64)
    found[cut.i * grid.patches + cut.j] = cut.level
    return found


def _points(grid: ProjectedGrid, level: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Vertices (N, 3) on the sphere, once each, and their distances (N,) from neighbours, the smaller ones."""
    i, j = np.divmod(np.arange(grid.patches**2), grid.patches)
    codes, steps, side = [], [], grid.steps() + 1
    for finer in range(MOST_LEVEL, -1, -1):
        rows = np.flatnonzero(level == finer)
        b, a = np.divmod(np.arange(((1 << finer) + 1) ** 2), (1 << finer) + 1)
        step = FINEST >> finer
        codes.append((((i[rows] * FINEST)[:, None] + a * step) * side + (j[rows] * FINEST)[:, None] + b * step).ravel())
        steps.append(np.full(codes[-1].size, step))
    code, first = np.unique(np.concatenate(codes), return_index=True)  # the finest patch of those that share it
    i, j = np.divmod(code, side)
    step = np.concatenate(steps)[first]
    foot = grid.foot_offsets_m(i, j)
    beside = [
        np.linalg.norm(grid.foot_offsets_m(*to) - foot, axis=1)
        for to in (
            (np.where(i + step < side, i + step, i - step), j),
            (i, np.where(j + step < side, j + step, j - step)),
        )
    ]
    return foot + grid.radius_m * grid.axes[2], np.minimum(*beside)


def _share(before: Floats, after: Floats, spacing_m: Floats) -> float:
    from scipy.spatial import KDTree

    distance, _ = KDTree(before).query(after)
    return float((distance < NEAR * spacing_m).mean())
