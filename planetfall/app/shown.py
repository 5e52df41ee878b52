"""What the flight and its interface say to each other: what is shown, and the interface's protocol."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

if TYPE_CHECKING:
    from ..engine.input import InputState
    from ..render.renderer import Renderer
    from .window import FlightApp

__all__ = ["Interface", "RendererMaker", "Shown"]

RendererMaker = Callable[[str, Mapping[str, Any]], "Renderer"]
"""Makes a renderer on the window's context: (quality, overrides)."""


class Interface(Protocol):
    """What the app needs of a user interface; without one it flies all the same."""

    def begin(self, state: InputState, app: FlightApp, dt_s: float) -> None:
        """Take the frame's events; whatever the interface uses is consumed from `state`."""

    def draw(self, app: FlightApp) -> None:
        """Draw over the picture, into the bound framebuffer."""

    def release(self) -> None: ...


@dataclass
class Shown:
    """What the interface shows of the app, and may change. message fades; errors stay while they last."""

    help: bool = True
    numbers: bool = True
    panels: bool = False
    journey: bool = False
    message: str = ""
    error: str = ""
    shader_errors: tuple[str, ...] = ()
    stats: dict[str, int] = field(default_factory=dict)
