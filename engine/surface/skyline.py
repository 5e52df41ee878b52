"""Whether ground around a camera that is lower than the highest ground may rise into its picture.

Heights are asked at places around the camera, nearer ones the closer together; between them the ground is as high as
its steepest slope allows. What can't be told counts as seen.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ..space import orthonormal_axes
from .field import HeightField

Floats = NDArray[np.float64]

_DRAWN_RAD = math.radians(2.0)
"""Edges of the drawn ground pass above what they connect: sides of up to 0.7 of their distance, by so much at most."""
_STEP_RAD = math.radians(2.5)
_RING, _SECTORS = 1.4, 16
_DEEPEST, _MOST = 4, 1500
"""Halvings of a part of the ground, and places at a time."""


def ground_below(field: HeightField, camera_m: Floats, radius_m: float, elevation_rad: float, moved_m: float) -> bool:
    """Whether no ground is seen at or above an elevation (positive), from wherever the camera is within `moved_m`."""
    distance = math.sqrt(float(camera_m @ camera_m))
    up = camera_m / distance
    steepest = float(getattr(field, "steepest", math.inf))
    clear_m = distance - radius_m - float(field.height(up[None])[0]) - moved_m
    nearest, top_m = clear_m / (steepest * radius_m), radius_m + field.highest_m
    lowest_m, shift = distance - moved_m, 1.01 * moved_m / distance
    if not (nearest > shift and elevation_rad > 0.0):
        return False
    if lowest_m >= top_m:
        return True
    cos, tan = math.cos(elevation_rad), math.tan(elevation_rad)
    # From here on the highest ground is below the elevation; up to `nearest` none is as high as the camera.
    farthest = 0.5 * math.pi - elevation_rad - math.asin(min(lowest_m * cos / top_m, 1.0)) + shift
    if farthest <= nearest:
        return True
    right, ahead, _ = orthonormal_axes(up, None, (0.0, 0.0, 1.0))
    rings = math.ceil(math.log(farthest / nearest) / math.log(_RING))
    edges = nearest * (farthest / nearest) ** (np.arange(rings + 1) / rings)
    inner, first = (a.ravel() for a in np.meshgrid(edges[:-1], np.arange(_SECTORS) * (2.0 * math.pi / _SECTORS)))
    outer, width = np.tile(edges[1:], _SECTORS), 2.0 * math.pi / _SECTORS
    for _ in range(_DEEPEST + 1):
        theta, azimuth = 0.5 * (inner + outer), first + 0.5 * width
        around = np.cos(azimuth)[:, None] * right + np.sin(azimuth)[:, None] * ahead
        heights = field.height(np.cos(theta)[:, None] * up + np.sin(theta)[:, None] * around)
        reach = 0.5 * (outer - inner) + 0.5 * width * outer
        bound = radius_m + np.minimum(heights + steepest * radius_m * reach, field.highest_m)
        near = inner - shift
        high = bound * np.cos(near) - lowest_m > tan * bound * np.sin(near)
        if not high.any():
            return True
        there = radius_m + heights[high]
        if (there * np.cos(theta[high]) - distance > tan * there * np.sin(theta[high])).any():
            return False
        inner, outer, first = inner[high], outer[high], first[high]
        if 4 * len(inner) > _MOST:
            return False
        middle, width = 0.5 * (inner + outer), 0.5 * width
        inner, outer = np.tile(np.concatenate([inner, middle]), 2), np.tile(np.concatenate([middle, outer]), 2)
        first = np.concatenate([first, first, first + width, first + width])
    return False


class Skyline:
    """What was found for a view: it holds until the camera has moved by a part of its distance to the ground."""

    def __init__(self) -> None:
        self._field: HeightField | None = None
        self._place = np.zeros(3)
        self._free_m = 0.0
        self._clear_rad = math.inf
        self._high_rad = -math.inf

    def below(self, field: HeightField, camera_m: Floats, radius_m: float, elevation_rad: float) -> bool:
        """Whether all ground, as it is drawn, is lower in the view than the elevation; False where that is unknown."""
        asked = _STEP_RAD * math.floor((elevation_rad - _DRAWN_RAD) / _STEP_RAD)
        steepest = float(getattr(field, "steepest", math.inf))
        if asked <= 0.0 or not math.isfinite(steepest):
            return False
        moved = camera_m - self._place
        if field is not self._field or float(moved @ moved) > self._free_m**2:
            up = camera_m / math.sqrt(float(camera_m @ camera_m))
            above_m = math.sqrt(float(camera_m @ camera_m)) - radius_m - float(field.height(up[None])[0])
            self._field, self._place = field, np.array(camera_m)
            self._free_m = max(above_m, 0.0) / (4.0 * (1.0 + steepest))
            self._clear_rad, self._high_rad = math.inf, -math.inf
        if asked >= self._clear_rad:
            return True
        if asked <= self._high_rad:
            return False
        found = ground_below(field, self._place, radius_m, asked, self._free_m)
        if found:
            self._clear_rad = asked
        else:
            self._high_rad = asked
        return found
