"""What tiles of elevation hold, all of them read once: ranges, gaps, and a picture of where there is any."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .found import Found, TileError, pieces
from .survey_picture import SetPicture
from .tile_files import read_tile
from .tile_index import TileSet
from .warped_files import file_grid, in_file

__all__ = ["SetFacts", "begin_survey", "survey"]

Floats = NDArray[np.float64]


@dataclass
class SetFacts:
    """Of one set: bounds in degrees (south, west, north, east; beyond the date line above 180), heights in metres,
    shares and counts, and how many files are in which coordinate system, (name, note)."""

    tiles: TileSet
    bounds_deg: tuple[float, float, float, float]
    lowest_m: float = np.inf
    highest_m: float = -np.inf
    samples: int = 0
    voids: int = 0
    broken: list[str] = field(default_factory=list)
    systems: Counter[tuple[str, str]] = field(default_factory=Counter)
    grids: dict[object, list[tuple[int, int, int, int]]] = field(default_factory=dict)
    """Of warped files: their places on the grid of pixels that they share, as TileSet.where."""

    @property
    def missing(self) -> int:
        """Tiles of the set's size that its bounds have room for and that are not there."""
        plain = self.tiles.turned[~self.tiles.warped]
        found = _missing(plain) if len(plain) else 0
        return found + sum(_missing(np.array(places, np.int64)) for places in self.grids.values())

    def see(self, file: Path, found: Found) -> None:
        """Take in the header of a file."""
        if not found.warped:
            self.systems["Mercator" if found.lattice.mercator else "degrees", ""] += 1
            return
        grid = file_grid(file)
        self.systems[grid.label, grid.note] += 1
        self.grids.setdefault(grid.key, []).append(grid.place)

    def count(self, file: Path, found: Found, there: NDArray[np.bool_]) -> None:
        """Take in samples of a file, and which of them there are."""
        if not found.warped:
            self.samples += there.size
            self.voids += int(there.size - there.sum())
            return
        inside = in_file(file, found)
        self.samples += int(inside.sum())
        self.voids += int((inside & ~there).sum())


def _missing(where: NDArray[np.int64]) -> int:
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
        drawn = None if picture is None else SetPicture(shape, facts.tiles.lattice, corner, scale, smooth=True)
        for number in range(len(facts.tiles)):
            file, where = facts.tiles.tile(number)
            try:
                for piece in pieces(where):
                    values = read_tile(file, piece, facts.tiles.folder.png) + np.float32(facts.tiles.folder.geoid_m)
                    there = ~np.isnan(values)
                    facts.count(file, piece, there)
                    if there.any():
                        facts.lowest_m = min(facts.lowest_m, float(np.nanmin(values)))
                        facts.highest_m = max(facts.highest_m, float(np.nanmax(values)))
                    if drawn is not None:
                        drawn.draw(values, there, (piece.column, piece.row))
                facts.see(file, where)
            except (TileError, OSError) as error:
                facts.broken.append(str(error))
                continue
            done += 1
            if progress is not None:
                progress(done, total)
        if picture is not None and drawn is not None:
            drawn.onto(picture)
    return found, picture


def begin_survey(
    sets: Sequence[TileSet], longest_px: int
) -> tuple[list[SetFacts], tuple[int, int], tuple[float, float], float]:
    """Facts of sets of which none has been read, and of a picture of all of them its shape (rows, columns), its corner
    (north, west) in degrees and pixels by degree. The picture is of the shorter way around the world."""
    found = [SetFacts(tiles, tiles.bounds_deg()) for tiles in sets]
    bounds = np.array([facts.bounds_deg for facts in found])
    south, north = bounds[:, 0].min(), bounds[:, 2].max()
    west, east = _around(bounds[:, 1], bounds[:, 3])
    scale = longest_px / max(north - south, east - west, 1e-9)
    scale = min(scale, 1.0 / min(tiles.lattice.step_deg for tiles in sets))  # no pixel is smaller than a sample
    shape = max(int(np.ceil((north - south) * scale)), 1), max(int(np.ceil((east - west) * scale)), 1)
    return found, shape, (float(north), float(west)), float(scale)


def _around(west: Floats, east: Floats) -> tuple[float, float]:
    """West and east of a window that has all of these, the shorter way around; each west of 180."""
    ways = [(start, max(_beyond(w, start) + e - w for w, e in zip(west, east, strict=True))) for start in west]
    best = min(ways, key=lambda way: (way[1] - way[0] > 360.0, way[1] - way[0]))
    if best[1] - best[0] >= 360.0 - 1e-9:
        return -180.0, 180.0
    return float(best[0]), float(best[1])


def _beyond(longitude: float, start: float) -> float:
    """The same longitude, counted east from a start."""
    return start + float(np.mod(longitude - start, 360.0))
