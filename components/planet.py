"""Planet: the sphere that everything else stands on, where it is and how it turns."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Planet"]


@dataclass
class Planet:
    """A sphere with axes fixed to it: +Z north pole, +X latitude 0 longitude 0, +Y longitude 90 E.

    Its turning moves the sun in the sky when the sun is in epoch mode; nothing else turns with it.
    """

    radius_m: float = knob(
        6.371e6, 500.0, 1e8, "m", "Radius of the reference sphere, from which heights and altitudes count", log=True
    )
    position_m: Vec3 = knob((0.0, 0.0, 0.0), -1e13, 1e13, "m", "Where the planet's centre is in the scene")
    rotation_period_s: float = knob(
        86164.1, 60.0, 1e9, "s", "One turn against the stars; moves an epoch sun", log=True, group="rotation"
    )
    axial_tilt_deg: float = knob(
        0.0, 0.0, 180.0, "deg", "Angle between the axis and the normal of the orbit: seasons", group="rotation"
    )
    orbital_period_s: float = knob(
        3.15581e7, 3600.0, 1e12, "s", "One turn around the sun: the length of the year", log=True, group="rotation"
    )
