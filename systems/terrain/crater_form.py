"""The point-wise part of craters: from a place in a cell and its draws to what the crater there adds, see craters.py.

Statements of `height_statements`, which makes the shader's functions of them. Shares of rounded corners are single:
heights don't hang on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .height_statements import Single, Statements, at_least, at_most, clamp

__all__ = ["CraterShape", "crater_form", "crater_profile", "crater_relief", "crater_rise", "crater_sizes", "shader"]

PEAK_NARROW = 12.0
WORN_LEAST = 0.15


@dataclass
class CraterShape:
    """Of a fresh crater, by its radius: depth of the wall's parabola below the crest, depth of the floor below it,
    height of the crest, height of the central peak."""

    wall: float
    bottom: float
    rim: float
    peak: float


def crater_form(k: CraterShape, vv: Any, along: Any, curve: Any, there: Any, wide: Any, worn: Any) -> Any:
    """Of a crater whose cell's place is `vv` from here (squared, in cells), `along` of it upwards, on a sphere of
    radius 1 / `curve`. there: 1, or 0 for none; wide, worn: draws in [0, 1)."""
    e = vv * curve - 2.0 * along
    root = (1.0 + e * curve) ** 0.5
    z = e / (1.0 + root)
    kept, depth, room, smaller, fresh = crater_sizes(z, root, there, wide, worn)
    square = at_least(vv - z * z, 0.0) / depth * smaller
    form, slope, left, covered, d_covered = crater_profile(k, square, kept, fresh)
    size = (room / smaller) ** 0.5
    narrow: Single = smaller
    inverse_radius: Single = narrow / room
    return form, fresh, size, covered, root, inverse_radius, slope, d_covered, left


def crater_sizes(z: Any, root: Any, there: Any, wide: Any, worn: Any) -> Any:
    """Of craters whose places lie `z` above the sphere (in cells), at `root` of its radius: whether they are there
    (0..1); smaller / room is 1 / R^2 in cells; freshness."""
    depth = at_least(0.25 - z * z, 1e-9)
    room = depth / root
    kept = there * clamp(16.0 * room - 1.0, 0.0, 1.0)  # those less than half as wide as they could be are left out
    smaller = 4.0 + 12.0 * wide
    fresh = kept * (WORN_LEAST + (1.0 - WORN_LEAST) * worn * worn)
    return kept, depth, room, smaller, fresh


def crater_profile(k: CraterShape, square: Any, kept: Any, fresh: Any) -> Any:
    """At square = (r / R)^2: the height by the radius and its slope by the square; a third of what the square is below
    4; how much of what is older is wiped out, 1 inside, 0 beyond the rim, and its slope."""
    q = at_most(square, 4.0)
    top = at_least(1.0 - PEAK_NARROW * q, 0.0)
    bottom = k.rim - k.bottom + k.peak * top * top
    d_bottom: Single = -2.0 * PEAK_NARROW * k.peak * top
    bowl = k.rim + k.wall * (q - 1.0)
    foot_width: Single = 0.15 * k.bottom
    foot: Single = clamp(0.5 + 0.5 * (bowl - bottom) / foot_width, 0.0, 1.0)
    inside = bottom + (bowl - bottom) * foot + foot_width * foot * (1.0 - foot)
    d_inside: Single = d_bottom + (k.wall - d_bottom) * foot
    left = (4.0 - q) * (1.0 / 3.0)
    outside = k.rim * left * left * left
    d_outside: Single = -k.rim * (left * left)
    crest_width: Single = k.rim * (2.2 - 1.6 * fresh)
    crest: Single = clamp(0.5 + 0.5 * (outside - inside) / crest_width, 0.0, 1.0)
    form = outside + (inside - outside) * crest - crest_width * crest * (1.0 - crest)
    slope: Single = d_outside + (d_inside - d_outside) * crest
    within = clamp(1.5 - q, 0.0, 1.0)
    beyond = 1.0 - within
    covered = kept * within * within * (3.0 - 2.0 * within)
    d_covered: Single = -6.0 * (kept * within * beyond)
    return form, slope, left, covered, d_covered


_MADE = Statements(Path(__file__).read_text(encoding="utf-8"), globals())
crater_relief = _MADE.python(_MADE["crater_form"].only("crater_relief", ("form", "fresh", "size", "covered")))
"""crater_form without what slopes need."""
crater_rise = _MADE.python(_MADE["crater_profile"].only("crater_rise", ("form", "covered")))
"""crater_profile without slopes."""


def shader() -> str:
    """GLSL: crater_form in float, and with TERRAIN_CANONICAL in double."""
    single, double = (_MADE.glsl(_MADE["crater_form"], real) for real in ("float", "double"))
    return f"const float CRATER_PEAK_NARROW = {PEAK_NARROW};\n{single}\n#ifdef TERRAIN_CANONICAL\n{double}#endif\n"
