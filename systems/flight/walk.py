"""On foot: gravity towards the planet's centre, ground that carries, steps, slopes, jumps, and swimming in the sea."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .ground import Ground
from .rotation import Vector, any_perpendicular, carry, cross, turn, unit
from .ship import FlightInput

WaterHeight = Callable[[Vector], float]
"""Height in m above the reference sphere of the sea's surface, waves included, at a unit direction."""
Obstacles = Callable[[Vector, Vector], tuple[Vector, Vector]]
"""Depths (N,) of spheres, centres (N, 3) and radii (N,), in what stands in the way, and normals (N, 3) out of it."""

_EARTH_RADIUS_M = 6.371e6
_HIGHEST_WAVE_M = 100.0
"""No wave, not the highest freak wave on record (32 m), wets feet that are so much higher."""
_PUSHES = 3
"""Between two trunks that touch, one pushes into the other."""
_STEEPEST_LOOK_RAD = math.radians(89.0)


@dataclass(frozen=True, slots=True)
class WalkLimits:
    """How the walker moves."""

    eye_m: float = 1.7
    speed_m_s: float = 4.0
    boost_factor: float = 3.0
    swim_share: float = 0.5
    step_m: float = 0.45
    """Higher edges within one pace stop the walker."""
    slope_deg: float = 50.0
    """Steeper ground can't be climbed, and is slid down."""
    body_m: float = 0.35
    """Half the width of the body: slopes are those between its sides, and it keeps so far from trunks."""
    waist_m: float = 1.0
    """Height above the feet at which trunks are met."""
    jump_m: float = 1.1
    """How high a jump lifts the feet."""
    float_m: float = 1.45
    """Depth of water around a body that swims: the eye is so much less than `eye_m` above the water."""
    inertia_s: float = 0.08
    air_inertia_s: float = 0.8
    least_gravity_m_s2: float = 1.0
    """On an asteroid a jump would last for minutes, or for ever."""
    step_s: float = 1.0 / 60.0
    longest_step_s: float = 0.5


