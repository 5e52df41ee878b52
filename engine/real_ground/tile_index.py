"""Which tiles a folder has, and where they lie: an index that is kept, so that 10^5 tiles open at once.

Names, sizes and times of change of all files are kept with what their headers say, in the cache folder; only new and
changed files are read again. Broken files cost one warning each and stand for nothing.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from importlib.util import find_spec
from pathlib import Path, PurePosixPath

import numpy as np
from numpy.typing import NDArray

from ..surface.cube_map import FACES
from ..table_cache import TableCache
from ..user_paths import place_of
from .found import Found, MissingLibrary, TileError
from .lattice import Lattice
from .tile_files import ENDINGS, find_tile
from .tile_folders import HEIGHTS, PICTURES, TileFolder, tile_folders

__all__ = ["TileSet", "first_tiles", "folder_sets", "folder_stamp", "is_tiles", "open_tiles", "tiles_stamp"]

log = logging.getLogger(__name__)

Ints = NDArray[np.int64]

_FORMAT = 4
"""Of the kept index; another number forgets what older ones kept."""
_BETWEEN = "\0"
"""What no name of a file has in it: lines may end in one."""
_WARPED = 1
"""Of how files in other coordinate systems are read."""


@dataclass(frozen=True, eq=False)
class TileSet:
    """Tiles with the same lattice.

    names: of the files, from the folder. where: (N, 4) first column and row, columns and rows of each. warped: (N,)
    which have samples of their own, in another coordinate system.
    """

    folder: TileFolder
    lattice: Lattice
    names: list[str]
    where: Ints
    warped: NDArray[np.bool_]

    def __len__(self) -> int:
        return len(self.names)

    def tile(self, number: int) -> tuple[Path, Found]:
        column, row, columns, rows = (int(v) for v in self.where[number])
        file = self.folder.folder / self.names[number]
        if not self.warped[number]:
            return file, Found(self.lattice, column, row, columns, rows)
        beside = tuple(self.folder.folder / self.names[k] for k in self._beside(number))
        return file, Found(self.lattice, column, row, columns, rows, True, beside)

    @cached_property
    def _cells(self) -> tuple[Ints, dict[tuple[int, int], list[int]]]:
        """Warped tiles by squares as wide as the largest of them, and its sides."""
        numbers = np.flatnonzero(self.warped)
        side = self.where[numbers, 2:].max(axis=0) + 2
        found: dict[tuple[int, int], list[int]] = {}
        for number, (i, j) in zip(numbers.tolist(), (self.where[numbers, :2] // side).tolist(), strict=True):
            found.setdefault((i, j), []).append(number)
        return side, found

    def _beside(self, number: int) -> list[int]:
        """Warped tiles that touch this one, or lie over it. None across the date line, where they just go on."""
        side, cells = self._cells
        i, j = (int(v) for v in self.where[number, :2] // side)
        first = self.where[number, :2] - 1
        last = self.where[number, :2] + self.where[number, 2:]
        found = sorted(k for b in (-1, 0, 1) for a in (-1, 0, 1) for k in cells.get((i + a, j + b), ()) if k != number)
        where = self.where[found].reshape(-1, 4)
        near = np.all((where[:, :2] <= last) & (where[:, :2] + where[:, 2:] > first), axis=1)
        return [found[k] for k in np.flatnonzero(near)]

    @property
    def samples(self) -> int:
        """Of all tiles together."""
        return int((self.where[:, 2] * self.where[:, 3]).sum())

    def bounds_deg(self) -> tuple[float, float, float, float]:
        """South, west, north, east of all samples, the shorter way around: east of the date line is above 180."""
        first, last = self.turned[:, :2], self.turned[:, :2] + self.where[:, 2:] - 1
        north, west = self.lattice.place(first[:, 0].min(), first[:, 1].min())
        south, east = self.lattice.place(last[:, 0].max(), last[:, 1].max())
        turn = 360.0 * np.floor((west + 180.0) / 360.0)
        return float(south), float(west - turn), float(north), float(east - turn)

    @cached_property
    def turned(self) -> Ints:
        """As `where`, with columns counted on from the widest gap between tiles around the world."""
        around, found = self.lattice.across, self.where.copy()
        start = np.mod(found[:, 0], around)
        order = np.argsort(start, kind="stable")
        start, end = start[order], start[order] + found[order, 2]
        reached = np.maximum.accumulate(np.maximum(end, end.max() - around))
        gaps = np.append(start[1:], start[0] + around) - reached
        widest = int(gaps.argmax())
        first = 0 if gaps[widest] <= max(gaps[-1], 0.5) else widest + 1
        if gaps[widest] > 0.5 or first:
            found[order, 0] = np.rint(start - around * ((np.arange(len(order)) >= first) & (first > 0)))
        return found


def is_tiles(path: str) -> bool:
    """Whether a map is tiles: an index file, or a folder without pictures of a cube's faces."""
    place = place_of(path)
    if not os.path.isdir(place):
        return place.suffix.lower() == ".toml"
    try:
        with os.scandir(place) as entries:
            return not any(Path(entry.name).stem in FACES and entry.is_file() for entry in entries)
    except OSError:  # what reads it says so
        return True


