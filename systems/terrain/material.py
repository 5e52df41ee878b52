"""What the ground is made of, as the shader reads it: the block of terrain/ground_at.glsl and how it is filled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...components import Terrain
from ...components.season import winter_at
from ...engine.blocks.layout import IVec3, Vec2, Vec3, array
from ...engine.surface.nested import NestedAnchor, nested_anchor
from ...engine.wavelengths import Nanometres
from .height import TerrainParams
from .height_model import Model
from .height_octaves import model_of
from .height_table import octave_table
from .material_list import MOST_ALBEDOS, albedos

__all__ = ["TerrainMaterialBlock", "material_block"]

LAYERS = 16
"""Most layers of relief."""

_GRADIENT_VARIANCE = 1.3
"""Of gradient noise along the ground, per squared wavelength; ridges included. Measured."""

_GRAIN_SLOPE = 0.07
"""Of each octave of bumps below the shortest layer, height over wavelength."""

_MEAN_MOISTURE = 0.41  # 0.9 times the mean of the ground's own moisture, less what makes a third of Earth's land dry
_LEAST_CLIMATE_M = 500.0  # worlds without climate have the same snow line everywhere

_RANGE_SHARE = 1.8
"""Of the ranges' height that their layers add where roughness says that there are ranges: an estimate for detail."""


@dataclass
class ReliefWarp:
    """What bends the warped layers."""

    cell: Annotated[IVec3, "of the anchor"]
    frequency_per_m: float
    fraction: Annotated[Vec3, "the anchor's place in its cell"]
    amplitude_m: float
    value: Annotated[Vec3, "of the noise at the anchor"]


@dataclass
class ReliefLayer:
    """An octave of the terrain's relief."""

    cell: Annotated[IVec3, "of the anchor"]
    frequency_per_m: float
    fraction: Annotated[Vec3, "the anchor's place in its cell"]
    wavelength_m: float
    amplitude_m: Annotated[float, "at roughness 1"]
    range_amplitude_m: Annotated[float, "the same of the ranges' own layers"]
    ridge: Annotated[float, "share of the ridge transform, negative for its mirror image"]


@dataclass
class ReliefSlopes:
    """How steep all layers together are."""

    shortest_per_m: Annotated[float, "2 / wavelength of the shortest"]
    variance: Annotated[float, "at roughness 1"]
    per_octave: Annotated[float, "1 / number of those that have any"]


@dataclass
class TerrainMaterialBlock:
    """What the ground is made of. GLSL: ``generated/terrain_material_block.glsl``, instance
    ``terrain_material_block``."""

    albedos: Annotated[Any, array(Vec3, MOST_ALBEDOS)]
    """of the materials; ``generated/terrain_albedos.glsl`` names the places"""
    rock_slope: Annotated[float, "of bare rock, m per m"]
    snow_slope: Annotated[float, "that sheds snow, m per m"]
    beach_height_m: float
    per_beach_height: Annotated[float, "1/m"]
    beach_shift: Annotated[float, "added to noise of variance 1: a beach is as high as it may where the sum is 1"]
    plants: Annotated[float, "share of ground that may carry plants"]
    strata: Annotated[float, "how clearly they show"]
    strata_per_m: float
    snow_line_m: Annotated[float, "height at the equator"]
    snow_line_rise_m: Annotated[float, "how much higher it is at the poles"]
    warmth_per_m: Annotated[float, "1 / range of the snow line"]
    winter: Annotated[Vec2, "how far it is winter in the northern and the southern half, 0..1"]
    humidity: float
    variation: Annotated[float, "strength of colour variation"]
    dust_law: Annotated[float, "share of the law of airless dust"]
    grain: Annotated[float, "height of the bumps below the shortest layer"]
    clutter: Annotated[float, "things on the ground"]
    slopes: ReliefSlopes
    layer_count: int
    warped_layers: int
    anchor: Annotated[NestedAnchor, "for noise of all wavelengths"]
    warp: ReliefWarp
    layers: Annotated[Any, array(ReliefLayer, LAYERS)]


def _beach_shift(share: float) -> float:
    """So that noise of variance 1 is over a half with it in this share of places."""
    return 0.5 + NormalDist().inv_cdf(share) if 0.0 < share < 1.0 else (-10.0, 10.0)[share >= 1.0]


def material_block(
    terrain: Terrain, params: TerrainParams, anchor_direction: NDArray[np.float64], nm: Nanometres
) -> TerrainMaterialBlock:
    """The block for one component, one anchor (unit direction, (3,) float64) and light at the wavelengths `nm`."""
    model = model_of(params)
    slopes = model.amplitude_m / model.wavelength_m
    octaves = max(int(np.count_nonzero(slopes)), 1)
    return TerrainMaterialBlock(
        albedos=albedos(terrain, nm),
        rock_slope=_slope(terrain.rock_slope_deg),
        snow_slope=_slope(terrain.snow_slope_deg),
        beach_height_m=terrain.beach_height_m,
        per_beach_height=1.0 / max(terrain.beach_height_m, 1e-3),
        beach_shift=_beach_shift(terrain.beach_share),
        plants=terrain.plants,
        strata=terrain.strata,
        strata_per_m=1.0 / terrain.strata_m,
        snow_line_m=terrain.snow_line_m,
        snow_line_rise_m=terrain.snow_line_pole_m - terrain.snow_line_m,
        warmth_per_m=1.0 / max(terrain.snow_line_m - terrain.snow_line_pole_m, _LEAST_CLIMATE_M),
        winter=winter_at(terrain.season, np.array([1.0, -1.0])),
        humidity=terrain.humidity - _MEAN_MOISTURE,
        variation=terrain.variation,
        dust_law=terrain.dust_law,
        grain=terrain.grain * _GRAIN_SLOPE / max(float(slopes[-1]), 1e-6),
        clutter=terrain.clutter,
        slopes=ReliefSlopes(
            shortest_per_m=2.0 / float(model.wavelength_m[-1]),
            variance=_GRADIENT_VARIANCE * float(np.sum(slopes * slopes)),
            per_octave=1.0 / octaves,
        ),
        layer_count=model.layers,
        warped_layers=model.warped_layers,
        anchor=nested_anchor(anchor_direction, params.radius_m),
        **_relief(model, anchor_direction),
    )


def _relief(model: Model, anchor_direction: NDArray[np.float64]) -> dict[str, Any]:
    """The warp and the layers of the block, from the table that the vertices are made of."""
    table = octave_table(model, anchor_direction, 0.0)
    warp, layers = table["narrow_warp"], table["layers"][:LAYERS].copy()
    layers[model.layers :] = layers[model.layers - 1]
    at, of_warp = layers["lattice"], warp["lattice"]
    columns = (
        at["cell"],
        at["frequency_per_m"],
        at["fraction"],
        1.0 / at["frequency_per_m"],
        layers["amplitude_m"],
        layers["range_weight"] * (_RANGE_SHARE * float(model.constants.range_m)),
        layers["ridge"],
    )
    return {
        "warp": ReliefWarp(
            cell=of_warp["cell"],
            frequency_per_m=float(of_warp["frequency_per_m"]),
            fraction=of_warp["fraction"],
            amplitude_m=float(warp["amplitude_m"]),
            value=warp["value"],
        ),
        "layers": [ReliefLayer(*row) for row in zip(*(column.tolist() for column in columns), strict=True)],
    }


def _slope(angle_deg: float) -> float:
    return max(math.tan(math.radians(min(angle_deg, 89.0))), 1e-3)
