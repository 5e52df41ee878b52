"""Lens models: from directions in front of a camera to its picture plane and back, as OpenCV defines them, in float64.

Camera axes are OpenCV's: x right, y down, z forward. A plane position is ((u - cx) / fx, (v - cy) / fy), u and v being
OpenCV's pixels. A model is used where it is one-to-one, from the middle of the picture to where it first folds over.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Protocol

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

__all__ = ["COEFFICIENTS", "Lens", "lens_of"]

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

COEFFICIENTS: dict[str, tuple[int, ...]] = {
    "pinhole": (0,),
    "brown": (0, 4, 5),
    "rational": (0, 8, 12, 14),
    "fisheye": (0, 4),
    "equirectangular": (0,),
}
"""Model -> how many coefficients of distortion it may have. 0 where all are zero."""

_EXACT = 1e-13
"""Newton's method has arrived, in plane units: a billionth of a pixel for a focal length of 10 000 pixels."""
_FOUND = 1e-10


class Lens(Protocol):
    """A lens model. Points (N, 3) in camera axes, plane positions (N, 2)."""

    def project(self, points: Floats) -> tuple[Floats, Bools]:
        """Plane positions, NaN for points that it doesn't see, and which it sees (N,)."""
        ...

    def rays(self, plane: Floats) -> Floats:
        """Unit directions (N, 3), NaN where there is none."""
        ...


@lru_cache(maxsize=64)
def lens_of(model: str, distortion: tuple[float, ...], middle_rad: float) -> Lens:
    """middle_rad: longitude of the picture's middle, for a model that goes all around."""
    if model == "fisheye":
        return _Fisheye(distortion)
    return _Equirectangular(middle_rad) if model == "equirectangular" else _Planar(distortion)


