"""Light on a surface: the sun's, and the sky's from wherever the ground is not seen, for any normal.

The sky's first order is a product rule of Gauss-Legendre panels over elevation and azimuth, whose limits follow the
surface's own plane; the other orders are Monte-Carlo.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from .air_medium import AirParameters, Floats
from .air_multiple import MOST_ORDERS, SOBOL_DIMENSIONS, first_order_check, replicated, tracer_for, turns
from .air_paths import Front, disc_cosine, turned
from .air_quadrature import gauss_legendre
from .air_rays import make_rays, units, vectors
from .air_single import single_scattering, sun_seen
from .air_transmittance import optical_lengths, transmittance_of


@dataclass(frozen=True)
class Irradiance:
    """Light on N surfaces per unit solar irradiance."""

    direct: Floats
    """(N, 3) the sun's, cosine included."""
    sky: Floats
    """(N, 3)"""
    sky_standard_error: Floats
    """(N, 3) one standard deviation of `sky`."""
    sky_by_order: Floats
    """(N, K, 3)"""
    single_check: Floats
    """(N, 3) the first order of the paths less the cubature's, in standard errors of the paths."""


def direct_irradiance(air: AirParameters, positions_m: Floats, normals: Floats, suns: Floats) -> Floats:
    """(N, 3): transmittance towards max(mu_s, cos_h) times the mean cosine of what is seen of the disc.

    The disc is cut by the surface's own plane or by the planet's horizon: whatever leaves less counts, and on level
    ground, where they are the same, it counts once.
    """
    radius = np.linalg.norm(positions_m, axis=1)
    level = air.level(radius - air.radius_m)
    rise = np.einsum("ij,ij->i", positions_m, suns)
    horizon = np.sqrt(np.maximum(level, 0.0))
    cosine = np.einsum("ij,ij->i", normals, suns)
    a = air.sun_angular_radius_rad
    mean = np.minimum(
        disc_cosine(cosine, a), sun_seen(air, level, rise, "disc") * np.maximum(cosine, np.where(cosine > -a, a, 0.0))
    )
    start = np.maximum(rise, -horizon)
    perigee = level - start * start
    half = np.sqrt(np.maximum(air.level(air.thickness_m) - perigee, 0.0))
    start = np.maximum(start, -half)
    lengths = optical_lengths(air, perigee, start, np.maximum(half, start))
    return mean[:, None] * transmittance_of(air, lengths)


def sky_single_irradiance(
    air: AirParameters, position_m: Floats, normal: Floats, sun: Floats, nodes: int = 16, rtol: float = 1e-6
) -> Floats:
    """(3,) the sky's first order on one surface; twice the `nodes` give an error estimate."""
    directions, weights = _sky_rule(air, position_m, normal, sun, nodes)
    rays = make_rays(air, np.broadcast_to(position_m, directions.shape), directions)
    single = single_scattering(air, rays, sun[None, :], "disc", rtol)
    return weights @ np.where(rays.hits_ground[:, None], 0.0, single.radiance)


def _sky_rule(air: AirParameters, position: Floats, normal: Floats, sun: Floats, nodes: int) -> tuple[Floats, Floats]:
    """Directions (M, 3) above the horizon and before the surface, and their weights with the surface's cosine."""
    radius = float(np.linalg.norm(position))
    up = position / radius
    east = sun - (sun @ up) * up
    if np.linalg.norm(east) < 1e-9:
        east = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    nz, nx, ny = float(normal @ up), float(normal @ east), float(normal @ north)
    flat = float(np.hypot(nx, ny))
    lowest = -np.sqrt(max(1.0 - (air.radius_m / max(radius, air.radius_m)) ** 2, 0.0))
    # Towards the horizon the air gets long, over a few hundredths of the cosine.
    layers = lowest + (1.0 - lowest) * np.array([0.0, 0.004, 0.03, 0.15, 0.5, 1.0])
    # Where the surface's plane touches a cone of constant elevation, the limits in azimuth have a root: split there.
    # The dust's glow around the sun, twice as wide as its core.
    glow = float(sun @ up) + np.array([-0.12, 0.0, 0.12])
    edges = np.unique(np.clip(np.concatenate([layers, glow, [-flat, flat, 0.0]]), lowest, 1.0))
    x, w = gauss_legendre(nodes)
    found: list[tuple[Floats, Floats]] = []
    for low, high in pairwise(edges):
        # mu = low + (high - low) sin^2: smooth for limits that begin or end like a root.
        angle = 0.25 * np.pi * (x + 1.0)
        mus = low + (high - low) * np.sin(angle) ** 2
        steps = w * 0.25 * np.pi * (high - low) * np.sin(2.0 * angle)
        for mu, step in zip(mus, steps, strict=True):
            sine = np.sqrt(max(1.0 - mu * mu, 0.0))
            reach = np.arccos(np.clip(-nz * mu / max(sine * flat, 1e-300), -1.0, 1.0))
            if reach <= 0.0:
                continue
            middle = float(np.arctan2(ny, nx)) if flat > 1e-12 else 0.0
            phi, width = _azimuths(middle, float(reach), flat <= 1e-12 or abs(ny) <= 1e-12, nodes)
            d = mu * up + sine * (np.cos(phi)[:, None] * east + np.sin(phi)[:, None] * north)
            found.append((d, step * width * np.maximum(d @ normal, 0.0)))
    if not found:
        return np.empty((0, 3)), np.empty(0)
    return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])


