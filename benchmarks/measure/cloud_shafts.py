"""Errors of light shafts as pictures have them, against a float64 march through air whose sunlight clouds dim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from ... import Atmosphere, Camera, Clouds, Planet, Renderer, Scene, Sun
from ...systems.clouds.ours import OurClouds
from ...systems.light.sun import resolve_sun
from ..evaluate import Evaluator
from ..reference.air_medium import EARTH_BRUNETON, Floats
from ..reference.cloud_shafts import shadowed_air
from ..reference.cloud_shells import Layer, layer_depth
from .rays import pixel_rays

__all__ = [
    "SHEET", "UNIFORM", "WEATHER", "Shot", "converged", "scene_of", "shaft_errors", "sheet_clouds", "uniform_clouds",
    "weather_clouds",
]  # fmt: skip

RADIUS_M = EARTH_BRUNETON.radius_m
FLOOR = 1e-6
"""Radiance for a unit sun below which relative errors say nothing: a millionth of what the day's sky has."""
LEAST_LEFT = 0.05
"""Share of the light that has to be left: below, what has been scattered before outshines it many times."""


BROKEN_CUMULUS, BROKEN_SHEET = (-16.0, 30.0), (20.0, 10.0)
"""Latitude and longitude where the weather has gaps: under a closed sky there is hardly any light left to be right."""


@dataclass(frozen=True)
class Shot:
    """Where the camera stands and looks, and how high the sun is."""

    altitude_m: float
    pitch_deg: float
    sun_deg: float
    heading_deg: float = 120.0
    place: tuple[float, float] = BROKEN_CUMULUS


UNIFORM: Sequence[Shot] = tuple(
    Shot(altitude, pitch, sun)
    for sun in (60.0, 15.0, 3.0, 0.5)
    for altitude, pitch in ((10.0, 10.0), (10.0, 45.0), (800.0, -3.0), (5e3, -30.0), (1e5, -40.0))
)
WEATHER: Sequence[Shot] = tuple(
    Shot(altitude, pitch, sun, heading)
    for sun in (45.0, 15.0, 5.0)
    for altitude, pitch, heading in ((10.0, 10.0, 120.0), (300.0, 2.0, 150.0), (8e3, -25.0, 160.0))
)
SHEET: Sequence[Shot] = tuple(
    Shot(altitude, pitch, sun, heading, BROKEN_SHEET)
    for sun in (15.0, 5.0)
    for altitude, pitch, heading in ((10.0, 5.0, 150.0), (300.0, 1.0, 140.0), (10.0, 15.0, 165.0))
)
"""Towards the sun and a little beside it, from below."""
SUN_AZIMUTH_DEG = 150.0


def scene_of(clouds: Clouds) -> Scene:
    """A planet of nothing but air and clouds, under a sun of irradiance 1."""
    scene = Scene("shafts", {"planet": Planet(radius_m=RADIUS_M), "atmosphere": Atmosphere(), "clouds": clouds})
    scene.sun = Sun(direction=(0.0, 0.0, 1.0), irradiance=(1.0, 1.0, 1.0))
    return scene


def weather_clouds() -> Clouds:
    """Broken cumulus."""
    return Clouds(base_m=1200.0, top_m=3200.0, coverage=0.55)


def sheet_clouds() -> Clouds:
    """A flat sheet with gaps."""
    return Clouds(base_m=1500.0, top_m=2100.0, coverage=0.8)


def uniform_clouds() -> Clouds:
    """A black shell of depth 1."""
    return Clouds(
        base_m=1500.0, top_m=2500.0, extinction_per_m=1e-3, albedo=0.0, density_model="uniform", height_profile="none"
    )


