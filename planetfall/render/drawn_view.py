"""DrawnView: one planet in one picture, with all that lasts from frame to frame of it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from ..engine.frame import View
from ..errors import SettingError
from .drawn_camera import DrawnCamera
from .rest import Rest
from .stillness import Stillness

if TYPE_CHECKING:
    from ..engine.graph import Plan
    from ..scene.scene import Scene
    from .drawn_ground import DrawnGround

__all__ = ["LDR", "PICTURE", "DrawnView", "PlanKey"]

LDR = "composite.ldr"
"""The resource that a picture of colours is read from."""
PICTURE = frozenset({LDR, "composite.resolved", "composite.quarter"})
"""Resources that belong to a picture: asking for them alone leaves its samples where they are."""


class PlanKey(NamedTuple):
    """What a plan was compiled for. gates: how often systems had come or gone; view: its structure; systems: name and
    structure of each."""

    exports: frozenset[str]
    gates: int
    view: int
    systems: tuple[tuple[str, object], ...]


class DrawnView(View):
    """What a planet's renderer keeps for one picture: its size, frame graph, last frame, camera, and what systems keep.

    Released with `release`, which leaves it as new.
    """

    def __init__(self, index: int, size: tuple[int, int], scene: Scene, ground: DrawnGround) -> None:
        super().__init__(index)
        self.size = size
        """(width, height) in pixels."""
        self.plan: Plan | None = None
        self.plan_key: PlanKey | None = None
        self.exports: frozenset[str] = frozenset({LDR})
        self.frames = 0
        """Frames that it has shown."""
        self.cut = True
        """The next frame has no use for the last one."""
        self.camera = DrawnCamera(scene, ground)
        self.stillness = Stillness(scene)
        self.rest = Rest(scene)

    def resize(self, size: tuple[int, int]) -> None:
        """Another size from the next frame on; nothing is drawn anew that doesn't depend on it."""
        if size != self.size:
            if self.plan is not None:
                self.plan.resize(size)
            self.size = size
            self.plan_key = None  # lists of tiles have the picture's size

    def compiled(self) -> Plan:
        """The frame graph of the last frame. SettingError before the first."""
        if self.plan is None:
            raise SettingError("nothing has been rendered yet: call render() first")
        return self.plan

    def outdated(self) -> None:
        """A shader has changed: what was made with the old one is made again."""
        if self.plan is not None:
            self.plan.invalidate_persistent()
        self.rest.forget()

    def failed_system(self) -> str:
        """The system whose pass raised in the last frame; "" where none did."""
        return "" if self.plan is None else self.plan.failed_system

    def release_plan(self) -> None:
        """Free the frame graph's textures and buffers."""
        if self.plan is not None:
            self.plan.release()
            self.plan = None

    def release(self) -> None:
        self.release_plan()
        super().release()
