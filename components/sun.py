"""Sun: where the light comes from, how strong it is and how large its disc looks."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Sun"]


@dataclass
class Sun:
    """The sun, placed in one of three ways; the one that was set last counts, nothing set means direction (1, 0, 0).

    - direction: towards the sun, in planet axes; any length but zero.
    - elevation_deg with azimuth_deg (0 north, 90 east), as seen at latitude_deg, longitude_deg.
    - epoch_s: seconds on the calendar; the rendered time is added, and the planet turns below. On the planet's own
      calendar 0 is noon at longitude 0 at the northern spring equinox, and Planet.rotation_period_s, axial_tilt_deg and
      orbital_period_s do the rest. On Earth's 0 is 2000-01-01 12:00 UTC and the sun stands where the almanac has it.
    """

    direction: Vec3 | None = knob(
        None,
        help="Towards the sun in planet axes",
        nonzero=True,
        excludes=("elevation_deg", "epoch_s"),
        group="position",
        widget="direction",
    )
    elevation_deg: float | None = knob(
        None,
        -90.0,
        90.0,
        "deg",
        "Height of the sun above the horizon at latitude_deg, longitude_deg",
        excludes=("direction", "epoch_s"),
        group="position",
    )
    azimuth_deg: float = knob(180.0, -360.0, 360.0, "deg", "Heading of the sun: 0 north, 90 east", group="position")
    latitude_deg: float = knob(0.0, -90.0, 90.0, "deg", "Where elevation and azimuth are seen", group="position")
    longitude_deg: float = knob(0.0, -360.0, 360.0, "deg", "Where elevation and azimuth are seen", group="position")
    epoch_s: float | None = knob(
        None,
        -1e12,
        1e12,
        "s",
        "Time on the planet's calendar; moves the sun as time goes by",
        excludes=("direction", "elevation_deg"),
        group="position",
    )
    calendar: str = knob(
        "planet",
        help="What epoch_s counts on: a circular orbit, or Earth's",
        choices=("planet", "earth"),
        group="position",
    )
    irradiance: Vec3 = knob(
        (1.474, 1.8504, 1.91198),
        0.0,
        1e6,
        "W m^-2 nm^-1",
        "Strength of sunlight outside any air at 680, 550 and 440 nm",
        group="light",
    )
    angular_radius_rad: float = knob(
        0.004675, 1e-5, 0.5, "rad", "Half the angle of the sun's disc", log=True, group="light"
    )

    @property
    def mode(self) -> str:
        """ "direction", "elevation" or "epoch": which of the three places the sun."""
        if self.epoch_s is not None:
            return "epoch"
        return "direction" if self.elevation_deg is None else "elevation"
