"""Spherical Gerstner waves in float64: where a point of the calm sea goes, and how the surface lies there.

At a direction v, wave i has come the angle x from its origin o; d is the unit tangent at v away from o, r the radius of
the calm sea, w the fade near origin and antipode times the factor of shallow water:
    theta = k r x + phi t,  P = v r + v sum w A sin(theta) + sum w Q A cos(theta) d.
Tangents are derivatives of P, with d turning as v moves (dd = -v along the way, cot(x) v x d across it); the normal is
their cross product. The printed methods of 2018 and 2019 are in paper.py.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import paper
from .anchor import anchor_axes
from .set import WaveSet
from .shoaling import DEEP, footprint_weight, open_share, shoaling, shoaling_slope

__all__ = ["METHODS", "Surface", "WaveMethod", "displacement", "normal", "surface", "wave_method"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WaveMethod:
    """A way to evaluate waves. printed: the year of the source whose formulas they are as printed, 0: ours, with
    normalised directions and exact normals; arc: how that source finds an arc, None: ours."""

    printed: int = 0
    arc: paper.Arc | None = None

    def surface(
        self,
        waves: WaveSet,
        v: Floats,
        time_s: Floats,
        depth: Floats | None,
        spacing: Floats | None,
        slope: Floats | None,
    ) -> Surface:
        """At points that are worked on at once; as `surface`."""
        if self.arc is not None:
            return _printed(waves, v, time_s, self.arc)
        return Local(waves, v, time_s, depth, spacing).surface(slope)


METHODS: Mapping[str, WaveMethod] = {
    "ours": WaveMethod(),
    "paper_2018": WaveMethod(2018, paper.arc_2018),
    "paper_2019": WaveMethod(2019, paper.arc_2019),
}
"""By the names that Ocean.method takes."""


def wave_method(name: str) -> WaveMethod:
    """The method of that name; ValueError names those that there are."""
    if name not in METHODS:
        raise ValueError(f"method: expected one of {', '.join(METHODS)}, found {name!r}")
    return METHODS[name]


_BATCH = 12_000
"""Points times waves that are worked on at once: arrays of 100 kB stay in the processor's cache."""
_LEAST = 64


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
    time_s: ArrayLike,
    depth_m: ArrayLike | None = None,
    spacing_m: ArrayLike | None = None,
    *,
    method: str = "ours",
) -> Floats:
    """Where points of the calm sea go, metres (M, 3) in planet axes, at unit directions (M, 3).

    depth_m: (M,) of the water at rest, None: deep everywhere. spacing_m: (M,), distance of the samples: waves too short
    for it are left out. The printed methods know neither. time_s: a number, or one for each direction (M,).
    """
    return surface(waves, directions, time_s, depth_m, spacing_m, method=method).displacement_m


def normal(
    waves: WaveSet,
    directions: ArrayLike,
    time_s: ArrayLike,
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
    time_s: ArrayLike,
    depth_m: ArrayLike | None = None,
    spacing_m: ArrayLike | None = None,
    *,
    depth_slope: ArrayLike | None = None,
    method: str = "ours",
) -> Surface:
    """Displacement, tangents and normal at once; see `displacement`.

    depth_slope: (M, 3), change of the depth along the calm sea, metres per metre in planet axes; None: even beds.
    """
    found = wave_method(method)
    v = np.atleast_2d(np.asarray(directions, dtype=np.float64))
    count = len(v)
    time = np.asarray(time_s, dtype=np.float64)
    depth, spacing, slope = _rows(depth_m, (count,)), _rows(spacing_m, (count,)), _rows(depth_slope, (count, 3))
    parts = []
    for rows in batches(count, len(waves)):
        t = time[rows] if time.ndim else time
        own = (_part(values, rows) for values in (depth, spacing, slope))
        parts.append(found.surface(waves, v[rows], t, *own))
    if len(parts) == 1:
        return parts[0]
    names = ("displacement_m", "tangents", "normal", "jacobian", "axes")
    return Surface(*(np.concatenate([getattr(p, n) for p in parts]) for n in names))


