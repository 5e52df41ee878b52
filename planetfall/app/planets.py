"""A flight among several planets: which one it is over, and the way from one to another.

The pilot moves in the axes of one planet, that which the renderer would draw as its camera's (`companions.nearest`);
the app's camera is in the axes of the scene's own planet. With a single planet both are the same and this does nothing.
"""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..camera.camera import Camera
from ..camera.views import view, views
from ..components import Sun
from ..errors import UnknownNameError
from ..query.sea_surface import SeaSurface
from ..scene.companions import Body, bodies, nearest
from ..systems.flight import Pose
from ..systems.light.sun import resolve_sun

if TYPE_CHECKING:
    from ..engine.surface.field import HeightField
    from ..render.renderer import Renderer
    from ..scene.scene import PlanetHandle, Scene
    from ..systems.flight import Pilot, ShipFlight

__all__ = ["Crossing", "FlightPlanets", "Traveller", "first_camera"]

Vector = NDArray[np.float64]

_PACE_PER_S = 1.2
"""E-folds of the distance to the planet left, and then to the one ahead, in a second."""
_RAMP = 0.25
_ARRIVAL_RADII = 3.0
_AROUND_RADII = 6.0
"""So high, in radii of the planet that is left, the way has come around it."""
_TURN_SHARE = 0.5
"""Of a crossing's time, in which the view turns to where it goes."""


class Traveller(Protocol):
    """What flying among planets needs of the flight."""

    scene: Scene
    renderer: Renderer
    pilot: Pilot
    ship: ShipFlight
    sea: SeaSurface
    time_s: float

    @property
    def camera(self) -> Camera: ...

    def say(self, message: str) -> None: ...
    def meet_ground(self) -> None: ...