@dataclass(frozen=True)
class _Listing:
    """The files of a folder as they are now, sorted by name."""

    names: list[str]
    changed_ns: Ints
    sizes: Ints

    @staticmethod
    def of(folder: Path, endings: tuple[str, ...] = ENDINGS) -> _Listing:
        rows: list[tuple[str, int, int]] = []
        waiting = [(str(folder), "")]
        been: set[tuple[int, int]] = set()  # a link may lead back to where one is
        while waiting:
            at, inside = waiting.pop()
            try:
                here = os.stat(at)
                with os.scandir(at) as found_here:
                    entries = sorted(found_here, key=lambda entry: entry.name)
            except OSError as error:
                log.warning("%s can't be searched for tiles: %s (left out)", at, error.strerror)
                continue
            if (here.st_dev, here.st_ino) in been:
                continue
            been.add((here.st_dev, here.st_ino))
            for entry in entries:
                name = entry.name
                if name.startswith("."):
                    continue
                if _is_folder(entry):
                    waiting.append((entry.path, f"{inside}{name}/"))
                elif name.lower().endswith(endings):
                    rows.append((inside + name, *_change(entry)))
        rows.sort()
        numbers = np.array([row[1:] for row in rows], dtype=np.int64).reshape(-1, 2)
        return _Listing([row[0] for row in rows], numbers[:, 0], numbers[:, 1])

    def digest(self) -> str:
        """Of all of it: a tile that has only been renamed is another one."""
        found = hashlib.sha256("\n".join(self.names).encode(errors="surrogateescape"))
        for numbers in (self.changed_ns, self.sizes):
            found.update(np.ascontiguousarray(numbers).tobytes())
        return found.hexdigest()


def _is_folder(entry: os.DirEntry[str]) -> bool:
    try:
        return entry.is_dir()
    except OSError:
        return False


def _change(entry: os.DirEntry[str]) -> tuple[int, int]:
    """Time of change in ns and bytes; zeros of a link to nothing: what reads it says so."""
    try:
        found = entry.stat()
    except OSError:
        return 0, 0
    return found.st_mtime_ns, found.st_size


def tiles_stamp(path: str, kind: str = HEIGHTS) -> tuple[object, ...]:
    """What tells whether the map at `path` has changed."""
    place = place_of(path)
    stamp: list[object] = [str(place)]
    with contextlib.suppress(OSError, ValueError):  # what reads it says so
        if place.is_file():
            stamp.append(place.stat().st_mtime_ns)
    try:
        folders = tile_folders(path, "", kind)
    except TileError:
        return tuple(stamp)
    water = folders[0].water if folders else ()
    for each in (*folders, *water):
        stamp += folder_stamp(each)
    return tuple(stamp)


