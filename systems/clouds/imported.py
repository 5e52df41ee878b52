"""Weather from a file: the cover of a map, on the octahedral square that maps of the weather have."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.map_files import FileStamp, files_stamp, load_samples, read_shares

__all__ = ["IMPORT_BORDER", "WHAT", "imported_cover", "octahedral_directions"]

WHAT = "Clouds.weather_map"
IMPORT_BORDER = 2
"""Texels around the square that repeat what lies across its edges: enough for bilinear reads."""
_LEAST, _MOST = 64, 2048
_MOST_ROWS = 2048
"""Of a file; a finer one is averaged down, cells of 10 km on Earth: the weather has none that are smaller."""


def imported_cover(path: str) -> NDArray[np.float32]:
    """(side, side) with the border, 0..1; read once as long as its files stay as they are. MapError: what is wrong."""
    return _imported(path, files_stamp(path))


def octahedral_directions(size: int, border: int) -> NDArray[np.float64]:
    """(size + 2 border, size + 2 border, 3), not of unit length: places of texels, as weather.comp has them."""
    place = (np.arange(-border, size + border) + 0.5) / size * 2.0 - 1.0
    x, y = np.meshgrid(place, place)
    # Beyond an edge: turned half round about its middle.
    out = np.abs(x) > 1.0
    x, y = np.where(out, 2.0 * np.sign(x) - x, x), np.where(out, -y, y)
    out = np.abs(y) > 1.0
    x, y = np.where(out, -x, x), np.where(out, 2.0 * np.sign(y) - y, y)
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    x, y = x - np.where(x < 0.0, -1.0, 1.0) * fold, y - np.where(y < 0.0, -1.0, 1.0) * fold
    return np.stack([x, y, z], axis=-1)


def _read(file: Path, what: str) -> NDArray[Any]:
    values = read_shares(file, what)
    while values.shape[0] > _MOST_ROWS and values.shape[0] % 2 == 0 and values.shape[1] % 2 == 0:
        values = 0.25 * (values[::2, ::2] + values[1::2, ::2] + values[::2, 1::2] + values[1::2, 1::2])
    return values


@lru_cache(maxsize=2)
def _imported(path: str, _files: tuple[FileStamp, ...]) -> NDArray[np.float32]:
    sample, quarter = load_samples(path, WHAT, _read)
    # A quarter of a great circle is half of the square's side; in its corners texels are nearly twice as far apart.
    size = int(min(max(_LEAST, 1 << int(np.ceil(np.log2(2.5 * quarter)))), _MOST))
    directions = octahedral_directions(size, IMPORT_BORDER)
    rows = [
        np.clip(sample(part.reshape(-1, 3).T)[0].reshape(part.shape[:2]), 0.0, 1.0)  # cubics overshoot at edges
        for part in np.array_split(directions, max(size // 64, 1))
    ]
    return np.concatenate(rows).astype(np.float32)
