"""System: one feature of a frame, and what it gets once.

A system is the owner of its passes and of its GL objects. It never imports another system: they meet in components,
in the frame and its view, in world resources, in named graph resources and in shader contracts.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from .frame import Frame, View, ViewInfo, Views
from .settings import Settings
from .world import World

if TYPE_CHECKING:
    from .gpu import GpuScope
    from .graph import GraphBuilder

__all__ = ["Setup", "System"]


@dataclass
class Setup:
    """What a system gets once, when it becomes active.

    gpu: the scope that owns all its GL objects. settings: resolved quality values by dotted key. planet: entity.
    views: those of the renderer.
    """

    world: World
    gpu: GpuScope
    settings: Settings
    planet: int
    views: Views = field(default_factory=Views)


class System:
    """Base class of all systems. Subclasses say `name` and `needs` and override what they use.

    name: unique; also the owner under which its GL objects are counted. needs: component types; an entity that has all
    of them makes the system active (no needs: always active).
    """

    name: ClassVar[str] = ""
    needs: ClassVar[tuple[type, ...]] = ()
    essential: ClassVar[bool] = False
    """Nothing can be drawn without it, though the graph may compile: a renderer that goes on without systems that raise
    does not go on without this one."""
    structure: int = 0
    """Raised by the system when its passes or the sizes of its resources change: every view's frame graph is compiled
    again. What changes for one view alone raises `View.structure`, or is in `structure_of`."""
    moving: bool | None = None
    """Whether what it shows changed since the last frame although no component's field, camera, light or time did. None
    stands for no in the library's own systems and for yes in a game's, which says False where that is true."""

    def __init_subclass__(cls, **kwargs: object) -> None:
        super().__init_subclass__(**kwargs)
        if not isinstance(cls.name, str) or not cls.name:
            raise TypeError(f"system class {cls.__name__} needs a class attribute name, such as name = 'terrain'")

    def active(self, world: World) -> bool:
        """Whether the world has anything for this system to do; asked whenever the world's structure changes."""
        return not self.needs or bool(world.query(*self.needs))

    def setup(self, setup: Setup) -> None:
        """Make the GL objects, through setup.gpu. Called once when the system becomes active."""

    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        """Add this system's passes for one view. Called whenever the frame graph is compiled.

        builder: in the scope of that view, and of the planet for a system that belongs to one. What is declared is
        theirs, under bare names; `builder.scope(view=None)` is for what all views share.
        """

    def structure_of(self, view: View) -> object:
        """What the passes and sizes that `declare` gives for a view depend on: its graph is compiled again when this
        is not equal to what it was."""
        return self.structure

    def begin(self, frame: Frame) -> None:
        """Before any system's `update`: what all of them have to know of the frame, such as its jitter."""

    def update(self, frame: Frame) -> None:
        """CPU work and buffer writes of one frame, before the graph runs."""

    def settled(self, view: View) -> bool:
        """Whether that view's last frame shows all that this system will come to show: nothing streams, refines or
        adapts."""
        return True

    def progress(self, view: View) -> float:
        """How much of what `settled` waits for is done, 0..1."""
        return 1.0 if self.settled(view) else 0.0

    def refining(self, view: View) -> str:
        """What is still being made of what that view's last frame showed, in two or three words; "" for nothing.
        Asked every frame while somebody looks: never waits for the GPU."""
        return ""

    def statistics(self) -> dict[str, int]:
        """Counts of the last frame (cells, vertices, triangles) for overlays and benches. May read the GPU."""
        return {}

    def release(self) -> None:
        """Let go of what setup made; the caller then releases the GL scope, and what is kept for views. A system may be
        set up again afterwards."""
