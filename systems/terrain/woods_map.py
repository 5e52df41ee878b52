"""Forests of a vector map as a picture of shares, for the ground beyond single trees: how much of it may have some.

Rows and columns are even steps of latitude and longitude over the bounds of all forests, at most MOST_SIDE a side; the
picture has coarser levels, so that distant pixels see means. Single trees ask the polygons themselves.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import IVec2, Vec2
from ...engine.real_ground.lattice import sphere_place
from ...engine.real_ground.polygons import Polygons

__all__ = ["TerrainWoods", "WoodsMap", "woods_map", "write_woods"]

Floats = NDArray[np.float64]

MOST_SIDE = 2048
LEAST_TEXEL_M = 2.0
"""Finer than that no crown is."""
_LEAST_DEG = 1e-9
"""Width and height of a picture, where all forests lie in one line or point."""
_BAND = 128
"""Rows of texels made at once."""


@dataclass
class TerrainWoods:
    """Where the picture of forests lies about the anchor; written with the table."""

    size: Annotated[IVec2, "columns and rows; 0: no map has forests"]
    texel_rad: Annotated[Vec2, "of longitude and latitude"]
    place: Annotated[Vec2, "of the anchor, in texels from the north-west corner"]


@dataclass(frozen=True, eq=False)
class WoodsMap:
    """share (rows, columns): 0..255, from north to south."""

    share: NDArray[np.uint8]
    west_deg: float
    north_deg: float
    texel_deg: tuple[float, float]
    """of longitude and latitude"""

    def place(self, longitude_deg: float, latitude_deg: float) -> tuple[float, float]:
        """Column and row in texels, of the turn that is nearest to the picture's middle."""
        across, up = self.texel_deg
        middle = self.west_deg + 0.5 * self.share.shape[1] * across
        longitude_deg -= 360.0 * round((longitude_deg - middle) / 360.0)
        return (longitude_deg - self.west_deg) / across, (self.north_deg - latitude_deg) / up


@lru_cache(maxsize=4)
def woods_map(woods: Polygons, radius_m: float) -> WoodsMap:
    """The picture of these forests on a planet of that radius."""
    west, south, east, north = woods.bounds
    turns = [0.0]
    if east - west > 360.0:  # some go on beyond the date line, all around the world
        west, east, turns = -180.0, 180.0, [-360.0, 0.0, 360.0]
    east, north = max(east, west + _LEAST_DEG), max(north, south + _LEAST_DEG)
    per_deg = np.radians(1.0) * radius_m
    flat = np.cos(np.radians(np.clip(0.0, south, north)))
    sides_m = (east - west) * per_deg * flat, (north - south) * per_deg
    # Texels are hardly twice as long as wide: a pixel is.
    least_m = max(LEAST_TEXEL_M, 0.5 * max(sides_m) / MOST_SIDE)
    columns, rows = (int(np.clip(np.ceil(side / least_m), 1, MOST_SIDE)) for side in sides_m)
    across, up = (east - west) / columns, (north - south) / rows
    # In samples from the first one's middle.
    column, row = (woods.edges[:, 0::2] - west) / across - 0.5, (north - woods.edges[:, 1::2]) / up - 0.5
    share = np.empty((rows, columns), np.uint8)
    for first in range(0, rows, _BAND):
        count = min(_BAND, rows - first)
        parts = (woods.shares(column + turn / across, row - first, count, columns) for turn in turns)
        share[first : first + count] = np.rint(255.0 * np.minimum(sum(parts), 1.0))
    return WoodsMap(share, west, north, (across, up))


def write_woods(table: NDArray[Any], woods: Polygons, point: Floats, radius_m: float) -> None:
    """The table's part, for an anchor at `point` (3,); nothing around the planet's centre, where nothing is drawn.
    radius_m: of the planet, as `woods_map` is asked elsewhere: the length of `point` is off by rounding."""
    if not point.any():
        return
    found = woods_map(woods, radius_m)
    latitude_deg, longitude_deg = (float(a[0]) for a in sphere_place(point[:, None]))
    part = table["woods"]
    part["size"] = found.share.shape[::-1]
    part["texel_rad"] = np.radians(found.texel_deg)
    part["place"] = found.place(longitude_deg, latitude_deg)
