"""The four planes of a view, through the camera, for culling in camera-relative space."""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .camera import CameraState

Floats = NDArray[np.float64]


def frustum_planes(camera: CameraState) -> Floats:
    """Inward unit normals (4, 3) of the left, right, bottom and top planes; all pass through the camera.

    A camera-relative point p is in the view's pyramid when all `planes @ p >= 0`. There is no far plane, and the near
    plane is left out: the four meet at the camera, so only points between it and the near plane are kept too many.
    """
    return camera.planes


def sphere_outside(planes: Floats, centers_m: ArrayLike, radii_m: ArrayLike) -> NDArray[np.bool_]:
    """Which spheres (camera-relative centres (N, 3), radii (N,)) lie wholly outside one of the planes."""
    distance = np.asarray(centers_m, dtype=np.float64) @ planes.T
    outside: NDArray[np.bool_] = np.any(distance < -np.asarray(radii_m, dtype=np.float64)[..., None], axis=-1)
    return outside


def out_of_view(camera: CameraState, center_m: ArrayLike, radius_m: float) -> bool:
    """Whether a sphere (camera-relative centre (3,)) lies outside a plane of the view or behind the camera."""
    # Number by number: a frame asks this of a few spheres, and `planes` takes numpy longer than all of them.
    x, y, z = (camera.axes @ np.asarray(center_m, dtype=np.float64)).tolist()
    nearest = min(
        (x - camera.tan_left * z) / math.hypot(1.0, camera.tan_left),
        (camera.tan_right * z - x) / math.hypot(1.0, camera.tan_right),
        (y - camera.tan_bottom * z) / math.hypot(1.0, camera.tan_bottom),
        (camera.tan_top * z - y) / math.hypot(1.0, camera.tan_top),
        z,
    )
    return nearest < -radius_m
