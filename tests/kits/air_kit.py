"""Small planets of nothing but air, the coarsest tables, and what the tests of the air ask of a renderer."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

import planetfall as pf
from planetfall.benchmarks.stress.atmosphere import SMALL_TABLES as TINY
from planetfall.components import Atmosphere, Ocean, Planet
from planetfall.systems.atmosphere.job import TableJob
from planetfall.systems.atmosphere.system import AtmosphereSystem

SIZE = (32, 18)
HAZY = (4e-5, 4e-5, 4e-5)
"""Haze ten times as thick as the default: its scattering and extinction, per metre."""
SUN = pf.Sun(direction=(0.6, 0.0, 0.8))


def bare(atmosphere: Atmosphere | None = None, radius_m: float = 6.36e6, sea_m: float | None = None) -> pf.Scene:
    """A planet without ground: a frame takes 2 ms and a start 0.3 s. sea_m: with a calm sea at this height, 20 ms."""
    calm = {"wind_speed_m_s": 0.0, "swell_height_m": 0.0, "foam": 0.0, "surf_m": 0.0, "roughness": 0.2}
    calm |= {"caustics": 0.0, "bed_detail": 0.0}  # its bed is its surface
    sea = {} if sea_m is None else {"ocean": Ocean(sea_level_m=sea_m, **calm)}
    scene = pf.Scene("bare", {"planet": Planet(radius_m=radius_m), "atmosphere": atmosphere or Atmosphere(), **sea})
    scene.sun = pf.Sun(direction=SUN.direction)
    return scene


def renderer_of(scene: pf.Scene, **changes: Any) -> pf.Renderer:
    """Quality low with the coarsest tables, light at the wavelengths of the components' numbers; changes: of the
    constructor, or overrides without "atmosphere."."""
    given = {key: changes.pop(key) for key in ("size", "ctx", "guard", "quality") if key in changes}
    overrides = {"light.wavelengths": "given", **TINY, **{f"atmosphere.{key}": value for key, value in changes.items()}}
    return pf.Renderer(scene, **{"size": SIZE, "quality": "low", **given}, overrides=overrides)


def at(altitude_m: float, pitch_deg: float = 0.0, heading_deg: float = 30.0, **more: Any) -> pf.Camera:
    return pf.Camera.at(
        more.pop("latitude_deg", 20.0), more.pop("longitude_deg", 10.0), altitude_m, heading_deg=heading_deg,
        pitch_deg=pitch_deg, **more,
    )  # fmt: skip


def radiance(renderer: pf.Renderer, camera: pf.Camera, **more: Any) -> NDArray[np.float64]:
    """(h, w, 3), checked: finite and not negative."""
    found = renderer.render(camera, outputs=("radiance",), **more)["radiance"].astype(np.float64)
    assert np.isfinite(found).all()
    assert (found >= 0.0).all()
    return found


def settled(renderer: pf.Renderer, camera: pf.Camera) -> NDArray[np.float64]:
    renderer.settle(camera)
    return radiance(renderer, camera)


def ran(renderer: pf.Renderer) -> set[str]:
    """Names of the passes of the last frame that ran."""
    return {report.name for report in renderer.passes() if report.ran}


def air_of(renderer: pf.Renderer) -> AtmosphereSystem:
    found = renderer.system("atmosphere")
    assert isinstance(found, AtmosphereSystem)
    return found


def job_of(renderer: pf.Renderer) -> TableJob:
    return air_of(renderer).method.job


def dispatches(renderer: pf.Renderer, act: Callable[[], Any]) -> int:
    """How many compute dispatches there were meanwhile."""
    before = renderer.gpu.work.dispatches
    act()
    return renderer.gpu.work.dispatches - before
