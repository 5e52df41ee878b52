"""The transfer function of sRGB displays (IEC 61966-2-1), both ways. In GLSL: common/color.glsl."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["SRGB_STEPS", "srgb_decode", "srgb_encode"]

Floats = NDArray[Any]
"""As wide as what is given: f32 stays f32."""


def srgb_encode(linear: ArrayLike) -> Floats:
    """Display values of linear light, clipped to 0..1."""
    x = np.clip(linear, 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 1e-9) ** (1.0 / 2.4) - 0.055)


def srgb_decode(encoded: ArrayLike) -> Floats:
    """Linear light of display values 0..1."""
    x = np.asarray(encoded)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


SRGB_STEPS = srgb_decode(np.arange(256) / 255.0)
"""Light (0..1) of each step of an 8-bit picture."""
