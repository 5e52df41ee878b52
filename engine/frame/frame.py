"""View: one picture of a scene, and the owner of what systems keep for it from frame to frame. Frame: one frame of it
as systems get it, and the records that it holds."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol, TypeVar, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from ..settings import Settings
from ..space import CameraState
from ..world import MissingError, World
from .proxy import Proxy
from .seen import Seen
from .snapping import SnapAhead

__all__ = ["Frame", "SunState", "View", "ViewInfo"]

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class SunState:
    """The sun as one frame sees it, in planet axes.

    direction: (3,) f64, unit, from the planet to the sun. irradiance: (3,) f64 at the planet, in the scene's unit at
    the wavelengths that light is carried at (`engine/wavelengths.py`). angular_radius_rad: half the angle of the disc.
    """

    direction: NDArray[np.float64]
    irradiance: NDArray[np.float64]
    angular_radius_rad: float


@runtime_checkable
class _Releasable(Protocol):
    def release(self) -> None: ...


class View:
    """One picture of a scene. index: 0 is the renderer's own, further ones take the lowest that is free.

    seen, snap and proxy are what all systems know of it. What is one system's own it keeps with `state`; it is released
    with the view, or when the system says `forget`.
    """

    def __init__(self, index: int = 0) -> None:
        self.index = index
        self._kept: dict[int, tuple[object, Any]] = {}
        self._begin()

    def _begin(self) -> None:
        self.seen = Seen()
        """What it may show of its planet."""
        self.snap = SnapAhead()
        """The next snap of its proxy."""
        self.latest: Frame | None = None
        """Its last frame, or the one that is being drawn; None before the first."""
        self.structure = 0
        """Raised by systems when passes or the sizes of resources change that they declare for this view alone: its
        frame graph is compiled again."""
        self.placed: Proxy | None = None
        """Its camera's proxy, or None before the first frame."""
        self.planets_px: tuple[int, int, int, int] | None = None
        """Where its picture shows other planets in this frame: (x, y, width, height); None: nowhere."""

    @property
    def frame(self) -> Frame:
        """The frame that its passes draw; MissingError before the first."""
        if self.latest is None:
            raise MissingError(f"view {self.index} has no frame yet")
        return self.latest

    @property
    def proxy(self) -> Proxy:
        """Its camera's proxy; MissingError before the first frame."""
        if self.placed is None:
            raise MissingError(f"view {self.index} has no proxy yet: ProxySystem places it in the view's first frame")
        return self.placed

    def state(self, owner: object, factory: Callable[[], T]) -> T:
        """What `owner` keeps for this view; made by `factory` when it is asked for first. One state an owner."""
        found = self._kept.get(id(owner))
        if found is None:
            found = self._kept[id(owner)] = (owner, factory())  # the owner is held, so that its id stays its own
        return found[1]

    def found(self, owner: object) -> Any:
        """What `owner` keeps for this view, or None."""
        found = self._kept.get(id(owner))
        return None if found is None else found[1]

    def forget(self, owner: object) -> None:
        """Release what that owner keeps."""
        _release(self._kept.pop(id(owner), None))

    def release(self) -> None:
        """Release what everybody keeps; the view may be used again, and is then as new."""
        while self._kept:
            _release(self._kept.popitem()[1])
        self._begin()

    def __repr__(self) -> str:
        return f"<View {self.index}>"


def _release(kept: tuple[object, object] | None) -> None:
    if kept is not None and isinstance(kept[1], _Releasable):
        kept[1].release()


@dataclass
class ViewInfo:
    """The view that a frame graph is declared for: size in pixels (width, height), what is asked of it.

    planet: the entity of the planet that its camera is on.
    """

    size: tuple[int, int]
    view: View = field(default_factory=View)
    outputs: frozenset[str] = frozenset({"color"})
    planet: int = 0


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
    view: View = field(default_factory=View)
    """Which view it is a frame of, and what systems keep for that: `frame.view.state(self, factory)`."""
    settings: Settings = field(default_factory=dict)
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
    """(3, 3): planet = star_axes @ inertial, from who draws several planets or else the light system; None: stars are
    fixed to the planet."""
    jitter_px: tuple[float, float] = (0.0, 0.0)
    """Where in its pixel, from its centre (x to the right, y up), this frame samples the scene. `System.begin` sets it;
    the frame block's projection holds it, so all that is drawn or reconstructed from depth agrees. `camera` does not:
    culling by it needs a margin of a pixel."""
    checkerboard: int | None = None
    """Which squares of a checkerboard this frame shades, where every second pixel is: 0 or 1, by turns. None: all, as
    where a picture keeps still or stands for itself."""
    checkered: set[str] = field(default_factory=set)
    """Surfaces of which it shades those squares alone, "terrain" and "ocean": who shades them says so in `update`."""

    def __post_init__(self) -> None:
        self.view.latest = self

    @property
    def pixel_rad(self) -> float:
        """The angle of a pixel at the middle of the view, from row to row."""
        return self.camera.pixel_rad(self.size[1])

    @property
    def at_once(self) -> bool:
        """Whether nothing may wait for later frames: the picture stands for itself, or there is no last one."""
        return self.cut or self.settling or self.one_shot

    @property
    def goes_on(self) -> bool:
        """Whether it is one of a flight, which comes to need as much room for what is prepared as for what is drawn.
        Made early, and together, that costs one compilation of the graph; bit by bit it costs three."""
        return int(self.settings.get("proxy.ahead_frames", 0)) > 0 and not (self.settling or self.one_shot)
