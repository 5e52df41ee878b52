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

import math
import threading
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Words = NDArray[np.uint32]

GRADIENT_SCALE = 2.0**-23
"""A hash word, shifted right (signed) by 8 bits, times this is a gradient component in [-1, 1)."""

NOISE_BOUND = 1.5
"""|gradient noise| is below this: at a cell's centre each corner gives at most 3 * 0.5."""

# Arrays without axes: numpy converts a Python or numpy scalar anew at each call, which costs a third of a small one.
_MUL = np.array(1664525, dtype=np.uint32)
_ADD = np.array(1013904223, dtype=np.uint32)
_SIXTEEN = np.array(16, dtype=np.uint32)
_EIGHT = np.array(8, dtype=np.int32)
_SCALE = np.array(GRADIENT_SCALE)
_HALF, _ONE, _MIDDLE_SLOPE, _FIVE, _SIX = (np.array(v) for v in (0.5, 1.0, 1.875, 5.0, 6.0))


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
    """Gradient noise at lattice coordinates `points` (N, 3) -> (N,): plain, slow, what tests hold the rest against."""
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


class Scratch(threading.local):
    """Memory for temporaries, kept between calls, one set a thread.

    Fresh temporaries of a few hundred kB are given back to the system and faulted in again at each call, which made
    batches of 500 points three times slower. An array from a slot is valid until the slot is asked for again.
    """

    def __init__(self) -> None:
        self._slots: dict[str, NDArray[np.uint8]] = {}

    def array(self, slot: str, shape: tuple[int, ...], dtype: type = np.float64) -> NDArray:
        """An uninitialised array in the slot's memory."""
        size = math.prod(shape) * (4 if dtype is np.uint32 else 8)
        memory = self._slots.get(slot)
        if memory is None or memory.nbytes < size:
            memory = self._slots[slot] = np.empty(size, dtype=np.uint8)
        return np.ndarray(shape, dtype, memory)

    def clear(self) -> None:
        """Give this thread's memory back; no array from it may be in use."""
        self._slots.clear()


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

    def cells(self, points: Floats, scratch: Scratch | None = None) -> Corners:
        """Hash the corners around `points`: (3, N), or (3, K, N) where each octave has its own points.

        With `scratch`, everything lives in its slots until the next `cells` with it.
        """
        p = points if points.ndim == 3 else points[:, None, :]
        shape = (3, len(self.frequency), p.shape[2])
        if scratch is None or shape[1] * shape[2] <= _FEW:
            scratch, x, base = None, np.empty(shape), np.empty(shape)
        else:
            x, base = scratch.array("fraction", shape), scratch.array("spare", shape)
        np.multiply(p, self.frequency[:, None], out=x)
        x += self.offset.T[:, :, None]
        np.floor(x, out=base)
        x -= base
        return Corners(x, _hash_corners(base, scratch), scratch=scratch)


