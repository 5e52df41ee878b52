"""Terrain: the solid ground, its shape and what it is made of."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from dataclasses import dataclass

from ._knob import Vec3, knob

__all__ = ["Terrain"]


@dataclass
class Terrain:
    """Procedural ground between lowest_m and highest_m above the reference sphere. Equal values give equal ground.

    Albedos are colours, linear sRGB: what shows in sunlight outside the air, where white paper shows (1, 1, 1).
    """

    seed: int = knob(1, 0, 2**31 - 1, "", "Which of the many planets of this shape")
    highest_m: float = knob(9000.0, -2e4, 1e5, "m", "No ground is higher than this above the reference sphere")
    lowest_m: float = knob(-9000.0, -1e5, 2e4, "m", "No ground is lower than this; negative is below the sphere")
    layers: int = knob(
        16, 1, 16, "", "How many layers of noise, from continents to pebbles", cost="time grows with each layer"
    )
    backend: str = knob(
        "grid",
        help="How the ground is cut into triangles",
        choices=("grid", "quadtree", "icosphere"),
    )
    method: str = knob(
        "ours",
        help="ours, or the backend's source as it was written",
        choices=("ours", "paper"),
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
    hills: float = knob(
        1.0,
        0.0,
        1.0,
        "",
        "1: flat plains, hill country and high ranges along coasts; 0: all that gently rolling",
        group="shape",
    )
    roughness: float = knob(
        1.0, 0.0, 8.0, "", "Steepness of everything smaller than a mountain range; 1 as on Earth's land", group="shape"
    )
    warp: float = knob(1.0, 0.0, 2.0, "", "How far continents and ranges are bent out of their shape", group="shape")
    craters: float = knob(
        0.0,
        0.0,
        1.0,
        "",
        "How densely impact craters lie; 1: as on the oldest ground of airless worlds, 0: none",
        cost="each octave of craters costs as much as two layers; 0 costs nothing",
        group="craters",
    )
    crater_largest_m: float = knob(
        2.5e5,
        1.0,
        2e6,
        "m",
        "Diameter of the largest craters, at most the planet's radius",
        log=True,
        group="craters",
    )

    erosion: float = knob(
        0.0,
        0.0,
        1.0,
        "",
        "How far water has drawn gullies down steep ground, in place of lumps; 0: none",
        cost="a vertex takes 1.5 times as long",
        group="rivers",
    )
    rivers: float = knob(
        0.0,
        0.0,
        1.0,
        "",
        "Water of rivers and lakes, whose valleys carve the ground; 1: what the rain gives, 0: none",
        cost="a vertex takes 1.5 times as long, 40 MB; the first start of a planet solves them for 20 s",
        group="rivers",
    )
    banks: float = knob(
        1.0,
        0.0,
        1.0,
        "",
        "How uneven banks of rivers and lakes are, and how much gravel and mud lies along them; 0: straight, with none",
        group="rivers",
    )
    spray: float = knob(
        1.0,
        0.0,
        3.0,
        "",
        "How much spray hangs about waterfalls; 0: none",
        cost="6 ms at 640 x 360 on two cores before a fall that fills the picture, nothing elsewhere",
        group="rivers",
    )
    drainage_cells: int = knob(
        3_538_944,
        1536,
        14_155_776,
        "",
        "Cells of the planet on which rivers find their way: 12 km wide on Earth, a million of them land",
        cost="time to solve rivers grows with it",
        log=True,
        group="rivers",
    )

    height_map: str = knob(
        "",
        help="Heights: of all around a PNG, EXR or GeoTIFF, or six faces; of some places a folder of tiles",
        cost="16 texture fetches a vertex, 8 bytes a sample",
        group="maps",
        widget="path",
    )
    height_map_range_m: tuple[float, float] | None = knob(
        None, -1e6, 1e6, "m", "Heights of the lowest and the highest value that the height map can hold", group="maps"
    )
    height_map_blend: float = knob(
        0.0,
        0.0,
        1.0,
        "",
        "0: the height map alone makes broad shapes; 1: it adds to the procedural ones",
        group="maps",
    )
    height_map_detail: float = knob(
        1.0, 0.0, 4.0, "", "Roughness of the relief finer than the height map; 1 goes on as the map does", group="maps"
    )
    height_map_most_mb: float = knob(
        256.0,
        1.0,
        900.0,
        "MB",
        "Memory that tiles of elevation may take, here and on the GPU; what is more is read as it is looked at",
        cost="memory, and time to read the tiles",
        log=True,
        group="maps",
    )
    color_map: str = knob(
        "",
        help="Colours of the ground: of all around a PNG or JPEG, or six faces; of some places a folder of tiles",
        cost="8 texture fetches a pixel, of tiles 60; 4 bytes a sample",
        group="maps",
        widget="path",
    )
    color_map_strength: float = knob(
        1.0, 0.0, 1.0, "", "1: the ground's colour is the map's; 0: that of its materials", group="maps"
    )
    color_map_unlit: float = knob(
        0.0,
        0.0,
        1.0,
        "",
        "Share of the sunlight that is taken out of tiles of pictures, by the slopes of the height map there",
        cost="time to read the tiles",
        group="maps",
    )
    color_map_most_mb: float = knob(
        256.0,
        1.0,
        900.0,
        "MB",
        "Memory that tiles of pictures may take, here and on the GPU; what is more is read as it is looked at",
        cost="memory, and time to read the tiles",
        log=True,
        group="maps",
    )

    vector_map: str = knob(
        "",
        help="Lakes, rivers, coasts and forests: a GeoJSON file (RFC 7946)",
        cost="about 0.1 MB for each kilometre of shore, here and on the GPU, and time to make it",
        group="maps",
        widget="path",
    )

    rock_albedo: Vec3 = knob(
        (0.16, 0.145, 0.125), 0.0, 1.0, "", "Share of light that bare rock throws back", group="ground", widget="color"
    )
    strata_albedo: Vec3 = knob(
        (0.235, 0.165, 0.105), 0.0, 1.0, "", "The same of the other layers in the rock", group="ground", widget="color"
    )
    strata: float = knob(1.0, 0.0, 1.0, "", "How clearly layers show in steep rock", group="ground")
    strata_m: float = knob(
        220.0, 1.0, 1e4, "m", "Height from one thick layer of rock to the next", log=True, group="ground"
    )
    dry_albedo: Vec3 = knob(
        (0.43, 0.31, 0.175), 0.0, 1.0, "", "The same of dry soil, desert and dust", group="ground", widget="color"
    )
    sand_albedo: Vec3 = knob(
        (0.42, 0.32, 0.18),
        0.0,
        1.0,
        "",
        "The same of beaches and dunes; dark plains where nothing grows",
        group="ground",
        widget="color",
    )
    snow_albedo: Vec3 = knob(
        (0.80, 0.83, 0.87), 0.0, 1.0, "", "The same of snow and ice", group="ground", widget="color"
    )
    grass_albedo: Vec3 = knob((0.069, 0.103, 0.03), 0.0, 1.0, "", "The same of grass", group="plants", widget="color")
    forest_albedo: Vec3 = knob(
        (0.034, 0.058, 0.022), 0.0, 1.0, "", "The same of forests", group="plants", widget="color"
    )
    tundra_albedo: Vec3 = knob(
        (0.13, 0.115, 0.07), 0.0, 1.0, "", "The same of moss and heath in the cold", group="plants", widget="color"
    )
    plants: float = knob(
        1.0, 0.0, 1.0, "", "Share of suitable ground that plants cover; 0: a bare world", group="plants"
    )
    humidity: float = knob(0.5, -1.0, 2.0, "", "0: deserts everywhere, 1: forests everywhere", group="plants")
    rock_slope_deg: float = knob(18.0, 0.0, 90.0, "deg", "Ground steeper than this is bare rock", group="ground")
    beach_height_m: float = knob(
        4.0, 0.0, 1000.0, "m", "Sand reaches this high above the sea; without a sea it has no effect", group="ground"
    )
    beach_share: float = knob(
        0.6, 0.0, 1.0, "", "Share of the coast that has beaches, in stretches of a kilometre or so", group="ground"
    )
    snow_line_m: float = knob(5200.0, -1e5, 1e6, "m", "Height of the snow line at the equator", group="ground")
    snow_line_pole_m: float = knob(-500.0, -1e5, 1e6, "m", "Height of the snow line at the poles", group="ground")
    season: float | None = knob(
        None, 0.0, 1.0, "", "Time of year: 0 and 1 midwinter of the northern half, when snow lies lower down, 0.5 its "
        "midsummer; the southern half is half a year apart. Trees follow, where Cover.season isn't set; unset: none",
        group="ground",
    )  # fmt: skip
    snow_slope_deg: float = knob(
        24.0, 0.0, 90.0, "deg", "Slopes steeper than this shed most of their snow", group="ground"
    )
    variation: float = knob(1.0, 0.0, 2.0, "", "How much colours vary, from continents to pebbles", group="ground")
    grain: float = knob(1.0, 0.0, 4.0, "", "Height of bumps that are smaller than the smallest layer", group="ground")
    clutter: float = knob(
        1.0,
        0.0,
        1.0,
        "",
        "Stones, tufts, boulders and shrubs that stand on the ground; 0: none",
        cost="pixels near the camera; none where a pixel is wider than 0.4 m",
        group="ground",
    )
    dust_law: float = knob(
        0.0,
        0.0,
        1.0,
        "",
        "0: matt ground (Lambert); 1: dust of airless worlds, whose full disc is flat (McEwen 1991)",
        group="ground",
    )
    shadows: bool = knob(True, help="The ground casts shadows, on itself and on the sea", group="light")
    occlusion: bool = knob(True, help="Ground around a place takes away its share of the sky's light", group="light")
