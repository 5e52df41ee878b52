"""Relief of procedural land beside measured relief of the Earth."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Scene
from ...systems.terrain.height import relief_statistics
from ...systems.terrain.height_relief import EARTH_LAND_RELIEF_M, EARTH_LAND_UNRELATED_M

DISTANCES_M = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5)

MEASURED = EARTH_LAND_RELIEF_M
"""rms height difference of the Earth's land over each distance, metres."""
SOURCE = "joined: Tang et al. 2020 (slopes at 30 m), Gagnon et al. 2006 (exponent above), smooth below"
UNRELATED_M = EARTH_LAND_UNRELATED_M
UNRELATED_SOURCE = "Dutch (hypsometry)"


def roughness(scene: Scene, count: int) -> dict[float, float]:
    """rms height difference of land over each of DISTANCES_M, metres."""
    planet = scene.planet
    field = planet.height_field()
    assert field is not None
    found = relief_statistics(field, planet.radius_m, DISTANCES_M, count)
    return dict(zip(DISTANCES_M, (float(x) for x in found), strict=True))


def unrelated(scene: Scene, count: int, seed: int = 0) -> float:
    """rms height difference of points of land anywhere, metres: where roughness() must end at great distances."""
    field = scene.planet.height_field()
    assert field is not None
    v = np.random.default_rng(seed).normal(size=(count, 3))
    heights = field.height(v / np.linalg.norm(v, axis=1, keepdims=True))
    return float(np.sqrt(2.0) * heights[heights > 0.0].std())


@dataclass(frozen=True)
class Composition:
    """What a planet is made of, by area."""

    land_share: float
    highest_m: float
    lowest_m: float
    samples: int


def composition(scene: Scene, samples: int, seed: int = 0) -> Composition:
    """Share of land above the sea, highest peak and lowest seabed of evenly random directions; peaks are climbed."""
    field = scene.planet.height_field()
    assert field is not None
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(samples, 3))
    v /= np.linalg.norm(v, axis=1, keepdims=True)
    heights = field.height(v)
    order = np.argsort(heights)
    highest, lowest = _climb(field, v[order[-20:]], 1.0, rng), -_climb(field, v[order[:20]], -1.0, rng)
    return Composition(float((heights > 0.0).mean()), highest, lowest, samples)


def _climb(field: Any, starts: NDArray[np.float64], sign: float, rng: np.random.Generator) -> float:
    """The best of `sign` times the height near some starts, by random steps that shrink."""
    v, h = starts, sign * field.height(starts)
    step = 2e-3
    for _ in range(40):
        around = v + rng.normal(size=v.shape) * step
        around /= np.linalg.norm(around, axis=1, keepdims=True)
        found = sign * field.height(around)
        better = found > h
        v, h = np.where(better[:, None], around, v), np.where(better, found, h)
        step *= 0.85
    return float(h.max())
