"""Waves as seen from an anchor: what a shader needs to draw them near it in single precision.

Everything large (a wave's way from its origin, its phase after years) is reduced here in float64 to cycles between 0
and 1; what is left for the shader are offsets from the anchor, and every term of them is in proportion to the offset.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .set import WaveSet

__all__ = ["AnchoredWaves", "anchor_axes", "at_anchor", "local_wave", "phases"]

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]


@dataclass(frozen=True)
class AnchoredWaves:
    """Arrays (N,) float32 of the waves of a set at an anchor, longest first.

    east, north: (3,) float64, the tangent axes at the anchor in which `heading` is counted. heading: (N, 2), the unit
    direction away from each origin. cos0, sin0: of the angle from the origin to the anchor. angle: that angle, or the
    one to the antipode if it is smaller, rad (what the fade goes by). phase: at the anchor, in cycles, 0 to 1.
    way: (N,) float64, from the origin to the anchor in cycles, 0 to 1: what `phases` adds time to.
    """

    east: Floats
    north: Floats
    heading: Singles
    cos0: Singles
    sin0: Singles
    angle: Singles
    phase: Singles
    way: Floats


def anchor_axes(anchor: ArrayLike) -> tuple[Floats, Floats]:
    """Two unit tangents (east-like, north-like) at a direction (..., 3): right-handed with it, defined everywhere.

    Duff et al. 2017, "Building an Orthonormal Basis, Revisited": continuous but for the plane z = 0.
    """
    v = np.asarray(anchor, dtype=np.float64)
    x, y, z = v[..., 0], v[..., 1], v[..., 2]
    sign = np.where(z < 0.0, -1.0, 1.0)
    a = -1.0 / (sign + z)
    b = x * y * a
    east = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x], axis=-1)
    north = np.stack([b, sign + y * y * a, -y], axis=-1)
    return east, north


def at_anchor(waves: WaveSet, anchor: ArrayLike, time_s: float) -> AnchoredWaves:
    """The set reduced to an anchor, a unit direction (3,), at a time."""
    v = np.asarray(anchor, dtype=np.float64)
    east, north = anchor_axes(v)
    cos0 = waves.origins @ v
    # Minus the origin's tangential part: away from the origin, as long as the sine of the angle.
    along = -np.stack([waves.origins @ east, waves.origins @ north], axis=1)
    sin0 = np.hypot(along[:, 0], along[:, 1])
    there = sin0 > 1e-15  # at an origin, where the wave has faded, any direction does
    heading = np.where(there[:, None], along / np.where(there, sin0, 1.0)[:, None], np.array([1.0, 0.0]))
    away = np.arctan2(sin0, cos0)
    # fmod is exact: no digits are lost however many wavelengths the way is long.
    way = np.fmod(waves.radius_m * away, waves.wavelength_m) / waves.wavelength_m
    return AnchoredWaves(
        east,
        north,
        heading.astype(np.float32),
        cos0.astype(np.float32),
        sin0.astype(np.float32),
        np.minimum(away, np.pi - away).astype(np.float32),
        phases(waves, way, time_s),
        way,
    )


def phases(waves: WaveSet, way: Floats, time_s: float) -> Singles:
    """`AnchoredWaves.phase` at another time: all that changes with it."""
    cycles = way + np.fmod(waves.speed_rad_s * time_s / (2.0 * np.pi), 1.0)
    phase = (cycles - np.floor(cycles)).astype(np.float32)
    return np.where(phase >= 1.0, np.float32(0.0), phase)


def local_wave(
    east_m: NDArray, north_m: NDArray, down_m: NDArray, anchored: AnchoredWaves, radius_m: float
) -> tuple[NDArray, NDArray, NDArray]:
    """The shader's formula, in the type of its arguments: offsets (M,) from the anchor along its axes, on the sphere.

    Returns (M, N): x, how far each wave has travelled from the anchor, rad; sin and cos of the angle from its origin.
    down_m: below the anchor's tangent plane, q^2 / (r (1 + sqrt(1 - q^2 / r^2))), q the distance in the plane.
    With q1 along the wave and q2 across (both / r), w = sin0 (1 - down) + cos0 q1:
        sin(angle) = hypot(w, q2), cos(angle) = cos0 (1 - down) - sin0 q1,
        sin(x) = q1 + cos0 (sin(angle) - w), sin(angle) - w = q2^2 / (sin(angle) + w).
    """
    kind = east_m.dtype
    one = kind.type(1.0)
    r = kind.type(radius_m)
    h = anchored.heading.astype(kind)
    c0, s0 = anchored.cos0.astype(kind), anchored.sin0.astype(kind)
    u, v, up = east_m[:, None] / r, north_m[:, None] / r, one - down_m[:, None] / r
    q1 = u * h[:, 0] + v * h[:, 1]
    q2 = v * h[:, 0] - u * h[:, 1]
    w = s0 * up + c0 * q1
    sine = np.hypot(w, q2)
    cosine = c0 * up - s0 * q1
    excess = np.where(w > 0.0, q2 * q2 / np.maximum(sine + w, kind.type(1e-30)), sine - w)
    return np.arcsin(np.clip(q1 + c0 * excess, -one, one)), sine, cosine
