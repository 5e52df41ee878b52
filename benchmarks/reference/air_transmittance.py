"""Optical lengths and transmittance of clear air by Gauss-Legendre panels between the densities' kinks."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .air_medium import AirParameters, Floats, densities
from .air_quadrature import gauss_legendre
from .air_rays import make_rays

NODES = 16
"""Gauss-Legendre nodes a panel. With twice as many, no optical length differs by more than 1e-12 (a test says so)."""
_CHUNK = 1 << 15


def optical_lengths(air: AirParameters, level_m2: Floats, start_m: Floats, end_m: Floats, nodes: int = NODES) -> Floats:
    """(N, 3) integrals of the densities of molecules, dust and absorber over rays (metres).

    `level_m2` is h (2 R + h) of the rays' perigees; `start_m <= end_m` are distances from there, inside the shell.
    """
    level, start, end = np.broadcast_arrays(level_m2, start_m, end_m)
    # Densities depend on |s| alone: a ray through its perigee is two rays that rise from it.
    through = (start < 0.0) & (end > 0.0)
    low = np.where(through, 0.0, np.where(end <= 0.0, -end, start))
    high = np.where(through | (end > 0.0), end, -start)
    lengths = _rising(air, level, low, high, nodes)
    if through.any():
        lengths[through] += _rising(air, level[through], np.zeros(through.sum()), -start[through], nodes)
    return lengths


def _rising(air: AirParameters, level: Floats, low: Floats, high: Floats, nodes: int) -> Floats:
    """(N, 3) optical lengths of rays from 0 <= low to high."""
    inner = np.sqrt(np.maximum(air.level(air.break_heights_m) - level[:, None], 0.0))
    edges = np.concatenate([low[:, None], np.clip(inner, low[:, None], high[:, None]), high[:, None]], axis=1)
    ray, panel = np.nonzero(edges[:, 1:] > edges[:, :-1])
    x, w = gauss_legendre(nodes)
    lengths = np.zeros((len(level), 3))
    for first in range(0, len(ray), _CHUNK):
        r, k = ray[first : first + _CHUNK], panel[first : first + _CHUNK]
        a, b = edges[r, k], edges[r, k + 1]
        half = 0.5 * (b - a)
        s = 0.5 * (a + b)[:, None] + half[:, None] * x
        parts = np.einsum("mnk,n->mk", densities(air, air.height(level[r, None] + s * s)), w) * half[:, None]
        for kind in range(3):
            lengths[:, kind] += np.bincount(r, parts[:, kind], len(level))
    return lengths


def transmittance_of(air: AirParameters, lengths_m: Floats) -> Floats:
    """exp(-optical depth) (..., 3 wavelengths) of optical lengths (..., 3 kinds)."""
    return np.exp(-lengths_m @ air.extinction_per_m)


def transmittance(
    params: AirParameters,
    positions_m: ArrayLike,
    directions: ArrayLike,
    distance_m: ArrayLike | None = None,
    nodes: int = NODES,
) -> Floats:
    """Transmittance (N, 3) from positions (N, 3) into directions (N, 3), over `distance_m` (N,) or to space.

    A ray that misses the air has 1. To space, a ray that meets the sphere has 0; over a distance, it ends there.
    Twice the `nodes` give an error estimate.
    """
    rays = make_rays(params, positions_m, directions, distance_m)
    through = transmittance_of(params, optical_lengths(params, rays.level_m2, rays.start_m, rays.end_m, nodes))
    return np.where(rays.hits_ground[:, None], 0.0, through) if distance_m is None else through
