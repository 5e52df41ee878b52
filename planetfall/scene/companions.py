"""The planets of a scene at one moment: its own one and its companions, as bodies in the axes of its own planet."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..components import Orbit
from ..engine.settings import PartRevision
from .orbits import Matrix, Vector, centre_on, places, reach_m
from .scene import Scene

__all__ = ["Body", "SceneRevision", "bodies", "centre_of", "nearest", "own_reach_m", "own_revisions"]


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


def bodies(scene: Scene, time_s: float, stars_stand: bool = False) -> list[Body]:
    """All planets of a scene at a time, its own one first. stars_stand: under another sun than the scene's, which
    stands still, and the stars with it."""
    planet = scene.planet.planet
    found = [Body(scene.planet.name, scene, np.zeros(3), np.eye(3), planet.radius_m, own_reach_m(scene))]
    companions = scene.companions.values()
    if companions:
        others = [(companion.orbit, companion.scene.planet.planet) for companion in companions]
        there = places(scene.sun, planet, others, time_s, stars_stand)
        for companion, (centre, axes) in zip(companions, there, strict=True):
            own = companion.scene
            found.append(Body(companion.name, own, centre, axes, own.planet.radius_m, own_reach_m(own)))
    return found


def centre_of(scene: Scene, orbit: Orbit, time_s: float) -> Vector:
    """Where a companion on this orbit would be, (3,) in the axes of the scene's own planet."""
    return centre_on(orbit, scene.sun, scene.planet.planet, time_s)


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
    return reach_m(scene.planet)


class SceneRevision(NamedTuple):
    """Of a scene: its structure and its parts."""

    structure: int
    parts: tuple[PartRevision, ...]


def own_revisions(scene: Scene) -> SceneRevision:
    """Changes with everything that a scene's own planet shows or where its companions are."""
    parts = (*scene.planet.components(), *(companion.orbit for companion in scene.companions.values()))
    return SceneRevision(scene.world.structure_revision, tuple(PartRevision.of(part) for part in parts))
