"""Spherical Gerstner waves in float64: where a point of the calm sea goes, and how the surface lies there.

At a direction v, wave i has come the angle x from its origin o; d is the unit tangent at v away from o, r the radius of
the calm sea, w the fade near origin and antipode times the factor of shallow water:
    theta = k r x + phi t,  P = v r + v sum w A sin(theta) + sum w Q A cos(theta) d.
Tangents are derivatives of P, with d turning as v moves (dd = -v along the way, cot(x) v x d across it); the normal is
their cross product. The printed methods of 2018 and 2019 are in paper.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import paper
from .anchor import anchor_axes
from .set import WaveSet
from .shoaling import footprint_weight, shoaling, shoaling_slope

__all__ = ["METHODS", "Surface", "displacement", "normal", "surface"]

Floats = NDArray[np.float64]

METHODS = ("ours", "paper_2018", "paper_2019")
"""Normalised directions and exact normals; the formulas as printed, with the arc by arccos or by arcsin."""

_BATCH = 400_000
"""Points times waves that are worked on at once: some tens of megabytes."""


@dataclass(frozen=True)
class Surface:
    """The displaced sea at M points of the calm one.

    displacement_m: (M, 3), planet axes. tangents: (M, 2, 3), derivatives of the position by a step along `axes`,
    metres per metre of the calm sea. normal: (M, 3) unit, outward. jacobian: (M,), area of the displaced surface seen
    from above over that of the calm sea: below 1 at crests, 0 where it would fold. axes: (M, 2, 3) unit tangents at v.
    """

    displacement_m: Floats
    tangents: Floats
    normal: Floats
    jacobian: Floats
    axes: Floats


def displacement(
    waves: WaveSet,
    directions: ArrayLike,
    time_s: float,
    depth_m: ArrayLike | None = None,
    spacing_m: ArrayLike | None = None,
    *,
    method: str = "ours",
) -> Floats:
    """Where points of the calm sea go, metres (M, 3) in planet axes, at unit directions (M, 3).

    depth_m: (M,) of the water at rest, None: deep everywhere. spacing_m: (M,), distance of the samples: waves too short
    for it are left out. The printed methods know neither.
    """
    return surface(waves, directions, time_s, depth_m, spacing_m, method=method).displacement_m


def normal(
    waves: WaveSet,
    directions: ArrayLike,
    time_s: float,
    depth_m: ArrayLike | None = None,
    spacing_m: ArrayLike | None = None,
    *,
    depth_slope: ArrayLike | None = None,
    method: str = "ours",
) -> Floats:
    """Unit normals (M, 3) of the displaced surface, where points of the calm sea at directions (M, 3) have gone."""
    return surface(waves, directions, time_s, depth_m, spacing_m, depth_slope=depth_slope, method=method).normal


def surface(
    waves: WaveSet,
    directions: ArrayLike,
    time_s: float,
    depth_m: ArrayLike | None = None,
    spacing_m: ArrayLike | None = None,
    *,
    depth_slope: ArrayLike | None = None,
    method: str = "ours",
) -> Surface:
    """Displacement, tangents and normal at once; see `displacement`.

    depth_slope: (M, 3), change of the depth along the calm sea, metres per metre in planet axes; None: even beds.
    """
    if method not in METHODS:
        raise ValueError(f"method: expected one of {', '.join(METHODS)}, found {method!r}")
    v = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    count = len(v)
    depth = None if depth_m is None else np.broadcast_to(np.asarray(depth_m, dtype=np.float64), (count,))
    spacing = None if spacing_m is None else np.broadcast_to(np.asarray(spacing_m, dtype=np.float64), (count,))
    slope = None if depth_slope is None else np.broadcast_to(np.asarray(depth_slope, dtype=np.float64), (count, 3))
    step = max(_BATCH // max(len(waves), 1), 1)
    parts = []
    for first in range(0, max(count, 1), step):
        rows = slice(first, first + step)
        if method == "ours":
            parts.append(
                _ours(
                    waves,
                    v[rows],
                    time_s,
                    None if depth is None else depth[rows],
                    None if spacing is None else spacing[rows],
                    None if slope is None else slope[rows],
                )
            )
        else:
            parts.append(_printed(waves, v[rows], time_s, method))
    if len(parts) == 1:
        return parts[0]
    names = ("displacement_m", "tangents", "normal", "jacobian", "axes")
    return Surface(*(np.concatenate([getattr(p, n) for p in parts]) for n in names))


def _ours(
    waves: WaveSet, v: Floats, time_s: float, depth: Floats | None, spacing: Floats | None, slope: Floats | None
) -> Surface:
    east, north = anchor_axes(v)
    r, k = waves.radius_m, waves.wave_number_per_m
    # Away from the origin, as long as the sine: accurate at the origin and at the antipode as well.
    along, across = -(east @ waves.origins.T), -(north @ waves.origins.T)
    cosine, sine = v @ waves.origins.T, np.hypot(along, across)
    angle = np.arctan2(sine, cosine)
    safe = np.where(sine > 1e-15, sine, 1.0)
    d1, d2 = along / safe, across / safe

    fade, fade_rate = _fade(waves, angle)
    weight, rate = fade, fade_rate  # rate: per radian along the way
    change = None  # of the weight per metre of depth
    if depth is not None:
        shallow = shoaling(k, depth[:, None])
        if slope is not None:
            change = weight * shoaling_slope(k, depth[:, None])
        weight, rate = weight * shallow, rate * shallow
    if spacing is not None:
        drawn = footprint_weight(waves.wavelength_m, spacing[:, None])
        weight, rate = weight * drawn, rate * drawn
        change = None if change is None else change * drawn

    cycles = np.fmod(r * angle, waves.wavelength_m) / waves.wavelength_m
    cycles = cycles + np.fmod(waves.speed_rad_s * time_s / (2.0 * np.pi), 1.0)
    theta = 2.0 * np.pi * cycles
    sin, cos = np.sin(theta), np.cos(theta)
    a, qa = waves.amplitude_m, waves.steepness * waves.amplitude_m
    up = weight * a * sin
    side = weight * qa * cos
    height = up.sum(axis=1)
    side1, side2 = (side * d1).sum(axis=1), (side * d2).sum(axis=1)

    # Slopes per metre of the calm sea, along each wave's way: of the height, and of the sideways movement.
    rise = weight * (a * k) * cos + (rate / r) * a * sin
    squeeze = -weight * (qa * k) * sin + (rate / r) * qa * cos
    turn = side * (cosine / safe) / r  # across the way d turns by cot(x) for each radian
    m11 = 1.0 + height / r + (squeeze * d1 * d1 + turn * d2 * d2).sum(axis=1)
    m22 = 1.0 + height / r + (squeeze * d2 * d2 + turn * d1 * d1).sum(axis=1)
    m12 = ((squeeze - turn) * d1 * d2).sum(axis=1)
    m21 = m12
    lift1 = (rise * d1).sum(axis=1) - side1 / r
    lift2 = (rise * d2).sum(axis=1) - side2 / r
    if change is not None:
        s1, s2 = (slope * east).sum(axis=1), (slope * north).sum(axis=1)
        grow = (change * a * sin).sum(axis=1)
        grow1, grow2 = (change * qa * cos * d1).sum(axis=1), (change * qa * cos * d2).sum(axis=1)
        lift1, lift2 = lift1 + grow * s1, lift2 + grow * s2
        m11, m22 = m11 + grow1 * s1, m22 + grow2 * s2
        m12, m21 = m12 + grow1 * s2, m21 + grow2 * s1  # m12: east component of the step along north

    def place(e: Floats, n: Floats, u: Floats) -> Floats:
        return e[:, None] * east + n[:, None] * north + u[:, None] * v

    area = m11 * m22 - m12 * m21
    # Cross product of (m11, m21, lift1) and (m12, m22, lift2).
    across_both = place(m21 * lift2 - lift1 * m22, lift1 * m12 - m11 * lift2, area)
    return Surface(
        place(side1, side2, height),
        np.stack([place(m11, m21, lift1), place(m12, m22, lift2)], axis=1),
        across_both / np.linalg.norm(across_both, axis=1, keepdims=True),
        area,
        np.stack([east, north], axis=1),
    )


def _fade(waves: WaveSet, angle: Floats) -> tuple[Floats, Floats]:
    """Weight near origin and antipode (M, N), and its change per radian away from the origin."""
    e0, e1 = waves.fade_edges.T
    near = np.minimum(angle, np.pi - angle)
    t = np.clip((2.0 * np.sin(0.5 * near) ** 2 - e0) / (e1 - e0), 0.0, 1.0)
    toward = np.where(angle < 0.5 * np.pi, 1.0, -1.0)
    return t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t) / (e1 - e0) * np.sin(near) * toward


def _printed(waves: WaveSet, v: Floats, time_s: float, method: str) -> Surface:
    arc = paper.arc_2018 if method == "paper_2018" else paper.arc_2019
    found = paper.waves(waves, v, time_s, arc)
    east, north = anchor_axes(v)
    dot = np.einsum("mi,mi->m", found.normal, v)
    return Surface(
        found.position_m - v * waves.radius_m,
        np.stack([found.tangent, found.bitangent], axis=1),
        found.normal / np.linalg.norm(found.normal, axis=1, keepdims=True),
        dot,
        np.stack([east, north], axis=1),
    )
