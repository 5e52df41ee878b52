"""Reads maps of a planet from files: heights, colours, shares, equirectangular or as six faces; says what is wrong.

A path is a file (equirectangular), a folder, or a pattern with `{face}`; a folder means `{face}` with any known ending.
Equirectangular maps are twice as wide as high: longitude -180 at the left, +180 at the right, north on top. Or, with
2 h - 1 columns, registered on grid lines: first and last column are both the date line, first and last row the poles.
Faces: engine/surface/cube_map.py; pictures have their up side on top.
"""

from __future__ import annotations

import logging
import os
import warnings
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...engine.settings import SettingError
from ..srgb import srgb_decode
from ..user_paths import place_of
from .cube_map import FACES, CubeMap, cube_of, face_directions, face_place

__all__ = [
    "MapError",
    "files_stamp",
    "load_cube",
    "load_samples",
    "read_colors",
    "read_heights",
    "read_pixels",
    "read_shares",
]

log = logging.getLogger(__name__)

Floats = NDArray[np.float64]
Reader = Callable[[Path, str], NDArray[Any]]
Samples = Callable[[Floats], Floats]
"""Values (channels, N) at points (3, N), which need no unit length."""

ENDINGS = (".png", ".tif", ".tiff", ".exr", ".jpg", ".jpeg", ".npy")
MOST_CELLS = 2048
"""Of a face's side: finer maps are read at this, 6 km on Earth, and take 270 MB on the GPU."""


class MapError(SettingError):
    """A map that can't be used: what, where, expected, found, and what to do."""


def load_cube(path: str, what: str, read: Reader) -> CubeMap:
    """The map at `path` on the faces of a cube. what: the setting, for messages. read: (file, what) -> (h, w, c)."""
    sample, wanted = load_samples(path, what, read)
    return cube_of(sample, _cells(wanted, what, path))


def load_samples(path: str, what: str, read: Reader) -> tuple[Samples, int]:
    """The map at `path` as a function, cubic between its values, and the samples along a quarter of a great circle that
    hold all it has. what, read: as for load_cube."""
    place = place_of(path)
    if os.path.isdir(place):
        place = place / "{face}"
    if "{face}" in place.name:
        return _from_faces(place, what, read)
    if not os.path.exists(place):
        raise MapError(f"{what}: no file {str(place)!r} (looked from {Path.cwd()}); correct the path, or set it to ''")
    return _from_equirectangular(place, what, read)


class FileStamp(NamedTuple):
    """A file as it was found."""

    path: str
    changed_ns: int
    size_bytes: int


def files_stamp(path: str) -> tuple[FileStamp, ...]:
    """What tells whether the files of the map at `path` have changed."""
    place = place_of(path)
    folder = place if os.path.isdir(place) else place.parent
    files = [place]
    if os.path.isdir(place) or "{face}" in place.name:
        found = folder.glob("*") if os.path.isdir(folder) else ()
        files = sorted(f for f in found if any(name in f.name for name in FACES))
    stamps: list[FileStamp] = []
    for file in files:
        try:
            found = os.stat(file)
        except (OSError, ValueError):
            continue
        stamps.append(FileStamp(str(file), found.st_mtime_ns, found.st_size))
    return tuple(stamps)


