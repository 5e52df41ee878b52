"""Quality knobs: what trades run time against error, apart from what the scene is. Values per preset are in TOML."""

from __future__ import annotations

from dataclasses import dataclass

from ._knob import knob

__all__ = [
    "AtmosphereQuality",
    "CloudQuality",
    "CompositeQuality",
    "CoverQuality",
    "LightQuality",
    "MemoryQuality",
    "OceanQuality",
    "ProxyQuality",
    "ShadowQuality",
    "SkyQuality",
    "TerrainQuality",
]


@dataclass
class TerrainQuality:
    """Keys "terrain.*"."""

    edge_px: float = knob(
        12.5,
        1.0,
        64.0,
        "px",
        "Longest edge of a triangle on the screen, at the centre of the picture; most are half to all of it",
        cost="vertices grow with the inverse square",
        log=True,
    )
    quads: int = knob(
        16,
        4,
        64,
        "",
        "Quads along a cell's side; a power of two",
        cost="larger cells are fewer draws but cull less tightly",
        power_of_two=True,
    )
    decimation: int = knob(
        3,
        0,
        3,
        "",
        "Where ground is seen at a flat angle, cells leave out vertices along the view: every 2^this is kept at least",
        cost="a higher value is cheaper",
    )
    min_spacing_m: float = knob(
        0.03,
        0.005,
        100.0,
        "m",
        "The grid is never finer than this; the normals go on below it",
        cost="vertices near the camera, close to the ground",
        log=True,
    )
    sharpness: float = knob(
        1.0,
        0.0,
        1.0,
        "",
        "How sharp the ground's details stay where it is seen at a flat angle; 0: blurred along and across alike. 1"
        " counts on anti-aliasing to average what a pixel covers along the view",
        cost="more layers a pixel at flat angles",
    )
    coast_px: int = knob(
        1,
        1,
        4,
        "px",
        "Along coasts the ground's height is asked at every so many pixels; a power of two",
        cost="grows with the inverse square, where many coasts are seen",
        power_of_two=True,
    )
    shade_every: int = knob(
        1,
        1,
        4,
        "px",
        "One of so many pixels is shaded: each, every second as on a checkerboard (of a still picture each), or one of "
        "each block of 2 x 2; those between are interpolated, outlines stay sharp",
        cost="grows with its inverse",
        power_of_two=True,
    )
    fade_s: float = knob(
        0.3,
        0.0,
        0.3,
        "s",
        "For how long the ground moves after a snap of the grid; 0: it jumps by a fraction of a pixel",
        cost="a snap takes longer, and memory for a second grid",
    )
    paper_grid: int = knob(
        100,
        50,
        200,
        "",
        "Points along a side of the projected grid of Terrain.method paper: the source has 50, 100 and 200",
        cost="patches to cut, cull and draw",
    )
    paper_warp: int = knob(
        4,
        2,
        4,
        "",
        "Power of that grid's warp to a hemisphere, 2 or 4; 4 is the source's choice",
        power_of_two=True,
    )
    paper_layers: int = knob(
        5,
        0,
        10,
        "",
        "Layers of simplex noise on the continents of Terrain.method paper; the source shows 0, 1, 5 and 10",
        cost="time of the vertices at a snap",
    )
    error_px: float = knob(
        1.5,
        0.05,
        16.0,
        "px",
        "Backends quadtree and icosphere: how far the drawn ground may be from the true one, as measured tile by tile",
        cost="tiles grow with the inverse",
        log=True,
    )
    tile_quads: int = knob(
        16,
        16,
        64,
        "",
        "Backends quadtree and icosphere: segments along a tile's side; a power of two",
        cost="larger tiles are fewer draws, but split less finely",
        power_of_two=True,
    )
    slots: int = knob(
        4096,
        1024,
        16384,
        "",
        "Backends quadtree and icosphere: tiles that are kept",
        cost="memory: 10 kB each with 16 segments a side",
        log=True,
    )
    budget_ms: float = knob(
        4.0,
        0.1,
        1000.0,
        "ms",
        "Backends quadtree and icosphere: time a frame for tiles that are wanted and not there",
        cost="itself, while flying",
        log=True,
    )


@dataclass
class ProxyQuality:
    """Keys "proxy.*"."""

    fraction: float = knob(
        0.25,
        0.02,
        0.5,
        "",
        "How far the camera may move before the grid is made anew, as a share of its height above the ground",
        cost="smaller: snaps more often; larger: the grid has to cover more",
    )
    ahead_frames: int = knob(
        16,
        0,
        60,
        "",
        "Over how many frames at most the next grid is prepared while the last one is drawn; 0: in one, which takes "
        "several times as long as others",
        cost="memory for a second grid; in a fast flight triangles are for some frames up to twice as long as wanted",
    )


@dataclass
class SkyQuality:
    """Keys "sky.*"."""

    radiance_format: str = knob(
        "rgba32f",
        help="How radiance is stored before exposure: 16 bits keep 3 digits, 32 bits 7",
        cost="32 bits are twice the memory to write and read",
        choices=("rgba16f", "rgba32f"),
    )


