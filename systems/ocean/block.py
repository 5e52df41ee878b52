"""OceanBlock: what shaders know of the water. One uniform block for drawing, shading and whoever asks the contract."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ...components import Ocean
from ...engine.gpu.layout import IVec4, Vec4
from ...engine.surface.nested import nested_anchor

__all__ = ["OCEAN_BINDING", "OceanBlock", "ocean_block"]

OCEAN_BINDING = 6


@dataclass
class OceanBlock:
    """The water. GLSL: ``generated/ocean.glsl``, instance ``ocean``."""

    absorption: Vec4 = (0.35, 0.07, 0.03, 0.0)
    """1/m at the three wavelengths"""
    scattering: Vec4 = (0.0014, 0.0022, 0.003, 0.0)
    """1/m at the three wavelengths"""
    bed: Vec4 = (0.34, 0.27, 0.17, 0.0)
    """albedo of the ground below"""
    water: Vec4 = (0.2, 2.0, 0.0, 0.0)
    """(roughness: Beckmann's alpha of the slopes, sine of the latitude where ice begins (above 1: none), 0, 0)"""
    ice: Vec4 = (0.6, 0.64, 0.68, 0.0)
    """albedo of sea ice"""
    anchor_cell: IVec4 = (0, 0, 0, 0)
    """the anchor's place for nested noise: whole cells"""
    anchor_fraction: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """the rest of it"""


def ocean_block(ocean: Ocean, anchor: Any, radius_m: float) -> OceanBlock:
    """The block of a sea around an anchor: unit vector (3,), on a planet of this radius."""
    ice = math.sin(math.radians(ocean.ice_latitude_deg)) if ocean.ice_latitude_deg < 90.0 else 2.0
    return OceanBlock(
        (*ocean.absorption_per_m, 0.0),
        (*ocean.scattering_per_m, 0.0),
        (*ocean.bed_albedo, 0.0),
        (ocean.roughness, ice, 0.0, 0.0),
        (*ocean.ice_albedo, 0.0),
        *nested_anchor(anchor, radius_m),
    )
