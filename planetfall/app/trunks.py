"""The trunks that a walker of the flight can't walk through: those of the trees that are drawn."""

from __future__ import annotations

from ..components import Cover, Ocean, Terrain
from ..engine.settings import revision
from ..scene.scene import PlanetHandle
from ..systems.cover.felling import grows
from ..systems.cover.grown import Grown, TrunkGround
from ..systems.cover.growth import Growing
from ..systems.flight import Obstacles

__all__ = ["FlightTrunks"]


class FlightTrunks:
    """Of one planet at a time, and known anew when what they follow from has changed."""

    def __init__(self) -> None:
        self._key: object = None
        self._grown: Grown | None = None

    def on(self, planet: PlanetHandle, field: TrunkGround | None) -> Obstacles | None:
        """What spheres touch on a planet with these heights; None where no trees grow."""
        cover, terrain, ocean = planet.get(Cover), planet.get(Terrain), planet.get(Ocean)
        if cover is None or terrain is None or field is None or cover.density <= 0.0:
            self._key = self._grown = None
            return None
        sea = None if ocean is None else ocean.sea_level_m
        key = (field, grows(cover), revision(terrain), sea)
        if self._grown is None or key != self._key:
            self._key, self._grown = (
                key,
                Grown(field, Growing.of(terrain, sea, cover.savanna, cover.riparian), cover, terrain.seed),
            )
        self._grown.fell(cover.felled)
        return self._grown.contact