class Corners:
    """The eight hashed corners of K x N lattice cells: a step shared by gradient and vector noise.

    `fraction` (3, K, N); `gradients` (3, 8, K, N) in units of `GRADIENT_SCALE`; corner c is at x = c & 1,
    y = c >> 1 & 1, z = c >> 2.
    """

    __slots__ = ("_scratch", "_weights", "fraction", "gradients")

    def __init__(
        self, fraction: Floats, gradients: Floats, weights: Floats | None = None, scratch: Scratch | None = None
    ) -> None:
        self.fraction = fraction
        self.gradients = gradients
        self._weights = weights
        self._scratch = scratch

    def part(self, octaves: slice) -> Corners:
        """The corners of some of the octaves (views)."""
        weights = None
        if self.fraction.shape[1] * self.fraction.shape[2] <= _FEW:
            weights = self._few_weights()[:, octaves]
        return Corners(self.fraction[:, octaves], self.gradients[:, :, octaves], weights, self._scratch)

    def at(self, points: NDArray[np.int64]) -> Corners:
        """The corners of some of the points (copies)."""
        return Corners(self.fraction.take(points, axis=-1), self.gradients.take(points, axis=-1))

    def _few_weights(self) -> Floats:
        """The weight of each corner (8, K, N), for small batches."""
        if self._weights is None:
            w = np.subtract(_FAR_SIDES, quintic(self.fraction)[:, None], out=np.empty(self.gradients.shape))
            np.abs(w, out=w)
            product = w[0]
            product *= w[1]
            product *= w[2]
            self._weights = product
        return self._weights

    def noise(self) -> Floats:
        """Gradient noise (K, N)."""
        f, g = self.fraction, self.gradients
        if f.shape[1] * f.shape[2] <= _FEW:
            d = np.subtract(f[:, None], _SIDES, out=np.empty(g.shape))  # a fresh result would be strided like f
            d *= g
            dot = d[0]
            dot += d[1]
            dot += d[2]
            dot *= self._few_weights()
            out = np.add.reduce(dot)
            out *= _SCALE
            return out
        scratch = self._scratch or Scratch()
        out = _interpolate(self._dots(scratch), quintic(f, scratch), scratch)
        out *= _SCALE
        return out

    def _dots(self, scratch: Scratch) -> Floats:
        """Gradients times the way from their corners (8, K, N), in the scratch's memory."""
        f, g = self.fraction, self.gradients
        e = np.subtract(f, _ONE, out=scratch.array("e", f.shape))
        dot = scratch.array("dot", g.shape[1:])
        t = scratch.array("t", (4, *f.shape[1:]))
        for half, dz in ((slice(0, 4), f[2]), (slice(4, 8), e[2])):
            part = dot[half]
            np.multiply(g[2, half], dz, out=part)
            np.multiply(g[1, half.start : half.start + 2], f[1], out=t[:2])
            np.multiply(g[1, half.start + 2 : half.stop], e[1], out=t[2:])
            part += t
        for side, dx in ((0, f[0]), (1, e[0])):
            np.multiply(g[0, side::2], dx, out=t)
            dot[side::2] += t
        return dot

    def vector(self) -> Floats:
        """Vector value noise (3, K, N), each component in (-1, 1): the hash itself, interpolated. For warps."""
        f = self.fraction
        if f.shape[1] * f.shape[2] <= _FEW:
            out = np.add.reduce(self.gradients * self._few_weights(), axis=1)
            out *= _SCALE
            return out
        scratch = self._scratch or Scratch()
        u = quintic(f, scratch)
        return _interpolate(self.gradients.swapaxes(0, 1), u, scratch) * GRADIENT_SCALE

    def noise_derivative(self) -> tuple[Floats, Floats]:
        """Gradient noise (K, N) and its derivative by the lattice coordinate (3, K, N)."""
        f, g = self.fraction, self.gradients
        scratch = self._scratch or Scratch()
        u = quintic(f)
        value, slope = _interpolate_slopes(self._dots(scratch), u, quintic_slope(f), scratch)
        for axis in range(3):
            slope[axis] += _interpolate(g[axis], u, scratch)
        value *= _SCALE
        slope *= _SCALE
        return value, slope

    def noise_hessian(self) -> Floats:
        """Second derivatives (3, 3, K, N) of gradient noise by the lattice coordinate."""
        f = self.fraction
        u, du = quintic(f), quintic_slope(f)
        ddu = 60.0 * f * (f * (2.0 * f - 3.0) + 1.0)
        total = np.zeros((3, 3, *f.shape[1:]))
        for corner in range(8):
            side = np.array([corner & 1, corner >> 1 & 1, corner >> 2], dtype=np.float64).reshape(3, 1, 1)
            sign = 2.0 * side - 1.0
            w, dw, ddw = 1.0 - side + sign * u, sign * du, sign * ddu
            g = self.gradients[:, corner] * GRADIENT_SCALE
            value = (g * (f - side)).sum(axis=0)
            by = np.stack([dw[0] * w[1] * w[2], w[0] * dw[1] * w[2], w[0] * w[1] * dw[2]])
            for a in range(3):
                for b in range(a, 3):
                    second = ddw[a] * w[(a + 1) % 3] * w[(a + 2) % 3] if a == b else dw[a] * dw[b] * w[3 - a - b]
                    total[a, b] += by[a] * g[b] + g[a] * by[b] + second * value
        for a, b in ((0, 1), (0, 2), (1, 2)):
            total[b, a] = total[a, b]
        return total

    def vector_derivative(self) -> tuple[Floats, Floats]:
        """Vector value noise (3, K, N) and its Jacobian [component, axis] (3, 3, K, N) by the lattice coordinate."""
        u, du = quintic(self.fraction), quintic_slope(self.fraction)
        value, slope = _interpolate_slopes(self.gradients.swapaxes(0, 1), u, du[:, None], self._scratch)
        return value * GRADIENT_SCALE, slope.swapaxes(0, 1) * GRADIENT_SCALE


_FEW = 64
"""Below this many octaves x points the count of numpy calls decides, not the work: eight plain corner weights."""

_SIDES = np.array([[c & 1, c >> 1 & 1, c >> 2] for c in range(8)], dtype=np.float64).T.reshape(3, 8, 1, 1)
_FAR_SIDES = 1.0 - _SIDES
_SIDE_STEPS = _SIDES.reshape(3, 8, 1).astype(np.uint32) * _MUL


def quintic(f: Floats, scratch: Scratch | None = None) -> Floats:
    """6 f^5 - 15 f^4 + 10 f^3, as the odd polynomial that it is around 1/2."""
    t = f - _HALF
    square = t * t if scratch is None else np.multiply(t, t, out=scratch.array("t", f.shape))
    u = square * _SIX if scratch is None else np.multiply(square, _SIX, out=scratch.array("u", f.shape))
    u -= _FIVE
    u *= square
    u += _MIDDLE_SLOPE
    u *= t
    u += _HALF
    return u


