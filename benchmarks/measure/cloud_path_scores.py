"""How far drawn clouds are from paths of light through them: ratios, by place, and local contrast."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .cloud_paths import Truth

__all__ = ["PLACES", "Score", "contrast", "score_of", "sheet"]

Floats = NDArray[np.float64]
BAND_PX = 1.2, 8.0
"""Standard deviations of the two Gaussians whose difference is the band of local contrast."""
SOLID = 0.8
"""Opacity of what is not a rim."""
PLACES = ("rims", "sunlit", "between", "shade")
"""Rims hide less than SOLID of what is behind; of the rest each is a third: brightest, between, darkest traced."""
OPACITIES = (0.05, 0.3, 0.6, 0.9, 1.01)
_LEAST = 1e-3
"""Of the median light: what is drawn darker counts as that dark."""


@dataclass(frozen=True)
class Score:
    """median, p95: of |log2(drawn / traced)| over pixels with cloud; places: signed medians and shares of the pixels by
    place; contrast: of the drawn window over that of the traced one; noise: median standard error of log2 in the
    truth; light: of all these pixels, drawn over traced; opacity: of the window, drawn less traced; by_opacity: light
    for each unit of opacity, drawn over traced, of pixels in each of OPACITIES."""

    median: float
    p95: float
    places: dict[str, float]
    shares: dict[str, float]
    contrast: float
    noise: float
    light: float
    opacity: float
    by_opacity: dict[str, float]


def score_of(truth: Truth, drawn: Floats) -> Score:
    """drawn: (rows, columns, 2) of cloud_paths.drawn."""
    judged = truth.judged
    floor = _LEAST * float(np.median(truth.radiance[judged]))
    log2 = np.log2(np.maximum(drawn[..., 0], floor) / np.maximum(truth.radiance, floor))
    apart, places = np.abs(log2[judged]), _places(truth)
    return Score(
        float(np.median(apart)),
        float(np.percentile(apart, 95)),
        {name: float(np.median(log2[at])) if at.any() else float("nan") for name, at in places.items()},
        {name: float(at.sum() / judged.sum()) for name, at in places.items()},
        contrast(drawn[..., 0], judged) / contrast(truth.radiance, judged, truth.error),
        float(np.median((truth.error / np.maximum(truth.radiance, floor))[judged])) / np.log(2.0),
        float(drawn[..., 0][judged].sum() / truth.radiance[judged].sum()),
        float(drawn[..., 1].mean() - truth.opacity.mean()),
        {f"opacity_{low:g}": _per_opacity(truth, drawn, low, high) for low, high in pairwise(OPACITIES)},
    )


def _per_opacity(truth: Truth, drawn: Floats, low: float, high: float) -> float:
    at = truth.judged & (truth.opacity >= low) & (truth.opacity < high)
    if at.mean() < 0.01:
        return float("nan")
    shown = drawn[at].sum(axis=0)
    return float(shown[0] / max(shown[1], 1e-9) / (truth.radiance[at].sum() / truth.opacity[at].sum()))


def _places(truth: Truth) -> dict[str, NDArray[np.bool_]]:
    judged, solid = truth.judged, truth.opacity >= SOLID
    low, high = np.quantile(truth.radiance[solid], (1 / 3, 2 / 3)) if solid.any() else (0.0, 0.0)
    bright, dark = solid & (truth.radiance >= high), solid & (truth.radiance < low)
    return {"rims": judged & ~solid, "sunlit": bright, "between": solid & ~bright & ~dark, "shade": dark}


def contrast(light: Floats, judged: NDArray[np.bool_], error: Floats | None = None) -> float:
    """Deviation of the light in the band over its mean, over the judged pixels. error: standard errors, whose share of
    the variance is taken off."""
    band = _blurred(light, BAND_PX[0]) - _blurred(light, BAND_PX[1])
    variance = float((band[judged] ** 2).mean())
    if error is not None:
        spot = np.zeros((65, 65))
        spot[32, 32] = 1.0
        kept = float(((_blurred(spot, BAND_PX[0]) - _blurred(spot, BAND_PX[1])) ** 2).sum())
        variance -= kept * float((error[judged] ** 2).mean())
    return float(np.sqrt(max(variance, 1e-12)) / light[judged].mean())


def _blurred(picture: Floats, deviation_px: float) -> Floats:
    reach = int(np.ceil(3.0 * deviation_px))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation_px) ** 2)
    weights /= weights.sum()
    for axis in (0, 1):
        width = [(reach, reach) if a == axis else (0, 0) for a in (0, 1)]
        padded = np.pad(picture, width, mode="symmetric")
        picture = np.apply_along_axis(lambda row: np.convolve(row, weights, "valid"), axis, padded)
    return picture


def sheet(truth: Truth, drawn: dict[str, Floats], larger: int = 4) -> NDArray[np.uint8]:
    """(rows, columns, 3) u8: the traced window, then the drawn ones beside it, pixels as squares of so many."""
    white = float(np.percentile(truth.radiance[truth.judged], 99.0)) if truth.judged.any() else 1.0
    windows = [truth.radiance, *(window[..., 0] for window in drawn.values())]
    gap = np.ones((len(truth.radiance), 1))
    parts = [part for window in windows for part in (np.clip(window / (1.1 * white), 0.0, 1.0) ** (1.0 / 2.2), gap)]
    picture = np.round(255.0 * np.concatenate(parts[:-1], axis=1)).astype(np.uint8)
    return picture.repeat(larger, 0).repeat(larger, 1)[..., None].repeat(3, 2)
