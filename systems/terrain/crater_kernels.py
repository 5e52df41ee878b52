"""Craters as compiled loops: what craters.py and crater_paths.py do in numpy, with the same bits.

Each operation is the one that numpy does, in the same order, and so are the lists of craters along stretches.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Library, inlined
from . import crater_form
from .craters import OTHER, SHIFTS, STEPS, Craters
from .height_kernels import SCOPE, made

__all__ = ["heights", "octave_heights"]

Floats = NDArray[np.float64]

TEXTS = crater_form.scalars()
FORMS = dict(SCOPE)
made(FORMS, TEXTS)
_above, _relief = FORMS["crater_above"], FORMS["crater_relief"]
FORMS["texts"] = [Path(__file__).read_text(encoding="utf-8"), *SCOPE["texts"], *TEXTS]
_library = Library("craters", FORMS["texts"])

_word, _whole = np.uint32, np.int32
_STEP_X, _STEP_Y, _STEP_Z = (_word(step) for step in STEPS)
_SHIFT_X, _SHIFT_Y, _SHIFT_Z, _SHIFT_DRAW = (_word(shift) for shift in SHIFTS)
_TEN, _TWELVE, _BITS_15, _BITS_16 = _word(1023), _word(4095), _word(15), _word(16)
_BITS_12, _FIRST, _SECOND, _OTHER, _ONE = _word(12), _word(0x7FEB352D), _word(0x846CA68B), _word(OTHER), _word(1)


@inlined
def mixed(x: Any) -> Any:
    """lowbias32."""
    x = _word(_word(x ^ (x >> _BITS_16)) * _FIRST)
    x = _word(_word(x ^ (x >> _BITS_15)) * _SECOND)
    return _word(x ^ (x >> _BITS_16))


@inlined
def hashed(x: Any, y: Any, z: Any) -> Any:
    """The word of a cell."""
    return mixed(_word(_word(x * _STEP_X) + _word(y * _STEP_Y) + _word(z * _STEP_Z)))


@inlined
def inside(word: Any) -> tuple[float, float, float]:
    """Where in its cell a crater's place is."""
    return (
        (float(_whole(word & _TEN)) + 0.5) * (1.0 / 1024.0),
        (float(_whole(word >> _SHIFT_Y & _TEN)) + 0.5) * (1.0 / 1024.0),
        (float(_whole(word >> _SHIFT_Z & _TEN)) + 0.5) * (1.0 / 1024.0),
    )


@inlined
def draws(word: Any) -> Any:
    """The draw that `accept` is for, and two numbers in [0, 1) for width and wear."""
    word = mixed(_word(word ^ _OTHER))
    wide, worn = _whole(word & _TWELVE), _whole(word >> _BITS_12 & _TWELVE)
    return _whole(word >> _SHIFT_DRAW), wide * (1.0 / 4096.0), worn * (1.0 / 4096.0)


@inlined
def _candidate(x: Any, y: Any, z: Any, p: Any, age: int) -> Any:
    """Of the eight cells around a place, at `p` (3) from the middle between them, the one of that age: its word, and
    the way (3) from its crater's place. x, y, z: words of the lowest cell."""
    sx = _word((x & _ONE) ^ _word(age & 1))
    sy = _word((y & _ONE) ^ _word(age >> 1 & 1))
    sz = _word((z & _ONE) ^ _word(age >> 2 & 1))
    word = hashed(_word(x + sx), _word(y + sy), _word(z + sz))
    at = inside(word)
    v = (p[0] + 0.5 - _whole(sx) - at[0], p[1] + 0.5 - _whole(sy) - at[1], p[2] + 0.5 - _whole(sz) - at[2])
    return word, v


@inlined
def _place(point: Any, n: int, frequency: float, offset: Any, k: int) -> Any:
    """Words of the lowest of the eight cells around a point, and where between them it is."""
    x = point[0, n] * frequency + offset[k, 0] - 0.5
    y = point[1, n] * frequency + offset[k, 1] - 0.5
    z = point[2, n] * frequency + offset[k, 2] - 0.5
    bx, by, bz = np.floor(x), np.floor(y), np.floor(z)
    return _word(_whole(bx)), _word(_whole(by)), _word(_whole(bz)), (x - bx, y - by, z - bz)


@_library.part
def _octave(
    points: Any, radius_m: float, frequency: float, offset: Any, shape: Any, k: int, accept: int, out: Any
) -> None:
    """Metres that octave k adds at points (3, N)."""
    near = np.empty(points.shape[1], np.uint8)
    for n in range(len(near)):
        x, y, z, p = _place(points, n, frequency, offset, k)
        mask = _word(0)
        for age in range(8):
            _, v = _candidate(x, y, z, p, age)
            if v[0] * v[0] + v[1] * v[1] + v[2] * v[2] < 0.25:
                mask |= _word(1 << age)
        near[n] = mask
    form = shape[k, 0], shape[k, 1], shape[k, 2], shape[k, 3]
    curve = 1.0 / (radius_m * frequency)
    for n in range(len(near)):
        total = 0.0
        if near[n]:
            x, y, z, p = _place(points, n, frequency, offset, k)
            for age in range(8):
                if near[n] >> age & 1:
                    word, v = _candidate(x, y, z, p, age)
                    draw, wide, worn = draws(word)
                    if draw < accept:
                        vv = v[0] * v[0] + v[1] * v[1] + v[2] * v[2]
                        along = (v[0] * points[0, n] + v[1] * points[1, n] + v[2] * points[2, n]) / radius_m
                        up, root = _above(vv, along, curve)
                        high, fresh, size, wiped = _relief(form, vv - up * up, up, root, 1.0, wide, worn)
                        total = total * (1.0 - wiped) + high * fresh / frequency * size
        out[n] = total


@_library.kernel
def _octaves(points: Any, radius_m: float, frequency: Any, offset: Any, shape: Any, accept: int, out: Any) -> None:
    for k in range(len(frequency)):
        _octave(points, radius_m, frequency[k], offset, shape, k, accept, out[k])


@_library.kernel
def _heights(points: Any, radius_m: float, frequency: Any, offset: Any, shape: Any, accept: int, total: Any) -> None:
    part = np.empty(len(total))
    total[:] = 0.0
    for k in range(len(frequency)):
        _octave(points, radius_m, frequency[k], offset, shape, k, accept, part)
        for n in range(len(total)):
            total[n] += part[n]


def heights(craters: Craters, points: Floats) -> Floats:
    """Heights (N,) that craters add at points (3, N)."""
    total = np.empty(points.shape[1])
    c = craters
    _heights(np.ascontiguousarray(points), c.radius_m, c.frequency, c.offset, c.shape, c.accept, total)
    return total


def octave_heights(craters: Craters, points: Floats) -> Floats:
    """Heights (K, N) that each octave adds at points (3, N)."""
    out = np.empty((len(craters), points.shape[1]))
    c = craters
    _octaves(np.ascontiguousarray(points), c.radius_m, c.frequency, c.offset, c.shape, c.accept, out)
    return out
