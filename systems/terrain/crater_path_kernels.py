"""Craters along stretches of rays as compiled loops: what crater_paths.py does in numpy, with the same bits and order.

Lists are pairs of arrays: whole numbers (3, C) of stretch, octave and age, and the other columns of `CraterPaths`
(11, C) in their order. They are sorted by stretch, octave and age.
"""

from __future__ import annotations

from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.compiled import Library, inlined
from .crater_kernels import FORMS, draws, hashed, inside
from .craters import Craters

__all__ = ["found", "halves", "joined", "kept", "rise"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]
Lists = tuple[Ints, Floats]

_library = Library("crater_paths", [Path(__file__).read_text(encoding="utf-8"), *FORMS["texts"]])
_above, _sizes, _rise_of = FORMS["crater_above"], FORMS["crater_sizes"], FORMS["crater_rise"]

_word, _whole = np.uint32, np.int32
REACH = 2.0
"""Ejecta end at so many radii."""
_X, _Y, _Z, _INVERSE, _RELIEF, _FRESH, _KEPT, _A, _B, _HEIGHT_A, _HEIGHT_B = range(11)
COLUMNS = 11


@inlined
def _form(shape: Any, k: int) -> Any:
    return shape[k, 0], shape[k, 1], shape[k, 2], shape[k, 3]


@inlined
def _height(shape: Any, k: int, away: float, kept: float, fresh: float, relief_m: float) -> tuple[float, float]:
    """Of a crater alone, and how much of what is older it wipes out."""
    form, covered = _rise_of(_form(shape, k), away * away, kept, fresh)
    return relief_m * form, covered


@inlined
def _distance(x: float, y: float, z: float, centre: Any, i: int) -> float:
    dx, dy, dz = x - centre[_X, i], y - centre[_Y, i], z - centre[_Z, i]
    return sqrt(dx * dx + dy * dy + dz * dz)


@_library.part
def _grown(whole: Any, other: Any) -> Any:
    """The lists with room for twice as many."""
    room = 2 * whole.shape[1]
    more_whole, more_other = np.empty((3, room), np.int64), np.empty((COLUMNS, room))
    more_whole[:, : whole.shape[1]] = whole
    more_other[:, : whole.shape[1]] = other
    return more_whole, more_other


@_library.part
def _ended(whole: Any, other: Any, count: int) -> Any:
    return whole[:, :count].copy(), other[:, :count].copy()


@_library.kernel
def _found(
    radius_m: float, frequency: Any, offset: Any, shape: Any, accept: int, first: int, last: int,
    ends_a: Any, ends_b: Any, length_m: Any, sums_a: Any, sums_b: Any,
) -> Any:  # fmt: skip
    """Craters of octaves from `first` to before `last` along stretches between places (3, S), and what they add at both
    ends (S,)."""
    whole, other = np.empty((3, 1024), np.int64), np.empty((COLUMNS, 1024))
    count = 0
    ages, order = np.empty(27, np.int64), np.empty((6, 27))
    words, apart = np.empty(27, np.uint32), np.empty(27)
    for s in range(len(length_m)):
        mx = 0.5 * (ends_a[0, s] + ends_b[0, s])
        my = 0.5 * (ends_a[1, s] + ends_b[1, s])
        mz = 0.5 * (ends_a[2, s] + ends_b[2, s])
        scale = radius_m / sqrt(mx * mx + my * my + mz * mz)
        mx *= scale
        my *= scale
        mz *= scale
        sums_a[s] = 0.0
        sums_b[s] = 0.0
        for k in range(first, last):
            f = frequency[k]
            x, y, z = mx * f + offset[k, 0], my * f + offset[k, 1], mz * f + offset[k, 2]
            cx, cy, cz = np.floor(x), np.floor(y), np.floor(z)
            x -= cx
            y -= cy
            z -= cz
            half = 0.5 + 0.5 * length_m[s] * f
            reach = half * half
            cell_x, cell_y, cell_z = _word(_whole(cx) - 1), _word(_whole(cy) - 1), _word(_whole(cz) - 1)
            for i in range(27):  # several at once, most of which are too far away
                jx, jy, jz = i % 3, i // 3 % 3, i // 9
                word = hashed(_word(cell_x + _word(jx)), _word(cell_y + _word(jy)), _word(cell_z + _word(jz)))
                px, py, pz = inside(word)
                wx, wy, wz = x - (jx - 1.0) - px, y - (jy - 1.0) - py, z - (jz - 1.0) - pz
                words[i] = word
                apart[i] = wx * wx + wy * wy + wz * wz
            there = 0
            for i in range(27):
                if not apart[i] < reach:
                    continue
                draw, wide, worn = draws(words[i])
                if not draw < accept:
                    continue
                jx, jy, jz = i % 3, i // 3 % 3, i // 9
                px, py, pz = inside(words[i])
                px = (cx + (jx - 1.0) + px - offset[k, 0]) / f
                py = (cy + (jy - 1.0) + py - offset[k, 1]) / f
                pz = (cz + (jz - 1.0) + pz - offset[k, 2]) / f
                away = sqrt(px * px + py * py + pz * pz)
                kept, _, room, smaller, fresh = _sizes((away - radius_m) * f, away * (1.0 / radius_m), 1.0, wide, worn)
                if not kept > 0.0:
                    continue
                odd_x, odd_y, odd_z = cell_x + _word(jx), cell_y + _word(jy), cell_z + _word(jz)
                ages[there] = (odd_x & 1) + 2 * (odd_y & 1) + 4 * (odd_z & 1)
                onto = radius_m / away
                order[0, there], order[1, there], order[2, there] = px * onto, py * onto, pz * onto
                order[3, there] = sqrt(smaller / room) * f
                order[4, there] = fresh
                order[5, there] = kept
                there += 1
            total_a = total_b = 0.0
            rank = 0
            for age in range(8):
                for i in range(there):
                    if ages[i] != age:
                        continue
                    inverse, fresh, kept = order[3, i], order[4, i], order[5, i]
                    a = _distance(ends_a[0, s], ends_a[1, s], ends_a[2, s], order, i) * inverse
                    b = _distance(ends_b[0, s], ends_b[1, s], ends_b[2, s], order, i) * inverse
                    if not 0.5 * (a + b - length_m[s] * inverse) < REACH:
                        continue
                    if count == whole.shape[1]:
                        whole, other = _grown(whole, other)
                    whole[0, count], whole[1, count], whole[2, count] = s, k, age
                    relief_m = fresh / inverse
                    height_a, cover_a = _height(shape, k, a, kept, fresh, relief_m)
                    height_b, cover_b = _height(shape, k, b, kept, fresh, relief_m)
                    other[_X, count], other[_Y, count], other[_Z, count] = order[0, i], order[1, i], order[2, i]
                    other[_INVERSE, count], other[_RELIEF, count] = inverse, relief_m
                    other[_FRESH, count], other[_KEPT, count] = fresh, kept
                    other[_A, count], other[_B, count] = a, b
                    other[_HEIGHT_A, count], other[_HEIGHT_B, count] = height_a, height_b
                    if rank == 0:
                        total_a, total_b = height_a, height_b
                    else:
                        total_a = total_a * (1.0 - cover_a) + height_a
                        total_b = total_b * (1.0 - cover_b) + height_b
                    rank += 1
                    count += 1
            sums_a[s] += total_a
            sums_b[s] += total_b
    return _ended(whole, other, count)