def shaft_errors(clouds: Clouds, shots: Sequence[Shot], quality: str, size: tuple[int, int], **more: Any) -> Floats:
    """(N,) relative errors of the light that is left of the air's, of rays with any shadow. more: overrides."""
    scene = scene_of(clouds)
    overrides = {"clouds.stride": 1, "clouds.picture_px": 1, **more}  # a ray for each pixel
    found = []
    with Renderer(scene, size, quality, overrides) as renderer:
        for shot in shots:
            camera = Camera.at(
                *shot.place, shot.altitude_m, heading_deg=shot.heading_deg, pitch_deg=shot.pitch_deg, fov_y_deg=40.0
            )
            sun = Sun(
                elevation_deg=shot.sun_deg, azimuth_deg=SUN_AZIMUTH_DEG, latitude_deg=shot.place[0],
                longitude_deg=shot.place[1],
                irradiance=(1.0, 1.0, 1.0),
            )  # fmt: skip
            clouds.shafts = False
            renderer.render(camera, sun=sun)
            clear = _rays(renderer)
            clouds.shafts = True
            renderer.render(camera, sun=sun)
            taken = (clear - _rays(renderer))[..., :3].reshape(-1, 3)
            state = camera.resolve(scene, size[0] / size[1])
            direction = resolve_sun(sun, None).direction
            found.append(_errors(renderer, (state, direction), clouds, taken, size))
    return np.concatenate(found)


def _rays(renderer: Renderer) -> Floats:
    held = renderer.graph.resource("clouds.rays")
    with renderer.current():
        rows = np.frombuffer(held.read(), np.float32).reshape(held.size[1], held.size[0], 4)
    return rows.astype(np.float64)


def _errors(renderer: Renderer, shot: Any, clouds: Clouds, taken: Floats, size: tuple[int, int]) -> Floats:
    """Relative, per ray and wavelength."""
    camera, sun = shot
    ways = pixel_rays(camera, size)
    along = ways @ camera.position_m
    miss = np.linalg.norm(np.cross(camera.position_m, ways), axis=1)
    level = (miss - RADIUS_M) * (miss + RADIUS_M)
    top = clouds.top_m * (2.0 * RADIUS_M + clouds.top_m)
    # As far as the highest cloud, or the ground.
    lands = (level < 0.0) & (along < 0.0)
    end = np.where(lands, -np.sqrt(np.maximum(-level, 0.0)), np.sqrt(np.maximum(top - level, 0.0)))
    met = level < top
    ways, taken, length = ways[met], taken[met], (end - along)[met]
    points = camera.position_m + ways * length[:, None]
    suns = np.broadcast_to(sun, ways.shape)

    panels = _PANELS
    seen = _Sight(renderer, clouds, camera.position_m, ways, length, sun, panels)
    start = np.broadcast_to(camera.position_m, ways.shape)
    left = shadowed_air(EARTH_BRUNETON, start, points, suns, seen.lit, panels)
    lost = shadowed_air(EARTH_BRUNETON, start, points, suns, seen.open, panels) - left
    judged = (left > FLOOR) & (lost > 1e-3 * left) & (left > LEAST_LEFT * (left + lost))
    return (np.abs(taken - lost) / np.maximum(left, FLOOR))[judged]


class _Sight:
    """What clouds do to light on its way to places of rays, and from there to the camera."""

    def __init__(
        self, renderer: Renderer, clouds: Clouds, position_m: Floats, ways: Floats, length_m: Floats, sun: Floats,
        panels: int,
    ) -> None:  # fmt: skip
        self._renderer, self._clouds, self._position, self._ways = renderer, clouds, position_m, ways
        self._sun = sun
        self._share = (np.arange(4 * panels) + 0.5) / (4 * panels)
        self._length = length_m
        # Depth of clouds up to evenly many places of each ray.
        t = self._share * length_m[:, None]
        if clouds.density_model == "uniform":
            self._depth = self._shell(np.repeat(np.arange(len(ways)), t.shape[1]), t.ravel()).reshape(t.shape)
        else:
            found = converged(renderer, (ways[:, None] * t[..., None]).reshape(-1, 3), 0)[:, 1].reshape(t.shape)
            step = found * (length_m / t.shape[1])[:, None]
            self._depth = np.cumsum(step, axis=1) - 0.5 * step

    def lit(self, owner: Any, t: Floats) -> Floats:
        """Sunlight that is left, times what comes through to the camera."""
        return self._sunlight(owner, t) * self.open(owner, t)

    def open(self, owner: Any, t: Floats) -> Floats:
        """What comes through to the camera."""
        found = np.empty_like(t)
        for ray in np.unique(owner):
            of = owner == ray
            found[of] = np.interp(t[of], self._share * self._length[ray], self._depth[ray])
        return np.exp(-found)

    def _sunlight(self, owner: Any, t: Floats) -> Floats:
        if self._clouds.density_model != "uniform":
            return np.exp(-converged(self._renderer, self._ways[owner] * t[:, None], _SUN_STEPS)[:, 0])
        place = self._position + self._ways[owner] * t[:, None]
        return np.exp(-_shell_depth(self._clouds, place, self._sun, np.full(len(t), np.inf)))

    def _shell(self, owner: Any, t: Floats) -> Floats:
        return _shell_depth(self._clouds, self._position, self._ways[owner], t)


