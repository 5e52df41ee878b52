"""How much of a planet is under cloud, seen from straight above."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ... import Camera, Renderer, Scene, Sun, latitude_longitude
from ...render.outputs import read_texture

__all__ = ["Cover", "cover"]

SIZE = (64, 64)
REGION_M = 2.4e6
ABOVE_M = 2e7


@dataclass(frozen=True)
class Cover:
    """Means over the planet: opacity, and shares under cloud that hides more than 0.3 and 0.5 of what is below."""

    opacity: float
    thin: float
    thick: float


def cover(scene: Scene, time_s: float, regions: int, quality: str = "medium") -> Cover:
    """Of so many regions of 2400 km, spread evenly over the sphere (a Fibonacci lattice)."""
    k = np.arange(regions) + 0.5
    z, turn = 1.0 - 2.0 * k / regions, np.pi * (1.0 + 5.0**0.5) * k
    r = np.sqrt(1.0 - z * z)
    ups = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)
    angle_deg = 2.0 * np.degrees(np.arctan(0.5 * REGION_M / ABOVE_M))
    found = []
    with Renderer(scene, SIZE, quality) as renderer:
        for up in ups:
            latitude, longitude = (float(v) for v in latitude_longitude(up))
            camera = Camera.at(latitude, longitude, ABOVE_M, pitch_deg=-90.0, fov_y_deg=angle_deg)
            renderer.render(camera, time_s=time_s, sun=Sun(direction=(float(up[0]), float(up[1]), float(up[2]))))
            hides = 1.0 - read_texture(renderer.graph.resource("clouds.full"))[..., 3]
            found.append((hides.mean(), (hides > 0.3).mean(), (hides > 0.5).mean()))
    return Cover(*(float(v) for v in np.mean(found, axis=0)))
