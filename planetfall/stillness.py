"""Whether a frame shows what the last one did, so that still pictures can gather over frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from .components import DebugView, Exposure, Shape, Sun, Transform
from .engine.settings import latest_revision, revision
from .engine.system import Frame, System
from .scene import Scene
from .systems.composite import CompositeSystem

__all__ = ["Stillness"]

_SEEN_ELSEWHERE = (Sun, Exposure, DebugView)
"""Components whose change doesn't change what a still picture gathers, or is in the frame anyway."""


class Stillness:
    """What the last frame showed. `own`: the systems that say of themselves whether they move; others of a game's are
    taken to, unless they say so too."""

    def __init__(self, scene: Scene, own: tuple[type[System], ...]) -> None:
        self._scene, self.own = scene, own
        self._shown: tuple[Any, ...] = ()

    def forget(self) -> None:
        """The next frame is another one than the last, whatever it shows."""
        self._shown = ()

    def same_as_before(self, frame: Frame, running: Sequence[System]) -> bool:
        """See Frame.still."""
        camera, sun = frame.camera, frame.sun
        revisions = [
            revision(part)
            for holder in (*self._scene.planets.values(), self._scene.environment)
            for part in holder.components()
            if not isinstance(part, _SEEN_ELSEWHERE)
        ]
        place = (camera.position_m, camera.forward, camera.up, sun.direction, sun.irradiance)
        tangents = (camera.tan_left, camera.tan_right, camera.tan_bottom, camera.tan_top)
        moment = (*(v.tobytes() for v in place), *tangents, sun.angular_radius_rad, frame.time_s, frame.planet)
        bodies = latest_revision(Transform, Shape)
        shown = (moment, frame.size, self._scene.world.structure_revision, revisions, bodies)
        same, self._shown = shown == self._shown, shown
        if not same:
            return False
        return not any(self._moves(system) for system in running)

    def _moves(self, system: System) -> bool:
        if system.name == CompositeSystem.name:  # which gathers
            return False
        moving = system.moving if system.moving is not None else type(system) not in self.own
        return moving or not system.settled()
