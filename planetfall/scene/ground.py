"""The heights of the ground of a scene's planets on the CPU, kept until what they are made of changes."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Protocol

from ..components import Ocean, Planet, Terrain
from ..engine.settings import revision
from ..errors import SceneError
from .handle import Parts

if TYPE_CHECKING:
    from ..engine.surface.field import HeightField

__all__ = ["HeightFields"]

log = logging.getLogger(__name__)


class Ground(Parts, Protocol):
    """A planet with whatever ground it has."""

    entity: int

    @property
    def planet(self) -> Planet: ...

    @property
    def radius_m(self) -> float: ...


class HeightFields:
    """Height fields by the planet's entity."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[tuple[object, ...], HeightField]] = {}

    def of(self, planet: Ground) -> HeightField | None:
        """As `Scene.height_field`."""
        terrain = planet.get(Terrain)
        if terrain is None:
            return None
        from ..systems.terrain.rivers.source import source

        sea = planet.get(Ocean) is not None
        solved = source.finished if terrain.rivers > 0.0 else 0
        stamp = (revision(terrain), revision(planet.planet, "radius_m"), sea, solved)
        known = self._known.get(planet.entity)
        if known is not None and known[0] == stamp:
            return known[1]
        from ..systems.terrain.ground_params import ground_params
        from ..systems.terrain.height import TerrainField

        before = known[1].params if known is not None and isinstance(known[1], TerrainField) else None
        try:
            params = ground_params(terrain, planet.radius_m, sea, before)
        except ValueError as error:
            if known is not None:
                log.error("Terrain stays as it was: %s", error)
                self._known[planet.entity] = (stamp, known[1])
                return known[1]
            raise SceneError(f"Terrain on a planet of {planet.radius_m:g} m cannot be: {error}") from error
        field: HeightField = TerrainField(params)
        self._known[planet.entity] = (stamp, field)
        return field

    def clear(self) -> None:
        """Forget all of them."""
        self._known.clear()
