"""A globe in the hand: drag it, zoom to what lies under the pointer, tilt; never below the ground.

Pixels become rays by the picture's size and field of view, so that the point that was grabbed stays under the pointer.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .ground import Ground
from .rotation import Vector, any_perpendicular, arc_angle, carry, cross, turn, unit


@dataclass(slots=True)
class OrbitInput:
    """What the player asks for in one step. Pointer places are -1..1 over the picture, x to the right and y up.

    drag turns the globe, tilt leans over it (both from pointer_before to pointer), zoom_steps > 0 goes nearer to the
    pointer. forward, right and turn (-1..1) do the same for keys and sticks, about the picture's middle.
    """

    pointer: tuple[float, float] = (0.0, 0.0)
    pointer_before: tuple[float, float] = (0.0, 0.0)
    drag: bool = False
    tilt: bool = False
    zoom_steps: float = 0.0
    forward: float = 0.0
    right: float = 0.0
    turn: float = 0.0
    lean: float = 0.0
    fov_y_deg: float = 60.0
    aspect: float = 16.0 / 9.0


@dataclass(frozen=True, slots=True)
class OrbitLimits:
    """How the globe handles."""

    clearance_m: float = 2.0
    zoom_factor: float = 0.8
    """What is left of the distance to the pointer's place after one step of the wheel."""
    zoom_inertia_s: float = 0.12
    spin_inertia_s: float = 0.35
    """A globe that is let go while turning turns on; its speed falls to 1/e in this time."""
    keys_per_s: float = 0.5
    """Distances to the ground by which a held key moves the picture's middle in a second."""
    turn_rad_s: float = 0.9
    farthest_radii: float = 60.0
    highest_look_deg: float = 85.0
    """From straight down: further up one would look into the sky."""


