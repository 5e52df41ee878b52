"""The ground that a renderer draws, where a method's source has another one than the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..components import Ocean, Planet, Terrain
from ..engine.settings import revision, with_overrides
from ..engine.surface.field import HeightField
from ..systems.terrain.backends import backend_of
from ..systems.terrain.height import TerrainParams
from ..systems.terrain.paper_ground import PaperField

if TYPE_CHECKING:
    from ..camera.place import SceneCamera
    from ..scene.scene import Scene

__all__ = ["DrawnGround"]


class _MadeFor(NamedTuple):
    """Revisions that the printed ground was made for. radius: of the planet's."""

    terrain: int
    radius: int


class DrawnGround:
    """Which ground a renderer with these settings draws on a scene's default planet.

    That of the scene, but for the projected grid's paper mode: a texture of continents and layers of noise, a kilometre
    off among mountains. TerrainSampler and the scene's other queries always tell of the scene.
    """

    def __init__(self, scene: Scene, settings: Mapping[str, Any]) -> None:
        self._scene, self._settings = scene, settings
        self._held: tuple[_MadeFor, PaperField] | None = None

    def own_field(self) -> PaperField | None:
        """The ground that is drawn, if it isn't the scene's."""
        planet = self._scene.planet
        component = planet.get(Terrain)
        if component is None:
            return None
        knob = self._settings.get
        kind = backend_of(knob("terrain.backend", component.backend), knob("terrain.method", component.method))
        if not kind.own_ground:
            return None
        stamp = _MadeFor(revision(component), revision(planet[Planet], "radius_m"))
        if self._held is None or self._held[0] != stamp:
            terrain = with_overrides(component, "terrain", self._settings)
            params = TerrainParams.from_component(terrain, planet.radius_m)
            self._held = (stamp, PaperField(params, int(self._settings["terrain.paper_layers"])))
        return self._held[1]

    def field(self) -> HeightField | None:
        """The ground that is drawn; None without Terrain."""
        return self.own_field() or self._scene.planet.height_field()

    def placed_on(self, placed: SceneCamera) -> SceneCamera:
        """A camera that was placed above the ground, placed above the ground that is drawn."""
        drawn = self.own_field()
        if drawn is None or placed.place is None:
            return placed
        planet, own = self._scene.planet, placed.printed_place
        place, pose = (placed.place, placed.pose) if own is None else (own, own.pose(planet))
        if place.above == "ground":
            distance = float(np.linalg.norm(pose.position_m))
            zenith = pose.position_m / distance
            sea = planet.get(Ocean)
            height = float(drawn.height(zenith[None])[0])
            height = height if sea is None else max(height, sea.sea_level_m)
            off = height - float(planet.surface_height_m(zenith[None])[0])
            pose = replace(pose, position_m=zenith * (distance + off))
        return replace(placed, pose=pose)
