"""Real ground whose fine levels are on disk: coarse levels in memory whole, the others page by page as they are asked
for, within a budget.

All tiles are read once, square by square, for the coarse levels and for what is known of the fine ones (tile_scan.py).
That is kept in the cache folder; pages are made from tiles when somebody asks for them, and kept there, too.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..table_cache import TableCache
from .block_keys import among, inner, names_of, parents_of, reached_by
from .kept_ground import level_arrays, level_of, read_arrays, write_arrays
from .lattice import Lattice
from .page_files import PageKind, StreamFiles, keep_to_limit, limit_bytes
from .page_levels import heights_of, levels_of, next_factor
from .page_pool import PageSource
from .pages import SLOT, MadePage, PageLevel, made_page, polar_of
from .raw_level import BLOCK, RawLevel
from .real_ground import RealGround
from .streamed_level import HeightPool, streamed_level
from .tile_blocks import MeansBlocks, TileBlocks
from .tile_index import TileSet
from .tile_scan import BlockFile, LevelFacts, scan, squares_of

__all__ = ["KeptStream", "SetLevels", "StreamedGround", "first_in_memory", "ground_of", "levels_in_memory", "read_set"]

log = logging.getLogger(__name__)

Ints = NDArray[np.int64]
Progress = Callable[[int, int], None]

_FORMAT = 1
_RESIDENT = 0.5
"""Share of the budget for levels that are in memory whole."""
_ROOM = 0.1
"""Of the range of all samples: heights beyond a border follow coarser levels, and hardly leave it by more."""
_SLOT_BYTES = 4 * SLOT * SLOT


@dataclass(frozen=True, eq=False)
class StreamedGround(RealGround):
    """Levels of which some are StreamedLevel. pool: their pages here; budget_bytes: of all levels, here and once more
    on the GPU; index: the file that says what is where, None without a cache folder."""

    pool: HeightPool
    budget_bytes: int
    index: Path | None

    @property
    def resident_bytes(self) -> int:
        """Of heights and weights that are in memory now."""
        return sum(level.nbytes for level in self.levels) + self.pool.nbytes


@dataclass(frozen=True, eq=False)
class _Streamed:
    """What is known of a level that streams. stored: its blocks, None: they are those of tiles."""

    facts: LevelFacts
    polar: NDArray[np.float64]
    stored: BlockFile | None


@dataclass(frozen=True, eq=False)
class SetLevels:
    """The levels of a set: those that stream, the finest first, and those in memory with their factors, the coarsest
    first."""

    tiles: TileSet
    streamed: tuple[_Streamed, ...]
    whole: list[tuple[PageLevel, int]]


class KeptStream(StreamFiles[MadePage]):
    """The files of one map. stamp: all that it follows from."""

    def __init__(self, stamp: tuple[object, ...], most_bytes: int) -> None:
        root = TableCache("real_ground").folder
        kind = PageKind("h", MadePage.arrays, MadePage.of)
        super().__init__(kind, root, stamp, most_bytes, f"streamed {_FORMAT}", f"pages {_FORMAT}")

    def part(self, number: int, k: int) -> Path | None:
        """The file that says how far reading that level has come."""
        return self._named(f"{number}-{k}.reading.npz")

    def load(self, sets: Sequence[TileSet]) -> list[SetLevels] | None:
        """What was kept; None where nothing was."""
        held = read_arrays(self.index)
        if held is None:
            return None
        try:
            return [self._set(held, tiles, number) for number, tiles in enumerate(sets)]
        except (KeyError, ValueError, TypeError) as error:
            log.warning("%s holds something else than was expected and will be written again: %r", self.index, error)
            return None

    def _set(self, held: dict[str, NDArray[Any]], tiles: TileSet, number: int) -> SetLevels:
        streamed, whole = (int(v) for v in held[f"set{number}"])
        found = []
        for k in range(streamed):
            name = f"s{number}-{k}-"
            stored = None if k == 0 else BlockFile.of(self.blocks(number, k), held, name)
            found.append(_Streamed(LevelFacts.of(held, name), held[f"{name}polar"], stored))
        mine = {name.removeprefix(f"w{number}-"): v for name, v in held.items() if name.startswith(f"w{number}-")}
        levels = [(level_of(mine, k), int(mine[f"factor{k}"])) for k in range(whole)]
        return SetLevels(tiles, tuple(found), levels)

    def save(self, sets: Sequence[SetLevels]) -> bool:
        """Whether it could be written."""
        arrays: dict[str, NDArray[Any]] = {}
        for number, found in enumerate(sets):
            arrays[f"set{number}"] = np.array([len(found.streamed), len(found.whole)])
            for k, level in enumerate(found.streamed):
                name = f"s{number}-{k}-"
                arrays |= level.facts.arrays(name) | {f"{name}polar": level.polar}
                if level.stored is not None:
                    arrays |= level.stored.arrays(name)
            for k, (pages, factor) in enumerate(found.whole):
                mine: Mapping[str, NDArray[Any]] = level_arrays(pages, k) | {f"factor{k}": np.array(factor)}
                arrays |= {f"w{number}-{name}": value for name, value in mine.items()}
        if not write_arrays(self.index, arrays):
            return False
        if self._root is not None:
            for part in self._root.glob(f"{self._key}.*.reading.npz"):
                part.unlink(missing_ok=True)
            keep_to_limit(self._root, limit_bytes())
        return True


def levels_in_memory(sets: Sequence[TileSet], most_bytes: int) -> list[int]:
    """Of each set the finest level that is in memory whole."""
    return first_in_memory(sets, most_bytes, _level_bytes, next_factor)


def _level_bytes(samples: float) -> int:
    """About what a level takes."""
    side = max(samples, 1.0) ** 0.5 / BLOCK
    return int((1.08 * samples / BLOCK**2 + 8.0 * side + 8.0) * _SLOT_BYTES)


def first_in_memory(
    sets: Sequence[TileSet], most_bytes: int, bytes_of: Callable[[float], int], next_of: Callable[[Lattice], int]
) -> list[int]:
    """Of each set the finest level that is in memory whole: the smallest levels of all sets are, as long as they fit
    into their share. The coarsest of each always is. bytes_of: a level of so many samples; next_of: how many samples
    of a level make one of the next, 0: it is the last."""
    sizes: list[tuple[int, int, int]] = []  # the coarsest of alike ones first
    found = []
    for number, tiles in enumerate(sets):
        samples, lattice, k = float(tiles.samples), tiles.lattice, 0
        while True:
            sizes.append((bytes_of(samples), number, -k))
            factor = next_of(lattice)
            if not factor:
                break
            samples, lattice, k = samples / factor**2, lattice.coarser(factor), k + 1
        found.append(k)
    left = _RESIDENT * most_bytes - sum(size for size, number, k in sizes if -k == found[number])
    for size, number, k in sorted(sizes):
        if -k == found[number] - 1 and size <= left:
            left -= size
            found[number] = -k
    return found


def read_set(
    tiles: TileSet, first_whole: int, kept: KeptStream, number: int, what: str, progress: Progress | None = None
) -> SetLevels:
    """Read all tiles of a set once. first_whole: of levels_in_memory, above 0. progress: (squares, of how many)."""
    blocks = TileBlocks(tiles, what)
    raw: RawLevel = blocks
    squares = squares_of(blocks, next_factor(tiles.lattice))
    found: list[_Streamed] = []
    stored: BlockFile | None = None
    for k in range(first_whole):
        factor = next_factor(raw.lattice)
        coarser = RawLevel(raw.lattice.coarser(factor))
        following = BlockFile(kept.blocks(number, k + 1)) if k + 1 < first_whole else None
        facts = scan(raw, squares, factor, coarser, following, kept.part(number, k), progress if k == 0 else None)
        found.append(_Streamed(facts, polar_of(raw), stored))
        raw, stored = coarser if following is None else _means(raw, facts, factor, following), following
        coarse = parents_of(parents_of(facts.blocks, factor), next_factor(raw.lattice) or 1)
        squares = [(j, i) for j, i in coarse.tolist()]
    return SetLevels(tiles, tuple(found), levels_of(raw, False) if found[0].facts.found else [])


def _means(finer: RawLevel, facts: LevelFacts, factor: int, stored: BlockFile) -> MeansBlocks:
    there = names_of(parents_of(facts.blocks, factor))

    def has(key: tuple[int, int]) -> bool:
        return bool(among(names_of(np.array([key])), there)[0])

    return MeansBlocks(finer, factor, has, stored.read)


def ground_of(sets: Sequence[SetLevels], kept: KeptStream, most_bytes: int, what: str) -> StreamedGround:
    """Levels of all sets, with nothing of those that stream in memory yet."""
    whole = sum(level.nbytes for found in sets for level, _ in found.whole)
    pool = HeightPool(most_bytes - whole)
    levels: list[tuple[PageLevel, int, int]] = []
    low, high = np.inf, -np.inf
    for number, found in enumerate(sets):
        levels += [(level, factor, number) for level, factor in found.whole]
        low = min([low, *(float(level.heights.min()) for level, _ in found.whole)])
        high = max([high, *(float(level.heights.max()) for level, _ in found.whole)])
        low = min([low, *(level.facts.lowest_m for level in found.streamed)])
        high = max([high, *(level.facts.highest_m for level in found.streamed)])
        levels += [(level, factor, number) for level, factor in _streamed(found, number, kept, pool, what)]
    levels.sort(key=lambda entry: entry[0].lattice.step_deg)
    of_set = [number for _, _, number in levels]
    room = _ROOM * max(high - low, 1.0)
    return StreamedGround(
        tuple(level for level, _, _ in levels),
        tuple(factor for _, factor, _ in levels),
        tuple(of_set.index(number) for number in of_set),
        low - room,
        high + room,
        pool,
        most_bytes,
        kept.index,
    )


def _streamed(
    found: SetLevels, number: int, kept: KeptStream, pool: HeightPool, what: str
) -> list[tuple[PageLevel, int]]:
    """The levels of a set that stream, and their factors."""
    if not found.streamed or not found.whole:
        return []
    blocks = TileBlocks(found.tiles, what)
    raws: list[RawLevel] = [blocks]
    for level, following in zip(found.streamed, found.streamed[1:], strict=False):
        assert following.stored is not None
        raws.append(_means(raws[-1], level.facts, next_factor(raws[-1].lattice), following.stored))
    coarser, levels = found.whole[-1][0], []
    for k in range(len(raws) - 1, -1, -1):
        facts, lattice = found.streamed[k].facts, raws[k].lattice
        where = reached_by(lattice, facts.blocks, BLOCK)  # they may have heights, see pages.reached
        border = ~inner(lattice, where, facts.blocks[facts.blocks[:, 2] > 0, :2], BLOCK)
        level = streamed_level(lattice, where, found.streamed[k].polar, k == 0)
        make = partial(made_page, raws[k], heights_of(coarser))
        source = PageSource(f"{number}-{k}", make, kept.files, lambda: not blocks.broken)
        level.begin(source, pool, facts.steepest_rad, border)
        levels.append((level, next_factor(lattice)))
        coarser = level
    return levels
