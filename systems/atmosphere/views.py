"""The air as one camera sees it: tables over the directions around it, made anew when its altitude or the sun's height
changes there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import Vec3
from ...engine.space import length
from .model import AirModel

__all__ = ["AirRows", "AirView", "AirViewBlock", "ViewSizes", "focus_of", "rows_at", "sun_at", "view_block"]

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
    def texels(self) -> tuple[int, int]:
        """Size of the tables of light."""
        return (self.columns, 2 * self.rows)

    @property
    def layers(self) -> int:
        """Of those tables: one for each end of a slice, and one for whole rays."""
        return self.slices + 2

    @property
    def extinction_texels(self) -> tuple[int, int]:
        """Size of the table of mean extinction."""
        return (2 * self.rows, _FINE * self.slices + 1)


@dataclass
class AirRows:
    """Rows of the tables for one kind of rays; numbers, or arrays of them."""

    least_m: float
    """length of the vertical ray in the air"""
    range_m: float
    """so much longer is the longest"""
    kappa: float
    """how far rows crowd at short rays: see air_path_row in atmosphere/slices.glsl"""


@dataclass
class AirView:
    """What the functions of atmosphere/view.glsl know of a camera and its tables."""

    altitude_m: float
    """above the floor, >= 0"""
    sun_mu: float
    """cosine of the sun's zenith angle"""
    sun_sine: float
    floor_rays: AirRows
    """that end on the floor: the first half"""
    open_rays: AirRows
    """that don't"""
    focus: float
    """half width of the azimuths' crowding at the terminator"""
    columns: int
    rows: int
    """of each half"""
    slices: int


@dataclass
class AirViewBlock:
    """GLSL: ``#include "generated/air_view.glsl"``, instance ``air_view``."""

    camera: AirView
    sun_side: Vec3
    """unit, level at the camera, towards the sun"""


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


def rows_at(model: AirModel, altitude_m: Any) -> tuple[AirRows, AirRows]:
    """AirView's floor_rays and open_rays for a camera, or for cameras (...), at altitudes >= 0."""
    top = model.thickness_m
    # Continuous through the top: from there on the rays are those of a camera on it.
    inside = np.minimum(altitude_m, top)
    to_horizon = np.sqrt(inside * (2.0 * model.radius_m + inside))
    least, share = top - inside, inside / top
    return (
        AirRows(inside, to_horizon - inside, 1.0 + _STEEP_SHARE * (share * share)),
        AirRows(least, to_horizon + model.longest_path_m - least, 1.0 - _GRAZING_SHARE * share),
    )


def focus_of(model: AirModel) -> float:
    """AirView's focus."""
    return _FOCUS * math.sqrt(model.rayleigh_height_m / model.radius_m)


def view_block(
    model: AirModel, altitude_m: float, cosine: float, sine: float, side: NDArray[np.float64], sizes: ViewSizes
) -> AirViewBlock:
    """The block of a camera at this altitude under a sun at this zenith angle. Below the floor and just above it, it is
    held at _LEAST_SHARE of the radius."""
    h = max(altitude_m, _LEAST_SHARE * model.radius_m)
    size = (sizes.columns, sizes.rows, sizes.slices)
    return AirViewBlock(AirView(h, cosine, sine, *rows_at(model, h), focus_of(model), *size), side)