def batches(count: int, waves: int) -> Iterator[slice]:
    """Slices of points that are worked on at once; one empty one for no points."""
    step = max(_BATCH // max(waves, 1), _LEAST)
    for first in range(0, max(count, 1), step):
        yield slice(first, first + step)


def _rows(values: ArrayLike | None, shape: tuple[int, ...]) -> Floats | None:
    return None if values is None else np.broadcast_to(np.asarray(values, dtype=np.float64), shape)


def _part(values: Floats | None, rows: slice) -> Floats | None:
    return None if values is None else values[rows]


class Local:
    """M points and what N waves are there, arrays (M, N): d1, d2 the direction away from the origin in the tangent axes
    east and north (M, 3), cycles the phase, weight the share of the amplitude (None: all of it)."""

    def __init__(
        self, waves: WaveSet, v: Floats, time_s: Floats, depth: Floats | None, spacing: Floats | None = None
    ) -> None:
        self.waves, self.v = waves, v
        self.east, self.north = anchor_axes(v)
        origins = waves.origins.T
        # Away from the origin, as long as the sine: accurate at the origin and at the antipode as well.
        along, across = -(self.east @ origins), -(self.north @ origins)
        sine, self.cosine = np.sqrt(along * along + across * across), v @ origins
        self.safe = np.maximum(sine, 1e-15)
        self.d1, self.d2 = along / self.safe, across / self.safe
        angle = np.arctan2(sine, self.cosine)
        # In cycles, whose whole ones are dropped: 1e-7 rad is what float64 loses over 1e8 wavelengths.
        way = angle * (waves.radius_m / waves.wavelength_m)
        turns = waves.speed_rad_s * time_s[..., None] / (2.0 * np.pi)
        self.cycles = (way - np.floor(way)) + (turns - np.floor(turns))
        self.weight, self.rate = _fade(waves, self.cosine, angle)
        if waves.ice_sine < 1.0:
            # Where it isn't given the sea is deep; under ice what counts is that the product vanishes.
            depth = (1e4 if depth is None else depth) * open_share(waves.ice_sine, v)
        self.depth, self.drawn = depth, None
        if depth is not None and len(waves) and np.min(depth, initial=np.inf) * waves.wave_number_per_m[0] < DEEP:
            self._scale(shoaling(waves.wave_number_per_m, depth[:, None]))
        if spacing is not None:
            self.drawn = footprint_weight(waves.wavelength_m, spacing[:, None])
            self._scale(self.drawn)

    def _scale(self, factor: Floats) -> None:
        self.weight = factor if self.weight is None else self.weight * factor
        if self.rate is not None:
            self.rate = self.rate * factor

    def displacement(self) -> Floats:
        """Metres (M, 3) in planet axes."""
        theta = (2.0 * np.pi) * self.cycles
        sin, cos = np.sin(theta), np.cos(theta)
        if self.weight is not None:
            sin, cos = self.weight * sin, self.weight * cos
        qa = self.waves.steepness * self.waves.amplitude_m
        side1, side2, height = (cos * self.d1) @ qa, (cos * self.d2) @ qa, sin @ self.waves.amplitude_m
        return side1[:, None] * self.east + side2[:, None] * self.north + height[:, None] * self.v

    def surface(self, slope: Floats | None = None) -> Surface:
        """The displaced surface; slope: of the depth, (M, 3)."""
        waves, d1, d2, r = self.waves, self.d1, self.d2, self.waves.radius_m
        k, a = waves.wave_number_per_m, waves.amplitude_m
        qa, ak = waves.steepness * a, a * k
        theta = (2.0 * np.pi) * self.cycles
        sin, cos = np.sin(theta), np.cos(theta)
        sin_w, cos_w = (sin, cos) if self.weight is None else (self.weight * sin, self.weight * cos)
        height = sin_w @ a
        c1, c2 = cos_w * d1, cos_w * d2
        side1, side2 = c1 @ qa, c2 @ qa
        # Derivatives by metres of the calm sea: (m11, m21, lift1) along east, (m12, m22, lift2) along north. Moving on,
        # up and directions turn by 1 / r, and across its way a wave's direction by cot(x) / r.
        turn = cos_w * (self.cosine / self.safe)
        t1, t2 = turn * d1, turn * d2
        s1, s2 = sin_w * d1, sin_w * d2
        squeeze, curve = -qa * k, qa / r
        m11 = 1.0 + height / r + (s1 * d1) @ squeeze + (t2 * d2) @ curve
        m22 = 1.0 + height / r + (s2 * d2) @ squeeze + (t1 * d1) @ curve
        m12 = (s1 * d2) @ squeeze - (t1 * d2) @ curve
        m21 = m12
        lift1, lift2 = c1 @ ak - side1 / r, c2 @ ak - side2 / r
        if self.rate is not None:
            rise, push = (self.rate * sin) * (a / r), (self.rate * cos) * curve
            lift1, lift2 = lift1 + (rise * d1).sum(axis=1), lift2 + (rise * d2).sum(axis=1)
            m11, m22 = m11 + (push * d1 * d1).sum(axis=1), m22 + (push * d2 * d2).sum(axis=1)
            m12 = m21 = m12 + (push * d1 * d2).sum(axis=1)
        if slope is not None and self.depth is not None:
            b1, b2 = (slope * self.east).sum(axis=1), (slope * self.north).sum(axis=1)
            change = _fade(waves, self.cosine, np.arctan2(self.safe, self.cosine))[0]
            change = shoaling_slope(k, self.depth[:, None]) * (1.0 if change is None else change)
            change = change if self.drawn is None else change * self.drawn
            grow = (change * sin) @ a
            grow1, grow2 = (change * cos * d1) @ qa, (change * cos * d2) @ qa
            lift1, lift2 = lift1 + grow * b1, lift2 + grow * b2
            m11, m22 = m11 + grow1 * b1, m22 + grow2 * b2
            m12, m21 = m12 + grow1 * b2, m21 + grow2 * b1

        def place(e: Floats, n: Floats, u: Floats) -> Floats:
            return e[:, None] * self.east + n[:, None] * self.north + u[:, None] * self.v

        area = m11 * m22 - m12 * m21
        upward = place(m21 * lift2 - lift1 * m22, lift1 * m12 - m11 * lift2, area)
        return Surface(
            place(side1, side2, height),
            np.stack([place(m11, m21, lift1), place(m12, m22, lift2)], axis=1),
            upward / np.linalg.norm(upward, axis=1, keepdims=True),
            area,
            np.stack([self.east, self.north], axis=1),
        )


def _fade(waves: WaveSet, cosine: Floats, angle: Floats) -> tuple[Floats | None, Floats | None]:
    """Weight near origin and antipode (M, N), and its change per radian away from the origin; None: nothing fades."""
    e0, e1 = waves.fade_edges.T
    rows, columns = np.nonzero(1.0 - np.abs(cosine) < e1 * 1.001 + 1e-15)
    if not len(rows):
        return None, None
    e0, e1, x = e0[columns], e1[columns], angle[rows, columns]
    near = np.minimum(x, np.pi - x)
    t = np.clip((2.0 * np.sin(0.5 * near) ** 2 - e0) / (e1 - e0), 0.0, 1.0)
    weight, rate = np.ones_like(angle), np.zeros_like(angle)
    weight[rows, columns] = t * t * (3.0 - 2.0 * t)
    rate[rows, columns] = 6.0 * t * (1.0 - t) / (e1 - e0) * np.sin(near) * np.where(x < 0.5 * np.pi, 1.0, -1.0)
    return weight, rate


def _printed(waves: WaveSet, v: Floats, time_s: Floats, arc: paper.Arc) -> Surface:
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
