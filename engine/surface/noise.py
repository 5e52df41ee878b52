"""Gradient noise on an integer lattice: the float64 twins of `assets/shaders/common/noise.glsl`.

One octave is 3D gradient noise (Perlin 2002: quintic weights) whose gradients come from the PCG3D integer hash
(Jarzynski and Olano 2020), so that CPU and GPU agree on every bit of the lattice. Coordinates are in cells: a point
`p` lies in cell `floor(p)` at the fraction `p - floor(p)`. The gradient of a corner has its three components in
[-1, 1), with 24 bits each: exact in float32 as well.

`Lattice` evaluates many octaves at once. An octave is (wavelength, offset): lattice coordinate = P / wavelength +
offset. Offsets are what makes octaves of one family differ; wavelengths are powers of two in metres so that
the products are exact in float32 on the GPU.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Words = NDArray[np.uint32]

GRADIENT_SCALE = 2.0**-23
"""A hash word, shifted right (signed) by 8 bits, times this is a gradient component in [-1, 1)."""

NOISE_BOUND = 1.5
"""|gradient noise| is below this: at a cell's centre each corner gives at most 3 * 0.5."""

_MUL = np.uint32(1664525)
_ADD = np.uint32(1013904223)
_SIXTEEN = np.uint32(16)
_EIGHT = np.int32(8)


def pcg3d(x: Words, y: Words, z: Words) -> tuple[Words, Words, Words]:
    """Hash three words into three words (Jarzynski and Olano 2020, "Hash Functions for GPU Rendering")."""
    x = x * _MUL + _ADD
    y = y * _MUL + _ADD
    z = z * _MUL + _ADD
    x = x + y * z
    y = y + z * x
    z = z + x * y
    x = x ^ (x >> _SIXTEEN)
    y = y ^ (y >> _SIXTEEN)
    z = z ^ (z >> _SIXTEEN)
    x = x + y * z
    y = y + z * x
    z = z + x * y
    return x, y, z


def splitmix64(state: int) -> int:
    """One step of SplitMix64 (Steele et al. 2014): a well mixed 64-bit number for each integer `state`."""
    state = (state + 0x9E3779B97F4A7C15) & 0xFFFFFFFFFFFFFFFF
    state = ((state ^ (state >> 30)) * 0xBF58476D1CE4E5B9) & 0xFFFFFFFFFFFFFFFF
    state = ((state ^ (state >> 27)) * 0x94D049BB133111EB) & 0xFFFFFFFFFFFFFFFF
    return state ^ (state >> 31)


def octave_offset(seed: int, octave: int) -> Floats:
    """Pseudo-random lattice offset (3,) of one octave: 12 integer bits and 24 fraction bits, exact in float64.

    The same seed and octave always give the same offset, on every machine.
    """
    words = [splitmix64(((seed & 0xFFFFFFFF) << 20) ^ (octave << 2) ^ axis) >> 28 for axis in range(3)]
    return np.array(words, dtype=np.float64) * 2.0**-24


def gradient_noise(points: Floats) -> Floats:
    """Gradient noise at lattice coordinates `points` (N, 3) -> (N,), plain and slow: what tests hold the rest against."""
    return gradient_noise_derivative(points)[0]


def gradient_noise_derivative(points: Floats) -> tuple[Floats, Floats]:
    """Gradient noise (N,) and its derivative (N, 3) by the lattice coordinate, at `points` (N, 3)."""
    cell = np.floor(points)
    f = points - cell
    words = cell.astype(np.int64).astype(np.uint32)
    u = f * f * f * (f * (f * 6.0 - 15.0) + 10.0)
    du = 30.0 * f * f * (f * (f - 2.0) + 1.0)
    value = np.zeros(len(points))
    slope = np.zeros((len(points), 3))
    for corner in np.ndindex(2, 2, 2):
        step = np.array(corner, dtype=np.uint32)
        h = pcg3d(*(words + step).T)
        g = np.stack([(w.view(np.int32) >> _EIGHT) * GRADIENT_SCALE for w in h], axis=1)
        side = np.array(corner) == 1
        w = np.where(side, u, 1.0 - u)
        dw = np.where(side, du, -du)
        dot = (g * (f - step)).sum(axis=1)
        value += w.prod(axis=1) * dot
        slope += w.prod(axis=1)[:, None] * g
        slope[:, 0] += dw[:, 0] * w[:, 1] * w[:, 2] * dot
        slope[:, 1] += w[:, 0] * dw[:, 1] * w[:, 2] * dot
        slope[:, 2] += w[:, 0] * w[:, 1] * dw[:, 2] * dot
    return value, slope