def _shell_depth(clouds: Clouds, places_m: Floats, ways: Floats, length_m: Floats) -> Floats:
    """(N,) of the uniform shell, in closed form."""
    layer = Layer(clouds.base_m, clouds.top_m, clouds.extinction_per_m)
    places, ways = np.broadcast_arrays(places_m, ways)
    if len(places) != len(length_m):
        places, ways = np.broadcast_to(places, (len(length_m), 3)), np.broadcast_to(ways, (len(length_m), 3))
    along = np.einsum("ij,ij->i", places, ways)
    miss = np.linalg.norm(np.cross(places, ways), axis=1)
    return layer_depth(RADIUS_M, [layer], (miss - RADIUS_M) * (miss + RADIUS_M), along, along + length_m)


def converged(renderer: Renderer, points_m: Floats, steps: int, wide_m: float = 1.0) -> Floats:
    """(N, 2) of camera-relative points (N, 3): the clouds' optical depth towards the sun in so many steps, and their
    extinction there per metre. Of the clouds that the renderer has drawn last, in full detail."""
    clouds = getattr(renderer.system("clouds"), "method", None)
    assert isinstance(clouds, OurClouds)
    gpu = renderer.gpu
    with renderer.current():
        ask = Evaluator(gpu, _BODY, {"point": "vec3", "steps": "int", "wide": "float"}, {"found": "vec2"}, _HEADER)
        found = []
        for first in range(0, len(points_m), _BLOCK):
            part = points_m[first : first + _BLOCK]
            even = {"steps": np.full(len(part), steps), "wide": np.full(len(part), wide_m)}
            found.append(ask(partial(clouds.bind_density, renderer.views[0]), point=part, **even)["found"])
        ask.release()
    return np.concatenate(found).astype(np.float64)


_PANELS, _SUN_STEPS, _BLOCK = 100, 64, 65536
_HEADER = """
#include "clouds/density.glsl"
#include "clouds/sun_ray.glsl"

float extinction_at(vec3 point, float wide) {
    float altitude = altitude_of(point), sum = 0.0;
    CloudWeather w = cloud_weather(up_at(point), wide);
    for (int layer = 0; layer < cloud_view.layer_count; ++layer) {
        CloudViewLayer shell = cloud_view.layers[layer];
        float share = (altitude - shell.base_m) * shell.per_thickness;
        if (share > 0.0 && share < 1.0)
            sum += shell.extinction_per_m * cloud_density(layer, point + frame.camera_offset_m, share, w, wide, 2);
    }
    return sum;
}
"""
_BODY = """
    vec3 sun = frame.sun_direction;
    float altitude = altitude_of(point), mu = dot(up_at(point), sun), r = planet.radius_m + altitude;
    // From the base, or from the point itself if it lies higher, to the top; of a sun below the horizon the whole way.
    float low = mu > 0.0 ? max(altitude, cloud_view.lowest_m) : altitude;
    float from = low > altitude ? distance_to_rise(r, mu, low - altitude) : 0.0;
    float top = cloud_view.highest_m - altitude, to = top > 0.0 ? max(distance_to_rise(r, mu, top), from) : from;
    float unit = (to - from) / float(max(steps, 1)), sum = 0.0;
    for (int k = 0; k < steps; ++k)
        sum += unit * extinction_at(point + sun * (from + (float(k) + 0.5) * unit), max(wide, 0.3 * unit));
    found = vec2(sum, extinction_at(point, wide));
"""
