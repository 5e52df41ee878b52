"""A smooth way from here to a place: up, over and down, as long as it has to be and never under the ground.

Height and way are those of J. van Wijk and W. Nuij, "Smooth and efficient zooming and panning" (InfoVis 2003),
equations 9 and 10, with the clearance in place of the width of the view: what goes by in the picture goes by evenly.
"""

from __future__ import annotations

import math

import numpy as np

from ...engine.space import heading_pitch_axes
from .ground import Ground
from .path import Pose
from .profile import Array, GroundProfile
from .rotation import Vector, any_perpendicular, arc_angle, cross, exp_map, log_map, unit

_RHO = 1.4
"""Van Wijk and Nuij's users liked this share between going up and going along."""
_PACE_PER_S = 1.5
"""Their V: how much of the way a second takes."""
_RAMP = 0.3
_SHORTEST_S, _LONGEST_S = 0.8, 20.0
_SPIN_RAD_S = 1.5


class FlyTo:
    """From one pose to another over one planet. `pose_at(time_s)` for 0 to `duration_s`; the same time, the same pose.

    target: where to; its position is lifted to `clearance_m` above ground and sea. duration_s None: by the way.
    """

    def __init__(
        self, start: Pose, target: Pose, ground: Ground, *, duration_s: float | None = None, clearance_m: float = 2.0
    ) -> None:
        self.ground, self.clearance_m = ground, clearance_m
        self._from = ground.lifted(start.position_m, clearance_m)
        self._to = ground.lifted(target.position_m, clearance_m)
        self._a, b = unit(self._from), unit(self._to)
        self._tangent = log_map(self._a, b)
        if math.pi - arc_angle(self._a, b) < 1e-9:  # every way is as short: any will do
            self._tangent = any_perpendicular(self._a) * math.pi
        self._zoom = _Zoom(
            max(ground.clearance(self._from), clearance_m),
            max(ground.clearance(self._to), clearance_m),
            math.sqrt(float(self._tangent @ self._tangent)) * ground.radius_m,
        )
        # Far up, half the planet may go by at the top of the way: not faster than eyes can follow.
        spun = self._zoom.fastest * self._zoom.length / ((1.0 - _RAMP) * ground.radius_m * _SPIN_RAD_S)
        wanted = max(self._zoom.length / _PACE_PER_S + 0.5, spun) if duration_s is None else duration_s
        self.duration_s = min(max(wanted, _SHORTEST_S), _LONGEST_S) if duration_s is None else max(wanted, 1e-3)
        self._fov = (start.fov_y_deg, target.fov_y_deg)
        frame_a, frame_b = self._frame(0.0), self._frame(1.0)
        self._turned = frame_a.T @ _axes(start)
        self._twist = _log(self._turned.T @ (frame_b.T @ _axes(target)))
        self._profile = GroundProfile(
            self._tracks, self.duration_s, _Floors(ground), window_s=0.08 * self.duration_s, samples=512
        )

    def pose_at(self, time_s: float) -> Pose:
        """The pose at a time in s, clamped to the way."""
        time_s = min(max(float(time_s), 0.0), self.duration_s)
        share = self._share(time_s)
        along, above = self._zoom.at(share)
        place = exp_map(self._a, self._tangent * along)
        height = self._profile.height(time_s) + above
        position = self.ground.lifted(place * (self.ground.radius_m + height), self.clearance_m)
        x = share * share * (3.0 - 2.0 * share)
        axes = self._frame(along) @ self._turned @ _exp(self._twist * x)
        fov = self._fov[0] + (self._fov[1] - self._fov[0]) * x
        return Pose(position, axes[:, 0], axes[:, 1], fov)

    def _share(self, time_s: float) -> float:
        """Starts and ends at rest: speed rises and falls over _RAMP of the time each, with no kink (smoothstep)."""
        x = time_s / self.duration_s
        return 1.0 - _ramped(1.0 - x) if x > 0.5 else _ramped(x)

    def _frame(self, along: float) -> Array:
        """Columns: along the way, up, to the side; turning with the planet's curve and about nothing else."""
        place = exp_map(self._a, self._tangent * along)
        length = math.sqrt(float(self._tangent @ self._tangent))
        ahead = self._tangent / length if length > 1e-15 else any_perpendicular(self._a)
        here = ahead * math.cos(along * length) - self._a * math.sin(along * length)
        return np.stack([here, place, cross(here, place)], axis=1)

    def _tracks(self, times_s: Array) -> Array:
        return np.stack([exp_map(self._a, self._tangent * self._zoom.at(self._share(float(t)))[0]) for t in times_s])


