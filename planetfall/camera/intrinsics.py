"""Intrinsics: how a real camera maps directions to pixels, in OpenCV's order and signs."""

from __future__ import annotations

import dataclasses
import math
import operator
from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import CameraError
from .calibration_file import read_calibration, write_calibration
from .lens_models import COEFFICIENTS, Lens, lens_of

__all__ = ["Intrinsics"]

Floats = NDArray[np.float64]

_MIDDLE = 0.5
"""Our pixel centres lie at + 0.5, OpenCV's at whole numbers."""


@dataclasses.dataclass(frozen=True)
class Intrinsics:
    """A calibrated camera, as OpenCV describes it; give it to Camera(..., intrinsics=...).

    width, height: of the picture in pixels. fx, fy: focal lengths in pixels; pixels a radian where the model is
    "equirectangular". cx, cy: the principal point in OpenCV's pixels, whose centres are whole numbers: what `project`
    and all else here give is OpenCV's pixel + 0.5.
    distortion: OpenCV's coefficients in its order: () for "pinhole" and "equirectangular"; (k1, k2, p1, p2[, k3]) for
    "brown"; (k1, k2, p1, p2, k3, k4, k5, k6[, s1, s2, s3, s4[, tau_x, tau_y]]) for "rational"; (k1, k2, k3, k4) for
    "fisheye". () means zeros. A list or an array of cv2 will do.
    model: "pinhole", "brown", "rational", "fisheye" or "equirectangular" (docs/cameras.md).

    Points and rays are in camera axes, as OpenCV has them: x right, y down, z forward. CameraError for what can't be.
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float
    distortion: tuple[float, ...] = ()
    model: str = "pinhole"

    def __post_init__(self) -> None:
        def keep(name: str, value: object) -> None:
            object.__setattr__(self, name, value)

        for name in ("width", "height"):
            keep(name, _whole(name, getattr(self, name)))
        for name in ("fx", "fy", "cx", "cy"):
            keep(name, _number(name, getattr(self, name), above_zero=name[0] == "f"))
        if self.model not in COEFFICIENTS:
            raise CameraError(f"Intrinsics: model: expected one of {', '.join(COEFFICIENTS)}, found {self.model!r}")
        keep("distortion", _distortion(self.model, self.distortion))

    @classmethod
    def panorama(cls, width: int, height: int | None = None) -> Self:
        """A whole turn by half a turn, equirectangular, forward in the middle. height: half of width if left out."""
        width = _whole("width", width)
        height = _whole("height", width // 2 if height is None else height)
        fx, fy = width / (2.0 * math.pi), height / math.pi
        return cls(width, height, fx, fy, (width - 1) / 2.0, (height - 1) / 2.0, (), "equirectangular")

    @classmethod
    def load(cls, path: str | PathLike[str]) -> Self:
        """From a YAML file of OpenCV's FileStorage or ROS's camera_info. CameraError names what is missing or wrong."""
        found = read_calibration(Path(path))
        try:
            return cls(**found)
        except CameraError as error:
            raise CameraError(f"{path}: {error}") from None

    def save(self, path: str | PathLike[str]) -> Path:
        """Write a YAML file that OpenCV's FileStorage and ROS read. CameraError where it can't be written."""
        return write_calibration(Path(path), dataclasses.asdict(self))

    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
        return self.width, self.height

    @property
    def matrix(self) -> Floats:
        """OpenCV's camera matrix (3, 3)."""
        return np.array([[self.fx, 0.0, self.cx], [0.0, self.fy, self.cy], [0.0, 0.0, 1.0]])

    @property
    def is_pinhole(self) -> bool:
        """Whether straight lines stay straight: then it is drawn without resampling."""
        return self.model in ("pinhole", "brown", "rational") and not any(self.distortion)

    @property
    def tangents(self) -> tuple[float, float, float, float]:
        """(left, right, bottom, top) of the frustum without distortion, signed, y up."""
        left, right = ((edge - _MIDDLE - self.cx) / self.fx for edge in (0.0, self.width))
        top, bottom = ((self.cy + _MIDDLE - edge) / self.fy for edge in (0.0, self.height))
        return left, right, bottom, top

    def scaled(self, factor: int) -> Self:
        """The same camera with `factor` times the pixels along each side."""
        cx, cy = ((c + _MIDDLE) * factor - _MIDDLE for c in (self.cx, self.cy))
        width, height = self.width * factor, self.height * factor
        return dataclasses.replace(
            self, width=width, height=height, fx=self.fx * factor, fy=self.fy * factor, cx=cx, cy=cy
        )

    def project(self, points: ArrayLike) -> tuple[Floats, NDArray[np.bool_]]:
        """Pixels (N, 2), row 0 on top, of points (N, 3) in camera axes, and which the lens sees (N,).

        OpenCV's projectPoints + 0.5. NaN and False behind the lens and where the model has folded over; points beside
        the picture have pixels outside of it.
        """
        plane, seen = self._lens.project(_rows("points", points, 3))
        return plane * (self.fx, self.fy) + (self.cx + _MIDDLE, self.cy + _MIDDLE), seen

    def rays(self, pixels: ArrayLike | None = None) -> Floats:
        """Unit directions in camera axes of pixels (N, 2), (N, 3); None: of all pixels' centres, (H, W, 3).

        NaN where no direction leads to the pixel.
        """
        if pixels is None:
            columns, rows = np.meshgrid(np.arange(self.width) + _MIDDLE, np.arange(self.height) + _MIDDLE)
            return self.rays(np.stack([columns.ravel(), rows.ravel()], axis=1)).reshape(self.height, self.width, 3)
        plane = (_rows("pixels", pixels, 2) - (self.cx + _MIDDLE, self.cy + _MIDDLE)) / (self.fx, self.fy)
        return self._lens.rays(plane)

    @property
    def _lens(self) -> Lens:
        middle = ((self.width - 1) / 2.0 - self.cx) / self.fx if self.model == "equirectangular" else 0.0
        return lens_of(self.model, self.distortion, middle)


