"""Taking the sun out of a picture of the ground, by the relief that it shone on.

The topographic correction with a constant (C-correction: Teillet, Guindon and Goodenough 1982, "On the slope-aspect
correction of multispectral scanner data", Can. J. Remote Sensing 8), per channel: light that a slope throws back goes
with n.l + c, c for what the sky and the ground around add, so

    level = slope (l_z + c) / (n.l + c),      n: the ground's normal, l: to the sun, l_z: its sine above the horizon.

c is fitted: over squares of pixels, light by its mean in the square is a straight line in n.l. Where l isn't known the
line is one in the three parts of n, whose direction is l. Each fit takes the squares' means out, so that forests on
plains and rock on heights count little; what hangs on the side of a hill itself (snow, trees of its shady side) goes
out with the sun. Shadows that ground casts stay.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .color_level import SIDE, ColorLevel, coded, decoded
from .lattice import directions_at

__all__ = ["Relief", "take_out_sun"]

Floats = NDArray[np.float64]

_SQUARE = 42
"""Pixels a side of the squares whose means are taken out."""
_STEPS = (1, 2, 3, 6, 7, 14, 21)
"""Pixels from one normal to the next: parts of a square."""
_MOST_FITTED = 256
_TURNS = 6
_DARKEST, _BRIGHTEST = 0.2, 3.0
"""Of a slope's light by that of level ground."""
_RIDGE = 1e-4


@dataclass(frozen=True)
class Relief:
    """The ground of a planet. heights: metres (N,) at unit directions (3, N), NaN where none are known. sample_m: how
    far apart they are known. stamp: what tells whether any of it has changed."""

    heights: Callable[[Floats], Floats]
    sample_m: float
    radius_m: float
    stamp: object


