"""Numbered pictures of a sequence, resumable: what is on disk already is not made again."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError, remove_unfinished, require_writable, written_beside
from .png import json_plain, write_png

MANIFEST = "sequence.json"
_PNG_END = b"\0\0\0\0IEND\xae\x42\x60\x82"
"""The last chunk of every PNG."""


class NumberedFrames:
    """``folder/frame_0000.png`` and so on. A manifest holds what the frames were made of: frames of another
    flight, size or quality are not mixed in but refused, unless ``force`` writes all of them anew."""

    def __init__(
        self, folder: Path | str, count: int, *, settings: Mapping[str, Any] | None = None, force: bool = False
    ) -> None:
        if count < 1:
            raise CaptureError(f"a sequence needs at least one frame, found count = {count}")
        self.folder = require_writable(folder, make_folder=True)
        self.count = count
        self._digits = max(4, len(str(count - 1)))
        made_of = json.dumps({"count": count, "settings": settings or {}}, default=json_plain, sort_keys=True)
        manifest = self.folder / MANIFEST
        old = manifest.read_text(encoding="utf-8") if manifest.exists() else None
        if force:
            self._remove_frames()
        elif old is not None and old != made_of:
            raise CaptureError(
                f"{self.folder} holds frames made with other settings; replace them by force (--force) or name another"
            )
        elif old is None and any(self.folder.glob("frame_*.png")):
            raise CaptureError(
                f"{self.folder} holds frames of unknown origin; replace them by force (--force) or name another"
            )
        remove_unfinished(self.folder)
        with written_beside(manifest) as beside:
            beside.write_text(made_of, encoding="utf-8")

    def path(self, index: int) -> Path:
        return self.folder / f"frame_{index:0{self._digits}d}.png"

    @property
    def paths(self) -> list[Path]:
        return [self.path(index) for index in range(self.count)]

    def missing(self) -> Iterator[int]:
        """The numbers of the frames that are still to be made, in order; a file that is cut off counts as none."""
        return (index for index in range(self.count) if not _is_whole(self.path(index)))

    def write(self, index: int, pixels: NDArray[np.uint8], settings: Mapping[str, Any] | None = None) -> Path:
        return write_png(self.path(index), pixels, settings)

    def _remove_frames(self) -> None:
        for old in self.folder.glob("frame_*.png"):
            old.unlink()


def _is_whole(path: Path) -> bool:
    if not path.exists() or path.stat().st_size < len(_PNG_END):
        return False
    with path.open("rb") as file:
        file.seek(-len(_PNG_END), 2)
        return file.read() == _PNG_END
