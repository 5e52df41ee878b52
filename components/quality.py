"""Quality knobs: what trades run time against error, apart from what the scene is. Values per preset are in TOML."""

from __future__ import annotations

from dataclasses import dataclass

from ._knob import knob

__all__ = ["ProxyQuality", "SkyQuality", "TerrainQuality"]


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


@dataclass
class SkyQuality:
    """Keys "sky.*"."""

    radiance_format: str = knob(
        "rgba32f",
        help="How radiance is stored before exposure: 16 bits keep 3 digits, 32 bits 7",
        cost="32 bits are twice the memory to write and read",
        choices=("rgba16f", "rgba32f"),
    )
