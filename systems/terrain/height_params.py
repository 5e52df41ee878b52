"""What shapes a planet's ground: the knobs of the height function, checked and frozen."""

from __future__ import annotations

import math
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ...engine.real_ground.polygons import Polygons
from ...engine.real_ground.real_ground import RealGround
from ...engine.real_ground.resident import real_ground
from ...engine.real_ground.tile_index import is_tiles
from ...engine.surface.map_files import MapError
from .height_map import HeightMap, height_map
from .rivers.table import RiverTable

__all__ = ["TerrainParams", "asked_for", "forget_with_tiles"]

KNOBS = (
    "land_share",
    "continent_size",
    "plains",
    "mountains",
    "hills",
    "roughness",
    "warp",
    "craters",
    "crater_largest_m",
    "height_map_blend",
    "height_map_detail",
    "erosion",
)
RANGES = {
    "layers": (1, 16),
    "land_share": (0.02, 0.98),
    "continent_size": (0.125, 4.0),
    "plains": (0.0, 1.0),
    "mountains": (0.0, 2.0),
    "hills": (0.0, 1.0),
    "roughness": (0.0, 8.0),
    "warp": (0.0, 2.0),
    "craters": (0.0, 1.0),
    "crater_largest_m": (1.0, 2e6),
    "height_map_blend": (0.0, 1.0),
    "height_map_detail": (0.0, 4.0),
    "erosion": (0.0, 1.0),
}

_forget: list[Callable[[], None]] = []
_tiles: list[weakref.ref[RealGround]] = []


def forget_with_tiles(clear: Callable[[], None]) -> None:
    """clear: of a cache by params. It is emptied when other tiles are asked for, or none: it would hold on to all those
    that there were, 256 MB each."""
    _forget.append(clear)


def asked_for(real: RealGround | None) -> None:
    """Say which tiles are, and let go what is known of others."""
    if real is not (_tiles[0]() if _tiles else None):
        for clear in _forget:
            clear()
    _tiles[:] = [] if real is None else [weakref.ref(real)]


