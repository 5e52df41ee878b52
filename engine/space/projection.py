"""Between points, pixels and rays, in float64; and the near plane. Row 0 of a picture is its top."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .camera import CameraState
from .errors import SpaceError

Floats = NDArray[np.float64]

NEAR_FRACTION = 0.2
NEAREST_M = 1e-3
FARTHEST_NEAR_M = 0.1


def near_plane_m(clearance_m: float) -> float:
    """The near plane for a clearance to ground and water: a fifth of it, between 1 mm and 0.1 m (NaN: 1 mm)."""
    if math.isnan(clearance_m):
        return NEAREST_M
    return float(min(max(NEAR_FRACTION * clearance_m, NEAREST_M), FARTHEST_NEAR_M))


def projection_terms(camera: CameraState) -> tuple[float, float, float, float]:
    """(sx, sy, ox, oy) with x_ndc = (x / z - ox) / sx and y_ndc = (y / z - oy) / sy, x right, y up, z forward."""
    return (
        (camera.tan_right - camera.tan_left) / 2,
        (camera.tan_top - camera.tan_bottom) / 2,
        (camera.tan_right + camera.tan_left) / 2,
        (camera.tan_top + camera.tan_bottom) / 2,
    )


def project(camera: CameraState, points_m: ArrayLike, size: tuple[int, int]) -> tuple[Floats, NDArray[np.bool_]]:
    """Pixels (N, 2) of planet-centred points (N, 3), and which are in front of the camera, (N,).

    Pixel (i, j) has its middle at (i + 0.5, j + 0.5). Points that are not in front have NaN pixels; points beside the
    picture have pixels outside of it.
    """
    width, height = _checked(size)
    points = np.asarray(points_m, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise SpaceError(f"project: points_m must have the shape (N, 3), found {points.shape}")
    local = (points - camera.position_m) @ camera.axes.T
    in_front = local[:, 2] > 0.0
    depth = np.where(in_front, local[:, 2], np.nan)
    sx, sy, ox, oy = projection_terms(camera)
    x = (local[:, 0] / depth - ox) / sx
    y = (local[:, 1] / depth - oy) / sy
    return np.stack([(0.5 + 0.5 * x) * width, (0.5 - 0.5 * y) * height], axis=1), in_front


def pixel_rays(camera: CameraState, size: tuple[int, int], pixels: ArrayLike | None = None) -> Floats:
    """Unit directions through the middles of all pixels, (H, W, 3), or through given pixel positions (N, 2), (N, 3)."""
    width, height = _checked(size)
    if pixels is None:
        columns, rows = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    else:
        columns, rows = np.moveaxis(np.asarray(pixels, dtype=np.float64), -1, 0)
    sx, sy, ox, oy = projection_terms(camera)
    x = (2.0 * columns / width - 1.0) * sx + ox
    y = (1.0 - 2.0 * rows / height) * sy + oy
    rays = camera.forward + x[..., None] * camera.right + y[..., None] * camera.up
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def _checked(size: tuple[int, int]) -> tuple[int, int]:
    width, height = size
    if width < 1 or height < 1:
        raise SpaceError(f"size: expected a width and height of at least 1 pixel, found {size!r}")
    return width, height
