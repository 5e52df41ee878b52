"""How light a forest is: as trees that stand as solids, as crowns in the ground's light, and as a colour alone, over
pairs of a sun and a view; and on a way up, where one takes over from another."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Clouds, Renderer, Scene, Sun, TerrainSampler, latitude_longitude, load_scene, view

__all__ = ["CROWNS", "FLAT", "PAIRS", "PLACES", "SOLIDS", "Pair", "forest", "mean_light", "target_m", "up_light"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Pair:
    """Where eye and sun stand, as seen from the forest. Degrees."""

    eye: float
    """elevation"""
    sun: float
    between: float
    """difference of azimuths; 0: the sun is behind the eye"""


PAIRS = tuple(
    Pair(eye, sun, between)
    for eye, between in ((90.0, 0.0), (60.0, 120.0), (35.0, 0.0), (20.0, 60.0), (20.0, 180.0))
    for sun in (60.0, 35.0, 20.0, 12.0)
)
PLACES = {"closed, of broadleaves": "canopy", "open": "near", "of conifers": "treeline"}
"""By what they are: a view that stands 200 m from the place."""
SOLIDS: Mapping[str, Any] = {"cover.reach_m": 900.0}
CROWNS: Mapping[str, Any] = {"cover.reach_m": 20.0}
FLAT: Mapping[str, Any] = {"cover.reach_m": 20.0, "cover.crowns": 0}
_PX = 96
_AWAY_M = 400.0
_AZIMUTH_DEG = 120.0
_CROWN_M = 8.0


def forest() -> Scene:
    """Earth with trees, without clouds."""
    scene = load_scene("woods")
    scene.planet.remove(Clouds)
    return scene


def target_m(scene: Scene, name: str) -> Floats:
    """Planet-centred place (3,) among the crowns ahead of a view."""
    camera = view(name, scene.planet).camera.resolve(scene)
    eye, ahead = np.asarray(camera.position_m), np.asarray(camera.forward)
    up = eye / np.linalg.norm(eye)
    level = ahead - (ahead @ up) * up
    place = eye + 200.0 * level / np.linalg.norm(level)
    place /= np.linalg.norm(place)
    return place * (scene.planet.radius_m + float(TerrainSampler(scene).height(place[None])[0]) + _CROWN_M)


def _towards(place_m: Floats, elevation_deg: float, azimuth_deg: float) -> tuple[Floats, Floats]:
    """Unit vectors from a place: to what stands there in its sky, and to its north."""
    up = place_m / np.linalg.norm(place_m)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    e, a = np.radians((elevation_deg, azimuth_deg))
    return np.cos(e) * (np.cos(a) * north + np.sin(a) * east) + np.sin(e) * up, north


def _camera(place_m: Floats, elevation_deg: float, azimuth_deg: float, away_m: float, wide_m: float) -> Camera:
    """Looks at wide_m of a place."""
    to, north = _towards(place_m, elevation_deg, azimuth_deg)
    up = north if elevation_deg > 89.0 else place_m / np.linalg.norm(place_m)
    return Camera(place_m + away_m * to, -to, up, fov_y_deg=float(np.degrees(2.0 * np.arctan(0.5 * wide_m / away_m))))


def _sun(place_m: Floats, elevation_deg: float) -> Sun:
    latitude, longitude = (float(v) for v in latitude_longitude(place_m))
    return Sun(elevation_deg=elevation_deg, azimuth_deg=_AZIMUTH_DEG, latitude_deg=latitude, longitude_deg=longitude)


def mean_light(
    scene: Scene, name: str, overrides: Mapping[str, Any], pairs: tuple[Pair, ...] = PAIRS, quality: str = "medium"
) -> Floats:
    """Mean radiance (N, 3) of 100 m of the forest ahead of a view, for each pair."""
    place, found = target_m(scene, name), np.zeros((len(pairs), 3))
    with Renderer(scene, (_PX, _PX), quality, dict(overrides)) as renderer:
        for eye, between in dict.fromkeys((p.eye, p.between) for p in pairs):
            camera = _camera(place, eye, _AZIMUTH_DEG + between, _AWAY_M, 100.0)
            renderer.settle(camera)
            for k, pair in enumerate(pairs):
                if (pair.eye, pair.between) == (eye, between):
                    sun = _sun(place, pair.sun)
                    renderer.render(camera, sun=sun)  # the map of shadows follows the sun by a frame
                    found[k] = renderer.render(camera, sun=sun, outputs=("radiance",))["radiance"].mean(axis=(0, 1))
    return found


def up_light(
    scene: Scene, name: str, away_m: Floats, overrides: Mapping[str, Any] | None = None, quality: str = "medium"
) -> Floats:
    """Mean radiance (N, 3) of 200 m of a forest from so far above it (N,), the camera going up: a picture at each
    height without air."""
    place, found = target_m(scene, name), []
    with Renderer(scene, (_PX, _PX), quality, dict(overrides or {})) as renderer:
        for away in away_m:
            camera = _camera(place, 60.0, _AZIMUTH_DEG + 60.0, float(away), min(200.0, float(away)))
            renderer.settle(camera)
            sun = _sun(place, 40.0)
            renderer.render(camera, sun=sun)
            found.append(renderer.render(camera, sun=sun, outputs=("radiance",))["radiance"].mean(axis=(0, 1)))
    return np.array(found)
