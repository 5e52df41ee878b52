"""JPEG files that carry the settings they were made with, for pictures on pages."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError, written_beside
from .png import json_plain

QUALITY = 88
"""Of Pillow's 1 to 95: a picture of 1280 x 720 takes 100 to 250 kB, and banding in skies stays out of sight."""


def write_jpeg(path: Path | str, pixels: NDArray[np.uint8], settings: Mapping[str, Any] | None = None) -> Path:
    """Write u8 pixels (H, W, 3), row 0 on top, with ``settings`` as JSON in the file's comment."""
    from PIL import Image

    path = Path(path)
    if pixels.dtype != np.uint8 or pixels.ndim != 3 or pixels.shape[2] != 3:
        raise CaptureError(f"{path}: a JPEG takes u8 pixels (H, W, 3), found {pixels.dtype} {pixels.shape}")
    comment = {} if settings is None else {"comment": json.dumps(settings, default=json_plain).encode()}
    with written_beside(path) as beside:
        Image.fromarray(np.ascontiguousarray(pixels)).save(
            beside, format="JPEG", quality=QUALITY, optimize=True, progressive=True, **comment
        )
    return path


def read_jpeg_settings(path: Path | str) -> dict[str, Any] | None:
    """The settings inside a JPEG of ours; None when there are none. CaptureError when it is no picture."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            comment = image.info.get("comment", b"")
    except (OSError, UnidentifiedImageError) as error:
        raise CaptureError(f"{path} cannot be read as a picture: {error}; delete it or name another folder") from error
    try:
        found = json.loads(comment)
    except (ValueError, TypeError):
        return None
    return found if isinstance(found, dict) else None
