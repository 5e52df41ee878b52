"""Levels of pictures of the ground on disk, read from tiles once: in the cache folder, named after all they come from.

Written beside and renamed. What can't be read counts as absent.
"""

from __future__ import annotations

import logging
import os
from dataclasses import astuple
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..table_cache import TableCache
from .color_ground import ColorGround, ColorPages, ColorSet
from .lattice import Lattice

__all__ = ["KeptColors"]

log = logging.getLogger(__name__)

_FORMAT = 1


class KeptColors:
    """The file of one map. stamp: all that it follows from."""

    def __init__(self, stamp: tuple[object, ...]) -> None:
        folder = TableCache("real_colors").folder
        key = TableCache.key(repr(stamp), str(_FORMAT))
        self.file: Path | None = None if folder is None else folder / f"{key}.npz"

    def load(self) -> ColorGround | None:
        if self.file is None:
            return None
        try:
            with np.load(self.file, allow_pickle=False) as held:
                return _ground(held)
        except FileNotFoundError:
            return None
        except Exception as error:  # zip and numpy raise what they like for half a file
            log.warning("%s cannot be used: %s; write it again with planetfall map make", self.file, error)
            return None

    def save(self, found: ColorGround) -> bool:
        """Whether it could be written."""
        if self.file is None:
            return False
        arrays: dict[str, NDArray[Any]] = {"levels": np.array([len(each.levels) for each in found.sets])}
        levels = [(each, k) for each in found.sets for k in range(len(each.levels))]
        for number, (each, k) in enumerate(levels):
            level = each.levels[k]
            arrays[f"lattice{number}"] = np.array([*map(float, astuple(level.lattice)), each.octaves[k]])
            arrays[f"pixels{number}"], arrays[f"where{number}"] = level.pixels, level.where
        beside = self.file.with_suffix(f".{os.getpid()}.part")
        try:
            self.file.parent.mkdir(parents=True, exist_ok=True)
            with beside.open("wb") as out:
                write: Any = np.savez
                write(out, **arrays)
            beside.replace(self.file)
        except OSError as error:
            log.warning("%s cannot be written: %s", self.file, error)
            beside.unlink(missing_ok=True)
            return False
        return True


def _ground(held: Any) -> ColorGround:
    sets, number = [], 0
    for count in held["levels"].tolist():
        levels, octaves = [], []
        for _ in range(count):
            mercator, across, down, phase_x, phase_y, octave = (float(v) for v in held[f"lattice{number}"])
            lattice = Lattice(bool(mercator), across, down, phase_x, phase_y)
            levels.append(ColorPages(lattice, held[f"pixels{number}"], held[f"where{number}"]))
            octaves.append(octave)
            number += 1
        sets.append(ColorSet(tuple(levels), tuple(octaves)))
    return ColorGround(tuple(sets))
