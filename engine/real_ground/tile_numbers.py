"""Heights from the numbers that files hold."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .geo_system import height_unit_m
from .geo_tags import GeoHeader

__all__ = ["believed", "plain_heights"]

_LOWEST_M, _HIGHEST_M = -1.2e4, 1e5
"""Heights beyond are voids that a file forgot to name: no trench is deeper, and no mountain known is higher."""


def believed(values: NDArray[Any]) -> NDArray[Any]:
    """Heights with NaN in place of those that can't be."""
    with np.errstate(invalid="ignore"):
        bad = ~((values >= _LOWEST_M) & (values <= _HIGHEST_M))
    return np.where(bad, np.nan, values) if bad.any() else values


def plain_heights(file: Path, header: GeoHeader, values: NDArray[Any]) -> NDArray[np.float64]:
    """Metres of a GeoTIFF's numbers, NaN where they stand for none."""
    heights = values.astype(np.float64)
    if header.nodata is not None:
        heights[values == header.nodata] = np.nan
    unit_m = height_unit_m(file, header)
    if (header.scale, header.offset, unit_m) != (1.0, 0.0, 1.0):
        heights = (heights * header.scale + header.offset) * unit_m
    return heights
