"""Ocean: a sea of one level all over the planet."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Ocean"]


@dataclass
class Ocean:
    """Water up to sea_level_m wherever the ground is lower. Its surface is smooth."""

    sea_level_m: float = knob(0.0, -1e5, 1e5, "m", "Height of the sea above the reference sphere")
    absorption_per_m: Vec3 = knob(
        (0.35, 0.07, 0.03), 0.0, 100.0, "1/m", "How fast water swallows red, green and blue", group="water"
    )
    scattering_per_m: Vec3 = knob(
        (0.0014, 0.0022, 0.003), 0.0, 100.0, "1/m", "How much of it water throws back on the way", group="water"
    )
    bed_albedo: Vec3 = knob(
        (0.34, 0.27, 0.17),
        0.0,
        1.0,
        "",
        "Share of light that the bed under shallows throws back",
        group="water",
        widget="color",
    )
    roughness: float = knob(
        0.2,
        0.01,
        1.0,
        "",
        "Spread of slopes too small to be seen, the glitter's width: 0.2 is a wind of 7 m/s",
        group="water",
    )
    ice_latitude_deg: float = knob(
        90.0, 0.0, 90.0, "deg", "From here to the poles the sea is frozen; 90: nowhere", group="ice"
    )
    ice_albedo: Vec3 = knob(
        (0.62, 0.66, 0.70), 0.0, 1.0, "", "Share of light that sea ice throws back", group="ice", widget="color"
    )
