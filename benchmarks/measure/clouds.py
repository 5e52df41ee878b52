"""Errors of the march through homogeneous clouds against the float64 references."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ... import Atmosphere, CloudLayer, CloudProbe, Clouds, Planet, Scene, Sun
from ..reference.air_medium import EARTH_BRUNETON, AirParameters, Floats
from ..reference.cloud_shells import Layer, cloud_light
from ..reference.cloud_slab import SlabLight, slab_light

__all__ = ["IN_AIR", "SHAFTS", "SHELLS", "SLAB_DEPTHS", "Errors", "Shells", "errors_of", "slab_errors"]

FLOOR = 1e-7
"""Radiance of a unit sun below which relative errors say nothing."""
SEED = 2018


@dataclass(frozen=True)
class Shells:
    """Homogeneous layers around a planet, in vacuum or in air."""

    radius_m: float
    layers: tuple[Layer, ...]
    air: AirParameters | None = None


EARTH_M = EARTH_BRUNETON.radius_m
SHELLS: Mapping[str, Shells] = {
    "depth 1": Shells(EARTH_M, (Layer(2000.0, 3000.0, 1e-3, 1.0, 0.8),)),
    "depth 50": Shells(EARTH_M, (Layer(1500.0, 4000.0, 0.02, 0.9999, 0.85),)),
    "cirrus": Shells(EARTH_M, (Layer(8000.0, 9000.0, 2e-4, 1.0, 0.6),)),
    "parabola": Shells(EARTH_M, (Layer(1500.0, 4000.0, 2e-3, 1.0, 0.8, parabola=True),)),
    "small planet": Shells(6e4, (Layer(300.0, 700.0, 5e-3, 1.0, 0.8),)),
    "two layers": Shells(EARTH_M, (Layer(1500.0, 2500.0, 2e-3, 1.0, 0.8), Layer(8000.0, 9000.0, 2e-4, 1.0, 0.6))),
}
IN_AIR: Mapping[str, Shells] = {
    "low": Shells(EARTH_M, (Layer(1500.0, 2500.0, 2e-3, 1.0, 0.8),), EARTH_BRUNETON),
    "high": Shells(EARTH_M, (Layer(8000.0, 9000.0, 2e-4, 1.0, 0.6),), EARTH_BRUNETON),
}
SHAFTS: Mapping[str, Shells] = {
    "black low clouds": Shells(EARTH_M, (Layer(1500.0, 2500.0, 1e-3, 0.0),), EARTH_BRUNETON),
    "black high clouds": Shells(EARTH_M, (Layer(8000.0, 9000.0, 5e-4, 0.0),), EARTH_BRUNETON),
}
"""Clouds that scatter nothing: what is left is the light of air in and out of their shadow."""
SLAB_DEPTHS = (0.5, 2.0, 8.0, 32.0)
SLAB_ZENITH_DEG = (180.0, 150.0, 120.0, 120.0, 60.0, 60.0, 0.0)
SLAB_AZIMUTH_DEG = (0.0, 0.0, 0.0, 180.0, 0.0, 180.0, 0.0)


@dataclass(frozen=True)
class Errors:
    """Of relative errors where there is light, the largest absolute one of transmittance, answers that are no light."""

    median: float
    p95: float
    worst: float
    transmittance: float
    bad: int
    count: int


def scene_of(shells: Shells) -> Scene:
    """The planet, with a sun of irradiance 1."""
    first, *others = (_layer(layer) for layer in shells.layers)
    clouds = Clouds(**first, layers=tuple(CloudLayer(**other) for other in others))
    parts: dict[str, Any] = {"planet": Planet(radius_m=shells.radius_m), "clouds": clouds}
    if shells.air is not None:
        parts["atmosphere"] = Atmosphere()  # the defaults are those of EARTH_BRUNETON
    scene = Scene("homogeneous clouds", parts)
    scene.sun = Sun(direction=(0.0, 0.0, 1.0), irradiance=(1.0, 1.0, 1.0))
    return scene


def errors_of(
    shells: Shells, quality: str, count: int, method: str = "ours", as_pictures: bool = False
) -> Errors:  # fmt: skip
    """Of single scattering, for `count` rays from everywhere. as_pictures: by the march that pictures are made with."""
    positions, ways, suns = _questions(shells, count)
    truth, through = _truth(shells, count)
    with CloudProbe(
        scene_of(shells), quality=quality, overrides={"clouds.method": method}, as_pictures=as_pictures
    ) as probe:
        light, passed = probe.march(positions, ways, suns, orders=1, sun_visibility="point")
    bad = ~(np.isfinite(light) & (light >= 0.0)).all(1)
    seen = truth > FLOOR
    relative = np.abs(np.where(np.isfinite(light), light, 0.0) - truth)[seen] / truth[seen]
    return _errors(relative, float(np.abs(passed - through).max()), int(bad.sum()))


def slab_errors(depth: float, quality: str, photons: int, as_pictures: bool = False) -> tuple[Errors, float]:
    """Of all orders in a flat slab, and the standard error of the reference that is worst. as_pictures: by the march
    that pictures are made with."""
    flat_m, base_m = 1e8, 1000.0
    zenith, azimuth = np.array(SLAB_ZENITH_DEG), np.array(SLAB_AZIMUTH_DEG)
    relative, noise = [], 0.0
    for albedo, asymmetry in ((1.0, 0.0), (1.0, 0.8), (0.999, 0.85)):
        shells = Shells(flat_m, (Layer(base_m, 2.0 * base_m, depth / base_m, albedo, asymmetry),))
        height = np.where(zenith > 90.0, 2.0 * base_m + 1.0, base_m - 1.0)
        place = np.stack([0.0 * height, 0.0 * height, flat_m + height], axis=1)
        with CloudProbe(scene_of(shells), quality=quality, as_pictures=as_pictures) as probe:
            for sun in (0.0, 60.0):
                light = probe.march(place, _ways(zenith, azimuth), _ways(sun, 0.0), ground_albedo=0.0)[0][:, 0]
                truth = _slab_truth(depth, albedo, asymmetry, sun, photons)
                relative.append(np.abs(light / truth.total - 1.0))
                noise = max(noise, float((truth.error / truth.total).max()))
    return _errors(np.concatenate(relative), 0.0, 0), noise


@lru_cache(maxsize=64)
def _slab_truth(depth: float, albedo: float, asymmetry: float, sun_deg: float, photons: int) -> SlabLight:
    return slab_light(depth, albedo, asymmetry, sun_deg, SLAB_ZENITH_DEG, SLAB_AZIMUTH_DEG, photons, SEED)


def _errors(relative: Floats, transmittance: float, bad: int) -> Errors:
    spread = float(np.median(relative)), float(np.percentile(relative, 95)), float(relative.max())
    return Errors(*spread, transmittance, bad, relative.size)


@lru_cache(maxsize=32)
def _truth(shells: Shells, count: int) -> tuple[Floats, Floats]:
    positions, ways, suns = _questions(shells, count)
    found = cloud_light(shells.radius_m, shells.layers, positions, ways, suns, shells.air, rtol=1e-5)
    return found.radiance, found.transmittance


def _questions(shells: Shells, count: int) -> tuple[Floats, Floats, Floats]:
    """Cameras on the ground, in, between and above the layers and far out; views of all kinds and about tangents."""
    rng = np.random.default_rng(SEED)
    edges = np.array([0.0, *(h for layer in shells.layers for h in (layer.base_m, layer.top_m))])
    top = edges.max()
    height = rng.choice(
        [0.0, *(0.5 * (edges[1:] + edges[:-1])), 1.2 * top, 0.05 * shells.radius_m, 6.0 * shells.radius_m], count
    )
    sphere = shells.radius_m + rng.choice(edges, count) + rng.uniform(-0.3, 0.5, count) * top
    tangent = 180.0 - np.degrees(np.arcsin(np.clip(sphere / (shells.radius_m + height), 0.0, 1.0)))
    inside = np.degrees(np.arccos(rng.uniform(-1.0, 1.0, count)))
    # From far out most rays at random miss: there views are spread over the disc.
    disc = np.degrees(np.arcsin(np.minimum((shells.radius_m + top) / (shells.radius_m + height), 1.0)))
    far = 180.0 - disc * np.sqrt(rng.random(count))
    at_random = np.where(height > 2.0 * top, far, inside)
    zenith = np.where(rng.random(count) < 0.4, tangent, at_random)
    sun = rng.choice([0.0, 30.0, 60.0, 80.0, 88.0, 90.0, 91.0], count)
    azimuth = rng.choice([0.0, 30.0, 90.0, 180.0], count)
    places = np.stack([0.0 * height, 0.0 * height, shells.radius_m + height], axis=1)
    return places, _ways(zenith, azimuth), _ways(sun, 0.0)


def _ways(zenith_deg: Floats | float, azimuth_deg: Floats | float) -> Floats:
    z, a = np.broadcast_arrays(np.radians(np.atleast_1d(zenith_deg)), np.radians(np.atleast_1d(azimuth_deg)))
    return np.stack([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)], axis=1)


def _layer(layer: Layer) -> dict[str, Any]:
    return {
        "base_m": layer.base_m, "top_m": layer.top_m, "extinction_per_m": layer.extinction_per_m,
        "albedo": layer.albedo, "asymmetry": layer.asymmetry, "density_model": "uniform",
        "height_profile": "parabola" if layer.parabola else "none", "coverage": 1.0,
    }  # fmt: skip
