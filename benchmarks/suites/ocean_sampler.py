"""Bench ocean.sampler: what boats ask of the sea on the CPU, its time and how right it is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Ocean, OceanSampler, Planet, TerrainSampler
from ..reference.waves import displaced
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_most
from ..timing import time_variants

SEED = 20260402
Floats = NDArray[np.float64]


def ocean_sampler(session: Session) -> None:
    """Heights and normals of earth's sea, bed included; heights against displaced points in extended precision."""
    rng = np.random.default_rng(SEED)
    scene = preset_scene("earth")
    ocean = scene.planet[Ocean]
    ground = TerrainSampler(scene)
    open_sea, shore = _water(ground, 1000, -1e9, -500.0, rng), _water(ground, 200, -30.0, -0.5, rng)
    for waves in (20, 100, 1000):
        ocean.wave_count = waves
        sampler = OceanSampler(scene)
        runs = session.runs(40, 10) if waves < 1000 else session.runs(5, 2)
        timing = time_variants({"": lambda s=sampler: s.height(open_sea, 12.3)}, runs, 2)[""]
        promised = {"target": at_most(8.0, "ms"), "target_on": "ms"} if waves == 20 else {}
        session.row(f"1000 heights, {waves} waves", timing=timing, **promised)
        _residual_row(session, ocean, waves, rng)
    ocean.wave_count = 20
    sampler = OceanSampler(scene)
    for name, ask in (
        ("1000 heights, every point at a time of its own", lambda: sampler.height(open_sea, np.arange(1000.0))),
        ("1000 normals", lambda: sampler.normal(open_sea, 12.3)),
        ("200 heights, 0.5 to 30 m deep", lambda: sampler.height(shore, 12.3)),
        ("200 normals, 0.5 to 30 m deep", lambda: sampler.normal(shore, 12.3)),
        ("50 heights: a boat", lambda: sampler.height(open_sea[:50], 12.3)),
    ):
        session.row(f"{name}, 20 waves", timing=time_variants({"": ask}, session.runs(40, 10), 2)[""])
    # In shallow water the point that displacement() moves to a place is to be found there.
    place = shore * (sampler.radius_m + sampler.sea_level_m) + sampler.displacement(shore, 12.3)
    off = sampler.height(place, 12.3) - (np.linalg.norm(place, axis=1) - sampler.radius_m)
    session.row("heights, 0.5 to 30 m deep", error=1e3 * float(np.abs(off).max()), error_unit="mm",
                target=at_most(1.0, "mm"), points=len(shore))  # fmt: skip


def _residual_row(session: Session, ocean: Ocean, waves: int, rng: np.random.Generator) -> None:
    """Points of a bottomless sea without ice, displaced in extended precision: the height found where they are now."""
    worst, points = 0.0, session.runs(500, 100)
    ocean = replace(ocean, ice_latitude_deg=90.0)
    for radius, time_s in ((6e4, 0.0), (6.371e6, 1e5), (6.371e6, 1e8), (7e7, 1e8)):
        bare: Any = SimpleNamespace(planet={Planet: Planet(radius_m=radius), Ocean: ocean})
        sampler = OceanSampler(bare)
        w = sampler.waves
        calm = rng.normal(size=(20 * points, 3))
        calm /= np.linalg.norm(calm, axis=1)[:, None]
        away = np.arccos(np.clip(np.abs(calm @ w.origins.T), 0.0, 1.0))
        calm = calm[(away > w.fade_rad[:, 1]).all(axis=1)][:points]
        if not len(calm):
            continue
        there = displaced(
            calm, w.origins, w.amplitude_m, w.wavelength_m, w.steepness, w.speed_rad_s, w.radius_m, time_s
        )
        distance = np.sqrt((there * there).sum(axis=1))
        found = sampler.height(np.asarray(there / distance[:, None], dtype=np.float64), time_s)
        worst = max(worst, float(np.abs(found - (distance - np.longdouble(radius))).max()))
    session.row(f"heights at displaced points, {waves} waves", error=1e3 * worst, error_unit="mm",
                target=at_most(1.0, "mm"), points=points)  # fmt: skip


def _water(ground: TerrainSampler, count: int, low_m: float, high_m: float, rng: np.random.Generator) -> Floats:
    """Unit directions (count, 3) with ground between two heights."""
    found = np.empty((0, 3))
    while len(found) < count:
        tries = rng.normal(size=(8 * count, 3))
        tries /= np.linalg.norm(tries, axis=1)[:, None]
        height = ground.height(tries)
        found = np.concatenate([found, tries[(height > low_m) & (height < high_m)]])
    return found[:count]


SAMPLER_BENCHES: Mapping[str, Bench] = {"sampler": ocean_sampler}
