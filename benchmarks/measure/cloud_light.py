"""Weather clouds: what the way to the sun costs in error, and how opaque the same clouds are from near and far."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Atmosphere, Camera, Clouds, Renderer, Sun
from ...render.outputs import read_texture
from .cloud_pictures import scene_of_weather

__all__ = ["REGION_M", "SHOTS", "opacity", "sun_depth_error"]

SHOTS: Sequence[tuple[str, float, float, float]] = (
    ("ground", 100.0, 5.0, 45.0),
    ("ground", 100.0, 5.0, 10.0),
    ("8 km", 8e3, -10.0, 30.0),
    ("400 km", 4e5, -40.0, 20.0),
)
"""View, its altitude and pitch, and the sun's height in degrees."""
REGION_M = 120e3
_ABOVE_M = 1e6
_PLACES = (
    (20.0, 10.0),
    (-5.0, 80.0),
    (48.0, -30.0),
    (-40.0, 150.0),
    (60.0, 100.0),
    (5.0, -120.0),
    (-25.0, -60.0),
    (33.0, -150.0),
)
_ALONE: dict[str, Any] = {"clouds.stride": 1, "composite.antialiasing": "none"}


def sun_depth_error(
    quality: str, shots: Sequence[tuple[str, float, float, float]], size: tuple[int, int]
) -> list[float]:
    """For each shot: error of the light of clouds with the quality's steps to the sun and maps of the shadow, against
    48 steps through every layer: rms over the mean of what is there. No air, one ray a pixel."""
    found: list[list[NDArray[np.float64]]] = []
    for to_sun in ({}, {"clouds.sun_steps": 48}):
        scene = scene_of_weather()
        scene.planet.remove(Atmosphere)
        with Renderer(scene, size, quality, {**_ALONE, **to_sun}) as renderer:
            found.append([_light(renderer, *shot[1:]) for shot in shots])
    return [float(np.sqrt(((a - b) ** 2).mean()) / b.mean()) for a, b in zip(*found, strict=True)]


def _light(renderer: Renderer, altitude_m: float, pitch_deg: float, sun_deg: float) -> NDArray[np.float64]:
    camera = Camera.at(20.0, 10.0, altitude_m, heading_deg=30.0, pitch_deg=pitch_deg)
    sun = Sun(elevation_deg=sun_deg, azimuth_deg=150.0, latitude_deg=20.0, longitude_deg=10.0)
    renderer.render(camera, sun=sun)
    return read_texture(renderer.graph.resource("clouds.rays"))[..., :3].astype(np.float64)


def opacity(
    extinction_per_m: float, pixels: Sequence[int], regions: int, quality: str = "medium"
) -> list[float]:  # fmt: skip
    """Mean opacity of regions of 120 km, seen from 1000 km straight above, for pictures of so many pixels a side."""
    scene = scene_of_weather()
    scene.planet[Clouds].extinction_per_m = extinction_per_m
    scene.planet[Clouds].layers = ()
    fov = 2.0 * math.degrees(math.atan(0.5 * REGION_M / _ABOVE_M))
    found = []
    for side in pixels:
        with Renderer(scene, (side, side), quality, _ALONE) as renderer:
            hides = []
            for latitude, longitude in _PLACES[:regions]:
                renderer.render(Camera.at(latitude, longitude, _ABOVE_M, pitch_deg=-90.0, fov_y_deg=fov))
                hides.append(1.0 - read_texture(renderer.graph.resource("clouds.full"))[..., 3].mean())
        found.append(float(np.mean(hides)))
    return found
