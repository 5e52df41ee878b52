"""Climate: what the weather of a year is at places of a planet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..systems.terrain.drainage.cells import cell_grid
from ..systems.terrain.drainage.climate import ACROSS, ClimateParams, snow_line_m, temperature_c

__all__ = ["Climate", "climate_at"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Climate:
    """Of some places, means of a year."""

    temperature_c: Floats
    """(N,) at the ground, degrees Celsius; over the sea at its level"""
    rain_m_year: Floats
    """(N,) rain and snow, metres of water a year; 0 on a planet without Ocean"""
    snow_line_m: Floats
    """(N,) height above the reference sphere from which on snow lasts"""


def climate_at(directions: Floats, height_m: Floats, rain_mm: Floats, params: ClimateParams) -> Climate:
    """At unit directions (N, 3) with ground at height_m (N,). rain_mm: of a year, on the cells on which air moves."""
    rain = cell_grid(ACROSS).interpolated(rain_mm, directions)
    return Climate(
        temperature_c(directions, height_m, params), np.maximum(rain, 0.0) * 1e-3, snow_line_m(directions, params)
    )
