"""The point-wise part of the height function: from noises to metres, and its derivative.

Statements are the same for arrays and for plain floats: a single point is ten times faster in floats. The shader
(terrain/height.glsl) follows this file line by line.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .height_model import GATE_LOW, GATE_SHUT, GATE_WIDTH, Constants

Floats = NDArray[np.float64]


def smoothstep(t: Any) -> Any:
    """3 t^2 - 2 t^3 of t clamped to [0, 1]; arrays and plain floats."""
    if isinstance(t, float):
        t = 0.0 if t < 0.0 else 1.0 if t > 1.0 else t
        return t * t * (3.0 - 2.0 * t)
    t = np.minimum(np.maximum(t, 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def smoothstep_slope(t: Any) -> Any:
    t = np.minimum(np.maximum(t, 0.0), 1.0)
    return 6.0 * t * (1.0 - t)


def bump(t: Any) -> Any:
    """(1 - t^2)^2 inside [-1, 1], 0 outside."""
    t = 1.0 - t * t
    t = (t if t > 0.0 else 0.0) if isinstance(t, float) else np.maximum(t, 0.0)
    return t * t


def bump_slope(t: Any) -> Any:
    return -4.0 * t * np.maximum(1.0 - t * t, 0.0)


def surface(
    k: Constants, w1x: Any, w1y: Any, w1z: Any, c: Any, b: Any, sa: Any, sb: Any, z: Any,
    added: Any = 0.0, rougher: Any = 0.0,
) -> Any:  # fmt: skip
    """The point-wise part: height from the noises, metres `added` (craters, map) and roughness of the map's own. Serves
    floats and arrays."""
    base, rough, _, _ = surface_parts(k, w1x, w1y, w1z, c, b, sa, sb)
    return limit(k, base + (rough + rougher) * z + added)


def surface_parts(
    k: Constants, w1x: Any, w1y: Any, w1z: Any, c: Any, b: Any, sa: Any, sb: Any
) -> tuple[Any, Any, Any, Any]:
    """Height without the relief layers, their multiplier (roughness), 0..1 where ranges stand, and x."""
    s = sa + (GATE_SHUT + (1.0 - GATE_SHUT) * smoothstep((sa + GATE_LOW) * (1.0 / GATE_WIDTH))) * sb
    x = (c - k.sea_level) * k.inverse_deviation + k.coast * s
    along = bump(b * k.inverse_belt) * smoothstep((w1x + 0.35) * 2.0)
    coastal = bump((x - 0.30) * (1.0 / 0.30)) * smoothstep((w1y - 0.05) * (1.0 / 0.3)) * k.mountains
    belts = 1.0 - (1.0 - along) * (1.0 - coastal)
    on_land = belts * (0.3 + 0.7 * smoothstep((x + 0.5) * (1.0 / 0.6)))
    m = smoothstep((s + k.shape_low) * k.shape_inverse)
    calm = k.flat + k.hills * smoothstep((w1z + 0.1) * 2.0) * (1.0 - belts)
    rough = calm * (0.5 + m) + on_land * (k.calm + k.wild * m)
    base = _hypsometry(k, x) + on_land * (k.foot_m + k.range_m * m) + calm * (k.hill_m * m)
    return base, rough, on_land, x


def _hypsometry(k: Constants, x: Any) -> Any:
    earth = (
        k.coast_m * smoothstep(x * 4.0)
        + k.lowland_m * x
        - k.slope_m * smoothstep((-0.10 - x) * (1.0 / 0.6))
        - k.abyss_m * smoothstep((-0.5 - x) * 0.5)
        + k.plateau_m * smoothstep((x - 0.4) * (1.0 / 1.2))
    )
    t = x * 0.6
    even = k.middle_m + k.spread_m * t / (1.0 + t * t) ** 0.5
    return k.plains * earth + (1.0 - k.plains) * even


def limit(k: Constants, h: Any) -> Any:
    """The identity between the knees; approaches the bounds without reaching them outside. C1."""
    over, under = h - k.knee_high_m, k.knee_low_m - h
    if isinstance(h, float):
        over, under = max(over, 0.0), max(under, 0.0)
    else:
        over, under = np.maximum(over, 0.0), np.maximum(under, 0.0)
    return h - over * over / (over + k.room_high_m) + under * under / (under + k.room_low_m)


def surface_gradient(
    k: Constants, w1: Floats, c: Floats, b: Floats, shapes: Floats, zs: tuple[Floats, Floats],
    dw1: Floats, dc: Floats, db: Floats, dshapes: Floats, dz: Floats, added: Any, d_added: Any,
    rougher: Any, d_rougher: Any,
) -> Floats:  # fmt: skip
    """`surface` differentiated: (3, N). `zs`: all of z for the limit, and the part of z seen at this footprint."""
    z, z_seen = zs
    sa, sb = shapes
    t_gate = (sa + GATE_LOW) * (1.0 / GATE_WIDTH)
    gate = GATE_SHUT + (1.0 - GATE_SHUT) * smoothstep(t_gate)
    s = sa + gate * sb
    ds = (1.0 + (1.0 - GATE_SHUT) / GATE_WIDTH * smoothstep_slope(t_gate) * sb) * dshapes[0] + gate * dshapes[1]
    x, dx = (c - k.sea_level) * k.inverse_deviation + k.coast * s, dc * k.inverse_deviation + k.coast * ds
    t_belt, t_w, t_coast, t_y = b * k.inverse_belt, (w1[0] + 0.35) * 2.0, (x - 0.30) / 0.30, (w1[1] - 0.05) / 0.3
    along = bump(t_belt) * smoothstep(t_w)
    d_along = bump_slope(t_belt) * k.inverse_belt * smoothstep(t_w) * db
    d_along += bump(t_belt) * smoothstep_slope(t_w) * 2.0 * dw1[0]
    coastal = bump(t_coast) * smoothstep(t_y) * k.mountains
    d_coastal = (bump_slope(t_coast) / 0.30 * smoothstep(t_y) * k.mountains) * dx
    d_coastal += (bump(t_coast) * smoothstep_slope(t_y) / 0.3 * k.mountains) * dw1[1]
    belts = 1.0 - (1.0 - along) * (1.0 - coastal)
    d_belts = (1.0 - coastal) * d_along + (1.0 - along) * d_coastal
    t_land = (x + 0.5) / 0.6
    share = 0.3 + 0.7 * smoothstep(t_land)
    on_land = belts * share
    d_land = d_belts * share + belts * (0.7 / 0.6 * smoothstep_slope(t_land)) * dx
    t_shape = (s + k.shape_low) * k.shape_inverse
    m, dm = smoothstep(t_shape), smoothstep_slope(t_shape) * k.shape_inverse * ds
    t_hill = (w1[2] + 0.1) * 2.0
    hills = k.hills * smoothstep(t_hill)
    calm = k.flat + hills * (1.0 - belts)
    d_calm = (k.hills * 2.0 * smoothstep_slope(t_hill) * (1.0 - belts)) * dw1[2] - hills * d_belts
    rough = calm * (0.5 + m) + on_land * (k.calm + k.wild * m)
    d_rough = d_calm * (0.5 + m) + calm * dm + d_land * (k.calm + k.wild * m) + on_land * k.wild * dm
    rough, d_rough = rough + rougher, d_rough + d_rougher
    slope = hypsometry_slope(k, x) * dx
    slope += d_land * (k.foot_m + k.range_m * m) + on_land * k.range_m * dm
    slope += k.hill_m * (d_calm * m + calm * dm)
    slope += d_rough * z_seen + rough * dz + d_added
    base = _hypsometry(k, x) + on_land * (k.foot_m + k.range_m * m) + calm * (k.hill_m * m) + rough * z + added
    return slope * _limit_slope(k, base)


def hypsometry_slope(k: Constants, x: Floats) -> Floats:
    """Derivative of the hypsometry by x."""
    earth = (
        k.coast_m * 4.0 * smoothstep_slope(x * 4.0)
        + k.lowland_m
        + k.slope_m / 0.6 * smoothstep_slope((-0.10 - x) / 0.6)
        + k.abyss_m * 0.5 * smoothstep_slope((-0.5 - x) * 0.5)
        + k.plateau_m / 1.2 * smoothstep_slope((x - 0.4) / 1.2)
    )
    t = x * 0.6
    even = k.spread_m * 0.6 / (1.0 + t * t) ** 1.5
    return k.plains * earth + (1.0 - k.plains) * even


def _limit_slope(k: Constants, h: Floats) -> Floats:
    over, under = np.maximum(h - k.knee_high_m, 0.0), np.maximum(k.knee_low_m - h, 0.0)
    return 1.0 / ((1.0 + over / k.room_high_m) * (1.0 + under / k.room_low_m)) ** 2
