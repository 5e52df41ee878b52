"""Where the water stands at the camera: a plane for the pixels whose near plane the surface cuts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ...engine.space import length
from ...engine.surface.field import HeightField
from ...engine.waves import WaveSet, at_directions, surface

__all__ = ["FAR_M", "LENS_REACH_M", "lens_plane"]

LENS_REACH_M = 0.3
"""No point of the near plane is farther from the camera."""
FAR_M = 1.0e9
"""Stands for the height of a camera that no wave can reach: no rounding changes a pixel's side."""


def lens_plane(
    waves: WaveSet,
    highest_m: float,
    position_m: NDArray[np.float64],
    time_s: float,
    ground: HeightField | None,
    sea_level_m: float,
) -> tuple[float, float, float, float]:
    """The sea's surface at a camera (3,), planet-centred: its unit normal in planet axes, and the camera's height over
    it in metres, along that normal; +-FAR_M out of the waves' reach.

    The near plane is 0.3 m wide at most, which waves longer than that cross as planes.
    """
    distance = length(position_m)
    zenith = position_m / distance
    over = distance - waves.radius_m
    if abs(over) > highest_m + LENS_REACH_M:
        x, y, z = zenith.tolist()
        return (x, y, z, FAR_M if over > 0.0 else -FAR_M)
    depth_of = None if ground is None else lambda v: sea_level_m - ground.height(v)
    calm, depth, moved = at_directions(waves, zenith[None], np.asarray(time_s), depth_of)
    place = calm[0] * waves.radius_m + moved[0]
    normal = surface(waves, calm, time_s, depth).normal[0]
    return (*normal, float(np.dot(position_m - place, normal)))
