"""Pictures of the ground whose fine levels are on disk: coarse levels in memory whole, the others page by page as they
are asked for, within a budget. As streamed_ground.py does it for heights.

All tiles are read once, from the finest blocks up to the coarsest level that streams, for the levels in memory and for
what is known of the fine ones. That is kept in the cache folder; pages are made from tiles when somebody asks for them,
and kept there, too.
"""

from __future__ import annotations

import logging
import os
import shutil
import tempfile
import weakref
from collections.abc import Callable, Iterable, Sequence
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..table_cache import TableCache
from .block_keys import names_of, parents_of, reached_by
from .color_blocks import LevelBlocks, MarginBlocks, MeanPixels, PixelFile, TilePixels
from .color_ground import ColorGround, ColorPages, ColorSet, color_page
from .color_level import SIDE, ColorLevel, Pixels, coarser_pixels, finer_keys, pixel_factor
from .color_unlit import Relief, SunFit, fit_sun
from .kept_ground import read_arrays, write_arrays
from .lattice import Lattice
from .page_files import PageKind, StreamFiles, keep_to_limit, limit_bytes
from .page_pool import PageSource
from .streamed_color_level import ColorPool, streamed_color_level
from .tile_blocks import keys_touched
from .tile_index import TileSet

__all__ = ["ColorStreamFiles", "Reading", "StreamedColors", "read_color_set", "streamed_colors"]

log = logging.getLogger(__name__)

Ints = NDArray[np.int64]
Key = tuple[int, int]
Progress = Callable[[int, int], None]
Levels = Callable[[ColorLevel], tuple[tuple[ColorPages, ...], tuple[float, ...]]]

_FORMAT = 1


@dataclass(frozen=True, eq=False)
class StreamedColors(ColorGround):
    """Sets of which some levels are StreamedColorLevel. pool: their pages here; budget_bytes: of all levels, here and
    once more on the GPU; index: the file that says what is where, None without a cache folder."""

    pool: ColorPool
    budget_bytes: int
    index: Path | None

    @property
    def resident_bytes(self) -> int:
        """Of pixels that are in memory now."""
        return sum(level.nbytes for each in self.sets for level in each.levels) + self.pool.nbytes


@dataclass(frozen=True)
class Reading:
    """How pixels are read. convert: colours as files hold them into what levels hold; unlit: share of the sun's
    shading that is taken out, by `relief`; what: for warnings; levels_of: pages of a level and of coarser ones, and by
    how many octaves each is coarser."""

    convert: Callable[[Pixels], Pixels]
    unlit: float
    relief: Relief | None
    what: str
    levels_of: Levels


@dataclass(frozen=True, eq=False)
class _Kept:
    """What is known of a set. keys: of each level that streams, the blocks (N, 2) that have pixels, and polar rows;
    stored: the blocks of each but the finest; whole: the levels in memory, and by how many octaves they are coarser
    than the first of them."""

    keys: list[Ints]
    polar: list[dict[int, Pixels]]
    stored: list[PixelFile]
    whole: tuple[tuple[ColorPages, ...], tuple[float, ...]]
    sun: SunFit | None


