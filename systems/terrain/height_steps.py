"""Functions of one or two numbers that statements of the height function call, and their slopes: statements themselves,
made into the shader's functions by `height_statements`. Arrays and plain floats."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from .height_statements import Function, Statements, absolute, at_least, at_most, clamp, sign

RIDGE_TOP, RIDGE_SLOPE, RIDGE_ROUND = 0.30000001192092896, 1.899999976158142, 0.029999999329447746
"""Ridge transform: top - slope * |n|, its crest rounded off below |n| = round. Rounded to float32."""


def smoothstep(t: Any) -> Any:
    """3 t^2 - 2 t^3 of t clamped to [0, 1]."""
    u = clamp(t, 0.0, 1.0)
    return u * u * (3.0 - 2.0 * u)


def smoothstep_slope(t: Any) -> Any:
    u = clamp(t, 0.0, 1.0)
    return 6.0 * u * (1.0 - u)


def bump(t: Any) -> Any:
    """(1 - t^2)^2 inside [-1, 1], 0 outside."""
    inside = clamp(t, -1.0, 1.0)
    u = 1.0 - inside * inside
    return u * u


def bump_slope(t: Any) -> Any:
    return -4.0 * t * at_least(1.0 - t * t, 0.0)


def positive(t: Any) -> Any:
    """t where it is above 0, else 0."""
    return at_least(t, 0.0)


def positive_slope(t: Any) -> Any:
    return at_least(sign(t), 0.0)


def unit(t: Any) -> Any:
    """t clamped to [0, 1]."""
    return clamp(t, 0.0, 1.0)


def unit_slope(t: Any) -> Any:
    """1 inside (0, 1), 0 outside."""
    return positive_slope(t) * positive_slope(1.0 - t)


def layer_weight(wavelength_m: Any, spacing_m: Any) -> Any:
    """Share of a layer in band-limited gradients: 0 below two samples a wavelength, 1 from four on (Norton, Rockwood
    and Skolmoski 1982, "Clamping: a method of antialiasing textured surfaces by bandwidth limiting in object space").
    """
    return smoothstep(wavelength_m / spacing_m * 0.5 - 1.0)


def ridge(n: Any, share: Any) -> Any:
    """A layer's value from its noise: a mix of the noise and its ridges, top - slope |n| (Musgrave in Ebert et al.
    1994, "Texturing and Modeling"), the crest rounded. share: of the ridges, negative for their mirror image."""
    away = absolute(n)
    low = at_most(away, RIDGE_ROUND)
    rounded = away + (low * low * (0.5 / RIDGE_ROUND) - low)
    return (1.0 - absolute(share)) * n + share * (RIDGE_TOP - RIDGE_SLOPE * rounded)


def ridge_slope(n: Any, share: Any) -> Any:
    return 1.0 - absolute(share) - share * RIDGE_SLOPE * clamp(n / RIDGE_ROUND, -1.0, 1.0)


# -- changes, where t does by d, of what the statements above begin with. None rises where it is clamped, so it does not
# -- matter how exactly t is known there.


def clamp_change(t: Any, low: Any, high: Any, d: Any) -> Any:
    inside = clamp(t, low, high)
    return clamp((t - inside) + d, low - inside, high - inside)


def at_least_change(t: Any, low: Any, d: Any) -> Any:
    inside = at_least(t, low)
    return at_least((t - inside) + d, low - inside)


def at_most_change(t: Any, high: Any, d: Any) -> Any:
    inside = at_most(t, high)
    return at_most((t - inside) + d, high - inside)


def absolute_change(t: Any, d: Any) -> Any:
    """Of the part above 0, less that of the part below."""
    above = at_least(t, 0.0)
    below = at_most(t, 0.0)
    return at_least(below + d, -above) - at_most(above + d, -below)


_MADE = Statements(Path(__file__).read_text(encoding="utf-8"), globals())


_CHANGES = [_MADE[name].change(["t"]) for name in ("smoothstep", "bump", "positive")] + [_MADE["ridge"].change(["n"])]


def scalars() -> list[str]:
    """Python of single numbers, to be compiled, of what height_surface and height_octaves call."""
    return [_MADE.scalar(_MADE[name]) for name in ("smoothstep", "bump", "positive", "ridge", *_SCALAR_SLOPES)]


_SCALAR_SLOPES = ("smoothstep_slope", "bump_slope", "positive_slope", "ridge_slope", "layer_weight")


def shader() -> str:
    """GLSL: all of them in float, and with TERRAIN_CANONICAL, but for slopes, in pairs; without it their changes."""
    changes = [name for name in _MADE.names if name.endswith("_change")]
    singles = [name for name in _MADE.names if name not in changes]
    paired = [name for name in singles if not name.endswith("_slope")]

    def text(functions: Iterable[Function], real: str = "float") -> str:
        return "\n".join(_MADE.glsl(f, real) for f in functions)

    single, pairs = text(map(_MADE.__getitem__, singles)), text(map(_MADE.__getitem__, paired), "Pair")
    change = text([*map(_MADE.__getitem__, changes), *_CHANGES])
    return f"{single}\n#ifdef TERRAIN_CANONICAL\n{pairs}#else\n{change}#endif\n"
