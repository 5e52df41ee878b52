"""Labels that follow from where a pixel's surface lies: depth, slope and flow, in float64 on the CPU."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..engine.frame.labels import MaterialId
from ..engine.space import CameraState, pixel_rays, project
from ..systems.terrain.material_list import material_ids

__all__ = ["depth_m", "flow_px", "material_names", "slope_deg"]

Pixels = NDArray[np.float32]


def material_names() -> dict[int, str]:
    """Names of the numbers in the output `material`."""
    return {each.value: each.name.lower() for each in MaterialId} | {n: name for name, n in material_ids().items()}


def depth_m(position: NDArray[Any], camera: CameraState) -> Pixels:
    """(H, W) metres along the camera's axis, inf for the sky; position: (H, W, 4), outputs.position."""
    depth = position[..., :3].astype(np.float64) @ camera.forward
    return np.where(np.isfinite(position[..., 3]), depth, np.inf).astype(np.float32)


def slope_deg(position: NDArray[Any], normal: NDArray[Any], camera: CameraState) -> Pixels:
    """(H, W) degrees between the surface's normal and the vertical of its place, NaN for the sky; position, normal:
    (H, W, 4), outputs.position and outputs.normal."""
    zenith = camera.position_m + position[..., :3].astype(np.float64)
    facing = normal[..., :3].astype(np.float64)
    # By sine and cosine: a cosine alone cannot tell small angles apart.
    sine = np.linalg.norm(np.cross(zenith, facing), axis=-1)
    return np.degrees(np.arctan2(sine, (zenith * facing).sum(axis=-1))).astype(np.float32)


def flow_px(moved: NDArray[Any], camera: CameraState, before: CameraState | None, size: tuple[int, int]) -> Pixels:
    """(H, W, 2) pixels right and down, from each pixel to where the camera of the frame before had what it shows.

    moved: (H, W, 4), outputs.moved. The sky counts as infinitely far, fixed to the planet. NaN: behind that camera, not
    there then, or no frame before.
    """
    height, width = moved.shape[:2]
    if before is None:
        return np.full((height, width, 2), np.nan, np.float32)
    there = moved[..., 3] > 0.0
    sky = ~moved[..., :3].any(axis=-1)
    points = camera.position_m + moved[..., :3].astype(np.float64)
    # One metre ahead of the camera before: from there all directions at infinity look the same.
    points[sky] = before.position_m + pixel_rays(camera, size)[sky]
    found, _ = project(before, points.reshape(-1, 3), size)
    columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    flow = found.reshape(height, width, 2) - np.stack([columns, rows], axis=-1)
    flow[~(there | sky)] = np.nan
    return flow.astype(np.float32)
