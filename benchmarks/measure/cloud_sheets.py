"""Weather clouds lit as the sheets they are where they close the sky, against Monte-Carlo slabs.

Weather never makes an even sheet. So the march of pictures is asked with the light of weather clouds and, in place of
their density, one that is even: all the sky covered, no noise, no profile over the height.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ... import CloudProbe, Clouds, Planet, Scene, Sun
from ..reference.cloud_slab import SlabLight, slab_light

__all__ = ["SHEET_DEPTHS", "SHEET_SUNS", "SheetErrors", "sheet_errors", "sheet_light", "sheet_probe"]

Floats = NDArray[np.float64]
SHEET_DEPTHS = (0.5, 2.0, 8.0, 32.0)
SHEET_SUNS = (30.0, 60.0)
"""Zenith angles in degrees."""
_FLAT_M, _BASE_M = 1e8, 1000.0
_SHARE = 0.03
"""Of the layer's densest cloud: a layer that may be as deep as 5 is billows, and a thinner one ice."""
_UNUSED = {"clouds.shape_texels": 32, "clouds.fibre_texels": 64, "clouds.rim_texels": 16, "clouds.map_texels": 256}
"""Noise and weather that nobody looks at: as little of it as may be."""
_SEED = 2018
_ZENITH = np.array([180.0, 150.0, 120.0, 120.0, 60.0, 60.0, 30.0, 0.0])
_AZIMUTH = np.array([0.0, 0.0, 0.0, 180.0, 0.0, 180.0, 180.0, 0.0])
"""Looking down on it: 180 to 120; up through it: 60 to 0."""
_MADE = ("cloud_density", "cloud_noise", "cloud_gap", "cloud_rimmed", "cloud_weather", "cloud_column",
         "cloud_own_column")  # fmt: skip
_EVEN = f"""
CloudWeather cloud_weather(vec3 up, float footprint_m) {{ return CloudWeather(1.0, 1.0, 1.0, 1.0, 1.0); }}
float cloud_density(int layer, vec3 place, float share, CloudWeather w, float footprint_m, int rims) {{
    return {_SHARE};
}}
CloudNoise cloud_noise(int layer, vec3 place, float share, CloudWeather w, float footprint_m) {{
    CloudNoise n;
    return n;
}}
float cloud_gap(int layer, CloudNoise n, float footprint_m) {{ return 0.0; }}
float cloud_rimmed(int layer, CloudNoise n, float share, float footprint_m, int rims) {{ return {_SHARE}; }}
float cloud_column(int layer, CloudWeather w, float density) {{
    CloudViewLayer shell = cloud_view.layers[layer];
    return {_SHARE} * shell.extinction_per_m * (shell.top_m - shell.base_m);
}}
float cloud_own_column(int layer, CloudNoise n) {{ return cloud_column(layer, cloud_weather(vec3(0.0), 0.0), 1.0); }}
"""


@dataclass(frozen=True)
class SheetErrors:
    """Relative errors of all orders: of what a sheet throws back and of what comes through it, and the largest
    relative standard error of the reference."""

    back: Floats
    through: Floats
    noise: float


@contextmanager
def sheet_probe(depth: float, albedo: float, asymmetry: float, quality: str) -> Iterator[CloudProbe]:
    """A probe of an even sheet of weather cloud of that vertical optical depth, 1 km thick on a flat planet."""
    clouds = Clouds(
        base_m=_BASE_M, top_m=2.0 * _BASE_M, extinction_per_m=depth / (_SHARE * _BASE_M), albedo=albedo,
        asymmetry=asymmetry, coverage=1.0,
    )  # fmt: skip
    scene = Scene("sheet", {"planet": Planet(radius_m=_FLAT_M), "clouds": clouds})
    scene.sun = Sun(direction=(0.0, 0.0, 1.0), irradiance=(1.0, 1.0, 1.0))
    with CloudProbe(scene, quality=quality, overrides=_UNUSED) as probe:
        sources = probe._gpu.shaders.sources  # pyright: ignore[reportPrivateUsage]
        made = sources.read("clouds/density.glsl")
        assert made is not None
        renamed = "".join(f"#define {name} made_{name}\n" for name in _MADE)
        undone = "".join(f"#undef {name}\n" for name in _MADE)
        sources.add_virtual("clouds/density.glsl", f"{renamed}{made}\n{undone}{_EVEN}")
        yield probe


def sheet_light(probe: CloudProbe, sun_zenith_deg: float, zenith_deg: ArrayLike, azimuth_deg: ArrayLike) -> Floats:
    """(N,) radiance per irradiance of the sun, of directions of looking as in slab_light, over black ground."""
    zenith = np.asarray(zenith_deg, float)
    height = _FLAT_M + np.where(zenith > 90.0, 2.0 * _BASE_M + 1.0, _BASE_M - 1.0)
    place = np.stack([0.0 * height, 0.0 * height, height], axis=1)
    light, _ = probe.march(place, _ways(zenith, azimuth_deg), _ways(sun_zenith_deg, 0.0), ground_albedo=0.0)
    return light[:, 0]


def sheet_errors(depth: float, quality: str, photons: int) -> SheetErrors:
    """For droplets that scatter all around and ahead, under both suns."""
    found, noise = [], 0.0
    for albedo, asymmetry in ((1.0, 0.0), (1.0, 0.8), (0.999, 0.85)):
        with sheet_probe(depth, albedo, asymmetry, quality) as probe:
            for sun in SHEET_SUNS:
                light = sheet_light(probe, sun, _ZENITH, _AZIMUTH)
                truth = _truth(depth, albedo, asymmetry, sun, photons)
                found.append(np.abs(light / truth.total - 1.0))
                noise = max(noise, float((truth.error / truth.total).max()))
    errors = np.array(found)
    return SheetErrors(errors[:, _ZENITH > 90.0].ravel(), errors[:, _ZENITH < 90.0].ravel(), noise)


@lru_cache(maxsize=32)
def _truth(depth: float, albedo: float, asymmetry: float, sun_deg: float, photons: int) -> SlabLight:
    return slab_light(depth, albedo, asymmetry, sun_deg, _ZENITH, _AZIMUTH, photons, _SEED)


def _ways(zenith_deg: ArrayLike, azimuth_deg: ArrayLike) -> Floats:
    z, a = np.broadcast_arrays(np.radians(np.atleast_1d(zenith_deg)), np.radians(np.atleast_1d(azimuth_deg)))
    return np.stack([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)], axis=1)
