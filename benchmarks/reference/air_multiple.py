"""All orders of scattering: the first by quadrature, the others by Monte-Carlo with standard errors.

The numbers of the first two turns of the paths are scrambled Sobol points (Owen 1997), in independent replicates whose
spread gives the standard errors.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .air_medium import AirParameters, Floats
from .air_paths import Front, Tracer, Uniforms
from .air_rays import Rays, make_rays, units
from .air_single import check_visibility, rays_between, single_scattering
from .air_tables import distance_table, length_table

MOST_ORDERS = 60
"""Where paths end in any case; roulette ends nearly all of them far earlier."""
REPLICATES = 64
EVEN = 0.5
"""The share of distances sampled evenly along a ray: at dusk it halves the paths needed, by day it costs nothing."""
_NUMBERS = 5
_SOBOL_TURNS = 2
SOBOL_DIMENSIONS = _NUMBERS * _SOBOL_TURNS
_LANES = 8192


@dataclass(frozen=True)
class Estimate:
    """Radiance of N queries per unit solar irradiance (1 / sr)."""

    radiance: Floats
    """(N, 3)"""
    standard_error: Floats
    """(N, 3) one standard deviation of `radiance`; 0 where nothing is random."""
    transmittance: Floats
    """(N, 3) along the ray."""
    by_order: Floats
    """(N, K, 3) what each order adds, from the first."""
    by_order_error: Floats
    """(N, K, 3) standard errors of `by_order`."""
    single_check: Floats
    """(N, 3) the first order by the paths less that by quadrature, in standard errors; 0 without paths."""


def sky_multiple(
    params: AirParameters, positions_m: ArrayLike, directions: ArrayLike, sun_directions: ArrayLike,
    orders: int | None = None, paths: int = 65_536, seed: int = 0, sun_visibility: str = "disc",
) -> Estimate:  # fmt: skip
    """Scattered light on rays from positions (N, 3) to space or the ground; `orders` None: all of them."""
    rays = make_rays(params, positions_m, directions)
    return scatter(params, rays, units(sun_directions, "sun_directions"), orders, paths, seed, sun_visibility)


def aerial_multiple(
    params: AirParameters, positions_m: ArrayLike, points_m: ArrayLike, sun_directions: ArrayLike,
    orders: int | None = None, paths: int = 65_536, seed: int = 0, sun_visibility: str = "disc",
) -> Estimate:  # fmt: skip
    """The same between positions (N, 3) and points (N, 3)."""
    rays = rays_between(params, positions_m, points_m)
    return scatter(params, rays, units(sun_directions, "sun_directions"), orders, paths, seed, sun_visibility)


def scatter(
    air: AirParameters, rays: Rays, suns: Floats, orders: int | None = None, paths: int = 65_536, seed: int = 0,
    sun_visibility: str = "disc",
) -> Estimate:  # fmt: skip
    """Scattered light on rays, `paths` paths each (rounded up to what replicates of Sobol points need)."""
    check_visibility(sun_visibility)
    if orders is not None and orders < 1:
        raise ValueError(f"orders: expected at least 1, or None for all, found {orders}")
    single = single_scattering(air, rays, suns, sun_visibility)
    count, most = len(rays.level_m2), orders or MOST_ORDERS
    width = air.wavelengths
    by_order, errors = np.zeros((count, most, width)), np.zeros((count, most, width))
    by_order[:, 0] = single.radiance
    total_error, check = np.zeros((count, width)), np.zeros((count, width))
    if most > 1:
        suns = np.broadcast_to(suns, rays.direction.shape)
        for n in np.nonzero(rays.end_m > rays.start_m)[0]:
            means = _replicates(tracer_for(air, suns[n], sun_visibility), rays, int(n), most, paths, seed)
            spread = means.std(axis=0, ddof=1) / np.sqrt(len(means))
            by_order[n, 1:], errors[n, 1:] = means[:, 1:].mean(axis=0), spread[1:]
            total_error[n] = means[:, 1:].sum(axis=1).std(axis=0, ddof=1) / np.sqrt(len(means))
            check[n] = first_order_check(means[:, 0], single.radiance[n])
    used = max(int(np.nonzero(by_order.any(axis=(0, 2)))[0].max(initial=0)) + 1, orders or 1)
    return Estimate(
        by_order.sum(axis=1), total_error, single.transmittance, by_order[:, :used], errors[:, :used], check
    )


def first_order_check(means: Floats, truth: Floats) -> Floats:
    """(3,) how many standard errors the mean of `means` (replicates, 3) is from the quadrature's `truth`.

    The tables' 2e-5 are part of the error: Sobol points leave less noise than that in the first order.
    """
    error = np.hypot(means.std(axis=0, ddof=1) / np.sqrt(len(means)), 2e-5 * truth)
    return (means.mean(axis=0) - truth) / np.maximum(error, 1e-30)


def tracer_for(air: AirParameters, sun: Floats, sun_visibility: str = "disc") -> Tracer:
    """Paths to one sun; the tables of the last few airs are kept."""
    return Tracer(air, length_table(air), distance_table(air, EVEN), sun, sun_visibility)


def _replicates(tracer: Tracer, rays: Rays, n: int, most: int, paths: int, seed: int) -> Floats:
    """(REPLICATES, orders, 3) means of independent groups of paths along ray n."""
    start = rays.perigee_m[n] + rays.start_m[n] * rays.direction[n]

    def of_lanes(uniforms: Floats, rng: np.random.Generator) -> Floats:
        lanes = len(uniforms)
        same = rays.chosen(np.full(lanes, n))
        whole = np.ones((lanes, tracer.air.wavelengths))
        front = Front(np.arange(lanes), np.tile(start, (lanes, 1)), same.direction, whole)
        return tracer.trace(front, same, turns(uniforms, rng), most, fixed=True)

    return replicated(of_lanes, SOBOL_DIMENSIONS, paths, (seed, n))


def turns(uniforms: Floats, rng: np.random.Generator) -> Uniforms:
    """Numbers of the turns of paths: Sobol's (lanes, 10) for the first two, random ones after that."""

    def numbers(turn: int) -> Floats:
        if turn < _SOBOL_TURNS:
            return uniforms[:, turn * _NUMBERS : (turn + 1) * _NUMBERS].copy()
        return rng.random((len(uniforms), _NUMBERS))

    return numbers


def replicated(
    of_lanes: Callable[[Floats, np.random.Generator], Floats], dimensions: int, paths: int, seed: tuple[int, ...]
) -> Floats:
    """(REPLICATES, ...) means of `of_lanes`(uniforms (lanes, dimensions), rng) -> (lanes, ...) over Sobol points."""
    try:
        from scipy.stats import qmc
    except ImportError as error:
        raise RuntimeError(
            "multiple scattering: needs scipy, which is not installed; try: pip install planetfall[dev]"
        ) from error
    # Its last argument is called rng since scipy 1.15; all of them know the old name, its type stubs do not.
    sobol: Any = qmc.Sobol
    each = 1 << max(int(np.ceil(np.log2(max(paths, 1) / REPLICATES))), 4)
    rng = np.random.default_rng(seed)
    together = max(_LANES // each, 1)
    means = []
    for first in range(0, REPLICATES, together):
        size = min(together, REPLICATES - first)
        points = [sobol(dimensions, scramble=True, seed=rng).random(each) for _ in range(size)]
        for start in range(0, each * size, max(_LANES, each)):
            lanes = of_lanes(np.concatenate(points)[start : start + max(_LANES, each)], rng)
            means.append(lanes.reshape(-1, each, *lanes.shape[1:]).mean(axis=1))
    return np.concatenate(means)
