"""Single tiles of elevation: what their names and headers say of where they are, and the heights that they hold.

- `.hgt` (SRTM): N46E007.hgt, one degree, big-endian 16 bits, -32768 is a void. Rows and columns lie on the degree's
  lines, 3601 x 3601 for 1 arc second.
- GeoTIFF in degrees or in EPSG:3857, read through tifffile (extra `maps`). Pixels are areas unless the file says that
  they are points; GDAL_NODATA and numbers that are not finite are voids.
- PNG by zoom/x/y (12/2138/1443.png), 256 or 512 pixels: heights in red, green and blue.
"""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from types import ModuleType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..settings import SettingError
from .lattice import MERCATOR_SIDE_M, Lattice

__all__ = [
    "ENDINGS",
    "PNG_CODES",
    "Found",
    "TileError",
    "find_tile",
    "page_values",
    "read_part",
    "read_tile",
    "tifffile_or_error",
]

Heights = NDArray[np.float32]

ENDINGS = (".hgt", ".tif", ".tiff", ".png")
_HGT_VOID = -32768
_NAME = re.compile(r"([NS])(\d{1,2})_?([EW])(\d{1,3})", re.IGNORECASE)
_LOWEST_M, _HIGHEST_M = -1.2e4, 1e5
"""Heights beyond are voids that a file forgot to name: no trench is deeper, and no mountain known is higher."""
MAPS = "pip install 'planetfall[maps]'"


class TileError(SettingError):
    """A tile that can't be used: what, where, expected, found, and what to do."""


def _terrain_rgb(rgb: NDArray[Any]) -> NDArray[np.float64]:
    red, green, blue = (rgb[..., k].astype(np.float64) for k in range(3))
    return -10000.0 + 0.1 * (red * 65536.0 + green * 256.0 + blue)


def _terrarium(rgb: NDArray[Any]) -> NDArray[np.float64]:
    red, green, blue = (rgb[..., k].astype(np.float64) for k in range(3))
    return red * 256.0 + green + blue / 256.0 - 32768.0


PNG_CODES: dict[str, Callable[[NDArray[Any]], NDArray[np.float64]]] = {
    "terrain-rgb": _terrain_rgb,
    "terrarium": _terrarium,
}
"""What red, green and blue of a tile say."""


@dataclass(frozen=True)
class Found:
    """A tile: its lattice, its first sample there (column, row), and how many columns and rows it has."""

    lattice: Lattice
    column: int
    row: int
    columns: int
    rows: int


def find_tile(file: Path, inside: PurePosixPath, size_bytes: int) -> Found:
    """Where a file's samples are. inside: its path from the folder of tiles. TileError says what is wrong."""
    ending = file.suffix.lower()
    if ending == ".hgt":
        found = _find_hgt(file, size_bytes)
    elif ending in (".png", ".jpg", ".jpeg"):
        found = _find_png(file, inside)
    else:
        found = _find_tiff(file)
    return _on_the_world(file, found)


def _on_the_world(file: Path, found: Found) -> Found:
    lattice = found.lattice
    if found.columns < 1 or found.rows < 1:
        raise TileError(f"{file} has no samples: fetch it again, or remove it")
    v = (np.array([found.row, found.row + found.rows - 1]) + lattice.phase_y) / lattice.down
    u = (np.array([found.column, found.column + found.columns - 1]) + lattice.phase_x) / lattice.across
    near = 1e-6  # of the world: numbers in files are rounded
    if v.min() < -near or v.max() > 1.0 + near or u.min() < -1.0 - near or u.max() > 2.0 + near:
        north, south = 90.0 - 180.0 * v if not lattice.mercator else lattice.place(np.zeros(2), v * lattice.down)[0]
        west, east = 360.0 * u - 180.0
        raise TileError(
            f"{file} lies at latitudes {south:.6g} to {north:.6g}, longitudes {west:.6g} to {east:.6g}; expected -90 "
            "to 90 and -180 to 180, in degrees: correct its place, or remove it"
        )
    if found.columns > lattice.across + 1.0 + 1e-6:
        raise TileError(f"{file} goes around the world more than once, {found.columns} columns; remove it")
    return found


