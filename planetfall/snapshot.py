"""Snapshot: a picture that shows itself in notebooks."""

from __future__ import annotations

import io
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image


class Snapshot:
    """A rendered picture. array: (H, W, 3) u8 sRGB."""

    def __init__(self, array: NDArray[np.uint8]) -> None:
        self.array = array

    @property
    def image(self) -> Image.Image:
        """As a Pillow image."""
        return Image.fromarray(self.array)

    def _repr_png_(self) -> bytes:
        data = io.BytesIO()
        self.image.save(data, "PNG")
        return data.getvalue()

    def save(self, path: str | PathLike[str], **options: Any) -> Path:
        """Write the picture; the format follows the file's name."""
        target = Path(path)
        self.image.save(target, **options)
        return target

    def __repr__(self) -> str:
        height, width = self.array.shape[:2]
        return f"<Snapshot {width} x {height}>"