class ColorStreamFiles(StreamFiles[Pixels]):
    """The files of one map. stamp: all that its pixels follow from; None: nothing says it, and they are kept no longer
    than this process."""

    def __init__(self, stamp: tuple[object, ...] | None, most_bytes: int) -> None:
        root = TableCache("real_ground").folder
        self.passing: Path | None = None
        """A folder that has to go with the map."""
        if stamp is None:
            root = self.passing = Path(tempfile.mkdtemp(prefix=f"planetfall-pictures-{os.getpid()}-"))
        kind = PageKind("c", _page_arrays, _page_of)
        super().__init__(kind, root, stamp, most_bytes, f"streamed colors {_FORMAT}", f"color pages {_FORMAT}")

    def load(self, sets: Sequence[TileSet]) -> list[_Kept | None] | None:
        """What was kept; None where nothing was."""
        held = read_arrays(self.index)
        if held is None:
            return None
        try:
            return [self._set(held, number) for number in range(len(sets))]
        except (KeyError, ValueError, TypeError) as error:
            log.warning("%s holds something else than was expected and will be written again: %r", self.index, error)
            return None

    def _set(self, held: dict[str, NDArray[Any]], number: int) -> _Kept | None:
        streamed, whole = (int(v) for v in held[f"set{number}"])
        if not whole:
            return None
        keys, polar, stored = [], [], []
        for k in range(streamed):
            name = f"s{number}-{k}-"
            keys.append(held[f"{name}keys"].astype(np.int64).reshape(-1, 2))
            rows = zip(held[f"{name}rows"].tolist(), held[f"{name}polar"], strict=True)
            polar.append({int(row): pixels for row, pixels in rows})
            if k:
                stored.append(PixelFile.of(self.blocks(number, k), held, name))
        levels, octaves = [], []
        for k in range(whole):
            name = f"w{number}-{k}-"
            *parts, octave = (float(v) for v in held[f"{name}lattice"])
            levels.append(ColorPages(_lattice(parts), held[f"{name}pixels"], held[f"{name}where"]))
            octaves.append(octave)
        sun = None
        if f"u{number}-slopes" in held:
            facts = held[f"u{number}-facts"]
            given = held[f"u{number}-sun"]
            sun = SunFit(
                _lattice(facts[:5].tolist()), int(facts[5]), given if len(given) else None,
                held[f"u{number}-slopes"], held[f"u{number}-flat"], (float(facts[6]), float(facts[7])),
            )  # fmt: skip
        return _Kept(keys, polar, stored, (tuple(levels), tuple(octaves)), sun)

    def save(self, sets: Sequence[_Kept | None]) -> bool:
        """Whether it could be written."""
        arrays: dict[str, NDArray[Any]] = {}
        for number, found in enumerate(sets):
            arrays[f"set{number}"] = np.array([0, 0] if found is None else [len(found.keys), len(found.whole[0])])
            if found is None:
                continue
            for k, (keys, rows) in enumerate(zip(found.keys, found.polar, strict=True)):
                name = f"s{number}-{k}-"
                arrays[f"{name}keys"], arrays[f"{name}rows"] = keys.astype(np.int32), np.array(list(rows), np.int64)
                arrays[f"{name}polar"] = np.stack(list(rows.values())) if rows else np.zeros((0, 0, 4), np.uint8)
                if k:
                    arrays |= found.stored[k - 1].arrays(name)
            for k, (level, octave) in enumerate(zip(*found.whole, strict=True)):
                name = f"w{number}-{k}-"
                arrays[f"{name}lattice"] = np.array([*map(float, astuple(level.lattice)), octave])
                arrays[f"{name}pixels"], arrays[f"{name}where"] = level.pixels, level.where
            if found.sun is not None:
                sun, name = found.sun, f"u{number}-"
                arrays[f"{name}facts"] = np.array([*map(float, astuple(sun.lattice)), sun.step, *sun.sun_deg])
                arrays[f"{name}sun"] = np.zeros(0) if sun.sun is None else sun.sun
                arrays[f"{name}slopes"], arrays[f"{name}flat"] = sun.slopes, sun.flat
        if not write_arrays(self.index, arrays):
            return False
        if self._root is not None:
            keep_to_limit(self._root, limit_bytes())
        return True


def _lattice(parts: Sequence[float]) -> Lattice:
    mercator, *rest = parts
    return Lattice(bool(mercator), *rest)


def _page_arrays(page: Pixels) -> dict[str, NDArray[Any]]:
    return {"c": page}


def _page_of(held: Callable[[str], NDArray[Any] | None]) -> Pixels:
    page = held("c")
    if page is None:
        raise ValueError("half a page")
    return page


def streamed_colors(
    sets: Sequence[TileSet], firsts: Sequence[int], files: ColorStreamFiles, reading: Reading, most_bytes: int,
    progress: Progress | None = None,
) -> StreamedColors:  # fmt: skip
    """As they were kept, or with all tiles read once. firsts: of each set the finest level that is in memory whole."""
    raws = [TilePixels(tiles, reading.convert, reading.what) for tiles in sets]
    found = files.load(sets)
    if found is None:
        found = [
            read_color_set(raw, first, files, number, reading, progress)
            for number, (raw, first) in enumerate(zip(raws, firsts, strict=True))
        ]
        files.save(found)
        for raw in raws:
            raw.forget()
    known = [(raw, each) for raw, each in zip(raws, found, strict=True) if each is not None]
    pool = ColorPool(
        most_bytes - sum(level.nbytes for _, each in known for level in each.whole[0]) - _polar_bytes(known)
    )
    made = []
    for number, (raw, each) in enumerate(known):
        if each.sun is not None and reading.relief is not None:
            raw.take_out_sun(each.sun, reading.relief, reading.unlit)
        levels, octaves = _levels(raw, each, f"{number}", files, pool)
        made.append(ColorSet(levels, octaves, None if each.sun is None else each.sun.sun_deg))
    colors = StreamedColors(tuple(made), pool, most_bytes, None if files.passing else files.index)
    if files.passing is not None:
        weakref.finalize(colors, shutil.rmtree, files.passing, True)
    return colors


def _polar_bytes(known: Iterable[tuple[TilePixels, _Kept]]) -> int:
    return sum(row.nbytes for _, each in known for rows in each.polar for row in rows.values())