def open_tiles(
    path: str, what: str, progress: Callable[[int, int], None] | None = None, kind: str = HEIGHTS, quiet: bool = False
) -> list[TileSet]:
    """The sets of the map at `path`, the finest first. progress: (files looked at, of how many), for a first look.
    quiet: no word of broken tiles, for whoever opens them again."""
    sets: list[TileSet] = []
    for folder in tile_folders(path, what, kind):
        sets += folder_sets(folder, what, progress, quiet)
    if not sets:
        raise TileError(
            f"{what}: {path} has no tile of elevation; expected {', '.join(ENDINGS)} files: SRTM tiles such as "
            "N46E007.hgt, GeoTIFFs, or PNG by zoom/x/y"
            if kind == HEIGHTS
            else f"{what}: {path} has no tile of a picture; expected {', '.join(PICTURES)} files: PNG or JPEG by "
            "zoom/x/y, such as 12/2138/1443.jpg, or GeoTIFFs"
        )
    return sorted(sets, key=lambda found: found.lattice.step_deg)


def first_tiles(folder: TileFolder) -> Iterator[tuple[Path, Found]]:
    """Tiles of a folder by their names, without an index; broken ones are passed over."""
    listing = _Listing.of(folder.folder, folder.endings)
    for name, size in zip(listing.names, listing.sizes.tolist(), strict=True):
        with contextlib.suppress(TileError):
            yield folder.folder / name, find_tile(folder.folder / name, PurePosixPath(name), size)


def folder_stamp(folder: TileFolder) -> tuple[object, ...]:
    """What tells whether a folder has changed, or what can be read of it."""
    listing = _Listing.of(folder.folder, folder.endings)
    if not any(name.lower().endswith((".tif", ".tiff")) for name in listing.names):
        return folder, listing.digest()
    return folder, listing.digest(), _WARPED, *(find_spec(name) is not None for name in ("tifffile", "pyproj"))


def folder_sets(
    folder: TileFolder, what: str, progress: Callable[[int, int], None] | None = None, quiet: bool = False
) -> list[TileSet]:
    """The sets of a single folder."""
    listing = _Listing.of(folder.folder, folder.endings)
    kept = _Kept(folder.folder, "" if folder.kind == HEIGHTS else "pictures")
    lattices, numbers, where, warped, broken = kept.look(listing, progress)
    for name, message in () if quiet else broken:
        log.warning("%s: %s (left out)", what or name, message)
    sets = []
    for number, lattice in enumerate(lattices):
        at = np.flatnonzero(numbers == number)
        if len(at):
            sets.append(TileSet(folder, lattice, [listing.names[i] for i in at], where[at], warped[at]))
    return sets


