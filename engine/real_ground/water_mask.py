"""Where there is water, from tiles, for elevation that counts the sea as ground of 0 m: there ground goes below it.

A mask is a picture (color_files.py) of one channel, or the mean of three; above half is water, gaps are unknown. The
share of water within some samples of heights says how far from the shore a sample is: from half on, at the shore,
ground sinks to its whole depth where all is water. On the other side of the shore land that isn't above the sea rises
to half a metre, so that sea and ground are never at one height.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from .color_ground import ColorSet, composed
from .color_pixels import color_levels, color_plans, read_pixels
from .found import Found
from .tile_folders import TileFolder
from .tile_index import folder_sets, folder_stamp

__all__ = ["WaterMask", "water_of"]

log = logging.getLogger(__name__)

_NEAR_SEA_M, _FAR_M = 2.0, 4.0
"""Heights by the sea's level up to which ground under water sinks, and from which on none does: lakes in hills."""
_LAND_M = 0.5
_SHORE_SAMPLES = 4.0
"""Over so many samples of heights ground sinks."""
_MOST_BYTES = 128_000_000


@dataclass(frozen=True)
class WaterMask:
    """Masks, each with metres that ground sinks there."""

    masks: tuple[tuple[tuple[ColorSet, ...], float], ...]

    def lowered(self, heights_m: NDArray[np.float32], where: Found) -> NDArray[np.float32]:
        """Heights (rows, columns) of a tile, with ground below water where the masks say so."""
        with np.errstate(invalid="ignore"):
            near = np.clip((_FAR_M - np.abs(heights_m)) / (_FAR_M - _NEAR_SEA_M), 0.0, 1.0)
        at = np.flatnonzero(near.ravel() > 0.0)  # NaN is not
        if not at.size:
            return heights_m
        j, i = np.divmod(at, where.columns)
        latitude, longitude = where.lattice.place(i + where.column, j + where.row)
        flat = np.cos(np.radians(latitude)) if where.lattice.mercator else np.ones(len(at))
        footprint = _SHORE_SAMPLES * np.radians(where.lattice.step_deg) * flat
        found = heights_m.astype(np.float32, copy=True)
        values = found.ravel()
        for sets, depth_m in self.masks:
            share, known = composed(sets, latitude, longitude, footprint)
            inside = 2.0 * np.divide(share[0], known, out=np.zeros(len(at)), where=known > 0.0) - 1.0
            metres = values[at]
            sunk = metres - depth_m * np.clip(inside, 0.0, 1.0) * near.ravel()[at]
            dry = (inside < 0.0) & (known > 0.0) & (metres > -_LAND_M)
            values[at] = np.where(dry, np.maximum(metres, -_LAND_M * inside), np.where(known > 0.0, sunk, metres))
        return found


def water_of(folder: TileFolder, what: str) -> WaterMask | None:
    """The masks that belong to a folder of heights; None where there are none. TileError says what is wrong."""
    return _water(folder.water, tuple(folder_stamp(water) for water in folder.water), what) if folder.water else None


@lru_cache(maxsize=1)
def _water(folders: tuple[TileFolder, ...], _stamps: tuple[object, ...], what: str) -> WaterMask | None:
    """Kept, since each set of heights asks for it."""
    masks = []
    for water in folders:
        found: list[ColorSet] = []
        sets = sorted(folder_sets(water, what), key=lambda each: each.lattice.step_deg)
        if not sets:
            log.warning("%s: %s has no tile of water; name its folder, or remove it from the index", what, water.folder)
            continue
        for tiles, factor in color_plans(sets, _MOST_BYTES):
            levels, octaves = color_levels(read_pixels(tiles, factor, _wet, what))
            if levels:
                found.append(ColorSet(levels, octaves))
        masks.append((tuple(found), water.depth_m))
    return WaterMask(tuple(masks)) if masks else None


def _wet(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """White where there is water, black where there is land, gaps 0 all over."""
    wet = pixels[..., :3].mean(axis=-1) > 127.5
    there = pixels[..., 3] > 0
    return np.stack([*[np.where(wet & there, 255, 0)] * 3, np.where(there, 255, 0)], axis=-1).astype(np.uint8)
