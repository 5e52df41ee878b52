"""Weather clouds in pictures: how each quality differs from `reference`, what that is worth, its cost."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Atmosphere, Camera, CloudLayer, CloudProbe, Clouds, Exposure, Planet, Renderer, Scene, Sun
from ...engine.wavelengths import GIVEN_NM
from ...quality import resolve_quality
from ...systems.composite.photometry import expose
from ...systems.light.sun import resolve_sun
from ..reference.air_medium import EARTH_BRUNETON
from .flip import flip
from .rays import pixel_rays

__all__ = [
    "CAMERAS", "CLOUD_PASSES", "HALF_STEP", "HALVED", "Converged", "camera_at", "converged", "errors_of", "halved",
    "pictures", "scene_of_weather",
]  # fmt: skip

CLOUD_PASSES = (
    "clouds.classify", "clouds.march", "clouds.shafts", "clouds.between", "clouds.resolve", "clouds.composite",
    "atmosphere.view", "sky.shade",
)  # fmt: skip
"""What draws clouds and air; maps of weather, shadow and sky are drawn now and then."""
CAMERAS: Mapping[str, tuple[float, float]] = {
    "ground": (100.0, 5.0),
    "inside": (2500.0, 3.0),
    "10 km": (1e4, -5.0),
    "400 km": (4e5, -40.0),
    "2000 km": (2e6, -62.0),
    "36 000 km": (36e6, -90.0),
}
"""Altitude and pitch."""
HALVED = {
    "clouds.fine_steps": 2.0, "clouds.step_growth": 0.5, "clouds.sun_steps": 2.0, "clouds.shaft_steps": 2.0,
    "clouds.air_steps": 2.0,
}  # fmt: skip
"""Factors on the reference's knobs that halve all its steps."""
_PLACE = (48.0, -30.0)
"""Latitude and longitude of clouds with gaps, from below and above, with a sun 70 degrees high."""
_EV100 = 14.0
_ALIKE: Mapping[str, Any] = {
    "composite.antialiasing": "none", "clouds.shadow_texels": 256, "clouds.shadow_steps": 8, "clouds.map_texels": 1024,
}  # fmt: skip
"""What would differ between qualities without being of the march, with the air's tables; shafts have rows of their
own. Weather of another map is other weather."""


def scene_of_weather() -> Scene:
    """A planet of nothing but air and two layers of cloud, under a high sun and a fixed exposure."""
    clouds = Clouds(base_m=1200.0, top_m=4200.0, coverage=0.55)
    clouds.layers = (CloudLayer(base_m=8500.0, top_m=10500.0, extinction_per_m=6e-4, coverage=0.4),)
    planet = Planet(radius_m=EARTH_BRUNETON.radius_m)
    scene = Scene("weather", {"planet": planet, "atmosphere": Atmosphere(), "clouds": clouds})
    scene.sun = Sun(direction=(0.6, 0.0, 0.8))
    exposure = scene.environment[Exposure]
    exposure.mode, exposure.ev100 = "fixed", _EV100
    return scene


def camera_at(name: str, moved: float = 0.0) -> Camera:
    """One of CAMERAS, higher by that share of its altitude and turned a little."""
    altitude_m, pitch_deg = CAMERAS[name]
    return Camera.at(*_PLACE, altitude_m * (1.0 + moved), heading_deg=30.0 + 500.0 * moved, pitch_deg=pitch_deg)


def pictures(
    quality: str, names: Sequence[str], size: tuple[int, int], overrides: Mapping[str, Any] | None = None
) -> dict[str, NDArray[np.uint8]]:
    """(H, W, 3) u8 by camera, as they have settled, all in the air of `high`. The reference is one ray a pixel with
    short steps, and needs no settling."""
    renderer = Renderer(scene_of_weather(), size, quality, {**_air(), **_ALIKE, **(overrides or {})})
    try:
        found = {}
        for name in names:
            camera = camera_at(name)
            if quality != "reference":
                renderer.settle(camera)
            found[name] = np.asarray(renderer.render(camera)["color"])
        return found
    finally:
        renderer.release()


def _air() -> dict[str, Any]:
    """The air's tables of `high`, for all."""
    return {key: value for key, value in resolve_quality("high").items() if key.startswith("atmosphere.")}


def halved(quality: str = "reference") -> dict[str, Any]:
    """Overrides with which a quality's steps are half as long."""
    settings = resolve_quality(quality)
    return {key: type(settings[key])(settings[key] * factor) for key, factor in HALVED.items()}


@dataclass(frozen=True)
class Converged:
    """What halving all steps changes along rays: relative errors of the light of clouds and air and of what droplets
    scatter once (medians and 95th percentiles), and of transmittance (absolute: 95th percentile)."""

    light: tuple[float, float]
    once: tuple[float, float]
    transmittance: float


HALF_STEP = 0.5 / 255.0
"""Of 8 bits. Transmittance that is no farther off moves not even white by a step."""
_SHOWN = HALF_STEP / 12.92
"""Of white, linear: half the darkest step that sRGB has in 8 bits. What is exposed to less is black in the picture."""


def converged(
    names: Sequence[str], rays: tuple[int, int], rows: int, quality: str = "reference"
) -> dict[str, Converged]:  # fmt: skip
    """By camera, of pixels' rays: so many columns and rows of them, as wide as a pixel of a picture of `rows` rows."""
    scene = scene_of_weather()
    sun = np.asarray(resolve_sun(scene.sun, None).direction)
    cameras = {name: camera_at(name).resolve(scene, rays[0] / rays[1]) for name in names}
    found: dict[str, list[tuple[NDArray[np.float64], ...]]] = {name: [] for name in names}
    for steps in ({}, halved(quality)):
        with CloudProbe(scene, quality=quality, overrides={**_air(), **_ALIKE, **steps}) as probe:
            for name, state in cameras.items():
                ways, pixel_rad = pixel_rays(state, rays), state.pixel_rad(rows)
                light, through = probe.march(state.position_m, ways, sun, pixel_rad=pixel_rad)
                once, _ = probe.march(state.position_m, ways, sun, pixel_rad=pixel_rad, orders=1, air=False)
                found[name].append((light, once, through))
    return {name: _converged(*both) for name, both in found.items()}


def _converged(found: tuple[NDArray[np.float64], ...], finer: tuple[NDArray[np.float64], ...]) -> Converged:
    off = float(np.percentile(np.abs(found[2] - finer[2]), 95))
    return Converged(_relative(found[0], finer[0]), _relative(found[1], finer[1]), off)


def _relative(found: NDArray[np.float64], truth: NDArray[np.float64]) -> tuple[float, float]:
    lit = (expose(truth, _EV100, GIVEN_NM) >= _SHOWN).all(1)
    error = np.abs(found - truth)[lit] / truth[lit]
    return (float(np.median(error)), float(np.percentile(error, 95))) if lit.any() else (0.0, 0.0)


def errors_of(truth: NDArray[np.uint8], found: NDArray[np.uint8]) -> tuple[float, float]:
    """(mean, 99th percentile) of FLIP over the picture."""
    error = flip(truth, found)
    return float(error.mean()), float(np.percentile(error, 99))