@_library.kernel
def _halves(shape: Any, whole: Any, other: Any, middle: Any, length_m: Any, sums: Any) -> Any:
    """The craters of both halves of each stretch, and what they add at the middle (S,)."""
    new_whole, new_other = np.empty((3, 2 * whole.shape[1]), np.int64), np.empty((COLUMNS, 2 * whole.shape[1]))
    away, height = np.empty(whole.shape[1]), np.empty(whole.shape[1])
    sums[:] = 0.0
    count = i = 0
    while i < whole.shape[1]:
        s, start = whole[0, i], i
        added = total = 0.0
        octave = whole[1, i]
        rank = 0
        while i < whole.shape[1] and whole[0, i] == s:
            k = whole[1, i]
            if k != octave:
                added += total
                octave, rank = k, 0
            distance = _distance(middle[0, s], middle[1, s], middle[2, s], other, i)
            away[i] = distance * other[_INVERSE, i]
            height[i], cover = _height(shape, k, away[i], other[_KEPT, i], other[_FRESH, i], other[_RELIEF, i])
            total = height[i] if rank == 0 else total * (1.0 - cover) + height[i]
            rank += 1
            i += 1
        sums[s] = added + total
        for side in range(2):
            for j in range(start, i):
                a, b = (away[j], other[_B, j]) if side else (other[_A, j], away[j])
                if 0.5 * (a + b - length_m[s] * other[_INVERSE, j]) < REACH:
                    new_whole[0, count], new_whole[1, count] = 2 * s + side, whole[1, j]
                    new_whole[2, count] = whole[2, j]
                    for column in range(COLUMNS):
                        new_other[column, count] = other[column, j]
                    if side:
                        new_other[_A, count], new_other[_HEIGHT_A, count] = away[j], height[j]
                    else:
                        new_other[_B, count], new_other[_HEIGHT_B, count] = away[j], height[j]
                    count += 1
    return _ended(new_whole, new_other, count)