def quintic_slope(f: Floats) -> Floats:
    return 30.0 * f * f * (f * (f - 2.0) + 1.0)


def _interpolate(corners: Floats, u: Floats, scratch: Scratch | None = None) -> Floats:
    """Trilinear interpolation of `corners` (8, ..., K, N) by weights `u` (3, K, N); the result is a fresh array."""
    shape = corners.shape[1:]
    scratch = scratch or Scratch()
    x = np.subtract(corners[1::2], corners[0::2], out=scratch.array("t", (4, *shape)))
    x *= u[0]
    x += corners[0::2]
    y = np.subtract(x[1::2], x[0::2], out=scratch.array("y", (2, *shape)))
    y *= u[1]
    y += x[0::2]
    z = y[1] - y[0]
    z *= u[2]
    z += y[0]
    return z


def _interpolate_slopes(
    corners: Floats, u: Floats, du: Floats, scratch: Scratch | None = None
) -> tuple[Floats, Floats]:
    """`_interpolate`, and its derivative (3, ..., K, N) through the weights alone: fresh arrays. du: as `u`, to be
    multiplied with that."""
    shape = corners.shape[1:]
    scratch = scratch or Scratch()
    dx = np.subtract(corners[1::2], corners[0::2], out=scratch.array("dx", (4, *shape)))
    x = np.multiply(dx, u[0], out=scratch.array("t", (4, *shape)))
    x += corners[0::2]
    dy = np.subtract(x[1::2], x[0::2], out=scratch.array("y", (2, *shape)))
    slope = np.empty((3, *shape))
    sx = np.subtract(dx[1::2], dx[0::2], out=scratch.array("sx", (2, *shape)))
    sx *= u[1]
    sx += dx[0::2]
    _between(sx[0], sx[1], u[2], slope[0])
    _between(dy[0], dy[1], u[2], slope[1])
    y = np.multiply(dy, u[1], out=dy)
    y += x[0::2]
    np.subtract(y[1], y[0], out=slope[2])
    value = slope[2] * u[2]
    value += y[0]
    slope *= du
    return value, slope


def _between(a: Floats, b: Floats, share: Floats, out: Floats) -> None:
    np.subtract(b, a, out=out)
    out *= share
    out += a


def _hash_corners(base: Floats, scratch: Scratch | None) -> Floats:
    """PCG3D of the eight corners of cells `base` (3, K, N) -> gradient components (3, 8, K, N) as f64 integers.

    The first round's multiply-add is done once per axis and side instead of once per corner.
    """
    _, octaves, points = base.shape
    if scratch is None and octaves * points <= _FEW:
        words = base.astype(np.int32).view(np.uint32).reshape(3, 1, octaves * points)
        words *= _MUL
        words += _ADD
        h = np.empty((3, 8, octaves * points), dtype=np.uint32)
        return _mix(np.add(words, _SIDE_STEPS, out=h)).reshape(3, 8, octaves, points)
    first = np.empty((2, 3, octaves, points), dtype=np.uint32)
    low, high = first
    np.multiply(base.astype(np.int32).view(np.uint32), _MUL, out=low)
    low += _ADD
    np.add(low, _MUL, out=high)
    corners, flat = (3, 2, 2, 2, octaves, points), (3, 8, octaves, points)
    if scratch is None:
        h, spare, out = np.empty(corners, dtype=np.uint32), np.empty(corners, dtype=np.uint32), np.empty(flat)
    else:
        h = scratch.array("hash", corners, np.uint32)
        spare = scratch.array("spare", corners, np.uint32)
        out = scratch.array("gradients", flat)
    x, y, z = h
    # axes of x, y, z: z side, y side, x side: corner number = x side + 2 y side + 4 z side
    ax, ay, az = first[:, 0], first[:, 1, None], first[:, 2, None, None]
    np.add(az * ay, ax, out=x)
    np.multiply(x, az, out=y)
    y += ay
    np.multiply(x, y, out=z)
    z += az
    np.right_shift(h, _SIXTEEN, out=spare)
    h ^= spare
    t = spare[0]
    np.multiply(y, z, out=t)
    x += t
    np.multiply(z, x, out=t)
    y += t
    np.multiply(x, y, out=t)
    z += t
    signed = h.view(np.int32)
    signed >>= _EIGHT
    out[...] = signed.reshape(flat)
    return out


def _mix(h: Words) -> Floats:
    """PCG3D after its first multiply-add, on `h` (3, ...) in place, as f64 gradient components."""
    x, y, z = h
    t = y * z
    x += t
    np.multiply(z, x, out=t)
    y += t
    np.multiply(x, y, out=t)
    z += t
    h ^= h >> _SIXTEEN
    np.multiply(y, z, out=t)
    x += t
    np.multiply(z, x, out=t)
    y += t
    np.multiply(x, y, out=t)
    z += t
    signed = h.view(np.int32)
    signed >>= _EIGHT
    return signed.astype(np.float64)
