"""The ship that a player flies: six degrees of freedom whose speed follows the height above the ground.

From 36 000 km to 2 m is seven decades; no fixed speed serves them all. The ship's top speed is its clearance times a
rate, so that a held key closes in on the ground exponentially, without overshooting. Everything is f64 (planet-centred
metres, planet axes); the state is advanced in sub-steps of equal length, so the same inputs give the same flight.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .ground import Ground
from .profile import HeightLike
from .rotation import Vector, any_perpendicular, carry, cross, turn, unit

_STANDSTILL_M_S = 1e-4


@dataclass(slots=True)
class FlightInput:
    """What the player asks for in one step, free of keys and windows. Axes are -1..1, angles are this step's total.

    ``look_yaw_rad`` > 0 turns right, ``look_pitch_rad`` > 0 looks up, ``roll`` > 0 rolls right, ``wheel_steps`` > 0 is
    faster.
    """

    forward: float = 0.0
    right: float = 0.0
    up: float = 0.0
    roll: float = 0.0
    look_yaw_rad: float = 0.0
    look_pitch_rad: float = 0.0
    boost: bool = False
    wheel_steps: float = 0.0


@dataclass(frozen=True, slots=True)
class ShipLimits:
    """How the ship handles. Times are those in which a difference falls to 1/e."""

    clearance_m: float = 2.0
    """Lowest height of the eye above ground and water."""
    rate_per_s: float = 0.6
    """Top speed as clearances per second."""
    slowest_m_s: float = 3.0
    fastest_m_s: float = 6.0e7
    boost_factor: float = 5.0
    wheel_factor: float = 1.25
    wheel_range: float = 40.0
    inertia_s: float = 0.3
    roll_inertia_s: float = 0.15
    roll_rate_rad_s: float = 1.2
    level_time_s: float = 0.8
    near_share: float = 0.02
    """Below this share of the radius the ship counts as near the ground: it levels its roll and follows the horizon."""
    look_ahead_s: float = 0.5
    step_s: float = 1.0 / 60.0
    longest_step_s: float = 0.5


class _Surface(NamedTuple):
    """What a ship flies over."""

    ground: Ground
    field: HeightLike | None
    sea_level_m: float | None


class _Floors(NamedTuple):
    """Ground or water below a place, and below where the ship will be soon."""

    position_m: Vector
    surface: _Surface
    here_m: float
    ahead_m: float


class ShipFlight:
    """A steerable camera over one planet.

    ``radius_m`` is the reference sphere, ``field`` gives ground heights above it (None: a smooth sphere) and
    ``sea_level_m`` the water's height (None: dry). ``position_m`` is lifted at once when it lies below ground +
    clearance. ``forward`` and ``up`` need not be perpendicular. Zero or non-finite vectors raise ValueError.
    """

    def __init__(
        self,
        position_m: ArrayLike,
        forward: ArrayLike,
        up: ArrayLike | None = None,
        *,
        radius_m: float,
        field: HeightLike | None = None,
        sea_level_m: float | None = None,
        limits: ShipLimits | None = None,
    ) -> None:
        self.ground = Ground(radius_m, field, sea_level_m)
        self.limits = limits or ShipLimits()
        self.throttle = 1.0
        self.velocity_m_s: Vector = np.zeros(3)
        self._roll_rate_rad_s = 0.0
        self._known: _Floors | None = None
        self.place(position_m, forward, up)

    def place(self, position_m: ArrayLike, forward: ArrayLike, up: ArrayLike | None = None) -> None:
        """Put the ship somewhere at rest, lifted above the ground where needed."""
        self.position_m: Vector = np.array(position_m, dtype=np.float64).reshape(3)
        local_up = unit(self.position_m)
        self.forward: Vector = unit(np.array(forward, dtype=np.float64).reshape(3))
        wanted_up = local_up if up is None else unit(np.array(up, dtype=np.float64).reshape(3))
        self._orthonormalise(wanted_up)
        self.velocity_m_s = np.zeros(3)
        self._roll_rate_rad_s = 0.0
        self._keep_above_ground()

    # what others read

    @property
    def radius_m(self) -> float:
        return self.ground.radius_m

    @property
    def right(self) -> Vector:
        return cross(self.forward, self.up)

    @property
    def local_up(self) -> Vector:
        return unit(self.position_m)

    @property
    def altitude_m(self) -> float:
        """Height above the reference sphere."""
        return _length(self.position_m) - self.radius_m

    @property
    def clearance_m(self) -> float:
        """Height above ground or water, whichever is higher."""
        return self.altitude_m - self._heights()[0]

    @property
    def speed_m_s(self) -> float:
        return _length(self.velocity_m_s)

    def top_speed_m_s(self, clearance_m: float, boost: bool = False) -> float:
        """The speed of a held key at this clearance, throttle and boost included."""
        limits = self.limits
        speed = max(limits.rate_per_s * clearance_m, limits.slowest_m_s) * self.throttle
        return min(speed * (limits.boost_factor if boost else 1.0), limits.fastest_m_s)

    # one frame

    def update(self, wish: FlightInput, dt_s: float) -> None:
        """Advance by ``dt_s`` in equal sub-steps; a pause longer than ``longest_step_s`` counts as that long."""
        limits = self.limits
        if not (math.isfinite(dt_s) and dt_s >= 0.0):
            raise ValueError(f"ShipFlight.update: dt_s must be finite and at least 0, found {dt_s!r}")
        if wish.wheel_steps:
            throttle = self.throttle * limits.wheel_factor**wish.wheel_steps
            self.throttle = min(max(throttle, 1.0 / limits.wheel_range), limits.wheel_range)
        self._look(wish)
        dt_s = min(dt_s, limits.longest_step_s)
        steps = max(1, math.ceil(dt_s / limits.step_s - 1e-9))
        start, clearance = self.position_m, self.clearance_m
        for _ in range(steps if dt_s > 0.0 else 0):
            self._step(wish, dt_s / steps)
        self._stay_over(start, clearance)

    def _stay_over(self, start: Vector, clearance_m: float) -> None:
        """Over what stands between the frame's start and its end, however fast that was."""
        end = self.position_m
        if end is start or self.ground.is_clear(_length(end - start), min(clearance_m, self.clearance_m)):
            return
        way = self.ground.way(start, end, self.limits.clearance_m)
        if way is end:
            return
        self.position_m = way
        self._keep_above_ground()
        self._follow_horizon(unit(end), self._nearness(self.altitude_m))
        sinking = min(float(self.velocity_m_s @ self.local_up), 0.0)
        self.velocity_m_s = self.velocity_m_s - sinking * self.local_up

    def _look(self, wish: FlightInput) -> None:
        if wish.look_yaw_rad:
            # Near the ground a player expects to turn about the vertical, in space about the ship's own axis.
            local_up = self.local_up
            side = -1.0 if float(local_up @ self.up) < 0.0 else 1.0
            near = self._nearness(self.altitude_m)
            axis = self.up + near * (side * local_up - self.up)
            length = _length(axis)
            axis = axis / length if length > 1e-6 else self.up
            self.forward = turn(self.forward, axis, -wish.look_yaw_rad)
            self.up = turn(self.up, axis, -wish.look_yaw_rad)
        if wish.look_pitch_rad:
            axis = self.right
            self.forward = turn(self.forward, axis, wish.look_pitch_rad)
            self.up = turn(self.up, axis, wish.look_pitch_rad)
        self._orthonormalise(self.up)

    def _step(self, wish: FlightInput, dt_s: float) -> None:
        limits = self.limits
        before = self.local_up
        altitude = self.altitude_m
        if not (wish.forward or wish.right or wish.up) and self.speed_m_s < _STANDSTILL_M_S:
            self.velocity_m_s = np.zeros(3)
            self._keep_above_ground()
            self._roll(wish.roll, dt_s, self._nearness(altitude))
            return
        # The lower of here and ahead, so that the ship slows down before a slope and not inside it.
        clearance = max(altitude - max(self._heights()), limits.clearance_m)
        wanted = wish.forward * self.forward + wish.right * self.right + wish.up * self.up
        wanted = wanted / max(1.0, _length(wanted)) * self.top_speed_m_s(clearance, wish.boost)
        # The exact answer of dv/dt = (wanted - v) / inertia over the step, for any step length.
        decay = math.exp(-dt_s / limits.inertia_s)
        difference = self.velocity_m_s - wanted
        self.position_m = self.position_m + wanted * dt_s + difference * (limits.inertia_s * (1.0 - decay))
        self.velocity_m_s = wanted + difference * decay
        self._keep_above_ground()
        self._follow_horizon(before, self._nearness(altitude))
        self._roll(wish.roll, dt_s, self._nearness(altitude))

    def _follow_horizon(self, before: Vector, nearness: float) -> None:
        """Near the ground the ship turns with the planet's curve, so that a level flight stays level."""
        after = self.local_up
        self.forward = carry(self.forward, before, after, nearness)
        self.up = carry(self.up, before, after, nearness)
        self.velocity_m_s = carry(self.velocity_m_s, before, after, nearness)

    def _roll(self, wish: float, dt_s: float, nearness: float) -> None:
        limits = self.limits
        decay = math.exp(-dt_s / limits.roll_inertia_s)
        wanted = wish * limits.roll_rate_rad_s
        self._roll_rate_rad_s = wanted + (self._roll_rate_rad_s - wanted) * decay
        angle = self._roll_rate_rad_s * dt_s
        if not wish:
            # Looking straight up or down there is no horizon to level to; the wish fades out before that.
            local_up = self.local_up
            steepness = abs(float(self.forward @ local_up))
            fade = min(max((0.98 - steepness) / 0.1, 0.0), 1.0)
            tilt = math.atan2(-float(self.right @ local_up), float(self.up @ local_up))
            angle -= tilt * fade * nearness * (1.0 - math.exp(-dt_s / limits.level_time_s))
        self.up = turn(self.up, self.forward, angle)
        self._orthonormalise(self.up)

    def _keep_above_ground(self) -> None:
        if self.altitude_m >= self._heights()[0] + self.limits.clearance_m:
            return
        self.position_m = self.ground.lifted(self.position_m, self.limits.clearance_m)
        up = self.local_up
        sinking = min(float(self.velocity_m_s @ up), 0.0)
        self.velocity_m_s = self.velocity_m_s - sinking * up

    def _nearness(self, altitude_m: float) -> float:
        share = altitude_m / (self.limits.near_share * self.radius_m)
        return 1.0 / (1.0 + share * share)

    def _heights(self) -> tuple[float, float]:
        """Ground (or water) below the ship, and below where it will be soon. Asked of the field once a place."""
        known, surface = self._known, _Surface(self.ground, self.ground.field, self.ground.sea_level_m)
        if known is None or known.position_m is not self.position_m or known.surface != surface:
            soon = self.position_m + self.velocity_m_s * self.limits.look_ahead_s
            here, ahead = self.ground.floors(np.array([self.position_m, soon])).tolist()
            known = self._known = _Floors(self.position_m, surface, here, ahead)
        return known.here_m, known.ahead_m

    def _orthonormalise(self, wanted_up: Vector) -> None:
        self.forward = unit(self.forward)
        up = wanted_up - self.forward * float(wanted_up @ self.forward)
        self.up = unit(up) if _length(up) > 1e-9 else any_perpendicular(self.forward)


def _length(vector: Vector) -> float:
    return math.sqrt(float(vector @ vector))
