"""Checks of what is asked of samplers: each names the argument, what was expected, and what was found where."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .patch import TerrainPatch

__all__ = [
    "checked_directions",
    "checked_frame",
    "checked_lengths",
    "checked_pairs",
    "checked_points",
    "finite_lengths",
    "not_the_middle",
]

Floats = NDArray[np.float64]


def checked_directions(name: str, values: ArrayLike) -> Floats:
    """Unit vectors (N, 3) of directions (N, 3) or (3,); ValueError that names the argument and the index."""
    vectors = checked_points(name, values)
    largest = np.abs(vectors).max(axis=1, initial=0.0)
    bad = np.flatnonzero(largest == 0.0)
    if bad.size:
        raise ValueError(f"{name}[{bad[0]}]: expected a direction, found the zero vector")
    vectors = vectors / largest[:, None]  # so that squares neither overflow nor vanish
    return vectors / np.linalg.norm(vectors, axis=1)[:, None]


def checked_points(name: str, values: ArrayLike) -> Floats:
    """Finite vectors (N, 3) of (N, 3) or (3,); ValueError that names the argument and the index."""
    points = np.atleast_2d(_floats(name, values))
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"{name}: expected vectors of shape (N, 3), found shape {np.shape(values)}")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1))
    if bad.size:
        raise ValueError(f"{name}[{bad[0]}]: expected finite numbers, found {points[bad[0]].tolist()}")
    return points


def not_the_middle(name: str, points: Floats) -> Floats:
    """The points (N, 3) themselves; ValueError for one at the planet's centre, from which no way is up."""
    middle = np.flatnonzero(~points.any(axis=1))
    if middle.size:
        raise ValueError(f"{name}[{middle[0]}]: no ground is nearest to the planet's centre; give another place")
    return points


def checked_pairs(name: str, values: ArrayLike, other_name: str, others: ArrayLike) -> tuple[Floats, Floats]:
    """Two arrays (N, 3) of vectors, of which either may be a single one for all of the other."""
    a, b = checked_points(name, values), checked_points(other_name, others)
    if len(a) != len(b) and 1 not in (len(a), len(b)):
        raise ValueError(f"{name} and {other_name}: expected the same number of vectors, found {len(a)} and {len(b)}")
    count = max(len(a), len(b)) if len(a) and len(b) else 0
    return tuple(np.array(np.broadcast_to(v, (count, 3))) for v in (a, b))  # type: ignore[return-value]


def checked_lengths(name: str, values: ArrayLike, count: int) -> Floats:
    """Metres (count,) from 0 up, of one number or as many; ValueError that names the argument and the index."""
    numbers = _floats(name, values)
    if numbers.ndim > 1 or (numbers.ndim == 1 and len(numbers) not in (1, count)):
        raise ValueError(f"{name}: expected one number or {count}, found shape {numbers.shape}")
    numbers = np.array(np.broadcast_to(numbers, (count,)))
    bad = np.flatnonzero(~(numbers >= 0.0))
    if bad.size:
        raise ValueError(f"{name}[{bad[0]}]: expected a number of metres from 0 up, found {numbers[bad[0]]}")
    return numbers


def finite_lengths(name: str, values: ArrayLike, count: int) -> Floats:
    """As checked_lengths(), without inf."""
    numbers = checked_lengths(name, values, count)
    bad = np.flatnonzero(~np.isfinite(numbers))
    if bad.size:
        raise ValueError(f"{name}[{bad[0]}]: expected a finite number of metres, found {numbers[bad[0]]}")
    return numbers


def checked_frame(frame: TerrainPatch | tuple[ArrayLike, ArrayLike] | None) -> tuple[Floats, Floats] | None:
    """Origin (3,) and axes (3, 3), rows orthonormal, of what a patch takes as its frame; ValueError for others."""
    if frame is None:
        return None
    try:
        origin, axes = (frame.origin_m, frame.axes) if isinstance(frame, TerrainPatch) else frame
    except (TypeError, ValueError):
        raise ValueError(f"frame: expected a TerrainPatch or (origin_m, axes), found {frame!r}") from None
    turned = checked_points("frame axes", axes)
    if turned.shape != (3, 3) or np.abs(turned @ turned.T - np.eye(3)).max() > 1e-9:
        raise ValueError(f"frame: expected (origin_m, axes) with orthonormal rows, found axes {turned.tolist()}")
    return checked_points("frame origin_m", origin)[0], turned


def _floats(name: str, values: ArrayLike) -> Floats:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected real numbers, all rows equally long, found {values!r:.80}") from None