def _whole(name: str, value: object) -> int:
    try:
        number = operator.index(value)  # type: ignore[arg-type]
    except TypeError:
        number = 0
    if number < 1:
        raise CameraError(f"Intrinsics: {name}: expected a whole number of pixels, at least 1, found {value!r}")
    return number


def _number(name: str, value: object, above_zero: bool) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number) or (above_zero and number <= 0.0):
        expected = "pixels, more than 0" if above_zero else "a number of pixels"
        raise CameraError(f"Intrinsics: {name}: expected {expected}, found {value!r}")
    return number


def _distortion(model: str, value: Sequence[float]) -> tuple[float, ...]:
    try:
        found = np.asarray(value, np.float64).ravel()
    except (TypeError, ValueError):
        found = np.full(1, np.nan)
    if not np.isfinite(found).all():
        raise CameraError(f"Intrinsics: distortion: expected finite numbers, found {value!r}")
    counts = COEFFICIENTS[model]
    if found.size not in counts:
        expected = " or ".join(str(count) for count in counts if count) or "none"
        fits = [name for name, other in COEFFICIENTS.items() if found.size in other]
        hint = f"; {found.size} are those of model={fits[0]!r}" if fits else ""
        raise CameraError(
            f"Intrinsics: distortion: model {model!r} takes {expected} in OpenCV's order, found {found.size}{hint}"
        )
    return tuple(found.tolist())


def _rows(name: str, value: ArrayLike, columns: int) -> Floats:
    found = np.atleast_2d(np.asarray(value, np.float64))
    if found.ndim != 2 or found.shape[1] != columns:
        raise CameraError(f"Intrinsics: {name}: expected the shape (N, {columns}), found {np.shape(value)}")
    return found
