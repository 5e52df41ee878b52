"""Reading all samples of a set once, square by square: which blocks there are, ranges, slopes, and the next coarser
level. Cut off, it goes on where it was."""

from __future__ import annotations

import logging
import time
import zlib
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .kept_ground import read_arrays, write_arrays
from .lattice import Lattice
from .raw_level import BLOCK, RawLevel, means_of
from .tile_blocks import SUPER, TileBlocks

__all__ = ["EVERY_S", "BlockFile", "LevelFacts", "scan", "squares_of"]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Heights = NDArray[np.float32]
Ints = NDArray[np.int64]
Key = tuple[int, int]

EVERY_S = 20.0
"""So often how far a scan has come is written."""


@dataclass
class LevelFacts:
    """What is known of a level. found: its blocks, (n, 3) row, column and whether all of its samples are there;
    steepest_rad: its largest slope on a planet of radius 1."""

    found: list[Ints] = field(default_factory=list)
    lowest_m: float = np.inf
    highest_m: float = -np.inf
    steepest_rad: float = 0.0

    @property
    def blocks(self) -> Ints:
        """(N, 3): all of `found`."""
        return np.concatenate(self.found) if self.found else np.zeros((0, 3), np.int64)

    def arrays(self, name: str) -> dict[str, NDArray[Any]]:
        """To be written; `of` makes it of them again."""
        return {
            f"{name}found": self.blocks.astype(np.int32),
            f"{name}bounds": np.array([self.lowest_m, self.highest_m, self.steepest_rad]),
        }

    @staticmethod
    def of(held: dict[str, NDArray[Any]], name: str) -> LevelFacts:
        low, high, steep = (float(v) for v in held[f"{name}bounds"])
        return LevelFacts([held[f"{name}found"].astype(np.int64).reshape(-1, 3)], low, high, steep)

    def see(self, fine: Heights, lattice: Lattice, factor: int, j: int, i: int) -> bool:
        """Take in the samples of block (j, i) of a level factor times as coarse, and one row and column more; whether
        there are any."""
        inner = fine[:-1, :-1]
        there = ~np.isnan(inner)
        if not there.any():
            return False
        count = there.reshape(factor, BLOCK, factor, BLOCK).sum(axis=(1, 3))
        at = np.argwhere(count > 0)
        self.found.append(np.column_stack([at + np.array([j, i]) * factor, count[tuple(at.T)] == BLOCK * BLOCK]))
        self.lowest_m = min(self.lowest_m, float(np.nanmin(inner)))
        self.highest_m = max(self.highest_m, float(np.nanmax(inner)))
        rows = np.arange(len(inner)) + j * factor * BLOCK
        flat = np.maximum(np.cos(np.radians(lattice.place(np.zeros(len(rows)), rows)[0])), 1e-3)
        step = np.radians(lattice.step_deg) * (flat if lattice.mercator else np.ones_like(flat))
        along = np.abs(np.diff(fine[:-1], axis=1)) / (2.0 * np.pi / lattice.across * flat)[:, None]
        across = np.abs(np.diff(fine[:, :-1], axis=0)) / step[:, None]
        steep = np.hypot(np.nan_to_num(along), np.nan_to_num(across))
        self.steepest_rad = max(self.steepest_rad, float(steep.max()))
        return True