@dataclass(frozen=True, slots=True)
class TerrainParams:
    """Everything that the heights of a planet depend on. Hashable: equal params give equal ground.

    radius_m: reference radius. seed: which planet. highest_m, lowest_m: bounds that no ground leaves.
    layers: 1..16 relief layers, the first 131 km wide on Earth, each half of the one before, the last 4 m.
    land_share: share of the surface above height 0 (the sea's level; on dry worlds just the middle height).
    continent_size: size of continents, rounded to a power of two; 1 suits a planet with a handful of them.
    plains: 1 is Earth's hypsometry (abyss, slope, shelf, coastal plains, plateaus), 0 an even spread of heights.
    mountains: width of the belts that carry mountain ranges; 1 is Earth-like, 0 none.
    roughness: multiplies all relief layers below the ranges; 1 is near what is measured on Earth's land up to 100 m.
    warp: how far domain warps bend continents, belts and ranges; 1 is usual.
    hills: 1: plains, hill country and ranges along coasts; 0: gently rolling land instead of all three. At 1 land is
        two to four times as rough as the Earth's from 1 km up.
    craters: how densely impact craters lie; 0 none, 1 as the oldest ground (systems/terrain/craters.py).
    height_map: heights all around; the bounds are raised to hold it. height_map_blend: 0, the map alone makes the broad
        shapes, 1, continents, ranges and relief are added to it. height_map_detail: how rough the relief below its
        samples is, 1 going on as the map itself. real: elevation from tiles, where there is any; the bounds are raised
        to hold it. colored: a colour map says what the ground looks like. pictured: tiles of pictures do, where there
        are any. shape_m: lowest and highest that the ground around tiles is made for, however far these reach; None:
        the bounds before they were raised.
    crater_largest_m: diameter of the largest ones, at most the planet's radius; others go down to the shortest layer.
    erosion: share of the relief from 2 km to 64 m that becomes gullies down the slope, where it is steep.
    rivers: lines that carve the ground (systems/terrain/rivers/). water: those of a vector map, which don't; woods: its
    forests (systems/terrain/vector_water/).
    """

    radius_m: float = 6.371e6
    seed: int = 1
    highest_m: float = 9000.0
    lowest_m: float = -9000.0
    layers: int = 16
    land_share: float = 0.3
    continent_size: float = 1.0
    plains: float = 1.0
    mountains: float = 1.0
    roughness: float = 1.0
    warp: float = 1.0
    hills: float = 1.0
    craters: float = 0.0
    crater_largest_m: float = 2.5e5
    height_map: HeightMap | None = None
    height_map_blend: float = 0.0
    height_map_detail: float = 1.0
    real: RealGround | None = None
    shape_m: tuple[float, float] | None = None
    colored: bool = False
    pictured: bool = False
    erosion: float = 0.0
    rivers: RiverTable | None = None
    water: RiverTable | None = None
    woods: Polygons | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.radius_m) and self.radius_m > 0.0):
            raise ValueError(f"TerrainParams.radius_m: expected a positive number of metres, found {self.radius_m!r}")
        for name, (low, high) in RANGES.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise ValueError(f"TerrainParams.{name}: expected {low:g} to {high:g}, found {value!r}")
        if not (math.isfinite(self.lowest_m) and math.isfinite(self.highest_m) and self.lowest_m < self.highest_m):
            raise ValueError(
                f"TerrainParams: lowest_m ({self.lowest_m!r}) has to be a finite number below highest_m"
                f" ({self.highest_m!r}); raise highest_m or lower lowest_m"
            )
        if self.real is not None and self.shape_m is None:
            object.__setattr__(self, "shape_m", (self.lowest_m, self.highest_m))
        for found in (self.height_map, self.real):
            if found is not None:
                self._hold(found)
        if self.real is not None and (self.craters > 0.0 or self.rivers is not None):
            raise MapError(
                "Terrain.height_map: tiles of elevation have craters and rivers of their own; set Terrain.craters and "
                "Terrain.rivers to 0"
            )
        if self.lowest_m <= -self.radius_m:
            raise ValueError(f"TerrainParams.lowest_m: {self.lowest_m!r} is below the centre of the planet; raise it")

    def _hold(self, found: HeightMap | RealGround) -> None:
        """Bounds that leave the map as it is, with room for what is added to it."""
        low, high = found.lowest_m, found.highest_m
        if max(abs(low), abs(high)) > 0.25 * self.radius_m:
            raise MapError(
                f"Terrain.height_map: heights from {low:g} to {high:g} m on a planet of radius {self.radius_m:g} m; "
                f"expected at most a quarter of it, {0.25 * self.radius_m:g} m: lower height_map_range_m"
            )
        room = 0.05 * max(high - low, 1e-6 * self.radius_m)
        object.__setattr__(self, "highest_m", max(self.highest_m, high + room))
        object.__setattr__(self, "lowest_m", min(self.lowest_m, low - room))

    @staticmethod
    def from_component(terrain: Any, radius_m: float, tell: bool = True) -> TerrainParams:
        """Params of a Terrain component, or of anything with its fields; knobs that it lacks keep their defaults.

        Reads the height map, if it names one. Without rivers and vector map: ground_params.py adds them. tell: say
        which tiles were asked for (`asked_for`); else somebody else does.
        """
        path, range_m = getattr(terrain, "height_map", ""), getattr(terrain, "height_map_range_m", None)
        if range_m is not None and not range_m[0] < range_m[1]:
            raise MapError(
                f"Terrain.height_map_range_m: expected (lowest, highest) in metres, found {tuple(range_m)!r}; swap them"
            )
        if path.lower().endswith(".hgt"):
            raise MapError(
                f"Terrain.height_map: {path} is one tile; expected the folder that it lies in: name that one"
            )
        tiles = bool(path) and is_tiles(path)
        if tiles and range_m is not None:
            raise MapError(
                f"Terrain.height_map_range_m: {tuple(range_m)!r} with tiles of elevation in {path}, which hold metres; "
                "leave it out"
            )
        if tiles and getattr(terrain, "rivers", 0.0) > 0.0:
            raise MapError(
                f"Terrain.rivers: {terrain.rivers:g} with tiles of elevation in {path}, whose valleys are real ones; "
                "set it to 0"
            )
        most_bytes = int(1e6 * float(getattr(terrain, "height_map_most_mb", 256.0)))
        colors = getattr(terrain, "color_map", "")
        pictured = bool(colors) and is_tiles(colors)
        knobs: dict[str, Any] = {name: float(getattr(terrain, name)) for name in KNOBS if hasattr(terrain, name)}
        # Tiles of ground keep the heights that they were made with: those may not come later.
        streams = getattr(terrain, "backend", "grid") == "grid" and getattr(terrain, "method", "ours") == "ours"
        real = real_ground(path, most_bytes, "Terrain.height_map", streams) if tiles else None
        if tell:
            asked_for(real)
        return TerrainParams(
            radius_m=float(radius_m),
            seed=int(terrain.seed),
            highest_m=float(terrain.highest_m),
            lowest_m=float(terrain.lowest_m),
            layers=int(terrain.layers),
            colored=bool(colors) and not pictured,
            pictured=pictured,
            height_map=height_map(path, None if range_m is None else tuple(range_m)) if path and not tiles else None,
            real=real,
            **knobs,
        )

    @property
    def waters(self) -> RiverTable | None:
        """All that there is of rivers and lakes."""
        return self.water if self.rivers is None else self.rivers

    @property
    def shaped_m(self) -> tuple[float, float]:
        """Lowest and highest that the procedural ground is made for."""
        return self.shape_m or (self.lowest_m, self.highest_m)

    @property
    def scale(self) -> float:
        """Horizontal scale against Earth, a power of two: wavelengths are Earth's times this."""
        return 2.0 ** round(math.log2(self.radius_m / 6.371e6))
