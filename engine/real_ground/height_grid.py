"""Heights of a map of tiles on one grid of rows and columns, for what runs from sample to sample.

The grid is the lattice of the finest set that lies in the box, or squares of k x k of its samples, whose height is the
mean of up to 4 x 4 of them. Values come from the levels that scenes draw, so several sets, gaps and projections are
what they are there: gaps of a few samples are closed, wider ones are NaN.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .lattice import Lattice, directions_at
from .real_ground import RealGround
from .resident import resident_ground
from .tile_files import TileError
from .tile_index import TileSet, open_tiles

__all__ = ["Box", "HeightGrid", "height_grid"]

Floats = NDArray[np.float64]
Progress = Callable[[int, int], None]
Box = tuple[float, float, float, float]
"""West, south, east, north, degrees."""

_READ_BYTES = 400_000_000
_TAPS = 4
"""Samples that a square's mean is made of, at most, along each side."""
_STEPS_PER_M = 1024.0
"""Heights are rounded to these: what is flat in a file is flat here."""
_BLOCK = 1 << 16
_LEAST = 3
"""Rows and columns without which there is no way down."""


@dataclass(frozen=True, eq=False)
class HeightGrid:
    """Heights (rows, columns), metres, NaN where there are none, north on top. edge_deg: latitudes (rows + 1,) of the
    rows' edges. step_m: between rows in the grid's middle; own_m: of the set's own samples there."""

    height_m: Floats
    latitude_deg: Floats
    longitude_deg: Floats
    edge_deg: Floats
    step_m: float
    own_m: float
    radius_m: float

    @property
    def column_rad(self) -> float:
        """Longitude between columns."""
        return float(np.radians(self.longitude_deg[1] - self.longitude_deg[0]))

    @property
    def degree_steps(self) -> tuple[float, float]:
        """Longitude and latitude between columns and between rows in the grid's middle."""
        middle = len(self.latitude_deg) // 2
        down = float(self.latitude_deg[middle - 1] - self.latitude_deg[middle])
        return float(self.longitude_deg[1] - self.longitude_deg[0]), down

    def degrees(self, column: Floats, row: Floats) -> Floats:
        """(K, 2) longitude and latitude of places between cells (K,), up to a cell beyond the border."""
        longitude = self.longitude_deg[0] + column * (self.longitude_deg[1] - self.longitude_deg[0])
        below = np.clip(np.floor(row), 0, len(self.latitude_deg) - 2).astype(np.int64)
        share = row - below
        latitude = self.latitude_deg[below] * (1.0 - share) + self.latitude_deg[below + 1] * share
        return np.stack([longitude, latitude], axis=1)


