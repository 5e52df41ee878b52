"""Controls that are bound while flying: what is caught, who shares a key, and a file that is never lost."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from desk_kit import Desk

from planetfall.app.controls import keep_controls
from planetfall.engine.input import InputState, KeyEvent, MouseButton, MouseMove, PadAxis, PadButton, Wheel
from planetfall.engine.settings import PresetError
from planetfall.systems.flight import Binding, Catch, load_controls, rebind, rivals


def caught(action: str, *frames: Any, sign: float = 1.0) -> tuple[str, str]:
    """The binding that these frames of events give, as text, and how it ended."""
    state, catch = InputState(), Catch(action, sign)
    for events in frames:
        state.advance(events)
        found = catch.take(state)
        if catch.ended:
            return str(found or ""), catch.ended
    return "", catch.ended


@pytest.mark.parametrize(
    ("action", "frames", "wanted"),
    [
        ("pause", [[KeyEvent("k", True)]], "k"),
        ("pause", [[KeyEvent("left_ctrl", True)], [KeyEvent("k", True)]], "ctrl+k"),
        ("forward", [[KeyEvent("left_shift", True), KeyEvent("k", True)]], "k"),
        ("boost", [[KeyEvent("left_shift", True)], [], [KeyEvent("left_shift", False)]], "left_shift"),
        ("fly_to", [[MouseButton("middle", True, 5, 5)]], "mouse:middle"),
        ("speed", [[Wheel(0, -1)]], "-wheel"),
        ("look_right", [[MouseMove(0, 0, 50, 3)], [MouseMove(0, 0, 50, 3)]], "mouse:x"),
        ("look_up", [[MouseMove(0, 0, 3, -90)]], "-mouse:y"),
        ("walk", [[PadButton("x", True)]], "pad:x"),
        ("forward", [[], [PadAxis("left_y", -0.9)]], "-pad:left_y"),
        ("leave", [[KeyEvent("escape", True)]], "escape"),
    ],
)
def test_the_next_thing_pressed_is_caught(action: str, frames: list[Any], wanted: str) -> None:
    assert caught(action, *frames) == (wanted, "bound")


def test_what_is_no_answer() -> None:
    assert caught("pause", [KeyEvent("escape", True)]) == ("", "cancelled")
    assert caught("pause", [KeyEvent("delete", True)]) == ("", "cleared")
    assert caught("forward", [MouseMove(0, 0, 500, 0)], [PadAxis("left_x", 0.3)]) == ("", "")
    assert caught("forward", [PadAxis("left_trigger", 1.0)], []) == ("", "")  # held since before
    assert caught("forward", [KeyEvent("k", True)], sign=-1.0) == ("-k", "bound")
    assert caught("pause", [KeyEvent("k", True)], sign=-1.0) == ("k", "bound")  # one way only


def test_rebinding_keeps_the_others() -> None:
    controls = load_controls()
    up = controls.bindings["up"]
    rebind(controls, "up", up[0], Binding("key", "k"))
    assert list(map(str, controls.bindings["up"])) == ["k", *map(str, up[1:])]
    rebind(controls, "up", None, Binding("key", "k"))  # twice is once
    assert [str(b) for b in controls.bindings["up"]].count("k") == 1
    rebind(controls, "up", Binding("key", "k"), None)
    assert controls.bindings["up"] == up[1:]


def test_rivals_are_named_and_what_is_meant_is_not() -> None:
    controls = load_controls()
    assert rivals(controls) == {}  # a click that drags the globe catches the mouse elsewhere
    controls.bind("walk", "w")
    found = rivals(controls)
    assert found["walk"] == {Binding("key", "w"): ("forward",)} and "walk" in found["forward"][Binding("key", "w")]
    controls.bind("walk", "shift+w")
    assert rivals(controls) == {}  # Shift W is not W


def test_a_file_is_kept_beside_before_it_is_replaced(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "controls.toml"
    controls = load_controls()
    controls.bind("pause", "k")
    keep_controls(controls, path, keep_old=True)
    assert load_controls(path).bindings["pause"] == (Binding("key", "k"),)
    path.write_text("# mine\nnonsense = [")
    keep_controls(controls, path, keep_old=True)
    assert (path.parent / "controls.toml.old").read_text() == "# mine\nnonsense = ["
    assert load_controls(path).bindings["pause"] == (Binding("key", "k"),)
    (path.parent / "controls.toml.old").unlink()
    (path.parent / "controls.toml.old").mkdir()
    with pytest.raises(PresetError, match=r"can't be kept as controls\.toml\.old"):
        keep_controls(controls, path, keep_old=True)
    assert {entry.name for entry in path.parent.iterdir()} == {"controls.toml", "controls.toml.old"}


@pytest.fixture
def desk(gpu: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("PLANETFALL_CONFIG", str(tmp_path))
    made = Desk(gpu)
    made.app.time_runs = False
    yield made
    made.release()


@pytest.mark.gpu
def test_a_key_is_changed_by_clicks_and_kept(desk: Desk, tmp_path: Path) -> None:
    app, page = desk.app, desk.interface.settings.controls
    desk.press("f3")
    desk.click("Controls")
    desk.frames(2)
    desk.click("forward w")
    assert page.waiting
    speed = app.ship.speed_m_s
    desk.press("k")
    assert not page.waiting and app.ship.speed_m_s == speed, "the key was bound and moved nothing"
    assert app.controls.bindings["forward"][0] == Binding("key", "k")
    assert load_controls(tmp_path / "controls.toml").bindings["forward"][0] == Binding("key", "k")
    desk.frames(2)
    desk.click("+ roll")
    desk.press("k")  # which is forward's now
    assert Binding("key", "k") in app.controls.bindings["roll"]
    desk.frames(2)
    desk.click("take it from there")
    assert Binding("key", "k") not in app.controls.bindings["forward"]
    desk.frames(2)
    desk.click("reset forward")
    assert app.controls.bindings["forward"] == load_controls().bindings["forward"]
    desk.click("+ up")
    desk.press("escape")
    assert not page.waiting and app.shown.panels, "Escape gave up waiting, and nothing else"
    assert app.controls.bindings["up"] == load_controls().bindings["up"]
    desk.frames(2)
    desk.click("reset all controls")
    assert app.controls.table() == load_controls().table()
    assert desk.interface.hud(app, helps=True, errors=()).controls[-1] == ("F3, Controls", "change any of these")
