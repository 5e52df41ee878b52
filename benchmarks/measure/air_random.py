"""Random questions about clear air beside the grids of air_queries: none may be good on the grid's angles only."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..reference.air_medium import AirParameters, Floats
from .air_queries import (
    EARTH_RADIUS_M,
    EARTH_THICKNESS_M,
    NEAR_SPACE_M,
    SPACE_M,
    SPACE_SUNS_DEG,
    SUNS_DEG,
    AirQueries,
    horizon_zenith_deg,
)

Mask = NDArray[np.bool_]
HIGHEST_INSIDE_M = 50_000.0
CLOSEST_DEG = 0.1
"""How close to the horizon views come."""
_FIELDS = ("altitude_m", "sun_zenith_deg", "view_zenith_deg", "azimuth_deg", "distance_m", "hits_ground", "in_space")


def random_sky(air: AirParameters, count: int, seed: int) -> AirQueries:
    """Whole views: two thirds from inside the air, the others from space. Suns are those of the grid, for their classes
    and brightnesses; cameras and views are anywhere, many of them about the horizon and the sun."""
    rng = np.random.default_rng(seed)
    inside = 2 * count // 3
    return joined(_inside(air, inside, rng), _outside(air, count - inside, rng))


def joined(a: AirQueries, b: AirQueries) -> AirQueries:
    """Both, one after the other; of one planet."""
    if a.radius_m != b.radius_m:
        raise ValueError(f"joined: questions about planets of {a.radius_m:g} and {b.radius_m:g} m")
    both = [np.concatenate([getattr(a, name), getattr(b, name)]) for name in _FIELDS]
    return AirQueries(both[0], both[1], both[2], both[3], both[4], both[5], both[6], a.radius_m)


def _inside(air: AirParameters, count: int, rng: np.random.Generator) -> AirQueries:
    squeeze = air.thickness_m / EARTH_THICKNESS_M
    height = squeeze * 10.0 ** rng.uniform(0.0, np.log10(HIGHEST_INSIDE_M), count)
    height[rng.random(count) < 0.15] = 0.0
    sun = rng.choice(SUNS_DEG, count)
    horizon = np.array([horizon_zenith_deg(air, float(h)) for h in height])
    way = rng.random(count)
    anywhere = np.degrees(np.arccos(rng.uniform(-1.0, 1.0, count)))
    beside = horizon + rng.choice((-1.0, 1.0), count) * 10.0 ** rng.uniform(np.log10(CLOSEST_DEG), 1.3, count)
    near_sun = np.abs(sun + rng.normal(0.0, 10.0, count))
    view = np.where(way < 0.4, anywhere, np.where(way < 0.8, beside, near_sun))
    close = np.abs(view - horizon) < CLOSEST_DEG
    view[close] = horizon[close] - CLOSEST_DEG
    azimuth = np.where(way < 0.8, rng.uniform(0.0, 180.0, count), np.abs(rng.normal(0.0, 10.0, count)))
    return _queries(air, height, sun, np.minimum(view, 180.0), azimuth, view > horizon)


def _outside(air: AirParameters, count: int, rng: np.random.Generator) -> AirQueries:
    """Views by their impact parameter: over the disc by its area, and through the limb."""
    near = NEAR_SPACE_M * air.thickness_m / EARTH_THICKNESS_M
    far = SPACE_M[-1] * air.radius_m / EARTH_RADIUS_M
    height = near * (far / near) ** rng.random(count)
    disc = air.radius_m * np.sqrt(rng.random(count)) * 0.9999
    limb = air.radius_m + air.thickness_m * rng.uniform(0.005, 0.7, count)
    hits = rng.random(count) < 0.6
    view = 180.0 - np.degrees(np.arcsin(np.where(hits, disc, limb) / (air.radius_m + height)))
    return _queries(air, height, rng.choice(SPACE_SUNS_DEG, count), view, rng.uniform(0.0, 180.0, count), hits)


def _queries(air: AirParameters, height: Floats, sun: Floats, view: Floats, azimuth: Floats, hits: Mask) -> AirQueries:
    whole = np.full(len(height), np.inf)
    return AirQueries(height, sun, view, azimuth, whole, hits, height > air.thickness_m, air.radius_m)


def horizon_rays(air: AirParameters, positions_m: Floats, directions: Floats, within_rad: float = 1.7e-4) -> Mask:
    """(N,) whether rays pass the horizon so closely (default: 0.01 degrees) that rounding decides what they hit."""
    radius = np.linalg.norm(positions_m, axis=1)
    zenith = np.arccos(np.clip((positions_m * directions).sum(1) / radius, -1.0, 1.0))
    height = np.maximum(radius - air.radius_m, 0.0)
    horizon = 0.5 * np.pi + np.arctan2(np.sqrt(air.level(height)), air.radius_m)
    return np.abs(zenith - horizon) < within_rad