def _azimuths(middle: float, reach: float, mirrored: bool, nodes: int) -> tuple[Floats, Floats]:
    """Azimuths from the sun's and their weights, over middle -+ reach; only one half of it where both are alike."""
    ends = np.array([middle, middle + reach]) if mirrored else np.array([middle - reach, middle + reach])
    # The glow of dust stands around the sun, at azimuth 0: panels grow from there.
    marks = np.array([0.0, 0.15, 0.5, 1.2, 2.2, np.pi])
    marks = np.concatenate(
        [marks + 2.0 * np.pi * k for k in (-1, 0, 1)] + [-marks + 2.0 * np.pi * k for k in (-1, 0, 1)]
    )
    inner = marks[(marks > ends[0] + 1e-9) & (marks < ends[1] - 1e-9)]
    edges = np.unique(np.concatenate([ends, inner]))
    half, centre = 0.5 * np.diff(edges), 0.5 * (edges[1:] + edges[:-1])
    few = max(nodes // 2, 4)
    x, w = gauss_legendre(few)
    phi = (centre[:, None] + half[:, None] * x).ravel()
    return phi, (half[:, None] * w).ravel() * (2.0 if mirrored else 1.0)


def irradiance(
    params: AirParameters, positions_m: ArrayLike, normals: ArrayLike, sun_directions: ArrayLike,
    orders: int | None = None, paths: int = 65_536, seed: int = 0, nodes: int = 8,
) -> Irradiance:  # fmt: skip
    """Sun and sky on surfaces at positions (N, 3) with normals (N, 3); `orders` None: all.

    A query takes some seconds: thousands of rays for the first order, and the paths. `nodes` per panel of the first
    order: 8 are good to 1e-4, 12 to 1e-5.
    """
    positions = vectors(positions_m, "positions_m")
    positions, across, suns = np.broadcast_arrays(
        positions, units(normals, "normals"), units(sun_directions, "sun_directions")
    )
    most = orders or MOST_ORDERS
    count = len(positions)
    each = (count, params.wavelengths)
    by_order, error, check = np.zeros((count, most, params.wavelengths)), np.zeros(each), np.zeros(each)
    for n in range(count):
        by_order[n, 0] = sky_single_irradiance(params, positions[n], across[n], suns[n], nodes)
        if most > 1:
            means = _replicates(params, positions[n], across[n], suns[n], most, paths, (seed, n))
            error[n] = means[:, 1:].sum(axis=1).std(axis=0, ddof=1) / np.sqrt(len(means))
            check[n] = first_order_check(means[:, 0], by_order[n, 0])
            by_order[n, 1:] = means[:, 1:].mean(axis=0)
    used = max(int(np.nonzero(by_order.any(axis=(0, 2)))[0].max(initial=0)) + 1, orders or 1)
    return Irradiance(
        direct_irradiance(params, positions, across, suns), by_order.sum(axis=1), error, by_order[:, :used], check
    )


def _replicates(
    air: AirParameters, position: Floats, normal: Floats, sun: Floats, most: int, paths: int, seed: tuple[int, ...]
) -> Floats:
    """(replicates, orders, 3) of directions sampled by the surface's cosine."""
    tracer = tracer_for(air, sun)

    def of_lanes(uniforms: Floats, rng: np.random.Generator) -> Floats:
        lanes = len(uniforms)
        axis = np.tile(normal, (lanes, 1))
        directions = turned(axis, np.sqrt(uniforms[:, -2]), 2.0 * np.pi * uniforms[:, -1])
        rays = make_rays(air, np.tile(position, (lanes, 1)), directions)
        weight = np.where(rays.hits_ground, 0.0, np.pi)[:, None] * np.ones(air.wavelengths)
        start = rays.perigee_m + rays.start_m[:, None] * rays.direction
        front = Front(np.arange(lanes), start, rays.direction, weight)
        return tracer.trace(front, rays, turns(uniforms, rng), most, fixed=False)

    return replicated(of_lanes, SOBOL_DIMENSIONS + 2, paths, seed)
