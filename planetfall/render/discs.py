"""Where a distant planet stands in a picture: the pixels of its disc, and the camera that takes just those. float64."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..engine.space import CameraState
from ..scene.companions import Body

__all__ = ["SPOT_BELOW_PX", "Part", "disc_bounds", "hidden_by", "part_of", "spot_width_px"]

Vector = NDArray[np.float64]

SPOT_BELOW_PX = 4.0
"""Discs of a smaller diameter are drawn as spots."""
_SPOT_TEXELS = 32
_SPOT_DISC_TEXELS = 28.0
"""Of a spot's picture, whose disc keeps clear of its edge by two texels."""
_SMALLEST_PX = 0.01
"""Of a diameter: smaller planets reflect less than a ten-thousandth of what a lit pixel of theirs does."""
_FARTHEST_RADII = 100.0
"""A spot's picture is taken from here at most: single precision then still knows a texel's place, and the half of the
planet that is seen is the same within 0.6 degrees."""
_WIDEST_SPOT_PX = 0.7
_NARROWEST_SPOT_PX = 0.45
"""At SPOT_BELOW_PX, where the disc does the rest: its edge is as soft as one of a mean over pixels (sqrt(1/12) = 0.29)
and a little more."""
_DISC_TEXELS = 24.0
"""Discs of fewer pixels are drawn with 2 to 8 texels along a pixel: temporal samples alone would let them twinkle."""
_MARGIN_PX = 2
_STEP_PX = 32


@dataclass(frozen=True, eq=False)
class Part:
    """The part of a picture that shows a planet. camera: takes it, in that planet's axes. size: of what it takes, in
    texels. corner_px, texel_px, rect, spot_px: as in systems.companions.Picture. texels: to each side of a pixel, 0 for
    a spot."""

    camera: CameraState
    size: tuple[int, int]
    corner_px: tuple[float, float]
    texel_px: float
    rect: tuple[int, int, int, int]
    spot_px: float
    texels: int


def disc_bounds(camera: CameraState, centre_m: Vector, radius_m: float) -> tuple[float, float, float, float] | None:
    """(left, right, bottom, top) in tangents of the picture that a sphere is within; None where none of it is in front.

    centre_m: from the camera, in its axes (x right, y up, z forward). A side that the sphere reaches around is the
    picture's own side.
    """
    x, y, z = (float(v) for v in centre_m)
    if x * x + y * y + z * z <= radius_m * radius_m:
        return camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top
    if z <= -radius_m:
        return None
    across = _edges(x, z, radius_m, camera.tan_left, camera.tan_right)
    upright = _edges(y, z, radius_m, camera.tan_bottom, camera.tan_top)
    return None if across is None or upright is None else (*across, *upright)


def _edges(aside: float, ahead: float, radius: float, low: float, high: float) -> tuple[float, float] | None:
    """Slopes of the two planes through the eye that touch the sphere on either side, seen along the third axis."""
    distance = math.hypot(aside, ahead)
    if distance <= radius:
        return low, high
    middle, half = math.atan2(aside, ahead), math.asin(radius / distance)
    right = 0.5 * math.pi
    if middle - half >= right or middle + half <= -right:
        return None
    return (
        math.tan(middle - half) if middle - half > -right else low,
        math.tan(middle + half) if middle + half < right else high,
    )


def hidden_by(main: Body, lowest_m: float, camera_m: Vector, centre_m: Vector, reach_m: float) -> bool:
    """Whether the ground of the camera's planet hides another one. lowest_m: that ground's lowest radius. camera_m and
    centre_m: from its centre."""
    height = float(np.linalg.norm(camera_m))
    away = centre_m - camera_m
    distance = float(np.linalg.norm(away))
    if height <= lowest_m or distance <= reach_m:
        return False
    dip = math.asin(lowest_m / height)
    between = math.acos(min(max(float(away @ -camera_m) / (distance * height), -1.0), 1.0))
    return between + math.asin(reach_m / distance) < dip


def spot_width_px(diameter_px: float) -> float:
    """Standard deviation of the spot for a disc: that of stars up to 2 pixels, and narrower as the disc shows."""
    share = min(max(0.5 * diameter_px - 1.0, 0.0), 1.0)
    return _WIDEST_SPOT_PX + (_NARROWEST_SPOT_PX - _WIDEST_SPOT_PX) * share