class WalkFlight:
    """A walker's eye over one planet. `place` sets it down on the ground below, or into the sea.

    water: the sea's surface now (None: calm at the ground's sea_level_m). obstacles: what is walked around, such as
    trunks; it slides along them. Gravity is that of a body as dense as Earth,
    9.81 m/s^2 by the radius.
    """

    def __init__(
        self,
        ground: Ground,
        position_m: ArrayLike,
        forward: ArrayLike,
        *,
        limits: WalkLimits | None = None,
        water: WaterHeight | None = None,
        obstacles: Obstacles | None = None,
    ) -> None:
        self.ground, self.limits, self.water = ground, limits or WalkLimits(), water
        self.obstacles = obstacles
        self.velocity_m_s: Vector = np.zeros(3)
        self.place(position_m, forward)

    def place(self, position_m: ArrayLike, forward: ArrayLike) -> None:
        """Stand below a position at rest, looking along `forward` as far as a neck allows."""
        self._up: Vector = unit(np.array(position_m, dtype=np.float64).reshape(3))
        ahead = unit(np.array(forward, dtype=np.float64).reshape(3))
        level = ahead - self._up * float(ahead @ self._up)
        flat = math.sqrt(float(level @ level))
        self._level = level / flat if flat > 1e-6 else any_perpendicular(self._up)
        self._pitch_rad = _bounded_pitch(math.atan2(float(ahead @ self._up), flat))
        self._foot_m = self._ground_at(self._up)
        water = self._water_at(self._up)
        self.standing, self.swimming = True, False
        if water is not None and water - self._foot_m > self.limits.float_m:
            self._foot_m, self.standing, self.swimming = water - self.limits.float_m, False, True
        self.velocity_m_s = np.zeros(3)

    # what others read

    @property
    def position_m(self) -> Vector:
        """The eye."""
        return self._up * (self.ground.radius_m + self._foot_m + self.limits.eye_m)

    @property
    def forward(self) -> Vector:
        return self._level * math.cos(self._pitch_rad) + self._up * math.sin(self._pitch_rad)

    @property
    def up(self) -> Vector:
        return self._up * math.cos(self._pitch_rad) - self._level * math.sin(self._pitch_rad)

    @property
    def gravity_m_s2(self) -> float:
        return max(9.81 * self.ground.radius_m / _EARTH_RADIUS_M, self.limits.least_gravity_m_s2)

    @property
    def speed_m_s(self) -> float:
        return math.sqrt(float(self.velocity_m_s @ self.velocity_m_s))

    # one frame

    def update(self, wish: FlightInput, dt_s: float) -> None:
        """Advance by `dt_s` in equal sub-steps; a pause longer than `longest_step_s` counts as that long.

        wish: forward and right walk, up > 0 jumps or swims up, up < 0 dives, boost runs; roll and wheel do nothing.
        """
        if not (math.isfinite(dt_s) and dt_s >= 0.0):
            raise ValueError(f"WalkFlight.update: dt_s must be finite and at least 0, found {dt_s!r}")
        self._level = unit(turn(self._level, self._up, -wish.look_yaw_rad))
        self._pitch_rad = _bounded_pitch(self._pitch_rad + wish.look_pitch_rad)
        dt_s = min(dt_s, self.limits.longest_step_s)
        steps = max(1, math.ceil(dt_s / self.limits.step_s - 1e-9))
        for _ in range(steps if dt_s > 0.0 else 0):
            self._step(wish, dt_s / steps)

    def _step(self, wish: FlightInput, dt_s: float) -> None:
        limits, up = self.limits, self._up
        heights = self._around()
        here, slope = heights[0], np.array([heights[1] - heights[2], heights[3] - heights[4]]) / (2.0 * limits.body_m)
        uphill = slope[0] * self._level + slope[1] * cross(self._level, up)
        water = self._water_at(up)
        deep = water is not None and water - max(self._foot_m, here) > limits.float_m - 0.05
        self.swimming = deep and water is not None and self._foot_m < water - 0.8 * limits.float_m
        wanted = wish.forward * self._level + wish.right * cross(self._level, up)
        size = math.sqrt(float(wanted @ wanted))
        speed = limits.speed_m_s * (limits.boost_factor if wish.boost else 1.0)
        speed *= limits.swim_share if self.swimming else 1.0
        wanted = wanted * (speed / max(size, 1.0))
        climb = float(self.velocity_m_s @ up)
        level = self.velocity_m_s - climb * up
        steep = math.sqrt(float(uphill @ uphill)) > math.tan(math.radians(limits.slope_deg))
        inertia = limits.inertia_s if self.standing and not steep else limits.air_inertia_s
        level = wanted + (level - wanted) * math.exp(-dt_s / (4.0 * limits.inertia_s if self.swimming else inertia))
        if steep and self.standing and not self.swimming:
            level = self._slide(level, uphill, dt_s)
        climb = self._climb(climb, wish, water, dt_s)
        self._go(level, climb, here, dt_s)

    def _slide(self, level: Vector, uphill: Vector, dt_s: float) -> Vector:
        """Ground that is too steep isn't walked up, and a body on it slides."""
        steep = math.sqrt(float(uphill @ uphill))
        direction = uphill / steep
        level = level - max(float(level @ direction), 0.0) * direction
        return level - direction * (self.gravity_m_s2 * dt_s * steep / (1.0 + steep * steep))

    def _climb(self, climb: float, wish: FlightInput, water: float | None, dt_s: float) -> float:
        """The vertical speed of this step."""
        limits = self.limits
        if self.swimming:
            assert water is not None
            surface = water - limits.float_m
            wanted = wish.up * limits.speed_m_s * limits.swim_share
            if wanted == 0.0 and self._foot_m > surface - 1.0:
                wanted = (surface - self._foot_m) * 4.0  # floats with the waves
            if wanted > 0.0:
                wanted = min(wanted, max((surface - self._foot_m) * 8.0, 0.0))  # not out of the water
            return wanted + (climb - wanted) * math.exp(-dt_s / 0.15)
        if self.standing:
            return math.sqrt(2.0 * self.gravity_m_s2 * limits.jump_m) if wish.up > 0.0 else 0.0
        return climb - self.gravity_m_s2 * dt_s

    def _go(self, level: Vector, climb: float, here: float, dt_s: float) -> None:
        limits, up = self.limits, self._up
        away = self.ground.radius_m + self._foot_m
        there, level = self._around_trunks(unit(up * away + level * dt_s), level)
        ground = self._ground_at(there)
        if ground - max(self._foot_m, here) > limits.step_m:  # a wall: stand before it
            there, ground, level = up, here, np.zeros(3)
        foot = self._foot_m + climb * dt_s
        held = self.standing and climb <= 0.0 and not self.swimming and ground >= foot - limits.step_m
        if held or foot <= ground:
            foot, climb, self.standing = ground, 0.0, not self.swimming
        else:
            self.standing = False
        self._foot_m = foot
        self._level = carry(self._level, up, there)
        self._level = unit(self._level - there * float(self._level @ there))
        self.velocity_m_s = carry(level, up, there) + climb * there
        self._up = there

    def _around_trunks(self, there: Vector, level: Vector) -> tuple[Vector, Vector]:
        """Where a step to `there` ends beside what is in the way, and the velocity along it."""
        if self.obstacles is None:
            return there, level
        waist = self.ground.radius_m + self._foot_m + self.limits.waist_m
        for _ in range(_PUSHES):
            depth, normal = self.obstacles(there[None] * waist, np.array([self.limits.body_m]))
            out = normal[0] - there * float(normal[0] @ there)
            flat = math.sqrt(float(out @ out))
            if not depth[0] > 0.0 or flat < 1e-6:
                break
            out = out / flat
            there = unit(there * waist + out * (float(depth[0]) / flat))
            level = level - min(float(level @ out), 0.0) * out
        return there, level

    def _around(self) -> list[float]:
        """Ground heights below the body, and ahead, behind, right and left of it."""
        side = cross(self._level, self._up)
        arm = self.limits.body_m / self.ground.radius_m
        points = np.stack([np.zeros(3), self._level, -self._level, side, -side]) * arm + self._up
        return self.ground.dry(points).tolist()

    def _ground_at(self, up: Vector) -> float:
        return float(self.ground.dry(up[None])[0])

    def _water_at(self, up: Vector) -> float | None:
        if self.ground.sea_level_m is None:
            return None
        if self.water is None or self._foot_m > self.ground.sea_level_m + _HIGHEST_WAVE_M:
            return self.ground.sea_level_m  # inland nobody asks for waves
        return self.water(up)


def _bounded_pitch(pitch_rad: float) -> float:
    return min(max(pitch_rad, -_STEEPEST_LOOK_RAD), _STEEPEST_LOOK_RAD)


__all__ = ["Obstacles", "WalkFlight", "WalkLimits", "WaterHeight"]