@dataclass
class LightQuality:
    """Keys "light.*"."""

    wavelengths: str = knob(
        "display",
        help="At which wavelengths light is carried, and radiance given out: those that displays show best, 610, 550 "
        "and 440 nm, or those at which numbers are given, 680, 550 and 440 nm, by which reds are less true",
        choices=("display", "given"),
    )


@dataclass
class CompositeQuality:
    """Keys "composite.*"."""

    samples: int = knob(
        33,
        1,
        256,
        "",
        "Samples in a pixel that a picture gathers while the camera stands still, with temporal anti-aliasing",
        cost="frames until a picture has settled",
    )


@dataclass
class AtmosphereQuality:
    """Keys "atmosphere.*"."""

    columns: int = knob(
        24,
        8,
        128,
        "",
        "Azimuths of the air's tables around the camera, from towards the sun to away from it",
        cost="time to fill the tables when the camera's height changes",
    )
    rows: int = knob(
        48,
        8,
        256,
        "",
        "Rows of the air's tables on either side of the horizon, densest next to it",
        cost="as columns",
    )
    slices: int = knob(
        16,
        4,
        64,
        "",
        "Slices of each ray through the air; two points of the air are looked at in each",
        cost="as columns, and memory",
    )
    altitudes: int = knob(
        32,
        8,
        96,
        "",
        "Altitudes in the tables that hold for all cameras",
        cost="time to compute them after a change of the air",
    )
    sun_heights: int = knob(48, 8, 256, "", "Heights of the sun in those tables", cost="as altitudes")
    directions: int = knob(
        8,
        4,
        15,
        "",
        "Azimuths that light is gathered from in half a circle; heights and the first order in proportion",
        cost="as altitudes, with its square",
    )
    march: int = knob(8, 4, 32, "", "Slices of each ray that light is gathered along", cost="as altitudes")
    degree: int = knob(
        2,
        2,
        4,
        "",
        "Degree of the spherical harmonics of scattered light: 2 is exact for gas, haze gains from 4",
        cost="half as much again for each",
    )
    orders: int = knob(
        6,
        1,
        16,
        "",
        "Orders of scattering from which the sum of all is estimated; thick air takes up to twice as many",
        cost="as altitudes",
    )
    paper_scale: float = knob(
        1.0,
        0.1,
        2.0,
        "",
        "Size of the tables of Atmosphere.method paper, times that of the source in every direction but one",
        cost="time to compute them, with its cube; half a minute without a GPU at 1",
    )
    budget_ms: float = knob(
        2.0, 0.1, 1000.0, "ms", "Time a frame for the tables while the air changes", cost="itself", log=True
    )


@dataclass
class OceanQuality:
    """Keys "ocean.*"."""

    reflections: int = knob(
        16,
        0,
        64,
        "",
        "Steps in which the sea looks for ground of the picture to mirror; 0: it mirrors the sky alone",
        cost="steps for each pixel of the sea, where ground is in the picture",
    )
    footprint_px: float = knob(
        1.0,
        0.25,
        64.0,
        "px",
        "What a pixel counts as when waves too short for it become roughness: none shorter than two of these is drawn",
        cost="the smaller, the more waves for each pixel",
        log=True,
    )
    shade_every: int = knob(
        1,
        1,
        4,
        "px",
        "As terrain.shade_every, for the sea",
        cost="grows with its inverse",
        power_of_two=True,
    )
    ripples: bool = knob(
        True,
        help="Waves too short to be among the sea's own, drawn near the camera as octaves of noise",
        cost="an octave for each factor of two, near the camera",
    )


@dataclass
class ShadowQuality:
    """Keys "shadows.*"."""

    size: int = knob(
        256,
        64,
        1024,
        "",
        "Texels a side of each level of the map of shadows; small pictures take fewer, 0.71 a row",
        cost="time to fill and sweep it, and memory, with its square",
    )
    finest_m: float = knob(
        0.5,
        0.05,
        1000.0,
        "m",
        "Texels of that map are never finer than this",
        cost="levels near the ground",
        log=True,
    )
    texels_per_pixel: float = knob(
        0.75,
        0.1,
        4.0,
        "",
        "Texels across a pixel below which finer levels are left out",
        cost="levels, far above the ground",
        log=True,
    )
    levels_per_frame: int = knob(
        2,
        1,
        20,
        "",
        "Levels that are filled from nothing, or swept for a new place of the sun, in one frame",
        cost="time of frames in which the camera comes near the ground, or the sun moves",
    )


