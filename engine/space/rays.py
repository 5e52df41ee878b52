"""Rays against spheres, stable from 1 cm above a giant planet to a billion metres away from an asteroid."""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


class SphereHit(NamedTuple):
    """Where rays cross a sphere; arrays of one shape."""

    hit: NDArray[np.bool_]
    """Whether the sphere is crossed at or ahead of the origin."""
    near_m: Floats
    """Distance of the first crossing ahead (from inside: the exit); inf if there is none."""
    far_m: Floats
    """Distance of the last crossing ahead (from inside: the exit); inf if there is none."""


def ray_sphere(height_m: ArrayLike, mu: ArrayLike, radius_m: ArrayLike) -> SphereHit:
    """Cross rays with a sphere, from the origin's height above it (negative inside) and the cosine to its zenith.

    With b = (R + h) mu and c = h (2 R + h) the discriminant b^2 - c is formed as the product
    (R mu^2 / (1 + s) - h s) (R + (R + h) s), s = sqrt(1 - mu^2): it cancels only for rays that graze. The far root is
    q = -b - copysign(sqrt(D), b), the other c / q, so neither is a difference of nearly equal numbers. A level ray
    (mu = 0) from inside has b = +0: its exit is c / q.
    """
    h, mu, radius = np.broadcast_arrays(*(np.asarray(a, dtype=np.float64) for a in (height_m, mu, radius_m)))
    s = np.sqrt(np.maximum((1.0 - mu) * (1.0 + mu), 0.0))
    b = (radius + h) * mu
    c = h * (2.0 * radius + h)
    discriminant = (radius * (mu * mu) / (1.0 + s) - h * s) * (radius + (radius + h) * s)
    inside = h < 0.0
    root = np.sqrt(np.maximum(discriminant, 0.0))
    q = -b - np.where(b < 0.0, -root, root)
    usable = q != 0.0
    other = np.where(usable, c, 0.0) / np.where(usable, q, 1.0)
    leaving = np.maximum(q, other)
    hit = usable & (discriminant >= 0.0) & (inside | (b < 0.0))
    return SphereHit(
        hit,
        np.where(hit, np.where(inside, leaving, other), np.inf),
        np.where(hit, np.where(inside, leaving, q), np.inf),
    )


def ray_sphere_from(origins_m: ArrayLike, directions: ArrayLike, radius_m: float) -> SphereHit:
    """Cross rays from planet-centred origins (..., 3) along unit directions (..., 3) with a sphere at the centre."""
    origins = np.asarray(origins_m, dtype=np.float64)
    distance = np.linalg.norm(origins, axis=-1)
    # An origin at the centre itself has no zenith; any cosine serves.
    mu = (origins * np.asarray(directions, dtype=np.float64)).sum(axis=-1) / np.where(distance > 0.0, distance, 1.0)
    return ray_sphere(distance - radius_m, np.clip(mu, -1.0, 1.0), radius_m)
