"""The height function's octaves and surface as compiled loops: what height_octaves does in numpy, with the same bits.

Each operation is the one that numpy does, in the same order. (Batches of up to 32 points are summed by another library
there, in another order: the last bits may differ. Here all batches are summed alike.)
"""

from __future__ import annotations

from dataclasses import astuple
from functools import lru_cache
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Library, inlined
from ...engine.surface import noise_kernels
from ...engine.surface.noise_kernels import noise, vector
from . import height_steps, height_surface
from .height_model import FIELDS, Model, TerrainConstants, continent_weights

__all__ = ["heights", "layers", "parts"]

Floats = NDArray[np.float64]


@inlined
def clamp(t: float, low: float, high: float) -> float:
    t = t if t > low else low
    return t if t < high else high


@inlined
def at_least(t: float, low: float) -> float:
    return t if t > low else low


@inlined
def at_most(t: float, high: float) -> float:
    return t if t < high else high


@inlined
def absolute(t: float) -> float:
    return abs(t)


@inlined
def sign(t: float) -> float:
    return 1.0 if t > 0.0 else -1.0 if t < 0.0 else 0.0


def made(scope: dict[str, Any], texts: list[str]) -> None:
    """Adds functions of single numbers, written in Python, to a scope."""
    for text in texts:
        exec(text, scope)
        name = text[4 : text.index("(")]
        scope[name] = inlined(scope[name])


TEXTS = height_steps.scalars() + height_surface.scalars()
SCOPE: dict[str, Any] = {
    "sqrt": sqrt, "clamp": clamp, "at_least": at_least, "at_most": at_most, "absolute": absolute, "sign": sign,
}  # fmt: skip
made(SCOPE, TEXTS)
SCOPE["texts"] = [Path(__file__).read_text(encoding="utf-8"), *TEXTS]
_ridge, _surface, _surface_parts = SCOPE["ridge"], SCOPE["surface"], SCOPE["surface_parts"]
_hypsometry_slope = SCOPE["hypsometry_slope"]

_SOURCES = [Path(file).read_text(encoding="utf-8") for file in (__file__, noise_kernels.__file__)]
_library = Library("height", [*_SOURCES, *TEXTS])

CONTINENT_WEIGHTS, BELT_WEIGHTS = (tuple(row.tolist()) for row in continent_weights())
ROWS = 8
"""Of what `_noises` gives: w1 (3), c, b, both parts of s, z."""


@inlined
def row(offset: Any, k: int) -> Any:
    return offset[k, 0], offset[k, 1], offset[k, 2]


@_library.part
def octave(x: Any, y: Any, z: Any, frequency: Any, offset: Any, k: int, out: Any) -> None:
    """Gradient noise of octave k at points x, y, z."""
    f, o = frequency[k], row(offset, k)
    for n in range(len(out)):
        out[n] = noise((x[n], y[n], z[n]), f, o)


@_library.part
def vectors(x: Any, y: Any, z: Any, frequency: Any, offset: Any, k: int, out: Any) -> None:
    f, o = frequency[k], row(offset, k)
    for n in range(len(x)):
        out[0, n], out[1, n], out[2, n] = vector((x[n], y[n], z[n]), f, o)


@_library.part
def _add(values: Any, weight: float, total: Any) -> None:
    if weight != 0.0:
        for n in range(len(total)):
            total[n] += values[n] * weight


@_library.part
def _noises(points: Any, octaves: Any, warped_layers: int, rows: Any) -> None:
    """Rows (8, N) at points (3, N)."""
    unwarped, unwarped_offset, warped, warped_offset, warp_m, sums, ridge = octaves
    x, y, z = points[0], points[1], points[2]
    count, layers = points.shape[1], sums.shape[1]
    near, far, value = np.empty((3, count)), np.empty((3, count)), np.empty(count)
    for k in range(2):
        vectors(x, y, z, unwarped, unwarped_offset, k, near if k else rows)
    for axis in range(3):
        for n in range(count):
            near[axis, n] = near[axis, n] * warp_m[1] + points[axis, n]
            far[axis, n] = rows[axis, n] * warp_m[0] + near[axis, n]
    rows[3:] = 0.0
    for k in range(FIELDS):
        octave(far[0], far[1], far[2], warped, warped_offset, k, value)
        _add(value, CONTINENT_WEIGHTS[k], rows[3])
        _add(value, BELT_WEIGHTS[k], rows[4])
    for k in range(layers):
        if k < warped_layers:
            octave(near[0], near[1], near[2], warped, warped_offset, FIELDS + k, value)
        else:
            octave(x, y, z, unwarped, unwarped_offset, 2 + k - warped_layers, value)
        if k < len(ridge):
            share = ridge[k]
            for n in range(count):
                value[n] = _ridge(value[n], share)
        for row in range(3):
            _add(value, sums[row, k], rows[5 + row])


