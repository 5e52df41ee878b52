"""What the ground is made of, as the shader reads it: the block of terrain/ground_at.glsl and how it is filled."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...components import Terrain
from ...engine.gpu.layout import IVec4, Vec4, array
from ...engine.surface.nested import nested_anchor
from .height import TerrainParams, octave_table
from .height_model import FIELDS
from .height_octaves import model_of
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
class TerrainMaterialBlock:
    """What the ground is made of. GLSL: ``generated/terrain_material_block.glsl``, instance
    ``terrain_material_block``."""

    albedo: Annotated[Any, array(Vec4, MOST_ALBEDOS)]
    """of the materials; ``generated/terrain_albedos.glsl`` names the places"""
    limits: Vec4
    """(slope of bare rock in m per m, slope that sheds snow, height of beaches in m, 1 / height of beaches in m)"""
    shares: Vec4
    """(of ground that may carry plants, how clearly strata show, 0, 0)"""
    climate: Vec4
    """(height of the snow line in m at the equator, how much higher at the poles, humidity, 1 / its range in m)"""
    look: Vec4
    """(strength of colour variation, share of the law of airless dust, height of the grain, things on the ground)"""
    relief: Vec4
    """(2 / shortest layer in m, variance of all layers' slopes at roughness 1, 1 / their octaves, 1 / period of strata
    in m)"""
    anchor_cell: IVec4
    """the anchor's place in units of NESTED_BASE_M: whole cells"""
    anchor_fraction: Vec4
    """the rest of it"""
    counts: IVec4
    """(layers, how many of them are warped, 0, 0)"""
    warp_cell: IVec4
    """of the warp of layers, at the anchor"""
    warp_place: Vec4
    """fraction; w: frequency, 1/m"""
    warp_anchor: Vec4
    """its value at the anchor; w: how far it moves, m"""
    layer_cell: Annotated[Any, array(IVec4, LAYERS)]
    """of the terrain's layers, at the anchor"""
    layer_place: Annotated[Any, array(Vec4, LAYERS)]
    """fraction; w: frequency, 1/m"""
    layer_shape: Annotated[Any, array(Vec4, LAYERS)]
    """(amplitude in m at roughness 1, the same of the ranges' own layers in m, ridge share, wavelength in m)"""


def material_block(
    terrain: Terrain, params: TerrainParams, anchor_direction: NDArray[np.float64]
) -> TerrainMaterialBlock:
    """The block for one component and one anchor (unit direction, (3,) float64)."""
    model = model_of(params)
    slopes = model.amplitude_m / model.wavelength_m
    octaves = max(int(np.count_nonzero(slopes)), 1)
    table = octave_table(model, anchor_direction, 0.0)
    last = 2 + FIELDS + model.layers
    layers = table["octaves"][2 + FIELDS : 2 + FIELDS + LAYERS].copy()
    layers[model.layers :] = table["octaves"][last - 1]
    warp = table["octaves"][1]
    grain = terrain.grain * _GRAIN_SLOPE / max(float(slopes[-1]), 1e-6)
    range_m = _RANGE_SHARE * float(model.constants.range_m)
    cell, fraction = nested_anchor(anchor_direction, params.radius_m)
    return TerrainMaterialBlock(
        albedo=albedos(terrain),
        limits=(
            _slope(terrain.rock_slope_deg),
            _slope(terrain.snow_slope_deg),
            terrain.beach_height_m,
            1.0 / max(terrain.beach_height_m, 1e-3),
        ),
        shares=(terrain.plants, terrain.strata, 0.0, 0.0),
        climate=(
            terrain.snow_line_m,
            terrain.snow_line_pole_m - terrain.snow_line_m,
            terrain.humidity - _MEAN_MOISTURE,
            1.0 / max(terrain.snow_line_m - terrain.snow_line_pole_m, _LEAST_CLIMATE_M),
        ),
        look=(terrain.variation, terrain.dust_law, grain, terrain.clutter),
        relief=(
            2.0 / float(model.wavelength_m[-1]),
            _GRADIENT_VARIANCE * float(np.sum(slopes * slopes)),
            1.0 / octaves,
            1.0 / terrain.strata_m,
        ),
        anchor_cell=cell,
        anchor_fraction=fraction,
        counts=(model.layers, model.warped_layers, 0, 0),
        warp_cell=tuple(int(v) for v in warp["cell"]),
        warp_place=(*(float(v) for v in warp["fraction_hi"]), float(warp["frequency"])),
        warp_anchor=(*(float(v) for v in table["warp_hi"][1, :3]), float(table["warp_m"][1])),
        layer_cell=layers["cell"],
        layer_place=np.concatenate([layers["fraction_hi"], layers["frequency"][:, None]], axis=1),
        layer_shape=np.stack(
            [
                layers["weights"][:, 1],
                layers["weights"][:, 0] * range_m,
                layers["weights"][:, 2],
                1.0 / layers["frequency"],
            ],
            axis=1,
        ),
    )


def _slope(angle_deg: float) -> float:
    return max(math.tan(math.radians(min(angle_deg, 89.0))), 1e-3)
