"""The rays of a picture's pixels."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["pixel_rays"]


def pixel_rays(camera: Any, size: tuple[int, int]) -> NDArray[np.float64]:
    """(N, 3) unit directions of pixels, row by row from the bottom. camera: a CameraState; size: columns, rows."""
    across = camera.tan_left + (np.arange(size[0]) + 0.5) / size[0] * (camera.tan_right - camera.tan_left)
    upward = camera.tan_bottom + (np.arange(size[1]) + 0.5) / size[1] * (camera.tan_top - camera.tan_bottom)
    ways = camera.forward + upward[:, None, None] * camera.up + across[None, :, None] * camera.right
    return (ways / np.linalg.norm(ways, axis=2, keepdims=True)).reshape(-1, 3)
