"""What the sea keeps of each tile's long waves, as assets/shaders/ocean/swell.comp makes it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from ...engine.blocks.layout import StructLayout, Vec2, Vec3, Vec4, array
from ...engine.made_shaders import made_shader

__all__ = ["SWELL_BYTES"]


@dataclass
class SwellRow:
    """Four nodes along the rectangle's first axis: slopes of the height and of the sideways movement."""

    lift_east: Vec4
    lift_north: Vec4
    squeeze_ee: Vec4
    squeeze_nn: Vec4
    squeeze_en: Vec4


@dataclass
class SwellTile:
    """GLSL: ``generated/swell_tile.glsl``."""

    centre_m: Annotated[Vec2, "of the rectangle, as SeaPlace.at"]
    axis: Annotated[Vec2, "its first one, unit"]
    per_half_side: Annotated[Vec2, "1/m, along the first and the second axis"]
    feels: Annotated[int, "far waves that feel the bed,"]
    held: Annotated[int, "and with them those that the nodes hold"]
    hidden: Annotated[Vec3, "slope variance of the waves that the nodes hold"]
    rows: Annotated[Any, array(SwellRow, 4)]


_LAYOUT = StructLayout(SwellTile, "std430")
SWELL_BYTES = _LAYOUT.size
made_shader("generated/swell_tile.glsl", lambda: _LAYOUT.glsl)