@dataclass(frozen=True, slots=True)
class Lattice:
    """Octaves evaluated together: `frequency` (K,) in cells per metre, `offset` (K, 3) in cells.

    The evaluation is vectorised over octaves and points at once; callers keep K x N at a few thousand, so that the
    temporaries stay in the cache.
    """

    frequency: Floats
    offset: Floats

    @staticmethod
    def of(wavelengths_m: Floats | list[float], offsets: Floats) -> Lattice:
        """Octaves with `wavelengths_m` (K,) and lattice `offsets` (K, 3)."""
        return Lattice(1.0 / np.asarray(wavelengths_m, dtype=np.float64), np.asarray(offsets, dtype=np.float64))

    def __len__(self) -> int:
        return len(self.frequency)

    def cells(self, points: Floats) -> Corners:
        """Hash the corners around `points`: (3, N), or (3, K, N) where each octave has its own points."""
        p = points if points.ndim == 3 else points[:, None, :]
        x = p * self.frequency[:, None]
        x += self.offset.T[:, :, None]
        base = np.floor(x)
        x -= base
        return Corners(x, _hash_corners(base))


class Corners:
    """The eight hashed corners of K x N lattice cells: a step shared by gradient and vector noise.

    `fraction` (3, K, N); `gradients` (3, 8, K, N) in units of `GRADIENT_SCALE`; corner c is at x = c & 1,
    y = c >> 1 & 1, z = c >> 2.
    """

    __slots__ = ("fraction", "gradients")

    def __init__(self, fraction: Floats, gradients: Floats) -> None:
        self.fraction = fraction
        self.gradients = gradients

    def part(self, octaves: slice) -> Corners:
        """The corners of some of the octaves (views)."""
        return Corners(self.fraction[:, octaves], self.gradients[:, :, octaves])

    def noise(self) -> Floats:
        """Gradient noise (K, N)."""
        f, g = self.fraction, self.gradients
        if f.shape[1] * f.shape[2] <= _FEW:
            d = f[:, None] - _SIDES
            d *= g
            dot = d[0]
            dot += d[1]
            dot += d[2]
            dot *= _corner_weights(f)
            return np.add.reduce(dot) * GRADIENT_SCALE
        e = f - 1.0
        dot = np.empty(g.shape[1:])
        y = np.empty((2, *f.shape[1:]))
        for half, dz in ((slice(0, 4), f[2]), (slice(4, 8), e[2])):
            part = dot[half]
            np.multiply(g[2, half], dz, out=part)
            np.multiply(g[1, half.start : half.start + 2], f[1], out=y)
            part[:2] += y
            np.multiply(g[1, half.start + 2 : half.stop], e[1], out=y)
            part[2:] += y
        t = g[0, 0::2] * f[0]
        dot[0::2] += t
        np.multiply(g[0, 1::2], e[0], out=t)
        dot[1::2] += t
        return _interpolate(dot, _quintic(f)) * GRADIENT_SCALE

    def vector(self) -> Floats:
        """Vector value noise (3, K, N), each component in (-1, 1): the hash itself, interpolated. For warps."""
        f = self.fraction
        if f.shape[1] * f.shape[2] <= _FEW:
            return np.add.reduce(self.gradients * _corner_weights(f), axis=1) * GRADIENT_SCALE
        u = _quintic(f)
        return np.stack([_interpolate(g, u) for g in self.gradients]) * GRADIENT_SCALE

    def noise_derivative(self) -> tuple[Floats, Floats]:
        """Gradient noise (K, N) and its derivative by the lattice coordinate (3, K, N)."""
        f, g = self.fraction, self.gradients
        u, du = _quintic(f), _quintic_slope(f)
        d = np.stack([f, f - 1.0])
        dot = np.empty(g.shape[1:])
        for c in range(8):
            dot[c] = g[0, c] * d[c & 1, 0] + g[1, c] * d[c >> 1 & 1, 1] + g[2, c] * d[c >> 2, 2]
        value, slope = _interpolate_slopes(dot, u, du)
        for axis in range(3):
            slope[axis] += _interpolate(g[axis], u)
        return value * GRADIENT_SCALE, slope * GRADIENT_SCALE

    def vector_derivative(self) -> tuple[Floats, Floats]:
        """Vector value noise (3, K, N) and its Jacobian [component, axis] (3, 3, K, N) by the lattice coordinate."""
        u, du = _quintic(self.fraction), _quintic_slope(self.fraction)
        parts = [_interpolate_slopes(g, u, du) for g in self.gradients]
        return np.stack([p[0] for p in parts]) * GRADIENT_SCALE, np.stack([p[1] for p in parts]) * GRADIENT_SCALE


