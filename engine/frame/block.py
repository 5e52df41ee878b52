"""The uniform blocks that every shader of a view reads: the frame and its planet.

All vectors are in planet axes, all lengths in metres. What is large (a planet-centred position) never enters:
positions are relative to the anchor, the point of the ground below the camera proxy, which was subtracted in double
precision.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..blocks.layout import Vec2, Vec3


@dataclass
class FrameBlock:
    """One view of one frame. GLSL: ``#include "generated/frame.glsl"``, instance ``frame``."""

    camera_right: Vec3
    """unit"""
    near_m: float
    """distance of the near plane"""
    camera_up: Vec3
    """unit, of the picture"""
    pixel_rad: float
    """angle of a pixel at the picture's centre"""
    camera_forward: Vec3
    """unit"""
    time_s: float
    """modulo 4096"""
    projection_scale: Vec2
    """x / z = ndc.x * projection_scale.x + projection_offset.x, so with y; z along forward. The offset holds the
    frame's jitter: a pixel's centre stands for the place in the pixel that this frame samples."""
    projection_offset: Vec2
    camera_offset_m: Vec3
    """camera - anchor (formed in f64)"""
    checkerboard: int
    """the squares that are shaded where every second pixel is: 0 or 1, -1 all. Nothing that changes by itself: a still
    frame uploads nothing."""
    camera_zenith: Vec3
    """unit up at the camera"""
    camera_altitude_m: float
    """above the reference sphere"""
    anchor_up: Vec3
    """unit up at the anchor"""
    anchor_height_m: float
    """above the reference sphere"""
    sun_direction: Vec3
    """unit, towards the sun"""
    sun_radius_rad: float
    """its angular radius"""
    sun_irradiance: Vec3
    """W m^-2 nm^-1 at the three wavelengths, outside any air"""
    hdr_per_radiance: float
    """what HDR textures store for a radiance of 1"""
    viewport_px: Vec2
    """width, height"""
    texel_size: Vec2
    """1 / viewport_px"""
    radiance_per_hdr: float
    """1 / hdr_per_radiance"""


@dataclass
class PlanetBlock:
    """What never changes from frame to frame. GLSL: ``#include "generated/planet.glsl"``, instance ``planet``. Heights
    are above the reference sphere."""

    radius_m: float
    """of the reference sphere"""
    highest_m: float
    """height of the highest ground"""
    lowest_m: float
    """height of the lowest ground"""
    lowest_drawn_m: float
    """height of the lowest surface that is drawn, ground or sea"""
    sea_level_m: float
    """as a height; 0 where there is no sea"""
    has_sea: bool


def frame_of_anchor(up: Vec3, height_m: float) -> FrameBlock:
    """The block for programs that depend on nothing of the frame but its anchor."""
    return FrameBlock(
        camera_right=(1.0, 0.0, 0.0),
        near_m=0.1,
        camera_up=(0.0, 1.0, 0.0),
        pixel_rad=0.001,
        camera_forward=(0.0, 0.0, 1.0),
        time_s=0.0,
        projection_scale=(1.0, 1.0),
        projection_offset=(0.0, 0.0),
        camera_offset_m=(0.0, 0.0, 0.0),
        checkerboard=0,
        camera_zenith=(0.0, 0.0, 1.0),
        camera_altitude_m=0.0,
        anchor_up=up,
        anchor_height_m=height_m,
        sun_direction=(1.0, 0.0, 0.0),
        sun_radius_rad=0.004675,
        sun_irradiance=(1.0, 1.0, 1.0),
        hdr_per_radiance=1.0,
        viewport_px=(1.0, 1.0),
        texel_size=(1.0, 1.0),
        radiance_per_hdr=1.0,
    )