class FlightPlanets:
    """The planets of one flight. name: of that which the pilot's axes are those of."""

    def __init__(self, app: Traveller) -> None:
        self._app = app
        self.name = app.scene.planet.name
        self.crossing: Crossing | None = None

    @property
    def several(self) -> bool:
        return bool(self._app.scene.companions)

    @property
    def handle(self) -> PlanetHandle:
        """The planet that the flight is over."""
        return self._app.scene.planets.get(self.name, self._app.scene.planet)

    def body(self) -> Body:
        """That planet now, in the scene's axes."""
        found = {body.name: body for body in bodies(self._app.scene, self._app.time_s)}
        return found.get(self.name, found[self._app.scene.planet.name])

    def height_field(self) -> HeightField | None:
        """The ground below, as it is drawn; the scene's own where no frame has shown it yet."""
        app = self._app
        if not self.several or app.renderer.main == self.name:
            return app.renderer.height_field()
        return self.handle.height_field()

    def outside(self, pose: Pose) -> Pose:
        """A pose of the pilot in the scene's axes."""
        if self.name == self._app.scene.planet.name:
            return pose
        body = self.body()
        turned = body.axes @ pose.forward, body.axes @ pose.up
        return Pose(body.outside(pose.position_m), *turned, pose.fov_y_deg)

    def inside(self, pose: Pose) -> Pose:
        """The opposite of `outside`."""
        if self.name == self._app.scene.planet.name:
            return pose
        return _inside(self.body(), pose)

    def follow(self) -> None:
        """Go on in the axes of the planet that is nearest now, at the same place and speed."""
        app = self._app
        if not self.several and self.name == app.scene.planet.name:
            return
        pose = app.pilot.pose
        before = self.body() if self.name in app.scene.planets else None
        if before is None:  # its planet was taken out of the scene
            self._enter(bodies(app.scene, app.time_s)[0], _far_out(app.scene.planet.radius_m, pose))
            return
        there = before.outside(pose.position_m)
        now = nearest(bodies(app.scene, app.time_s), there)
        if now.name != before.name and app.pilot.route is None:
            velocity = now.axes.T @ before.axes @ app.ship.velocity_m_s
            self._enter(now, _inside(now, self.outside(pose)))
            app.ship.velocity_m_s = velocity
            app.say(f"now over {now.name}")

    def arrive(self, camera: Camera, sun: Sun | None) -> tuple[Pose, Sun | None]:
        """Take over the axes of the planet that a camera is near; where that is, and a sun of the camera's planet as
        one of the scene's."""
        app = self._app
        placed = camera.in_scene(app.scene)
        pose = Pose(placed.pose.position_m, placed.pose.forward, placed.pose.up, placed.optics.fov_y_deg)
        self.crossing = None
        if not self.several:
            return pose, sun
        found = {body.name: body for body in bodies(app.scene, app.time_s)}
        home = found[placed.planet.name]
        if sun is not None and home.name != app.scene.planet.name:
            shining = resolve_sun(sun, home.scene.planet.planet, app.time_s)
            x, y, z = (home.axes @ shining.direction).tolist()
            sun = Sun(direction=(x, y, z), irradiance=sun.irradiance, angular_radius_rad=sun.angular_radius_rad)
        outside = Pose(home.outside(pose.position_m), home.axes @ pose.forward, home.axes @ pose.up, pose.fov_y_deg)
        now = nearest(list(found.values()), outside.position_m)
        self._take(now)
        return (pose if now.name == home.name else _inside(now, outside)), sun

    def point(self, position_m: Vector) -> Vector:
        """A point of the scene's axes in the pilot's."""
        return position_m if self.name == self._app.scene.planet.name else self.body().inside(position_m)

    def pointed_at(self, x: float, y: float) -> str | None:
        """The companion, or the scene's own planet from a companion, that a pixel shows."""
        return self._app.renderer.planet_at(self._app.camera, x, y, self._app.time_s) if self.several else None

    def fly_to(self, name: str) -> None:
        """Fly to another planet, until it fills the view. UnknownNameError for one that isn't there."""
        app = self._app
        found = {body.name: body for body in bodies(app.scene, app.time_s)}
        if name not in found:
            raise UnknownNameError(f"there is no planet {name!r} to fly to; planets: {', '.join(found)}")
        app.pilot.route = None
        if app.pilot.mode != "ship":
            app.pilot.switch("ship")
        self.crossing = Crossing(self.body(), self.outside(app.pilot.pose), found[name], app.pilot.clearance_m)
        app.say(f"flying to {name}")

    def cross(self, dt_s: float) -> bool:
        """Go on with a flight to another planet; whether there is one."""
        crossing = self.crossing
        if crossing is None:
            return False
        crossing.time_s += dt_s
        app = self._app
        found = bodies(app.scene, app.time_s)
        pose = crossing.pose_at(crossing.time_s, found)
        now = nearest(found, pose.position_m)
        self._enter(now, _inside(now, pose))
        if crossing.time_s >= crossing.duration_s:
            self.crossing = None
        return True

    def _enter(self, body: Body, pose: Pose) -> None:
        self._take(body)
        self._app.pilot.place(pose)

    def _take(self, body: Body) -> None:
        app = self._app
        if body.name != self.name:
            self.name = body.name
            app.sea = SeaSurface(body.scene)
            app.pilot.walker.water = app.sea.height
        app.meet_ground()


