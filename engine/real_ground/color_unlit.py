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

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .color_level import SIDE, ColorLevel, Pixels, coded, decoded
from .lattice import Lattice, directions_at

__all__ = ["Relief", "SunFit", "fit_sun", "take_out_sun"]

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
    far apart they are known. stamp: what tells whether any of it has changed; files: the same for other processes,
    None where nothing does."""

    heights: Callable[[Floats], Floats]
    sample_m: float
    radius_m: float
    stamp: object
    files: object = None


@dataclass(frozen=True, eq=False)
class SunFit:
    """How light goes with the relief's normals on one level. step: pixels from one normal to the next; sun: the
    direction to it, None: fitted with the rest; slopes (3, k) and flat (k,) of _fit; sun_deg: azimuth from north to
    east, and elevation."""

    lattice: Lattice
    step: int
    sun: Floats | None
    slopes: Floats
    flat: Floats
    sun_deg: tuple[float, float]

    def unlit(self, pixels: Pixels, key: tuple[int, int], relief: Relief, strength: float) -> Pixels:
        """Pixels of a block with the shading divided out, to the power `strength`."""
        shading = _shading(self, relief, key)
        if shading is None:
            return pixels
        values = decoded(pixels)
        values[..., :3] /= shading**strength
        return coded(values)


def take_out_sun(
    level: ColorLevel, relief: Relief, sun_deg: tuple[float, float] | None, strength: float
) -> tuple[float, float] | None:
    """Divide the shading out of all pixels of full weight, to the power `strength`. sun_deg: azimuth from north to east
    and elevation; None: fitted. What it was; None where no relief is known or it explains nothing."""
    keys = sorted(level.blocks)
    fit = fit_sun(level, keys, relief, sun_deg)
    if fit is None:
        return None
    for key in keys:
        level.blocks[key] = fit.unlit(level.blocks[key], key, relief, strength)
    return fit.sun_deg


def fit_sun(
    level: ColorLevel, keys: Sequence[tuple[int, int]], relief: Relief, sun_deg: tuple[float, float] | None
) -> SunFit | None:
    """How light goes with normals on blocks `keys` of a level; None where no relief is known or it explains nothing."""
    sun = None if sun_deg is None else _direction(*sun_deg)
    step = _step(level.lattice, relief, keys[0])
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
    if sun_deg is None:
        east, north, up = slopes.mean(axis=0)
        high = float(np.degrees(np.arctan2(up, np.hypot(east, north))))
        sun_deg = float(np.degrees(np.arctan2(east, north)) % 360.0), high
    return SunFit(level.lattice, step, sun, slopes, flat, sun_deg)


def _direction(azimuth_deg: float, elevation_deg: float) -> Floats:
    azimuth, elevation = np.radians(azimuth_deg), np.radians(elevation_deg)
    flat = np.cos(elevation)
    return np.array([flat * np.sin(azimuth), flat * np.cos(azimuth), np.sin(elevation)])


def _step(lattice: Lattice, relief: Relief, key: tuple[int, int]) -> int:
    """Pixels from one normal to the next: half as far apart as heights are known. key: of a block."""
    pixel_m = lattice.sample_m(relief.radius_m)
    if lattice.mercator:
        latitude = lattice.place(key[1] * SIDE, key[0] * SIDE)[0]
        pixel_m *= float(np.cos(np.radians(latitude)))
    return max(step for step in _STEPS if step == 1 or step * pixel_m <= 0.5 * relief.sample_m)


def _normals(lattice: Lattice, relief: Relief, key: tuple[int, int], step: int) -> Floats:
    """East, north and up (3, n, n) at squares of `step` pixels of a block and one around; NaN where unknown."""
    count = SIDE // step + 4
    middle = (np.arange(count) - 2) * step + 0.5 * (step - 1)
    rows, columns = key[0] * SIDE + middle, key[1] * SIDE + middle
    latitude, longitude = lattice.place(columns[None, :], rows[:, None])
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
    cells, across, pixels = SIDE // step, SIDE // _SQUARE, level.block(key)
    if pixels is None:
        return None
    values = decoded(pixels).reshape(cells, step, cells, step, 4).mean(axis=(1, 3), dtype=np.float64)
    feature = np.moveaxis(_features(_normals(level.lattice, relief, key, step)[:, 1:-1, 1:-1], sun), 0, -1)

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


def _shading(fit: SunFit, relief: Relief, key: tuple[int, int]) -> NDArray[np.float32] | None:
    """Light (SIDE, SIDE, 3) of a block's slopes by that of level ground, 1 where no relief is known."""
    step = fit.step
    normals = _normals(fit.lattice, relief, key, step)
    if not np.isfinite(normals).any():
        return None
    feature = np.moveaxis(_features(normals, fit.sun), 0, -1)
    shading = np.clip(1.0 + (feature - fit.flat) @ fit.slopes.T, _DARKEST, _BRIGHTEST)
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