def _from_faces(pattern: Path, what: str, read: Reader) -> tuple[Samples, int]:
    faces = [read(_face_file(pattern, name, what), what) for name in FACES]
    size = faces[0].shape[0]
    for name, face in zip(FACES, faces, strict=True):
        if face.shape[:2] != (size, size):
            raise MapError(
                f"{what}: face {name} of {pattern} is {face.shape[1]} x {face.shape[0]}; expected six squares of one "
                f"size, the first being {size} wide: resample them"
            )
    if size < 4:
        raise MapError(f"{what}: faces of {pattern} are {size} wide; expected at least 4")
    stack = np.stack([face[::-1] for face in faces])  # rows go up

    def tap(face: NDArray[np.int64], i: NDArray[np.int64], j: NDArray[np.int64]) -> Floats:
        found = stack[face, np.clip(j, 0, size - 1), np.clip(i, 0, size - 1)].astype(np.float64)
        away = np.flatnonzero((i < 0) | (j < 0) | (i >= size) | (j >= size))
        if away.size:  # beyond the edge: what the neighbour shows there
            s, t = ((2.0 * k[away] + 1.0 - size) / size for k in (i, j))
            points = np.empty((3, len(away)))
            for f in range(6):
                on = face[away] == f
                points[:, on] = face_directions(f, s[on], t[on]).T
            other, s, t, _ = face_place(points)
            x, y = (np.clip((k * 0.5 + 0.5) * size - 0.5, 0.0, size - 1.001) for k in (s, t))
            a, b = x.astype(np.int64), y.astype(np.int64)
            u, v = (x - a)[:, None], (y - b)[:, None]
            found[away] = (1.0 - v) * ((1.0 - u) * stack[other, b, a] + u * stack[other, b, a + 1]) + v * (
                (1.0 - u) * stack[other, b + 1, a] + u * stack[other, b + 1, a + 1]
            )
        return found

    def sample(points: Floats) -> Floats:
        face, s, t, _ = face_place(points)
        return _cubic(
            lambda i, j: tap(face, i, j), (s * 0.5 + 0.5) * size - 0.5, (t * 0.5 + 0.5) * size - 0.5
        )  # middles of pixels are at (i + 0.5) / size

    return sample, size


def _cells(wanted: int, what: str, file: str) -> int:
    if wanted > MOST_CELLS:
        log.warning("%s: %s is finer than can be kept: read at %.2g of its resolution", what, file, MOST_CELLS / wanted)
    return min(wanted, MOST_CELLS)


def _face_file(pattern: Path, name: str, what: str) -> Path:
    place = pattern.with_name(pattern.name.replace("{face}", name))
    tried = [place] if place.suffix else [place.with_suffix(ending) for ending in ENDINGS]
    for file in tried:
        if file.exists():
            return file
    raise MapError(
        f"{what}: face {name!r} is missing: no {' or '.join(str(t) for t in tried[:2])}"
        f"{' (or another ending)' if len(tried) > 2 else ''}; expected one file for each of {', '.join(FACES)}"
    )


