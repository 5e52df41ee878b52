"""Orbit: where a companion planet is, seen from the planet of the scene that it accompanies."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Orbit"]


@dataclass
class Orbit:
    """A circle around the scene's planet, or a fixed place.

    The circle lies among the stars: with a sun in epoch mode the scene's planet turns below it, as below the sun. Its
    plane is tilted by inclination_deg against the planet's equator about the line at longitude node_deg, where the
    companion passes northwards; phase_deg is the angle from there at time 0. position_m, in the axes of the scene's
    planet, takes the circle's place.
    """

    distance_m: float = knob(3.844e8, 1e3, 1e13, "m", "Between the centres of both planets", log=True, group="circle")
    period_s: float = knob(
        2.3605915e6, 0.0, 1e12, "s", "One turn around the scene's planet; 0 stands still", group="circle"
    )
    inclination_deg: float = knob(
        0.0, -180.0, 180.0, "deg", "Between the orbit's plane and the equator of the scene's planet", group="circle"
    )
    node_deg: float = knob(
        0.0, -360.0, 360.0, "deg", "Longitude, among the stars, at which it passes northwards", group="circle"
    )
    phase_deg: float = knob(0.0, -360.0, 360.0, "deg", "How far from there it is at time 0", group="circle")
    position_m: Vec3 | None = knob(
        None, -1e13, 1e13, "m", "Where its centre stays, in the axes of the scene's planet", nonzero=True, group="place"
    )
    locked: bool = knob(
        True,
        help="Turns longitude 0 to the scene's planet, always; else it turns by its own rotation_period_s",
        group="rotation",
    )
