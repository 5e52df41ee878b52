"""All orders of scattering in an even plane slab over black ground, by Monte-Carlo with a local estimate at each event.

Depths count from the top down; a direction is that of looking, by its angles to the upward normal and from the sun's
azimuth, so that 180 degrees looks straight down from above the slab and 0 straight up from below it. Solar irradiance
on a surface across the beam is 1. The first order is exact; what is sampled has standard errors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["SlabLight", "henyey_greenstein", "slab_light", "slab_single"]

Floats = NDArray[np.float64]
_ROULETTE = 0.1
"""Photons below this weight end, or go on with it, in proportion: no bias."""


@dataclass(frozen=True)
class SlabLight:
    """Radiance towards M cameras outside the slab, (M,) each, in 1 / sr."""

    single: Floats
    """Scattered once, in closed form."""
    multiple: Floats
    """Scattered more than once."""
    error: Floats
    """Standard error of `multiple`."""

    @property
    def total(self) -> Floats:
        """All orders."""
        return self.single + self.multiple


def henyey_greenstein(cosine: ArrayLike, asymmetry: float) -> Floats:
    """Henyey and Greenstein 1941, per steradian."""
    c, g = np.asarray(cosine, dtype=float), asymmetry
    return (1.0 - g * g) / (4.0 * np.pi * (1.0 + g * g - 2.0 * g * c) ** 1.5)


def slab_single(
    optical_depth: float, albedo: float, asymmetry: float, sun_zenith_deg: float, view_zenith_deg: ArrayLike,
    azimuth_deg: ArrayLike,
) -> Floats:  # fmt: skip
    """(M,) single scattering in closed form."""
    sun, view = np.cos(np.radians(sun_zenith_deg)), _ways(view_zenith_deg, azimuth_deg)
    nu = view @ _ways(sun_zenith_deg, 0.0)[0]
    up = view[:, 2]
    # Looking down, the way out is upwards: depth t / |up|; looking up it is the rest of the slab.
    rate = 1.0 / sun - 1.0 / up
    whole = np.where(
        np.abs(rate) * optical_depth < 1e-9,
        optical_depth,
        -np.expm1(-rate * optical_depth) / np.where(rate == 0.0, 1.0, rate),
    )
    ends = np.where(up < 0.0, 1.0, np.exp(-optical_depth / np.maximum(up, 1e-300)))
    return albedo * henyey_greenstein(nu, asymmetry) * whole * ends / np.abs(up)


def slab_light(
    optical_depth: float, albedo: float, asymmetry: float, sun_zenith_deg: float, view_zenith_deg: ArrayLike,
    azimuth_deg: ArrayLike, photons: int = 100_000, seed: int = 0, batches: int = 10,
) -> SlabLight:  # fmt: skip
    """Light towards cameras that look along view_zenith_deg, azimuth_deg (M,), none of them level."""
    rng = np.random.default_rng(seed)
    view = _ways(view_zenith_deg, azimuth_deg)
    found = np.array([
        _batch(rng, optical_depth, albedo, asymmetry, _ways(sun_zenith_deg, 0.0)[0], view, photons // batches)
        for _ in range(batches)
    ])  # fmt: skip
    single = slab_single(optical_depth, albedo, asymmetry, sun_zenith_deg, view_zenith_deg, azimuth_deg)
    return SlabLight(single, found.mean(0), found.std(0, ddof=1) / np.sqrt(batches))


def _batch(
    rng: np.random.Generator, thickness: float, albedo: float, g: float, sun: Floats, view: Floats, photons: int
) -> Floats:
    """(M,) radiance of the second order and those after it."""
    beam = thickness / sun[2]
    # The first event is forced into the slab, and has that probability as its weight.
    inside = -np.expm1(-beam)
    depth = -np.log1p(-rng.random(photons) * inside) * sun[2]
    way = np.broadcast_to(-sun, (photons, 3))
    weight = np.full(photons, inside * albedo)
    light = np.zeros(len(view))
    while depth.size:
        way = _turned(rng, way, g)
        # w is counted downwards in depth, upwards in directions.
        depth = depth + np.log1p(-rng.random(depth.size)) * way[:, 2]
        stays = (depth > 0.0) & (depth < thickness)
        depth, way, weight = depth[stays], way[stays], weight[stays]
        if not depth.size:
            break
        rest = np.where(view[:, 2] < 0.0, depth[:, None], thickness - depth[:, None]) / np.abs(view[:, 2])
        # Light travels against the direction of looking.
        phase = henyey_greenstein(-(way @ view.T), g)
        light += np.einsum("n,nm,nm->m", albedo * weight, phase, np.exp(-rest)) / np.abs(view[:, 2])
        weight = weight * albedo
        lost = (weight < _ROULETTE) & (rng.random(depth.size) * _ROULETTE > weight)
        weight = np.maximum(weight, _ROULETTE * (weight < _ROULETTE))[~lost]
        depth, way = depth[~lost], way[~lost]
    return light * sun[2] / photons


def _turned(rng: np.random.Generator, way: Floats, g: float) -> Floats:
    """(N, 3) directions after a scattering event."""
    count = len(way)
    u = rng.random(count)
    cosine = 2.0 * u - 1.0
    if abs(g) > 1e-6:
        cosine = (1.0 + g * g - ((1.0 - g * g) / (1.0 - g + 2.0 * g * u)) ** 2) / (2.0 * g)
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    turn = 2.0 * np.pi * rng.random(count)
    helper = np.where((np.abs(way[:, 2]) < 0.9)[:, None], (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    side = np.cross(way, helper)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = np.cross(way, side)
    across = sine[:, None] * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other)
    fresh = cosine[:, None] * way + across
    return fresh / np.linalg.norm(fresh, axis=1, keepdims=True)


def _ways(zenith_deg: ArrayLike, azimuth_deg: ArrayLike) -> Floats:
    """(M, 3) unit directions."""
    z, a = np.broadcast_arrays(np.radians(np.atleast_1d(zenith_deg)), np.radians(np.atleast_1d(azimuth_deg)))
    return np.stack([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)], axis=1)
