"""Noise of noise.py for single numbers, to be compiled: the same operations in the same order, so the same bits.

Loops over points that call these compute several points at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..compiled import inlined
from .noise import GRADIENT_SCALE

__all__ = ["cell", "noise", "noise_slope", "quintic", "vector"]

_MUL, _ADD, _SIXTEEN, _EIGHT = np.uint32(1664525), np.uint32(1013904223), np.uint32(16), np.int32(8)
_word, _whole = np.uint32, np.int32


@inlined
def _first(cell: float) -> Any:
    """PCG3D's first step."""
    return _word(_word(_whole(cell)) * _MUL + _ADD)


@inlined
def _corner(ax: Any, ay: Any, az: Any) -> tuple[float, float, float]:
    """The rest of PCG3D, as a gradient in units of GRADIENT_SCALE."""
    x = _word(az * ay + ax)
    y = _word(x * az + ay)
    z = _word(x * y + az)
    x = _word(x ^ (x >> _SIXTEEN))
    y = _word(y ^ (y >> _SIXTEEN))
    z = _word(z ^ (z >> _SIXTEEN))
    x = _word(x + _word(y * z))
    y = _word(y + _word(z * x))
    z = _word(z + _word(x * y))
    return float(_whole(x) >> _EIGHT), float(_whole(y) >> _EIGHT), float(_whole(z) >> _EIGHT)


@inlined
def quintic(f: float) -> float:
    """The weight of the far corner."""
    t = f - 0.5
    square = t * t
    return ((square * 6.0 - 5.0) * square + 1.875) * t + 0.5


@inlined
def _quintic_slope(f: float) -> float:
    return 30.0 * f * f * (f * (f - 2.0) + 1.0)


@inlined
def _dot(g: tuple[float, float, float], dx: float, dy: float, dz: float) -> float:
    return g[2] * dz + g[1] * dy + g[0] * dx


@inlined
def _mix(a: float, b: float, u: float) -> float:
    return (b - a) * u + a


@inlined
def _between(a: Any, u: float, v: float, w: float) -> float:
    """Trilinear interpolation of eight numbers."""
    near = _mix(_mix(a[0], a[1], u), _mix(a[2], a[3], u), v)
    return _mix(near, _mix(_mix(a[4], a[5], u), _mix(a[6], a[7], u), v), w)


@inlined
def _between_slopes(a: Any, u: Any, du: Any) -> tuple[float, float, float, float]:
    """And its derivatives through the weights u (3), whose slopes are du."""
    d0, d1, d2, d3 = a[1] - a[0], a[3] - a[2], a[5] - a[4], a[7] - a[6]
    x0, x1, x2, x3 = d0 * u[0] + a[0], d1 * u[0] + a[2], d2 * u[0] + a[4], d3 * u[0] + a[6]
    y0, y1 = x1 - x0, x3 - x2
    by_x = _mix(_mix(d0, d1, u[1]), _mix(d2, d3, u[1]), u[2])
    by_y = _mix(y0, y1, u[2])
    low, high = y0 * u[1] + x0, y1 * u[1] + x2
    by_z = high - low
    return by_z * u[2] + low, by_x * du[0], by_y * du[1], by_z * du[2]


@inlined
def cell(p: Any, frequency: float, offset: Any) -> Any:
    """The fractions (3) at a point (3), and gradients (3) of the eight corners, x first."""
    x, y, z = p[0] * frequency + offset[0], p[1] * frequency + offset[1], p[2] * frequency + offset[2]
    bx, by, bz = np.floor(x), np.floor(y), np.floor(z)
    ax, ay, az = _first(bx), _first(by), _first(bz)
    cx, cy, cz = _word(ax + _MUL), _word(ay + _MUL), _word(az + _MUL)
    corners = (
        _corner(ax, ay, az), _corner(cx, ay, az), _corner(ax, cy, az), _corner(cx, cy, az),
        _corner(ax, ay, cz), _corner(cx, ay, cz), _corner(ax, cy, cz), _corner(cx, cy, cz),
    )  # fmt: skip
    return (x - bx, y - by, z - bz), corners


@inlined
def _dots(f: Any, g: Any) -> Any:
    """Gradients times the way from their corners."""
    x, y, z = f
    ex, ey, ez = x - 1.0, y - 1.0, z - 1.0
    return (
        _dot(g[0], x, y, z), _dot(g[1], ex, y, z), _dot(g[2], x, ey, z), _dot(g[3], ex, ey, z),
        _dot(g[4], x, y, ez), _dot(g[5], ex, y, ez), _dot(g[6], x, ey, ez), _dot(g[7], ex, ey, ez),
    )  # fmt: skip


@inlined
def _axis(g: Any, axis: int) -> Any:
    return (g[0][axis], g[1][axis], g[2][axis], g[3][axis], g[4][axis], g[5][axis], g[6][axis], g[7][axis])


@inlined
def noise(p: Any, frequency: float, offset: Any) -> float:
    """Gradient noise at a point (3): `Corners.noise`."""
    f, g = cell(p, frequency, offset)
    return _between(_dots(f, g), quintic(f[0]), quintic(f[1]), quintic(f[2])) * GRADIENT_SCALE


@inlined
def vector(p: Any, frequency: float, offset: Any) -> tuple[float, float, float]:
    """Vector value noise (3) at a point (3): `Corners.vector`."""
    f, g = cell(p, frequency, offset)
    u, v, w = quintic(f[0]), quintic(f[1]), quintic(f[2])
    return (
        _between(_axis(g, 0), u, v, w) * GRADIENT_SCALE,
        _between(_axis(g, 1), u, v, w) * GRADIENT_SCALE,
        _between(_axis(g, 2), u, v, w) * GRADIENT_SCALE,
    )


@inlined
def noise_slope(p: Any, frequency: float, offset: Any) -> tuple[float, float, float, float]:
    """Gradient noise and its derivatives by the lattice coordinate: `Corners.noise_derivative`."""
    f, g = cell(p, frequency, offset)
    u = (quintic(f[0]), quintic(f[1]), quintic(f[2]))
    du = (_quintic_slope(f[0]), _quintic_slope(f[1]), _quintic_slope(f[2]))
    value, x, y, z = _between_slopes(_dots(f, g), u, du)
    return (
        value * GRADIENT_SCALE,
        (x + _between(_axis(g, 0), u[0], u[1], u[2])) * GRADIENT_SCALE,
        (y + _between(_axis(g, 1), u[0], u[1], u[2])) * GRADIENT_SCALE,
        (z + _between(_axis(g, 2), u[0], u[1], u[2])) * GRADIENT_SCALE,
    )
