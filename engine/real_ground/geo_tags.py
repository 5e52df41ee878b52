"""What the header of a GeoTIFF says: where its pixels are in the coordinates of its system, what its keys say of that
system, and what its numbers mean (OGC GeoTIFF 1.1, 19-008r4; GDAL's own tags for gaps, scale and units)."""

from __future__ import annotations

import contextlib
import math
import os
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from types import ModuleType
from typing import Any, Protocol
from xml.etree import ElementTree

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .found import MAPS, MissingLibrary, TileError

__all__ = ["WARP_LINE", "GeoHeader", "Keys", "Matrix", "file_stamp", "geo_header", "nodata_of", "tifffile_or_error"]

Keys = tuple[tuple[str, Any], ...]
Matrix = tuple[float, float, float, float, float, float]
Floats = NDArray[np.float64]
Stamp = tuple[str, int, int]

WARP_LINE = "write it anew with gdalwarp -t_srs EPSG:4326 -r cubic"
_USER_DEFINED = 32767
_UNIT_NAMES = {
    "m": 1.0, "metre": 1.0, "meter": 1.0, "metres": 1.0, "meters": 1.0, "ft": 0.3048, "foot": 0.3048, "feet": 0.3048,
    "international foot": 0.3048, "ft_us": 1200.0 / 3937.0, "us-ft": 1200.0 / 3937.0, "sft": 1200.0 / 3937.0,
    "us survey foot": 1200.0 / 3937.0, "us_survey_foot": 1200.0 / 3937.0, "cm": 0.01, "dm": 0.1, "mm": 0.001,
    "km": 1000.0,
}  # fmt: skip


@dataclass(frozen=True)
class GeoHeader:
    """matrix: (a, b, c, d, e, f): the middle of the pixel in column i and row j is at x = a i + b j + c, y = d i + e j
    + f, as model coordinates. keys: names and values of the GeoKeys, sorted. scale, offset: what makes of its numbers
    what its band means. unit_m: of that, where the file's own tags say it. nodata: of its numbers."""

    columns: int
    rows: int
    matrix: Matrix
    keys: Keys
    scale: float = 1.0
    offset: float = 0.0
    unit_m: float | None = None
    nodata: float | None = None

    @property
    def upright(self) -> bool:
        """Whether columns go along x, and rows against y."""
        a, b, _, d, e, _ = self.matrix
        return b == 0.0 and d == 0.0 and a > 0.0 and e < 0.0

    def model(self, column: ArrayLike, row: ArrayLike) -> tuple[Floats, Floats]:
        """Coordinates of pixels, 0 in the middle of the first one."""
        a, b, c, d, e, f = self.matrix
        column, row = np.asarray(column, np.float64), np.asarray(row, np.float64)
        return a * column + b * row + c, d * column + e * row + f

    def pixel(self, x: ArrayLike, y: ArrayLike) -> tuple[Floats, Floats]:
        """The inverse of `model`; not finite where coordinates aren't."""
        a, b, c, d, e, f = self.matrix
        with np.errstate(invalid="ignore"):
            x, y, area = np.asarray(x) - c, np.asarray(y) - f, a * e - b * d
            return (e * x - b * y) / area, (a * y - d * x) / area


def tifffile_or_error() -> ModuleType:
    """The module. TileError without it."""
    try:
        import tifffile
    except ImportError:
        raise MissingLibrary(f"GeoTIFF needs tifffile: {MAPS}") from None
    return tifffile


def file_stamp(file: Path) -> Stamp:
    """What tells whether a file has changed. TileError for none."""
    try:
        found = os.stat(file)
    except OSError as error:
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    return str(file), found.st_mtime_ns, found.st_size


def geo_header(file: Path) -> GeoHeader:
    """What a file's header says, kept. TileError says what is wrong."""
    return _header(file_stamp(file))


@lru_cache(maxsize=4096)
def _header(stamp: Stamp) -> GeoHeader:
    file = Path(stamp[0])
    tifffile = tifffile_or_error()
    try:
        with tifffile.TiffFile(file) as tiff:
            page = tiff.pages[0]
            rows, columns = page.imagelength, page.imagewidth
            tags = dict(page.geotiff_tags or {})
            placed = 33550 in page.tags or 34264 in page.tags
            metadata, nodata = page.tags.valueof(42112), nodata_of(page)
    except Exception as error:  # it raises what it likes for half a file
        raise TileError(f"{file} can't be read: {error}; is it whole? Fetch it again, or remove it") from error
    if placed and not tags:
        raise TileError(
            f"{file} says where it is, but not in which coordinate system: name it, such as with gdal_edit.py -a_srs"
        )
    matrix = _matrix(file, tags)
    keys = tuple(sorted((str(name), _plain(value)) for name, value in tags.items() if str(name).endswith("GeoKey")))
    return GeoHeader(columns, rows, matrix, keys, *_band(metadata), nodata)


