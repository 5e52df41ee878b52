"""Thick air, in which light is scattered again and again: the preset hazy against paths followed one by one."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Atmosphere, AtmosphereProbe, Planet, load_scene
from ..reference import air as reference
from ..reference.air_medium import AirParameters
from .air import scene_of

__all__ = ["ThickError", "ThickTruth", "hazy_air", "thick_errors", "thick_truth"]

Floats = NDArray[np.float64]

ALTITUDES_M = (2.0, 1e4, 6e4)
SUN_ZENITHS_DEG = (30.0, 60.0, 80.0)
PITCHES_DEG = (-30.0, -5.0, 3.0, 20.0, 90.0)
AZIMUTHS_DEG = (60.0, 150.0)
"""From the sun."""


@dataclass(frozen=True)
class ThickTruth:
    """Questions, and the answers of Monte-Carlo with their standard errors."""

    positions_m: Floats
    directions: Floats
    sun_directions: Floats
    radiance: Floats
    noise: Floats
    ground_m: Floats
    ground_suns: Floats
    irradiance: Floats
    irradiance_noise: Floats


@dataclass(frozen=True)
class ThickError:
    """How far the light of all questions of a kind, added up, is from that of the paths: |sum / true sum - 1|."""

    worst_color: float
    all_colors: float
    """Of all three colours together."""
    noise: float
    """Of the paths: the worst colour's standard error."""


def hazy_air() -> AirParameters:
    """The air of the preset hazy, in the reference's words."""
    scene = load_scene("hazy")
    component: Any = scene.planet[Atmosphere]
    values: dict[str, Any] = {"radius_m": scene.planet[Planet].radius_m}
    values["sun_angular_radius_rad"] = scene.sun.angular_radius_rad
    for field in dataclasses.fields(AirParameters):
        if field.name not in values:
            values[field.name] = getattr(component, field.name)
    return AirParameters(**values)


@lru_cache(maxsize=4)
def thick_truth(paths: int = 4096) -> ThickTruth:
    """90 views and the light on the ground under three suns; a tenth of a second for each at 4096 paths."""
    air = hazy_air()
    asked = [
        (h, np.radians(z), np.radians(p), np.radians(a))
        for h in ALTITUDES_M
        for z in SUN_ZENITHS_DEG
        for p in PITCHES_DEG
        for a in AZIMUTHS_DEG
    ]
    h, zenith, pitch, azimuth = np.array(asked).T
    up = np.array([0.0, 0.0, 1.0])
    positions = (air.radius_m + h)[:, None] * up
    directions = np.stack([np.cos(pitch) * np.cos(azimuth), np.cos(pitch) * np.sin(azimuth), np.sin(pitch)], axis=-1)
    suns = np.stack([np.sin(zenith), np.zeros_like(zenith), np.cos(zenith)], axis=-1)
    light = reference.sky_radiance(air, positions, directions, suns, paths=paths, seed=7)
    zenith = np.radians(SUN_ZENITHS_DEG)
    ground_suns = np.stack([np.sin(zenith), np.zeros_like(zenith), np.cos(zenith)], axis=-1)
    ground = np.tile(air.radius_m * up, (len(zenith), 1))
    below = reference.irradiance(air, ground, up[None], ground_suns, paths=paths, seed=8)
    return ThickTruth(
        positions, directions, suns, light.radiance, light.standard_error, ground, ground_suns, below.sky,
        below.sky_standard_error,
    )  # fmt: skip


def thick_errors(truth: ThickTruth, quality: str) -> dict[str, ThickError]:
    """What a quality answers, by altitude, and the light of the sky on level ground."""
    with AtmosphereProbe(scene_of(hazy_air()), quality=quality) as probe:
        light = probe.sky_radiance(truth.positions_m, truth.directions, truth.sun_directions)
        sky = probe.irradiance(truth.ground_m, [[0.0, 0.0, 1.0]], truth.ground_suns)[1]
    height = np.linalg.norm(truth.positions_m, axis=1) - np.linalg.norm(truth.ground_m[0])
    found = {"light on level ground": _error(sky, truth.irradiance, truth.irradiance_noise)}
    for altitude in ALTITUDES_M:
        rows = np.abs(height - altitude) < 1.0
        name = f"air from {altitude:g} m"
        found[name] = _error(light[rows], truth.radiance[rows], truth.noise[rows])
    return found


def _error(found: Floats, true: Floats, noise: Floats) -> ThickError:
    total = true.sum(axis=0)
    apart = np.abs(found.sum(axis=0) / total - 1.0)
    return ThickError(
        float(apart.max()),
        float(abs(found.sum() / total.sum() - 1.0)),
        float((np.sqrt((noise**2).sum(axis=0)) / total).max()),
    )
