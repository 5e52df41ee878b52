"""Where the planets of a scene stand, and how far each of them reaches.

All places are float64 in the axes of the scene's own planet, in metres from its centre. Those axes are fixed to that
planet; a sun in epoch mode makes it turn, and with it turn sun, stars and companions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..components import Atmosphere, Clouds, Orbit, Planet, Sun, Terrain
from .handle import Parts

__all__ = ["Matrix", "Vector", "centre_on", "overlaps", "places", "reach_m"]

Vector = NDArray[np.float64]
Matrix = NDArray[np.float64]


def places(
    sun: Sun, planet: Planet, others: Sequence[tuple[Orbit, Planet]], time_s: float, stars_stand: bool = False
) -> list[tuple[Vector, Matrix]]:
    """Centre (3,) and axes (3, 3; its own as columns) of planets on orbits around a scene's own one. stars_stand: under
    another sun than this one, which stands still, and the stars with it."""
    spins = sun.epoch_s is not None and not stars_stand
    stars, moment_s = _among_stars(sun, planet, time_s, spins)
    found = []
    for orbit, other in others:
        spin_rad = 2.0 * math.pi * (moment_s / other.rotation_period_s % 1.0) if spins else 0.0
        found.append(_stand(orbit, moment_s, stars, spin_rad))
    return found


def centre_on(orbit: Orbit, sun: Sun, planet: Planet, time_s: float) -> Vector:
    """Where a planet on this orbit is, (3,)."""
    stars, moment_s = _among_stars(sun, planet, time_s, sun.epoch_s is not None)
    return _stand(orbit, moment_s, stars, 0.0)[0]


def reach_m(planet: Parts) -> float:
    """How far ground, air and clouds of a planet reach from its centre."""
    terrain, air, clouds = planet.get(Terrain), planet.get(Atmosphere), planet.get(Clouds)
    tops = [0.0]
    if terrain is not None:
        tops.append(terrain.highest_m)
    if air is not None:
        tops.append(air.thickness_m)
    if clouds is not None:
        tops += [layer.top_m for layer in (clouds, *clouds.layers)]
    return (planet.get(Planet) or Planet()).radius_m + max(tops)


def overlaps(planets: Sequence[tuple[str, Vector, float]]) -> list[str]:
    """Which of these planets (name, centre, reach) are inside each other."""
    said: list[str] = []
    for k, (name, centre, reach) in enumerate(planets):
        for other, there, others_reach in planets[k + 1 :]:
            apart = float(np.linalg.norm(centre - there))
            if not apart > reach + others_reach:
                said.append(
                    f"planets {name!r} and {other!r} are inside each other: their centres are {apart:g} m apart, their "
                    f"grounds and airs reach {reach:g} and {others_reach:g} m; raise Orbit.distance_m or change its "
                    "phase_deg"
                )
    return said


def _among_stars(sun: Sun, planet: Planet, time_s: float, spins: bool) -> tuple[Matrix, float]:
    """The stars' axes and the time that orbits go by. spins: the scene's planet turns below the stars."""
    if not spins:
        return np.eye(3), float(time_s)
    from ..systems.light.sun import resolve_sky  # with all of engine.frame, which one planet alone does without

    return resolve_sky(sun, planet, time_s).star_axes, float(time_s) + float(sun.epoch_s or 0.0)


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
    # The square of a place 1e-200 m from the middle is 0; that it is inside the planet is said later.
    whole = centre if centre @ centre > 0.0 else centre / np.abs(centre).max()
    ahead = -whole / np.linalg.norm(whole)
    east = np.cross(pole, ahead)
    if float(np.linalg.norm(east)) < 1e-9:  # right above a pole: any meridian will do
        east = np.cross(np.array([1.0, 0.0, 0.0]), ahead)
    east = east / np.linalg.norm(east)
    return centre, np.stack([ahead, east, np.cross(ahead, east)], axis=1)


def _about_z(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _about_x(angle: float) -> Matrix:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
