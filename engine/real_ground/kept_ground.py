"""Levels of real ground on disk: what was read from tiles once, and how far reading has come when it was cut off.

Files lie in the cache folder, named after all they come from: names, sizes and times of the tiles, and the memory that
the levels may take. They are written beside and renamed. What can't be read counts as absent.
"""

from __future__ import annotations

import contextlib
import logging
import os
import time
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import get_ident
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from ..table_cache import TableCache
from .lattice import Lattice
from .pages import PageLevel
from .raw_level import RawLevel
from .real_ground import RealGround

__all__ = ["Keeper", "lattice_of", "lattice_row", "level_arrays", "level_of", "read_arrays", "write_arrays"]

log = logging.getLogger(__name__)

_FORMAT = 1
EVERY_S = 20.0
"""So often what was read so far is written."""


class Keeper:
    """The files of one map. stamp: all that it follows from."""

    def __init__(self, stamp: tuple[object, ...], most_bytes: int) -> None:
        cache = TableCache("real_ground")
        self._key = TableCache.key(repr(stamp), str(most_bytes), str(_FORMAT))
        self._folder = cache.folder
        self._written_s = time.monotonic()

    @property
    def file(self) -> Path | None:
        """Where the levels are or will be; None without a cache folder."""
        return None if self._folder is None else self._folder / f"{self._key}.npz"

    def load(self) -> RealGround | None:
        held = read_arrays(self.file)
        if held is None:
            return None
        try:
            factors = tuple(int(v) for v in held["factors"])
            levels = tuple(level_of(held, k) for k in range(len(factors)))
            low, high = (float(v) for v in held["bounds"])
            return RealGround(levels, factors, tuple(int(v) for v in held["finest_of"]), low, high)
        except (KeyError, ValueError, TypeError) as error:
            log.warning("%s holds something else than was expected and will be written again: %r", self.file, error)
            return None

    def save(self, ground: RealGround) -> Path | None:
        """The file, None where none could be written."""
        arrays: dict[str, NDArray[Any]] = {
            "factors": np.array(ground.factors),
            "finest_of": np.array(ground.finest_of),
            "bounds": np.array([ground.lowest_m, ground.highest_m]),
        }
        for k, level in enumerate(ground.levels):
            arrays |= level_arrays(level, k)
        written = write_arrays(self.file, arrays)
        if self._folder is not None:
            for part in self._folder.glob(f"{self._key}.*.reading.npz"):
                part.unlink(missing_ok=True)
        return self.file if written else None

    def began(self, number: int) -> tuple[int, RawLevel] | None:
        """How many tiles of a set were read before, and what they gave."""
        held = read_arrays(self._part(number))
        if held is None:
            return None
        found = RawLevel(lattice_of(held["lattice"]))
        for key, block in zip(held["keys"].tolist(), held["blocks"], strict=True):
            found.blocks[key[0], key[1]] = block
        for key, block in zip(held["counted"].tolist(), held["counts"], strict=True):
            found.counts[key[0], key[1]] = block
        return int(held["done"]), found

    def keep(self, number: int, done: int, raw: RawLevel) -> None:
        """Write what the first `done` tiles of a set gave, now and then."""
        if time.monotonic() - self._written_s < EVERY_S:
            return
        side = (0, 0, 0)
        write_arrays(
            self._part(number),
            {
                "done": np.array(done),
                "lattice": lattice_row(raw.lattice),
                "keys": np.array(list(raw.blocks), np.int64).reshape(-1, 2),
                "blocks": np.stack(list(raw.blocks.values())) if raw.blocks else np.zeros(side, np.float32),
                "counted": np.array(list(raw.counts), np.int64).reshape(-1, 2),
                "counts": np.stack(list(raw.counts.values())) if raw.counts else np.zeros(side, np.uint16),
            },
        )
        self._written_s = time.monotonic()

    def _part(self, number: int) -> Path | None:
        return None if self._folder is None else self._folder / f"{self._key}.{number}.reading.npz"


_ARRAYS = ("heights", "weights", "of_weights", "where", "polar", "roughness")


def read_arrays(file: Path | None) -> dict[str, NDArray[Any]] | None:
    """What a file holds; None where there is none, or half of one."""
    if file is None:
        return None
    try:
        with np.load(file, allow_pickle=False) as held:
            with contextlib.suppress(OSError):
                os.utime(file)  # what is used is kept
            return {name: held[name] for name in held.files}
    except FileNotFoundError:
        return None
    except Exception as error:  # zip and numpy raise what they like for half a file
        log.warning("%s cannot be used and will be written again: %s", file, error)
        return None


def write_arrays(file: Path | None, arrays: Mapping[str, NDArray[Any]], small: bool = False) -> bool:
    """Beside, and renamed; whether it could be written. small: compressed a little, which takes least time."""
    if file is None:
        return False
    beside = file.with_suffix(f".{os.getpid()}-{get_ident()}.part")
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with beside.open("wb") as out:
            if small:
                _write_small(out, arrays)
            else:
                write: Callable[..., None] = np.savez
                write(out, **arrays)
        beside.replace(file)
    except OSError as error:
        log.warning("%s cannot be written: %s", file, error)
        with contextlib.suppress(OSError):
            beside.unlink(missing_ok=True)
        return False
    return True


def _write_small(out: IO[bytes], arrays: Mapping[str, NDArray[Any]]) -> None:
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as packed:
        for name, values in arrays.items():
            with packed.open(f"{name}.npy", "w") as part:
                np.lib.format.write_array(part, values, allow_pickle=False)


def lattice_row(lattice: Lattice) -> NDArray[np.float64]:
    return np.array([float(lattice.mercator), lattice.across, lattice.down, lattice.phase_x, lattice.phase_y])


def lattice_of(row: NDArray[Any]) -> Lattice:
    mercator, across, down, phase_x, phase_y = (float(v) for v in row)
    return Lattice(bool(mercator), across, down, phase_x, phase_y)


def level_arrays(level: PageLevel, k: int) -> dict[str, NDArray[Any]]:
    """Arrays of the k-th level; `level_of` makes it of them again."""
    arrays: dict[str, NDArray[Any]] = {f"{name}{k}": getattr(level, name) for name in _ARRAYS}
    return arrays | {f"lattice{k}": lattice_row(level.lattice), f"finest{k}": np.array(level.finest)}


def level_of(held: Mapping[str, NDArray[Any]], k: int) -> PageLevel:
    arrays = {name: held[f"{name}{k}"] for name in _ARRAYS}
    return PageLevel(lattice_of(held[f"lattice{k}"]), finest=bool(held[f"finest{k}"]), **arrays)
