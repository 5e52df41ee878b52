"""The uniform blocks that every shader of a view reads: the frame (binding 0) and its planet (binding 1).

All vectors are in planet axes, all lengths in metres. What is large (a planet-centred position) never enters:
positions are relative to the anchor, the point of the ground below the camera proxy, which was subtracted in double
precision.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..gpu.layout import Vec4


@dataclass
class FrameBlock:
    """One view of one frame. GLSL: ``#include "generated/frame.glsl"``, instance ``frame``."""

    camera_right: Vec4
    """xyz: the camera's right, unit."""
    camera_up: Vec4
    """xyz: the camera's up, unit."""
    camera_forward: Vec4
    """xyz: the camera's forward, unit."""
    projection: Vec4
    """(sx, sy, ox, oy): x / z = ndc.x * sx + ox, y / z = ndc.y * sy + oy, z along forward. Holds the frame's jitter: a
    pixel's centre stands for the place in the pixel that this frame samples."""
    camera_offset: Vec4
    """xyz: camera - anchor (formed in f64); w: near plane."""
    camera_zenith: Vec4
    """xyz: unit up at the camera; w: the camera's altitude above the reference sphere."""
    anchor_up: Vec4
    """xyz: unit up at the anchor; w: the anchor's height above the reference sphere."""
    sun_direction: Vec4
    """xyz: unit, towards the sun; w: its angular radius in radians."""
    sun_irradiance: Vec4
    """rgb: W m^-2 nm^-1 at the three wavelengths, outside any air."""
    viewport: Vec4
    """(width, height, 1 / width, 1 / height) in pixels."""
    clock: Vec4
    """(time in s modulo 4096, squares of a checkerboard that are shaded where every second pixel is: 0 or 1, -1 all;
    unused, angle of a pixel at the centre in rad). Nothing that changes by itself: a still frame uploads nothing."""
    scale: Vec4
    """(stored HDR value per radiance, its inverse, unused, unused)."""


@dataclass
class PlanetBlock:
    """What never changes from frame to frame. GLSL: ``#include "generated/planet.glsl"``, instance ``planet``."""

    radii: Vec4
    """(reference radius, highest ground, lowest ground, lowest drawn surface); the last three as heights above the
    first."""
    sea: Vec4
    """(sea level as a height, 1 where there is a sea, unused, unused)."""


def frame_of_anchor(anchor_up: Vec4) -> FrameBlock:
    """The block for programs that depend on nothing of the frame but its anchor (FrameBlock.anchor_up)."""
    return FrameBlock(
        camera_right=(1.0, 0.0, 0.0, 0.0),
        camera_up=(0.0, 1.0, 0.0, 0.0),
        camera_forward=(0.0, 0.0, 1.0, 0.0),
        projection=(1.0, 1.0, 0.0, 0.0),
        camera_offset=(0.0, 0.0, 0.0, 0.1),
        camera_zenith=(0.0, 0.0, 1.0, 0.0),
        anchor_up=anchor_up,
        sun_direction=(1.0, 0.0, 0.0, 0.004675),
        sun_irradiance=(1.0, 1.0, 1.0, 0.0),
        viewport=(1.0, 1.0, 1.0, 1.0),
        clock=(0.0, 0.0, 0.0, 0.001),
        scale=(1.0, 1.0, 0.0, 0.0),
    )
