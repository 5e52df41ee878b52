"""Where a camera stands: resolved against a scene's ground, and lifted out of it if need be."""

from __future__ import annotations

import logging
from typing import Any

from ..camera.camera import Camera
from ..camera.views import View
from ..components import Ocean, Terrain
from ..engine.settings import revision
from ..engine.space import CameraState
from ..scene.scene import Scene
from .drawn_ground import DrawnGround

__all__ = ["Standpoint"]

log = logging.getLogger(__name__)

_LOWEST_CLEARANCE_M = 0.01


class Standpoint:
    """Cameras of one scene as places in f64; the last one is kept, since cameras don't change."""

    def __init__(self, scene: Scene, ground: DrawnGround) -> None:
        self._scene, self._ground = scene, ground
        self._held: tuple[Camera | View, tuple[Any, ...], CameraState, Any] | None = None
        self._lifted = False

    @property
    def sun(self) -> Any:
        """The sun that the last camera brought, or None."""
        return None if self._held is None else self._held[3]

    def state(self, camera: Camera | View, size: tuple[int, int]) -> CameraState:
        """The camera in f64 for a picture of `size`."""
        # Cameras don't change: the same one in the same scene stands where it stood.
        here = self._scene.planet
        parts = tuple(0 if c is None else revision(c) for c in (here.planet, here.get(Terrain), here.get(Ocean)))
        key = (self._scene.world.structure_revision, revision(self._scene.sun), *parts, size)
        held = self._held
        if held is None or held[0] is not camera or held[1] != key:
            plain = camera.camera if isinstance(camera, View) else camera
            state = plain.resolve(self._scene, size[0] / size[1])
            state = self._lifted_out(self._ground.stand_on(plain, state))
            view_sun = camera.sun if isinstance(camera, View) else None
            held = self._held = (camera, key, state, view_sun)
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
