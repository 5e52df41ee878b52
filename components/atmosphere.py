"""Atmosphere: the air around a planet, as gas, haze and an absorbing layer."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Atmosphere"]

_MOST_PER_M = 1.0e4
"""Far above any air, yet what a tenth of a metre of it needs to be opaque; how much is too much depends on the height
of the air, so it is checked with the scene."""


@dataclass
class Atmosphere:
    """A shell of air from the reference sphere up to thickness_m. Its density is that of height 0 for all ground below.

    Numbers of three belong to wavelengths_nm, red first. Gas (Rayleigh) and haze (Mie) thin out exponentially
    from the reference sphere; the absorbing layer grows linearly to its centre and falls linearly above it. What haze
    takes away and doesn't scatter it absorbs. The defaults are Earth's (those of Bruneton's demo of 2017).
    """

    thickness_m: float = knob(
        60e3, 0.01, 1e8, "m", "Top of the air above the reference sphere; at most the planet's radius", log=True
    )
    rayleigh_scattering_per_m: Vec3 = knob(
        (5.802339381712381e-6, 1.355776244792022e-5, 3.3100005976367735e-5),
        0.0,
        _MOST_PER_M,
        "1/m",
        "Share of light that gas scatters in a metre at the reference sphere",
        log=True,
        group="gas",
    )
    rayleigh_scale_height_m: float = knob(
        8000.0, 1e-3, 1e8, "m", "Going up by this, gas thins to 1/e", log=True, group="gas"
    )
    mie_scattering_per_m: Vec3 = knob(
        (3.996e-6, 3.996e-6, 3.996e-6),
        0.0,
        _MOST_PER_M,
        "1/m",
        "Share of light that haze scatters in a metre at the reference sphere",
        log=True,
        group="haze",
    )
    mie_extinction_per_m: Vec3 = knob(
        (4.44e-6, 4.44e-6, 4.44e-6),
        0.0,
        _MOST_PER_M,
        "1/m",
        "Share of light that haze takes away in a metre: scattered or absorbed, so at least mie_scattering_per_m",
        log=True,
        group="haze",
    )
    mie_scale_height_m: float = knob(
        1200.0, 1e-3, 1e8, "m", "Going up by this, haze thins to 1/e", log=True, group="haze"
    )
    mie_asymmetry: float = knob(
        0.8,
        -0.99,
        0.99,
        "",
        "Where haze scatters to (g of Cornette and Shanks): 0 all around, towards 1 ahead, below 0 back",
        group="haze",
    )
    absorption_per_m: Vec3 = knob(
        (6.497166e-7, 1.8809e-6, 8.501668e-8),
        0.0,
        _MOST_PER_M,
        "1/m",
        "Share of light that the absorbing layer (on Earth ozone) swallows in a metre at its centre",
        log=True,
        group="absorbing layer",
    )
    absorption_center_m: float = knob(
        25e3, -1e8, 1e8, "m", "Height of the layer's centre above the reference sphere", group="absorbing layer"
    )
    absorption_half_width_m: float = knob(
        15e3, 1e-3, 1e8, "m", "From its centre the layer reaches this far up and down", log=True,
        group="absorbing layer",
    )  # fmt: skip
    ground_albedo: Vec3 = knob(
        (0.1, 0.1, 0.1),
        0.0,
        1.0,
        "",
        "Share of light that the ground on the whole gives back to the air",
        group="light",
        widget="color",
    )
    wavelengths_nm: Vec3 = knob(
        (680.0, 550.0, 440.0),
        100.0,
        1e4,
        "nm",
        "Which wavelengths the numbers of three belong to, red first: light is carried at 610, 550 and 440 nm",
        group="light",
    )
    night_light: float = knob(
        1.0,
        0.0,
        1e6,
        "",
        "Glow of the night sky: 1 is Earth's airglow overhead, a thousand-millionth of the sun's irradiance per sr",
        log=True,
        group="light",
    )
    method: str = knob(
        "ours",
        help="How scattered light is found: ours, or paper: tables as Bruneton and Neyret wrote them",
        choices=("ours", "paper"),
    )
