"""Single tiles of pictures of the ground: colours as files hold them, and what is a gap in them.

PNG and JPEG by zoom/x/y (12/2138/1443.jpg), 256 or 512 pixels, and GeoTIFFs of grey or red, green and blue, of 8 or 16
bits, in degrees or in EPSG:3857. Where they lie tile_files.find_tile says. Transparent pixels are gaps, and so are
those all of whose channels hold a GeoTIFF's GDAL_NODATA.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .tile_files import Found, TileError, page_values, tifffile_or_error

__all__ = ["read_color_tile"]

Pixels = NDArray[np.uint8]


def read_color_tile(file: Path, found: Found) -> Pixels:
    """Red, green and blue as files hold them (sRGB), and 255 where there is a pixel, 0 in gaps: (rows, columns, 4).
    TileError says what is wrong."""
    try:
        values = _read_tiff(file) if file.suffix.lower() in (".tif", ".tiff") else _read_picture(file)
    except TileError:
        raise
    except Exception as error:  # decoders raise whatever theirs do
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    if values.shape[:2] != (found.rows, found.columns):
        raise TileError(
            f"{file} holds {values.shape[1]} x {values.shape[0]} pixels; expected {found.columns} x {found.rows}: "
            "fetch it again, or remove it"
        )
    return values


def _read_picture(file: Path) -> Pixels:
    from PIL import Image

    with Image.open(file) as picture:
        if picture.mode.startswith("I"):  # grey of 16 bits
            return _four(np.asarray(picture).astype(np.uint16)[..., None], None)
        array = np.asarray(picture.convert("RGBA"))
    return np.concatenate([array[..., :3], np.where(array[..., 3:] < 128, 0, 255).astype(np.uint8)], axis=2)


def _read_tiff(file: Path) -> Pixels:
    with tifffile_or_error().TiffFile(file) as tiff:
        page = tiff.pages[0]
        values = page_values(file, page)
        tag, kind = page.tags.get("GDAL_NODATA"), int(page.photometric)
        planes = int(page.planarconfig) == 2
    if kind not in (1, 2, 6):
        raise TileError(
            f"{file} holds no red, green and blue (photometric interpretation {kind}); write it anew with "
            "gdal_translate -expand rgb"
        )
    if values.ndim == 2:
        values = values[..., None]
    elif planes:
        values = np.moveaxis(values, 0, -1)
    if values.shape[2] > 4:
        raise TileError(
            f"{file} has {values.shape[2]} channels; expected grey, or red, green and blue: choose three with "
            "gdal_translate -b 1 -b 2 -b 3"
        )
    nodata = None
    if tag is not None:
        with contextlib.suppress(ValueError):
            nodata = float(str(tag.value).strip("\x00 "))
    try:
        return _four(values, nodata)
    except ValueError as error:
        raise TileError(f"{file} {error}") from None


def _four(values: NDArray[Any], nodata: float | None) -> Pixels:
    """Of 1 to 4 channels: the second or the fourth is how opaque pixels are."""
    if values.dtype not in (np.uint8, np.uint16):
        raise ValueError(
            f"holds {values.dtype} values; expected whole numbers of 8 or 16 bits without a sign: write it anew with "
            "gdal_translate -ot Byte -scale"
        )
    count = values.shape[2]
    colors = values[..., :3] if count >= 3 else np.repeat(values[..., :1], 3, axis=2)
    there = np.ones(values.shape[:2], bool)
    if count in (2, 4):
        there &= values[..., -1] >= np.iinfo(values.dtype).max // 2 + 1
    if nodata is not None:
        there &= (colors != nodata).any(axis=2)
    if values.dtype == np.uint16:
        colors = (colors.astype(np.uint32) + 128) // 257
    out = np.empty((*there.shape, 4), np.uint8)
    out[..., :3], out[..., 3] = colors, np.where(there, 255, 0)
    return out
