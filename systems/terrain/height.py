"""Heights of whole planets, float64 and without GL: the twin of assets/shaders/terrain/height.glsl.

`TerrainParams` says what may be set. Recommended:

    planet       radius_m  highest_m  lowest_m  layers  land_share  plains  mountains  roughness
    Earth        6.371e6   9000       -9000     16      0.30        1.0     0.4        1.35       (hills 0.2)
    Mars, dry    3.39e6    12000      -8000     16      0.60        0.7     0.6        0.8        (craters 0.35)
    Moon         1.737e6   8000       -7000     16      0.50        0.3     0.0        0.5        (craters 0.8)
    asteroid     500-1000  0.1 r      -0.1 r    10      0.50        0.0     0.5        2.5        (craters 0.9)

Directions are unit vectors (N, 3) in planet axes; heights are metres above the reference sphere. The functions take
`params` or a `Model`; 1000 points at 16 layers take 1.5-1.8 ms, one point 0.08 ms (one core of a 2024 x86).
"""

from __future__ import annotations

from functools import cached_property, lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...engine.real_ground.lattice import sphere_place
from .height_model import Model
from .height_octaves import BLOCK, FEW_POINTS, heights, heights_gradients, heights_slopes, model_of, widest_noise
from .height_params import TerrainParams, forget_with_tiles
from .height_relief import relief_statistics
from .height_steps import layer_weight
from .rivers.valleys import beside_water, from_water_m, waters

__all__ = [
    "TerrainField",
    "TerrainParams",
    "height",
    "height_and_gradient",
    "height_at_points",
    "layer_weight",
    "relief_statistics",
]

Floats = NDArray[np.float64]

COLORED_MOISTURE = 0.45
"""TERRAIN_COLORED_MOISTURE of terrain/height.glsl."""

_REMEMBERED = 8
"""Places of a TerrainField; then all of them are forgotten."""


def height(directions: Floats, params: TerrainParams | Model) -> Floats:
    """Heights (N,) in metres at unit `directions` (N, 3)."""
    model = params if isinstance(params, Model) else model_of(params)
    return height_at_points(np.asarray(directions, dtype=np.float64) * model.params.radius_m, model)


