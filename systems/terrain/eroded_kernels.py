"""Ground with gullies as compiled loops: what height_eroded.py does in numpy for heights.

Sums over layers, sines and cosines are those of other libraries there: results agree to a hundred-millionth of a metre.
"""

from __future__ import annotations

from math import cos, sin, sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Library, inlined
from ...engine.surface.noise import GRADIENT_SCALE
from ...engine.surface.noise_kernels import cell, noise_slope, quintic
from .gullies import AMPLITUDE, CREST, END_GULLY, FALLING_LAYERS, FIRST_GULLY, FULL, LEAST, ROUND, TURN
from .height_kernels import BELT_WEIGHTS, CONTINENT_WEIGHTS, SCOPE, constants_of, each, octave, octaves_of, row, vectors
from .height_model import FIELDS, Model
from .height_steps import RIDGE_SLOPE
from .rivers.valleys import Valleys

__all__ = ["eroded"]

Floats = NDArray[np.float64]

_library = Library("eroded", [Path(__file__).read_text(encoding="utf-8"), *SCOPE["texts"]])
_ridge, _falling, _hypsometry_slope = SCOPE["ridge"], SCOPE["falling_slopes"], SCOPE["hypsometry_slope"]
_carve_slopes, _side_rough, _clamp = SCOPE["carve_slopes"], SCOPE["side_rough"], SCOPE["clamp"]

_GULLIES = END_GULLY - FIRST_GULLY


@inlined
def _turned(a: Any, b: Any, near: float, turned: float, across: float) -> tuple[float, float]:
    """Between two complex numbers, the other one turned."""
    return a[0] * near + (b[0] * turned + b[1] * across), a[1] * near + (b[1] * turned - b[0] * across)


@inlined
def _wave(p: Any, frequency: float, offset: Any, along: Any) -> tuple[float, float]:
    """`wave_values` of the lattice's cell around a point (3)."""
    f, g = cell(p, frequency, offset)
    angle = along[0] * TURN, along[1] * TURN, along[2] * TURN
    there = angle[0] * f[0] + angle[1] * f[1] + angle[2] * f[2]
    far = quintic(f[0])
    near, turned, across = 1.0 - far, far * cos(angle[0]), far * sin(angle[0])
    a = _turned(g[0], g[1], near, turned, across)
    b = _turned(g[2], g[3], near, turned, across)
    c = _turned(g[4], g[5], near, turned, across)
    d = _turned(g[6], g[7], near, turned, across)
    far = quintic(f[1])
    near, turned, across = 1.0 - far, far * cos(angle[1]), far * sin(angle[1])
    a, c = _turned(a, b, near, turned, across), _turned(c, d, near, turned, across)
    far = quintic(f[2])
    a = _turned(a, c, 1.0 - far, far * cos(angle[2]), far * sin(angle[2]))
    real, imaginary = a[0] * GRADIENT_SCALE, a[1] * GRADIENT_SCALE
    inverse = 1.0 / sqrt(real * real + imaginary * imaginary + ROUND)
    cosine, sine = cos(there) * inverse, sin(there) * inverse
    return real * cosine - imaginary * sine, real * sine + imaginary * cosine


@inlined
def _crest(n: float, share: float) -> float:
    """`crest_slopes`"""
    return 1.0 - abs(share) - share * RIDGE_SLOPE * _clamp(n * (1.0 / CREST), -1.0, 1.0)


@_library.part
def _slopes(x: Any, y: Any, z: Any, frequency: Any, offset: Any, k: int, value: Any, slope: Any) -> None:
    """Gradient noise of octave k and its derivatives by metre."""
    f, o = frequency[k], row(offset, k)
    for n in range(len(value)):
        value[n], sx, sy, sz = noise_slope((x[n], y[n], z[n]), f, o)
        slope[0, n], slope[1, n], slope[2, n] = sx * f, sy * f, sz * f


