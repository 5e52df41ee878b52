"""OceanSampler: the moving sea on the CPU, in float64 and without OpenGL."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Ocean, Planet, Terrain, Wind
from ..components.wind import blown
from ..engine.waves import WaveSet, at_directions, displacement, surface, wave_method, waves_of
from ..engine.waves.shoaling import DEEP
from ..engine.world import MissingError
from ..systems.terrain.ground_params import ground_params
from ..systems.terrain.height import TerrainField
from .arguments import checked_directions

if TYPE_CHECKING:
    from ..scene.scene import PlanetHandle, Scene

__all__ = ["OceanSampler"]

Floats = NDArray[np.float64]


class OceanSampler:
    """Heights and normals of a planet's sea, waves included: a snapshot of the scene when it was made.

    Directions (N, 3) go from the planet's centre, in planet axes, and need not be unit; times are seconds, one or (N,).
    The sea is the drawn one without the limits of a picture: every wave counts, however short, and in shallow water
    waves flatten by the depth above the ground. Where the ground is higher the sea is calm, below it. Bad input is a
    ValueError that names the argument and the index.
    """

    def __init__(self, scene: Scene, planet: PlanetHandle | None = None) -> None:
        """scene: anything with planet[Planet] and planet[Ocean]. planet: one of scene.planets instead of that."""
        handle = scene.planet if planet is None else planet
        try:
            ocean = handle[Ocean]
        except (KeyError, MissingError):
            raise ValueError(
                "OceanSampler: the planet has no Ocean component; add one with scene.planet.add(pf.Ocean())"
            ) from None
        self._radius_m = float(handle[Planet].radius_m)
        self._sea_level_m = float(ocean.sea_level_m)
        self._waves = waves_of(blown(ocean, handle.get(Wind)), self._radius_m)
        self._method = str(ocean.method)
        self._ground: TerrainField | None = None
        if Terrain in handle:
            self._ground = TerrainField(ground_params(handle[Terrain], self._radius_m))

    @property
    def radius_m(self) -> float:
        """Radius of the reference sphere, from which heights are counted."""
        return self._radius_m

    @property
    def sea_level_m(self) -> float:
        """Height of the calm sea."""
        return self._sea_level_m

    @property
    def waves(self) -> WaveSet:
        """The waves, longest first: origins, amplitudes, wavelengths, steepness, speeds."""
        return self._waves

    def height(self, directions: ArrayLike, time_s: ArrayLike) -> Floats:
        """Heights (N,) of the sea above the reference sphere in directions (N, 3).

        Waves move water sideways as well: the point that is there now is found to 0.1 mm.
        """
        calm, _, moved = self._found(directions, time_s)
        return np.linalg.norm(calm * self._waves.radius_m + moved, axis=1) - self._radius_m

    def normal(self, directions: ArrayLike, time_s: ArrayLike) -> Floats:
        """Unit normals (N, 3) of the sea's surface in directions (N, 3): at the points whose heights `height` gives."""
        v, time = self._arguments(directions, time_s)
        calm, depth, _ = at_directions(self._waves, v, time, self._depth_of(), method=self._method)
        slope = None
        if depth is not None and self._ground is not None and len(self._waves):
            near = np.flatnonzero((depth > 0.0) & (depth * self._waves.wave_number_per_m[0] < DEEP))
            slope = np.zeros_like(calm)
            if len(near):
                # Per metre of the calm sea, which lies sea_level_m above the sphere of the gradient.
                rise = self._ground.height_gradient(calm[near])[1]
                slope[near] = -rise * (self._radius_m / self._waves.radius_m)
        return surface(self._waves, calm, time, depth, depth_slope=slope, method=self._method).normal

    def displacement(self, directions: ArrayLike, time_s: ArrayLike) -> Floats:
        """By how much waves move points of the calm sea, metres (N, 3) in planet axes.

        The point at `directions` (N, 3) of the calm sea is at directions * (radius_m + sea_level_m) + displacement.
        """
        v, time = self._arguments(directions, time_s)
        depth_of = self._depth_of()
        return displacement(self._waves, v, time, None if depth_of is None else depth_of(v), method=self._method)

    def _found(self, directions: ArrayLike, time_s: ArrayLike) -> tuple[Floats, Floats | None, Floats]:
        v, time = self._arguments(directions, time_s)
        return at_directions(self._waves, v, time, self._depth_of(), method=self._method)

    def _arguments(self, directions: ArrayLike, time_s: ArrayLike) -> tuple[Floats, Floats]:
        v = checked_directions("directions", directions)
        time = np.asarray(time_s, dtype=np.float64)
        if time.shape not in ((), (1,), (len(v),)):
            raise ValueError(f"time_s: expected one number or {len(v)}, found shape {time.shape}")
        if not np.isfinite(time).all():
            raise ValueError(
                f"time_s: expected finite seconds, found {time.reshape(-1)[~np.isfinite(time.reshape(-1))][0]}"
            )
        return v, time if time.shape == (len(v),) else time.reshape(-1)[0]

    def _depth_of(self) -> Callable[[Floats], Floats] | None:
        """Depth of the calm sea, for a method that knows shallow water: no printed one does."""
        ground = self._ground
        if ground is None or wave_method(self._method).printed:
            return None
        return lambda v: self._sea_level_m - ground.height(v)
