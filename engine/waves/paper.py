"""Spherical Gerstner waves as printed, in float64: Michelic 2018, equations 7 to 11, and Michelic et al. 2019.

d = v x ((v - o) x v), whose length is the sine of the angle from the origin; the arc l = r arccos(v.o) (2018) or
2 r arcsin(|v - o| / 2) (2019); Q alone fades near the origin and the antipode. The normal is exact for a single wave
where |d| is 1. Differences to ours: docs/ocean.md.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .set import WaveSet
from .shoaling import smoothstep

__all__ = ["Printed", "arc_2018", "arc_2019", "waves"]

Floats = NDArray[np.float64]
Arc = Callable[[Floats, Floats, float], Floats]


@dataclass(frozen=True)
class Printed:
    """position_m, normal (as printed, not of unit length), tangent, bitangent: (M, 3)."""

    position_m: Floats
    normal: Floats
    tangent: Floats
    bitangent: Floats


def arc_2018(v: Floats, origins: Floats, radius_m: float) -> Floats:
    """l = r arccos(v.o), (M, N)."""
    return radius_m * np.arccos(np.clip(v @ origins.T, -1.0, 1.0))


def arc_2019(v: Floats, origins: Floats, radius_m: float) -> Floats:
    """l = 2 r arcsin(|v - o| / 2), (M, N)."""
    chord = np.linalg.norm(v[:, None, :] - origins[None, :, :], axis=2)
    return 2.0 * radius_m * np.arcsin(np.clip(0.5 * chord, 0.0, 1.0))


def waves(found: WaveSet, v: Floats, time_s: Floats, arc: Arc = arc_2018) -> Printed:
    """Position and tangent space at unit directions (M, 3). time_s: () or (M,); its phase is reduced beforehand."""
    a, k, r = found.amplitude_m, found.wave_number_per_m, found.radius_m
    # v x ((v - o) x v) = (v - o) - v (v . (v - o)), written out.
    away = v[:, None, :] - found.origins[None, :, :]
    d = away - v[:, None, :] * np.einsum("mi,mni->mn", v, away)[:, :, None]
    theta = k * arc(v, found.origins, r) + np.fmod(found.speed_rad_s * time_s[..., None], 2.0 * np.pi)
    e0, e1 = found.fade_edges.T
    q = found.steepness * smoothstep(e0, e1, 1.0 - np.abs(v @ found.origins.T))
    sin, cos = np.sin(theta), np.cos(theta)
    position = v * r + v * (a * sin).sum(axis=1)[:, None] + np.einsum("mn,mni->mi", q * a * cos, d)
    normal = v - v * (q * a * k * sin).sum(axis=1)[:, None] - np.einsum("mn,mni->mi", a * k * cos, d)
    turned = np.cross(d, v[:, None, :])
    length = np.linalg.norm(turned, axis=2, keepdims=True)
    tangent = (turned / np.where(length > 0.0, length, 1.0)).sum(axis=1)
    return Printed(position, normal, tangent, np.cross(normal, tangent))
