"""The cross-section of a valley: what a river makes of the ground at a distance d from its line.

Statements of `height_statements`, which makes the shader's functions and all derivatives of them. Lengths in metres.
half_width: of the water, 0 where a valley is dry; floor_width: half of the valley's floor; reach: where it ends.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .. import height_steps
from ..height_statements import Statements
from ..height_steps import positive, unit

__all__ = [
    "HELD",
    "NEAR_M2",
    "open_slopes",
    "raise_slopes",
    "section_slopes",
    "shader",
    "share_slopes",
]

NEAR_M2 = 1.0
"""Squared distance from the water at which a line has lost half of its say. Of lakes and rivers alike: a lake with more
to say would lay its shallow rim across the river that leaves it."""
HELD = 0.01
"""Ground that dips below a river is raised to this share of the reach from its banks, and half of the floor beyond."""
BANK_M, BANK_SHARE = 0.3, 0.6
"""Banks rise by so much and by this share of the water's depth."""
FLOOR_SLOPE = 0.003
"""Of a valley's floor, towards its sides."""


def river_open(d: Any, floor_width: Any, reach: Any) -> Any:
    """How much of the ground's height above the river is left: 0 on the floor, 1 where the valley ends. Sides are
    steepest at their foot, as cut by a river that sinks."""
    v = unit((d - floor_width) / (reach - floor_width))
    return v * (2.0 - v)


def river_raise(d: Any, half_width: Any, floor_width: Any, reach: Any, lake: Any) -> Any:
    """How much of a dip below the river is filled: 1 along the water, 0 from the middle of the floor on. Of a lake its
    rim alone."""
    held = HELD * reach + 0.5 * (floor_width - half_width)
    outside = 1.0 - unit((d - half_width) / held)
    within = unit((d - 0.75 * half_width) / (0.2 * half_width + 1.0))
    return outside * (1.0 - lake + lake * within)


def river_section(d: Any, half_width: Any, depth: Any) -> Any:
    """Height of bed, bank and floor over the water's level."""
    q = unit(d / (half_width + 0.001))
    beyond = positive(d - half_width)
    bank = (BANK_M + BANK_SHARE * depth) * beyond / (beyond + half_width + 2.0)
    return depth * (q * q - 1.0) + bank + FLOOR_SLOPE * beyond


def river_share(d: Any, half_width: Any, reach: Any) -> Any:
    """What a line has to say about the level among its neighbours (Shepard 1968, inverse squared distance): all at the
    water, nothing where its valley ends."""
    left = positive(1.0 - d / reach)
    beyond = positive(d - half_width)
    return left * left / (beyond * beyond + NEAR_M2)


_MADE = Statements(Path(__file__).read_text(encoding="utf-8"), {**vars(height_steps), **globals()})
_NAMES = ("river_open", "river_raise", "river_section", "river_share")
_SLOPES = {name: _MADE[name].slopes({}) for name in _NAMES}
open_slopes, raise_slopes, section_slopes, share_slopes = (_MADE.python(_SLOPES[name]) for name in _NAMES)
"""The value and its derivatives by the inputs."""


def shader() -> str:
    """GLSL, in float: the functions and their derivatives."""
    return "\n".join(_MADE.glsl(made, "float") for name in _NAMES for made in (_MADE[name], _SLOPES[name]))
