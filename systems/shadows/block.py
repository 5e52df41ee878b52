"""The uniform block of the clipmap (binding 9): what every shader that asks for its light reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from ...engine.gpu.layout import IVec4, Vec4, array

__all__ = ["MOST_LEVELS", "ShadowBlock"]

MOST_LEVELS = 20


@dataclass
class ShadowBlock:
    """Where a view's clipmap lies. GLSL: ``#include "generated/shadow_map.glsl"``, instance ``shadow_map``.

    Level 0 is the finest there is for the view; a level's texels are twice as wide as those of the one before.
    """

    axis_x: Vec4
    """xyz: the chart's x axis in planet axes; w: x of the anchor's place p0"""
    axis_y: Vec4
    """xyz: its y axis; w: y of the anchor's place"""
    axis_z: Vec4
    """xyz: its z axis, towards its centre; w: 1 + z of the anchor"""
    scale: Vec4
    """(texels of level 0 per length on the map, its inverse, reference radius in m, metres per length on the map at the
    anchor)"""
    view: Vec4
    """(place of the camera's foot minus the anchor's: x, y; half width of a level's usable part in texels; finest level
    that may be shown, continuous)"""
    detail: Vec4
    """(texels of level 0 that a metre of footprint asks for, level of the sea in m or far below all; the anchor's
    place in texels of level 0: what `anchor` leaves, x and y)"""
    sun: Vec4
    """xyz: the direction that the shadows were swept for, in the chart's axes; w: angular radius of the disc"""
    counts: IVec4
    """(levels, texels a side, 1 if the shelter from the sky is wanted, 1 if shadows are)"""
    anchor: IVec4
    """(the anchor's place in whole texels of level 0: x, y; power of level 0: texels are 2^-power wide; side of the
    textures, a power of two)"""
    window: Annotated[Any, array(Vec4, MOST_LEVELS)]
    """of each level: the anchor's place in texels from the window's corner (x, y), where the corner is stored (x, y)"""
