"""Single tiles of pictures of the ground: colours as files hold them, and what is a gap in them.

PNG and JPEG by zoom/x/y (12/2138/1443.jpg), 256 or 512 pixels, and GeoTIFFs of grey or red, green and blue, of 8 or 16
bits. Where they lie tile_files.find_tile says. Transparent pixels are gaps, and so are those all of whose channels hold
a GeoTIFF's GDAL_NODATA.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .found import Found, TileError
from .geo_tags import nodata_of, tifffile_or_error
from .tiff_parts import tiff_parts
from .tile_files import page_values
from .warped_files import warped_colors

__all__ = ["read_color_tile"]

Pixels = NDArray[np.uint8]


def read_color_tile(file: Path, found: Found) -> Pixels:
    """Red, green and blue as files hold them (sRGB), and 255 where there is a pixel, 0 in gaps: (rows, columns, 4).
    TileError says what is wrong."""
    try:
        values = _read_tiff(file, found) if file.suffix.lower() in (".tif", ".tiff") else _read_picture(file)
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


def _read_tiff(file: Path, found: Found) -> Pixels:
    if found.warped:
        parts = tiff_parts(file)
        _check_kind(file, parts.photometric)
        return warped_colors(file, found, partial(_four_of, file, nodata=nodata_of(parts.page)))
    with tifffile_or_error().TiffFile(file) as tiff:
        page = tiff.pages[0]
        values = page_values(file, page)
        nodata, planes = nodata_of(page), int(page.planarconfig) == 2
        _check_kind(file, int(page.photometric))
    if values.ndim == 2:
        values = values[..., None]
    elif planes:
        values = np.moveaxis(values, 0, -1)
    return _four_of(file, values, nodata)


def _check_kind(file: Path, photometric: int) -> None:
    if photometric not in (1, 2, 6):
        raise TileError(
            f"{file} holds no red, green and blue (photometric interpretation {photometric}); write it anew with "
            "gdal_translate -expand rgb"
        )


def _four_of(file: Path, values: NDArray[Any], nodata: float | None) -> Pixels:
    if values.shape[2] > 4:
        raise TileError(
            f"{file} has {values.shape[2]} channels; expected grey, or red, green and blue: choose three with "
            "gdal_translate -b 1 -b 2 -b 3"
        )
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
