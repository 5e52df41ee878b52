"""Companions: further planets of a scene, such as a moon, each a scene of its own on an orbit or at a place.

    scene = pf.load_scene("earth")
    moon = scene.companions.add("moon", pf.Orbit(distance_m=3.844e8, phase_deg=40.0))

All places are float64 in the axes of the scene's own planet, in metres from its centre. Those axes are fixed to that
planet; a sun in epoch mode makes it turn, and with it turn sun, stars and companions.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Atmosphere, Clouds, Orbit, Sun, Terrain
from ..engine.settings import did_you_mean, revision
from ..errors import SceneError, UnknownNameError
from ..systems.light.sun import resolve_sky
from .kinds import SCENE_KINDS

if TYPE_CHECKING:
    from .scene import Scene

__all__ = ["Body", "Companion", "Companions", "bodies", "centre_of", "nearest", "own_reach_m", "own_revisions"]

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Companion:
    """A planet beside a scene's own. name: as in `scene.planets`. scene: its own scene, whose planet it is, with its
    ground, sea, air, clouds and objects; sun, stars, exposure and composite are those of the scene that it accompanies.
    orbit: where it is; change its fields at any time."""

    name: str
    scene: Scene
    orbit: Orbit

    def __repr__(self) -> str:
        return f"<Companion {self.name!r}: {self.orbit!r}>"


@dataclass(frozen=True, eq=False)
class Body:
    """One planet at one moment, in the axes of the scene's own planet.

    centre_m: (3,) f64. axes: (3, 3) f64, its own axes as columns: `centre_m + axes @ p` for a point p of its own.
    radius_m: of its reference sphere. reach_m: nothing of it (ground, air, clouds) is farther from its centre.
    """

    name: str
    scene: Scene
    centre_m: Vector
    axes: Matrix
    radius_m: float
    reach_m: float

    def inside(self, point_m: ArrayLike) -> Vector:
        """A point (3,) of the scene's axes in those of this planet, from its centre."""
        return self.axes.T @ (np.asarray(point_m, dtype=np.float64) - self.centre_m)

    def outside(self, point_m: ArrayLike) -> Vector:
        """The opposite of `inside`."""
        return self.centre_m + self.axes @ np.asarray(point_m, dtype=np.float64)

    def seen_from(self, other: Body) -> Body:
        """The same planet in the axes of another one."""
        axes = other.axes.T @ self.axes
        return Body(self.name, self.scene, other.inside(self.centre_m), axes, self.radius_m, self.reach_m)


