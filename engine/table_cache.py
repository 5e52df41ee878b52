"""Finished tables on disk, named after all they were computed from. A second start doesn't compute them again."""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

__all__ = ["TableCache"]

log = logging.getLogger(__name__)

KEPT, KEPT_BYTES = 64, 256 << 20
"""Files, and what they may take together, though the last one is kept whatever it takes: a quality's tables take
0.1 to 2 MB, those of the printed method 34 MB at full size."""
_STALE_S = 3600.0


class TableCache:
    """Arrays by key in a folder. What cannot be read counts as absent; what cannot be written is only logged.

    part: whose tables, a folder in the cache: "atmosphere", "clouds". folder: PLANETFALL_CACHE if set (empty: no
    cache), else the user's cache folder.
    """

    def __init__(self, part: str, folder: Path | str | None = None) -> None:
        if folder is None:
            chosen = os.environ.get("PLANETFALL_CACHE")
            folder = platformdirs.user_cache_path("planetfall") if chosen is None else chosen
        self.part = part
        self.folder = Path(folder) / part if str(folder) not in ("", ".") else None

    @staticmethod
    def key(*parts: str) -> str:
        """One name for all that a table depends on."""
        return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:40]

    def load(
        self, key: str, shapes: Mapping[str, tuple[int, ...]], kind: type[np.generic] = np.float32
    ) -> dict[str, NDArray[Any]] | None:
        """The arrays, finite and of these shapes, or None. kind: their type; others are converted."""
        if self.folder is None:
            return None
        path = self.folder / f"{key}.npz"
        try:
            with np.load(path, allow_pickle=False) as held:
                named = str(held["key"])
                found = {name: np.asarray(held[name], kind) for name in shapes}
        except FileNotFoundError:
            return None
        except Exception as error:
            log.warning("%s cannot be used and will be written again: %s", path, error)
            return None
        if named != key or any(found[n].shape != shapes[n] or not np.isfinite(found[n]).all() for n in shapes):
            log.warning("%s holds something else than was expected and will be written again", path)
            return None
        with contextlib.suppress(OSError):
            os.utime(path)  # what is used is kept
        return found

    def save(self, key: str, arrays: Mapping[str, NDArray[np.generic]]) -> None:
        """Written beside and renamed: nobody ever reads half a file. Only the files used last are kept."""
        if self.folder is None:
            return
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            handle, beside = tempfile.mkstemp(dir=self.folder, suffix=".part")
            try:
                with os.fdopen(handle, "wb") as file:
                    np.savez(file, key=np.array(key), **arrays)  # pyright: ignore[reportArgumentType]
                os.replace(beside, self.folder / f"{key}.npz")
            except BaseException:
                Path(beside).unlink(missing_ok=True)
                raise
            self._tidy()
        except OSError as error:
            log.warning(
                "tables of %s cannot be kept in %s, so the next start computes them again: %s",
                self.part,
                self.folder,
                error,
            )

    def _tidy(self) -> None:
        """Remove what was used longest ago, and halves that a killed process left. Others may do the same meanwhile."""
        assert self.folder is not None
        found: list[tuple[float, int, Path]] = []
        for path in self.folder.iterdir():
            with contextlib.suppress(FileNotFoundError):
                about = path.stat()
                found.append((about.st_mtime, about.st_size, path))
        late = [path for age, _, path in found if path.suffix == ".part" and age < time.time() - _STALE_S]
        taken = 0
        whole = sorted((file for file in found if file[2].suffix == ".npz"), reverse=True)
        for number, (_, size, path) in enumerate(whole):
            taken += size
            if number >= KEPT or (number > 0 and taken > KEPT_BYTES):
                late.append(path)
        for path in late:
            path.unlink(missing_ok=True)