def part_of(
    camera: CameraState, size: tuple[int, int], body: Body, before: tuple[int, int] | None = None
) -> Part | None:
    """The part of a picture that a planet is seen in; None where it is out of the picture or too small to matter.

    camera, body: in the same axes. size: of the picture, in pixels. before: the size of the last picture of this
    planet, which is kept while it fits, so that textures need not be made anew.
    """
    seen = camera.axes @ (body.centre_m - camera.position_m)
    bounds = disc_bounds(camera, seen, body.reach_m)
    if bounds is None:
        return None
    width, height = size
    per_x, per_y = width / (camera.tan_right - camera.tan_left), height / (camera.tan_top - camera.tan_bottom)
    left, right = ((t - camera.tan_left) * per_x for t in bounds[:2])
    low, high = ((t - camera.tan_bottom) * per_y for t in bounds[2:])
    if right < -_MARGIN_PX or high < -_MARGIN_PX or left > width + _MARGIN_PX or low > height + _MARGIN_PX:
        return None
    diameter = math.sqrt((right - left) * (high - low))
    if diameter < _SMALLEST_PX:
        return None
    if diameter < SPOT_BELOW_PX:
        return _spot(camera, size, body, seen, (per_x, per_y), diameter)
    texels = next(n for n in (1, 2, 4, 8) if diameter * n >= _DISC_TEXELS)
    x0, y0 = max(math.floor(left) - _MARGIN_PX, 0), max(math.floor(low) - _MARGIN_PX, 0)
    x1, y1 = min(math.ceil(right) + _MARGIN_PX, width), min(math.ceil(high) + _MARGIN_PX, height)
    if x1 <= x0 or y1 <= y0:
        return None
    taken = (
        _taken((x1 - x0) * texels, width * texels, before and before[0]),
        _taken((y1 - y0) * texels, height * texels, before and before[1]),
    )
    # The picture may be larger than the disc's part: what is beside it shows nothing.
    wide, tall = taken[0] / texels, taken[1] / texels
    edges = (
        camera.tan_left + x0 / per_x, camera.tan_left + (x0 + wide) / per_x,
        camera.tan_bottom + y0 / per_y, camera.tan_bottom + (y0 + tall) / per_y,
    )  # fmt: skip
    own = _camera(body, camera, body.inside(camera.position_m), edges)
    return Part(own, taken, (float(x0), float(y0)), 1.0 / texels, (x0, y0, x1 - x0, y1 - y0), 0.0, texels)


def _taken(wanted: int, most: int, before: int | None) -> int:
    """A side of the picture: the one before if it fits well, else the next multiple of a step that leaves some room."""
    if before is not None and wanted <= before <= min(1.6 * wanted + 2 * _STEP_PX, most):
        return before
    return min(math.ceil(1.15 * wanted / _STEP_PX) * _STEP_PX, most)


def _spot(
    camera: CameraState, size: tuple[int, int], body: Body, seen: Vector, per: tuple[float, float], diameter: float
) -> Part | None:
    if seen[2] <= 0.0:
        return None
    place = (seen[0] / seen[2] - camera.tan_left) * per[0], (seen[1] / seen[2] - camera.tan_bottom) * per[1]
    texel = diameter / _SPOT_DISC_TEXELS
    corner = place[0] - 0.5 * _SPOT_TEXELS * texel, place[1] - 0.5 * _SPOT_TEXELS * texel
    spot = spot_width_px(diameter)
    reach = 0.5 * diameter + 3.5 * spot + 0.5  # and jitter
    x0, y0 = max(math.floor(place[0] - reach), 0), max(math.floor(place[1] - reach), 0)
    x1, y1 = min(math.ceil(place[0] + reach), size[0]), min(math.ceil(place[1] + reach), size[1])
    if x1 <= x0 or y1 <= y0:
        return None
    distance = float(np.linalg.norm(seen))
    near = min(distance, _FARTHEST_RADII * body.reach_m)
    ahead = (body.centre_m - camera.position_m) / distance
    # Straight at it: beside the axis of a wide picture a sphere is drawn longer, which a few pixels don't show.
    half = math.tan(math.asin(body.reach_m / near)) * _SPOT_TEXELS / _SPOT_DISC_TEXELS
    up = camera.up - ahead * float(camera.up @ ahead)
    up = up / np.linalg.norm(up)
    turned = CameraState(camera.position_m, ahead, up, np.cross(ahead, up), -half, half, -half, half)
    own = _camera(body, turned, body.inside(body.centre_m - ahead * near), (-half, half, -half, half))
    return Part(own, (_SPOT_TEXELS, _SPOT_TEXELS), corner, texel, (x0, y0, x1 - x0, y1 - y0), spot, 0)


def _camera(body: Body, camera: CameraState, position_m: Vector, edges: tuple[float, ...]) -> CameraState:
    """A camera in the body's own axes, turned as one in the axes that the body is told in."""
    forward, up, right = (body.axes.T @ v for v in (camera.forward, camera.up, camera.right))
    return CameraState(position_m, forward, up, right, *edges, near_m=camera.near_m)
