"""The window of F4, clicked through synthetic events, with the real renderer."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import desk_kit
import pytest
from desk_kit import Desk, Watching

from planetfall.app import journey_window as app_journey_window
from planetfall.capture.photos import PhotoPlan
from planetfall.engine.input import KeyEvent
from planetfall.systems.capture import read_png_settings

pytestmark = pytest.mark.gpu


@pytest.fixture
def desk(gpu: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    monkeypatch.setenv("PLANETFALL_CONFIG", str(tmp_path / "settings"))
    more = {"radio_button", "small_button"}
    monkeypatch.setattr(desk_kit, "WATCHED", desk_kit.WATCHED | more)
    monkeypatch.setattr(app_journey_window, "TOP_PX", 5.0)  # all of it is seen in the small window
    desk = Desk(gpu)
    draw = desk.interface.journey.draw
    desk.interface.journey.draw = lambda imgui, app: draw(Watching(imgui, desk.boxes), app)  # type: ignore[method-assign]
    yield desk
    desk.release()


def test_everything_in_the_window_does_what_it_says(desk: Desk, tmp_path: Path) -> None:
    app = desk.app
    desk.window.events = [KeyEvent("f4", True), KeyEvent("f4", False)]
    desk.frames(3)
    assert app.shown.journey
    desk.click("keep this place")
    assert app.journey.places.names(app.scene) == ["earth"]
    assert app.scene.sun.mode != "epoch"
    desk.click("moves the sun")
    assert app.scene.sun.mode == "epoch"
    desk.click("globe")
    assert app.pilot.mode == "orbit"
    desk.click("fly there")
    assert app.pilot.route is not None
    desk.click("go")
    assert app.pilot.route is None and app.scene.sun.mode != "epoch"
    desk.click("forget")
    assert app.journey.places.names() == []
    app.journey.photo, app.journey.folder = PhotoPlan((320, 100), 1, 256), tmp_path
    app.journey.start_photo()
    size = app.renderer.size
    for _ in range(9):
        app.frame()
    (file,) = tmp_path.glob("*.png")
    assert read_png_settings(file)["size"] == [320, 100] and not app.photographing
    assert app.renderer.size == size
    desk.window.events = [KeyEvent("escape", True), KeyEvent("escape", False)]
    desk.frames(1)
    assert not app.shown.journey and not desk.window.should_close
