"""PNG files that carry the settings they were made with."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import CaptureError, written_beside

KEY = "planetfall"
"""The text chunk's name; its content is JSON."""


def write_png(path: Path | str, pixels: NDArray[np.uint8], settings: Mapping[str, Any] | None = None) -> Path:
    """Write u8 pixels (H, W, 3 or 4) or (H, W), row 0 on top, with ``settings`` (as JSON, arrays too) inside."""
    from PIL import Image
    from PIL.PngImagePlugin import PngInfo

    path = Path(path)
    if pixels.dtype != np.uint8:
        raise CaptureError(f"{path}: a PNG takes u8 pixels, found {pixels.dtype}; use .npz for other outputs")
    info = PngInfo()
    info.add_text("Software", "Planetfall")
    if settings is not None:
        info.add_itxt(KEY, json.dumps(settings, default=json_plain, ensure_ascii=False))
    with written_beside(path) as beside:
        Image.fromarray(np.ascontiguousarray(pixels)).save(beside, format="PNG", pnginfo=info, compress_level=4)
    return path


def read_png_settings(path: Path | str) -> dict[str, Any]:
    """The settings inside a PNG of ours. Raises CaptureError when there are none."""
    from PIL import Image, UnidentifiedImageError

    try:
        with Image.open(path) as image:
            image.load()  # text may stand after the pixels
            text = image.info.get(KEY)
    except (OSError, UnidentifiedImageError) as error:
        raise CaptureError(f"{path} cannot be read as a picture: {error}; name one that Planetfall wrote") from error
    if text is None:
        raise CaptureError(f"{path} carries no Planetfall settings; only pictures written by Planetfall do")
    return json.loads(text)


def json_plain(value: Any) -> object:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, set | frozenset):
        return sorted(value)
    return repr(value)
