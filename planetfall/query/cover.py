"""CoverSampler: the trees and shrubs of a planet, in float64 and without OpenGL."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Cover, Ocean, Planet, Terrain
from ..engine.settings import assign_many
from ..engine.space import local_axes
from ..engine.world import MissingError
from ..systems.cover.grown import MOST_RADIUS_M, Grown
from ..systems.cover.growth import Growing
from ..systems.cover.species import Species
from ..systems.cover.stand import Plants
from ..systems.terrain.ground_params import ground_params
from ..systems.terrain.height import TerrainField
from .arguments import checked_directions, checked_frame, checked_points, finite_lengths, not_the_middle
from .patch import TerrainPatch
from .trunk_bodies import TrunkBodies

if TYPE_CHECKING:
    from ..scene.scene import PlanetHandle, Scene

__all__ = ["CoverSampler"]

MOST_M = 20_000.0
"""Radius within which a sampler looks for trees: some twenty million places, in forest."""

Floats = NDArray[np.float64]


class CoverSampler:
    """Where trees and shrubs stand: a snapshot of the scene when it was made. They are those that are drawn.

    Felling is no part of the snapshot: what `fell`, another sampler or an assignment to `Cover.felled` cut down is gone
    from all answers at once. Positions are planet-centred metres in planet axes. Bad input is a ValueError that names
    the argument and the index.
    """

    def __init__(self, scene: Scene, planet: PlanetHandle | str | None = None) -> None:
        """planet: one of scene.planets, or its name; its first one by default. ValueError without a Cover."""
        if isinstance(planet, str):
            if planet not in scene.planets:
                raise ValueError(f"CoverSampler: planet must be one of scene.planets, found {planet!r}")
            planet = scene.planets[planet]
        handle = planet or scene.planet
        try:
            terrain, cover = handle[Terrain], handle[Cover]
        except (KeyError, MissingError):
            raise ValueError(
                "CoverSampler: the planet needs the components Terrain and Cover; add one with "
                "scene.planet.add(pf.Cover())"
            ) from None
        scene.validate()
        ocean = handle.get(Ocean)
        self._handle, self._cover = handle, cover
        self._field = TerrainField(ground_params(terrain, handle[Planet].radius_m, ocean is not None))
        sea = None if ocean is None else ocean.sea_level_m
        growing = Growing.of(terrain, sea, cover.savanna, cover.riparian)
        species = tuple(map(replace, cover.species))
        self._grown = Grown(self._field, growing, replace(cover, species=species), terrain.seed)

    def within(self, direction: ArrayLike, radius_m: float) -> Plants:
        """The trees and shrubs within radius_m along the ground of the place in `direction` (3,) from the planet's
        centre.

        ValueError for a radius that is not above 0 and at most 20 km.
        """
        if not 0.0 < radius_m <= MOST_M:
            raise ValueError(f"radius_m: expected metres above 0 and at most {MOST_M:g}, found {radius_m!r}")
        return self._standing.within(_one_direction(direction), radius_m)

    def sphere_contact(self, centers_m: ArrayLike, radii_m: ArrayLike) -> tuple[Floats, Floats]:
        """Depth (N,) of spheres in the nearest trunk (negative: clear of it) and normals (N, 3) along which to push
        them out: as `TerrainSampler.sphere_contact` for the ground.

        Spheres (N, 3) may have one radius or one each, up to 1 km. A trunk is the cone that is drawn; leaves and limbs
        are none. Where no trunk is within 5 m of a sphere, its depth is -inf and its normal the zenith.
        """
        centers = not_the_middle("centers_m", checked_points("centers_m", centers_m))
        radii = finite_lengths("radii_m", radii_m, len(centers))
        wide = np.flatnonzero(radii > MOST_RADIUS_M)
        if wide.size:
            raise ValueError(f"radii_m[{wide[0]}]: expected at most {MOST_RADIUS_M:g} m, found {radii[wide[0]]:g}")
        return self._standing.contact(centers, radii)

    def bodies(
        self,
        direction: ArrayLike,
        radius_m: float,
        *,
        frame: TerrainPatch | tuple[ArrayLike, ArrayLike] | None = None,
    ) -> TrunkBodies:
        """The trunks within radius_m of the place in `direction` (3,), as cylinders or capsules for a physics engine.

        frame: (origin_m (3,), axes (3, 3), rows orthonormal) or a patch, whose frame they are then in; by default its
        origin is the ground at the place, its axes are east, north and up, as of TerrainSampler.patch.
        """
        up = _one_direction(direction)
        place = checked_frame(frame)
        if place is None:
            north, east = local_axes(up)
            place = (up * (self._field.radius_m + float(self._field.height(up[None])[0])), np.stack([east, north, up]))
        plants = self.within(up, radius_m)
        return TrunkBodies.of(plants.only(~np.isin(plants.forms, (Species.SHRUB, Species.ROSETTE))), *place)

    def fell(self, names: ArrayLike) -> int:
        """Cut down trees and shrubs by their names (N, 5), or one's (5,); returns how many were not felled before.

        They are neither drawn nor found any more, from the next frame on, and stay so in a scene's file: they are added
        to `Cover.felled`, which may be assigned to let trees stand again. A name holds for one `Cover.spacing_m`.
        """
        if self._handle.get(Cover) is not self._cover:
            raise ValueError("fell: the planet has another Cover by now; make a new CoverSampler")
        rows = np.asarray(names)
        rows = rows.reshape(-1, 5) if rows.shape == (5,) or rows.size == 0 else rows
        if rows.ndim != 2 or rows.shape[1] != 5 or (rows.size and not np.issubdtype(rows.dtype, np.integer)):
            raise ValueError(
                f"names: expected whole numbers (N, 5), as `names` of what within() gives, found shape "
                f"{np.shape(names)} of {rows.dtype}"
            )
        outside = ((rows < 0) | (rows >= 2**31)).any(axis=1) | (rows[:, 0] > 5)
        strange = np.flatnonzero((rows[:, 1] != self._grown.level) | outside)
        if strange.size:
            k = int(strange[0])
            raise ValueError(
                f"names[{k}]: expected a name that within() gives on this planet, (face 0 to 5, level "
                f"{self._grown.level}, i, j, number), found {rows[k].tolist()}"
            )
        felled = self._standing.felled
        new = [name for name in dict.fromkeys(map(tuple, rows.tolist())) if name not in felled]
        if new:
            # Checked above: a plain assignment would check ten thousand old names again, in 2 ms.
            assign_many([self._cover], "felled", [(*self._cover.felled, *new)])
        return len(new)

    @property
    def _standing(self) -> Grown:
        self._grown.fell(self._cover.felled)
        return self._grown


def _one_direction(direction: ArrayLike) -> Floats:
    found = checked_directions("direction", np.atleast_2d(np.asarray(direction, dtype=np.float64)))
    if len(found) != 1:
        raise ValueError(f"direction: expected one, (3,), found {len(found)}")
    return found[0]