@_library.kernel
def _heights(points: Any, octaves: Any, warped_layers: int, k: Any, added: Any, rougher: Any, out: Any) -> None:
    r = np.empty((ROWS, points.shape[1]))
    _noises(points, octaves, warped_layers, r)
    for n in range(len(out)):
        out[n] = _surface(
            k, r[0, n], r[1, n], r[2, n], r[3, n], r[4, n], r[5, n], r[6, n], r[7, n], added[n], rougher[n]
        )


@_library.kernel
def _parts(points: Any, octaves: Any, warped_layers: int, k: Any, z: Any, out: Any) -> None:
    """z (N,), and what `surface_parts` gives (4, N), but how the hypsometry rises by x in place of x."""
    r = np.empty((ROWS, points.shape[1]))
    _noises(points, octaves, warped_layers, r)
    for n in range(len(z)):
        z[n] = r[7, n]
        out[0, n], out[1, n], out[2, n], x = _surface_parts(
            k, r[0, n], r[1, n], r[2, n], r[3, n], r[4, n], r[5, n], r[6, n]
        )
        out[3, n] = _hypsometry_slope(k, x)


@_library.kernel
def _layers(points: Any, frequency: Any, offset: Any, amplitude_m: Any, ridge: Any, total: Any) -> None:
    x, y, z = points[0], points[1], points[2]
    value = np.empty(len(total))
    total[:] = 0.0
    for k in range(len(frequency)):
        octave(x, y, z, frequency, offset, k, value)
        if k < len(ridge):
            for n in range(len(total)):
                value[n] = _ridge(value[n], ridge[k])
        _add(value, amplitude_m[k], total)


@lru_cache(maxsize=16)
def constants_of(k: TerrainConstants) -> tuple[float, ...]:
    """The `k` of statements."""
    return astuple(k)


def octaves_of(model: Model) -> tuple[Floats, ...]:
    """Frequencies and offsets of both lattices, and what their noises are multiplied with."""
    return (
        *(model.unwarped.frequency, model.unwarped.offset, model.warped.frequency, model.warped.offset),
        *(model.warp_m, model.sums, model.ridge_column[:, 0]),
    )


def each(values: Floats | float, count: int) -> Floats:
    """(N,) of one number, or of N."""
    return np.full(count, values) if isinstance(values, float) else np.ascontiguousarray(values)


def heights(points: Floats, model: Model, added: Floats | float, rougher: Floats | float) -> Floats:
    """Heights (N,) at points (3, N), without rivers and gullies. added, rougher: of craters and maps."""
    count = points.shape[1]
    out = np.empty(count)
    points, added, rougher = np.ascontiguousarray(points), each(added, count), each(rougher, count)
    _heights(points, octaves_of(model), model.warped_layers, constants_of(model.constants), added, rougher, out)
    return out


def parts(points: Floats, model: Model) -> tuple[Floats, Floats]:
    """What `surface_parts` gives (4, N), but `hypsometry_slope` in place of x, and z (N,), at points (3, N)."""
    z, out = np.empty(points.shape[1]), np.empty((4, points.shape[1]))
    _parts(np.ascontiguousarray(points), octaves_of(model), model.warped_layers, constants_of(model.constants), z, out)
    return out, z


def layers(points: Floats, frequency: Floats, offset: Floats, amplitude_m: Floats, ridge: Floats) -> Floats:
    """The sum (N,) of layers that no warp bends, at points (3, N). ridge: shares of those that come first."""
    total = np.empty(points.shape[1])
    _layers(np.ascontiguousarray(points), frequency, offset, amplitude_m, ridge, total)
    return total
