"""Terrain: the solid ground, its shape and what it is made of."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Terrain"]


@dataclass
class Terrain:
    """Procedural ground between lowest_m and highest_m above the reference sphere. Equal values give equal ground."""

    seed: int = knob(1, 0, 2**31 - 1, "", "Which of the many planets of this shape")
    highest_m: float = knob(9000.0, -2e4, 1e5, "m", "No ground is higher than this above the reference sphere")
    lowest_m: float = knob(-9000.0, -1e5, 2e4, "m", "No ground is lower than this; negative is below the sphere")
    layers: int = knob(
        16, 1, 16, "", "How many layers of noise, from continents to pebbles", cost="time grows with each layer"
    )
    backend: str = knob(
        "grid",
        help="How the ground is cut into triangles",
        choices=("grid",),
        not_yet=("quadtree", "icosphere"),
    )

    land_share: float = knob(
        0.3, 0.02, 0.98, "", "Share of the surface above height 0: the land, where the sea is at 0", group="shape"
    )
    continent_size: float = knob(
        1.0, 0.125, 4.0, "", "Size of continents, in steps of two; 1 gives a handful", log=True, group="shape"
    )
    plains: float = knob(
        1.0,
        0.0,
        1.0,
        "",
        "1: abyss, shelf, coastal plains and plateaus as on Earth; 0: all heights alike",
        group="shape",
    )
    mountains: float = knob(1.0, 0.0, 2.0, "", "Width of the belts of mountain ranges; 0: none", group="shape")
    roughness: float = knob(
        1.0, 0.0, 8.0, "", "Steepness of everything smaller than a mountain range; 1 as on Earth's land", group="shape"
    )
    warp: float = knob(1.0, 0.0, 2.0, "", "How far continents and ranges are bent out of their shape", group="shape")

    rock_albedo: Vec3 = knob(
        (0.13, 0.115, 0.10), 0.0, 1.0, "", "Share of light that bare rock throws back", group="ground", widget="color"
    )
    grass_albedo: Vec3 = knob(
        (0.055, 0.085, 0.025), 0.0, 1.0, "", "The same of flat land: grass, or dust", group="ground", widget="color"
    )
    sand_albedo: Vec3 = knob(
        (0.34, 0.27, 0.17), 0.0, 1.0, "", "The same of beaches and the sea's bed", group="ground", widget="color"
    )
    snow_albedo: Vec3 = knob(
        (0.80, 0.82, 0.85), 0.0, 1.0, "", "The same of snow and ice", group="ground", widget="color"
    )
    rock_slope_deg: float = knob(32.0, 0.0, 90.0, "deg", "Ground steeper than this is bare rock", group="ground")
    beach_height_m: float = knob(
        4.0, 0.0, 1000.0, "m", "Sand reaches this high above the sea; without a sea it has no effect", group="ground"
    )
    snow_line_m: float = knob(5200.0, -1e5, 1e6, "m", "Height of the snow line at the equator", group="ground")
    snow_line_pole_m: float = knob(-500.0, -1e5, 1e6, "m", "Height of the snow line at the poles", group="ground")
