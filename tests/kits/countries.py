"""Countries made up for tests: tiles of elevation as files, of a field known in closed form."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Floats = NDArray[np.float64]


def land(latitude_deg: Floats, longitude_deg: Floats) -> Floats:
    """Metres: hills of 3 degrees and of 0.4, on a slope; the same at both sides of the date line."""
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    flat = np.cos(latitude)
    x, y, z = flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)
    return 1500.0 + 700.0 * z + 600.0 * np.sin(60.0 * x + 40.0 * z) * np.cos(50.0 * y) + 90.0 * np.sin(
        300.0 * x - 200.0 * y + 250.0 * z
    )  # fmt: skip


def hgt_name(south: int, west: int) -> str:
    return f"{'N' if south >= 0 else 'S'}{abs(south):02d}{'E' if west >= 0 else 'W'}{abs(west):03d}.hgt"


def hgt_samples(south: int, west: int, side: int) -> NDArray[np.int16]:
    """Heights (side, side) of a tile of one degree, whole metres."""
    at = np.arange(side) / (side - 1)
    longitude, latitude = np.meshgrid(west + at, south + 1.0 - at)
    return np.rint(land(latitude, longitude)).astype(np.int16)


def write_hgt(folder: Path, south: int, west: int, side: int, values: NDArray[np.int16] | None = None) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / hgt_name(south, west)
    found = hgt_samples(south, west, side) if values is None else values
    found.astype(">i2").tofile(file)
    return file


def write_country(
    folder: Path, south: int = 40, west: int = 0, rows: int = 10, columns: int = 20, side: int = 31
) -> Path:
    """A folder of rows x columns tiles of one degree."""
    for j in range(rows):
        for i in range(columns):
            write_hgt(folder, south + j, (west + i + 180) % 360 - 180, side)
    return folder


def write_png_tile(folder: Path, zoom: int, x: int, y: int, size: int = 256) -> Path:
    """A tile by zoom/x/y whose colours say the heights, in steps of 0.1 m."""
    count = size << zoom
    u = (x * size + np.arange(size) + 0.5) / count
    v = (y * size + np.arange(size) + 0.5) / count
    longitude, latitude = np.meshgrid(360.0 * u - 180.0, np.degrees(np.arctan(np.sinh(np.pi * (1.0 - 2.0 * v)))))
    steps = np.rint((land(latitude, longitude) + 10000.0) * 10.0).astype(np.uint32)
    rgb = np.stack([steps >> 16, steps >> 8 & 255, steps & 255], axis=-1).astype(np.uint8)
    file = folder / str(zoom) / str(x) / f"{y}.png"
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(rgb).save(file)
    return file


def fields(latitude_deg: Floats, longitude_deg: Floats) -> NDArray[np.uint8]:
    """Red, green and blue (..., 3) of a picture: brown and green in waves of 1 and 7 km."""
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    wide = np.sin(6000.0 * latitude) * np.sin(5000.0 * longitude)
    narrow = np.sin(43000.0 * longitude + 9000.0 * latitude)
    green = 0.5 + 0.35 * wide + 0.15 * narrow
    brown, leaf = np.array([150.0, 110.0, 70.0]), np.array([50.0, 95.0, 40.0])
    return np.rint(brown + (leaf - brown) * np.clip(green, 0.0, 1.0)[..., None]).astype(np.uint8)


def tile_places(zoom: int, x: int, y: int, size: int = 256) -> tuple[Floats, Floats]:
    """Latitudes and longitudes (size, size) of the pixels of a tile by zoom/x/y, degrees."""
    count = size << zoom
    u = (x * size + np.arange(size) + 0.5) / count
    v = (y * size + np.arange(size) + 0.5) / count
    longitude, latitude = np.meshgrid(360.0 * u - 180.0, np.degrees(np.arctan(np.sinh(np.pi * (1.0 - 2.0 * v)))))
    return latitude, longitude


def tile_at(zoom: int, latitude_deg: float, longitude_deg: float) -> tuple[int, int]:
    """x and y of the tile that a place lies in."""
    y = 0.5 - np.arcsinh(np.tan(np.radians(latitude_deg))) / (2.0 * np.pi)
    return int((longitude_deg / 360.0 + 0.5) * (1 << zoom)), int(y * (1 << zoom))


def write_picture(folder: Path, zoom: int, x: int, y: int, pixels: NDArray[np.uint8], ending: str = "png") -> Path:
    """A tile of a picture by zoom/x/y."""
    file = folder / str(zoom) / str(x) / f"{y}.{ending}"
    file.parent.mkdir(parents=True, exist_ok=True)
    Image.fromarray(pixels).save(file, **({"quality": 95} if ending == "jpg" else {}))
    return file


def write_fields(
    folder: Path, zoom: int, latitude_deg: float, longitude_deg: float, across: int = 2, ending: str = "png"
) -> Path:
    """across x across tiles of `fields` about a place."""
    x, y = tile_at(zoom, latitude_deg, longitude_deg)
    for j in range(across):
        for i in range(across):
            at = x + i - across // 2, y + j - across // 2
            write_picture(folder, zoom, *at, fields(*tile_places(zoom, *at)), ending)
    return folder


def write_color_tiff(
    file: Path, pixels: NDArray[np.uint8], west: float, north: float, step_deg: float, **words: Any
) -> Path:
    """A GeoTIFF in degrees of (rows, columns, channels). words: of tifffile.imwrite."""
    import tifffile

    tags = [
        (33550, "d", 3, (step_deg, step_deg, 0.0)),
        (33922, "d", 6, (0.0, 0.0, 0.0, west, north, 0.0)),
        (34735, "H", 16, (1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)),
    ]
    file.parent.mkdir(parents=True, exist_ok=True)
    extra = [*tags, *words.pop("tags", [])]
    tifffile.imwrite(
        file, pixels, extratags=extra, photometric="rgb" if pixels.shape[-1] >= 3 else "minisblack", **words
    )
    return file


def globe(latitude_deg: Floats, longitude_deg: Floats) -> NDArray[np.uint8]:
    """Red, green and blue (..., 3) of a picture of all the planet that knows no pole and no date line."""
    latitude, longitude = np.radians(latitude_deg), np.radians(longitude_deg)
    flat = np.cos(latitude)
    place = np.stack([flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)], axis=-1)
    return np.rint(128.0 + 100.0 * np.sin(7.0 * place)).astype(np.uint8)


def jacksboro() -> tuple[NDArray[np.int16], float, float, float] | None:
    """The fault at Jacksboro, Tennessee, which matplotlib ships, in SRTM's 3 arc seconds: heights, step, west, north,
    degrees; None without matplotlib or its sample data."""
    try:
        import matplotlib as mpl
    except ImportError:
        return None
    file = Path(mpl.__file__).parent / "mpl-data" / "sample_data" / "jacksboro_fault_dem.npz"
    if not file.exists():
        return None
    with np.load(file) as held:
        north = max(float(held["ymin"]), float(held["ymax"]))
        return held["elevation"], float(held["dx"]), float(held["xmin"]), north


def write_jacksboro(folder: Path) -> bool:
    """As a GeoTIFF; whether there is one."""
    found = jacksboro()
    if found is None:
        return False
    import tifffile

    heights, step, west, north = found
    keys = (1, 1, 0, 2, 1024, 0, 1, 2, 1025, 0, 1, 1)
    tags = [
        (33550, "d", 3, (step, step, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, west, north, 0.0), True),
        (34735, "H", len(keys), keys, True),
    ]
    folder.mkdir(parents=True, exist_ok=True)
    tifffile.imwrite(folder / "jacksboro.tif", heights, extratags=tags)
    return True
