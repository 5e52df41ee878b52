"""How much of its ground a forest's crowns cover, and how wide they are where they are drawn in cells of a lattice."""

from __future__ import annotations

import math

from .nested import NESTED_BASE_M

__all__ = ["CROWNS_FROM", "crown_octave", "crown_share", "mean_crown_m"]

CROWNS_FROM = 0.62
"""Share of the trees' reach from which on such crowns show, and solid trees shrink; as in
assets/shaders/terrain/forest.glsl."""


def crown_share(density: float, height_m: float, spacing_m: float) -> float:
    """Area of all crowns of a deep forest of broadleaves over the area of its ground: the mean of what
    systems/cover/stand.py makes there. As the component Cover has them."""
    grown_2 = 0.45**2 + 2.0 * 0.45 * 0.65 * 2.0 / 3.0 + 0.65**2 / 2.0
    radius_2 = (0.30 * height_m) ** 2 * grown_2
    return min(density, 1.0) * math.pi * radius_2 / spacing_m**2


def crown_octave(spacing_m: float) -> int:
    """Of the cells in which crowns far away stand: NESTED_BASE_M times 2 to this is nearest to spacing_m."""
    return round(math.log2(spacing_m / NESTED_BASE_M))


def mean_crown_m(share: float, spacing_m: float) -> float:
    """Mean radius of a crown, one in each of these cells, where they cover that share of the ground."""
    return NESTED_BASE_M * 2.0 ** crown_octave(spacing_m) * math.sqrt(share / math.pi)