class Crossing:
    """From near one planet to before another: up, around the planet that is left, and straight on.

    start: a pose in the scene's axes, clearance_m above `home`. The way is told from `home` and to `target` as they
    are at each moment: both may move. Speed follows the distance to the nearer of both, as a ship's does.
    """

    def __init__(self, home: Body, start: Pose, target: Body, clearance_m: float) -> None:
        self.home, self.target = home.name, target.name
        self._start = _inside(home, start)
        self._low_m = float(np.linalg.norm(self._start.position_m))
        self._left_m = max(clearance_m, 10.0)
        self._stop_m = _ARRIVAL_RADII * target.radius_m
        apart = float(np.linalg.norm(target.centre_m - home.centre_m))
        self._length = length = max(apart - self._stop_m - self._low_m, 1.0)
        self._around_m = min(_AROUND_RADII * home.radius_m, 0.6 * length)
        # Half way the distance left behind is as large as the one ahead.
        self._half = min(max(0.5 * (length + self._stop_m - self._left_m), 0.0), length)
        self._first = math.log((self._half + self._left_m) / self._left_m)
        self._second = math.log((length - self._half + self._stop_m) / self._stop_m)
        self.duration_s = (self._first + self._second) / _PACE_PER_S / (1.0 - _RAMP) + 1.0
        self.time_s = 0.0

    def pose_at(self, time_s: float, found: list[Body]) -> Pose:
        """The pose in the scene's axes, among planets as they are now."""
        at = {body.name: body for body in found}
        home, target = at.get(self.home, found[0]), at.get(self.target, found[0])
        share = min(max(time_s / self.duration_s, 0.0), 1.0)
        s = self._along(_ramped(share))
        way = target.centre_m - home.centre_m
        apart = float(np.linalg.norm(way))
        up = home.axes @ self._start.position_m / self._low_m
        direction = _between(up, way / apart, _smooth(s / self._around_m))
        # The planets may have moved since: all of the way is stretched.
        high = s / self._length * max(apart - self._stop_m - self._low_m, 0.0)
        position = home.centre_m + direction * (self._low_m + high)
        for body in found:
            if body.name not in (home.name, target.name):
                position = _kept_out(position, body)
        to = target.centre_m - position
        turn = _smooth(share / _TURN_SHARE)
        forward = _between(home.axes @ self._start.forward, to / np.linalg.norm(to), turn)
        return Pose(position, forward, _upright(home.axes @ self._start.up, forward), self._start.fov_y_deg)

    def _along(self, x: float) -> float:
        """Metres of the way at a share of the time."""
        e_folds = x * (self._first + self._second)
        if e_folds <= self._first:
            return self._left_m * math.expm1(e_folds)
        rest = self._stop_m * math.expm1(self._first + self._second - e_folds)
        return self._length - rest


def _kept_out(position: Vector, body: Body) -> Vector:
    """Beside a planet that stands in the way."""
    away = position - body.centre_m
    distance = float(np.linalg.norm(away))
    floor = 1.05 * body.reach_m
    return position if distance >= floor or distance == 0.0 else body.centre_m + away * (floor / distance)


def _smooth(share: float) -> float:
    share = min(max(share, 0.0), 1.0)
    return share * share * (3.0 - 2.0 * share)


def _inside(body: Body, pose: Pose) -> Pose:
    return Pose(
        body.inside(pose.position_m), body.axes.T @ pose.forward, body.axes.T @ pose.up, pose.fov_y_deg
    )  # fmt: skip


def _far_out(radius_m: float, pose: Pose) -> Pose:
    """A pose from a planet that is gone, over another one."""
    up = pose.position_m / np.linalg.norm(pose.position_m)
    return dataclasses.replace(pose, position_m=up * 4.0 * radius_m, forward=-up)


def _ramped(share: float) -> float:
    """0 to 1 with a smooth start and end: even speed but for a share of _RAMP at both."""
    if share > 0.5:
        return 1.0 - _ramped(1.0 - share)
    y = share / _RAMP
    part = _RAMP * y * y * y * (1.0 - 0.5 * y) if y < 1.0 else share - 0.5 * _RAMP
    return part / (1.0 - _RAMP)


def _between(one: Vector, other: Vector, share: float) -> Any:
    """On the great circle from one unit vector to another."""
    cosine = float(one @ other)
    if share >= 1.0 or cosine > 1.0 - 1e-12:
        return other
    side = other - one * cosine
    if float(side @ side) < 1e-6:  # opposite: any way around will do
        side = np.cross(one, np.eye(3)[int(np.argmin(np.abs(one)))])
    angle = share * math.acos(min(max(cosine, -1.0), 1.0))
    return one * math.cos(angle) + side / np.linalg.norm(side) * math.sin(angle)


def _upright(up: Vector, forward: Vector) -> Any:
    """The up at right angles to forward that is nearest to another one."""
    level = up - forward * float(up @ forward)
    if float(level @ level) < 1e-12:
        level = np.cross(forward, np.eye(3)[int(np.argmin(np.abs(forward)))])
    return level / np.linalg.norm(level)


def first_camera(scene: Scene) -> Camera:
    """The planet from orbit, or from three radii up where the scene has no such view."""
    if "orbit" in views(scene):
        return view("orbit", scene.planet)
    return Camera.at(20.0, 0.0, 3.0 * scene.planet.radius_m, 0.0, -90.0)