class _Kept:
    """What headers of a folder's files said, on disk."""

    def __init__(self, folder: Path, part: str = "") -> None:
        self._folder = folder
        cache = TableCache("tiles")
        key = TableCache.key(str(folder.resolve()), *([part] if part else []))
        self._file = None if cache.folder is None else cache.folder / f"{key}.npz"

    def look(
        self, listing: _Listing, progress: Callable[[int, int], None] | None
    ) -> tuple[list[Lattice], Ints, Ints, NDArray[np.bool_], list[tuple[str, str]]]:
        """Lattices; of each file its number among them, -1 where it is broken, (N, 4) where it is, and whether it is
        warped; what is wrong with the broken ones, (name, message)."""
        count = len(listing.names)
        lattices, numbers, where, messages = self._known(listing)
        later: list[int] = []
        new = np.flatnonzero(numbers == -2)
        for done, i in enumerate(new.tolist()):
            name = listing.names[i]
            try:
                found = find_tile(self._folder / name, PurePosixPath(name), int(listing.sizes[i]))
            except TileError as error:
                numbers[i] = -1
                messages[name] = str(error)
                if isinstance(error, MissingLibrary):
                    later.append(i)
            else:
                numbers[i] = _number(lattices, found.lattice)
                where[i] = found.column, found.row, found.columns, found.rows, found.warped
                messages.pop(name, None)
            if progress is not None and done % 256 == 255:
                progress(done + 1, len(new))
        if len(new):
            kept = numbers.copy()
            kept[later] = -2  # until the library is there
            self._write(listing, lattices, kept, where, messages)
        if progress is not None and len(new):
            progress(len(new), len(new))
        assert len(numbers) == count
        return lattices, numbers, where[:, :4], where[:, 4] > 0, sorted(messages.items())

    def _known(self, listing: _Listing) -> tuple[list[Lattice], Ints, Ints, dict[str, str]]:
        count = len(listing.names)
        nothing = [], np.full(count, -2, np.int64), np.zeros((count, 5), np.int64), {}
        if self._file is None:
            return nothing
        try:
            with np.load(self._file, allow_pickle=False) as held:
                if int(held["format"]) != _FORMAT:
                    return nothing
                names = (
                    bytes(held["names"]).decode(errors="surrogateescape").split(_BETWEEN) if held["names"].size else []
                )
                numbers, where, times = held["numbers"], held["where"], held["times"]
                texts = bytes(held["messages"]).decode(errors="surrogateescape").split(_BETWEEN)
                lattices = [Lattice(bool(row[0]), *(float(v) for v in row[1:])) for row in held["lattices"]]
            if not len(names) == len(numbers) == len(where) == len(times):
                raise ValueError(f"it names {len(names)} files and has places of {len(where)}")
        except FileNotFoundError:
            return nothing
        except Exception as error:
            log.warning("%s cannot be used and will be written again: %s", self._file, error)
            return nothing
        messages = dict(zip(texts[::2], texts[1::2], strict=False))
        now = np.stack([listing.changed_ns, listing.sizes], axis=1)
        if names == listing.names and np.array_equal(times, now):
            return lattices, numbers.copy(), where.copy(), messages
        before = {name: i for i, name in enumerate(names)}
        found_numbers, found_where = nothing[1], nothing[2]
        for i, name in enumerate(listing.names):
            j = before.get(name)
            if j is not None and (times[j] == now[i]).all():
                found_numbers[i], found_where[i] = numbers[j], where[j]
        still = {listing.names[i] for i in np.flatnonzero(found_numbers == -1)}
        return lattices, found_numbers, found_where, {k: v for k, v in messages.items() if k in still}

    def _write(
        self, listing: _Listing, lattices: list[Lattice], numbers: Ints, where: Ints, messages: dict[str, str]
    ) -> None:
        """Beside, and renamed. What can't be written is looked at again."""
        if self._file is None:
            return
        rows = [(float(a.mercator), a.across, a.down, a.phase_x, a.phase_y) for a in lattices]
        texts = _BETWEEN.join(text.replace(_BETWEEN, " ") for pair in messages.items() for text in pair)
        beside = self._file.with_suffix(f".{os.getpid()}.part")
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with beside.open("wb") as file:
                np.savez(
                    file,
                    format=np.array(_FORMAT),
                    names=np.frombuffer(_BETWEEN.join(listing.names).encode(errors="surrogateescape"), np.uint8),
                    times=np.stack([listing.changed_ns, listing.sizes], axis=1),
                    numbers=numbers,
                    where=where,
                    lattices=np.array(rows, dtype=np.float64).reshape(-1, 5),
                    messages=np.frombuffer(texts.encode(errors="surrogateescape"), np.uint8),
                )
            beside.replace(self._file)
        except OSError as error:
            log.warning("%s cannot be written: %s; tiles will be looked at again", self._file, error)
            with contextlib.suppress(OSError):
                beside.unlink(missing_ok=True)


def _number(lattices: list[Lattice], found: Lattice) -> int:
    for number, lattice in enumerate(lattices):
        if lattice.same(found):
            return number
    lattices.append(found)
    return len(lattices) - 1