_FEW = 64
"""Below this many octaves x points the count of numpy calls decides, not the work: eight plain corner weights."""

_SIDES = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)], dtype=np.float64).T.reshape(3, 8, 1, 1)
_FAR_SIDES = 1.0 - _SIDES


def _corner_weights(f: Floats) -> Floats:
    w = _FAR_SIDES - _quintic(f)[:, None]
    np.abs(w, out=w)
    product = w[0]
    product *= w[1]
    product *= w[2]
    return product


def _quintic(f: Floats) -> Floats:
    u = f * 6.0
    u -= 15.0
    u *= f
    u += 10.0
    cube = f * f
    cube *= f
    u *= cube
    return u


def _quintic_slope(f: Floats) -> Floats:
    return 30.0 * f * f * (f * (f - 2.0) + 1.0)


def _interpolate(corners: Floats, u: Floats) -> Floats:
    """Trilinear interpolation of `corners` (8, K, N) by weights `u` (3, K, N)."""
    x = corners[1::2] - corners[0::2]
    x *= u[0]
    x += corners[0::2]
    y = x[1::2] - x[0::2]
    y *= u[1]
    y += x[0::2]
    z = y[1] - y[0]
    z *= u[2]
    z += y[0]
    return z


def _interpolate_slopes(corners: Floats, u: Floats, du: Floats) -> tuple[Floats, Floats]:
    """`_interpolate`, and its derivative (3, K, N) through the weights alone."""
    dx = corners[1::2] - corners[0::2]
    x = corners[0::2] + u[0] * dx
    dy = x[1::2] - x[0::2]
    y = x[0::2] + u[1] * dy
    dz = y[1] - y[0]
    sx = dx[0::2] + u[1] * (dx[1::2] - dx[0::2])
    slope = np.stack([sx[0] + u[2] * (sx[1] - sx[0]), dy[0] + u[2] * (dy[1] - dy[0]), dz])
    slope *= du
    return y[0] + u[2] * dz, slope


def _hash_corners(base: Floats) -> Floats:
    """PCG3D of the eight corners of cells `base` (3, K, N) -> gradient components (3, 8, K, N) as f64 integers.

    The first round's multiply-add is done once per axis and side instead of once per corner.
    """
    _, octaves, points = base.shape
    first = np.empty((2, 3, octaves, points), dtype=np.uint32)
    low, high = first
    np.multiply(base.astype(np.int32).view(np.uint32), _MUL, out=low)
    low += _ADD
    np.add(low, _MUL, out=high)
    h = np.empty((3, 2, 2, 2, octaves, points), dtype=np.uint32)
    x, y, z = h
    # axes of h[i]: z side, y side, x side: corner index = x + 2 y + 4 z
    ax, ay, az = first[:, 0], first[:, 1, None], first[:, 2, None, None]
    np.add(az * ay, ax, out=x)
    np.multiply(x, az, out=y)
    y += ay
    np.multiply(x, y, out=z)
    z += az
    t = h >> _SIXTEEN
    h ^= t
    t = t[0]
    np.multiply(y, z, out=t)
    x += t
    np.multiply(z, x, out=t)
    y += t
    np.multiply(x, y, out=t)
    z += t
    signed = h.view(np.int32)
    signed >>= _EIGHT
    return signed.reshape(3, 8, octaves, points).astype(np.float64)
