"""Single tiles of elevation: what their names and headers say of where they are, and the heights that they hold.

- `.hgt` (SRTM): N46E007.hgt, one degree, big-endian 16 bits, -32768 is a void. Rows and columns lie on the degree's
  lines, 3601 x 3601 for 1 arc second.
- GeoTIFF, read through tifffile (extra `maps`). Pixels are areas unless the file says that they are points; GDAL_NODATA
  and numbers that are not finite are voids. Samples of files in degrees and in EPSG:3857 are used as they are, those in
  other coordinate systems are interpolated at a lattice of degrees (warp_lattice.py, warp.py).
- PNG by zoom/x/y (12/2138/1443.png), 256 or 512 pixels: heights in red, green and blue.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path, PurePosixPath
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from .found import MAPS, Found, TileError
from .geo_system import System, plain_kind, system_of
from .geo_tags import GeoHeader, geo_header, tifffile_or_error
from .lattice import MERCATOR_SIDE_M, Lattice
from .tile_numbers import believed, plain_heights
from .warp_lattice import warped_place
from .warped_files import warped_heights

__all__ = [
    "ENDINGS",
    "PNG_CODES",
    "Found",
    "TileError",
    "find_tile",
    "page_values",
    "read_part",
    "read_tile",
]

Heights = NDArray[np.float32]

ENDINGS = (".hgt", ".tif", ".tiff", ".png")
_HGT_VOID = -32768
_NAME = re.compile(r"([NS])(\d{1,2})_?([EW])(\d{1,3})", re.IGNORECASE)


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


def find_tile(file: Path, inside: PurePosixPath, size_bytes: int) -> Found:
    """Where a file's samples are. inside: its path from the folder of tiles. TileError says what is wrong."""
    ending = file.suffix.lower()
    try:
        if ending == ".hgt":
            found = _find_hgt(file, size_bytes)
        elif ending in (".png", ".jpg", ".jpeg"):
            found = _find_png(file, inside)
        else:
            found = _find_tiff(file)
        return _on_the_world(file, found)
    except TileError:
        raise
    except Exception as error:  # damaged headers make readers, and sums over what they say, raise what they like
        raise TileError(f"{file} can't be read: {error!r}; is it whole? Fetch it again, or remove it") from error


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
    return believed(values).astype(np.float32, copy=False)


def read_part(file: Path, found: Found, rows: slice, columns: slice) -> Heights | None:
    """As read_tile, of some rows and columns; None for files that have to be decoded whole."""
    if found.warped:
        return read_tile(file, found.window(rows, columns))
    if file.suffix.lower() != ".hgt":
        return None
    try:
        values = np.memmap(file, dtype=">i2", mode="r", shape=(found.rows, found.columns))[rows, columns]
    except (OSError, ValueError) as error:
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    return believed(_hgt_heights(values)).astype(np.float32, copy=False)


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


def _find_tiff(file: Path) -> Found:
    header = geo_header(file)
    kind = plain_kind(header.keys)
    a, _, x, _, e, y = header.matrix
    if kind == "degrees" and header.upright:
        return _degrees(x, y, a, -e, header.columns, header.rows)
    if kind == "mercator" and header.upright:
        side = MERCATOR_SIDE_M
        across, down = side / a, -side / e
        return _placed(
            True, across, down, (x / side + 0.5) * across, (0.5 - y / side) * down, header.columns, header.rows
        )
    system = system_of(file, header)
    if system.geographic and header.upright and _unmoved(header, system):
        return _degrees(x, y, a, -e, header.columns, header.rows)
    return warped_place(file, header, system)


def _unmoved(header: GeoHeader, system: System) -> bool:
    """Whether a system's angles are the map's degrees, to a thousandth of a pixel."""
    j, i = (v.ravel() for v in np.meshgrid(*(np.linspace(0.0, n - 1.0, 3) for n in (header.rows, header.columns))))
    x, y = header.model(i, j)
    longitude, latitude = system.place(x, y)
    a, e = header.matrix[0], header.matrix[4]
    with np.errstate(invalid="ignore"):
        turned = (longitude - x + 180.0) % 360.0 - 180.0
        return bool((np.abs(turned / a) < 1e-3).all() and (np.abs((latitude - y) / e) < 1e-3).all())


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
    if found.warped:
        return warped_heights(file, found)
    with tifffile_or_error().TiffFile(file) as tiff:
        values = page_values(file, tiff.pages[0])
    if values.ndim != 2:
        raise TileError(f"{file} has {values.shape[-1]} channels; expected one: heights in metres")
    return plain_heights(file, geo_header(file), values)
