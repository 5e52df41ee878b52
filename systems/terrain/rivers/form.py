"""The cross-section of a valley: what a river makes of the ground at a distance d from its line.

Statements of `height_statements`, which makes the shader's functions and all derivatives of them. Lengths in metres.
half_width: of the water, 0 where a valley is dry; floor_width: half of the valley's floor; reach: where it ends.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from .. import height_steps
from ..height_statements import Statements
from ..height_steps import positive, smoothstep, unit

__all__ = [
    "HELD",
    "NEAR_M2",
    "bank_slopes",
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
BANK_STEEP, BANK_MOST = 0.3, 0.28
"""How far noise moves a bank: by its wavelength, and by the half width at most."""
BANK_COARSE_M, BANK_MIDDLE_M, BANK_FINE_M = 256.0, 64.0, 16.0
"""Wavelengths of that noise: powers of two."""
BANK_INWARD = 0.6
"""By so much of the most that it moves them banks lie further in, where the floor has no room for more water."""
BANK_NARROWEST = 0.4
"""Of the half width so much is left anywhere."""
BANK_OUT = 3 * BANK_MOST
"""Of the half width, more than noise moves banks out."""
BANK_FAR = 2.5
"""Half widths from the line from which on its banks count as straight."""


def river_bank(d: Any, half_width: Any, floor_width: Any, share: Any, coarse: Any, middle: Any, fine: Any) -> Any:
    """Half width of the water between uneven banks. share: how uneven, 0..1; coarse, middle, fine: noise between -1
    and 1."""
    largest = share * BANK_MOST * half_width
    most_coarse = largest - positive(largest - share * BANK_STEEP * BANK_COARSE_M)
    most_middle = largest - positive(largest - share * BANK_STEEP * BANK_MIDDLE_M)
    most_fine = largest - positive(largest - share * BANK_STEEP * BANK_FINE_M)
    room = floor_width - half_width
    inward = positive(BANK_INWARD * (most_coarse + most_middle + most_fine) - room)
    moved = most_coarse * coarse + most_middle * middle + most_fine * fine - inward
    within = moved - positive(moved - room)
    kept = within + positive((BANK_NARROWEST - 1.0) * half_width - within)
    return half_width + kept * smoothstep(BANK_FAR - d / (half_width + 0.001))


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
_NAMES = ("river_bank", "river_open", "river_raise", "river_section", "river_share")
_SLOPES = {name: _MADE[name].slopes({}) for name in _NAMES}
bank_slopes, open_slopes, raise_slopes, section_slopes, share_slopes = (_MADE.python(_SLOPES[name]) for name in _NAMES)
"""The value and its derivatives by the inputs."""


def shader() -> str:
    """GLSL, in float: the functions and their derivatives."""
    return "\n".join(_MADE.glsl(made, "float") for name in _NAMES for made in (_MADE[name], _SLOPES[name]))
