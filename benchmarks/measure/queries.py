"""Questions to TerrainSampler and the slow, plain answers that they are held against: fine marches, dense grids."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ... import TerrainSampler
from ...engine.compiled import switched

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Rays:
    """N rays: origins in planet-centred metres, unit directions, how far they go."""

    name: str
    origins_m: Floats
    directions: Floats
    reach_m: float


def cpu_ms(call: Callable[[], None], runs: int = 3) -> float:
    """Least processor time of a call, which a busy machine changes little."""
    samples = []
    for _ in range(runs):
        start = time.process_time()
        call()
        samples.append(time.process_time() - start)
    return 1e3 * min(samples)


def numpy_cpu_ms(call: Callable[[], None], runs: int = 3) -> float:
    """The same without compiled loops (engine/compiled.py)."""
    with switched(False):
        return cpu_ms(call, runs)


def land(sampler: TerrainSampler, count: int, rng: np.random.Generator) -> Floats:
    """Unit directions (count, 3) with ground above height 0, evenly spread."""
    found = np.empty((0, 3))
    while len(found) < count:
        tries = rng.normal(size=(4 * count, 3))
        tries /= np.linalg.norm(tries, axis=1)[:, None]
        found = np.concatenate([found, tries[sampler.height(tries) > 0.0]])
    return found[:count]


def rays(
    sampler: TerrainSampler, name: str, above_m: float, pitch_deg: tuple[float, float], reach_m: float, count: int,
    rng: np.random.Generator,
) -> Rays:  # fmt: skip
    """Rays from `above_m` over land, in all azimuths, at pitches between two."""
    up = land(sampler, count, rng)
    side = np.cross(up, rng.normal(size=up.shape))
    side /= np.linalg.norm(side, axis=1)[:, None]
    pitch = np.radians(rng.uniform(*pitch_deg, count))[:, None]
    origins = up * (sampler.radius_m + sampler.height(up) + above_m)[:, None]
    return Rays(name, origins, side * np.cos(pitch) + up * np.sin(pitch), reach_m)


SETS = (
    ("2 m, level", 2.0, (0.0, 0.0), 1e4, 100.0),
    ("2 m, -5 to 5 degrees", 2.0, (-5.0, 5.0), 1e4, 100.0),
    ("100 m, -10 to 2 degrees", 100.0, (-10.0, 2.0), 1e4, 100.0),
    ("2 m, level", 2.0, (0.0, 0.0), 3e5, 1000.0),
    ("5 km, -4 to 0 degrees", 5e3, (-4.0, 0.0), 3e5, 1000.0),
    ("10 km, -4 degrees", 1e4, (-4.0, -4.0), 3e5, 1000.0),
)
"""name, height above ground, pitches, reach in m, target for 1000 rays in ms."""

SMALL_SETS = (
    ("0.2 m, level", 0.2, (0.0, 0.0), 1e3, 100.0),
    ("10 m, -10 to 2 degrees", 10.0, (-10.0, 2.0), 1e3, 100.0),
)
"""For a body of a kilometre."""


def earlier_ground(
    sampler: TerrainSampler, asked: Rays, hit: NDArray[np.bool_], distance_m: Floats, step_m: float
) -> tuple[Floats, int]:
    """How much farther than a march of even steps found ground each ray went (N,), m (0: no ground before its hit), and
    how many points were looked at. The march knows nothing of slopes: plain heights, `step_m` apart."""
    late, looked = np.zeros(len(hit)), 0
    for k, (origin, ray) in enumerate(zip(asked.origins_m, asked.directions, strict=True)):
        end = distance_m[k] if hit[k] else asked.reach_m
        t = np.arange(step_m, end, step_m)
        p = origin + t[:, None] * ray
        away = np.linalg.norm(p, axis=1)
        near = away < sampler.radius_m + sampler.highest_m
        t, p, away = t[near], p[near], away[near]
        looked += len(t)
        below = np.flatnonzero(away - sampler.radius_m < sampler.height(p)) if len(t) else []
        if len(below):
            late[k] = end - t[below[0]]
    return late, looked


def residual_m(sampler: TerrainSampler, asked: Rays, hit: NDArray[np.bool_], distance_m: Floats) -> float:
    """How far the ends of the rays that hit are from the ground, straight up or down: the worst."""
    if not hit.any():
        return 0.0
    ends = asked.origins_m[hit] + distance_m[hit, None] * asked.directions[hit]
    return float(np.abs(np.linalg.norm(ends, axis=1) - sampler.radius_m - sampler.height(ends)).max())


def nearest_m(sampler: TerrainSampler, centers_m: Floats, radius_m: float, points: int = 241) -> Floats:
    """Distances (N,) of the ground from centres, the nearest of a dense grid as wide as three radii below each."""
    x = np.linspace(-1.5, 1.5, points) * radius_m
    grid = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    found = []
    for center in centers_m:
        up = center / np.linalg.norm(center)
        a = np.cross(up, np.eye(3)[np.abs(up).argmin()])
        a /= np.linalg.norm(a)
        d = up + (grid[:, :1] * a + grid[:, 1:] * np.cross(up, a)) / sampler.radius_m
        d /= np.linalg.norm(d, axis=1)[:, None]
        ground = d * (sampler.radius_m + sampler.height(d))[:, None]
        found.append(np.linalg.norm(ground - center, axis=1).min())
    return np.array(found)
