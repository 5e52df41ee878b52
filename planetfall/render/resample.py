"""From the pixels of a pinhole picture to those of a lens: light filtered, geometry along each pixel's own ray."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .lens_faces import FacePixels

__all__ = ["distances", "light", "nearest"]

Floats = NDArray[Any]

_BLOCK = 16_384
"""Pixels at a time: what they need then stays in the cache."""
_SHARPEST = 0.25
"""Levels that are taken too fine: a little sharper, with no more aliasing than one sees."""
_COARSEST = 3
_BEND = 2.0
"""How many times faster than beside it the inverse depth of one surface may change from pixel to pixel."""
_FLAT = 1e-3
"""A change of depth that is no outline whatever is beside it, as a share of the depth."""


def light(image: Floats, face: FacePixels) -> Floats:
    """Light (N, C) f32 at the pixels of a lens, from the (H, W, C) of a face.

    By Catmull-Rom, held within the four nearest pixels so that nothing rings; where a pixel of the lens spans several
    of the face, from halved pictures, so that nothing is skipped.
    """
    image = np.ascontiguousarray(image, np.float32)
    result = np.zeros((face.pixels.size, image.shape[2]), np.float32)
    level = np.clip(np.log2(face.spread) - _SHARPEST, 0.0, _COARSEST)
    for k in range(_COARSEST + 1):
        share = np.clip(1.0 - np.abs(level - k), 0.0, 1.0)
        chosen = np.flatnonzero(share > 0.0)
        for block in _blocks(chosen):
            x, y = face.x[block] / 2.0**k, face.y[block] / 2.0**k
            result[block] += share[block, None] * _cubic(image, x, y)
        if k == _COARSEST or not (level > k).any():
            break
        image = _halved(image)
    return result


def nearest(image: Floats, face: FacePixels) -> Floats:
    """Values (N, ...) of the sample next to each pixel's ray, from a texture of any size of a face."""
    height, width = image.shape[:2]
    across, down = face.face.size
    x = np.clip(face.x * (width / across), 0, width - 1).astype(np.intp)
    y = np.clip(face.y * (height / down), 0, height - 1).astype(np.intp)
    return image[y, x]


def distances(distance_m: Floats, face: FacePixels) -> NDArray[np.float64]:
    """Metres (N,) along each pixel's own ray, inf where the sample next to it hit nothing.

    Inverse depth is linear over a plane in a pinhole picture: between four samples of one surface it is interpolated.
    Elsewhere, at outlines, the ray ends at the depth of the sample next to it.
    """
    height, width = distance_m.shape
    columns = (np.arange(width) + 0.5 - face.middle_px[0]) / face.focal_px[0]
    rows = (np.arange(height) + 0.5 - face.middle_px[1]) / face.focal_px[1]
    slant = np.sqrt(1.0 + columns**2 + rows[:, None] ** 2)
    inverse = slant / distance_m
    smooth = _smooth(inverse)
    x, y = face.x.astype(np.float64) - 0.5, face.y.astype(np.float64) - 0.5
    i, j = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    s, t = x - i, y - j
    top = inverse[j, i] * (1.0 - s) + inverse[j, i + 1] * s
    bottom = inverse[j + 1, i] * (1.0 - s) + inverse[j + 1, i + 1] * s
    between = top * (1.0 - t) + bottom * t
    found = np.where(smooth[j, i], between, nearest(inverse, face))
    ray_x = (x + 0.5 - face.middle_px[0]) / face.focal_px[0]
    ray_y = (y + 0.5 - face.middle_px[1]) / face.focal_px[1]
    with np.errstate(divide="ignore"):
        return np.sqrt(1.0 + ray_x**2 + ray_y**2) / found


def _smooth(inverse: Floats) -> NDArray[np.bool_]:
    """(H - 1, W - 1): whether the four samples around show one surface, by inverse depths (H, W)."""

    def along(values: Floats) -> NDArray[np.bool_]:
        step = np.abs(np.diff(values, axis=1))
        beside = np.pad(step, ((0, 0), (1, 1)), mode="edge")
        beside = np.maximum(beside[:, :-2], beside[:, 2:])
        least = np.minimum(values[:, :-1], values[:, 1:])
        return ((step <= _BEND * beside) | (step <= _FLAT * least)) & (least > 0.0)

    across, down = along(inverse), along(inverse.T).T
    return across[:-1] & across[1:] & down[:, :-1] & down[:, 1:]


def _blocks(chosen: NDArray[np.intp]) -> Iterator[NDArray[np.intp]]:
    for start in range(0, chosen.size, _BLOCK):
        yield chosen[start : start + _BLOCK]


def _halved(image: Floats) -> Floats:
    """Means of 2 x 2 pixels; the last row and column count twice where their number is odd."""
    height, width = image.shape[:2]
    image = np.pad(image, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
    return 0.25 * (image[::2, ::2] + image[1::2, ::2] + image[::2, 1::2] + image[1::2, 1::2])


def _cubic(image: Floats, x: Floats, y: Floats) -> Floats:
    """Catmull-Rom, as assets/shaders/outputs/present.frag has it."""
    height, width = image.shape[:2]
    flat = image.reshape(-1, image.shape[2])
    x, y = x - np.float32(0.5), y - np.float32(0.5)
    i, j = np.floor(x).astype(np.intp), np.floor(y).astype(np.intp)
    across, down = _weights(x - i), _weights(y - j)
    columns = [np.clip(i + n, 0, width - 1) for n in (-1, 0, 1, 2)]
    total = np.zeros((x.size, image.shape[2]), np.float32)
    least, most = np.full_like(total, np.inf), np.full_like(total, -np.inf)
    for n in range(4):
        row = np.clip(j + n - 1, 0, height - 1) * width
        line = np.zeros_like(total)
        for m in range(4):
            seen = flat.take(row + columns[m], axis=0)
            line += across[m][:, None] * seen
            if n in (1, 2) and m in (1, 2):
                np.minimum(least, seen, out=least)
                np.maximum(most, seen, out=most)
        total += down[n][:, None] * line
    return np.clip(total, least, most)


def _weights(t: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    return (
        0.5 * ((2.0 - t) * t - 1.0) * t,
        0.5 * ((3.0 * t - 5.0) * t * t + 2.0),
        0.5 * ((4.0 - 3.0 * t) * t + 1.0) * t,
        0.5 * (t - 1.0) * t * t,
    )
