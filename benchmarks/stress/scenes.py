"""Random scenes and cameras for stress cases, as JSON values and as objects."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from ... import Atmosphere, Camera, Clouds, Composite, Exposure, Ocean, Planet, Scene, Stars, Sun, Terrain
from .draw import ALTITUDES_M, camera, log_uniform, unit
from .runner import Case

_KINDS: dict[str, type] = {
    "planet": Planet, "terrain": Terrain, "ocean": Ocean, "sun": Sun, "stars": Stars, "exposure": Exposure,
    "composite": Composite, "atmosphere": Atmosphere, "clouds": Clouds,
}  # fmt: skip


def draw_planet(rng: np.random.Generator, radii_m: tuple[float, float] = (1e3, 7e7)) -> Case:
    """Tables of components: a planet with ground, often with a sea, knobs anywhere in their ranges."""
    radius = log_uniform(rng, *radii_m)
    # As high as relief gets on bodies of that size: a tenth of the radius on asteroids, 9 km on Earth.
    highest = min(0.1 * radius, 2e4) * float(10.0 ** rng.uniform(-2.0, 0.0))
    terrain: Case = {
        "seed": int(rng.integers(2**31)),
        "highest_m": highest,
        "lowest_m": -highest * float(rng.uniform(0.0, 1.0)),
        "layers": int(rng.choice([1, 4, 10, 16])),
        "land_share": float(rng.uniform(0.05, 0.95)),
        "continent_size": float(rng.choice([0.125, 0.5, 1.0, 2.0, 4.0])),
        "plains": float(rng.choice([0.0, 0.5, 1.0])),
        "mountains": float(rng.choice([0.0, 1.0, 2.0])),
        "roughness": float(rng.choice([0.0, 0.5, 1.0, 2.0])),
        "warp": float(rng.choice([0.0, 1.0, 2.0])),
    }
    scene: Case = {"planet": {"radius_m": radius}, "terrain": terrain}
    if rng.random() < 0.5:
        scene["ocean"] = {"sea_level_m": float(rng.choice([0.0, 0.3 * highest, terrain["lowest_m"], 1.1 * highest]))}
    return scene


def draw_light(rng: np.random.Generator) -> Case:
    """A sun anywhere, also exactly overhead or at the horizon; the ways to expose and to map tones."""
    sun: Case = {"direction": unit(rng), "angular_radius_rad": float(rng.choice([1e-4, 0.004675, 0.05]))}
    tables: Case = {"sun": sun, "composite": {"bloom": float(rng.choice([0.0, 0.3]))}}
    tables["exposure"] = {"mode": str(rng.choice(["auto", "fixed"])), "ev100": float(rng.uniform(-5.0, 20.0))}
    if rng.random() < 0.5:
        tables["stars"] = {"seed": int(rng.integers(1000))}
    return tables


COMMON_FOVS_DEG = (10.0, 30.0, 60.0, 60.0, 100.0, 130.0)
TELE_SHARE = 0.03
"""Of the cameras see through a telescope: much is selected for them, so they take long."""


def draw_camera(rng: np.random.Generator, tele: bool = True) -> Case:
    """A camera from 1 cm to 1e9 m over ground or sea; "clearance_m" is its height above them."""
    clearance = log_uniform(rng, *ALTITUDES_M)
    fovs = (0.01, 1.0) if tele and rng.random() < TELE_SHARE else COMMON_FOVS_DEG
    drawn = camera(rng, 1.0, 0.0, fovs)
    position = drawn.pop("position_m")
    return {"zenith": position, "clearance_m": clearance, **drawn}


def build_scene(tables: Case) -> Scene:
    """A Scene of these tables."""
    components: dict[str, Any] = {}
    for name, values in tables.items():
        kind = _KINDS[name]
        known = {field.name for field in dataclasses.fields(kind)}
        given = {key: tuple(v) if isinstance(v, list) else v for key, v in values.items() if key in known}
        components[name] = kind(**given)
    return Scene("stress", components)


def build_camera(scene: Scene, case: Case) -> Camera:
    """The camera of a case: its clearance counts from the higher of ground and sea."""
    zenith = np.array(case["zenith"])
    zenith = zenith / np.linalg.norm(zenith)
    surface = float(scene.planet.surface_height_m(zenith[None])[0])
    position = zenith * (scene.planet.radius_m + surface + case["clearance_m"])
    optics = {key: case[key] for key in ("fov_y_deg", "frustum_deg") if key in case}
    return Camera(position, case["forward"], case["up"], **optics)
