"""Where the water stands at the camera: a plane for the pixels whose near plane the surface cuts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import Vec3
from ...engine.space import CameraState, length
from ...engine.surface.field import HeightField
from ...engine.waves import WaveSet, at_directions, surface

__all__ = ["FAR_M", "LENS_REACH_M", "LensPlane", "lens_plane", "wet_rows"]

LENS_REACH_M = 0.3
"""No point of the near plane is farther from the camera."""
FAR_M = 1.0e9
"""Stands for the height of a camera that no wave can reach: no rounding changes a pixel's side."""
_EDGE_PX = 62.0
"""WATERLINE_PX of common/lens_edge.glsl, and room for a picture that is jittered by part of a pixel."""


@dataclass
class LensPlane:
    """The sea's surface at the camera as a plane."""

    normal: Vec3
    """unit, planet axes"""
    height_m: float
    """the camera's over the water, along the normal; +-FAR_M out of the waves' reach"""


def lens_plane(
    waves: WaveSet,
    highest_m: float,
    position_m: NDArray[np.float64],
    time_s: float,
    ground: HeightField | None,
    sea_level_m: float,
) -> LensPlane:
    """The sea's surface at a camera (3,), planet-centred.

    The near plane is 0.3 m wide at most, which waves longer than that cross as planes.
    """
    distance = length(position_m)
    zenith = position_m / distance
    over = distance - waves.radius_m
    if abs(over) > highest_m + LENS_REACH_M:
        x, y, z = zenith.tolist()
        return LensPlane((x, y, z), FAR_M if over > 0.0 else -FAR_M)
    depth_of = None if ground is None else lambda v: sea_level_m - ground.height(v)
    calm, depth, moved = at_directions(waves, zenith[None], np.asarray(time_s), depth_of)
    place = calm[0] * waves.radius_m + moved[0]
    normal = surface(waves, calm, time_s, depth).normal[0]
    return LensPlane(tuple(normal), float(np.dot(position_m - place, normal)))


def wet_rows(lens: LensPlane, camera: CameraState, height: int) -> tuple[int, int]:
    """The rows of a picture of so many, counted from below, that may show water before the lens: first, and past the
    last. Where the near plane lies under `lens` (`lens_plane`), or over it by no more than the edge's pixels.

    On the near plane the height over the water is linear in the pixel: the rows are those of its lowest side.
    """
    normal = np.array(lens.normal)
    right, up, forward = (float(axis.dot(normal)) for axis in (camera.right, camera.up, camera.forward))
    across, tall = (
        max(abs(a), abs(b)) for a, b in ((camera.tan_left, camera.tan_right), (camera.tan_bottom, camera.tan_top))
    )
    pixel = camera.pixel_rad(height)
    reach = _EDGE_PX * pixel * float(np.sqrt(1.0 + across * across + tall * tall))
    # Lens over water at the level of the eye, at the side where the water stands highest: `rest + up * tangent`.
    rest = lens.height_m / camera.near_m + forward + min(camera.tan_left * right, camera.tan_right * right) - reach
    if abs(up) < 1e-9:
        return (0, height) if rest < 1e-6 else (0, 0)
    row = float(np.clip((-rest / up - camera.tan_bottom) / pixel, -2.0, height + 2.0))
    first, end = (0, int(np.ceil(row)) + 1) if up > 0.0 else (int(np.floor(row)) - 1, height)
    return max(first, 0), max(min(end, height), 0)