@dataclass
class CoverQuality:
    """Keys "cover.*"."""

    reach_m: float = knob(
        350.0,
        20.0,
        2000.0,
        "m",
        "How far trees stand as solids; beyond, forests are a colour of the ground",
        cost="trees to make and draw, with its square",
        log=True,
    )
    shadow_texels: int = knob(
        1024,
        64,
        4096,
        "",
        "Side of the map of their shadows, which reaches as far as they do, and no farther than 600 m",
        cost="memory, and time when trees come or go, with its square",
        power_of_two=True,
    )
    shadows: bool = knob(
        True, help="Trees shade the ground and one another", cost="the map, and a look into it a pixel"
    )
    blades: int = knob(
        6,
        1,
        16,
        "",
        "Three for two tufts of grass in 25 cm x 25 cm of meadow; few have wider ones",
        cost="light on grass",
    )
    crowns: int = knob(
        6, 0, 16, "", "Slabs of a forest that a ray is followed through where trees are no solids; 0: a colour alone",
        cost="light on forests",
    )  # fmt: skip
    light_every: int = knob(
        2,
        1,
        4,
        "px",
        "Skylight and air on trees are found once for so many pixels side by side, the sun's beam for each",
        cost="light on trees: grows with its inverse, by halves",
        power_of_two=True,
    )


@dataclass
class CloudQuality:
    """Keys "clouds.*"."""

    steps: int = knob(
        24,
        2,
        256,
        "",
        "Steps through each crossing of a homogeneous layer; two points are looked at in each",
        cost="time of the march grows with it",
    )
    air_steps: int = knob(
        12,
        2,
        256,
        "",
        "Steps through the air above, between and below the layers, where it is marched with them",
        cost="as steps",
    )
    deepest: float = knob(
        12.0,
        1.0,
        80.0,
        "",
        "Optical depth at which a march ends: exp(-12) is a hundredth of what a picture of 8 bits shows",
        cost="time in thick cloud",
    )
    picture_px: int = knob(
        1,
        1,
        2,
        "px",
        "Clouds have a picture of their own; each of its pixels is so many of the frame's a side, and those between are"
        " interpolated on their own surface",
        cost="grows with the inverse square",
    )
    stride: int = knob(
        2,
        1,
        8,
        "px",
        "One ray through the clouds for a block of so many pixels of their picture a side",
        cost="inverse square",
    )
    march_every: int = knob(
        1,
        1,
        2,
        "",
        "Every so manieth of those blocks has a ray in a frame while something moves: each, or every second as on a"
        " checkerboard; those between are interpolated. Blocks of one pixel have theirs each",
        cost="grows with its inverse",
    )
    samples: int = knob(
        33,
        1,
        256,
        "",
        "Frames whose rays a picture gathers while the camera stands still; at least one for each pixel of a block",
        cost="frames until a picture has settled",
    )
    fine_steps: int = knob(
        96,
        8,
        4096,
        "",
        "Steps through the thickness of a layer where there is cloud; the clear takes four times longer ones",
        cost="grows with it",
        log=True,
    )
    step_growth: float = knob(
        0.003, 1e-4, 0.1, "", "Far away a step is this share of the distance", cost="grows with its inverse", log=True
    )
    sun_steps: int = knob(4, 1, 64, "", "Steps from a place in a cloud towards the sun", cost="half of all time with 4")
    shape_texels: int = knob(
        128, 32, 256, "", "Texels a side of the volume of the clouds' shape", cost="memory", power_of_two=True
    )
    paper_depth: float = knob(
        0.0,
        0.0,
        100.0,
        "",
        "Optical depth straight up through the deep ones of the printed methods' clouds, more than nine in ten; 0: as "
        "their extinction gives it. Light scattered once leaves deep clouds black",
    )
    fibre_texels: int = knob(
        2048, 64, 8192, "", "Texels a side of the map of the trails of ice in cirrus", cost="memory", power_of_two=True
    )
    rim_texels: int = knob(
        64, 16, 256, "", "Texels a side of the volume of the clouds' rims", cost="memory", power_of_two=True
    )
    shadow_texels: int = knob(
        256, 32, 1024, "", "Texels a side of each map of the clouds' shadow", cost="its square", power_of_two=True
    )
    shadow_steps: int = knob(8, 1, 64, "", "Steps through a layer for a texel of those maps", cost="itself")
    shadow_frames: int = knob(
        8,
        1,
        60,
        "",
        "Over how many frames one of those maps is drawn while the last one is shown, on average: fine ones take more, "
        "coarse ones fewer; 1: in one, which takes several times as long as others",
        cost="shadows of clouds follow camera, sun and wind by so many frames later",
    )
    shaft_steps: int = knob(
        8, 0, 1024, "", "Steps through the air in the clouds' shadow; 0: no shafts of light", cost="grows with it"
    )
    map_texels: int = knob(
        1024,
        256,
        4096,
        "",
        "Texels a side of the map of weather",
        cost="time to make it, every quarter of an hour of weather, and memory",
        power_of_two=True,
    )


@dataclass
class MemoryQuality:
    """Keys "memory.*"."""

    budget_mib: int = knob(
        0,
        0,
        65536,
        "MiB",
        "GPU memory that a renderer may take; other knobs give way until it fits. 0: as much as they ask for",
        cost="below what the quality takes: fewer tiles kept, coarser maps; see docs/tweaking.md",
    )
