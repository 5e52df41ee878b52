"""Snapshot: a picture that shows itself in notebooks."""

from __future__ import annotations

import io
import os
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..systems.capture import CaptureError

if TYPE_CHECKING:
    from PIL import Image


class Snapshot:
    """A rendered picture. array: (H, W, 3) u8 sRGB."""

    def __init__(self, array: NDArray[np.uint8]) -> None:
        self.array = array

    @property
    def image(self) -> Image.Image:
        """As a Pillow image."""
        from PIL import Image

        return Image.fromarray(self.array)

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        self.image.save(data, "PNG")
        return data.getvalue()

    def save(self, path: str | PathLike[str], **options: Any) -> Path:
        """Write the picture; the format follows the file's name. Written beside, then renamed.

        options: of Pillow's Image.save. CaptureError for a format that there isn't, or a file that can't be written.
        """
        target = Path(path)
        beside = target.with_name(f".{target.stem}.tmp{target.suffix}")
        try:
            self.image.save(beside, **options)
            os.replace(beside, target)
        except (OSError, ValueError, KeyError) as error:  # KeyError: a format that Pillow lacks
            beside.unlink(missing_ok=True)
            reason = getattr(error, "strerror", None) or error.args[0]
            raise CaptureError(f"{target} can't be written: {reason}; expected a name such as picture.png") from error
        return target

    def __repr__(self) -> str:
        height, width = self.array.shape[:2]
        return f"<Snapshot {width} x {height}>"