class Companions(Mapping[str, Companion]):
    """The companions of a scene by name; `add` and `remove` take effect with the next frame."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._found: dict[str, Companion] = {}
        self._kept: list[Scene] = []

    def add(self, planet: Scene | str | os.PathLike[str], orbit: Orbit | None = None, name: str = "") -> Companion:
        """One more planet: a scene, or what `load_scene` takes. orbit: None is the Moon's distance. name: None is the
        scene's.

        Raises SceneError, and adds nothing, for a name that is taken, a scene that is in use already or has companions
        itself, an orbit through another planet; UnknownNameError and PresetError as load_scene.
        """
        from .scene import Scene, scene_of

        own = planet if isinstance(planet, Scene) else scene_of(planet)
        companion = Companion(name or own.name, own, Orbit() if orbit is None else orbit)
        try:
            self._check(companion)
        except BaseException:
            if own is not planet:
                own.release()
            raise
        self.join(companion)
        return companion

    def join(self, companion: Companion) -> None:
        """Take in a companion, or one that was removed before, unchecked: `Scene.validate` says what doesn't fit."""
        self._found[companion.name] = companion
        companion.scene.accompanies = self._scene
        self._scene._handles[companion.name] = companion.scene.planet
        self.share_environment()

    def keep(self, scene: Scene) -> None:
        """Have a scene released with the one that these accompany, whether it is a companion then or not."""
        self._kept.append(scene)

    def remove(self, name: str) -> Companion:
        """Take a planet out of the scene; its own scene stays. UnknownNameError for one that isn't there."""
        companion = self[name]
        del self._found[name], self._scene._handles[name]
        companion.scene.accompanies = None
        return companion

    def release(self) -> None:
        """Release all their scenes, with the scene that they accompany."""
        for scene in (*(companion.scene for companion in self._found.values()), *self._kept):
            if not scene.world.closed:
                scene.release()
        self._found.clear()
        self._kept.clear()

    def share_environment(self) -> None:
        """Give every companion the scene's own stars, exposure and composite; done again when those are replaced."""
        shared = {type(part): part for part in self._scene.environment.components()}
        for companion in self._found.values():
            theirs = companion.scene.environment
            for kind, part in shared.items():
                if kind is not Sun and theirs.get(kind) is not part:
                    companion.scene.world.add(theirs.entity, part)
            for kind in SCENE_KINDS.values():
                if kind not in shared and kind is not Sun and theirs.has(kind):
                    companion.scene.world.remove(theirs.entity, kind)

    def problems(self) -> list[str]:
        """What doesn't fit together, at time 0."""
        found = bodies(self._scene, 0.0)
        said: list[str] = []
        for k, one in enumerate(found):
            for other in found[k + 1 :]:
                apart = float(np.linalg.norm(one.centre_m - other.centre_m))
                if not apart > one.reach_m + other.reach_m:
                    said.append(
                        f"planets {one.name!r} and {other.name!r} are inside each other: their centres are {apart:g} m "
                        f"apart, their grounds and airs reach {one.reach_m:g} and {other.reach_m:g} m; raise "
                        "Orbit.distance_m or change its phase_deg"
                    )
        return said

    def _check(self, companion: Companion) -> None:
        where = f"companion {companion.name!r} of scene {self._scene.name!r}"
        if not isinstance(companion.orbit, Orbit):
            raise SceneError(f"{where}: orbit: expected a pf.Orbit, found {companion.orbit!r}")
        if self._scene.accompanies is not None:
            raise SceneError(
                f"{where}: that scene accompanies {self._scene.accompanies.name!r} itself, and companions have no "
                "companions; add both to the same scene"
            )
        if companion.name in self._scene.planets:
            there = ", ".join(self._scene.planets)
            raise SceneError(f"{where}: the scene has a planet of that name ({there}); give another: add(..., name=)")
        if companion.scene is self._scene or companion.scene.accompanies is not None:
            raise SceneError(f"{where}: its scene is in use already; load another one for it")
        if companion.scene.companions:
            raise SceneError(f"{where}: it has companions itself; add all of them to {self._scene.name!r}")
        self._found[companion.name] = companion
        try:
            problems = self.problems()
        finally:
            del self._found[companion.name]
        if problems:
            raise SceneError(f"{where}: {'; '.join(problems)}")

    def __getitem__(self, name: str) -> Companion:
        try:
            return self._found[name]
        except KeyError:
            hint = did_you_mean(name, self._found, "its companions")
            raise UnknownNameError(f"scene {self._scene.name!r} has no companion {name!r}; {hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)


def bodies(scene: Scene, time_s: float, stars_stand: bool = False) -> list[Body]:
    """All planets of a scene at a time, its own one first. stars_stand: under another sun than the scene's, which
    stands still, and the stars with it."""
    planet = scene.planet.planet
    found = [Body(scene.planet.name, scene, np.zeros(3), np.eye(3), planet.radius_m, own_reach_m(scene))]
    if not scene.companions:
        return found
    spins = scene.sun.epoch_s is not None and not stars_stand
    stars, moment_s = _among_stars(scene, time_s, spins)
    for companion in scene.companions.values():
        own = companion.scene
        spin_rad = 2.0 * math.pi * (moment_s / own.planet.planet.rotation_period_s % 1.0) if spins else 0.0
        centre, axes = _stand(companion.orbit, moment_s, stars, spin_rad)
        found.append(Body(companion.name, own, centre, axes, own.planet.radius_m, own_reach_m(own)))
    return found


def centre_of(scene: Scene, orbit: Orbit, time_s: float) -> Vector:
    """Where a companion on this orbit would be, (3,) in the axes of the scene's own planet."""
    stars, moment_s = _among_stars(scene, time_s, scene.sun.epoch_s is not None)
    return _stand(orbit, moment_s, stars, 0.0)[0]


def _among_stars(scene: Scene, time_s: float, spins: bool) -> tuple[Matrix, float]:
    """The stars' axes and the time that orbits go by. spins: the scene's planet turns below the stars."""
    if not spins:
        return np.eye(3), float(time_s)
    stars = resolve_sky(scene.sun, scene.planet.planet, time_s).star_axes
    return stars, float(time_s) + float(scene.sun.epoch_s or 0.0)


def _stand(orbit: Orbit, moment_s: float, stars: Matrix, spin_rad: float) -> tuple[Vector, Matrix]:
    """Centre (3,) and axes (3, 3) of a companion. stars: planet = stars @ inertial."""
    tilt = _about_z(math.radians(orbit.node_deg)) @ _about_x(math.radians(orbit.inclination_deg))
    if orbit.position_m is not None:
        centre, pole = np.array(orbit.position_m, dtype=np.float64), np.array([0.0, 0.0, 1.0])
    else:
        turns = moment_s / orbit.period_s % 1.0 if orbit.period_s > 0.0 else 0.0
        angle = math.radians(orbit.phase_deg) + 2.0 * math.pi * turns
        centre = stars @ tilt @ np.array([math.cos(angle), math.sin(angle), 0.0]) * orbit.distance_m
        pole = stars @ tilt[:, 2]
    if not orbit.locked:
        return centre, stars @ _about_z(spin_rad)
    ahead = -centre / np.linalg.norm(centre)
    east = np.cross(pole, ahead)
    if float(np.linalg.norm(east)) < 1e-9:  # right above a pole: any meridian will do
        east = np.cross(np.array([1.0, 0.0, 0.0]), ahead)
    east = east / np.linalg.norm(east)
    return centre, np.stack([ahead, east, np.cross(ahead, east)], axis=1)


def nearest(found: Sequence[Body], point_m: Vector) -> Body:
    """The planet that no other one can hide from a point: that of the least power |p - c|^2 - reach^2.

    Two spheres that don't meet lie on either side of the plane of equal power, and the point is on the side of the
    lesser one: a ray that leaves this side has left that sphere behind.
    """
    return min(found, key=lambda body: _power(body, point_m))


def _power(body: Body, point_m: Vector) -> float:
    away = point_m - body.centre_m
    distance = math.sqrt(float(away @ away))
    return (distance - body.reach_m) * (distance + body.reach_m)


def own_reach_m(scene: Scene) -> float:
    """How far ground, air and clouds of a scene's own planet reach from its centre."""
    handle = scene.planet
    terrain, air, clouds = handle.get(Terrain), handle.get(Atmosphere), handle.get(Clouds)
    tops = [0.0]
    if terrain is not None:
        tops.append(terrain.highest_m)
    if air is not None:
        tops.append(air.thickness_m)
    if clouds is not None:
        tops += [layer.top_m for layer in (clouds, *clouds.layers)]
    return handle.radius_m + max(tops)


def own_revisions(scene: Scene) -> tuple[Any, ...]:
    """Changes with everything that a scene's own planet shows or where its companions are."""
    parts = (*scene.planet.components(), *(companion.orbit for companion in scene.companions.values()))
    return (scene.world.structure_revision, *((id(part), revision(part)) for part in parts))


def _about_z(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _about_x(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
