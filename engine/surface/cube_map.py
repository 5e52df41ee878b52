"""Samples on the six faces of a cube around a sphere: made from maps, with borders and levels, and read bicubically.

Faces px, py, nx, ny, pz, nz. Seen from outside, a face's columns go to its right and its rows go up: right is east and
up is north on the four around the equator; right is +Y on both poles', up is -X on pz and +X on nz. Place (s, t) in
[-1, 1]^2 of a face lies in the direction normal + s right + t up: a plane, so both faces at an edge have the same
samples along it, and the cubic through them depends on these alone there: there is no seam, and no pole.

A level has (n + 1)^2 samples a face at s, t = -1 + 2 i / n, and one more all around, read across the edge. `values`
are (6, n + 3, n + 3, channels), [face, row, column]; sample (i, j) is at [face, j + 1, i + 1].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..compiled import Kernels

__all__ = ["FACES", "CubeMap", "cube_of", "face_directions", "face_place", "face_planes"]

Floats = NDArray[np.float64]
_COMPILED = Kernels(__package__, "cube_map_kernels")
Samples = NDArray[np.float32]

FACES = ("px", "py", "nx", "ny", "pz", "nz")

_NORMAL = np.array([[1, 0, 0], [0, 1, 0], [-1, 0, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
_RIGHT = np.array([[0, 1, 0], [-1, 0, 0], [0, -1, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]], dtype=np.float64)
_UP = np.array([[0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0, 1], [-1, 0, 0], [1, 0, 0]], dtype=np.float64)


def face_directions(face: int, s: Floats, t: Floats) -> Floats:
    """Directions (..., 3), not of unit length, of places of a face. At an edge both faces give the same numbers."""
    return _NORMAL[face] + s[..., None] * _RIGHT[face] + t[..., None] * _UP[face]


def face_place(points: Floats) -> tuple[NDArray[np.int64], Floats, Floats, Floats]:
    """face (N,), s, t (N,) and the component along its normal (N,) of points (3, N)."""
    x, y, z = points
    a = np.abs(points)
    side = (a[0] >= a[1]) & (a[0] >= a[2])
    other = ~side & (a[1] >= a[2])
    face = np.where(side, np.where(x > 0.0, 0, 2), np.where(other, np.where(y > 0.0, 1, 3), np.where(z > 0.0, 4, 5)))
    along = np.where(side, a[0], np.where(other, a[1], a[2]))
    right = np.choose(face, [y, -x, -y, x, y, y])
    up = np.choose(face, [z, z, z, z, -x, x])
    return face, right / along, up / along, along


def face_planes(direction: Floats) -> tuple[NDArray[np.bool_], Floats]:
    """Where the ray in `direction` (3,), of unit length, meets the planes of the faces: (s, t) (6, 2) beyond the faces'
    own places too, and whether it does, well ahead (6,); else 0."""
    along = _NORMAL @ direction
    near = along > _WELL_AHEAD
    place = np.stack([_RIGHT @ direction, _UP @ direction], axis=1) / np.where(near, along, 1.0)[:, None]
    return near, np.where(near[:, None], place, 0.0)


_WELL_AHEAD = 0.42  # 10 degrees beyond a face's corners


def face_weights(f: Floats) -> Floats:
    """Catmull-Rom weights (4, N) at the fraction f (N,)."""
    return np.stack(
        [
            f * (-0.5 + f * (1.0 - 0.5 * f)),
            1.0 + f * f * (1.5 * f - 2.5),
            f * (0.5 + f * (2.0 - 1.5 * f)),
            f * f * (0.5 * f - 0.5),
        ]
    )


def face_weight_slopes(f: Floats) -> Floats:
    return np.stack([-0.5 + f * (2.0 - 1.5 * f), f * (4.5 * f - 5.0), 0.5 + f * (4.0 - 4.5 * f), f * (1.5 * f - 1.0)])


@dataclass(frozen=True, eq=False)
class CubeMap:
    """Levels of samples, the finest first, each with half as many samples a side as the one before."""

    levels: tuple[Samples, ...]

    @property
    def cells(self) -> int:
        """Samples a side of a face at the finest level, less one."""
        return self.levels[0].shape[1] - 3

    @property
    def channels(self) -> int:
        return self.levels[0].shape[3]

    def sample(self, points: Floats, level: int = 0) -> Floats:
        """Values (channels, N) in the directions of points (3, N)."""
        if (compiled := _COMPILED()) is not None:
            return compiled.sample(self.levels[level], points)
        return self._cubic(points, level, slopes=False)[0]

    @staticmethod
    def block_values(values: Floats, points: Floats) -> Floats:
        """Of blocks (6, n, n), a face's in equal parts, those that points (3, N) lie in (N,)."""
        if (compiled := _COMPILED()) is not None:
            return compiled.block_values(values, points)
        blocks = values.shape[1]
        face, s, t, _ = face_place(points)
        i, j = (np.clip(((v * 0.5 + 0.5) * blocks).astype(np.int64), 0, blocks - 1) for v in (s, t))
        return values[face, j, i]

    def sample_gradient(self, points: Floats, level: int = 0) -> tuple[Floats, Floats]:
        """Values (channels, N) and their derivatives by the points, (channels, 3, N)."""
        return self._cubic(points, level, slopes=True)

    def _cubic(self, points: Floats, level: int, slopes: bool) -> tuple[Floats, Floats]:
        values = self.levels[level]
        n = values.shape[1] - 3
        face, s, t, along = face_place(points)
        x, y = (s * 0.5 + 0.5) * n, (t * 0.5 + 0.5) * n
        i, j = (np.clip(np.floor(v), 0, n - 1) for v in (x, y))
        fx, fy = x - i, y - j
        flat = values.reshape(-1, values.shape[3])
        corner = ((face * (n + 3) + j.astype(np.int64)) * (n + 3)) + i.astype(np.int64)
        wx, wy = face_weights(fx), face_weights(fy)
        value = np.zeros((len(fx), values.shape[3]))
        by_x, by_y = np.zeros_like(value), np.zeros_like(value)
        dwx, dwy = (face_weight_slopes(fx), face_weight_slopes(fy)) if slopes else (wx, wy)
        for b in range(4):
            taps = [flat[corner + b * (n + 3) + a] for a in range(4)]
            row = sum(w[:, None] * v for w, v in zip(wx, taps, strict=True))
            value += wy[b][:, None] * row
            if slopes:
                by_x += wy[b][:, None] * sum(w[:, None] * v for w, v in zip(dwx, taps, strict=True))
                by_y += dwy[b][:, None] * row
        if not slopes:
            return value.T, by_x
        normal, right, up = _NORMAL[face].T, _RIGHT[face].T, _UP[face].T
        ds, dt = (right - s * normal) / along, (up - t * normal) / along
        scale = 0.5 * n
        return value.T, scale * (by_x.T[:, None] * ds + by_y.T[:, None] * dt)

    def atlas(self) -> Samples:
        """All levels in one picture (rows, columns, channels): three faces a row, two rows a level, from the top.

        Level l begins at row 4 (n - n / 2^l) + 6 l.
        """
        n, channels = self.cells, self.channels
        rows = sum(2 * level.shape[1] for level in self.levels)
        picture = np.zeros((rows, 3 * (n + 3), channels), dtype=np.float32)
        top = 0
        for level in self.levels:
            size = level.shape[1]
            for face in range(6):
                row, column = top + size * (face // 3), size * (face % 3)
                picture[row : row + size, column : column + size] = level[face]
            top += 2 * size
        return picture


def cube_of(read: Callable[[Floats], Floats], cells: int, coarsest: int = 8) -> CubeMap:
    """A cube map of `cells` (made a multiple of what halving needs) from read(directions (3, N)) -> (channels, N)."""
    halvings = 0
    while cells >> (halvings + 1) >= coarsest and halvings < 10:
        halvings += 1
    cells = -(-cells >> halvings) << halvings
    rows = []
    for face in range(6):
        at = (2.0 * np.arange(-1, cells + 2) - cells) / cells  # symmetric, so that edges are equal to the last bit
        parts = []
        for block in np.array_split(at, max(len(at) ** 2 // 200_000, 1)):
            directions = face_directions(face, *np.broadcast_arrays(at[None, :], block[:, None]))
            parts.append(read(directions.reshape(-1, 3).T).T.reshape(len(block), len(at), -1))
        rows.append(np.concatenate(parts))
    levels = [np.stack(rows).astype(np.float32)]
    for _ in range(halvings):
        levels.append(_halved(levels[-1]))
    return CubeMap(tuple(levels))


def _halved(values: Samples) -> Samples:
    """The next level: every second sample of [1 2 1] / 4 both ways, and a border read from the neighbours."""
    n = (values.shape[1] - 3) // 2
    v = values.astype(np.float64)
    v = v[:, :-2:2] * 0.25 + v[:, 1:-1:2] * 0.5 + v[:, 2::2] * 0.25
    v = v[:, :, :-2:2] * 0.25 + v[:, :, 1:-1:2] * 0.5 + v[:, :, 2::2] * 0.25
    assert v.shape[1] == n + 1
    out = np.empty((6, n + 3, n + 3, values.shape[3]), dtype=np.float32)
    out[:, 1:-1, 1:-1] = v
    at = (2.0 * np.arange(-1, n + 2) - n) / n
    for face in range(6):
        for row, column in ((0, None), (-1, None), (None, 0), (None, -1)):
            s = at if column is None else np.full(n + 3, at[column])
            t = at if row is None else np.full(n + 3, at[row])
            border = _linear(v, face_directions(face, s, t).T)
            if row is None:
                out[face, :, column] = border
            else:
                out[face, row] = border
    return out


def _linear(inner: Floats, points: Floats) -> Floats:
    """Bilinear (N, channels) in borderless faces (6, n + 1, n + 1, channels), places beyond a cube's corner clamped."""
    n = inner.shape[1] - 1
    face, s, t, _ = face_place(points)
    x, y = (np.clip((v * 0.5 + 0.5) * n, 0.0, n) for v in (s, t))
    i, j = (np.minimum(v.astype(np.int64), n - 1) for v in (x, y))
    fx, fy = (x - i)[:, None], (y - j)[:, None]
    low = inner[face, j, i] * (1.0 - fx) + inner[face, j, i + 1] * fx
    high = inner[face, j + 1, i] * (1.0 - fx) + inner[face, j + 1, i + 1] * fx
    return low * (1.0 - fy) + high * fy
