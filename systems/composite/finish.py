"""The last steps of a picture in numpy: glare, tone map, dither. Twins of composite/glare_*.frag and tonemap.frag.

For pictures that are drawn in pieces: light glares from one piece into the next.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...components import Composite
from .tone_maps import tone_map

__all__ = ["GLARE_FALL", "GLARE_ROWS", "finished", "glare", "glare_levels", "press", "unpress"]

Floats = NDArray[Any]

GLARE_ROWS = 360.0
GLARE_FALL = 0.4
"""Energy of an octave of glare against the next finer one: the halo falls a little faster than with the cube of
the angle, as in eyes below a degree (CIE glare, Vos and van den Berg 1999). A share is that of a picture of 360
rows, whose finest octave is 5 pixels wide; in larger pictures octaves keep their angles and finer ones join in."""

# Places in texels of the source, and weights, of bilinear look-ups: as the shaders have them.
_DOWN = ((-2.736516, 0.097425), (-0.903567, 0.402575), (0.903567, 0.402575), (2.736516, 0.097425))
_TENT = ((-1.0, 0.25), (0.0, 0.5), (1.0, 0.25))
_SOFT = ((-3.11195, 0.024115), (-1.29161, 0.322385), (0.0, 0.306999), (1.29161, 0.322385), (3.11195, 0.024115))
_PLAIN = ((0.0, 1.0),)


def glare_levels(height: int) -> int:
    """Halvings below a quarter of the size until one or two rows are left: the last octave is as wide as the view."""
    return int(np.clip(np.floor(np.log2(max(height, 1) / 5.0)), 1, 10))


def press(light: Floats) -> Floats:
    """Exposed colour (..., 3) pressed into 0..1, as composite/resolved.glsl has it."""
    peak = light.max(axis=-1, keepdims=True)
    return light * (1.0 + peak**4) ** -0.25


def unpress(pressed: Floats) -> Floats:
    """The inverse of `press`."""
    peak = pressed.max(axis=-1, keepdims=True)
    return pressed * np.maximum(1.0 - peak**4, 1e-6) ** -0.25


def glare(quarter: Floats, height: int, wraps: bool = False) -> Floats:
    """All octaves of glare (h, w, 3) of exposed light at a quarter of a picture's size. height: of the picture. wraps:
    its left edge meets its right one."""
    octaves = [quarter]
    for _ in range(glare_levels(height)):
        rows, columns = octaves[-1].shape[:2]
        octaves.append(_looked_up(octaves[-1], (-(-rows // 2), -(-columns // 2)), _DOWN, wraps))
    blunter = octaves.pop()
    while len(octaves) > 1:
        finer = octaves.pop()
        blunter = finer + GLARE_FALL * _looked_up(blunter, finer.shape[:2], _TENT, wraps)
    size = quarter.shape[:2]
    return _looked_up(quarter, size, _SOFT, wraps) + GLARE_FALL * _looked_up(blunter, size, _TENT, wraps)


def finished(light: Floats, quarter: Floats | None, composite: Composite, wraps: bool = False) -> NDArray[np.uint8]:
    """The picture (H, W, 3), sRGB, of exposed light (H, W, 3). quarter: the same at a quarter of the size, for glare;
    None: without."""
    height, width = light.shape[:2]
    if quarter is not None:
        levels = glare_levels(height)
        finest = (1.0 - GLARE_FALL) * height / GLARE_ROWS
        total = finest * (1.0 - GLARE_FALL ** (levels + 1)) / (1.0 - GLARE_FALL)
        share = min(composite.bloom, 0.5 / total)
        around = _looked_up(glare(quarter, height, wraps), (height, width), _PLAIN, wraps)
        light = light * (1.0 - share * total) + around * (share * finest)
    shown = 255.0 * tone_map(composite.tone_map, light)
    if composite.dither:
        shown += _dither((height, width))
    return np.rint(np.clip(shown, 0.0, 255.0)).astype(np.uint8)


def _looked_up(image: Floats, size: tuple[int, ...], taps: Sequence[tuple[float, float]], wraps: bool) -> Floats:
    """An image (H, W, C) at another size, through bilinear look-ups about each pixel."""
    down = _weights(size[0], image.shape[0], tuple(taps), False)
    across = _weights(size[1], image.shape[1], tuple(taps), wraps)
    return np.einsum("iy,yjc->ijc", down, np.einsum("jx,yxc->yjc", across, image, optimize=True), optimize=True)


@lru_cache(maxsize=256)
def _weights(count: int, source: int, taps: tuple[tuple[float, float], ...], wraps: bool) -> Floats:
    """(count, source): what pixels along one axis weigh in each pixel of another size."""
    found = np.zeros((count, source), np.float32)
    middle = (np.arange(count) + 0.5) * (source / count) - 0.5
    for place, weight in taps:
        first = np.floor(middle + place).astype(int)
        part = middle + place - first
        for at, share in ((first, 1.0 - part), (first + 1, part)):
            texel = at % source if wraps else np.clip(at, 0, source - 1)
            np.add.at(found, (np.arange(count), texel), weight * share)
    return found


@lru_cache(maxsize=2)
def _dither(size: tuple[int, int]) -> Floats:
    """As common/dither.glsl: (H, W, 3) of triangular noise in -0.499..0.499, which neighbours share with opposite
    signs."""
    rows, columns = np.indices((size[0] + 1, size[1] + 1), np.uint32)
    x, y, z = rows * 0 + columns, rows.copy(), np.full_like(rows, 17)
    x, y, z = (v * np.uint32(1664525) + np.uint32(1013904223) for v in (x, y, z))
    for shift in (True, False):
        x += y * z
        y += z * x
        z += x * y
        if shift:
            x, y, z = (v ^ (v >> np.uint32(16)) for v in (x, y, z))
    noise = np.stack([x, y, z], axis=2).astype(np.float64) / 2.0**32
    even = ((rows + columns) % 2 == 0)[:-1, :-1, None]
    return (0.499 * (noise[:-1, :-1] - np.where(even, noise[:-1, 1:], noise[1:, :-1]))).astype(np.float32)
