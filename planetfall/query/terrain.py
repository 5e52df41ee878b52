"""TerrainSampler: the ground's truth on the CPU, in float64 and without OpenGL."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Ocean, Planet, Terrain
from ..engine.surface.lattice import cell_of
from ..engine.world import MissingError
from ..systems.terrain import height_march, height_rays
from ..systems.terrain.drainage.network import CELLS, Network
from ..systems.terrain.drainage.stored import network_of, rain_grid_of
from ..systems.terrain.ground_params import ground_params
from ..systems.terrain.height import TerrainField, TerrainParams
from .arguments import (
    checked_directions,
    checked_frame,
    checked_lengths,
    checked_pairs,
    checked_points,
    finite_lengths,
    not_the_middle,
)
from .climate import Climate, climate_at
from .drainage import Drainage, climate_params, drainage_at
from .patch import MOST_POINTS, TerrainPatch, aligned_patch, lattice_size, tangent_patch
from .water import Water, water_at

if TYPE_CHECKING:
    from ..scene.scene import PlanetHandle, Scene

__all__ = ["TerrainPatch", "TerrainSampler", "checked_directions"]

Floats = NDArray[np.float64]


class TerrainSampler:
    """Heights, normals, rays and contacts of a planet's ground: a snapshot of the scene when it was made.

    Positions are planet-centred metres in planet axes; directions need not be unit. Arrays are (N, 3) in, (N,) out.
    Bad input (wrong shape, NaN, a zero direction) is a ValueError that names the argument and the index.
    """

    def __init__(
        self, scene: Scene, planet: PlanetHandle | str | None = None, *, drainage_cells: int | None = None
    ) -> None:
        """scene: anything with planet[Planet] and planet[Terrain]. planet: one of scene.planets, or its
        name, instead of that. drainage_cells: of the whole planet, for `drainage`; the terrain's own by default."""
        if isinstance(planet, str) and planet in getattr(scene, "planets", ()):
            planet = scene.planets[planet]
        handle = getattr(scene, "planet", None) if planet is None else planet
        if handle is None or isinstance(handle, str) or not hasattr(handle, "__getitem__"):
            raise ValueError(
                f"TerrainSampler: expected a scene such as pf.load_scene('earth'), found {scene!r}"
                if planet is None
                else f"TerrainSampler: planet must be one of scene.planets, found {planet!r}"
            )
        try:
            terrain = handle[Terrain]
        except (KeyError, MissingError):
            raise ValueError(
                "TerrainSampler: the planet has no Terrain component; add one with scene.planet.add(pf.Terrain())"
            ) from None
        validate = getattr(scene, "validate", None)
        if validate is not None:
            validate()  # no ground that a renderer would refuse to draw
        self._sea_level_m = _sea_level_m(handle)
        sea = self._sea_level_m is not None
        self._field = TerrainField(ground_params(terrain, handle[Planet].radius_m, sea))
        self._climate, self._drainage_cells = climate_params(terrain, sea), drainage_cells or terrain.drainage_cells

    @classmethod
    def from_params(cls, params: TerrainParams) -> TerrainSampler:
        """A sampler of bare params, without a scene."""
        sampler = cls.__new__(cls)
        sampler._field, sampler._sea_level_m = TerrainField(params), None
        sampler._climate, sampler._drainage_cells = climate_params(Terrain()), CELLS
        return sampler

    @property
    def radius_m(self) -> float:
        """Radius of the reference sphere."""
        return self._field.radius_m

    @property
    def highest_m(self) -> float:
        """No ground is higher."""
        return self._field.highest_m

    @property
    def lowest_m(self) -> float:
        """No ground is lower."""
        return self._field.lowest_m

    def height(self, directions: ArrayLike) -> Floats:
        """Heights (N,) of the ground above the reference sphere in directions (N, 3) from the planet's centre."""
        return self._field.height(checked_directions("directions", directions))

    def normal(self, directions: ArrayLike, footprint_m: float | None = None) -> Floats:
        """Unit normals (N, 3) of the ground. footprint_m: leave out relief shorter than about two of it."""
        if footprint_m is not None and not 0.0 <= footprint_m < np.inf:
            raise ValueError(f"footprint_m: expected a number of metres from 0 up, found {footprint_m!r}")
        return height_march.surface_normal(self._field, checked_directions("directions", directions), footprint_m)[1]

    def raycast(
        self, origins_m: ArrayLike, directions: ArrayLike, max_distance_m: ArrayLike = np.inf
    ) -> tuple[NDArray[np.bool_], Floats]:
        """First ground along rays: hit (N,), distance_m (N,) (inf: none). Origins may be in space; below ground is 0.

        Distances are exact to less than a micrometre. Rays that graze a crest may miss a sliver of it, 1 mm
        long or a ten-millionth of their way.
        """
        origins, rays = checked_pairs(
            "origins_m", origins_m, "directions", checked_directions("directions", directions)
        )
        reach = checked_lengths("max_distance_m", max_distance_m, len(origins))
        return height_rays.raycast(self._field, origins, rays, reach)

    def sphere_contact(self, centers_m: ArrayLike, radii_m: ArrayLike) -> tuple[Floats, Floats]:
        """Depth (N,) of spheres in the ground (negative: clear of it) and normals (N, 3) along which to push them out.

        The depth is that of the nearest ground while a sphere is about as near as its radius; further up it is the
        height above the ground.
        """
        centers = not_the_middle("centers_m", checked_points("centers_m", centers_m))
        return height_march.contact(self._field, centers, finite_lengths("radii_m", radii_m, len(centers)))

    def sweep(
        self, start_m: ArrayLike, end_m: ArrayLike, radius_m: ArrayLike
    ) -> tuple[NDArray[np.bool_], Floats, Floats]:
        """Spheres going straight from start to end: hit (N,), fraction (N,) of the way at contact, normal (N, 3).

        The fraction is 1 where nothing is hit and 0 where the start touches already; contact is within 1 mm.
        """
        start, end = checked_pairs("start_m", start_m, "end_m", end_m)
        not_the_middle("start_m", start)
        return height_march.sweep(self._field, start, end, finite_lengths("radius_m", radius_m, len(start)))

    def drainage(self, directions: ArrayLike) -> Drainage:
        """Where water goes in directions (N, 3), by the broad shape of the ground: in cells of 12 km on Earth.

        The first question solves the planet's rivers, 20 s for one like Earth, or reads them: from the user's cache
        folder, or those of the preset earth from the package.
        """
        return drainage_at(self._network, checked_directions("directions", directions))

    def water(self, directions: ArrayLike) -> Water:
        """Water over the ground in directions (N, 3): of rivers and lakes (`Terrain.rivers`), and of the sea, calm.

        Water lies where its level is above the ground. A sampler from bare params knows of no sea.
        """
        return water_at(self._field, self._sea_level_m, checked_directions("directions", directions))

    def climate(self, directions: ArrayLike) -> Climate:
        """Warmth, rain and snow line in directions (N, 3): what rivers follow from, on cells of 52 km on Earth.

        The first question computes the planet's rain, or reads it from the user's cache folder: 2 s, or 0.01 s.
        """
        found = checked_directions("directions", directions)
        return climate_at(found, self._field.height(found), self._rain_mm, self._climate)

    @cached_property
    def _rain_mm(self) -> Floats:
        return rain_grid_of(self._field.params, self._climate)

    @cached_property
    def _network(self) -> Network:
        return network_of(replace(self._field.params, rivers=None), self._climate, self._drainage_cells)

    def patch_cells(self, directions: ArrayLike, size_m: float, spacing_m: float) -> NDArray[np.int64]:
        """Which aligned patches hold directions (N, 3): rows (face, level, i, j) (N, 4), as in TerrainPatch.cell.

        Two directions with equal rows get the same patch from patch(..., size_m, spacing_m, aligned=True).
        """
        _check_grid(size_m, spacing_m)
        level = lattice_size(self.radius_m, size_m, spacing_m)[1]
        face, i, j = cell_of(checked_directions("directions", directions), level)
        return np.stack([face, np.full_like(face, level), i, j], axis=1)

    def patch(
        self,
        direction: ArrayLike,
        size_m: float,
        spacing_m: float,
        *,
        aligned: bool = False,
        border: int = 0,
        frame: TerrainPatch | tuple[ArrayLike, ArrayLike] | None = None,
        normals: bool = True,
    ) -> TerrainPatch:
        """Ground around `direction` (3,): a square grid of `size_m` with points about `spacing_m` apart.

        It is the height function itself, whatever a camera sees. aligned: the cell of the planet's lattice that holds
        `direction`; size and spacing become the nearest powers of two of lattice steps, neighbouring patches of equal
        size and spacing share the points of their common border to the last bit. border: further rings of points beyond
        the cell, so that neighbours overlap (for bodies that roll across). frame: (origin_m (3,), axes (3, 3), rows
        orthonormal) or another patch, to have several patches in one frame. normals=False saves three quarters of the
        time.
        """
        up = checked_directions("direction", direction)
        if len(up) != 1:
            raise ValueError(f"direction: expected one direction (3,), found {len(up)}")
        _check_grid(size_m, spacing_m)
        if border < 0 or (border and not aligned):
            raise ValueError(f"patch: border={border!r} is for aligned patches, from 0 up")
        count = round(size_m / spacing_m) + 1 + 2 * border
        if count > MOST_POINTS:
            raise ValueError(
                f"patch: {count} x {count} points are too many ({MOST_POINTS}); raise spacing_m or lower size_m"
            )
        if size_m > self.radius_m:
            raise ValueError(f"patch: size_m={size_m!r} is above the planet's radius {self.radius_m!r}; lower it")
        place = checked_frame(frame)
        if aligned:
            return aligned_patch(self._field, up[0], size_m, spacing_m, border, place, normals)
        return tangent_patch(self._field, up[0], size_m, count, place, normals)


def _check_grid(size_m: float, spacing_m: float) -> None:
    if not (np.isfinite(size_m) and size_m > 0.0 and np.isfinite(spacing_m) and 0.0 < spacing_m <= size_m):
        raise ValueError(f"patch: expected 0 < spacing_m <= size_m, found size_m={size_m!r}, spacing_m={spacing_m!r}")


def _sea_level_m(handle: Any) -> float | None:
    """Of anything with components; None without a sea."""
    try:
        return float(handle[Ocean].sea_level_m)
    except (KeyError, MissingError):
        return None
