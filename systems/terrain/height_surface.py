"""The point-wise part of the height function: from noises to metres.

Written once: `height_statements` makes the shader's functions and all derivatives of what follows, see
docs/terrain-height.md. Statements are the same for arrays and for plain floats: a single point is ten times faster in
floats.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from . import height_steps
from .height_model import GATE_LOW, GATE_SHUT, GATE_WIDTH, TerrainConstants
from .height_statements import Statements
from .height_steps import bump, positive, smoothstep

# -- statements: what they may be, and how the shader knows them, says height_statements -------------------------------


def surface(
    k: TerrainConstants, w1x: Any, w1y: Any, w1z: Any, c: Any, b: Any, sa: Any, sb: Any, z: Any,
    added: Any = 0.0, rougher: Any = 0.0,
) -> Any:  # fmt: skip
    """The point-wise part: height from the noises, metres `added` (craters, map) and roughness of the map's own. Serves
    floats and arrays."""
    base, rough, _, _ = surface_parts(k, w1x, w1y, w1z, c, b, sa, sb)
    ground = base + (rough + rougher) * z + added
    return limit(k, ground)


def surface_parts(
    k: TerrainConstants, w1x: Any, w1y: Any, w1z: Any, c: Any, b: Any, sa: Any, sb: Any
) -> tuple[Any, Any, Any, Any]:
    """Height without the relief layers, their multiplier (roughness), 0..1 where ranges stand, and x."""
    gate = GATE_SHUT + (1.0 - GATE_SHUT) * smoothstep((sa + GATE_LOW) * (1.0 / GATE_WIDTH))
    s = sa + gate * sb
    x = (c - k.sea_level) * k.inverse_deviation + k.coast * s
    belt = bump(b * k.inverse_belt)
    folded = smoothstep((w1x + 0.35) * 2.0)
    along = belt * folded
    shore = bump((x - 0.30) * (1.0 / 0.30))
    raised = smoothstep((w1y - 0.05) * (1.0 / 0.3))
    coastal = shore * raised * k.mountains
    belts = 1.0 - (1.0 - along) * (1.0 - coastal)
    dry = 0.3 + 0.7 * smoothstep((x + 0.5) * (1.0 / 0.6))
    on_land = belts * dry
    m = smoothstep((s + k.shape_low) * k.shape_inverse)
    hills = k.hills * smoothstep((w1z + 0.1) * 2.0)
    calm = k.gentle + hills * (1.0 - belts)
    rough = calm * (0.5 + m) + on_land * (k.calm + k.wild * m)
    base = hypsometry(k, x) + on_land * (k.foot_m + k.range_m * m) + calm * (k.hill_m * m)
    return base, rough, on_land, x


def hypsometry(k: TerrainConstants, x: Any) -> Any:
    """Metres by x, without ranges."""
    earth = (
        k.coast_m * smoothstep(x * 4.0)
        + k.lowland_m * x
        - k.slope_m * smoothstep((-0.10 - x) * (1.0 / 0.6))
        - k.abyss_m * smoothstep((-0.5 - x) * 0.5)
        + k.plateau_m * smoothstep((x - 0.4) * (1.0 / 1.2))
    )
    t = x * 0.6
    root = (1.0 + t * t) ** 0.5
    even = k.middle_m + k.spread_m * t / root
    return k.plains * earth + (1.0 - k.plains) * even


def limit(k: TerrainConstants, h: Any) -> Any:
    """The identity between the knees; approaches the bounds without reaching them outside. C1."""
    over = positive(h - k.knee_high_m)
    under = positive(k.knee_low_m - h)
    return h - over * over / (over + k.room_high_m) + under * under / (under + k.room_low_m)


def carve(h: Any, base: Any, open: Any, raised: Any) -> Any:
    """The ground where a river has cut it: `open` is what is left of its height above the river's own ground `base`,
    `raised` what is filled of its depth below that; deep under the sea nothing is."""
    over = positive(h - base)
    under = positive(base - h)
    emerged = smoothstep(1.0 + h * (1.0 / SUBMERGED_M))
    return h - (1.0 - open) * over + raised * emerged * under


SUBMERGED_M = 15.0


def side_rough(h: Any, base: Any, open: Any) -> Any:
    """Roughness that gullies alone have on a valley's side, most where half of its height is cut away: relief shrinks
    there, and what the river has cut off is steep."""
    over = positive(h - base)
    return SIDES * open * (1.0 - open) * over / (over + SIDES_M)


SIDES, SIDES_M = 6.0, 400.0

# -- what is made of them ----------------------------------------------------------------------------------------------

_MADE = Statements(Path(__file__).read_text(encoding="utf-8"), {**vars(height_steps), **globals()})
_SLOPES = {name: _MADE[name].slopes({}) for name in ("hypsometry", "limit", "carve", "side_rough")}
# Where the roughness changes, the ground shows the layers of z that its footprint shows.
_SLOPES["surface"] = _MADE["surface"].slopes({"z": "seen_z"}, ["on_land"])

hypsometry_slope, limit_slope = _MADE.python(_SLOPES["hypsometry"]), _MADE.python(_SLOPES["limit"])
carve_slopes = _MADE.python(_SLOPES["carve"])
"""(the inputs of `carve`) -> the height and its derivatives by them."""
side_rough_slopes = _MADE.python(_SLOPES["side_rough"])
"""(the inputs of `side_rough`) -> the roughness and its derivatives by them."""
surface_slopes = _MADE.python(_SLOPES["surface"])
"""(k, the inputs of `surface`, seen_z) -> the height, its derivatives by the inputs, and on_land."""
_PARTS = ("base", "rough", "on_land", "x")
_FALLING = _MADE["surface"].slopes({}, _PARTS)
_FALLING_SLOPES = _FALLING.only("falling_slopes", ["value", "by_sa", "by_sb", "by_z", *_PARTS])
falling_slopes = _MADE.python(_FALLING_SLOPES)
"""(k, the inputs of `surface`) -> the height, its derivatives by what may be steep, and what `surface_parts` gives."""


def scalars() -> list[str]:
    """Python of single numbers, to be compiled: statements, then derivatives."""
    made = [_MADE[name] for name in ("hypsometry", "limit", "surface_parts", "surface", "carve")]
    made += [_SLOPES[name] for name in ("hypsometry", "limit", "surface")]
    eroded = [_FALLING_SLOPES, _SLOPES["carve"], _MADE["side_rough"]]
    return [_MADE.scalar(f) for f in (*made, *eroded)]


def shader() -> str:
    """GLSL: the statements and their derivatives, after the functions that they call. With TERRAIN_CANONICAL the
    statements in pairs of floats, too, without it their changes."""
    parts = [f"// Made from {Path(__file__).name}.\n", '#include "generated/terrain_steps.glsl"\n']
    for name, slopes in _SLOPES.items():
        made = _MADE[name]
        pairs, change = _MADE.glsl(made, "Pair"), _MADE.glsl(made.change(), "float")
        parts += [_MADE.glsl(made, "float"), _MADE.glsl(slopes, "float")]
        parts += [f"#ifdef TERRAIN_CANONICAL\n{pairs}#else\n{change}#endif\n"]
    return "\n".join(parts)