def height_at_points(points_m: Floats, params: TerrainParams | Model) -> Floats:
    """Heights (N,) of the noise at `points_m` (N, 3), planet-centred metres: the feet on the reference sphere."""
    model = params if isinstance(params, Model) else model_of(params)
    points = np.ascontiguousarray(points_m.T)
    count = points.shape[1]
    if count <= BLOCK:
        return heights(points, model)
    blocks = -(-count // BLOCK)
    edges = np.linspace(0, count, blocks + 1).astype(int)
    return np.concatenate([heights(points[:, a:b], model) for a, b in pairwise(edges)])


def height_and_gradient(
    directions: Floats, params: TerrainParams | Model, footprint_m: float | Floats | None = None
) -> tuple[Floats, Floats]:
    """Heights (N,) and surface gradients (N, 3) at unit `directions` (N, 3).

    The gradient is tangential, metres per metre along the reference sphere. With `footprint_m` (a number or (N,)) it
    is band-limited as the shader's is: each layer weighs `layer_weight(wavelength, footprint)`. Heights never are.
    """
    model = params if isinstance(params, Model) else model_of(params)
    directions = np.asarray(directions, dtype=np.float64)
    points = np.ascontiguousarray(directions.T) * model.params.radius_m
    count = points.shape[1]
    footprint = None if footprint_m is None else np.broadcast_to(np.asarray(footprint_m, dtype=np.float64), (count,))
    heights, gradients = np.empty(count), np.empty((count, 3))
    for start in range(0, count, BLOCK):
        part = slice(start, start + BLOCK)
        limit = None if footprint is None else footprint[part]
        heights[part], slope = heights_gradients(points[:, part], model, limit)
        up = directions[part].T
        gradients[part] = (slope - up * (up * slope).sum(axis=0)).T
    return heights, gradients


@lru_cache(maxsize=16)
def _places(params: TerrainParams) -> dict[bytes, float]:
    """The heights that are remembered of this ground: several fields may be of the same."""
    return {}


forget_with_tiles(_places.cache_clear)


class TerrainField:
    """The ground of one planet as a HeightField (engine/surface/field.py).

    The last few single places are remembered: in each frame a flight, the camera that it moves and the proxy below that
    ask for the same one, and a place takes a tenth of a millisecond.
    """

    def __init__(self, params: TerrainParams) -> None:
        self.params = params
        self.model = model_of(params)
        self._known = _places(params)

    @property
    def highest_m(self) -> float:
        """No ground is higher."""
        return self.params.highest_m

    @property
    def lowest_m(self) -> float:
        """No ground is lower."""
        return self.params.lowest_m

    @property
    def radius_m(self) -> float:
        """Reference radius."""
        return self.params.radius_m

    @cached_property
    def steepest(self) -> float:
        """A slope that hardly any ground exceeds."""
        return self.model.steepest

    def height_slope(self, directions: Floats) -> tuple[Floats, Floats]:
        """Heights (N,) and slopes (N,) that the ground near there hardly ever exceeds."""
        points = np.ascontiguousarray(np.asarray(directions, dtype=np.float64).T) * self.params.radius_m
        parts = [heights_slopes(points[:, a : a + BLOCK], self.model) for a in range(0, points.shape[1], BLOCK)]
        if not parts:
            return np.empty(0), np.empty(0)
        return np.concatenate([h for h, _ in parts]), np.concatenate([s for _, s in parts])

    def height(self, directions: Floats) -> Floats:
        """Heights (N,) at unit directions (N, 3)."""
        if len(directions) > FEW_POINTS:
            return height(directions, self.model)
        return self._remembered(np.asarray(directions, dtype=np.float64))

    def _remembered(self, directions: Floats) -> Floats:
        """`height` of so few places that each has the bits that it has alone."""
        names = [place.tobytes() for place in directions]
        heights = [self._known.get(name) for name in names]
        if None in heights:
            heights = height(directions, self.model).tolist()
            if len(self._known) > _REMEMBERED:
                self._known.clear()
            self._known.update(zip(names, heights, strict=True))
        return np.array(heights, dtype=np.float64)

    def moisture(self, directions: Floats) -> Floats:
        """Of the ground by itself (N,), 0 dry .. 1 wet, at unit directions (N, 3): terrain_moisture() of
        terrain/height.glsl, without craters."""
        if self.params.colored:
            return np.full(len(directions), COLORED_MOISTURE)
        points = np.ascontiguousarray(directions.T) * self.radius_m
        w1 = np.concatenate(
            [widest_noise(points[:, a : a + BLOCK], self.model) for a in range(0, points.shape[1], BLOCK)]
            or [np.zeros((3, 0))],
            axis=1,
        )
        return np.clip(0.5 - 0.6 * w1[2] + 0.2 * w1[1], 0.0, 1.0)

    def beside_water(self, directions: Floats) -> Floats:
        """1 in rivers and lakes (N,) .. 0 from 100 m from them on, at unit directions (N, 3)."""
        if self.params.waters is None or not len(directions):
            return np.zeros(len(directions))
        return beside_water(self.params.waters, directions.T * self.radius_m)

    def from_water_m(self, directions: Floats) -> Floats:
        """Metres from the edges of rivers and lakes (N,), as their lines are measured, which bends stretch by up to
        two; negative in them, infinite where there are none around. At unit directions (N, 3)."""
        if self.params.waters is None or not len(directions):
            return np.full(len(directions), np.inf)
        return from_water_m(self.params.waters, directions.T * self.radius_m)

    def is_wet(self, directions: Floats, height_m: Floats) -> NDArray[np.bool_]:
        """Whether places (N,) of that height lie under a river or a lake."""
        if self.params.waters is None or not len(directions):
            return np.zeros(len(directions), dtype=bool)
        found = waters(self.params.waters, directions.T * self.radius_m)
        return (found.beyond_m < 0.0) & (found.level_m > height_m)

    def wooded(self, directions: Floats) -> NDArray[np.bool_]:
        """Whether a map lets trees stand at places (N,): all but those beside its forests, within their bounds."""
        woods = self.params.woods
        if woods is None:
            return np.ones(len(directions), dtype=bool)
        latitude_deg, longitude_deg = sphere_place(directions.T)
        return ~woods.boxed(longitude_deg, latitude_deg) | woods.inside(longitude_deg, latitude_deg)

    def height_gradient(self, directions: Floats, footprint_m: float | Floats | None = None) -> tuple[Floats, Floats]:
        """Heights (N,) and tangential gradients (N, 3) at unit directions (N, 3)."""
        return height_and_gradient(directions, self.model, footprint_m)
