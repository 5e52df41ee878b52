"""Homogeneous spherical cloud layers: optical depths in closed form, single scattering by adaptive quadrature.

Rays are described as those of clear air (air_rays), by their closest approach to the planet's centre and distances from
there. The planet is black and casts a hard shadow of the sun's centre; solar irradiance is 1. Around the layers is
nothing, or the air of air_medium, whose light and extinction then count as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .air_medium import AirParameters, Floats, densities, mie_phase, rayleigh_phase
from .air_quadrature import gauss_legendre, integrate
from .air_rays import units, vectors
from .air_single import sun_light
from .air_transmittance import optical_lengths, transmittance_of
from .cloud_slab import henyey_greenstein

__all__ = ["CloudLight", "Layer", "cloud_light", "cloud_transmittance"]


@dataclass(frozen=True)
class Layer:
    """One layer; parabola: denser in its middle, by 4 x (1 - x) over the share x of its height."""

    base_m: float
    top_m: float
    extinction_per_m: float
    albedo: float = 1.0
    asymmetry: float = 0.0
    parabola: bool = False


@dataclass(frozen=True)
class CloudLight:
    """Light along N rays, (N, 3) per wavelength."""

    radiance: Floats
    transmittance: Floats
    error: Floats
    """(N,) estimated relative error of the radiance; generous."""


@dataclass(frozen=True)
class _Lines:
    perigee_m: Floats
    direction: Floats
    level_m2: Floats
    start_m: Floats
    end_m: Floats


def cloud_transmittance(
    radius_m: float, layers: Sequence[Layer], positions_m: ArrayLike, directions: ArrayLike,
    air: AirParameters | None = None,
) -> Floats:  # fmt: skip
    """(N, 3) from positions (N, 3) into directions (N, 3), to space or the ground."""
    lines = _lines(radius_m, layers, positions_m, directions, air)
    return _transmittance(radius_m, layers, lines, air)


def cloud_light(
    radius_m: float, layers: Sequence[Layer], positions_m: ArrayLike, directions: ArrayLike, sun_directions: ArrayLike,
    air: AirParameters | None = None, rtol: float = 1e-6,
) -> CloudLight:  # fmt: skip
    """Single scattering by droplets, and by the air between them if there is any. Suns (N, 3), or one for all."""
    lines = _lines(radius_m, layers, positions_m, directions, air)
    suns = np.broadcast_to(units(sun_directions, "sun_directions"), lines.direction.shape)
    cosine = np.einsum("ij,ij->i", lines.direction, suns)
    lift = np.einsum("ij,ij->i", lines.perigee_m, suns)
    phases = np.array([layer.albedo * henyey_greenstein(cosine, layer.asymmetry) for layer in layers])

    def integrand(owner: NDArray[np.intp], s: Floats) -> Floats:
        flat = np.broadcast_to(owner[:, None], s.shape).ravel()
        at = s.ravel()
        level = lines.level_m2[flat] + at * at
        rise = lift[flat] + cosine[flat] * at
        below = level - rise * rise
        depth = layer_depth(radius_m, layers, lines.level_m2[flat], lines.start_m[flat], at)
        depth += layer_depth(radius_m, layers, below, rise, np.full_like(at, np.inf))
        seen = ((rise >= 0.0) | (below >= 0.0)) * np.exp(-depth)
        extinction = np.array([_extinction(radius_m, layer, level) for layer in layers])
        source = np.einsum("ln,ln->n", extinction, phases[:, flat])[:, None] * np.ones(3)
        light = seen[:, None] * np.ones(3)
        if air is not None:
            thin = densities(air, air.height(level))[:, :2] @ np.diag([1.0, 1.0])
            inside = (air.height(level) <= air.thickness_m)[:, None]
            scattering = air.scattering_per_m
            source = source + inside * (
                thin[:, :1] * scattering[0] * rayleigh_phase(cosine[flat])[:, None]
                + thin[:, 1:] * scattering[1] * mie_phase(cosine[flat], air.mie_asymmetry)[:, None]
            )
            way = optical_lengths(air, lines.level_m2[flat], lines.start_m[flat], at)
            light = light * transmittance_of(air, way) * sun_light(air, level, rise, "point")
        return (source * light).reshape(*s.shape, 3)

    found = integrate(integrand, _breaks(radius_m, layers, lines, suns, cosine, lift, air), 3, rtol)
    error = (found.error / np.maximum(found.value, 1e-300)).max(axis=1)
    return CloudLight(found.value, _transmittance(radius_m, layers, lines, air), error)


def layer_depth(radius_m: float, layers: Sequence[Layer], level_m2: Floats, start_m: Floats, end_m: Floats) -> Floats:
    """(N,) optical depth of all layers between two distances from the perigee of rays."""
    depth = np.zeros_like(level_m2)
    for layer in layers:
        outer, inner = (_half_chord(radius_m, h, level_m2) for h in (layer.top_m, layer.base_m))
        for low, high in ((-outer, -inner), (inner, outer)):
            a, b = np.clip(low, start_m, end_m), np.clip(high, start_m, end_m)
            depth += layer.extinction_per_m * _mean_profile(radius_m, layer, level_m2, a, b) * (b - a)
    return depth


def _mean_profile(radius_m: float, layer: Layer, level: Floats, a: Floats, b: Floats) -> Floats:
    if not layer.parabola:
        return np.ones_like(level)
    x, w = gauss_legendre(12)
    s = 0.5 * (a + b)[:, None] + 0.5 * (b - a)[:, None] * x
    return 0.5 * _profile(radius_m, layer, level[:, None] + s * s) @ w


def _profile(radius_m: float, layer: Layer, level: Floats) -> Floats:
    share = (_height(radius_m, level) - layer.base_m) / (layer.top_m - layer.base_m)
    return np.maximum(4.0 * share * (1.0 - share), 0.0) if layer.parabola else np.ones_like(share)


def _extinction(radius_m: float, layer: Layer, level: Floats) -> Floats:
    inside = (level > _level(radius_m, layer.base_m)) & (level < _level(radius_m, layer.top_m))
    return layer.extinction_per_m * inside * _profile(radius_m, layer, level)


def _level(radius_m: float, height_m: float) -> float:
    return height_m * (2.0 * radius_m + height_m)


def _height(radius_m: float, level: Floats) -> Floats:
    return level / (radius_m + np.sqrt(np.maximum(radius_m * radius_m + level, 0.0)))


def _half_chord(radius_m: float, height_m: float, level: Floats) -> Floats:
    return np.sqrt(np.maximum(_level(radius_m, height_m) - level, 0.0))


def _lines(
    radius_m: float, layers: Sequence[Layer], positions_m: ArrayLike, directions: ArrayLike, air: AirParameters | None
) -> _Lines:
    """Rays through all there is, cut at the ground."""
    p, d = np.broadcast_arrays(vectors(positions_m, "positions_m"), units(directions, "directions"))
    along = np.einsum("ij,ij->i", p, d)
    miss = np.linalg.norm(np.cross(p, d), axis=1)
    level = (miss - radius_m) * (miss + radius_m)
    top = max([layer.top_m for layer in layers] + ([air.thickness_m] if air is not None else []))
    half = _half_chord(radius_m, top, level)
    # A camera on the sphere may lie a rounding below it.
    lands = (level < 0.0) & (along < 0.0)
    end = np.where(lands, -np.sqrt(np.maximum(-level, 0.0)), half)
    start = np.clip(along, -half, half)
    return _Lines(p - along[:, None] * d, d, level, start, np.maximum(end, start))


def _transmittance(radius_m: float, layers: Sequence[Layer], lines: _Lines, air: AirParameters | None) -> Floats:
    depth = layer_depth(radius_m, layers, lines.level_m2, lines.start_m, lines.end_m)
    through = np.exp(-depth)[:, None] * np.ones(3)
    if air is None:
        return through
    return through * transmittance_of(air, optical_lengths(air, lines.level_m2, lines.start_m, lines.end_m))


def _breaks(
    radius_m: float, layers: Sequence[Layer], lines: _Lines, suns: Floats, cosine: Floats, lift: Floats,
    air: AirParameters | None,
) -> Floats:  # fmt: skip
    """(N, B) distances where the integrand is not smooth, or falls steeply from."""
    heights = [h for layer in layers for h in (layer.base_m, layer.top_m)]
    sine2 = (np.cross(lines.direction, suns) ** 2).sum(axis=1)
    found = [np.zeros((len(cosine), 1))]
    steps = np.geomspace(1e-3, 1e5, 17)
    for height in heights:
        half = _half_chord(radius_m, height, lines.level_m2)[:, None]
        found += [half, -half, *(sign * half + turn * steps for sign in (-1, 1) for turn in (-1, 1))]
    for height in [0.0, *heights]:
        found.append(_tangents(sine2, cosine, lift, lines.level_m2 - _level(radius_m, height)))
    if air is not None:
        for height in air.break_heights_m:
            half = _half_chord(radius_m, float(height), lines.level_m2)[:, None]
            found += [half, -half]
    ends = np.stack([lines.start_m, lines.end_m], axis=1)
    inner = np.concatenate([*found, ends[:, :1] + steps], axis=1)
    inner = np.where(np.isfinite(inner), inner, ends[:, :1])
    return np.concatenate([ends, np.clip(inner, ends[:, :1], ends[:, 1:])], axis=1)


def _tangents(sine2: Floats, cosine: Floats, lift: Floats, level: Floats) -> Floats:
    """(N, 2) both s at which the ray to the sun touches a sphere: (lift + cosine s)^2 = level + s^2."""
    b = lift * cosine
    with np.errstate(divide="ignore", invalid="ignore"):
        q = b + np.copysign(np.sqrt(lift * lift - sine2 * level), b)
        return np.stack([q / sine2, (level - lift * lift) / q], axis=1)
