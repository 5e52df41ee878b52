"""The flight's app with its interface on an offscreen window: hands for tests that click and drag."""

from __future__ import annotations

from typing import Any

import numpy as np

import planetfall as pf
from planetfall.app.interface import FlightInterface
from planetfall.app.window import FlightApp
from planetfall.engine.input import InputEvent, InputState, KeyEvent, MouseButton, MouseMove

SIZE = (640, 480)
WATCHED = {"checkbox", "button", "begin_combo", "selectable", "slider_float", "begin_tab_item", "collapsing_header"}


class OffscreenWindow:
    """A window as the app and the interface want it, on a framebuffer of the headless context."""

    def __init__(self, ctx: Any) -> None:
        self.ctx = ctx
        self.events: list[InputEvent] = []
        self.state = InputState()
        self.framebuffer = ctx.simple_framebuffer(SIZE, 4)
        self.size = self.framebuffer_size = SIZE
        self.pixel_ratio = self.ui_scale = 1.0
        self.clipboard = ""
        self.mouse_exclusivity = self.fullscreen = self.should_close = False

    def poll(self) -> InputState:
        self.state.advance(self.events)
        self.events = []
        return self.state

    def swap(self) -> None: ...

    def request_close(self) -> None:
        self.should_close = True


class Watching:
    """ImGui that remembers where its items are."""

    def __init__(self, imgui: Any, boxes: dict[str, tuple[float, float]]) -> None:
        self._imgui, self._boxes = imgui, boxes

    def __getattr__(self, name: str) -> Any:
        function = getattr(self._imgui, name)
        if name not in WATCHED:
            return function

        def call(label: str, *arguments: Any) -> Any:
            result = function(label, *arguments)
            low, high = self._imgui.get_item_rect_min(), self._imgui.get_item_rect_max()
            if name != "begin_combo" or not result:  # an open list is the last item then
                shown = label.rsplit("###", maxsplit=1)[-1].rsplit("  ", maxsplit=1)[-1]  # without an icon
                self._boxes[shown] = ((low.x + high.x) / 2, (low.y + high.y) / 2)
            return result

        return call


class Desk:
    """The app at a small size, and hands for it. scene: earth, if left out; released with the desk."""

    def __init__(self, gpu: Any, scene: pf.Scene | None = None, overrides: Any = None) -> None:
        self.scene = pf.load_scene("earth") if scene is None else scene
        self.scene.environment[pf.Exposure].mode = "fixed"  # pictures that can be compared
        self.window = OffscreenWindow(gpu.ctx)
        self.made: list[pf.Renderer] = []
        self.interface = FlightInterface(self.window, self.scene, gpu)  # type: ignore[arg-type]
        self.app = FlightApp(
            self.window, self.make("low", overrides or {}), self.scene, pf.view("orbit", self.scene.planet),
            interface=self.interface, make_renderer=self.make, quality="low",
            overrides=overrides,
        )  # fmt: skip
        self.app.shown.help = self.app.shown.numbers = False
        self.boxes: dict[str, tuple[float, float]] = {}
        draw = self.interface.settings.draw
        self.interface.settings.draw = lambda imgui, app: draw(Watching(imgui, self.boxes), app)  # type: ignore[method-assign]

    def make(self, quality: str, overrides: Any) -> pf.Renderer:
        self.made.append(pf.Renderer(self.scene, SIZE, quality, overrides, ctx=self.window.ctx))
        return self.made[-1]

    def frames(self, count: int = 1) -> None:
        for _ in range(count):
            self.app.frame()
            assert self.app.shown.error == ""

    def rest(self) -> None:
        """What streams or refines is there, and what a frame still has to do after it is done."""
        self.app.renderer.settle(self.app.camera, self.app.time_s)
        self.frames(3)

    def press(self, key: str) -> None:
        self.window.events += [KeyEvent(key, True), KeyEvent(key, False)]  # type: ignore[arg-type]
        self.frames(4)

    def click(self, label: str) -> None:
        x, y = self.boxes[label]
        self.window.events = [MouseMove(x, y, 0, 0)]
        self.frames(2)
        for down in (True, False):
            self.window.events = [MouseButton("left", down, x, y)]
            self.frames()
        self.frames()

    def pixels(self) -> np.ndarray:
        data = self.window.framebuffer.read(components=3)
        return np.frombuffer(data, np.uint8).reshape(SIZE[1], SIZE[0], 3)[::-1].astype(int)

    def picture(self) -> np.ndarray:
        """Without the interface."""
        panels, self.app.shown.panels = self.app.shown.panels, False
        message, self.app.shown.message = self.app.shown.message, ""
        self.frames()
        self.app.shown.panels, self.app.shown.message = panels, message
        return self.pixels()

    def ran(self) -> set[str]:
        return {report.name for report in self.app.renderer.passes() if report.ran}

    def planned(self) -> set[str]:
        """Passes of the plan, whether or not the last frame was the same picture again."""
        reports = self.app.renderer.passes()
        return {report.name for report in reports if "culled" not in (report.skipped_why or "")}

    def release(self) -> None:
        self.interface.release()
        self.app.renderer.gpu.leave(self.window.framebuffer)
        self.app.renderer.release()
        self.window.framebuffer.release()
        self.scene.release()


def turn(desk: Desk, heading: str, field: str, value: Any) -> None:
    """What the widget of a knob does."""
    bench = desk.interface.settings.bench
    part = bench.store.parts()[heading]
    before = getattr(part, field)
    setattr(part, field, value)
    assert bench.made(heading, [(field, before, value)]) == ""
    bench.history.seal()
