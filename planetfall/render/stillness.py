"""Whether a frame shows what the last one did, so that still pictures can gather over frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..components import DebugView, Exposure, Shape, Sun, Transform
from ..engine.frame import Frame, View
from ..engine.settings import latest_revision, revision
from ..engine.space.camera import CameraStamp
from ..engine.system import System
from ..scene.scene import Scene
from ..systems.composite import CompositeSystem
from ..systems.terrain.material_list import list_revision
from .system_list import is_own

__all__ = ["Stillness"]

_SEEN_ELSEWHERE = (Sun, Exposure, DebugView)
"""Components whose change doesn't change what a still picture gathers, or is in the frame anyway."""


class _SunKey(NamedTuple):
    direction: bytes
    irradiance: bytes
    angular_radius_rad: float


class _ShownKey(NamedTuple):
    """What a frame shows. structure, parts, props, materials: revisions."""

    camera: CameraStamp
    sun: _SunKey
    time_s: float
    planet: int
    size: tuple[int, int]
    structure: int
    parts: list[int]
    props: int
    materials: int


class Stillness:
    """What the last frame showed. The library's own systems say of themselves whether they move; others of a game's are
    taken to, unless they say so too."""

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._shown: _ShownKey | None = None
        self._waiting: frozenset[str] | None = None
        self._parts: tuple[tuple[object, ...], tuple[object, ...]] = ((), ())

    def forget(self) -> None:
        """The next frame is another one than the last, whatever it shows."""
        self._shown = None

    def drawn(self, view: View, running: Sequence[System]) -> None:
        """A frame has been drawn. Systems are asked now: what they share goes on in frames of other views, but this one
        shows it as it was."""
        # Not composite, which shares nothing, and may read back from the GPU to answer: later, when the frame is done.
        names = (s.name for s in running if s.name != CompositeSystem.name and not s.settled(view))
        self._waiting = frozenset(names)

    def settled(self, view: View, running: Sequence[System]) -> bool:
        """Whether the last frame of this view showed all that it will come to show."""
        return self._waiting is not None and not self._waiting and all(s.settled(view) for s in running)

    def same_as_before(self, frame: Frame, running: Sequence[System]) -> bool:
        """See Frame.still."""
        camera, sun = frame.camera, frame.sun
        revisions = [revision(part) for part in self._listed()]
        light = _SunKey(sun.direction.tobytes(), sun.irradiance.tobytes(), sun.angular_radius_rad)
        props, materials = latest_revision(Transform, Shape), list_revision()
        structure = self._scene.world.structure_revision
        moment = (camera.stamp, light, frame.time_s, frame.planet, frame.size)
        shown = _ShownKey(*moment, structure, revisions, props, materials)
        same, self._shown = shown == self._shown, shown
        return same and not any(self._moves(frame.view, system) for system in running)

    def _listed(self) -> tuple[object, ...]:
        """The components whose change ends a still picture."""
        holders = (*self._scene.planets.values(), self._scene.environment)
        structure = tuple((holder.scene, holder.scene.world.structure_revision) for holder in holders)  # each its own
        if self._parts[0] != structure:
            parts = [part for holder in holders for part in holder.components()]
            self._parts = structure, tuple(part for part in parts if not isinstance(part, _SEEN_ELSEWHERE))
        return self._parts[1]

    def _moves(self, view: View, system: System) -> bool:
        if system.name == CompositeSystem.name:  # which gathers
            return False
        moving = system.moving if system.moving is not None else not is_own(system)
        return moving or self._waiting is None or system.name in self._waiting or not system.settled(view)