def read_tile(file: Path, found: Found, png: str = "terrain-rgb") -> Heights:
    """Heights (rows, columns) in metres, NaN where there is none. TileError says what is wrong."""
    ending = file.suffix.lower()
    read = {".hgt": _read_hgt, ".png": _read_png}.get(ending, _read_tiff)
    try:
        values = read(file, found, png)
    except TileError:
        raise
    except Exception as error:  # decoders raise whatever theirs do
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    if values.shape != (found.rows, found.columns):
        raise TileError(
            f"{file} holds {values.shape[1]} x {values.shape[0]} samples; expected {found.columns} x {found.rows}: "
            "fetch it again, or remove it"
        )
    return _believed(values)


def _believed(values: NDArray[Any]) -> Heights:
    with np.errstate(invalid="ignore"):
        bad = ~((values >= _LOWEST_M) & (values <= _HIGHEST_M))
    if bad.any():
        values = np.where(bad, np.nan, values)
    return values.astype(np.float32, copy=False)


def read_part(file: Path, found: Found, rows: slice, columns: slice) -> Heights | None:
    """As read_tile, of some rows and columns; None for files that have to be decoded whole."""
    if file.suffix.lower() != ".hgt":
        return None
    try:
        values = np.memmap(file, dtype=">i2", mode="r", shape=(found.rows, found.columns))[rows, columns]
    except (OSError, ValueError) as error:
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    return _believed(_hgt_heights(values))


def _degrees(west: float, north: float, step_x: float, step_y: float, columns: int, rows: int) -> Found:
    """Of the middle of the first sample, and the steps to the next ones."""
    # Steps are written with some digits only: 0.000277777778 degrees are a whole part of the circle.
    across, down = (
        float(round(count)) if abs(count - round(count)) < 1e-6 * count else count
        for count in (360.0 / step_x, 180.0 / step_y)
    )
    return _placed(False, across, down, (west + 180.0) / 360.0 * across, (90.0 - north) / 180.0 * down, columns, rows)


def _placed(mercator: bool, across: float, down: float, x: float, y: float, columns: int, rows: int) -> Found:
    column, row = math.floor(x + 0.01), math.floor(y + 0.01)
    phases = [0.0 if abs(v) < 0.01 else 0.5 if abs(v - 0.5) < 0.01 else v for v in (x - column, y - row)]
    return Found(Lattice(mercator, across, down, *phases), column, row, columns, rows)


