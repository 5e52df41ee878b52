"""The point-wise part of craters: from a place in a cell and its draws to what the crater there adds, see craters.py.

Statements of `height_statements`, which makes the shader's functions of them. Shares of rounded corners are single:
heights don't hang on them.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from .height_statements import Single, Statements, at_least, at_most, clamp

__all__ = [
    "CraterShape",
    "crater_above",
    "crater_form",
    "crater_profile",
    "crater_relief",
    "crater_rise",
    "crater_sizes",
    "shader",
]

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


def crater_above(vv: Any, along: Any, curve: Any) -> Any:
    """Of a crater's place that is `vv` from one on the sphere of radius 1 / `curve` (squared, in cells), `along` of it
    downwards: how high it lies above the sphere, z, and at `root` of its radius."""
    e = vv * curve - 2.0 * along
    root = (1.0 + e * curve) ** 0.5
    z = e / (1.0 + root)
    return z, root


def crater_form(k: CraterShape, aside: Any, z: Any, root: Any, there: Any, wide: Any, worn: Any) -> Any:
    """Of a crater whose place is `aside` from here along the ground (squared, in cells: all of the distance less z^2).
    there: 1, or 0 for none; wide, worn: draws in [0, 1)."""
    kept, depth, room, smaller, fresh = crater_sizes(z, root, there, wide, worn)
    square = aside / depth * smaller
    form, slope, covered, covered_slope, dug = crater_profile(k, square, kept, fresh)
    size = (room / smaller) ** 0.5
    narrow: Single = smaller
    square_by_vv: Single = narrow / depth
    return form, fresh, size, covered, square_by_vv, slope, covered_slope, dug


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
    """At square = (r / R)^2: the height by the radius and its slope by the square; how much of what is older is wiped
    out, 1 inside, 0 beyond the rim, and its slope; how freshly the ground is dug."""
    q = clamp(square, 0.0, 4.0)
    top = at_least(1.0 - PEAK_NARROW * q, 0.0)
    bottom = k.rim - k.bottom + k.peak * top * top
    bottom_slope: Single = -2.0 * PEAK_NARROW * k.peak * top
    bowl = k.rim + k.wall * (q - 1.0)
    foot_width: Single = 0.15 * k.bottom
    foot: Single = clamp(0.5 + 0.5 * (bowl - bottom) / foot_width, 0.0, 1.0)
    inside = bottom + (bowl - bottom) * foot + foot_width * foot * (1.0 - foot)
    inside_slope: Single = bottom_slope + (k.wall - bottom_slope) * foot
    left = (4.0 - q) * (1.0 / 3.0)
    outside = k.rim * left * left * left
    outside_slope: Single = -k.rim * (left * left)
    crest_width: Single = k.rim * (2.2 - 1.6 * fresh)
    crest: Single = clamp(0.5 + 0.5 * (outside - inside) / crest_width, 0.0, 1.0)
    form = outside + (inside - outside) * crest - crest_width * crest * (1.0 - crest)
    slope: Single = outside_slope + (inside_slope - outside_slope) * crest
    within = clamp(1.5 - q, 0.0, 1.0)
    beyond = 1.0 - within
    covered = kept * within * within * (3.0 - 2.0 * within)
    covered_slope: Single = -6.0 * (kept * within * beyond)
    dug: Single = at_least(4.0 * fresh - 3.0, 0.0) * at_most(left, 1.0)
    return form, slope, covered, covered_slope, dug


_MADE = Statements(Path(__file__).read_text(encoding="utf-8"), globals())
_ABOVE, _FORM, _CHANGED = (
    _MADE["crater_above"],
    _MADE["crater_form"],
    ("form", "d_form", "covered", "d_covered", "new_covered"),
)
_RELIEF = _FORM.only("crater_relief", ("form", "fresh", "size", "covered"))
_RISE = _MADE["crater_profile"].only("crater_rise", ("form", "covered"))
crater_relief = _MADE.python(_RELIEF)
"""crater_form without what slopes need."""
crater_slopes = _MADE.python(_FORM.only("crater_slopes", [name for name in _FORM.results if name != "dug"]))
crater_rise = _MADE.python(_RISE)
"""crater_profile without slopes."""


def scalars() -> list[str]:
    """Python of single numbers, to be compiled."""
    made = [_MADE[name] for name in ("crater_above", "crater_sizes", "crater_profile")]
    return [_MADE.scalar(f) for f in (*made, _RELIEF, _RISE)]


def shader() -> str:
    """GLSL: crater_above and crater_form in float, and with TERRAIN_CANONICAL in pairs; without it crater_form as a
    change by `aside`. What a crater is, its place above the sphere, width and wear, is the same from everywhere."""
    single, pairs = ("\n".join(_MADE.glsl(f, real) for f in (_ABOVE, _FORM)) for real in ("float", "Pair"))
    there = ("new_slope", "new_covered_slope", "new_dug")
    change = _MADE.glsl(_FORM.change(["aside"], (*_CHANGED, "fresh", "size", "square_by_vv", *there)), "float")
    return f"{single}\n#ifdef TERRAIN_CANONICAL\n{pairs}#else\n{change}#endif\n"
