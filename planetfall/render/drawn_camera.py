"""A camera as it is drawn: resolved in a scene, put on the ground that is drawn, and lifted out of it if need be."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, NamedTuple

from ..components import Ocean, Terrain
from ..engine.settings import PartRevision, revision
from ..engine.space import CameraState

if TYPE_CHECKING:
    from ..camera.camera import Camera
    from ..camera.place import SceneCamera
    from ..scene.scene import Scene
    from .drawn_ground import DrawnGround

__all__ = ["CameraResolver", "DrawnCamera"]

log = logging.getLogger(__name__)

_LOWEST_CLEARANCE_M = 0.01


class _StandsOn(NamedTuple):
    """What a camera's place follows from: revisions. scene, structure: structures of its scene and its planet's."""

    scene: int
    structure: int
    sun: PartRevision
    planet: int
    terrain: int
    ocean: int


class CameraResolver:
    """The last camera of a picture in its scene: resolving one takes up to a seventh of a frame."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._held: tuple[Camera, _StandsOn | None, SceneCamera] | None = None

    def resolve(self, camera: Camera) -> SceneCamera:
        """The same object while neither the camera nor what it stands on changes."""
        held = self._held
        if held is None or held[0] is not camera or held[1] != self._stamp(held[2]):
            placed = camera.in_scene(self._scene)
            held = self._held = (camera, self._stamp(placed), placed)
        return held[2]

    def _stamp(self, placed: SceneCamera) -> _StandsOn | None:
        """None: its planet is gone."""
        over = placed.planet
        if over.scene.world.closed or over.name not in self._scene.planets:
            return None
        terrain, ocean = (0 if c is None else revision(c) for c in (over.get(Terrain), over.get(Ocean)))
        sun = PartRevision.of(self._scene.sun)
        structures = (self._scene.world.structure_revision, over.scene.world.structure_revision)
        return _StandsOn(*structures, sun, revision(over.planet), terrain, ocean)


class DrawnCamera:
    """A camera over one planet as it is drawn, for one view."""

    def __init__(self, scene: Scene, ground: DrawnGround) -> None:
        self._scene, self._ground = scene, ground
        self._held: tuple[SceneCamera, tuple[int, int], CameraState] | None = None
        self._lifted = False

    def state(self, placed: SceneCamera, size: tuple[int, int]) -> CameraState:
        """In f64, in the planet's axes, for a picture of `size`; the last one is kept."""
        held = self._held
        if held is None or held[0] is not placed or held[1] != size:
            state = self._lifted_out(self._ground.placed_on(placed).state(size[0] / size[1]))
            held = self._held = (placed, size, state)
        return held[2]

    def _lifted_out(self, state: CameraState) -> CameraState:
        """Out of the ground, with one warning: nothing good can be seen from inside."""
        field = self._ground.field()
        if field is None:
            return state
        distance = state.distance_m
        radius = self._scene.planet.radius_m
        if distance - radius > field.highest_m + _LOWEST_CLEARANCE_M or distance == 0.0:
            return state
        zenith = state.direction
        ground = float(field.height(zenith[None])[0])
        if distance - radius >= ground + _LOWEST_CLEARANCE_M:
            return state
        if not self._lifted:
            self._lifted = True
            log.warning(
                "the camera was %.2f m inside the ground and was lifted above it; said once",
                ground - (distance - radius),
            )
        return state.moved(zenith * (radius + ground + _LOWEST_CLEARANCE_M))