@_library.kernel
def _eroded(
    points: Any, octaves: Any, warped_layers: int, k: Any, amplitude_m: Any, strength: float, radius_m: float,
    added: Any, rougher: Any, cut: Any, carved: bool, z: Any, furrows: Any, out: Any,
) -> None:  # fmt: skip
    """z, furrows (N,) and parts (4, N). cut (6, N): base, open, raised and the slope of open, if anything is carved."""
    unwarped, unwarped_offset, warped, warped_offset, warp_m, sums, ridge = octaves
    count, layers = points.shape[1], sums.shape[1]
    x, y, up = points[0], points[1], points[2]
    near, far, w1 = np.empty((3, count)), np.empty((3, count)), np.empty((3, count))
    for i in range(2):
        vectors(x, y, up, unwarped, unwarped_offset, i, near if i else w1)
    for axis in range(3):
        for n in range(count):
            near[axis, n] = near[axis, n] * warp_m[1] + points[axis, n]
            far[axis, n] = w1[axis, n] * warp_m[0] + near[axis, n]
    value, c, b = np.empty(count), np.zeros(count), np.zeros(count)
    for i in range(FIELDS):
        octave(far[0], far[1], far[2], warped, warped_offset, i, value)
        for n in range(count):
            c[n] += value[n] * CONTINENT_WEIGHTS[i]
            b[n] += value[n] * BELT_WEIGHTS[i]
    v, slope = np.empty((layers, count)), np.empty((FALLING_LAYERS, 3, count))
    for i in range(layers):
        if i < FALLING_LAYERS:
            _slopes(near[0], near[1], near[2], warped, warped_offset, FIELDS + i, v[i], slope[i])
        elif i < warped_layers:
            octave(near[0], near[1], near[2], warped, warped_offset, FIELDS + i, v[i])
        else:
            octave(x, y, up, unwarped, unwarped_offset, 2 + i - warped_layers, v[i])
    noise = v[:FALLING_LAYERS].copy()
    for i in range(len(ridge)):
        for n in range(count):
            v[i, n] = _ridge(v[i, n], ridge[i])
    end = min(END_GULLY, layers)
    share, wave = np.empty(_GULLIES), np.empty(_GULLIES)
    for n in range(count):
        total_a = total_b = total_z = 0.0
        for i in range(FALLING_LAYERS):
            total_a += sums[0, i] * v[i, n]
            total_b += sums[1, i] * v[i, n]
            total_z += sums[2, i] * v[i, n]
        height, by_a, by_b, rough, base, out[1, n], out[2, n], by = _falling(
            k, w1[0, n], w1[1, n], w1[2, n], c[n], b[n], total_a, total_b, total_z, added[n], rougher[n]
        )
        out[0, n], out[3, n] = base, _hypsometry_slope(k, by)
        fx = fy = fz = 0.0
        for i in range(FALLING_LAYERS):
            share_i = ridge[i] if i < len(ridge) else 0.0
            weight = (sums[0, i] * by_a + sums[1, i] * by_b + sums[2, i] * rough) * _crest(noise[i, n], share_i)
            fx += weight * slope[i, 0, n]
            fy += weight * slope[i, 1, n]
            fz += weight * slope[i, 2, n]
        if carved:
            _, by_h, _, open_m, _ = _carve_slopes(height, cut[0, n], cut[1, n], cut[2, n])
            rough = by_h * rough + _side_rough(height, cut[0, n], cut[1, n])
            fx = by_h * fx + open_m * cut[3, n]
            fy = by_h * fy + open_m * cut[4, n]
            fz = by_h * fz + open_m * cut[5, n]
        ux, uy, uz = x[n] * (1.0 / radius_m), y[n] * (1.0 / radius_m), up[n] * (1.0 / radius_m)
        along_up = ux * fx + uy * fy + uz * fz
        fx -= ux * along_up
        fy -= uy * along_up
        fz -= uz * along_up
        square = fx * fx + fy * fy + fz * fz
        furrows[n] = 0.0
        if square > LEAST * LEAST:
            steep = sqrt(square)
            inverse = 1.0 / max(steep, 1e-6)
            fx *= inverse
            fy *= inverse
            fz *= inverse
            sx, sy, sz = uy * fz - uz * fy, uz * fx - ux * fz, ux * fy - uy * fx
            p, q = steep, 0.0
            for i in range(FIRST_GULLY, end):
                t = _clamp((steep - LEAST) * (1.0 / (FULL - LEAST)), 0.0, 1.0)
                share[i - FIRST_GULLY] = t * t * (3.0 - 2.0 * t) * strength
                inverse = 1.0 / max(steep, 1e-6)
                ahead, aside = q * -inverse, p * inverse
                along = ahead * fx + aside * sx, ahead * fy + aside * sy, ahead * fz + aside * sz
                if i < warped_layers:
                    where, f, o = (
                        (near[0, n], near[1, n], near[2, n]),
                        warped[FIELDS + i],
                        row(warped_offset, FIELDS + i),
                    )
                else:
                    plain = 2 + i - warped_layers
                    where, f, o = (x[n], y[n], up[n]), unwarped[plain], row(unwarped_offset, plain)
                found, pull = _wave(where, f, o, along)
                wave[i - FIRST_GULLY] = found * AMPLITUDE
                pull *= share[i - FIRST_GULLY] * rough * -(AMPLITUDE * TURN * amplitude_m[i] * f)
                p, q = p + pull * ahead, q + pull * aside
                steep = sqrt(p * p + q * q)
            for i in range(FIRST_GULLY, end):
                own = share[i - FIRST_GULLY]
                v[i, n] += own * (wave[i - FIRST_GULLY] - v[i, n])
                furrows[n] += amplitude_m[i] * (own * wave[i - FIRST_GULLY])
        total = 0.0
        for i in range(layers):
            total += sums[2, i] * v[i, n]
        z[n] = total


def eroded(points: Floats, model: Model, added: tuple[Any, Any], cut: Valleys | None) -> tuple[Floats, Floats, Floats]:
    """What `surface_parts` gives (4, N), but `hypsometry_slope` in place of x; z and what of it is gullies (N,)."""
    count = points.shape[1]
    z, furrows, out = np.empty(count), np.empty(count), np.empty((4, count))
    valleys = np.empty((6, 0))
    if cut is not None:
        assert cut.d_open is not None
        valleys = np.stack([cut.base_m, cut.open, cut.raised, *cut.d_open])
    metres, rougher = (each(v, count) for v in added)
    _eroded(
        np.ascontiguousarray(points), octaves_of(model), model.warped_layers, constants_of(model.constants),
        model.amplitude_m, model.params.erosion, model.params.radius_m, metres, rougher, valleys, cut is not None,
        z, furrows, out,
    )  # fmt: skip
    return out, z, furrows