def _find_hgt(file: Path, size_bytes: int) -> Found:
    match = _NAME.search(file.stem)
    if match is None:
        raise TileError(f"{file} has no place in its name; expected N46E007.hgt or the like: rename it")
    side = math.isqrt(size_bytes // 2)
    if side < 2 or 2 * side * side != size_bytes:
        raise TileError(
            f"{file} has {size_bytes} bytes; expected 2 n n for n samples a side (1201: 2884802, 3601: 25934402): "
            "fetch it again, or remove it"
        )
    south, west = _corner(match)
    step = 1.0 / (side - 1)
    return _degrees(west, south + 1.0, step, step, side, side)


def _corner(match: re.Match[str]) -> tuple[float, float]:
    """South and west of a tile of one degree."""
    ns, latitude, ew, longitude = match.groups()
    return float(latitude) * (1.0 if ns in "nN" else -1.0), float(longitude) * (1.0 if ew in "eE" else -1.0)


def _read_hgt(file: Path, found: Found, png: str) -> NDArray[Any]:
    return _hgt_heights(np.fromfile(file, dtype=">i2").reshape(found.rows, found.columns))


def _hgt_heights(values: NDArray[Any]) -> NDArray[Any]:
    return np.where(values == _HGT_VOID, np.nan, values.astype(np.float32))


def _find_png(file: Path, inside: PurePosixPath) -> Found:
    from PIL import Image

    parts = (*inside.parts[-3:-1], inside.stem)
    if len(parts) != 3 or not all(part.isdecimal() for part in parts):
        raise TileError(f"{file} is no tile by zoom/x/y; expected 12/2138/1443.png or the like: rename it")
    zoom, x, y = (int(part) for part in parts)
    if zoom > 24 or x >= 1 << zoom or y >= 1 << zoom:
        raise TileError(f"{file}: there is no tile {zoom}/{x}/{y}; expected x and y below 2^zoom: rename it")
    try:
        with Image.open(file) as picture:
            width, height = picture.size
    except (OSError, SyntaxError, ValueError) as error:
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    if width != height:
        raise TileError(f"{file} is {width} x {height}; expected a square: fetch it again, or remove it")
    count = float(width << zoom)
    return Found(Lattice(True, count, count, 0.5, 0.5), x * width, y * width, width, width)


def _read_png(file: Path, found: Found, png: str) -> NDArray[Any]:
    from PIL import Image

    with Image.open(file) as picture:
        array = np.asarray(picture.convert("RGBA"))
    heights = PNG_CODES[png](array)
    return np.where(array[..., 3] == 0, np.nan, heights)


def tifffile_or_error() -> ModuleType:
    """The module. TileError without it."""
    try:
        import tifffile
    except ImportError:
        raise TileError(f"GeoTIFF needs tifffile: {MAPS}") from None
    return tifffile


def _find_tiff(file: Path) -> Found:
    tifffile = tifffile_or_error()
    try:
        with tifffile.TiffFile(file) as tiff:
            page = tiff.pages[0]
            rows, columns = page.imagelength, page.imagewidth
            tags = dict(page.geotiff_tags or {})
    except Exception as error:
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    scale, ties = tags.get("ModelPixelScale"), tags.get("ModelTiepoint")
    if scale is None or ties is None:
        raise TileError(
            f"{file} doesn't say where it is (ModelPixelScale and ModelTiepoint are missing): write it as a GeoTIFF, "
            "such as with gdal_translate -a_ullr"
        )
    i, j, _, x, y, _ = (float(v) for v in np.ravel(ties)[:6])
    step_x, step_y = float(scale[0]), float(scale[1])
    if not all(math.isfinite(v) for v in (i, j, x, y)) or not all(0.0 < v < math.inf for v in (step_x, step_y)):
        raise TileError(
            f"{file}: its first pixel is at ({x:g}, {y:g}), pixels are {step_x:g} x {step_y:g}; expected numbers, and "
            "pixels above 0, rows from north to south: write it anew with gdalwarp -t_srs EPSG:4326 -r cubic"
        )
    # The place of the first sample's middle.
    first = 0.0 if int(tags.get("GTRasterTypeGeoKey", 1)) == 2 else 0.5
    x, y = x + (first - i) * step_x, y - (first - j) * step_y
    if int(tags.get("GTModelTypeGeoKey", 2)) == 2:
        return _degrees(x, y, step_x, step_y, columns, rows)
    code = int(tags.get("ProjectedCSTypeGeoKey", 0))
    if code != 3857:
        raise TileError(
            f"{file} is in the projection EPSG:{code}; expected degrees (EPSG:4326) or EPSG:3857: write it anew with "
            "gdalwarp -t_srs EPSG:4326 -r cubic"
        )
    side = MERCATOR_SIDE_M
    return _placed(
        True, side / step_x, side / step_y, (x / side + 0.5) * side / step_x, (0.5 - y / side) * side / step_y, columns,
        rows,
    )  # fmt: skip


class Page(Protocol):
    """A picture of an open TIFF."""

    def asarray(self) -> NDArray[Any]: ...


def page_values(file: Path, page: Page) -> NDArray[Any]:
    """What a page of an open GeoTIFF holds. TileError where a codec is missing."""
    try:
        return page.asarray()
    except ValueError as error:
        if "imagecodecs" in str(error):
            raise TileError(f"{file} is compressed in a way that needs imagecodecs: {MAPS}") from error
        raise


def _read_tiff(file: Path, found: Found, png: str) -> NDArray[Any]:
    with tifffile_or_error().TiffFile(file) as tiff:
        page = tiff.pages[0]
        values = page_values(file, page)
        tag = page.tags.get("GDAL_NODATA")
    if values.ndim != 2:
        raise TileError(f"{file} has {values.shape[-1]} channels; expected one: heights in metres")
    heights = values.astype(np.float64)
    if tag is not None:
        with contextlib.suppress(ValueError):
            heights[values == float(str(tag.value).strip("\x00 "))] = np.nan
    return heights
