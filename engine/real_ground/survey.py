"""What tiles of elevation hold, all of them read once: ranges, gaps, and a picture of where there is any."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .tile_files import TileError, read_tile
from .tile_index import TileSet

__all__ = ["SetFacts", "begin_survey", "draw_tile", "survey"]

Floats = NDArray[np.float64]


@dataclass
class SetFacts:
    """Of one set: bounds in degrees (south, west, north, east), heights in metres, shares and counts."""

    tiles: TileSet
    bounds_deg: tuple[float, float, float, float]
    lowest_m: float = np.inf
    highest_m: float = -np.inf
    samples: int = 0
    voids: int = 0
    broken: list[str] = field(default_factory=list)

    @property
    def missing(self) -> int:
        """Tiles of the set's size that its bounds have room for and that are not there."""
        where = self.tiles.where
        size = np.median(where[:, 2:], axis=0)
        # Tiles may share their border samples.
        step = np.array([_step(where[:, k], size[k]) for k in range(2)])
        first, last = where[:, :2].min(axis=0), where[:, :2].max(axis=0)
        room = np.round((last - first) / step) + 1.0
        return max(int(room.prod()) - len(np.unique(where[:, :2], axis=0)), 0)


def _step(starts: NDArray[np.int64], size: float) -> float:
    apart = np.diff(np.unique(starts))
    near = apart[apart >= 0.5 * size]
    return float(near.min()) if len(near) else max(size, 1.0)


def survey(
    sets: Sequence[TileSet], longest_px: int = 0, progress: Callable[[int, int], None] | None = None
) -> tuple[list[SetFacts], Floats | None]:
    """Facts of each set, and a picture of heights (rows, columns) in degrees, north on top and NaN where there are
    none, whose longer side has longest_px; None for 0. Of places that several sets have, the finest one's."""
    found, shape, corner, scale = begin_survey(sets, longest_px)
    picture = np.full(shape, np.nan) if longest_px else None
    total, done = sum(map(len, sets)), 0
    for facts in reversed(found):  # the finest last, over the others
        for number in range(len(facts.tiles)):
            file, where = facts.tiles.tile(number)
            try:
                values = read_tile(file, where, facts.tiles.folder.png) + np.float32(facts.tiles.folder.geoid_m)
            except (TileError, OSError) as error:
                facts.broken.append(str(error))
                continue
            there = ~np.isnan(values)
            facts.samples += values.size
            facts.voids += int(values.size - there.sum())
            if there.any():
                facts.lowest_m = min(facts.lowest_m, float(np.nanmin(values)))
                facts.highest_m = max(facts.highest_m, float(np.nanmax(values)))
            if picture is not None:
                draw_tile(picture, facts.tiles, values, there, (where.column, where.row), corner, scale)
            done += 1
            if progress is not None:
                progress(done, total)
    return found, picture


def begin_survey(
    sets: Sequence[TileSet], longest_px: int
) -> tuple[list[SetFacts], tuple[int, int], tuple[float, float], float]:
    """Facts of sets of which none has been read, and of a picture of all of them its shape (rows, columns), its corner
    (north, west) in degrees and pixels by degree."""
    found = [SetFacts(tiles, tiles.bounds_deg()) for tiles in sets]
    bounds = np.array([facts.bounds_deg for facts in found])
    south, west = bounds[:, :2].min(axis=0)
    north, east = bounds[:, 2:].max(axis=0)
    scale = longest_px / max(north - south, east - west, 1e-9)
    scale = min(scale, 1.0 / min(tiles.lattice.step_deg for tiles in sets))  # no pixel is smaller than a sample
    shape = max(int(np.ceil((north - south) * scale)), 1), max(int(np.ceil((east - west) * scale)), 1)
    return found, shape, (float(north), float(west)), float(scale)


def draw_tile(
    picture: NDArray[Any], tiles: TileSet, values: NDArray[Any], there: NDArray[np.bool_], first: tuple[int, int],
    corner: tuple[float, float], scale: float,
) -> None:  # fmt: skip
    """The pixels that a tile covers, from its nearest samples. first: its first column and row."""
    lattice = tiles.lattice
    rows, columns = np.arange(values.shape[0]) + first[1], np.arange(values.shape[1]) + first[0]
    latitude, longitude = lattice.place(np.zeros(len(rows)), rows)[0], lattice.place(columns, np.zeros(len(columns)))[1]
    y, x = (corner[0] - latitude) * scale, (longitude - corner[1]) * scale
    j = np.arange(max(int(np.floor(y[0])), 0), min(int(np.ceil(y[-1])) + 1, picture.shape[0]))
    i = np.arange(max(int(np.floor(x[0])), 0), min(int(np.ceil(x[-1])) + 1, picture.shape[1]))
    if not len(i) or not len(j):
        return
    at_row = np.clip(np.searchsorted(y, j + 0.5), 0, len(y) - 1)
    at_column = np.clip(np.searchsorted(x, i + 0.5), 0, len(x) - 1)
    part = np.ix_(at_row, at_column)
    target = picture[j[0] : j[-1] + 1, i[0] : i[-1] + 1]
    target[there[part]] = values[part][there[part]]