class _Planar:
    """pinhole, brown (k1 k2 p1 p2 k3) and rational (further k4 k5 k6, thin prism s1 s2 s3 s4, tilt tau_x tau_y).

    OpenCV, "Camera Calibration and 3D Reconstruction", detailed description. Radius x^2 + y^2 is valid below the first
    place where the radial curve stops to rise, and where the Jacobian's determinant is positive.
    """

    def __init__(self, distortion: tuple[float, ...]) -> None:
        k = np.zeros(14)
        k[: len(distortion)] = distortion
        self._above = Polynomial([1.0, k[0], k[1], k[4]])
        self._below = Polynomial([1.0, k[5], k[6], k[7]])
        self._k = k
        above, below = self._above, self._below
        slope = above * below + Polynomial([0.0, 2.0]) * (above.deriv() * below - above * below.deriv())
        self._largest_r2 = min(_first_root(slope), _first_root(below))
        self._tilt = _tilt(k[12], k[13])
        self._untilt = np.asarray(np.linalg.inv(self._tilt), np.float64)

    def _distorted(self, x: Floats, y: Floats) -> tuple[Floats, Floats, tuple[Floats, Floats, Floats, Floats]]:
        """Before the tilt: plane position, and the Jacobian (xx, xy, yx, yy)."""
        _, _, p1, p2, _, _, _, _, s1, s2, s3, s4, _, _ = self._k
        r2 = x * x + y * y
        above, below = self._above(r2), self._below(r2)
        radial = above / below
        steep = 2.0 * (self._above.deriv()(r2) * below - above * self._below.deriv()(r2)) / below**2
        plane_x = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + s1 * r2 + s2 * r2 * r2
        plane_y = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + s3 * r2 + s4 * r2 * r2
        prism_x, prism_y = 2.0 * (s1 + 2.0 * s2 * r2), 2.0 * (s3 + 2.0 * s4 * r2)
        mixed = x * y * steep + 2.0 * (p1 * x + p2 * y)
        xx = radial + x * x * steep + 2.0 * p1 * y + 6.0 * p2 * x + x * prism_x
        yy = radial + y * y * steep + 6.0 * p1 * y + 2.0 * p2 * x + y * prism_y
        return plane_x, plane_y, (xx, mixed + y * prism_x, mixed + x * prism_y, yy)

    def _valid(self, x: Floats, y: Floats, jacobian: tuple[Floats, Floats, Floats, Floats]) -> Bools:
        xx, xy, yx, yy = jacobian
        return (x * x + y * y < self._largest_r2) & (xx * yy - xy * yx > 0.0)

    def project(self, points: Floats) -> tuple[Floats, Bools]:
        with np.errstate(all="ignore"):
            depth = np.where(points[:, 2] > 0.0, points[:, 2], np.nan)
            x, y = points[:, 0] / depth, points[:, 1] / depth
            plane_x, plane_y, jacobian = self._distorted(x, y)
            seen = self._valid(x, y, jacobian)
            plane = _turned(self._tilt, np.stack([plane_x, plane_y], axis=1))
        seen &= np.isfinite(plane).all(axis=1)
        return np.where(seen[:, None], plane, np.nan), seen

    def rays(self, plane: Floats) -> Floats:
        with np.errstate(all="ignore"):
            wanted = _turned(self._untilt, plane)
            x, y = self._undistorted(wanted[:, 0], wanted[:, 1])
            plane_x, plane_y, jacobian = self._distorted(x, y)
            off = np.hypot(plane_x - wanted[:, 0], plane_y - wanted[:, 1])
            found = (off < _FOUND * (1.0 + np.hypot(x, y))) & self._valid(x, y, jacobian)
            rays = np.stack([x, y, np.ones_like(x)], axis=1)
            rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        return np.where(found[:, None], rays, np.nan)

    def _undistorted(self, wanted_x: Floats, wanted_y: Floats) -> tuple[Floats, Floats]:
        """Newton's method, from where the radial terms alone would put it."""
        if not self._k[:12].any():
            return wanted_x, wanted_y
        reach = np.hypot(wanted_x, wanted_y)
        farthest = float(np.nanmax(reach, initial=1e-3))
        end = math.sqrt(self._largest_r2)
        if math.isinf(end):
            end = 1.0
            while end < 1e4 and end * float(self._above(end * end) / self._below(end * end)) < farthest:
                end *= 2.0
        radii = np.tan(np.linspace(0.0, math.atan(end), 4096))
        start = np.interp(reach, radii * self._above(radii**2) / self._below(radii**2), radii)
        x, y = (w * np.where(reach > 0.0, start / reach, 1.0) for w in (wanted_x, wanted_y))
        going = np.flatnonzero(np.isfinite(reach))
        for _ in range(40):
            if not going.size:
                break
            a, b = x[going], y[going]
            plane_x, plane_y, (xx, xy, yx, yy) = self._distorted(a, b)
            off_x, off_y = plane_x - wanted_x[going], plane_y - wanted_y[going]
            scale = xx * yy - xy * yx
            a, b = a - (yy * off_x - xy * off_y) / scale, b - (xx * off_y - yx * off_x) / scale
            back = np.minimum(end / np.maximum(np.hypot(a, b), 1e-300), 1.0)  # a step beyond the fold goes to it
            x[going], y[going] = a * back, b * back
            going = going[~(np.hypot(off_x, off_y) < _EXACT)]
        return x, y