class OrbitFlight:
    """A camera over one planet that is moved by moving the planet below it. Axes and metres as in ShipFlight."""

    def __init__(
        self,
        ground: Ground,
        position_m: ArrayLike,
        forward: ArrayLike,
        up: ArrayLike | None = None,
        *,
        limits: OrbitLimits | None = None,
    ) -> None:
        self.ground, self.limits = ground, limits or OrbitLimits()
        self.place(position_m, forward, up)

    def place(self, position_m: ArrayLike, forward: ArrayLike, up: ArrayLike | None = None) -> None:
        """Put the camera somewhere at rest, lifted above the ground where needed."""
        self.position_m: Vector = np.array(position_m, dtype=np.float64).reshape(3)
        self.forward: Vector = unit(np.array(forward, dtype=np.float64).reshape(3))
        above = unit(self.position_m) if up is None else unit(np.array(up, dtype=np.float64).reshape(3))
        self.up: Vector = self._square(above)
        self._grabbed: Vector | None = None
        self._spin_axis: Vector = np.array([0.0, 0.0, 1.0])
        self._spin_rad_s = 0.0
        self._zoom_left = 0.0
        self._zoom_at: Vector | None = None
        self.position_m = self.ground.lifted(self.position_m, self.limits.clearance_m)

    @property
    def right(self) -> Vector:
        return cross(self.forward, self.up)

    @property
    def clearance_m(self) -> float:
        """Height above ground or sea."""
        return self.ground.clearance(self.position_m)

    def update(self, wish: OrbitInput, dt_s: float) -> None:
        """Advance by `dt_s`: what was dragged follows at once, zoom and a globe let go run out."""
        if not (math.isfinite(dt_s) and dt_s >= 0.0):
            raise ValueError(f"OrbitFlight.update: dt_s must be finite and at least 0, found {dt_s!r}")
        self._drag(wish, dt_s)
        self._zoom(wish, dt_s)
        self._keys(wish, dt_s)
        if wish.tilt:
            dx = wish.pointer[0] - wish.pointer_before[0]
            dy = wish.pointer[1] - wish.pointer_before[1]
            self._lean_and_turn(-dy * 1.2, dx * 1.6)
        self.position_m = self.ground.lifted(self.position_m, self.limits.clearance_m)

    # the parts

    def _drag(self, wish: OrbitInput, dt_s: float) -> None:
        if not wish.drag:
            self._grabbed = None
            if self._spin_rad_s:
                self._spin(self._spin_axis, self._spin_rad_s * dt_s)
                self._spin_rad_s *= math.exp(-dt_s / self.limits.spin_inertia_s)
                if abs(self._spin_rad_s) < 1e-9:
                    self._spin_rad_s = 0.0
            return
        if self._grabbed is None:
            self._grabbed = self.under(wish.pointer_before, wish)
            self._spin_rad_s = 0.0
        if self._grabbed is None or wish.pointer == wish.pointer_before:
            self._spin_rad_s = 0.0
            return
        now = self._on_sphere(self._ray(wish.pointer, wish), math.sqrt(float(self._grabbed @ self._grabbed)))
        if now is None:
            return  # the pointer has left the globe
        start, end = unit(now), unit(self._grabbed)
        axis = cross(start, end)
        length = math.sqrt(float(axis @ axis))
        if length < 1e-300:
            return
        angle = arc_angle(start, end)
        self._spin(axis / length, angle)
        self._spin_axis, self._spin_rad_s = axis / length, angle / dt_s if dt_s > 0.0 else 0.0

    def _zoom(self, wish: OrbitInput, dt_s: float) -> None:
        if wish.zoom_steps:
            self._zoom_left += wish.zoom_steps
            self._zoom_at = self.under(wish.pointer, wish)
        if not self._zoom_left:
            return
        steps = self._zoom_left * (1.0 - math.exp(-dt_s / self.limits.zoom_inertia_s))
        self._zoom_left = 0.0 if abs(self._zoom_left - steps) < 1e-3 else self._zoom_left - steps
        target = self._zoom_at if self._zoom_at is not None else unit(self.position_m) * self.ground.radius_m
        before = self.position_m
        after = target + (before - target) * self.limits.zoom_factor**steps
        farthest = self.limits.farthest_radii * self.ground.radius_m
        if float(after @ after) > farthest * farthest:
            self._zoom_left = 0.0
            return
        # Leaning with the planet's curve, about the target: what is under the pointer stays there.
        old, new = unit(before), unit(after)
        self.position_m = self.ground.way(
            before, target + carry(after - target, old, new), self.limits.clearance_m
        )  # never through a mountain on the way
        self.forward, self.up = carry(self.forward, old, new), carry(self.up, old, new)
        self.up = self._square(self.up)

    def _keys(self, wish: OrbitInput, dt_s: float) -> None:
        if wish.forward or wish.right:
            ahead = self.up if abs(float(self.forward @ unit(self.position_m))) > 0.7 else self.forward
            way = wish.forward * self._tangent(ahead) + wish.right * self._tangent(self.right)
            length = math.sqrt(float(way @ way))
            if length > 1e-9:
                speed = self.limits.keys_per_s * max(self.clearance_m, self.limits.clearance_m) * min(length, 1.0)
                angle = speed * dt_s / math.sqrt(float(self.position_m @ self.position_m))
                self._spin(cross(unit(self.position_m), way / length), min(angle, 2.0 * dt_s))
        if wish.turn or wish.lean:
            step = self.limits.turn_rad_s * dt_s
            self._lean_and_turn(wish.lean * step, wish.turn * step)

    def _spin(self, axis: Vector, angle_rad: float) -> None:
        """Turn camera and all about the planet's centre, and stay above what comes below."""
        before = self.position_m
        self.position_m = self.ground.way(before, turn(before, axis, angle_rad), self.limits.clearance_m)
        self.forward, self.up = turn(self.forward, axis, angle_rad), turn(self.up, axis, angle_rad)
        self.up = self._square(self.up)

    def _lean_and_turn(self, lean_rad: float, turn_rad: float) -> None:
        """About the place in the picture's middle: `lean_rad` > 0 looks further up, `turn_rad` turns about the
        vertical."""
        middle = self._on_sphere(self.forward, self.ground.radius_m + self.ground.floor(self.position_m))
        centre = self.position_m if middle is None else middle
        vertical = unit(centre)
        side = self.right
        now = math.pi - math.acos(min(max(float(self.forward @ vertical), -1.0), 1.0))
        highest = math.radians(self.limits.highest_look_deg)
        lean_rad = min(max(now + lean_rad, min(0.0, now)), max(highest, now)) - now
        arm = self.position_m - centre
        for axis, angle in ((side, lean_rad), (vertical, turn_rad)):
            arm, self.forward, self.up = turn(arm, axis, angle), turn(self.forward, axis, angle), turn(
                self.up, axis, angle)  # fmt: skip
        self.position_m = self.ground.way(self.position_m, centre + arm, self.limits.clearance_m)
        self.forward, self.up = unit(self.forward), self._square(self.up)

    def under(self, pointer: tuple[float, float], wish: OrbitInput) -> Vector | None:
        """The surface below the pointer, metres in planet axes; None for the sky.

        The sphere through the ground there, found in a few turns: exact over seas and from space.
        """
        ray = self._ray(pointer, wish)
        found = self._on_sphere(ray, self.ground.radius_m + self.ground.floor(self.position_m))
        for _ in range(4):
            if found is None:
                return None
            better = self._on_sphere(ray, self.ground.radius_m + self.ground.floor(found))
            if better is None:
                return found
            found = better
        return found

    def _ray(self, pointer: tuple[float, float], wish: OrbitInput) -> Vector:
        half = math.tan(math.radians(wish.fov_y_deg) / 2.0)
        x, y = pointer
        return unit(self.forward + self.right * (x * half * wish.aspect) + self.up * (y * half))

    def _on_sphere(self, ray: Vector, radius: float) -> Vector | None:
        along = float(self.position_m @ ray)
        away = float(self.position_m @ self.position_m) - radius * radius
        under = along * along - away
        if under < 0.0 or along > 0.0 or away <= 0.0:
            return None
        return self.position_m + ray * (away / (-along + math.sqrt(under)))

    def _tangent(self, vector: Vector) -> Vector:
        up = unit(self.position_m)
        return vector - up * float(vector @ up)

    def _square(self, wanted: Vector) -> Vector:
        up = wanted - self.forward * float(wanted @ self.forward)
        length = math.sqrt(float(up @ up))
        return up / length if length > 1e-9 else any_perpendicular(self.forward)


__all__ = ["OrbitFlight", "OrbitInput", "OrbitLimits"]