@inlined
def _alone(shape: Any, whole: Any, other: Any, length_m: float, i: int) -> Any:
    """How far ground may rise by crater i, and low, high (squares of radii) and the steepest slope about it."""
    wall, _, rim, peak = _form(shape, whole[1, i])
    a, b, relief_m = other[_A, i], other[_B, i], other[_RELIEF, i]
    d = length_m * other[_INVERSE, i]
    low, high = max(0.5 * (a + b - d), 0.0), 0.5 * (a + b + d)
    low *= low
    high *= high
    width = rim * (2.2 - 1.6 * other[_FRESH, i])
    around = width / wall
    crest = low < 1.0 + around and high > 1.0 - around
    ejecta = (4.0 - max(low, 1.0 - around)) * (1.0 / 3.0)
    ejecta = max(ejecta, 0.0) if high > 1.0 - around else 0.0
    falls = rim * ejecta * ejecta
    inner = low < 1.0 / 12.0
    bend = 2.0 * falls + (48.0 * peak if inner else 0.0)
    slopes = wall + rim * 1.3
    sharpest = slopes * slopes / (2.0 * width)
    bend += 4.0 * min(high, 1.0 + around) * sharpest if crest else 0.0
    rise = bend * d * d * 0.125
    steep = sqrt(min(high, 1.0 + around)) * 2.0 * (wall + falls)
    steep += 24.0 * peak if inner else 0.0
    if crest or inner:
        rise = min(rise, 0.25 * steep * d)
    rise *= relief_m
    height_a, height_b = other[_HEIGHT_A, i], other[_HEIGHT_B, i]
    if not inner:
        top = rim if high > 1.0 - around else rim + wall * (high - 1.0)
        highest = max(top * relief_m, height_a, height_b)
        rise = min(rise, highest - min(height_a, height_b))
    size = max(abs(height_a), abs(height_b)) + 0.5 * steep * d * relief_m
    return rise, low, high, min(size, (wall + rim) * relief_m)


@_library.kernel
def _rise(shape: Any, whole: Any, other: Any, length_m: Any, total: Any) -> None:
    total[:] = 0.0
    i, count = 0, whole.shape[1]
    while i < count:
        s, k, end = whole[0, i], whole[1, i], i
        sizes = 0.0
        while end < count and whole[0, end] == s and whole[1, end] == k:
            end += 1
        if end > i + 1:
            for j in range(i, end):
                sizes += _alone(shape, whole, other, length_m[s], j)[3]
        for j in range(i, end):
            rise, low, high, size = _alone(shape, whole, other, length_m[s], j)
            if j > i:
                changes = min(1.5 * (min(high, 1.5) - max(low, 0.5)), 1.0)
                rise += max(changes, 0.0) * other[_KEPT, j] * (sizes - size)
            total[s] += rise
        i = end


@_library.kernel
def _joined(whole: Any, other: Any, whole_2: Any, other_2: Any) -> Any:
    """Both, by stretch, octave and age."""
    first, second = whole.shape[1], whole_2.shape[1]
    new_whole, new_other = np.empty((3, first + second), np.int64), np.empty((COLUMNS, first + second))
    i = j = 0
    for n in range(first + second):
        one = j == second
        if i < first and j < second:
            key = (whole[0, i] * 32 + whole[1, i]) * 8 + whole[2, i]
            one = key <= (whole_2[0, j] * 32 + whole_2[1, j]) * 8 + whole_2[2, j]
        if one:
            for row in range(3):
                new_whole[row, n] = whole[row, i]
            for row in range(COLUMNS):
                new_other[row, n] = other[row, i]
            i += 1
        else:
            for row in range(3):
                new_whole[row, n] = whole_2[row, j]
            for row in range(COLUMNS):
                new_other[row, n] = other_2[row, j]
            j += 1
    return new_whole, new_other


@_library.kernel
def _kept(whole: Any, other: Any, number: Any) -> Any:
    """The craters of stretches whose new number (S,) is not negative."""
    new_whole, new_other = np.empty(whole.shape, np.int64), np.empty(other.shape)
    count = 0
    for i in range(whole.shape[1]):
        stretch = number[whole[0, i]]
        if stretch >= 0:
            new_whole[0, count], new_whole[1, count], new_whole[2, count] = stretch, whole[1, i], whole[2, i]
            for row in range(COLUMNS):
                new_other[row, count] = other[row, i]
            count += 1
    return _ended(new_whole, new_other, count)


def found(
    craters: Craters, first: int, last: int, ends: tuple[Floats, Floats], length_m: Floats
) -> tuple[Lists, Floats, Floats]:
    """Craters of octaves from `first` to before `last`, as `found_along` finds them, and what they add at both ends."""
    sums_a, sums_b = np.empty(len(length_m)), np.empty(len(length_m))
    a, b = (np.ascontiguousarray(end) for end in ends)
    lists = _found(
        craters.radius_m, craters.frequency, craters.offset, craters.shape, craters.accept, first, last, a, b,
        np.ascontiguousarray(length_m), sums_a, sums_b,
    )  # fmt: skip
    return lists, sums_a, sums_b


def halves(craters: Craters, lists: Lists, middle: Floats, length_m: Floats) -> tuple[Lists, Floats]:
    """`CraterPaths.halves`."""
    sums = np.empty(len(length_m))
    return _halves(craters.shape, *lists, np.ascontiguousarray(middle), np.ascontiguousarray(length_m), sums), sums


def rise(craters: Craters, lists: Lists, length_m: Floats) -> Floats:
    """`CraterPaths.rise`."""
    total = np.empty(len(length_m))
    _rise(craters.shape, *lists, np.ascontiguousarray(length_m), total)
    return total


def joined(lists: Lists, others: Lists) -> Lists:
    """`CraterPaths.joined`."""
    return _joined(*lists, *others)


def kept(lists: Lists, number: Ints) -> Lists:
    """`CraterPaths.kept`."""
    return _kept(*lists, number)
