"""Pages on disk: squares of them in compressed files, made once from tiles.

All of the folder real_ground in the cache folder keeps to a limit, PLANETFALL_CACHE_MB (8000): when files have come to
take more, those that were used longest ago go until a tenth of it is free. Whatever is gone is made again from tiles.
"""

from __future__ import annotations

import contextlib
import logging
import os
import re
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from ..settings import SettingError
from ..table_cache import TableCache
from .kept_ground import write_arrays

__all__ = ["SQUARE", "PageFiles", "PageKind", "StreamFiles", "keep_to_limit", "limit_bytes"]

log = logging.getLogger(__name__)

P = TypeVar("P")

SQUARE = 4
"""Pages a side of a file's."""
_MOST_MB = 8000.0
_LEFT = 0.9
_TOUCHED_S = 600.0
"""So often at most the time of use of a file is written."""
_STALE_S = 3600.0
_OURS = re.compile(r"[0-9a-f]{40}(\.|$)")
"""How names of files and folders begin here: others' files may lie beside them."""


def limit_bytes() -> int:
    """What kept ground may take on disk. SettingError for a PLANETFALL_CACHE_MB that is no number of megabytes."""
    text = os.environ.get("PLANETFALL_CACHE_MB", "")
    try:
        most = float(text) if text else _MOST_MB
    except ValueError:
        most = -1.0
    if not 0.0 < most < float("inf"):
        raise SettingError(f"PLANETFALL_CACHE_MB: {text!r}; expected megabytes above 0, such as {_MOST_MB:g}: unset it")
    return int(1e6 * most)


def keep_to_limit(folder: Path, most_bytes: int) -> int:
    """Remove what was used longest ago until the folder has room again; the bytes that are left. Others may do the same
    meanwhile."""
    found: list[tuple[float, int, Path]] = []
    for at, inside, names in os.walk(folder):
        top = Path(at) == folder
        if top:
            inside[:] = [name for name in inside if _OURS.match(name)]
        for name in names:
            if top and not _OURS.match(name):
                continue
            with contextlib.suppress(OSError):
                about = os.stat(f"{at}/{name}")
                found.append((about.st_mtime, about.st_size, Path(at) / name))
    taken = sum(size for _, size, _ in found)
    if taken <= most_bytes:
        return taken
    found.sort()
    now = time.time()
    for age, size, path in found:
        if path.suffix == ".part" and age > now - _STALE_S:  # somebody writes it
            continue
        if taken <= _LEFT * most_bytes and path.suffix != ".part":
            break
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)
            taken -= size
    return taken


@dataclass(frozen=True)
class PageKind(Generic[P]):
    """How pages lie in files: arrays by a letter, of which each page has the first one, and pages made of them."""

    first: str
    arrays: Callable[[P], dict[str, NDArray[Any]]]
    page: Callable[[Callable[[str], NDArray[Any] | None]], P]


class PageFiles(Generic[P]):
    """The pages of one map. folder: None, there is no cache folder. root: what keeps to the limit."""

    def __init__(self, kind: PageKind[P], folder: Path | None, root: Path | None) -> None:
        self._kind, self.folder, self._root = kind, folder, root
        self._most_bytes = limit_bytes()
        self._taken: int | None = None
        self._touched: dict[Path, float] = {}
        self._lock = Lock()

    @property
    def keeps(self) -> bool:
        """Whether there is a folder for them."""
        return self.folder is not None

    def _file(self, level: str, j: int, i: int) -> Path | None:
        return None if self.folder is None else self.folder / f"{level}-{j // SQUARE}-{i // SQUARE}.npz"

    def load(self, level: str, j: int, i: int) -> tuple[bool, P | None]:
        """Whether the square of the page in row j and column i of pages is there, and the page, None where nothing
        is."""
        file = self._file(level, j, i)
        if file is None:
            return False, None
        name = f"{j}_{i}"
        try:
            with np.load(file, allow_pickle=False) as held:
                self._touch(file)
                if f"{self._kind.first}{name}" not in held:
                    return True, None
                return True, self._kind.page(lambda letter: held.get(f"{letter}{name}"))
        except FileNotFoundError:
            return False, None
        except Exception as error:  # zip and numpy raise what they like for half a file
            log.warning("%s cannot be used and will be written again: %s", file, error)
            return False, None

    def save(self, level: str, j: int, i: int, pages: dict[tuple[int, int], P]) -> None:
        """Keep a square: all of its pages that there are."""
        arrays: dict[str, NDArray[Any]] = {}
        for (row, column), page in pages.items():
            arrays |= {f"{letter}{row}_{column}": values for letter, values in self._kind.arrays(page).items()}
        file = self._file(level, j, i)
        if file is None or self._root is None or not write_arrays(file, arrays, small=True):
            return
        with self._lock:
            if self._taken is None:
                self._taken = keep_to_limit(self._root, self._most_bytes)
            else:
                with contextlib.suppress(OSError):
                    self._taken += file.stat().st_size
                if self._taken > self._most_bytes:
                    self._taken = keep_to_limit(self._root, self._most_bytes)

    def _touch(self, file: Path) -> None:
        """What is used is kept."""
        now = time.monotonic()
        if now - self._touched.get(file, -_TOUCHED_S) >= _TOUCHED_S:
            self._touched[file] = now
            with contextlib.suppress(OSError):
                os.utime(file)


class StreamFiles(Generic[P]):
    """The files of one map that streams. stamp: all that it follows from; name: of their format; root: the folder they
    lie in, None: none is kept."""

    def __init__(
        self, kind: PageKind[P], root: Path | None, stamp: tuple[object, ...] | None, most_bytes: int, name: str,
        pages_name: str,
    ) -> None:  # fmt: skip
        self._root = root
        self._key = TableCache.key(repr(stamp), str(most_bytes), name)
        # Pages don't depend on the memory that there is.
        pages = TableCache.key(repr(stamp), pages_name)
        self.files = PageFiles(kind, None if root is None else root / pages, root)

    @property
    def index(self) -> Path | None:
        """The file that says what is where; None without a cache folder."""
        return self._named("index.npz")

    def _named(self, name: str) -> Path | None:
        return None if self._root is None else self._root / f"{self._key}.{name}"

    def blocks(self, number: int, k: int) -> Path | None:
        """The file of the blocks of level k of a set."""
        return self._named(f"{number}-{k}.blocks")
