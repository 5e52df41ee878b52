"""Single scattering of sunlight in clear air by adaptive quadrature, split where sunlight begins and ends on the ray.

Two conventions of the sun at the horizon of a point at r, with sin_h = R / r and cos_h = -sqrt(1 - sin_h^2): `disc`,
the transmittance towards max(mu_s, cos_h) times smoothstep(-a sin_h, a sin_h, mu_s - cos_h), a the sun's angular
radius; `point`, the sun's centre behind a hard shadow. Solar irradiance is 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .air_medium import AirParameters, Floats, densities, mie_phase, rayleigh_phase
from .air_quadrature import integrate
from .air_rays import Rays, level_crossings, make_rays, units, vectors
from .air_transmittance import optical_lengths, transmittance_of

VISIBILITIES = ("disc", "point")


@dataclass(frozen=True)
class SingleScattering:
    """Single scattering of N rays, per unit solar irradiance."""

    rayleigh: Floats
    """(N, 3) integral of scattering by molecules, without its phase function."""
    mie: Floats
    """(N, 3) the same of dust."""
    radiance: Floats
    """(N, 3) both with their phase functions (1 / sr)."""
    transmittance: Floats
    """(N, 3) along the ray."""
    error: Floats
    """(N,) estimated relative error of `radiance`; generous."""
    hits_ground: NDArray[np.bool_]


def sun_light(air: AirParameters, level_m2: Floats, rise_m: Floats, sun_visibility: str) -> Floats:
    """(N, 3) sunlight at points: transmittance to the sun times what is seen of it.

    `level_m2` (N,) is h (2 R + h) of the points, `rise_m` (N,) r mu_s: their coordinate along the sun's direction.
    """
    seen = sun_seen(air, level_m2, rise_m, sun_visibility)
    horizon = np.sqrt(np.maximum(level_m2, 0.0))  # -r cos_h
    light = np.zeros((len(seen), air.wavelengths))
    lit = seen > 0.0
    start = np.maximum(rise_m[lit], -horizon[lit])
    level = level_m2[lit] - start * start
    end = np.sqrt(np.maximum(air.level(air.thickness_m) - level, 0.0))
    lengths = optical_lengths(air, level, start, np.maximum(end, start))
    light[lit] = seen[lit, None] * transmittance_of(air, lengths)
    return light


def sun_seen(air: AirParameters, level_m2: Floats, rise_m: Floats, sun_visibility: str) -> Floats:
    """(N,) the part 0..1 of the sun that the planet does not hide."""
    above = rise_m + np.sqrt(np.maximum(level_m2, 0.0))
    if sun_visibility == "disc" and air.sun_angular_radius_rad > 0.0:
        r = np.sqrt(np.maximum(air.radius_m**2 + level_m2, 0.0))
        # Under the sphere sin_h stays 1, and so half the disc's height is a r.
        t = np.clip(0.5 + 0.5 * above / (air.sun_angular_radius_rad * np.minimum(r, air.radius_m)), 0.0, 1.0)
        return t * t * (3.0 - 2.0 * t)
    return (above >= 0.0).astype(float)


def check_visibility(sun_visibility: str) -> None:
    """ValueError for anything but the two conventions."""
    if sun_visibility not in VISIBILITIES:
        raise ValueError(f"sun_visibility: expected one of {', '.join(VISIBILITIES)}, found {sun_visibility!r}")


def single_scattering(
    air: AirParameters, rays: Rays, suns: Floats, sun_visibility: str = "disc", rtol: float = 1e-8
) -> SingleScattering:
    """Integrates over rays with sun directions (N, 3) of length 1."""
    check_visibility(sun_visibility)
    suns, width = np.broadcast_to(suns, rays.direction.shape), air.wavelengths
    cosine = np.einsum("ij,ij->i", rays.direction, suns)
    lift = np.einsum("ij,ij->i", rays.perigee_m, suns)

    def integrand(owner: NDArray[np.intp], s: Floats) -> Floats:
        level = rays.level_m2[owner, None] + s * s
        rise = lift[owner, None] + cosine[owner, None] * s
        light = sun_light(air, level.ravel(), rise.ravel(), sun_visibility).reshape(*s.shape, width)
        flat = np.broadcast_to(owner[:, None], s.shape).ravel()
        lengths = optical_lengths(air, rays.level_m2[flat], rays.start_m[flat], s.ravel())
        light *= transmittance_of(air, lengths).reshape(*s.shape, width)
        density = densities(air, air.height(level))
        return np.concatenate([density[..., :1] * light, density[..., 1:2] * light], axis=-1)

    breaks = _breaks(air, rays, suns, cosine, lift, sun_visibility)
    found = integrate(integrand, breaks, 2 * width, rtol)
    scattering = air.scattering_per_m
    rayleigh, mie = found.value[:, :width] * scattering[0], found.value[:, width:] * scattering[1]
    phases = rayleigh_phase(cosine)[:, None], mie_phase(cosine, air.mie_asymmetry)[:, None]
    radiance = rayleigh * phases[0] + mie * phases[1]
    spread = found.error[:, :width] * scattering[0] * phases[0] + found.error[:, width:] * scattering[1] * phases[1]
    error = np.where(radiance > 0.0, spread / np.maximum(radiance, 1e-300), 0.0).max(axis=1)
    whole = transmittance_of(air, optical_lengths(air, rays.level_m2, rays.start_m, rays.end_m))
    return SingleScattering(rayleigh, mie, radiance, whole, error, rays.hits_ground)


def _breaks(air: AirParameters, rays: Rays, suns: Floats, cosine: Floats, lift: Floats, sun_visibility: str) -> Floats:
    """(N, B) distances along rays where the integrand is not smooth, clipped to the rays; both ends are among them."""
    radius = air.radius_m
    sine2 = (np.cross(rays.direction, suns) ** 2).sum(axis=1)
    crossings = [level_crossings(air, rays.level_m2, np.append(air.break_heights_m, air.thickness_m))]
    # The sun's rim or centre on the horizon: lift + cosine s + sqrt(level + s^2) = k a R.
    rims = (-1.0, 0.0, 1.0) if sun_visibility == "disc" else (0.0,)
    for rim in rims:
        offset = rim * air.sun_angular_radius_rad * radius
        crossings.append(_quadratic(sine2, cosine, lift - offset, rays.level_m2))
    # The sun's ray touches a kink, or the top: level of its perigee = the kink's.
    for height in np.append(air.kink_heights_m[1:], air.thickness_m):
        crossings.append(_quadratic(sine2, cosine, lift, rays.level_m2 - air.level(height)))
    # Below the sphere the horizon is level: the sun's centre is on it where lift + cosine s = 0.
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings.append((-lift / cosine)[:, None])
    ends = np.stack([rays.start_m, rays.end_m], axis=1)
    inner = np.concatenate(crossings, axis=1)
    inner = np.where(np.isfinite(inner), inner, ends[:, :1])
    return np.concatenate([ends, np.clip(inner, ends[:, :1], ends[:, 1:])], axis=1)


def _quadratic(sine2: Floats, cosine: Floats, lift: Floats, level: Floats) -> Floats:
    """(N, 2) both s with (lift + cosine s)^2 = level + s^2; not finite where there is none."""
    b = lift * cosine
    with np.errstate(divide="ignore", invalid="ignore"):
        q = b + np.copysign(np.sqrt(lift * lift - sine2 * level), b)
        return np.stack([q / sine2, (level - lift * lift) / q], axis=1)


def sky_single(
    params: AirParameters,
    positions_m: ArrayLike,
    directions: ArrayLike,
    sun_directions: ArrayLike,
    sun_visibility: str = "disc",
    rtol: float = 1e-8,
) -> SingleScattering:
    """Single scattering on rays from positions (N, 3) to space or the ground; suns (N, 3) or one for all."""
    rays = make_rays(params, positions_m, directions)
    return single_scattering(params, rays, units(sun_directions, "sun_directions"), sun_visibility, rtol)


def aerial_single(
    params: AirParameters,
    positions_m: ArrayLike,
    points_m: ArrayLike,
    sun_directions: ArrayLike,
    sun_visibility: str = "disc",
    rtol: float = 1e-8,
) -> SingleScattering:
    """Single scattering between positions (N, 3) and points (N, 3), as far as the ground lets one see."""
    rays = rays_between(params, positions_m, points_m)
    return single_scattering(params, rays, units(sun_directions, "sun_directions"), sun_visibility, rtol)


def rays_between(params: AirParameters, positions_m: ArrayLike, points_m: ArrayLike) -> Rays:
    """Rays from positions (N, 3) that end at points (N, 3) or before, on the ground or where the air ends."""
    p, q = np.broadcast_arrays(vectors(positions_m, "positions_m"), vectors(points_m, "points_m"))
    return make_rays(params, p, q - p, np.linalg.norm(q - p, axis=1))
