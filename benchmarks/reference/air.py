"""The reference of clear air behind the calls of `planetfall.AtmosphereProbe`: the same questions, answered in float64.

Positions are planet-centred metres (N, 3), directions point away from them, sun directions to the sun (N, 3; one for
all is enough). Solar irradiance is 1. The sun's own disc and the light of a ground that is hit are left out; rays end
on the reference sphere. Deterministic answers are good to 1e-8 relative; what Monte-Carlo adds has standard errors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from .air_irradiance import Irradiance, irradiance
from .air_medium import EARTH_BRUNETON, SMALL_PLANET, AirParameters
from .air_multiple import Estimate, aerial_multiple, sky_multiple
from .air_single import sky_single
from .air_transmittance import transmittance

__all__ = [
    "EARTH_BRUNETON",
    "SMALL_PLANET",
    "AirParameters",
    "Estimate",
    "Irradiance",
    "in_scattering",
    "irradiance",
    "sky_radiance",
    "transmittance",
]

PARTS = ("rayleigh", "mie")


def sky_radiance(
    params: AirParameters, positions_m: ArrayLike, directions: ArrayLike, sun_directions: ArrayLike,
    orders: int | None = None, part: str | None = None, sun_visibility: str = "disc",
    paths: int = 65_536, seed: int = 0,
) -> Estimate:  # fmt: skip
    """Scattered light from positions into directions, to space or the ground.

    `orders` 1: single scattering, by quadrature; None: all, or up to a number, with `paths` paths a query (about 10 us
    each; 65 536 give 0.1 % by day, a per cent where only twice scattered twilight is left). `part` "rayleigh" or "mie":
    that kind's integral of the first order without its phase function.
    """
    if part is None:
        return sky_multiple(params, positions_m, directions, sun_directions, orders, paths, seed, sun_visibility)
    if part not in PARTS or orders not in (None, 1):
        raise ValueError(f'part: expected "rayleigh" or "mie" with orders=1, found {part!r} with orders={orders}')
    single = sky_single(params, positions_m, directions, sun_directions, sun_visibility)
    value = single.rayleigh if part == "rayleigh" else single.mie
    zeros = np.zeros_like(value)
    return Estimate(value, zeros, single.transmittance, value[:, None], zeros[:, None], zeros)


def in_scattering(
    params: AirParameters, positions_m: ArrayLike, points_m: ArrayLike, sun_directions: ArrayLike,
    orders: int | None = None, sun_visibility: str = "disc", paths: int = 65_536, seed: int = 0,
) -> Estimate:  # fmt: skip
    """Light scattered into the way from positions to points, and the way's transmittance."""
    return aerial_multiple(params, positions_m, points_m, sun_directions, orders, paths, seed, sun_visibility)
