"""What keys, windows and pages need of a flight: protocols that `FlightApp` and windows of `engine.hosts` fulfil."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from .journey import Journey, Journeying
from .shown import Shown

if TYPE_CHECKING:
    import moderngl

    from ..camera.flights import ScenePath
    from ..engine.hosts.monitors import Monitor
    from ..engine.input import InputState
    from ..render.renderer import Renderer
    from ..systems.flight import Controls
    from .pace import Pace

__all__ = ["Flight", "FlightWindow", "Interface", "RendererMaker"]

RendererMaker = Callable[[str, Mapping[str, Any]], "Renderer"]
"""Makes a renderer on the window's context: (quality, overrides)."""


class FlightWindow(Protocol):
    """What the flight and its pages need of a window. One without monitors, monitor, vsync, size, pixel_ratio or
    minimised will do for a flight without pages."""

    @property
    def mouse_exclusivity(self) -> bool: ...
    @mouse_exclusivity.setter
    def mouse_exclusivity(self, value: bool, /) -> None: ...
    @property
    def fullscreen(self) -> bool: ...
    @fullscreen.setter
    def fullscreen(self, value: bool, /) -> None: ...
    @property
    def vsync(self) -> bool: ...
    @vsync.setter
    def vsync(self, value: bool, /) -> None: ...
    @property
    def monitor(self) -> int: ...
    @monitor.setter
    def monitor(self, value: int, /) -> None: ...
    @property
    def should_close(self) -> bool: ...
    @property
    def framebuffer(self) -> moderngl.Framebuffer: ...
    @property
    def framebuffer_size(self) -> tuple[int, int]: ...
    @property
    def pixel_ratio(self) -> float: ...
    @property
    def monitors(self) -> tuple[Monitor, ...]: ...

    def poll(self) -> InputState: ...
    def swap(self) -> None: ...
    def request_close(self) -> None: ...


class Flight(Journeying, Protocol):
    """A flight as its keys, windows and pages know it; `FlightApp` says what each of these does."""

    window: FlightWindow
    shown: Shown
    controls: Controls
    journey: Journey
    pace: Pace
    playing: ScenePath | None
    played_s: float
    time_runs: bool
    time_speed: float

    @property
    def fov_y_deg(self) -> float: ...
    @fov_y_deg.setter
    def fov_y_deg(self, value: float, /) -> None: ...
    @property
    def debug_view(self) -> str: ...
    @debug_view.setter
    def debug_view(self, value: str, /) -> None: ...
    @property
    def looking(self) -> bool: ...
    @property
    def photographing(self) -> bool: ...
    @property
    def can_change_quality(self) -> bool: ...
    @property
    def latitude_longitude_altitude(self) -> tuple[float, float, float]: ...

    def to_start(self) -> None: ...
    def go_to(self, name: str) -> None: ...
    def fly_to_place(self, latitude_deg: float, longitude_deg: float, altitude_m: float = ...) -> None: ...
    def fly_to_pixel(self, place: tuple[float, float] | None = None) -> None: ...
    def fly_to_planet(self, name: str) -> None: ...
    def play(self, name: str | None) -> None: ...
    def set_quality(self, quality: str, overrides: Mapping[str, Any] | None = None) -> None: ...
    def reload_shaders(self) -> None: ...
    def save_picture(self, folder: Path | str = ..., suffix: str = ...) -> Path | None: ...


class Interface(Protocol):
    """What the app needs of a user interface; without one it flies all the same."""

    def begin(self, state: InputState, app: Flight, dt_s: float) -> None:
        """Take the frame's events; whatever the interface uses is consumed from `state`."""

    def draw(self, app: Flight) -> None:
        """Draw over the picture, into the bound framebuffer."""

    def release(self) -> None: ...
