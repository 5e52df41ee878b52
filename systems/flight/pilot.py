"""The ways to move over one planet, one at a time: ship, on foot, globe in the hand; and flights to a place."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, get_args

from ...engine.space import direction
from .fly_to import FlyTo, pose_before, pose_over
from .ground import Ground
from .orbit import OrbitFlight, OrbitInput
from .path import Pose
from .rotation import Vector, unit
from .ship import FlightInput, ShipFlight
from .walk import WalkFlight, WaterHeight

Mode = Literal["ship", "walk", "orbit"]
MODES: tuple[Mode, ...] = get_args(Mode)

_LAND_M = 30.0
"""Higher up, who wants to walk is flown down first."""
_SEEN_M = (40.0, 2.0e5)
"""A place that was pointed at is looked at from so near, or a quarter of the way there if that is more."""


@dataclass(slots=True)
class Steering:
    """What the player asks for in one frame, for whichever mode it is."""

    flight: FlightInput = field(default_factory=FlightInput)
    orbit: OrbitInput = field(default_factory=OrbitInput)

    @property
    def moves(self) -> bool:
        """Whether anything but looking around is asked for: that ends a flight to a place."""
        f, o = self.flight, self.orbit
        return bool(f.forward or f.right or f.up or f.roll or o.drag or o.tilt or o.zoom_steps)


class Pilot:
    """Moves a camera over `ground`, which may change between frames. Starts as a ship.

    `mode` is set by `switch`; `pose` is where the camera is. While `route` is a FlyTo, it is followed; whoever steers
    takes over. water: the sea's surface for swimmers (None: calm).
    """

    def __init__(self, ground: Ground, pose: Pose, *, water: WaterHeight | None = None) -> None:
        self.ground = ground
        self.ship = ShipFlight(pose.position_m, pose.forward, pose.up, radius_m=ground.radius_m)
        self.ship.ground = ground
        self.ship.place(pose.position_m, pose.forward, pose.up)
        self.walker = WalkFlight(ground, pose.position_m, pose.forward, water=water)
        self.orbit = OrbitFlight(ground, pose.position_m, pose.forward, pose.up)
        self.mode: Mode = "ship"
        self.fov_y_deg = pose.fov_y_deg
        self.route: FlyTo | None = None
        self.route_s = 0.0
        self._then: Mode = "ship"

    @property
    def pose(self) -> Pose:
        """Where the camera is now."""
        body = {"ship": self.ship, "walk": self.walker, "orbit": self.orbit}[self.mode]
        return Pose(body.position_m, body.forward, body.up, self.fov_y_deg)

    @property
    def position_m(self) -> Vector:
        return self.pose.position_m

    @property
    def clearance_m(self) -> float:
        """Height of the eye above ground or sea."""
        if self.mode == "ship":
            return self.ship.clearance_m
        return self.ground.clearance(self.position_m)

    @property
    def speed_m_s(self) -> float:
        """0 for the globe in the hand, which has no speed of its own."""
        if self.mode == "orbit":
            return 0.0
        return self.ship.speed_m_s if self.mode == "ship" else self.walker.speed_m_s

    def place(self, pose: Pose) -> None:
        """Put the camera somewhere at rest. A walker lands below."""
        self.route = None
        self._put(pose)

    def switch(self, mode: Mode) -> None:
        """Go on from here in another way. Who wants to walk high above the ground is flown down first.

        ValueError for an unknown mode.
        """
        if mode not in MODES:
            raise ValueError(f"flight mode: expected one of {', '.join(MODES)}, found {mode!r}")
        pose, self.route = self.pose, None
        if mode == "walk" and self.mode != "walk" and self.clearance_m > _LAND_M:
            up = unit(pose.position_m)
            level = pose.forward - up * float(pose.forward @ up)
            ahead = level if float(level @ level) > 1e-6 else pose.up - up * float(pose.up @ up)
            floor = self.ground.lifted(up * (self.ground.radius_m * 0.5), self.walker.limits.eye_m)
            ahead = unit(ahead)
            self.fly_to(Pose(floor, ahead, up, self.fov_y_deg))
            self._then = "walk"
            return
        self.mode = mode
        self._put(pose)

    def fly_to(self, target: Pose, duration_s: float | None = None) -> None:
        """Fly smoothly to a pose, lifted above the ground where needed. The mode stays; a walker flies on as a ship."""
        start = self.pose
        if self.mode == "walk":
            self.mode = "ship"
            self._put(start)
        self.route, self.route_s = FlyTo(start, target, self.ground, duration_s=duration_s), 0.0
        self._then = self.mode

    def fly_to_place(
        self, latitude_deg: float, longitude_deg: float, altitude_m: float = 200.0, heading_deg: float = 0.0,
        pitch_deg: float = -15.0,
    ) -> None:  # fmt: skip
        """Fly to a place; altitude_m counts from ground or sea. ValueError for a latitude beyond the poles or NaN."""
        numbers = (latitude_deg, longitude_deg, altitude_m, heading_deg, pitch_deg)
        if not all(math.isfinite(n) for n in numbers) or abs(latitude_deg) > 90.0 or abs(pitch_deg) > 90.0:
            raise ValueError(
                "fly to: expected a latitude of -90..90, a pitch of -90..90 and finite numbers, found "
                f"latitude {latitude_deg!r}, longitude {longitude_deg!r}, altitude {altitude_m!r}, heading "
                f"{heading_deg!r}, pitch {pitch_deg!r}"
            )
        at = direction(latitude_deg, longitude_deg)
        self.fly_to(pose_over(self.ground, at, max(altitude_m, 2.0), heading_deg, pitch_deg, self.fov_y_deg))

    def fly_to_point(self, point_m: Vector) -> None:
        """Fly to where a point of the surface (planet-centred metres) is seen from near, from this side of it."""
        away = point_m - self.position_m
        near = min(max(0.25 * math.sqrt(float(away @ away)), _SEEN_M[0]), _SEEN_M[1])
        if near > 0.02 * self.ground.radius_m:  # from space: down to where single hills can be seen
            near = max(_SEEN_M[0], 0.001 * self.ground.radius_m)
        self.fly_to(pose_before(self.ground, point_m, self.position_m, near, self.fov_y_deg))

    def update(self, wish: Steering, dt_s: float) -> None:
        """Advance by `dt_s`."""
        if self.route is not None and wish.moves:
            self.route = None
        if self.route is not None:
            self._follow(self.route, dt_s)
        elif self.mode == "ship":
            self.ship.update(wish.flight, dt_s)
        elif self.mode == "walk":
            self.walker.update(wish.flight, dt_s)
        else:
            self.orbit.update(wish.orbit, dt_s)

    def _follow(self, route: FlyTo, dt_s: float) -> None:
        self.route_s += dt_s
        pose, before = route.pose_at(self.route_s), self.position_m
        self.fov_y_deg = pose.fov_y_deg
        position = self.ground.way(before, pose.position_m, route.clearance_m)
        self._put(Pose(position, pose.forward, pose.up, pose.fov_y_deg))
        if self.route_s >= route.duration_s:
            self.route = None
            if self._then != self.mode:
                self.mode = self._then
                self._put(pose)

    def _put(self, pose: Pose) -> None:
        self.fov_y_deg = pose.fov_y_deg
        if self.mode == "walk":
            self.walker.place(pose.position_m, pose.forward)
        else:
            (self.ship if self.mode == "ship" else self.orbit).place(pose.position_m, pose.forward, pose.up)


__all__ = ["MODES", "Mode", "Pilot", "Steering"]
