"""GeoTIFFs in any coordinate system, written for tests: keys by their numbers, and fields known in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
RADIUS_M = 6.371e6
AMPLITUDE_M = 30.0


def of_code(code: int) -> dict[int, Any]:
    """Keys of a projection by its EPSG code."""
    return {1024: 1, 3072: code}


def geo_tags(
    keys: Mapping[int, Any], matrix: tuple[float, ...] | None, place: tuple[float, ...], point: bool
) -> list[tuple[Any, ...]]:
    """Tags of tifffile.imwrite. matrix: (a, b, c, d, e, f) of ModelTransformation, or place: x, y, step of the first
    pixel's corner (its middle for `point`) and of rows that go down."""
    entries, doubles, texts = [], [], ""
    if not keys:  # a file that doesn't say in which system
        x, y, step = place
        return [(33550, "d", 3, (step, step, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, x, y, 0.0), True)]
    for key, value in sorted({1025: 2 if point else 1, **keys}.items()):
        if isinstance(value, str):
            entries.append((key, 34737, len(value) + 1, len(texts)))
            texts += value + "|"
        elif isinstance(value, int):
            entries.append((key, 0, 1, value))
        else:
            values = [float(v) for v in np.ravel(value)]
            entries.append((key, 34736, len(values), len(doubles)))
            doubles += values
    directory = [1, 1, 0, len(entries), *(number for entry in entries for number in entry)]
    tags: list[tuple[Any, ...]] = [(34735, "H", len(directory), tuple(directory), True)]
    if doubles:
        tags.append((34736, "d", len(doubles), tuple(doubles), True))
    if texts:
        tags.append((34737, "s", 0, texts, True))
    if matrix is not None:
        a, b, c, d, e, f = matrix
        whole = (a, b, 0.0, c, d, e, 0.0, f, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
        tags.append((34264, "d", 16, whole, True))
    elif place:
        x, y, step = place
        tags.append((33550, "d", 3, (step, step, 0.0), True))
        tags.append((33922, "d", 6, (0.0, 0.0, 0.0, x, y, 0.0), True))
    return tags


def write_geotiff(
    file: Path, values: NDArray[Any], keys: Mapping[int, Any], place: tuple[float, ...] = (),
    matrix: tuple[float, ...] | None = None, point: bool = False, tags: tuple[Any, ...] = (), **words: Any,
) -> Path:  # fmt: skip
    """A GeoTIFF. tags: more of them; words: of tifffile.imwrite."""
    import tifffile

    file.parent.mkdir(parents=True, exist_ok=True)
    words.setdefault("photometric", "rgb" if values.ndim == 3 else "minisblack")
    tifffile.imwrite(file, values, extratags=[*geo_tags(keys, matrix, place, point), *tags], **words)
    return file


def pixel_places(code: int, x: float, y: float, step: float, rows: int, columns: int) -> tuple[Floats, Floats]:
    """Longitudes and latitudes (rows, columns), WGS84, of the middles of pixels, by pyproj alone."""
    import pyproj

    at_x, at_y = np.meshgrid(x + step * (np.arange(columns) + 0.5), y - step * (np.arange(rows) + 0.5))
    return pyproj.Transformer.from_crs(code, 4326, always_xy=True).transform(at_x, at_y)


def waves(longitude_deg: Floats, latitude_deg: Floats, wave_m: float) -> Floats:
    """Metres: three waves of AMPLITUDE_M in all, as long as wave_m or longer on the ground, that know no pole and no
    date line."""
    longitude, latitude = np.radians(longitude_deg), np.radians(latitude_deg)
    flat = np.cos(latitude)
    place = np.stack([flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)])
    ways = np.array([[0.8, 0.6, 0.0], [-0.5, 0.5, np.sqrt(0.5)], [0.1, -0.7, np.sqrt(0.5)]])
    phase = 2.0 * np.pi * RADIUS_M / wave_m * np.tensordot(ways, place, 1)
    return 500.0 + AMPLITUDE_M / 3.0 * np.sin(phase).sum(axis=0)


def most_error_m(step_m: float, wave_m: float) -> float:
    """Of a surface through samples of `waves` that leaves the range of a cell's corners hardly: h^2 / 8 of the
    curvature along rows and of that along columns."""
    return 2.0 * step_m**2 / 8.0 * AMPLITUDE_M * (2.0 * np.pi / wave_m) ** 2
