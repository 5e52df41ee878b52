"""How filaments lie in a picture, by the structure tensor of its brightness (Jaehne 2005, 13.3), and their width."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

__all__ = ["Filaments", "fan_share", "filaments", "width_px"]

Floats = NDArray[np.float64]


def _smooth(picture: Floats, sigma: float) -> Floats:
    """Gaussian blur of a picture whose edge pixels go on beyond it."""
    reach = int(np.ceil(3.0 * sigma))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / sigma) ** 2)
    kernel /= kernel.sum()
    for axis in (0, 1):
        padded = np.pad(picture, [(reach, reach) if axis == a else (0, 0) for a in (0, 1)], "edge")
        picture = np.apply_along_axis(np.convolve, axis, padded, kernel, "valid")
    return picture


class Filaments:
    """(rows, columns) each: angle_rad along the filament, 0 along a row, modulo pi; coherence 0..1; weight: coherence
    where there is any structure."""

    def __init__(self, angle_rad: Floats, coherence: Floats, weight: Floats) -> None:
        self.angle_rad, self.coherence, self.weight = angle_rad, coherence, weight

    @property
    def spread_deg(self) -> float:
        """Angular standard deviation of directions modulo 180 degrees, weighted (Mardia and Jupp 2000, 2.3.3): 0 for
        parallel lines; all directions alike have no bound."""
        mean = abs((self.weight * np.exp(2j * self.angle_rad)).sum()) / self.weight.sum()
        return float(np.degrees(0.5 * np.sqrt(-2.0 * np.log(max(mean, 1e-9)))))


def filaments(picture: Floats, sigma_px: float = 3.0, mask: NDArray[np.bool_] | None = None) -> Filaments:
    """Of a picture (rows, columns). Weights are coherence times the gradient's root mean square, as far as that counts:
    the strongest tenth counts alike. mask: pixels that count."""
    smooth = _smooth(picture, 1.0)
    down, across = np.gradient(smooth, axis=0), np.gradient(smooth, axis=1)
    xx, yy, xy = _smooth(across * across, sigma_px), _smooth(down * down, sigma_px), _smooth(across * down, sigma_px)
    difference, twice = xx - yy, 2.0 * xy
    energy = xx + yy
    coherence = np.hypot(difference, twice) / np.maximum(energy, 1e-30)
    counted = np.ones(picture.shape, bool) if mask is None else mask
    strength = np.minimum(np.sqrt(energy / max(float(np.quantile(energy[counted], 0.9)), 1e-30)), 1.0)
    # Gradients point across: filaments lie at right angles to them.
    angle = 0.5 * np.arctan2(twice, difference) + 0.5 * np.pi
    return Filaments(angle, coherence, coherence * strength * counted)


def fan_share(found: Filaments) -> float:
    """How far all filaments run towards one point, as in a zoom blur: the largest weighted mean over candidate points,
    in and around the picture, of the cosine of twice the angle to the way there. 1: a perfect fan (or parallel lines,
    towards a point far away)."""
    rows, columns = found.angle_rad.shape
    y, x = np.mgrid[:rows, :columns]
    best = -1.0
    for cy in np.linspace(-1.0, 2.0, 19) * rows:
        for cx in np.linspace(-1.0, 2.0, 25) * columns:
            to = np.arctan2(y - cy, x - cx)
            share = (found.weight * np.cos(2.0 * (found.angle_rad - to))).sum() / found.weight.sum()
            best = max(best, float(share))
    return best


def width_px(picture: Floats, reach_px: int = 16, least: float = 0.05) -> float:
    """Full width across filaments at half of their height, in pixels: the median over ridges, each place that is
    brightest across. The height is that above the brighter of the lowest places on either side within reach_px, and at
    least a share `least` of the picture's range (5 to 95 %)."""
    found = filaments(picture, 2.0)
    rows, columns = picture.shape
    inside = np.zeros(picture.shape, bool)
    inside[reach_px + 2 : rows - reach_px - 2, reach_px + 2 : columns - reach_px - 2] = True
    chosen = np.argwhere(inside & (found.coherence > 0.5))
    angle = found.angle_rad[chosen[:, 0], chosen[:, 1]] + 0.5 * np.pi
    lags = np.arange(0.0, reach_px + 0.1, 0.25)

    def profile(sign: float) -> Floats:
        """(lags, places)."""
        away = sign * lags[:, None]
        return _sampled(picture, chosen[:, 0] + away * np.sin(angle), chosen[:, 1] + away * np.cos(angle))

    sides = profile(1.0), profile(-1.0)
    peak = sides[0][0]
    base = np.maximum(sides[0].min(axis=0), sides[1].min(axis=0))
    spread = float(np.quantile(picture, 0.95) - np.quantile(picture, 0.05))
    ridge = (peak - base > least * spread) & np.all([side[:5].max(axis=0) <= peak for side in sides], axis=0)
    half = 0.5 * (peak + base)
    widths = lags[np.argmax(sides[0] < half, axis=0)] + lags[np.argmax(sides[1] < half, axis=0)]
    return float(np.median(widths[ridge])) if ridge.any() else float("inf")


def _sampled(picture: Floats, y: Floats, x: Floats) -> Floats:
    """Bilinear."""
    j, i = np.floor(y).astype(int), np.floor(x).astype(int)
    v, u = y - j, x - i
    return (
        (1 - v) * ((1 - u) * picture[j, i] + u * picture[j, i + 1])
        + v * ((1 - u) * picture[j + 1, i] + u * picture[j + 1, i + 1])
    )  # fmt: skip
