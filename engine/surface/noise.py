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
    """Gradient noise at lattice coordinates `points` (N, 3) -> (N,). Plain and slow: what tests hold the rest against."""
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
    temporaries stay in the cache (4.7 times slower in one go for 16 x 1000).
    """

    frequency: Floats
    offset: Floats

    @staticmethod
    def of(wavelengths_m: Floats, offsets: Floats) -> Lattice:
        """Octaves with `wavelengths_m` (K,) and lattice `offsets` (K, 3)."""
        return Lattice(1.0 / np.asarray(wavelengths_m, dtype=np.float64), np.asarray(offsets, dtype=np.float64))

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

    `fraction` (3, K, N); `gradients` (3, 2, 2, 2, K, N) in units of `GRADIENT_SCALE`, corner indices in x, y, z order.
    """

    __slots__ = ("fraction", "gradients")

    def __init__(self, fraction: Floats, gradients: Floats) -> None:
        self.fraction = fraction
        self.gradients = gradients

    def part(self, octaves: slice) -> Corners:
        """The corners of some of the octaves (views)."""
        return Corners(self.fraction[:, octaves], self.gradients[..., octaves, :])

    def _weights(self) -> Floats:
        f = self.fraction
        w = np.empty((3, 2, *f.shape[1:]))
        u = w[:, 1]
        np.multiply(f, 6.0, out=u)
        u -= 15.0
        u *= f
        u += 10.0
        u *= f
        u *= f
        u *= f
        np.subtract(1.0, u, out=w[:, 0])
        return w

    def noise(self) -> Floats:
        """Gradient noise (K, N)."""
        g = self.gradients
        d = np.empty((3, 2, *self.fraction.shape[1:]))
        d[:, 0] = self.fraction
        np.subtract(self.fraction, 1.0, out=d[:, 1])
        w = self._weights()
        dot = g[0] * d[0][:, None, None]
        dot += g[1] * d[1][None, :, None]
        dot += g[2] * d[2][None, None, :]
        dot *= w[0][:, None, None]
        plane = dot[0]
        plane += dot[1]
        plane *= w[1][:, None]
        line = plane[0]
        line += plane[1]
        line *= w[2]
        out = line[0]
        out += line[1]
        out *= GRADIENT_SCALE
        return out

    def noise_derivative(self) -> tuple[Floats, Floats]:
        """Gradient noise (K, N) and its derivative by the lattice coordinate (3, K, N)."""
        f, g = self.fraction, self.gradients
        d = np.stack([f, f - 1.0], axis=1)
        w = self._weights()
        du = f * (f - 2.0)
        du += 1.0
        du *= f
        du *= f
        du *= 30.0 * GRADIENT_SCALE
        wx, wy, wz = w[0][:, None, None], w[1][None, :, None], w[2][None, None, :]
        dot = g[0] * d[0][:, None, None]
        dot += g[1] * d[1][None, :, None]
        dot += g[2] * d[2][None, None, :]
        wyz, wxz, wxy = wy * wz, wx * wz, wx * wy
        value = np.einsum("abckn,abckn->kn", dot * wx, np.broadcast_to(wyz, dot.shape)) * GRADIENT_SCALE
        slope = np.einsum("iabckn,abckn->ikn", g, wx * wyz) * GRADIENT_SCALE
        slope[0] += ((dot[1] - dot[0]) * wyz[0]).sum(axis=(0, 1)) * du[0]
        slope[1] += ((dot[:, 1] - dot[:, 0]) * wxz[:, 0]).sum(axis=(0, 1)) * du[1]
        slope[2] += ((dot[:, :, 1] - dot[:, :, 0]) * wxy[:, :, 0]).sum(axis=(0, 1)) * du[2]
        return value, slope

    def vector(self) -> Floats:
        """Vector value noise (3, K, N), each component in (-1, 1): the hash itself, interpolated. For warps."""
        w = self._weights()
        v = self.gradients * w[0][:, None, None]
        v = v[:, 0] + v[:, 1]
        v *= w[1][:, None]
        v = v[:, 0] + v[:, 1]
        v *= w[2]
        out = v[:, 0] + v[:, 1]
        out *= GRADIENT_SCALE
        return out

    def vector_derivative(self) -> tuple[Floats, Floats]:
        """Vector value noise (3, K, N) and its Jacobian [component, axis] (3, 3, K, N) by the lattice coordinate."""
        f, g = self.fraction, self.gradients
        w = self._weights()
        du = 30.0 * GRADIENT_SCALE * f * f * (f * (f - 2.0) + 1.0)
        wx, wy, wz = w[0][:, None, None], w[1][None, :, None], w[2][None, None, :]
        wyz, wxz, wxy = wy * wz, wx * wz, wx * wy
        value = np.einsum("iabckn,abckn->ikn", g, wx * wyz) * GRADIENT_SCALE
        jacobian = np.empty((3, *f.shape))
        jacobian = np.stack(
            [
                ((g[:, 1] - g[:, 0]) * wyz[0]).sum(axis=(1, 2)) * du[0],
                ((g[:, :, 1] - g[:, :, 0]) * wxz[:, 0]).sum(axis=(1, 2)) * du[1],
                ((g[:, :, :, 1] - g[:, :, :, 0]) * wxy[:, :, 0]).sum(axis=(1, 2)) * du[2],
            ],
            axis=1,
        )
        return value, jacobian


def _hash_corners(base: Floats) -> Floats:
    """PCG3D of the eight corners of cells `base` (3, K, N) -> gradient components (3, 2, 2, 2, K, N) as f64 integers.

    The first round's multiply-add is done once per axis and side instead of once per corner.
    """
    _, octaves, points = base.shape
    first = np.empty((3, 2, octaves, points), dtype=np.uint32)
    first[:, 0] = base.astype(np.int32).view(np.uint32)
    first[:, 0] *= _MUL
    first[:, 0] += _ADD
    np.add(first[:, 0], _MUL, out=first[:, 1])
    ax, ay, az = first[0][:, None, None], first[1][None, :, None], first[2][None, None, :]
    h = np.empty((3, 2, 2, 2, octaves, points), dtype=np.uint32)
    x, y, z = h[0], h[1], h[2]
    t = np.empty((2, 2, 2, octaves, points), dtype=np.uint32)
    np.add(ax, ay * az, out=x)
    np.multiply(az, x, out=y)
    y += ay
    np.multiply(x, y, out=z)
    z += az
    for word in (x, y, z):
        np.right_shift(word, _SIXTEEN, out=t)
        word ^= t
    np.multiply(y, z, out=t)
    x += t
    np.multiply(z, x, out=t)
    y += t
    np.multiply(x, y, out=t)
    z += t
    signed = h.view(np.int32)
    signed >>= _EIGHT
    return signed.astype(np.float64)