class _Tag(Protocol):
    @property
    def value(self) -> object: ...


class _Tags(Protocol):
    def get(self, key: str, /) -> _Tag | None: ...


class TaggedPage(Protocol):
    """A picture of an open TIFF."""

    @property
    def tags(self) -> _Tags: ...


def nodata_of(page: TaggedPage) -> float | None:
    """The number of an open page that stands for none, if it says one."""
    tag = page.tags.get("GDAL_NODATA")
    if tag is not None:
        with contextlib.suppress(ValueError):
            return float(str(tag.value).strip("\x00 "))
    return None


def _plain(value: Any) -> Any:
    """Numbers and texts that can be compared and kept."""
    if isinstance(value, str):
        return value.strip("\x00 ")
    if isinstance(value, (list, tuple, np.ndarray)):
        return tuple(float(v) for v in np.ravel(value))
    with contextlib.suppress(TypeError, ValueError):
        number = float(value)
        return int(number) if number.is_integer() and not isinstance(value, float) else number
    return str(value)


def _matrix(file: Path, tags: dict[str, Any]) -> Matrix:
    # Raster coordinates count from the corner of the first pixel, unless pixels are points.
    half = 0.0 if int(tags.get("GTRasterTypeGeoKey", 1)) == 2 else 0.5
    scale, ties, whole = tags.get("ModelPixelScale"), tags.get("ModelTiepoint"), tags.get("ModelTransformation")
    if scale is not None and ties is not None:
        i, j, _, x, y, _ = (float(v) for v in np.ravel(ties)[:6])
        step_x, step_y = float(scale[0]), float(scale[1])
        if not all(math.isfinite(v) for v in (i, j, x, y)) or not all(0.0 < v < math.inf for v in (step_x, step_y)):
            raise TileError(
                f"{file}: its first pixel is at ({x:g}, {y:g}), pixels are {step_x:g} x {step_y:g}; expected numbers, "
                f"and pixels above 0, rows from north to south (others by ModelTransformation): {WARP_LINE}"
            )
        return step_x, 0.0, x + (half - i) * step_x, 0.0, -step_y, y - (half - j) * step_y
    if whole is None:
        count = 0 if ties is None else np.size(ties) // 6
        raise TileError(
            f"{file} has tie points alone, {count} of them; expected ModelPixelScale or "
            f"ModelTransformation, too: {WARP_LINE}"
            if count > 1
            else f"{file} doesn't say where it is (ModelPixelScale and ModelTiepoint, or ModelTransformation, are "
            "missing): write it as a GeoTIFF, such as with gdal_translate -a_ullr"
        )
    a, b, _, c, d, e, _, f = (float(v) for v in np.ravel(whole)[:8])
    pixels = abs(a * e - b * d)
    if not all(math.isfinite(v) for v in (a, b, c, d, e, f)) or pixels <= 1e-9 * (a * a + b * b + d * d + e * e):
        raise TileError(
            f"{file}: ModelTransformation is x = {a:g} i + {b:g} j + {c:g}, y = {d:g} i + {e:g} j + {f:g}; expected "
            f"numbers, and pixels that have an area: {WARP_LINE}"
        )
    return a, b, c + half * (a + b), d, e, f + half * (d + e)


def _band(metadata: Any) -> tuple[float, float, float | None]:
    """Scale, offset and metres of a unit, as GDAL writes them of the first band."""
    scale, offset, unit_m = 1.0, 0.0, None
    if not isinstance(metadata, str):
        return scale, offset, unit_m
    with contextlib.suppress(ElementTree.ParseError, ValueError):
        for item in ElementTree.fromstring(metadata.strip("\x00 ")).iter("Item"):
            if item.get("sample", "0") != "0" or item.text is None:
                continue
            role, text = item.get("role", ""), item.text.strip()
            if role == "scale":
                scale = float(text)
            elif role == "offset":
                offset = float(text)
            elif role == "unittype":
                unit_m = _UNIT_NAMES.get(text.lower())
    return scale, offset, unit_m
