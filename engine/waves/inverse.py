"""From a direction to the surface above it: which point of the calm sea has come there.

The sideways movement s -> s + T(s) is the gradient of |s|^2 / 2 + sum (Q A / k) sin(theta), which is strictly convex
while the sum of Q A k is below 1: there is one solution. Newton's method finds it, held back where it goes too far.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from .anchor import anchor_axes
from .gerstner import Local, WaveMethod, batches, wave_method
from .set import WaveSet
from .shoaling import DEEP

__all__ = ["RESIDUAL_M", "at_directions"]

Floats = NDArray[np.float64]
DepthOf = Callable[[Floats], Floats]
Singles = NDArray[np.float32]

RESIDUAL_M = 1e-4
"""Points are moved on until the surface is found within this distance of the direction asked for."""
_ROUNDS = 40
_STEPS = 8
_CLOSE_M = 1e-3
"""A step of Newton's method as short as this leaves an error near its square times the curvature: micrometres."""


def at_directions(
    waves: WaveSet, v: Floats, time_s: Floats, depth_of: DepthOf | None = None, *, method: str = "ours"
) -> tuple[Floats, Floats | None, Floats]:
    """What is in unit directions (M, 3): points of the calm sea (M, 3), depth there (M,) and their displacement (M, 3).

    time_s: () or (M,). depth_of: depth of the calm sea (m,) at unit directions (m, 3); None: no bed, and no depth.
    """
    found = wave_method(method)
    depth = None if depth_of is None else depth_of(v)
    calm, moved = v.copy(), np.zeros_like(v)
    for rows in batches(len(v), len(waves)):
        here = None if depth is None else depth[rows]
        time = time_s[rows] if time_s.ndim else time_s
        _solve(waves, v[rows], time, depth_of, found, calm[rows], here, moved[rows])
    return calm, depth, moved


def _solve(
    waves: WaveSet,
    v: Floats,
    time_s: Floats,
    depth_of: DepthOf | None,
    method: WaveMethod,
    calm: Floats,
    depth: Floats | None,
    moved: Floats,
) -> None:
    """Fill calm, depth and moved of a batch."""
    r = waves.radius_m
    if not method.printed and len(v) and len(waves):
        local = Local(waves, v, time_s, depth)
        step = _newton(local, slice(None), None)
        _move(calm, np.arange(len(v)), local.east, local.north, step, r)
        _deepen(waves, calm, np.flatnonzero(step.any(axis=1)), depth, depth_of)
    todo = np.arange(len(v))
    for attempt in range(_ROUNDS):
        time = time_s[todo] if time_s.ndim else time_s
        here = None if depth is None else depth[todo]
        local = None if method.printed else Local(waves, calm[todo], time, here)
        if local is None:
            offset = method.surface(waves, calm[todo], time, None, None, None).displacement_m
        else:
            offset = local.displacement()
        moved[todo] = offset
        position = calm[todo] * r + offset
        # To where the ray in the direction asked for is as far from the centre.
        missing = v[todo] * np.linalg.norm(position, axis=1)[:, None] - position
        bad = np.linalg.norm(missing, axis=1) > RESIDUAL_M
        if not bad.any():
            return
        todo = todo[bad]
        east, north = anchor_axes(calm[todo])
        step = np.stack([(missing[bad] * east).sum(axis=1), (missing[bad] * north).sum(axis=1)], axis=1)
        if local is not None and attempt < _ROUNDS // 2:
            step = _newton(local, bad, step)
        _move(calm, todo, east, north, step, r)
        _deepen(waves, calm, todo, depth, depth_of)


def _move(calm: Floats, rows: NDArray[np.int64], east: Floats, north: Floats, step_m: Floats, radius_m: float) -> None:
    moved = calm[rows] + (step_m[:, :1] * east + step_m[:, 1:] * north) / radius_m
    calm[rows] = moved / np.sqrt((moved * moved).sum(axis=1))[:, None]


def _deepen(
    waves: WaveSet, calm: Floats, rows: NDArray[np.int64], depth: Floats | None, depth_of: DepthOf | None
) -> None:
    """Depths where points have come to, if their waves feel the bed."""
    if depth is not None and depth_of is not None and len(waves):
        feel = rows[depth[rows] * waves.wave_number_per_m[0] < DEEP]
        if len(feel):
            depth[feel] = depth_of(calm[feel])


def _newton(local: Local, chosen: NDArray[np.bool_] | slice, target: Floats | None) -> Floats:
    """Steps s (m, 2), metres in the tangent plane, with s + T(s) - T(0) = target, by float32: the caller checks them.

    target None: -T(0), back to the place itself.

    Within some metres a wave's phase is linear in s, and its direction and weight stay what they are.
    """
    kind = np.float32
    waves = local.waves
    d1, d2 = local.d1[chosen].astype(kind), local.d2[chosen].astype(kind)
    theta0 = (2.0 * np.pi * (local.cycles[chosen] - np.floor(local.cycles[chosen]))).astype(kind)
    k = waves.wave_number_per_m.astype(kind)
    push = (waves.steepness * waves.amplitude_m).astype(kind)
    pull = push * k
    weight = None if local.weight is None else local.weight[chosen].astype(kind)
    kd1, kd2 = k * d1, k * d2
    d11, d12, d22 = d1 * d1, d1 * d2, d2 * d2
    if weight is not None:
        d1, d2, d11, d12, d22 = weight * d1, weight * d2, weight * d11, weight * d12, weight * d22
    goal1 = goal2 = np.zeros(len(theta0), kind)
    if target is not None:
        cos = np.cos(theta0)
        goal1, goal2 = target[:, 0].astype(kind) + (cos * d1) @ push, target[:, 1].astype(kind) + (cos * d2) @ push
    s1, s2 = np.zeros_like(goal1), np.zeros_like(goal2)
    for _ in range(_STEPS):
        theta = theta0 + kd1 * s1[:, None] + kd2 * s2[:, None]
        sin, cos = np.sin(theta), np.cos(theta)
        f1, f2 = goal1 - s1 - (cos * d1) @ push, goal2 - s2 - (cos * d2) @ push
        a, b, c = 1.0 - (sin * d11) @ pull, -(sin * d12) @ pull, 1.0 - (sin * d22) @ pull
        # The Hessian of the convex function; where it is nearly flat a plain step, which can't go too far, is safer.
        area = a * c - b * b
        flat = area < 0.3
        area = np.where(flat, kind(1.0), area)
        step1, step2 = (c * f1 - b * f2) / area, (a * f2 - b * f1) / area
        step1, step2 = np.where(flat, f1, step1), np.where(flat, f2, step2)
        s1, s2 = s1 + step1, s2 + step2
        if max(np.max(np.abs(step1)), np.max(np.abs(step2))) < _CLOSE_M:
            break
    return np.stack([s1, s2], axis=1).astype(np.float64)
