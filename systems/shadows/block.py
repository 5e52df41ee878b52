"""The uniform block of the clipmap: what every shader that asks for its light reads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from ...engine.blocks.layout import IVec2, Vec2, Vec3, array

__all__ = ["MOST_LEVELS", "ShadowBlock", "ShadowWindow"]

MOST_LEVELS = 20


@dataclass
class ShadowWindow:
    """One level: ``shadow_map.windows[i]``."""

    anchor: Vec2
    """its place in texels from the window's corner"""
    stored: IVec2
    """where the corner is stored"""


@dataclass
class ShadowBlock:
    """Where a view's clipmap lies. GLSL: ``#include "generated/shadow_map.glsl"``, instance ``shadow_map``.

    Level 0 is the finest there is for the view; a level's texels are twice as wide as those of the one before.
    """

    axis_x: Vec3
    """of the projection, in planet axes"""
    radius_m: float
    """of the reference sphere"""
    axis_y: Vec3
    sea_level_m: float
    """far below all where there is no sea"""
    axis_z: Vec3
    """towards the projection's centre"""
    anchor_divisor: float
    """1 + z of the anchor in the projection's axes"""
    sun_direction: Vec3
    """that the shadows were swept for, in the projection's axes"""
    sun_radius_rad: float
    """angular, of the disc"""
    anchor_place: Vec2
    """the anchor's place p0 on the map"""
    foot: Vec2
    """place of the camera's foot minus the anchor's"""
    anchor_texel: IVec2
    """the anchor's place in whole texels of level 0"""
    anchor_rest: Vec2
    """what anchor_texel leaves, in texels of level 0"""
    frequency: float
    """texels of level 0 per length on the map"""
    texel_m: float
    """width of a texel of level 0 at the anchor"""
    texels_per_footprint_m: float
    """of level 0, that a metre of a pixel's footprint asks for"""
    finest_shown: float
    """finest level that may be shown, continuous"""
    half_texels: float
    """half width of a level's usable part"""
    levels: int
    window_texels: int
    """a side"""
    power: int
    """texels of level 0 are 2^-power wide"""
    side: int
    """of the textures, a power of two"""
    shadows: bool
    """wanted"""
    shelter: bool
    """from the sky, wanted"""
    windows: Annotated[Any, array(ShadowWindow, MOST_LEVELS)]
