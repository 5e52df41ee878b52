"""The air as one camera sees it: tables over the directions around it, made anew when its altitude or the sun's height
changes there."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...engine.gpu.layout import IVec4, Vec4
from ...engine.space import length
from .model import AirModel

__all__ = ["AirViewBlock", "ViewSizes", "spans", "sun_at", "view_block"]

_FINE = 4  # AIR_FINE in atmosphere/view.glsl
_LEAST_SHARE = 4.0e-8
"""Of the radius, 0.25 m on Earth. A camera on the floor has rays of no length to it, and would see ground below it
through air that is lit as straight down. From here on all directions have rows of their own."""
_STEEP_SHARE = 2.0
"""From space, this much more of the rows is given to floor rays near the middle of the disc."""
_GRAZING_SHARE = 0.6
"""From high up, this much less of the other rays' rows goes to short rays: the limb gets them."""
_FOCUS = 2.7
"""Width of the terminator's focus in units of sqrt(scale height / radius): about 0.1 on Earth."""


@dataclass(frozen=True)
class ViewSizes:
    """columns: azimuths; rows: of rays that end on the floor, and as many of those that don't; slices along a ray."""

    columns: int = 24
    rows: int = 48
    slices: int = 12

    @property
    def texels(self) -> tuple[int, int, int]:
        """Size of the tables of light."""
        return (self.columns, 2 * self.rows, self.slices + 1)

    @property
    def extinction_texels(self) -> tuple[int, int]:
        """Size of the table of mean extinction."""
        return (2 * self.rows, _FINE * self.slices + 1)


@dataclass
class AirViewBlock:
    """GLSL: ``#include "generated/air_view.glsl"``, instance ``air_view``; struct AirView in atmosphere/view.glsl."""

    camera: Vec4
    """(altitude >= 0, cosine and sine of the sun's zenith angle, unused)"""
    span: Vec4
    """length of rays in the air: those that end on the floor (least, range), the others (least, range)"""
    shape: Vec4
    """(kappa of the rows of floor rays, of the others, width of the terminator's focus, unused)"""
    sun_side: Vec4
    """xyz: unit, level at the camera, towards the sun"""
    size: IVec4
    """(columns, rows of each half, slices, unused)"""


def sun_at(up: NDArray[np.float64], sun: NDArray[np.float64]) -> tuple[float, float, NDArray[np.float64]]:
    """Cosine and sine of the sun's zenith angle and the level unit vector towards it; any where it is in the zenith."""
    cosine = min(max(float(up.dot(sun)), -1.0), 1.0)
    side = sun - cosine * up
    sine = length(side)
    if sine < 1e-12:
        helper = np.array([0.0, 0.0, 1.0]) if abs(up[2]) < 0.7 else np.array([1.0, 0.0, 0.0])
        side = np.cross(up, helper)
        return cosine, sine, side / np.linalg.norm(side)
    return cosine, sine, side / sine


def spans(model: AirModel, altitude_m: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """AirViewBlock's span and shape, (..., 4) each, for cameras at altitudes (...) >= 0 in metres."""
    h = np.asarray(altitude_m, np.float64)
    top, radius = model.thickness_m, model.radius_m
    # Continuous through the top: from there on the rays are those of a camera on it.
    inside = np.minimum(h, top)
    to_horizon = np.sqrt(inside * (2.0 * radius + inside))
    least = top - inside
    share = inside / top
    span = np.stack([inside, to_horizon - inside, least, to_horizon + model.longest_path_m - least], -1)
    focus = np.full_like(h, _FOCUS * math.sqrt(model.rayleigh_height_m / radius))
    shape = np.stack([1.0 + _STEEP_SHARE * share**2, 1.0 - _GRAZING_SHARE * share, focus, np.zeros_like(h)], -1)
    return span, shape


def _spans_of_one(model: AirModel, h: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """`spans` for one altitude, as each frame asks for it, to the bit."""
    top, radius = model.thickness_m, model.radius_m
    inside = min(h, top)
    to_horizon = math.sqrt(inside * (2.0 * radius + inside))
    least = top - inside
    share = inside / top
    span = (inside, to_horizon - inside, least, to_horizon + model.longest_path_m - least)
    focus = _FOCUS * math.sqrt(model.rayleigh_height_m / radius)
    return span, (1.0 + _STEEP_SHARE * (share * share), 1.0 - _GRAZING_SHARE * share, focus, 0.0)


def view_block(
    model: AirModel, altitude_m: float, cosine: float, sine: float, side: NDArray[np.float64], sizes: ViewSizes
) -> AirViewBlock:
    """The block of a camera at this altitude under a sun at this zenith angle. Below the floor and just above it, it is
    held at _LEAST_SHARE of the radius."""
    h = max(altitude_m, _LEAST_SHARE * model.radius_m)
    span, shape = _spans_of_one(model, h)
    return AirViewBlock(
        camera=(h, cosine, sine, 0.0),
        span=span,
        shape=shape,
        sun_side=(*side.tolist(), 0.0),
        size=(sizes.columns, sizes.rows, sizes.slices, 0),
    )
