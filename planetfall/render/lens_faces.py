"""Which pinhole pictures a lens's picture is made from, and where in them each of its pixels looks.

One picture where it would not reach far to the sides, else faces of a cube around the camera, of which only the part
that is looked at is drawn. Their pixels are as fine as those of the lens, wherever that is no finer than twice what
its focal length says.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ..camera.intrinsics import Intrinsics
from ..camera.place import Face
from ..errors import CameraError

__all__ = ["FacePixels", "LensFaces", "faces_of"]

Floats = NDArray[np.float64]

_WIDEST_TANGENT = 1.75
"""60 degrees to a side: a single picture has four times the pixels there that it has in its middle."""
_MARGIN_PX = 24
"""Around each face: glare, smoothing and resampling look at their neighbours."""
_MOST_DETAIL = 2.0

# Rows right, down, forward in OpenCV's camera axes: ahead, right, left, down, up, back.
_CUBE = np.array(
    [
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
    ],
    np.float64,
)
_Y_UP = np.array([1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False)
class FacePixels:
    """A face, and the pixels of the lens's picture that are taken from it.

    pixels: (N,) their flat indices. x, y: (N,) f32, where they look in the face, in its pixels. spread: (N,) f32,
    pixels of the face to the next one of the lens. focal_px: (fx, fy) of the face; middle_px: where its axis is.
    """

    face: Face
    pixels: NDArray[np.intp]
    x: NDArray[np.float32]
    y: NDArray[np.float32]
    spread: NDArray[np.float32]
    focal_px: tuple[float, float]
    middle_px: tuple[float, float]


@dataclass(frozen=True, eq=False)
class LensFaces:
    """What a lens's picture is made from. faces: those that are looked at, the one with most pixels first. rays: (H, W,
    3) f32, of the pixels, in the axes of Intrinsics; NaN where there is none. seen: (H, W), where there is one."""

    faces: tuple[FacePixels, ...]
    rays: NDArray[np.float32]
    seen: NDArray[np.bool_]


@lru_cache(maxsize=4)
def faces_of(lens: Intrinsics) -> LensFaces:
    """For a lens; kept for the last few. CameraError for one that nothing is seen through."""
    rays = lens.rays()
    valid = np.isfinite(rays[..., 0])
    if not valid.any():
        raise CameraError(
            f"Intrinsics: no pixel of {lens.width} x {lens.height} has a ray: expected a principal point near the "
            f"picture and distortion that it can be undone for, found {lens}"
        )
    ahead = rays[valid]
    flat = bool((ahead[:, 2] > 0.0).all()) and float((np.abs(ahead[:, :2]) / ahead[:, 2:]).max()) <= _WIDEST_TANGENT
    cube = _CUBE[:1] if flat else _CUBE
    side = np.argmax(np.where(valid[..., None], rays, 0.0) @ cube[:, 2].T, axis=2)
    focal = np.array((lens.fx, lens.fy) if flat else (max(lens.fx, lens.fy),) * 2)
    step = _steps(rays, cube, side, focal)
    detail = float(np.clip(1.0 / np.percentile(step[valid], 1.0), 1.0, _MOST_DETAIL))
    focal, spread, side = focal * detail, step[valid] * detail, side[valid]
    there = np.flatnonzero(valid)
    # The middle of the picture then meets the centres of the face's pixels.
    phase = (lens.cx + 0.5) % 1.0, (lens.cy + 0.5) % 1.0
    found = [
        _face(axes, there[side == k], ahead[side == k], spread[side == k], focal, phase)
        for k, axes in enumerate(cube)
        if (side == k).any()
    ]
    faces = tuple(sorted(found, key=lambda face: -face.pixels.size))
    return LensFaces(faces, rays.astype(np.float32), valid)


def _face(
    axes: Floats,
    pixels: NDArray[np.intp],
    rays: Floats,
    spread: Floats,
    focal: Floats,
    phase: tuple[float, float],
) -> FacePixels:
    local = rays @ axes.T
    position, first, count = [], [], []
    for k in range(2):
        at = focal[k] * local[:, k] / local[:, 2] + phase[k]
        start = int(np.floor(at.min())) - _MARGIN_PX
        position.append(at - start)
        first.append(start - phase[k])
        count.append(int(np.ceil(at.max())) + _MARGIN_PX - start)
    left, top = (float(first[k] / focal[k]) for k in range(2))
    right, bottom = (float((first[k] + count[k]) / focal[k]) for k in range(2))
    x, y, wide = (part.astype(np.float32) for part in (*position, spread))
    turn = axes * _Y_UP * _Y_UP[:, None]
    face = Face(turn, (left, right, -bottom, -top), (count[0], count[1]))
    return FacePixels(face, pixels, x, y, wide, (float(focal[0]), float(focal[1])), (-first[0], -first[1]))


def _steps(rays: Floats, cube: Floats, side: NDArray[np.intp], focal: Floats) -> Floats:
    """(H, W): from each pixel to the next, along its row or its column, whichever is farther, in pixels of its face.

    side: (H, W), which face of the cube. The rows of a panorama shrink to a point at the poles; their columns don't.
    """

    def place(of: Floats) -> Floats:
        right, down, forward = ((of * cube[side, k]).sum(axis=2) for k in range(3))
        return np.stack([right, down], axis=2) / forward[..., None] * focal

    here, steps = place(rays), np.zeros(rays.shape[:2])
    for axis in (0, 1):
        count = rays.shape[axis]
        if count > 1:
            beside = np.minimum(np.arange(count) + 1, count - 1)
            beside[-1] = count - 2
            steps = np.fmax(steps, np.linalg.norm(place(rays.take(beside, axis)) - here, axis=2))
    return np.where(steps > 0.0, steps, 1.0)
