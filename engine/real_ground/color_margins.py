"""What lies beyond the pixels of a picture: colours go on and fade, so that it passes into what is below.

Over MARGIN pixels each new ring takes the mean of its neighbours within, and its weight falls from 1 to 0. All pixels
of the picture itself keep their weight. Gaps of a few pixels are closed by it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .color_level import SIDE, ColorLevel, Pixels, coded, decoded, near_blocks

__all__ = ["MARGIN", "block_with_margins", "with_margins"]

MARGIN = 32


def with_margins(level: ColorLevel) -> ColorLevel:
    """The level with what goes on beyond its pixels."""
    found = ColorLevel(level.lattice)
    for key in near_blocks(level):
        block = block_with_margins(level, key)
        if block is not None:
            found.blocks[key] = block
    return found


def block_with_margins(level: ColorLevel, key: tuple[int, int]) -> Pixels | None:
    """A block of `with_margins`, None where there is nothing."""
    core = level.block(key)
    if core is not None and core[..., 3].all():
        return core.copy()
    side, inner = SIDE + 2 * MARGIN, slice(MARGIN, MARGIN + SIDE)
    window = level.window(key[0] * SIDE - MARGIN, key[1] * SIDE - MARGIN, side, side)
    if window[inner, inner, 3].all():
        return window[inner, inner]
    if not window[..., 3].any():
        return None
    block = _grown(window)[inner, inner]
    return block if block[..., 3].any() else None


def _grown(window: Pixels) -> Pixels:
    values, known = decoded(window), window[..., 3] > 0
    weight = known.astype(np.float32)
    for ring in range(1, MARGIN + 1):
        count = _around(known.astype(np.float32))
        new = (count > 0.0) & ~known
        if not new.any():
            break
        for k in range(3):
            total = _around(values[..., k])
            values[..., k][new] = total[new] / count[new]
        left = 1.0 - (ring - 0.5) / MARGIN
        weight[new] = left * left * (3.0 - 2.0 * left)
        known |= new
    values[..., :3] *= weight[..., None]
    values[..., 3] = weight
    return coded(values)


def _around(values: NDArray[Any]) -> NDArray[Any]:
    """Sums over squares of 3 x 3; values are 0 where nothing is known."""
    wide = np.pad(values, 1)
    rows = wide[:-2] + wide[1:-1] + wide[2:]
    return rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]
