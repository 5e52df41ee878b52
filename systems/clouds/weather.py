"""Weather of a planet: which maps a moment needs, where its cyclones are, and the balance that keeps the mean cover."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import Vec3, array

__all__ = [
    "CYCLONES",
    "Cyclone",
    "Generation",
    "Moment",
    "WeatherBlock",
    "balance_for",
    "cyclones_at",
    "generations_at",
    "moment_of",
    "octahedral_weights",
]

CYCLONES = 28
"""Of the middle latitudes, and the last ones tropical storms."""
_TROPICAL = 5
STEP_S = 900.0
"""From one map to the next; what is shown is mixed from both. A front at 15 m/s moves by one texel of a large map."""
_LIFE_S = 5.0 * 86400.0
"""Of a generation of noise."""


@dataclass(frozen=True)
class Moment:
    """Two maps, by number, and the share of the second in what is shown."""

    first: int
    share: float

    @property
    def maps(self) -> tuple[int, int]:
        return self.first, self.first + 1


def moment_of(time_s: float) -> Moment:
    """What a time asks for; in float64, so that it is right to a microsecond after three years."""
    steps = time_s / STEP_S
    first = math.floor(steps)
    return Moment(first, steps - first)


@dataclass
class Generation:
    """Of the weather's noise."""

    seed: int
    age: Annotated[float, "of its life, -0.5 to 0.5"]
    weight: float


@dataclass
class Cyclone:
    """One that winds the weather up, or has come to its end (strength 0)."""

    direction: Annotated[Vec3, "unit, of its middle"]
    size: Annotated[float, "a chord of the unit sphere"]
    winding: Annotated[float, "its sense, 1 or -1"]
    strength: Annotated[float, "0..1"]
    phase: Annotated[float, "of its spiral, rad"]


@dataclass
class WeatherBlock:
    """A moment's, as clouds/weather.comp reads it: instance ``weather``."""

    generations: Annotated[Any, array(Generation, 2)]
    cyclones: Annotated[Any, array(Cyclone, CYCLONES)]

    @classmethod
    def at(cls, time_s: float, seed: int) -> WeatherBlock:
        return cls(generations_at(time_s, seed), cyclones_at(time_s, seed))


def generations_at(time_s: float, seed: int = 0) -> list[Generation]:
    """The two of a moment; the squares of their weights add up to one."""
    found = []
    for j in range(2):
        lives = time_s / _LIFE_S + 0.5 * j
        number = math.floor(lives)
        age = lives - number - 0.5
        found.append(Generation(64 * ((2 * number + j + 977 * seed) % 8192), age, math.cos(math.pi * age)))
    norm = math.hypot(*(one.weight for one in found))
    return [replace(one, weight=one.weight / norm) for one in found]


def _hash(*numbers: int) -> np.random.Generator:
    return np.random.default_rng([n % (1 << 32) for n in numbers])


@lru_cache(maxsize=4)
def cyclones_at(time_s: float, seed: int) -> tuple[Cyclone, ...]:
    """All CYCLONES of a moment.

    Each lives for some days, grows, drifts (in the middle latitudes to the east and the pole) and dies; then the next.
    """
    found = []
    for i in range(CYCLONES):
        tropical = i >= CYCLONES - _TROPICAL
        own = _hash(seed, i)
        life_s = own.uniform(4.0, 8.0) * 86400.0
        lives = time_s / life_s + own.uniform()
        number = math.floor(lives)
        share = lives - number
        fate = _hash(seed, i, number)
        side = 1.0 if (i % 2 == 0) else -1.0
        # Spread along the storm tracks, so that few overlap.
        slot = 2.0 * math.pi * ((i // 2) + 0.8 * fate.uniform()) / (CYCLONES / 2)
        if tropical:
            latitude = side * math.radians(fate.uniform(10.0, 16.0) + 12.0 * share)
            longitude = fate.uniform(0.0, 2.0 * math.pi) - math.radians(40.0) * share
            size, most = fate.uniform(0.05, 0.08), 1.0
        else:
            latitude = side * math.radians(fate.uniform(34.0, 54.0) + 10.0 * share)
            longitude = slot + math.radians(40.0) * share
            size, most = fate.uniform(0.13, 0.26), fate.uniform(0.5, 1.0)
        across = math.cos(latitude)
        direction = (across * math.cos(longitude), across * math.sin(longitude), math.sin(latitude))
        strength = most * math.sin(math.pi * share) ** 2
        found.append(Cyclone(direction, size, side, strength, fate.uniform(0.0, 2.0 * math.pi)))
    return tuple(found)


def octahedral_weights(size: int) -> NDArray[np.float64]:
    """(size, size): solid angle of each texel of an octahedral map, adding up to one."""
    place = (np.arange(size) + 0.5) / size * 2.0 - 1.0
    x, y = np.meshgrid(place, place)
    # A texel of the octahedron |x| + |y| + |z| = 1 is seen under an angle that falls with the cube of its distance.
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    x, y = x - np.where(x < 0.0, -1.0, 1.0) * fold, y - np.where(y < 0.0, -1.0, 1.0) * fold
    weights = (x * x + y * y + z * z) ** -1.5
    return weights / weights.sum()


def balance_for(
    raw: NDArray[np.floating], weights: NDArray[np.float64], coverage: float, slope: float
) -> tuple[float, float]:
    """(level, slope) with which the mean of clip(0.5 + slope (raw - level), 0, 1) is `coverage`, by bisection."""
    low, high = float(raw.min()) - 1.0 / slope, float(raw.max()) + 1.0 / slope
    for _ in range(60):
        level = 0.5 * (low + high)
        mean = float((np.clip(0.5 + slope * (raw - level), 0.0, 1.0) * weights).sum())
        low, high = (level, high) if mean > coverage else (low, level)
    return 0.5 * (low + high), slope