class BlockFile:
    """Blocks of a level one after the other in a file, compressed; path: None, there is no cache folder."""

    shape: tuple[int, ...] = (BLOCK, BLOCK)
    kind: type[np.generic] = np.float32

    def __init__(self, path: Path | None, places: dict[Key, tuple[int, int]] | None = None) -> None:
        self.path = path
        self.places = {} if places is None else places
        """Of each block its first byte and how many there are."""
        self._end = max((a + n for a, n in self.places.values()), default=0)

    def go_on(self, held: dict[str, NDArray[Any]]) -> None:
        """As far as it was written."""
        before = BlockFile.of(self.path, held, "")
        self.places, self._end = before.places, before._end

    def append(self, key: Key, block: NDArray[Any]) -> None:
        if self.path is None:
            return
        data = zlib.compress(block.tobytes(), 1)
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            with self.path.open("r+b" if self.path.exists() else "w+b") as file:
                file.seek(self._end)
                file.write(data)
        except OSError as error:  # what is not there is made anew
            log.warning("%s can't be written, so blocks of tiles are made again each time: %s", self.path, error)
            self.path = None
            return
        self.places[key] = self._end, len(data)
        self._end += len(data)

    def read(self, key: Key) -> NDArray[Any] | None:
        """None where it is not there, or damaged."""
        at = self.places.get(key)
        if at is None or self.path is None:
            return None
        try:
            with self.path.open("rb") as file:
                file.seek(at[0])
                data = zlib.decompress(file.read(at[1]))
            return np.frombuffer(data, self.kind).reshape(self.shape)
        except (OSError, ValueError, zlib.error):
            return None

    def arrays(self, name: str) -> dict[str, NDArray[Any]]:
        keys = np.array(list(self.places), np.int32).reshape(-1, 2)
        return {f"{name}stored": keys, f"{name}at": np.array(list(self.places.values()), np.int64).reshape(-1, 2)}

    @classmethod
    def of(cls, path: Path | None, held: dict[str, NDArray[Any]], name: str) -> Self:
        rows = zip(held[f"{name}stored"].tolist(), held[f"{name}at"].tolist(), strict=True)
        return cls(path, {(key[0], key[1]): (at[0], at[1]) for key, at in rows})


def squares_of(raw: TileBlocks, factor: int) -> list[Key]:
    """Blocks of the next coarser level that tiles touch, tile by tile, so that each is decoded a few times at most."""
    squares = sorted(raw.by_square, key=lambda key: (raw.by_square[key][0], key))
    found = [
        ((j * SUPER + b) // factor, (i * SUPER + a) // factor)
        for j, i in squares
        for b in range(SUPER)
        for a in range(SUPER)
    ]
    return list(dict.fromkeys(found))


def scan(
    raw: RawLevel, squares: list[Key], factor: int, coarser: RawLevel, stored: BlockFile | None,
    part: Path | None = None, progress: Callable[[int, int], None] | None = None,
) -> LevelFacts:  # fmt: skip
    """Facts of a level. Means of it go into `coarser`, or into `stored` where there is one. part: the file that says
    how far this has come."""
    facts, first, written_s = LevelFacts(), 0, time.monotonic()
    held = read_arrays(part)
    if held is not None and (stored is None or (stored.path is not None and stored.path.exists())):
        facts, first = LevelFacts.of(held, ""), int(held["done"])
        if stored is not None:
            stored.go_on(held)
        for key, block in zip(held["keys_coarser"].tolist(), held["blocks"], strict=True):
            coarser.blocks[key[0], key[1]] = block
    side = BLOCK * factor
    for number, (j, i) in enumerate(squares[first:], first):
        fine = raw.plain(j * side, i * side, side + 1)
        if facts.see(fine, raw.lattice, factor, j, i):
            block = means_of(fine[:-1, :-1], factor)
            if stored is None:
                coarser.blocks[j, i] = block
            else:
                stored.append((j, i), block)
        if progress is not None:
            progress(number + 1, len(squares))
        if part is not None and time.monotonic() - written_s >= EVERY_S:
            _keep(part, facts, number + 1, coarser, stored)
            written_s = time.monotonic()
    return facts


def _keep(part: Path, facts: LevelFacts, done: int, coarser: RawLevel, stored: BlockFile | None) -> None:
    blocks = list(coarser.blocks.values())
    arrays = facts.arrays("") | {
        "done": np.array(done),
        "keys_coarser": np.array(list(coarser.blocks), np.int32).reshape(-1, 2),
        "blocks": np.stack(blocks) if blocks else np.zeros((0, BLOCK, BLOCK), np.float32),
    }
    write_arrays(part, arrays if stored is None else arrays | stored.arrays(""))