def height_grid(
    path: str,
    what: str,
    radius_m: float,
    box: Box | None = None,
    spacing_m: float | None = None,
    most_cells: int = 4_000_000,
    progress: Progress | None = None,
) -> HeightGrid:
    """The map at `path`, a folder or an index file, on a planet of that radius. box: what lies outside is left out.
    spacing_m: rounded to whole samples, and coarser where there would be more cells than most_cells. progress: (tiles
    read, of how many). TileError says what is wrong."""
    if box is not None:
        _check_box(box, what)
    found = open_tiles(path, what)
    sets = [each for each in (_within(tiles, box) for tiles in found) if each is not None]
    if not sets:
        bounds = np.array([tiles.bounds_deg() for tiles in found])
        (south, west), (north, east) = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
        raise TileError(
            f"{what}: --box {_said(box)}: no tile of {path} lies there; expected a box that meets west {west:g}, south "
            f"{south:g}, east {east:g}, north {north:g}"
        )
    lattice = sets[0].lattice
    column, row, columns, rows = _window(sets, lattice, box)
    middle = float(lattice.place(0.0, row + 0.5 * rows)[0])
    own_m = lattice.sample_m(radius_m) * (float(np.cos(np.radians(middle))) if lattice.mercator else 1.0)
    by = 1 if spacing_m is None else max(round(spacing_m / own_m), 1)
    while (columns // by) * (rows // by) > most_cells:
        by += 1
    columns, rows = columns // by, rows // by
    if min(columns, rows) < _LEAST:
        raise TileError(
            f"{what}: {columns} x {rows} cells of {by * own_m:.0f} m are left; expected {_LEAST} x {_LEAST} or more: "
            "give a larger box, or a smaller spacing"
        )
    ground = _coarse(resident_ground(sets, _READ_BYTES, what, progress, quiet=True), by)
    heights = _heights(ground, lattice, (column, row), (columns, rows), by)
    middles = 0.5 * (by - 1)
    latitude = lattice.place(np.zeros(rows), row + by * np.arange(rows) + middles)[0]
    longitude = lattice.place(column + by * np.arange(columns) + middles, np.zeros(columns))[1]
    edge = lattice.place(np.zeros(rows + 1), row + by * np.arange(rows + 1) - 0.5)[0]
    return HeightGrid(heights, latitude, longitude, edge.clip(-90.0, 90.0), by * own_m, own_m, radius_m)


def _said(box: Box | None) -> str:
    return "" if box is None else " ".join(f"{v:g}" for v in box)


def _check_box(box: Box, what: str) -> None:
    west, south, east, north = box
    if not (-180.0 <= west < east <= 180.0 and -90.0 <= south < north <= 90.0):
        raise TileError(
            f"{what}: --box {_said(box)}: expected WEST SOUTH EAST NORTH in degrees, west below east in -180 to 180 "
            "and south below north in -90 to 90; a box over the date line is two"
        )


def _within(tiles: TileSet, box: Box | None) -> TileSet | None:
    """The tiles of a set that meet the box."""
    if box is None:
        return tiles
    first, last = tiles.where[:, :2], tiles.where[:, :2] + tiles.where[:, 2:] - 1
    north, west = tiles.lattice.place(first[:, 0], first[:, 1])
    south, east = tiles.lattice.place(last[:, 0], last[:, 1])
    at = np.flatnonzero((west < box[2]) & (east > box[0]) & (south < box[3]) & (north > box[1]))
    if not at.size:
        return None
    return replace(tiles, names=[tiles.names[k] for k in at.tolist()], where=tiles.where[at])


def _window(sets: Sequence[TileSet], lattice: Lattice, box: Box | None) -> tuple[int, int, int, int]:
    """First column and row of a lattice, and how many of each, of all sets within the box."""
    bounds = np.array([tiles.bounds_deg() for tiles in sets])
    (south, west), (north, east) = bounds[:, :2].min(axis=0), bounds[:, 2:].max(axis=0)
    if box is not None:
        west, south, east, north = max(west, box[0]), max(south, box[1]), min(east, box[2]), min(north, box[3])
    left, top = lattice.index(*lattice.world(north, west))
    right, bottom = lattice.index(*lattice.world(south, east))
    slack = 1e-6  # samples on the border are in
    column, row = int(np.ceil(left - slack)), int(np.ceil(top - slack))
    return column, row, int(np.floor(right + slack)) - column + 1, int(np.floor(bottom + slack)) - row + 1


def _coarse(ground: RealGround, by: int) -> RealGround:
    """One level of each set: the coarsest that has _TAPS samples on a square's side, or the finest that there is."""
    most_m = by / _TAPS * ground.finest_m(1.0) * (1.0 + 1e-9)
    kept: dict[int, int] = {}
    for number, finest in enumerate(ground.finest_of):
        if finest == number or ground.levels[number].lattice.sample_m(1.0) <= most_m:
            kept[finest] = number
    levels = tuple(ground.levels[number] for number in sorted(kept.values()))
    return RealGround(levels, (0,) * len(levels), tuple(range(len(levels))), ground.lowest_m, ground.highest_m)


def _heights(ground: RealGround, lattice: Lattice, first: tuple[int, int], size: tuple[int, int], by: int) -> Floats:
    """(rows, columns) of squares of by x by samples from `first` (column, row) on."""
    taps = min(by, _TAPS)
    within = (np.arange(taps) + 0.5) * (by / taps) - 0.5
    columns = (by * np.arange(size[0])[:, None] + within).ravel()
    longitude = lattice.place(first[0] + columns, np.zeros(len(columns)))[1]
    rows_of = max(_BLOCK // max(len(longitude) * taps, 1), 1)

    def part(start: int) -> Floats:
        rows = np.arange(start, min(start + rows_of, size[1]))
        lines = (by * rows[:, None] + within).ravel()
        latitude = lattice.place(np.zeros(len(lines)), first[1] + lines)[0].clip(-90.0, 90.0)
        points = directions_at(latitude[:, None], longitude[None, :]).reshape(3, -1)
        height, rest = ground.heights(points)
        there = rest < 0.5
        value = np.where(there, height / np.maximum(1.0 - rest, 0.5), 0.0)
        shape = len(rows), taps, size[0], taps
        count, total = np.zeros((len(rows), size[0])), np.zeros((len(rows), size[0]))
        value, there = value.reshape(shape), there.reshape(shape)
        for j in range(taps):  # one after the other: numpy's own sums differ between processors
            for i in range(taps):
                count += there[:, j, :, i]
                total += value[:, j, :, i]
        mean = np.divide(total, count, out=np.full(count.shape, np.nan), where=count > 0.0)
        return np.rint(mean * _STEPS_PER_M) / _STEPS_PER_M

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return np.concatenate(list(pool.map(part, range(0, size[1], rows_of))))
