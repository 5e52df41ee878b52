"""Reading of cube_map.py as compiled loops: the same operations in the same order, so the same bits."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..compiled import Library, inlined

__all__ = ["block_values", "sample"]

Floats = NDArray[np.float64]

_library = Library("cube_map", [Path(__file__).read_text(encoding="utf-8")])


@inlined
def _place(x: float, y: float, z: float) -> tuple[int, float, float]:
    """The face that a direction meets, and s, t there."""
    ax, ay, az = abs(x), abs(y), abs(z)
    if ax >= ay and ax >= az:
        return (0, y / ax, z / ax) if x > 0.0 else (2, -y / ax, z / ax)
    if ay >= az:
        return (1, -x / ay, z / ay) if y > 0.0 else (3, x / ay, z / ay)
    return (4, y / az, -x / az) if z > 0.0 else (5, y / az, x / az)


@inlined
def _weights(f: float) -> tuple[float, float, float, float]:
    return (
        f * (-0.5 + f * (1.0 - 0.5 * f)),
        1.0 + f * f * (1.5 * f - 2.5),
        f * (0.5 + f * (2.0 - 1.5 * f)),
        f * f * (0.5 * f - 0.5),
    )


@_library.kernel
def _sample(values: Any, points: Any, out: Any) -> None:
    n = values.shape[1] - 3
    for p in range(points.shape[1]):
        face, s, t = _place(points[0, p], points[1, p], points[2, p])
        x, y = (s * 0.5 + 0.5) * n, (t * 0.5 + 0.5) * n
        i, j = min(max(np.floor(x), 0.0), n - 1.0), min(max(np.floor(y), 0.0), n - 1.0)
        wx, wy = _weights(x - i), _weights(y - j)
        column, line = int(i), int(j)
        for c in range(len(out)):
            total = 0.0
            for b in range(4):
                row = 0.0
                for a in range(4):
                    row += wx[a] * values[face, line + b, column + a, c]
                total += wy[b] * row
            out[c, p] = total


@_library.kernel
def _block_values(values: Any, points: Any, out: Any) -> None:
    blocks = values.shape[1]
    for p in range(points.shape[1]):
        face, s, t = _place(points[0, p], points[1, p], points[2, p])
        i, j = int((s * 0.5 + 0.5) * blocks), int((t * 0.5 + 0.5) * blocks)
        out[p] = values[face, min(max(j, 0), blocks - 1), min(max(i, 0), blocks - 1)]


def sample(values: NDArray[np.float32], points: Floats) -> Floats:
    """Values (channels, N) of a level, cubic between its samples, in the directions of points (3, N)."""
    out = np.empty((values.shape[3], points.shape[1]))
    _sample(values, np.ascontiguousarray(points), out)
    return out


def block_values(values: Floats, points: Floats) -> Floats:
    """Of blocks (6, n, n), a face's in equal parts, those that points (3, N) lie in (N,)."""
    out = np.empty(points.shape[1])
    _block_values(values, np.ascontiguousarray(points), out)
    return out
