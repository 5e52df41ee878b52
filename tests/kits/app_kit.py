"""Stand-ins for the window and the renderer of a flight, and key presses for them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from planetfall.app.window import FlightApp
from planetfall.engine.input import InputEvent, InputState, KeyEvent
from planetfall.systems.debug import NAMED_VIEWS


class FakeWindow:
    """A window that is told its events."""

    def __init__(self) -> None:
        self.events: list[InputEvent] = []
        self.state = InputState()
        self.mouse_exclusivity = self.fullscreen = self.should_close = False
        self.framebuffer_size = (64, 36)
        self.framebuffer = object()
        self.swaps = 0
        self.frames_left = 10**9

    def poll(self) -> InputState:
        self.state.advance(self.events)
        self.events = []
        return self.state

    def swap(self) -> None:
        self.swaps += 1
        self.should_close = self.should_close or self.swaps >= self.frames_left

    def request_close(self) -> None:
        self.should_close = True


class FakeRenderer:
    """Remembers what it was asked to draw."""

    def __init__(self) -> None:
        self.drawn: list[tuple[Any, float, Any]] = []
        self.reloads = self.invalidated = 0
        self.changed: list[str] = []
        self.stats = {"cells": 3}
        self.size = (64, 36)
        self.exposure = 14.0
        self.shown: Any = None
        self.field: Any = None
        self.fails: Exception | None = None
        self.main = ""
        self.released = False
        self.shader_errors: list[Any] = []
        specs = {view.resource: None for view in NAMED_VIEWS.values()}
        analysis = SimpleNamespace(model=SimpleNamespace(specs=specs))
        self.graph = SimpleNamespace(invalidate_persistent=self._invalidate, analysis=analysis)

    def _invalidate(self) -> None:
        self.invalidated += 1

    def release(self) -> None:
        self.released = True

    def render_to(
        self, framebuffer: Any, camera: Any, time_s: float, sun: Any = None, viewport: Any = None, dt_s: float = 0.0
    ) -> None:
        assert viewport == (0, 0, 64, 36)
        if self.fails is not None:
            raise self.fails
        self.drawn.append((camera, time_s, sun))

    def render(
        self, camera: Any, time_s: float, sun: Any = None, outputs: Any = ("color",), dt_s: float | None = None
    ) -> dict[str, Any]:
        return {"color": np.zeros((36, 64, 3), np.uint8)}

    def try_again(self) -> None: ...

    def height_field(self) -> Any:
        return self.field

    def pick(self, camera: Any, x: float, y: float) -> Any:
        return self.shown

    def reload_shaders(self) -> list[str]:
        self.reloads += 1
        return self.changed


def app_of(scene: Any, **more: Any) -> tuple[FlightApp, Any, Any]:
    window, renderer = FakeWindow(), FakeRenderer()
    return FlightApp(window, renderer, scene, **more), window, renderer  # type: ignore[arg-type]


def press(window: FakeWindow, *keys: str) -> None:
    for key in keys:
        window.events += [KeyEvent(key, True), KeyEvent(key, False)]