def _levels(
    raw: TilePixels, kept: _Kept, name: str, files: ColorStreamFiles, pool: ColorPool
) -> tuple[tuple[ColorPages, ...], tuple[float, ...]]:
    """Of a set, the finest first, and by how many octaves each is coarser than that."""
    if not kept.keys:
        return kept.whole
    blocks: list[LevelBlocks] = [MarginBlocks(raw, kept.keys[0])]
    for keys, stored in zip(kept.keys[1:], kept.stored, strict=True):
        blocks.append(MeanPixels(blocks[-1], pixel_factor(blocks[-1].lattice), keys, stored))
    levels: list[ColorPages] = []
    octaves = [0.0]
    for k, (each, keys) in enumerate(zip(blocks, kept.keys, strict=True)):
        each.use_polar(kept.polar[k])
        where = reached_by(each.lattice, keys, SIDE)
        source = PageSource(f"{name}-{k}", partial(color_page, each), files.files, lambda: not raw.broken)
        levels.append(streamed_color_level(each.lattice, where, source, pool))
        octaves.append(octaves[-1] + float(np.log2(pixel_factor(each.lattice))))
    first = octaves.pop()
    whole, after = kept.whole
    return (*levels, *whole), (*octaves, *(first + octave for octave in after))


def read_color_set(
    raw: TilePixels, first_whole: int, files: ColorStreamFiles, number: int, reading: Reading,
    progress: Progress | None,
) -> _Kept | None:  # fmt: skip
    """Read all tiles of a set once."""
    touched, sun = keys_touched(raw.tiles, SIDE), None
    if reading.unlit > 0.0 and reading.relief is not None:
        keys = [(j, i) for j, i in touched.tolist()]
        sun = fit_sun(raw, keys, reading.relief, raw.tiles.folder.sun_deg)
        if sun is not None:
            raw.take_out_sun(sun, reading.relief, reading.unlit)
            if raw.tiles.folder.sun_deg is None:
                log.info(
                    "%s: %s: the sun stood at %.0f degrees from north, %.0f high",
                    reading.what, raw.tiles.folder.folder, *sun.sun_deg,
                )  # fmt: skip
    there = reached_by(raw.lattice, touched, SIDE)
    blocks: list[LevelBlocks] = [MarginBlocks(raw, there)]
    stored: list[PixelFile] = []
    polar_keys = []
    for k in range(first_whole):
        blocks[k].use_polar(blocks[k].polar_rows())
        polar_keys.append(blocks[k].polar_keys())
        there = np.unique(np.concatenate([there, polar_keys[k]]), axis=0)
        if k + 1 < first_whole:
            factor = pixel_factor(blocks[k].lattice)
            there = parents_of(there, factor)
            path = files.blocks(number, k + 1)
            if path is not None:
                path.unlink(missing_ok=True)  # of a reading that was cut off
            stored.append(PixelFile(path))
            blocks.append(MeanPixels(blocks[k], factor, there, stored[-1]))
    scan = _Scan(blocks, stored, first_whole, progress)
    whole = scan.whole(there) if first_whole else _in_memory(blocks[0], there)
    if not whole.blocks:
        return None
    return _Kept(
        [np.array(keys, dtype=np.int64).reshape(-1, 2) for keys in scan.keys],
        [each.polar for each in blocks[:first_whole]],
        stored,
        reading.levels_of(whole),
        sun,
    )


def _in_memory(blocks: LevelBlocks, there: Ints) -> ColorLevel:
    level = ColorLevel(blocks.lattice)
    for j, i in there.tolist():
        block = blocks.block((j, i))
        if block is not None:
            level.blocks[j, i] = block
    return level


class _Scan:
    """Blocks of all levels that stream, from each one of the first level in memory down: every tile is decoded once or
    twice, and no more than a branch is in memory."""

    def __init__(
        self, blocks: list[LevelBlocks], stored: list[PixelFile], levels: int, progress: Progress | None
    ) -> None:  # fmt: skip
        self._blocks, self._stored, self._progress = blocks, stored, progress
        self.keys: list[list[Key]] = [[] for _ in range(levels)]

    def whole(self, there: Ints) -> ColorLevel:
        """The first level in memory. there: blocks of the level below."""
        last = self._blocks[-1]
        factor = pixel_factor(last.lattice)
        level = ColorLevel(last.lattice.coarser(factor))
        coarse = parents_of(there, factor).tolist()
        for number, (j, i) in enumerate(coarse):
            finer = [self._block(len(self._blocks) - 1, key) for key in finer_keys(factor, j, i)]
            block = coarser_pixels(finer, factor)
            if block is not None:
                level.blocks[j, i] = block
            if self._progress is not None:
                self._progress(number + 1, len(coarse))
        for k, keys in enumerate(self.keys):
            order = np.argsort(names_of(np.array(keys, dtype=np.int64).reshape(-1, 2)))
            self.keys[k] = [keys[n] for n in order.tolist()]
        return level

    def _block(self, k: int, key: Key) -> Pixels | None:
        level = self._blocks[k]
        if not level.may_have(key):
            return None
        if k == 0:
            block = level.block(key)
        else:
            factor = pixel_factor(self._blocks[k - 1].lattice)
            block = coarser_pixels([self._block(k - 1, each) for each in finer_keys(factor, *key)], factor)
            block = level.finished(key, block)
            if block is not None:
                self._stored[k - 1].append(key, block)
        if block is not None:
            self.keys[k].append(key)
        return block
