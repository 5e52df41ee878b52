"""Callbacks of a renderer: what a host wants to hear of a scene that others may change."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING
from weakref import WeakSet

from ..engine.settings import revision

if TYPE_CHECKING:
    from ..engine.frame import View
    from ..engine.system import System
    from ..scene.scene import Scene

__all__ = ["Watch"]


class Watch:
    """Lists of functions that are called after a frame, in the thread that rendered it. Empty lists cost nothing.

    changed(names): components of the scene's planets, their orbits or its environment were changed, added or taken off
    since the last frame; names are those of their classes. settled(): everything that streams, refines or adapts in
    a view has come to rest; once for that view, and again after each change that set it going. Asking for that reads
    back from the GPU in automatic exposure. What a callback raises comes out of the renderer's call.
    """

    def __init__(self) -> None:
        self.changed: list[Callable[[frozenset[str]], object]] = []
        self.settled: list[Callable[[], object]] = []
        self._stamps: dict[tuple[int, int, str], tuple[int, int]] | None = None
        self._rest: WeakSet[View] = WeakSet()

    def after_frame(self, scene: Scene, view: View, running: Iterable[System]) -> None:
        """A frame of a scene has been drawn in that view by these systems."""
        if self.changed:
            self._tell_changes(scene)
        if self.settled:
            if not all(system.settled(view) for system in running):
                self._rest.discard(view)
            elif view not in self._rest:
                self._rest.add(view)
                for function in tuple(self.settled):
                    function()

    def _tell_changes(self, scene: Scene) -> None:
        stamps = {
            (id(holder.scene), holder.entity, type(part).__name__): (id(part), revision(part))
            for holder in (*scene.planets.values(), scene.environment)
            for part in holder.components()
        }
        for companion in scene.companions.values():
            stamps[id(companion.scene), -1, "Orbit"] = (id(companion.orbit), revision(companion.orbit))
        before, self._stamps = self._stamps, stamps
        if before is None or before == stamps:
            return
        names = frozenset(key[2] for key in before.keys() | stamps.keys() if before.get(key) != stamps.get(key))
        for function in tuple(self.changed):
            function(names)
