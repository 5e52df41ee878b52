"""Light of clear air that is scattered once, where clouds keep a share of the sun from it: Gauss's rule in many panels.

The shadow is given as a function of places, so that any clouds can be asked about; it may jump, which is why there are
many. Solar irradiance is 1, the sun's disc is that of air_single.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .air_medium import AirParameters, Floats, densities, mie_phase, rayleigh_phase
from .air_quadrature import gauss_legendre
from .air_rays import units, vectors
from .air_single import rays_between, sun_light
from .air_transmittance import optical_lengths, transmittance_of

__all__ = ["shadowed_air"]

_BLOCK = 200_000
"""Places at a time."""


def shadowed_air(
    air: AirParameters, positions_m: ArrayLike, points_m: ArrayLike, sun_directions: ArrayLike,
    left: Callable[[NDArray[np.intp], Floats], Floats], panels: int = 400, points: int = 4,
) -> Floats:  # fmt: skip
    """(N, 3) radiance per unit solar irradiance between positions (N, 3) and points (N, 3) from the planet's centre.

    left: of M places, by the numbers (M,) of their rays and their distances (M,) from the positions, what counts of
    their light: the share of the sunlight that comes to them, times what comes from them to the camera through anything
    but the air. Panels grow with the distance from where the ray enters the air.
    """
    rays = rays_between(air, positions_m, points_m)
    suns = np.broadcast_to(units(sun_directions, "sun_directions"), rays.direction.shape)
    start = np.einsum("ij,ij->i", vectors(positions_m, "positions_m"), rays.direction)
    x, w = gauss_legendre(points)
    # Squares: dense near the camera.
    edges = np.linspace(0.0, 1.0, panels + 1) ** 2
    share = (0.5 * (edges[1:] + edges[:-1])[:, None] + 0.5 * np.diff(edges)[:, None] * x).ravel()
    weight = (0.5 * np.diff(edges)[:, None] * w).ravel()
    light = np.zeros((len(suns), 3))
    scattering = air.scattering_per_m
    rows = max(_BLOCK // len(share), 1)
    for first in range(0, len(suns), rows):
        of = np.arange(first, min(first + rows, len(suns)))
        length = rays.end_m[of] - rays.start_m[of]
        s = (rays.start_m[of, None] + length[:, None] * share).ravel()
        owner = np.repeat(of, len(share))
        way, sun = rays.direction[owner], suns[owner]
        level = rays.level_m2[owner] + s * s
        density = densities(air, air.height(level))
        cosine = np.einsum("ij,ij->i", way, sun)
        source = density[:, :1] * scattering[0] * rayleigh_phase(cosine)[:, None]
        source = source + density[:, 1:2] * scattering[1] * mie_phase(cosine, air.mie_asymmetry)[:, None]
        seen = transmittance_of(air, optical_lengths(air, rays.level_m2[owner], rays.start_m[owner], s))
        rise = np.einsum("ij,ij->i", rays.perigee_m[owner], sun) + s * cosine
        part = source * seen * sun_light(air, level, rise, "disc") * left(owner, s - start[owner])[:, None]
        light[of] = np.einsum("nkc,k->nc", part.reshape(len(of), -1, 3), weight) * length[:, None]
    return light
