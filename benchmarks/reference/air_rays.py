"""Straight rays through the shell, each described by its closest approach to the centre and distances from there.

Along a ray the squared distance from the centre is r_p^2 + s^2 with s counted from the closest approach (perigee), so
that h (2 R + h) = level_p + s^2: heights follow without cancellation, near the ground as far out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .air_medium import AirParameters, Floats

ON_GROUND = 1e-9
"""A start this part of the radius below the sphere is taken as on it: coordinates have no more digits."""


@dataclass(frozen=True)
class Rays:
    """N rays from `start_m` to `end_m`, both signed distances from the perigee; no air on a ray: end = start."""

    perigee_m: Floats
    """(N, 3) closest points of the lines to the planet's centre."""
    direction: Floats
    """(N, 3) unit directions."""
    level_m2: Floats
    """(N,) h (2 R + h) of the perigee, negative for lines through the ball."""
    start_m: Floats
    end_m: Floats
    hits_ground: NDArray[np.bool_]
    """(N,) whether the ray, without a given length, ends on the sphere."""

    def chosen(self, at: NDArray[Any]) -> Rays:
        """Some of them, by mask or by numbers (repeats allowed)."""
        return Rays(
            self.perigee_m[at], self.direction[at], self.level_m2[at], self.start_m[at], self.end_m[at],
            self.hits_ground[at],
        )  # fmt: skip


def vectors(values: ArrayLike, what: str) -> Floats:
    """(N, 3) finite float64; ValueError otherwise."""
    array = np.atleast_2d(np.asarray(values, dtype=np.float64))
    if array.ndim != 2 or array.shape[1] != 3 or not np.isfinite(array).all():
        raise ValueError(f"{what}: expected finite vectors (N, 3), found shape {np.shape(values)}")
    return array


def units(values: ArrayLike, what: str) -> Floats:
    """(N, 3) float64 of length 1; ValueError for a zero vector."""
    array = vectors(values, what)
    lengths = np.linalg.norm(array, axis=1, keepdims=True)
    if not (lengths > 0.0).all():
        raise ValueError(f"{what}: a direction has length 0")
    return array / lengths


def make_rays(
    air: AirParameters, positions_m: ArrayLike, directions: ArrayLike, distance_m: ArrayLike | None = None
) -> Rays:
    """Rays from positions (N, 3) into directions (N, 3), as far as space, the ground or `distance_m` (N,).

    A start above the air moves to where the ray enters it. A start on or above the sphere ends where it meets the
    sphere; one below it never meets it: it goes through air held at the floor's density and out.
    """
    p, d = np.broadcast_arrays(vectors(positions_m, "positions_m"), units(directions, "directions"))
    along = np.einsum("ij,ij->i", p, d)
    perigee = p - along[:, None] * d
    # From the cross product: the difference above loses digits of the length for a perigee far ahead.
    perigee_radius = np.linalg.norm(np.cross(p, d), axis=1)
    level = (perigee_radius - air.radius_m) * (perigee_radius + air.radius_m)
    radius = np.linalg.norm(p, axis=1)
    outside = radius >= air.radius_m * (1.0 - ON_GROUND)
    hits = outside & (level < 0.0) & (along < -1e-12 * radius)
    half_chord = np.sqrt(np.maximum(air.level(air.thickness_m) - level, 0.0))
    start = np.clip(along, -half_chord, half_chord)
    end = np.where(hits, -np.sqrt(np.maximum(-level, 0.0)), half_chord)
    if distance_m is not None:
        length = np.asarray(distance_m, dtype=np.float64)
        if not (length >= 0.0).all():
            raise ValueError("distance_m: expected distances >= 0")
        end = np.minimum(end, along + length)
    return Rays(perigee, d, level, start, np.maximum(end, start), hits)


def level_crossings(air: AirParameters, level_m2: Floats, heights_m: Floats) -> Floats:
    """(N, 2 K + 1) distances from the perigee where rays cross heights (K,), and the perigee; 0 where they do not."""
    there = np.sqrt(np.maximum(air.level(heights_m) - level_m2[:, None], 0.0))
    return np.concatenate([-there, np.zeros((len(level_m2), 1)), there], axis=1)
