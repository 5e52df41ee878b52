"""System: one feature of a frame, and the small records that the renderer hands to it.

A system is the owner of its passes and of its GL objects. It never imports another system: they meet in components,
in world resources, in named graph resources and in shader contracts.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from .frame import View, Views
from .world import World

if TYPE_CHECKING:
    from .gpu import GpuScope
    from .graph import GraphBuilder
    from .space import CameraState

__all__ = ["Frame", "Setup", "SunState", "System", "ViewInfo"]


@dataclass(frozen=True, eq=False)
class SunState:
    """The sun as one frame sees it, in planet axes.

    direction: (3,) f64, unit, from the planet to the sun. irradiance: (3,) f64 at the planet, in the scene's unit at
    the three wavelengths. angular_radius_rad: half the angle of the disc.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    angular_radius_rad: float


@dataclass
class Setup:
    """What a system gets once, when it becomes active.

    gpu: the scope that owns all its GL objects. settings: resolved quality values by dotted key. planet: entity.
    views: those of the renderer.
    """

    world: World
    gpu: GpuScope
    settings: Mapping[str, Any]
    planet: int
    views: Views = field(default_factory=Views)


@dataclass
class ViewInfo:
    """The view that a frame graph is declared for: size in pixels (width, height), what is asked of it.

    planet: the entity of the planet that its camera is on; planet_index: that planet's place in names of the graph.
    """

    size: tuple[int, int]
    view: View = field(default_factory=View)
    outputs: frozenset[str] = frozenset({"color"})
    planet: int = 0
    planet_index: int = 0

    @property
    def index(self) -> int:
        """The view's index."""
        return self.view.index


@dataclass
class Frame:
    """One frame of one view. The object is reused from frame to frame: copy what has to last.

    camera is f64 in the axes of `planet` (an entity). cut: there is no usable last frame (the first one, a teleport).
    settings: as in Setup.
    """

    world: World
    planet: int
    size: tuple[int, int]
    camera: CameraState
    sun: SunState
    time_s: float = 0.0
    dt_s: float = 0.0
    frame_index: int = 0
    planet_index: int = 0
    view: View = field(default_factory=View)
    """Which view it is a frame of, and what systems keep for that: `frame.view.state(self, factory)`."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    cut: bool = True
    settling: bool = False
    """Nobody looks at this frame: what refines over frames may take its time and finish now."""
    ev100: float | None = None
    """A view's own fixed exposure, which goes before the scene's Exposure; None: the scene decides."""
    one_shot: bool = False
    """A picture by itself: it may show what was settled for this very moment, and nothing else of earlier frames."""
    exact: bool = False
    """Somebody reads arrays of this frame: pixels are sampled in their centres."""
    still: bool = False
    """Shows what the last frame showed: same camera, light, time and settings, nothing moves, streams or refines."""
    frozen: bool = False
    """DebugView.freeze: what is selected and culled stays as it is, whatever the camera does."""
    host_depth: tuple[float, float] | None = None
    """(a, b): a host's depth buffer, which the picture is to share, holds a + b / z; None: it has none, or not now."""
    backdrop: bool = True
    """Whether the sun's disc and stars are drawn; not in a picture that is to stand before somebody else's."""
    star_axes: NDArray[np.float64] | None = None
    """(3, 3): planet = star_axes @ inertial, where somebody else says how the stars stand; None: the scene's clock."""
    jitter_px: tuple[float, float] = (0.0, 0.0)
    """Where in its pixel, from its centre (x to the right, y up), this frame samples the scene. `System.begin` sets it;
    the frame block's projection holds it, so all that is drawn or reconstructed from depth agrees. `camera` does not:
    culling by it needs a margin of a pixel."""
    squares: int | None = None
    """Which squares of a chessboard this frame shades, where every second pixel is: 0 or 1, by turns. None: all, as
    where a picture keeps still or stands for itself."""
    left_out: set[str] = field(default_factory=set)
    """Surfaces of which it shades those squares alone, "terrain" and "ocean": who shades them says so in `update`."""

    @property
    def view_index(self) -> int:
        """The view's index."""
        return self.view.index


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
    again. What changes for one view alone is in `structure_of`."""
    moving: bool | None = None
    """Whether what it shows changed since the last frame although no component's field, camera, light or time did. None
    stands for no in the library's own systems and for yes in a game's, which says False where that is true."""

    def __init_subclass__(cls, **kwargs: Any) -> None:
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

    def settled(self) -> bool:
        """Whether the last frame shows all that this system will come to show: nothing streams, refines or adapts."""
        return True

    def progress(self) -> float:
        """How much of what `settled` waits for is done, 0..1."""
        return 1.0 if self.settled() else 0.0

    def refining(self) -> str:
        """What is still being made of what the last frame showed, in two or three words for people; "" for nothing.
        Asked every frame while somebody looks: never waits for the GPU."""
        return ""

    def statistics(self) -> dict[str, int]:
        """Counts of the last frame (cells, vertices, triangles) for overlays and benches. May read the GPU."""
        return {}

    def release(self) -> None:
        """Let go of what setup made; the caller then releases the GL scope, and what is kept for views. A system may be
        set up again afterwards."""