class _Fisheye:
    """OpenCV's cv::fisheye, of Kannala and Brandt 2006: theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)
    from the middle for a direction at the angle theta from forward. Valid up to where this stops to rise, at most all
    around."""

    def __init__(self, distortion: tuple[float, ...]) -> None:
        self._curve = Polynomial([0.0, 1.0]) * Polynomial([1.0, *distortion])(Polynomial([0.0, 0.0, 1.0]))
        self._slope = self._curve.deriv()
        self._end = min(_first_root(self._slope), math.pi)
        self._angles = np.linspace(0.0, self._end, 4096)

    def project(self, points: Floats) -> tuple[Floats, Bools]:
        across = np.hypot(points[:, 0], points[:, 1])
        angle = np.arctan2(across, points[:, 2])
        seen = (angle <= self._end) & _directions(points)
        scale = np.divide(self._curve(angle), across, out=np.zeros_like(across), where=across > 0.0)
        return np.where(seen[:, None], points[:, :2] * scale[:, None], np.nan), seen

    def rays(self, plane: Floats) -> Floats:
        wanted = np.hypot(plane[:, 0], plane[:, 1])
        angle = np.interp(wanted, self._curve(self._angles), self._angles)
        for _ in range(40):
            with np.errstate(all="ignore"):
                step = (self._curve(angle) - wanted) / self._slope(angle)
            angle = np.clip(angle - np.nan_to_num(step), 0.0, self._end)
            if not np.any(np.abs(step) > _EXACT):
                break
        found = np.abs(self._curve(angle) - wanted) < _FOUND
        side = np.divide(np.sin(angle), wanted, out=np.zeros_like(wanted), where=wanted > 0.0)
        rays = np.stack([plane[:, 0] * side, plane[:, 1] * side, np.cos(angle)], axis=1)
        return np.where(found[:, None], rays, np.nan)


class _Equirectangular:
    """Longitude atan2(x, z) and latitude asin(y / |p|), down positive, in radians: fx and fy are pixels a radian.

    Longitudes are counted within half a turn of the picture's middle.
    """

    def __init__(self, middle_rad: float) -> None:
        self._middle = middle_rad

    def project(self, points: Floats) -> tuple[Floats, Bools]:
        longitude = np.arctan2(points[:, 0], points[:, 2])
        longitude -= 2.0 * math.pi * np.floor((longitude - self._middle) / (2.0 * math.pi) + 0.5)
        latitude = np.arctan2(points[:, 1], np.hypot(points[:, 0], points[:, 2]))
        seen = _directions(points)
        return np.where(seen[:, None], np.stack([longitude, latitude], axis=1), np.nan), seen

    def rays(self, plane: Floats) -> Floats:
        longitude, latitude = plane[:, 0], plane[:, 1]
        across = np.cos(latitude)
        rays = np.stack([across * np.sin(longitude), np.sin(latitude), across * np.cos(longitude)], axis=1)
        found = (np.abs(longitude - self._middle) <= math.pi + _FOUND) & (np.abs(latitude) <= math.pi / 2 + _FOUND)
        return np.where(found[:, None], rays, np.nan)


def _directions(points: Floats) -> Bools:
    """Which points (N, 3) are finite and not the eye itself."""
    return np.isfinite(points).all(axis=1) & (points != 0.0).any(axis=1)


def _first_root(polynomial: Polynomial) -> float:
    """The smallest positive one; inf without any."""
    roots = polynomial.trim().roots()
    real = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0.0)]
    return float(real.min(initial=math.inf))


def _tilt(x_rad: float, y_rad: float) -> Floats:
    """(3, 3) of a sensor that is turned by these angles (Louhichi et al. 2007), as OpenCV has it."""
    (cx, sx), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (x_rad, y_rad))
    turn = np.array([[cy, 0.0, -sy], [0.0, 1.0, 0.0], [sy, 0.0, cy]]) @ np.array(
        [[1.0, 0.0, 0.0], [0.0, cx, sx], [0.0, -sx, cx]]
    )
    return np.array([[turn[2, 2], 0.0, -turn[0, 2]], [0.0, turn[2, 2], -turn[1, 2]], [0.0, 0.0, 1.0]]) @ turn


def _turned(matrix: Floats, plane: Floats) -> Floats:
    """Plane positions (N, 2) through a homography (3, 3)."""
    if np.array_equal(matrix, np.eye(3)):
        return plane
    found = plane @ matrix[:, :2].T + matrix[:, 2]
    return found[:, :2] / found[:, 2:]