def pose_over(
    ground: Ground, direction: Vector, altitude_m: float, heading_deg: float, pitch_deg: float, fov_y_deg: float = 60.0
) -> Pose:
    """A pose `altitude_m` above the ground or sea in a unit direction."""
    forward, up = heading_pitch_axes(direction, heading_deg, pitch_deg)
    position = direction * (ground.radius_m + ground.floor(direction * ground.radius_m) + altitude_m)
    return Pose(position, forward, up, fov_y_deg)


def pose_before(ground: Ground, point_m: Vector, seen_from_m: Vector, distance_m: float, fov_y_deg: float) -> Pose:
    """A pose that looks at a point of the surface from `distance_m`, a little from above, from the side of a viewer."""
    up = unit(point_m)
    back = seen_from_m - point_m
    level = back - up * float(back @ up)
    length = math.sqrt(float(level @ level))
    level = level / length if length > 1e-3 * math.sqrt(float(back @ back)) else _south(up)
    elevation = math.radians(25.0)
    position = point_m + distance_m * (level * math.cos(elevation) + up * math.sin(elevation))
    position = ground.lifted(position, max(0.2 * distance_m, 2.0))
    forward = unit(point_m - position)
    above = unit(position)
    side = cross(forward, above)
    size = math.sqrt(float(side @ side))
    side = side / size if size > 1e-9 else any_perpendicular(forward)
    return Pose(position, forward, cross(side, forward), fov_y_deg)


class _Floors:
    """Ground and sea as a height field."""

    def __init__(self, ground: Ground) -> None:
        self._ground = ground

    def height(self, directions: Array) -> Array:
        return self._ground.floors(directions)


class _Zoom:
    """Shares of the way and clearances along van Wijk and Nuij's curve from clearance w0 to w1 over u1 metres."""

    def __init__(self, w0: float, w1: float, u1: float) -> None:
        self._w0, self._w1, self._u1 = w0, w1, u1
        self._straight = u1 < 1e-6 * max(w0, w1)
        if self._straight:
            self.length, self.fastest = abs(math.log(w1 / w0)) / _RHO, 0.0
            return
        r2, r4 = _RHO**2, _RHO**4
        b0 = (w1 * w1 - w0 * w0 + r4 * u1 * u1) / (2.0 * w0 * r2 * u1)
        b1 = (w1 * w1 - w0 * w0 - r4 * u1 * u1) / (2.0 * w1 * r2 * u1)
        self._r0, r1 = -math.asinh(b0), -math.asinh(b1)  # ln(-b + sqrt(b^2 + 1))
        self.length = (r1 - self._r0) / _RHO
        self.fastest = w0 * math.cosh(self._r0) / _RHO
        """Metres of the way by length of the curve, at its top."""

    def at(self, share: float) -> tuple[float, float]:
        """(share of the way, clearance in m) at a share of the curve."""
        s = share * self.length
        if self._straight:
            return share, self._w0 * (self._w1 / self._w0) ** share
        if share >= 1.0:
            return 1.0, self._w1
        r0 = self._r0
        u = self._w0 / _RHO**2 * (math.cosh(r0) * math.tanh(_RHO * s + r0) - math.sinh(r0))
        w = self._w0 * math.cosh(r0) / math.cosh(_RHO * s + r0)
        return min(max(u / self._u1, 0.0), 1.0), w


def _ramped(x: float) -> float:
    """The integral of smoothstep(x / _RAMP), scaled so that a way of that and its mirror image is 1 long."""
    if x >= _RAMP:
        return (x - 0.5 * _RAMP) / (1.0 - _RAMP)
    y = x / _RAMP
    return _RAMP * y * y * y * (1.0 - 0.5 * y) / (1.0 - _RAMP)


def _south(up: Vector) -> Vector:
    return -heading_pitch_axes(up, 0.0, 0.0)[0]


def _axes(pose: Pose) -> Array:
    return np.stack([pose.forward, pose.up, cross(pose.forward, pose.up)], axis=1)


def _log(rotation: Array) -> Vector:
    """Axis times angle of a rotation matrix."""
    skew = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    sine = 0.5 * math.sqrt(float(skew @ skew))
    cosine = 0.5 * (float(np.trace(rotation)) - 1.0)
    angle = math.atan2(sine, cosine)
    if sine > 1e-6:
        return skew * (0.5 * angle / sine)
    if cosine > 0.0:
        return 0.5 * skew
    column = rotation + np.eye(3)  # half a turn: the axis spans what stays
    axis = column[:, int(np.argmax((column * column).sum(axis=0)))]
    return unit(axis) * math.pi


def _exp(vector: Vector) -> Array:
    """The rotation matrix of axis times angle (Rodrigues)."""
    angle = math.sqrt(float(vector @ vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (vector / angle).tolist()
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * k + 2.0 * math.sin(0.5 * angle) ** 2 * (k @ k)


__all__ = ["FlyTo", "pose_before", "pose_over"]
