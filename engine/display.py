"""What a display shows of light at three wavelengths, and which reflectance shows a wanted colour.

Light is (..., 3) at 680, 550 and 440 nm in units of sunlight, colours are linear sRGB for an eye to which sunlight is
white. In GLSL: common/color.glsl. docs/exposure.md says where the numbers come from.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["DISPLAY", "DISPLAY_BETWEEN", "display_color", "light_of_color", "reflectance"]

Floats = NDArray[np.float64]

DISPLAY: Floats = np.array([[0.0, 0.144, -0.552], [-0.027, 0.77, -0.011], [-0.006, 0.048, 1.077]])
"""Rows: red, green and blue of what there is at 680, 550 and 440 nm."""
DISPLAY_BETWEEN: Floats = np.array([[1.1, 0.775, -0.467], [0.109, 0.01, 0.149], [-0.077, -0.298, 0.256]])
"""The same of what lies between two wavelengths: geometric means of 680 and 550, 550 and 440, 440 and 680 nm. Together
with DISPLAY rows add up to 1, so that sunlight comes out white."""

_NEXT = (1, 2, 0)


def display_color(light: ArrayLike) -> Floats:
    """Linear sRGB (..., 3) of light; below 0 where a display cannot show it.

    Root-polynomial colour correction (Finlayson, Mackiewicz and Hurlbert 2015): scaled light comes out scaled, which no
    other polynomial of the second degree does.
    """
    known = np.maximum(np.asarray(light, dtype=np.float64), 0.0)
    return known @ DISPLAY.T + np.sqrt(known * known[..., _NEXT]) @ DISPLAY_BETWEEN.T


def reflectance(color: ArrayLike) -> Floats:
    """Shares 0..1 of light (..., 3) that ground of a colour (..., 3), linear sRGB, throws back: in sunlight outside the
    air the colour is what shows."""
    return np.minimum(light_of_color(color), 1.0)


def light_of_color(color: ArrayLike) -> Floats:
    """The inverse of `display_color`. Colours that no light of three wavelengths shows come out as near as a few steps
    of Newton's method get."""
    wanted = np.clip(np.asarray(color, dtype=np.float64), 0.0, None)
    # In square roots of light, colours are quadratic forms, without the infinite slopes of roots at 0.
    root = np.sqrt(np.maximum(wanted, 1e-6))
    for _ in range(20):
        slope = 2.0 * DISPLAY * root[..., None, :]
        slope = slope + DISPLAY_BETWEEN * root[..., None, _NEXT]
        slope = slope + (DISPLAY_BETWEEN * root[..., None, :])[..., (2, 0, 1)]
        off = wanted - display_color(root * root)
        if np.abs(off).max(initial=0.0) < 1e-7:
            break
        step = np.asarray(np.linalg.solve(slope, off[..., None]), dtype=np.float64)[..., 0]
        root = np.clip(root + step, 0.5 * root, 2.0 * root + 1e-3)
    return root * root