def take_out_sun(
    level: ColorLevel, relief: Relief, sun_deg: tuple[float, float] | None, strength: float
) -> tuple[float, float] | None:
    """Divide the shading out of all pixels of full weight, to the power `strength`. sun_deg: azimuth from north to east
    and elevation; None: fitted. What it was; None where no relief is known or it explains nothing."""
    sun = None if sun_deg is None else _direction(*sun_deg)
    step = _step(level, relief)
    keys = sorted(level.blocks)
    chosen = keys[:: -(-len(keys) // _MOST_FITTED)]
    parts = [_squares(level, relief, key, step, sun) for key in chosen]
    known = [part for part in parts if part is not None]
    if not known:
        return None
    light, feature = (np.concatenate(each) for each in zip(*known, strict=True))
    flat = _features(np.array([0.0, 0.0, 1.0])[:, None], sun)[:, 0]
    slopes = _fit(light, feature, flat)
    if not slopes.any():
        return None
    for key in keys:
        shading = _shading(level, relief, key, step, sun, slopes, flat)
        if shading is None:
            continue
        values = decoded(level.blocks[key])
        values[..., :3] /= shading**strength
        level.blocks[key] = coded(values)
    if sun_deg is not None:
        return sun_deg
    east, north, up = slopes.mean(axis=0)
    return float(np.degrees(np.arctan2(east, north)) % 360.0), float(np.degrees(np.arctan2(up, np.hypot(east, north))))


def _direction(azimuth_deg: float, elevation_deg: float) -> Floats:
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    flat = np.cos(elevation)
    return np.array([flat * np.sin(azimuth), flat * np.cos(azimuth), np.sin(elevation)])


def _step(level: ColorLevel, relief: Relief) -> int:
    """Pixels from one normal to the next: half as far apart as heights are known."""
    pixel_m = level.lattice.sample_m(relief.radius_m)
    if level.lattice.mercator:
        j, i = next(iter(level.blocks))
        latitude = level.lattice.place(i * SIDE, j * SIDE)[0]
        pixel_m *= float(np.cos(np.radians(latitude)))
    return max(step for step in _STEPS if step == 1 or step * pixel_m <= 0.5 * relief.sample_m)


def _normals(level: ColorLevel, relief: Relief, key: tuple[int, int], step: int) -> Floats:
    """East, north and up (3, n, n) at squares of `step` pixels of a block and one around; NaN where unknown."""
    count = SIDE // step + 4
    middle = (np.arange(count) - 2) * step + 0.5 * (step - 1)
    rows, columns = key[0] * SIDE + middle, key[1] * SIDE + middle
    latitude, longitude = level.lattice.place(columns[None, :], rows[:, None])
    latitude, longitude = np.broadcast_arrays(latitude, longitude)
    heights = relief.heights(directions_at(latitude.ravel(), longitude.ravel())).reshape(count, count)
    up_m = np.radians(latitude) * relief.radius_m
    east_m = np.radians(longitude) * np.cos(np.radians(latitude)) * relief.radius_m
    with np.errstate(invalid="ignore", divide="ignore"):
        north = (heights[:-2, 1:-1] - heights[2:, 1:-1]) / (up_m[:-2, 1:-1] - up_m[2:, 1:-1])
        east = (heights[1:-1, 2:] - heights[1:-1, :-2]) / (east_m[1:-1, 2:] - east_m[1:-1, :-2])
    normal = np.stack([-east, -north, np.ones_like(east)])
    return normal / np.linalg.norm(normal, axis=0)


def _features(normals: Floats, sun: Floats | None) -> Floats:
    """What light is linear in: the normal (3, ...), or n.l (1, ...)."""
    return normals if sun is None else np.maximum(np.tensordot(sun, normals, axes=1), 0.0)[None]


def _squares(
    level: ColorLevel, relief: Relief, key: tuple[int, int], step: int, sun: Floats | None
) -> tuple[Floats, Floats] | None:
    """Light (squares, places, 3) and features (squares, places, k) of squares of a block that are known all over."""
    cells, across = SIDE // step, SIDE // _SQUARE
    values = decoded(level.blocks[key]).reshape(cells, step, cells, step, 4).mean(axis=(1, 3), dtype=np.float64)
    feature = np.moveaxis(_features(_normals(level, relief, key, step)[:, 1:-1, 1:-1], sun), 0, -1)

    def cut(array: Floats) -> Floats:
        each = cells // across
        parts = array.reshape(across, each, across, each, -1).transpose(0, 2, 1, 3, 4)
        return parts.reshape(across * across, each * each, -1)

    light, feature = cut(values), cut(feature)
    good = (light[..., 3] == 1.0).all(axis=1) & np.isfinite(feature).all(axis=(1, 2))
    good &= light[..., :3].mean(axis=1).min(axis=1) > 1e-4
    return (light[good][..., :3], feature[good]) if good.any() else None


def _fit(light: Floats, feature: Floats, flat: Floats) -> Floats:
    """Slopes (3, k) of light by that of level ground, per channel: light goes with 1 + slopes (feature - flat)."""
    count = feature.shape[-1]
    slopes = np.zeros((3, count))
    rest = feature - feature.mean(axis=1, keepdims=True)
    spread = np.einsum("spk,spl->kl", rest, rest)
    spread += _RIDGE * max(float(np.trace(spread)), 1e-12) * np.eye(count)
    for channel in range(3):
        for _ in range(_TURNS):
            shading = np.clip(1.0 + (feature - flat) @ slopes[channel], _DARKEST, _BRIGHTEST)
            level = light[..., channel] / shading
            level = level / level.mean(axis=1, keepdims=True) - 1.0
            slopes[channel] += np.linalg.solve(spread, np.einsum("spk,sp->k", rest, level))
    return slopes


def _shading(
    level: ColorLevel, relief: Relief, key: tuple[int, int], step: int, sun: Floats | None, slopes: Floats, flat: Floats
) -> NDArray[np.float32] | None:
    """Light (SIDE, SIDE, 3) of a block's slopes by that of level ground, 1 where no relief is known."""
    normals = _normals(level, relief, key, step)
    if not np.isfinite(normals).any():
        return None
    feature = np.moveaxis(_features(normals, sun), 0, -1)
    shading = np.clip(1.0 + (feature - flat) @ slopes.T, _DARKEST, _BRIGHTEST)
    shading = np.where(np.isfinite(shading), shading, 1.0)
    if step > 1:
        at = (np.arange(SIDE) - 0.5 * (step - 1)) / step + 1.0
        low = np.floor(at).astype(np.int64)
        f = (at - low)[:, None]
        shading = shading[low] * (1.0 - f[..., None]) + shading[low + 1] * f[..., None]
        shading = shading[:, low] * (1.0 - f) + shading[:, low + 1] * f
    else:
        shading = shading[1:-1, 1:-1]
    return shading.astype(np.float32)
