"""Where a game lets nothing grow: what Cover.mask says of places, and functions for the commonest masks."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["clearing", "road"]

Floats = NDArray[np.float64]
Mask = Callable[[Floats], Floats]

_SAG = 0.1
"""How deep the middle of a piece of a road may lie below the sphere, over the road's width: moves its edge by 1 %."""


def clearing(place_m: ArrayLike, radius_m: float) -> Mask:
    """A mask for `Cover.mask`: nothing grows within radius_m, along the ground, of a place (3,).

    place_m is planet-centred, in metres, as positions of cameras and objects are: the planet's radius is taken from its
    length. ValueError names what is wrong.
    """
    place = _points("place_m", place_m)
    if len(place) != 1:
        raise ValueError(f"place_m: expected one place (3,), found {len(place)}; multiply several clearings")
    far = float(np.linalg.norm(place[0]))
    _check_width("radius_m", radius_m, far)
    middle, chord = place[0] / far, 2.0 * np.sin(0.5 * radius_m / far)

    def mask(directions: Floats) -> Floats:
        away = directions - middle
        return (np.einsum("ij,ij->i", away, away) > chord * chord).astype(np.float64)

    return mask


def road(points_m: ArrayLike, width_m: float) -> Mask:
    """A mask for `Cover.mask`: nothing grows on a road of width_m through points (N, 3), one after the other.

    points_m are planet-centred, in metres; between two of them the road is the shortest way. ValueError names what is
    wrong, with the index.
    """
    points = _points("points_m", points_m)
    if len(points) < 2:
        raise ValueError(f"points_m: expected two points or more, found {len(points)}; a single place is a pf.clearing")
    far = np.linalg.norm(points, axis=1)
    _check_width("width_m", width_m, float(far.min()))
    radius, half = float(far.mean()), 0.5 * width_m / float(far.mean())
    ends = _pieces(points / far[:, None], np.sqrt(8.0 * _SAG * width_m / radius))
    start, along = ends[:-1], np.diff(ends, axis=0)
    long_2 = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    middle, reach = start + 0.5 * along, 0.5 * np.sqrt(long_2) + half

    def mask(directions: Floats) -> Floats:
        out = np.ones(len(directions))
        centre = directions.mean(axis=0)
        size = np.sqrt(((directions - centre) ** 2).sum(axis=1).max())
        # Of a long road only what is near these places.
        near = np.flatnonzero(((middle - centre) ** 2).sum(axis=1) < (reach + size) ** 2)
        for k in near:
            away = directions - start[k]
            share = np.clip(away @ along[k] / long_2[k], 0.0, 1.0)
            away = away - share[:, None] * along[k]
            out[np.einsum("ij,ij->i", away, away) < half * half] = 0.0
        return out

    return mask


def _pieces(directions: Floats, longest: float) -> Floats:
    """Unit vectors along the great circles between neighbours, no two farther apart than `longest` (rad)."""
    found = [directions[:1]]
    for a, b in pairwise(directions):
        count = max(int(np.ceil(np.linalg.norm(b - a) / longest)), 1)
        share = (np.arange(count) + 1.0)[:, None] / count
        between = a + share * (b - a)
        found.append(between / np.linalg.norm(between, axis=1, keepdims=True))
    return np.concatenate(found)


def _points(name: str, values: ArrayLike) -> Floats:
    try:
        points = np.atleast_2d(np.asarray(values, dtype=np.float64))
    except (TypeError, ValueError):
        raise ValueError(f"{name}: expected planet-centred metres (N, 3), found {values!r:.80}") from None
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"{name}: expected planet-centred metres (N, 3), found shape {np.shape(values)}")
    bad = np.flatnonzero(~np.isfinite(points).all(axis=1) | ~points.any(axis=1))
    if bad.size:
        raise ValueError(f"{name}[{bad[0]}]: expected finite metres, not the centre, found {points[bad[0]].tolist()}")
    return points


def _check_width(name: str, width_m: float, far_m: float) -> None:
    if not 0.0 < width_m < far_m:
        raise ValueError(
            f"{name}: expected metres above 0 and below the place's distance from the planet's centre ({far_m:g}), "
            f"found {width_m!r}; multiply a unit direction by scene.planet.radius_m to get a place"
        )
