"""Ocean: a sea all over the planet, its wind and its waves."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

import math
from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Ocean", "Wave"]


@dataclass(frozen=True)
class Wave:
    """One wave around the whole planet: rings around its origin, straight crests a quarter turn away."""

    origin: tuple[float, float] = knob(
        (0.0, 0.0), unit="deg", help="Latitude and longitude from which it runs, or to which", widget="place"
    )
    amplitude_m: float = knob(0.5, 0.0, 1e4, "m", "Height of its crests above the calm sea")
    wavelength_m: float = knob(60.0, 0.01, 1e7, "m", "From crest to crest", log=True)
    steepness: float = knob(
        0.5, 0.0, 1e6, "", "0: a sine; 1: points move in circles, crests are sharper than troughs; see Ocean.waves"
    )
    speed_rad_s: float | None = knob(
        None,
        -1e6,
        1e6,
        "rad/s",
        "Phase a second: above 0 crests run towards the origin, below 0 away from it; unset: away, as in deep water",
    )


def _not_too_steep(waves: tuple[Wave, ...]) -> str:
    steep = sum(w.steepness * w.amplitude_m * 2.0 * math.pi / w.wavelength_m for w in waves)
    if steep <= 1.0 + 1e-9:  # numbers typed to sixteen digits
        return ""
    return (
        f"the sum of steepness x amplitude_m x 2 pi / wavelength_m is {steep:.6g}, and above 1 the surface intersects "
        f"itself. Multiply all steepness by {1.0 / steep:.4g} or less"
    )


@dataclass
class Ocean:
    """Water up to sea_level_m wherever the ground is lower, with the waves of a wind and a swell, or given ones.

    Albedos of its bed, ice and foam are colours, linear sRGB as they show in sunlight.
    """

    sea_level_m: float = knob(0.0, -1e5, 1e5, "m", "Height of the sea above the reference sphere")
    wind_speed_m_s: float = knob(
        8.0, 0.0, 60.0, "m/s", "Wind 10 m above the sea; 0: no wind sea, 8: whitecaps begin, 20: a gale", group="waves"
    )
    wind_direction_deg: float = knob(
        70.0, -360.0, 360.0, "deg", "Heading that the wind blows towards at wind_at: 0 north, 90 east", group="waves"
    )
    wind_at: tuple[float, float] = knob(
        (0.0, 0.0),
        unit="deg",
        help="Latitude and longitude for which wind and swell directions are given",
        group="waves",
        widget="place",
    )
    fetch_m: float = knob(
        3e5,
        100.0,
        1e8,
        "m",
        "Way over which the wind has raised the waves; the more, the higher",
        log=True,
        group="waves",
    )
    wave_count: int = knob(
        48,
        1,
        1000,
        "",
        "Waves that wind and swell are made of; without wind and swell there are none",
        cost="each wave costs time where it can be seen",
        group="waves",
    )
    wave_seed: int = knob(1, 0, 2**31 - 1, "", "Which of the many seas of this wind and swell", group="waves")
    choppiness: float = knob(
        1.2,
        0.0,
        2.0,
        "",
        "How sharp crests are: 0 sines, 1 circles as water moves in; never so much that waves fold",
        group="waves",
    )
    swell_height_m: float = knob(
        1.2, 0.0, 30.0, "m", "Height of long waves from far away, from trough to crest (significant)", group="waves"
    )
    swell_period_s: float = knob(
        11.0, 1.0, 60.0, "s", "Time between its crests; 11 s: 190 m from crest to crest in deep water", group="waves"
    )
    swell_direction_deg: float = knob(
        100.0, -360.0, 360.0, "deg", "Heading that the swell runs towards at wind_at", group="waves"
    )
    gravity_m_s2: float = knob(
        9.81, 0.001, 1e3, "m/s2", "Gravity at the surface: how fast waves run and how high they grow", group="waves"
    )
    waves: tuple[Wave, ...] = knob(
        (),
        0,
        1000,
        "",
        "Waves in place of those of wind and swell; the sum of steepness x amplitude x 2 pi / wavelength is at most 1",
        group="waves",
        check=_not_too_steep,
    )
    method: str = knob(
        "ours",
        help="How waves are laid over the sphere: ours, or as printed; 2018 and 2019 differ with printed_arcs alone",
        choices=("ours", "paper_2018", "paper_2019"),
        group="waves",
    )
    printed_arcs: bool = knob(
        False,
        help="With a paper method: the way from a wave's origin by arccosine (2018) or arcsine (2019) in single "
        "precision, as printed, which breaks; off: both by phases from an anchor, the same picture to the bit",
        group="waves",
    )
    absorption_per_m: Vec3 = knob(
        (0.35, 0.07, 0.03), 0.0, 100.0, "1/m", "How fast water swallows light at 680, 550 and 440 nm", group="water"
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
        0.0,
        0.0,
        1.0,
        "",
        "Slopes beside those of the waves, which widen the glitter: 0.2 is a wind of 7 m/s",
        group="water",
    )
    ice_latitude_deg: float = knob(
        90.0, 0.0, 90.0, "deg", "From here to the poles the sea is frozen; 90: nowhere", group="ice"
    )
    ice_albedo: Vec3 = knob(
        (0.62, 0.66, 0.70), 0.0, 1.0, "", "Share of light that sea ice throws back", group="ice", widget="color"
    )
    refractive_index: float = knob(
        1.333,
        1.0,
        4.0,
        "",
        "Of the liquid over the air: 1.333 water, 1.27 methane; bends and mirrors light",
        group="water",
    )
    foam: float = knob(1.0, 0.0, 4.0, "", "How much foam stands on breaking crests; 0: none", group="foam")
    foam_albedo: Vec3 = knob(
        (0.6, 0.6, 0.6), 0.0, 1.0, "", "Share of light that foam throws back", group="foam", widget="color"
    )
    surf_m: float = knob(
        0.3,
        0.0,
        10.0,
        "m",
        "How high waves run up a beach: surf, foam along the shore and the wet band of the land; 0: a still shore",
        group="foam",
    )
    caustics: float = knob(
        1.0, 0.0, 2.0, "", "Contrast of the bright lines that waves gather on a shallow bed; 0: none", group="water"
    )
    bed_detail: float = knob(
        1.0, 0.0, 2.0, "", "Contrast of sand, stones and weed on the bed as seen through the water", group="water"
    )
    glow: Vec3 = knob(
        (0.0, 0.0, 0.0),
        0.0,
        1e6,
        "W m^-2 sr^-1 nm^-1",
        "Light that the liquid gives off by itself, as lava does",
        group="water",
    )
    crust: float = knob(0.0, 0.0, 1.0, "", "Share of a glowing liquid that dark crust covers", group="water")