def _from_equirectangular(file: Path, what: str, read: Reader) -> tuple[Samples, int]:
    values = read(file, what)
    height, width = values.shape[:2]
    grid_lines = width == 2 * height - 1 and height >= 5
    if not grid_lines and width != 2 * height:
        raise MapError(
            f"{what}: {file} is {width} x {height}; expected an equirectangular map twice as wide as high "
            f"({2 * height} x {height}), all of the planet: resample it, or give six faces"
        )
    if height < 4:
        raise MapError(f"{what}: {file} is {width} x {height}; expected at least 8 x 4")
    if grid_lines:
        values = values[:, :-1]
        width -= 1
    rows = height - 1 if grid_lines else height
    # Where the first pixel's middle is, in pixels from -180 degrees and from the north pole.
    first = 0.0 if grid_lines else 0.5

    def tap(i: NDArray[np.int64], j: NDArray[np.int64]) -> Floats:
        over, under = j < 0, j > height - 1  # beyond a pole the map goes on from it on the other side
        back = 0 if grid_lines else 1
        j = np.where(over, -j - back, np.where(under, 2 * (height - 1) - j + back, j))
        i = np.where(over | under, i + width // 2, i) % width
        return values[j, i]

    def sample(points: Floats) -> Floats:
        x, y, z = points
        longitude, colatitude = np.arctan2(y, x), np.arctan2(np.hypot(x, y), z)
        return _cubic(tap, (longitude / (2.0 * np.pi) + 0.5) * width - first, colatitude / np.pi * rows - first)

    return sample, -(-width // 3)


def _cubic(tap: Callable[[NDArray[np.int64], NDArray[np.int64]], Floats], x: Floats, y: Floats) -> Floats:
    """Catmull-Rom through taps at whole (i, j): (channels, N)."""
    i, j = np.floor(x), np.floor(y)
    f, g = (x - i)[:, None], (y - j)[:, None]
    wx, wy = (
        (
            w * (-0.5 + w * (1.0 - 0.5 * w)),
            1.0 + w * w * (1.5 * w - 2.5),
            w * (0.5 + w * (2.0 - 1.5 * w)),
            w * w * (0.5 * w - 0.5),
        )
        for w in (f, g)
    )
    column, row = i.astype(np.int64), j.astype(np.int64)
    total: Any = 0.0
    for b in range(4):
        total = total + wy[b] * sum(wx[a] * tap(column + (a - 1), row + (b - 1)) for a in range(4))
    return np.asarray(total).T


def read_heights(range_m: tuple[float, float] | None) -> Reader:
    """A reader of heights in metres, (h, w, 1). range_m: heights of the lowest and the highest value of whole numbers
    without a sign (0 and 65535), and of 0 and 1 of fractions; None: the values are metres."""

    def read(file: Path, what: str) -> NDArray[Any]:
        raw = read_pixels(file, what)
        if raw.ndim == 3 and raw.shape[2] == 1:
            raw = raw[:, :, 0]
        if raw.ndim != 2:
            raise MapError(
                f"{what}: {file} has {raw.shape[2]} channels; expected one: heights as grey, 16 bits "
                "(colours belong to Terrain.color_map)"
            )
        kind = raw.dtype.kind
        if range_m is None and kind == "u":
            raise MapError(
                f"{what}: {file} holds whole numbers from 0 to {np.iinfo(raw.dtype).max}, which say nothing of metres; "
                "set Terrain.height_map_range_m to the heights of the lowest and the highest, such as [-8200, 21200]"
            )
        if raw.dtype == np.uint8 and range_m is not None:
            step = (range_m[1] - range_m[0]) / 255.0
            log.warning("%s: %s has 8 bits: steps of %.3g m; use 16 bits", what, file, step)
        values = raw.astype(np.float64 if raw.dtype.itemsize > 4 else np.float32)
        bad = ~np.isfinite(values)
        if bad.any():
            j, i = np.argwhere(bad)[0]
            raise MapError(
                f"{what}: {file} has {int(bad.sum())} values that are no finite numbers, the first at column {i}, "
                f"row {j}; expected a height everywhere: fill the gaps"
            )
        if range_m is None:
            return values[:, :, None]
        low, high = range_m
        if kind == "i":
            raise MapError(
                f"{what}: {file} holds whole numbers with a sign, which are metres by themselves; leave "
                "Terrain.height_map_range_m out"
            )
        top = 1.0 if kind == "f" else float(np.iinfo(raw.dtype).max)
        return (low + (high - low) / top * values)[:, :, None]

    return read


def read_colors(file: Path, what: str) -> NDArray[Any]:
    """Colours (h, w, 3), linear 0..1, of an sRGB picture; grey becomes three equal channels."""
    raw = read_pixels(file, what)
    if raw.dtype.kind not in "u":
        raise MapError(f"{what}: {file} holds {raw.dtype} values; expected a picture (PNG or JPEG) with 8 or 16 bits")
    values = raw.astype(np.float32) / np.float32(np.iinfo(raw.dtype).max)
    if values.ndim == 2:
        values = values[:, :, None]
    values = values[:, :, :3] if values.shape[2] >= 3 else np.repeat(values[:, :, :1], 3, axis=2)
    return srgb_decode(values)


def read_shares(file: Path, what: str) -> NDArray[Any]:
    """Shares (h, w, 1) from 0 to 1: whole numbers of 0 to their largest, or fractions. Of a picture in colours the mean
    of red, green and blue."""
    raw = read_pixels(file, what)
    channels = raw.shape[2] if raw.ndim == 3 else 1
    if raw.ndim not in (2, 3) or channels not in (1, 3):
        raise MapError(
            f"{what}: {file} has {channels} channels of shape {raw.shape}; expected one, 0 clear to 1 covered (or grey "
            "as red, green and blue): leave transparency out"
        )
    if raw.dtype.kind not in "uf":
        raise MapError(f"{what}: {file} holds {raw.dtype} values; expected whole numbers without a sign, or fractions")
    top = 1.0 if raw.dtype.kind == "f" else float(np.iinfo(raw.dtype).max)
    values = raw.astype(np.float64).reshape(*raw.shape[:2], channels).mean(axis=2) / top
    for bad, found, wanted in (
        (~np.isfinite(values), "values that are no finite numbers", "a share everywhere: fill the gaps"),
        ((values < 0.0) | (values > 1.0), "values outside 0..1", "shares, 0 clear to 1 covered: divide by the largest"),
    ):
        if bad.any():
            j, i = np.argwhere(bad)[0]
            raise MapError(
                f"{what}: {file} has {int(bad.sum())} {found}, the first ({values[j, i]:g}) at column {i}, row {j}; "
                f"expected {wanted}"
            )
    return values[:, :, None]


def read_pixels(file: Path, what: str) -> NDArray[Any]:
    """The file's numbers as they are, (h, w) or (h, w, channels)."""
    if file.is_dir() or not file.is_file():
        raise MapError(f"{what}: {file} is no file")
    ending = file.suffix.lower()
    if ending in (".tif", ".tiff"):
        return _tiff(file, what)
    if ending == ".exr":
        return _exr(file, what)
    if ending == ".npy":
        return _array(file, what)
    if ending not in ENDINGS:
        raise MapError(f"{what}: {file}: unknown ending {ending!r}; expected one of {', '.join(ENDINGS)}")
    from PIL import Image

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(file) as picture:
                picture.load()
                plain = picture.mode not in ("P", "PA", "1", "CMYK", "YCbCr", "LAB", "HSV")
                array = np.asarray(picture if plain else picture.convert("L" if picture.mode == "1" else "RGB"))
    except (OSError, SyntaxError, ValueError, Image.DecompressionBombError) as error:
        raise MapError(f"{what}: {file} can't be read: {error}; is it whole, and a {ending[1:]} file?") from error
    # Pillow gives 16-bit grey as int32 in some versions.
    return array.astype(np.uint16) if array.dtype == np.int32 else array


def _array(file: Path, what: str) -> NDArray[Any]:
    try:
        array = np.load(file, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise MapError(f"{what}: {file} can't be read: {error}; is it whole, and written by numpy.save?") from error
    if not isinstance(array, np.ndarray) or array.ndim not in (2, 3) or array.size == 0:
        raise MapError(f"{what}: {file} holds an array of shape {np.shape(array)}; expected (rows, columns)")
    return array


def _tiff(file: Path, what: str) -> NDArray[Any]:
    try:
        import tifffile
    except ImportError:
        raise MapError(f"{what}: {file}: TIFF needs tifffile: pip install 'planetfall[maps]'") from None
    try:
        with tifffile.TiffFile(file) as tiff:
            page: Any = tiff.pages[0]
            array = page.asarray()
            tag, placed = page.tags.get("GDAL_NODATA"), dict(page.geotiff_tags or {})
    except Exception as error:  # tifffile raises whatever its decoders do
        raise MapError(f"{what}: {file} can't be read: {error}; is it whole, and a TIFF file?") from error
    _check_whole(file, what, placed, array.shape[1])
    if tag is not None:
        try:
            missing = float(str(tag.value).strip("\x00 "))
        except ValueError:
            return array
        if (array == missing).any():
            array = np.where(array == missing, np.nan, array.astype(np.float64))
    return array


def _check_whole(file: Path, what: str, placed: Mapping[str, Any], columns: int) -> None:
    """A file of a region would be stretched over all the planet. placed: a GeoTIFF's keys; where it counts in metres it
    doesn't say how wide the planet is."""
    scale = placed.get("ModelPixelScale")
    if scale is None or int(placed.get("GTModelTypeGeoKey", 0)) != 2:
        return
    wide_deg = float(scale[0]) * columns
    if wide_deg < 359.0:
        raise MapError(
            f"{what}: {file} is {wide_deg:.6g} degrees of longitude wide; expected 360, as a single file is a map of"
            " all the planet: for heights of a region name the folder that it lies in"
        )


def _exr(file: Path, what: str) -> NDArray[Any]:
    try:
        exr_files = import_module("OpenEXR")
    except ImportError:
        raise MapError(f"{what}: {file}: EXR needs OpenEXR: pip install 'planetfall[maps]'") from None
    try:
        with exr_files.File(str(file)) as exr:
            channels = exr.channels()
            name = next((n for n in ("Y", "R", "Z", "height", "RGB", "RGBA") if n in channels), next(iter(channels)))
            array = np.array(channels[name].pixels)
    except Exception as error:  # the library raises RuntimeError and others
        raise MapError(f"{what}: {file} can't be read: {error}; is it whole, and an EXR file?") from error
    if array.ndim == 3:
        if not (array[:, :, :1] == array[:, :, :3]).all():
            raise MapError(f"{what}: {file} has colours; expected one channel, such as Y or R")
        array = array[:, :, 0]
    return array.astype(np.float64)
