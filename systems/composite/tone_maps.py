"""Tone maps: exposed linear colour (1 = saturated) to display-encoded colour. Float64 twins of common/tonemap.glsl.

Each curve but "camera" is scaled on its input so that middle grey, 0.18, comes out as middle grey: changing among them
changes contrast and colour, not the brightness of the picture. "camera" shows grey one part in twelve brighter.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.srgb import srgb_encode
from .photometry import LUMINANCE_WEIGHTS

__all__ = ["CAMERA_POINTS", "GREY_SCALES", "TONE_MAPS", "tone_map"]

Array = NDArray[np.float64]

TONE_MAPS = ("camera", "agx", "aces", "hable", "reinhard", "neutral", "linear")
"""Names in the order of TONE_MAP in common/tonemap.glsl."""

_AGX_IN = np.array(
    [
        [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
        [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
        [0.0423756549057051, 0.0784336, 0.879142973793104],
    ]
)
_AGX_POLYNOMIAL = (15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232)
_AGX_RANGE = (-12.47393, 4.026069)
_AGX_GREY = 0.46114
"""What the curve makes of 0.18, also the sRGB encoding of 0.18."""
_AGX_CONTRAST = 1.2
_AGX_SATURATION = 1.35
"""A look, between the base's (1, 1) and the "punchy" one's (1.35, 1.4)."""
_ACES_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
_ACES_OUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
_REINHARD_WHITE = 6.0
GREY_SCALES = {
    "camera": 1.0, "agx": 0.821, "aces": 1.462, "hable": 2.928, "reinhard": 1.211, "neutral": 1.222, "linear": 1.0,
}  # fmt: skip
"""Input scales that keep 0.18 at 0.18; common/tonemap.glsl has the same numbers."""


CAMERA_POINTS = {0.012: 26.0, 0.18: 122.0, 0.5: 188.0, 1.0: 242.0, 4.0: 254.0}
"""Exposed light to 8-bit sRGB: what "camera" was fitted to, within half a step. docs/exposure.md says where from."""
_CAMERA_GAIN = 1.17
_CAMERA_TOE = 0.0043
"""Exposed light at which half is left: the contrast of black in a lens whose flare a camera takes off."""
_CAMERA_ROLL_OFF = 0.267
_CAMERA_START = 0.9
"""Linear value where the shoulder begins."""


def _bleached(color: Array, pressed: Array, peak: Array) -> Array:
    """Colour (..., 3), lifted towards white by how far its brightest channel (..., 1) was pressed (Khronos PBR neutral,
    2024)."""
    bleach = 1.0 - 1.0 / (0.15 * np.maximum(peak - pressed, 0.0) + 1.0)
    return color * (1.0 - bleach) + pressed * bleach


def _camera(x: Array) -> Array:
    """White at exposed 1: the brightest channel p becomes u = 1.17 p^2 / (p + 0.0043), then v = u / (1 + 0.267 u),
    above 0.9 the rational shoulder 1 - 0.01 / (v - 0.8); the others keep their ratio to it, then highlights bleach."""
    x = np.minimum(x, 1e6)
    peak = np.clip(np.max(x, axis=-1, keepdims=True), 1e-6, 1e6)
    lifted = _CAMERA_GAIN * peak * peak / (peak + _CAMERA_TOE)
    pressed = lifted / (1.0 + _CAMERA_ROLL_OFF * lifted)
    span = 1.0 - _CAMERA_START
    shoulder = 1.0 - span * span / (np.maximum(pressed, _CAMERA_START) + span - _CAMERA_START)
    pressed = np.where(pressed > _CAMERA_START, shoulder, pressed)
    return srgb_encode(_bleached(x * (pressed / peak), pressed, peak))


def _agx(x: Array) -> Array:
    """AgX (Troy Sobotka 2022) by the polynomial fit of Benjamin Wrensch (2023), with more contrast about middle grey,
    black and white where they were, and more saturation. The curve gives display values itself: no sRGB encoding."""
    low, high = _AGX_RANGE
    v = np.log2(np.maximum(x @ _AGX_IN.T, 1e-10))
    v = np.clip(np.polyval(_AGX_POLYNOMIAL, (np.clip(v, low, high) - low) / (high - low)), 0.0, 1.0)
    darker = _AGX_GREY * (v / _AGX_GREY) ** _AGX_CONTRAST
    brighter = 1.0 - (1.0 - _AGX_GREY) * ((1.0 - v) / (1.0 - _AGX_GREY)) ** _AGX_CONTRAST
    v = np.where(v > _AGX_GREY, brighter, darker)
    grey = (v @ LUMINANCE_WEIGHTS)[..., None]
    v = grey + (v - grey) * _AGX_SATURATION
    return np.clip(v @ np.linalg.inv(_AGX_IN).T, 0.0, 1.0)


def _aces(x: Array) -> Array:
    """ACES reference and output transforms for sRGB, fit by Stephen Hill (in Pettineo and Neubelt's BakingLab)."""
    v = x @ _ACES_IN.T
    v = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081)
    return srgb_encode(v @ _ACES_OUT.T)


def _hable(x: Array) -> Array:
    """The film curve of Uncharted 2 (Hable 2010), white at 11.2."""

    def curve(v: Array) -> Array:
        return (v * (0.15 * v + 0.05) + 0.004) / (v * (0.15 * v + 0.5) + 0.06) - 0.02 / 0.3

    return srgb_encode(curve(x) / curve(np.array(11.2)))


def _reinhard(x: Array) -> Array:
    """Reinhard et al. 2002, eq. 4, on luminance, white at 6."""
    grey = (x @ LUMINANCE_WEIGHTS)[..., None]
    return srgb_encode(x * (1.0 + grey / _REINHARD_WHITE**2) / (1.0 + grey))


def _neutral(x: Array) -> Array:
    """Khronos PBR neutral (2024): hues of lit colours as they are, highlights compressed and bleached."""
    least = np.min(x, axis=-1, keepdims=True)
    v = x - np.where(least < 0.08, least - 6.25 * least * least, 0.04)
    peak = np.max(v, axis=-1, keepdims=True)
    start, span = 0.76, 0.24
    pressed = 1.0 - span * span / (np.maximum(peak, start) + span - start)
    high = _bleached(v * pressed / np.maximum(peak, start), pressed, peak)
    return srgb_encode(np.where(peak < start, v, high))


_CURVES: dict[str, Callable[[Array], Array]] = {
    "camera": _camera,
    "agx": _agx,
    "aces": _aces,
    "hable": _hable,
    "reinhard": _reinhard,
    "neutral": _neutral,
    "linear": srgb_encode,
}


def tone_map(name: str, exposed: ArrayLike) -> Array:
    """Display colour (..., 3) in 0..1, sRGB-encoded, of exposed linear colour (..., 3). KeyError names the choices."""
    if name not in _CURVES:
        raise KeyError(f"unknown tone map {name!r}: expected one of {', '.join(TONE_MAPS)}")
    x = np.maximum(np.asarray(exposed, dtype=np.float64), 0.0) * GREY_SCALES[name]
    return _CURVES[name](x)
