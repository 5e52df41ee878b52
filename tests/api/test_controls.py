"""Controls as data: bindings, the user's file, the help, gamepads from glfw and pyglet."""

from __future__ import annotations

import random
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from planetfall.engine.hosts.gamepad import GamepadReader
from planetfall.engine.input import (
    PAD_AXES,
    Focus,
    InputEvent,
    InputState,
    KeyEvent,
    MouseButton,
    MouseMove,
    PadAxis,
    PadButton,
    Wheel,
)  # fmt: skip
from planetfall.engine.settings import PresetError
from planetfall.systems.flight import ACTIONS, CONTROLS_FILE, Controls, controls_or_defaults, load_controls, steering
from planetfall.systems.flight.bindings import Binding, BindingError


def state_of(*events: InputEvent) -> InputState:
    state = InputState()
    state.advance(events)
    return state


@pytest.mark.parametrize("text", ["w", "-s", "left_shift", "wheel", "-wheel", "mouse:left", "mouse:x", "-mouse:y",
                                  "pad:a", "-pad:left_y", "shift+v", "-ctrl+f1", "pad:dpad_up"])  # fmt: skip
def test_bindings_are_written_as_they_are_read(text: str) -> None:
    assert str(Binding.parse(text)) == text


@pytest.mark.parametrize("text", ["", "-", "ww", "mouse:wheel", "pad:q", "shift+", "hyper+v", "pad:", "w:x"])
def test_bindings_that_name_nothing_are_refused(text: str) -> None:
    with pytest.raises(BindingError, match="expected a key"):
        Binding.parse(text)


def test_every_action_has_a_default_and_nothing_else_is_bound() -> None:
    controls = load_controls()
    assert set(controls.bindings) == set(ACTIONS) and all(controls.bindings.values())
    taken: dict[str, list[str]] = {}
    for action, bound in controls.bindings.items():
        for binding in bound:
            if binding.kind in ("key", "pad_button"):
                taken.setdefault(str(binding).lstrip("-"), []).append(action)
    assert {key: actions for key, actions in taken.items() if len(actions) > 1} == {}


def test_keys_mouse_and_gamepad_steer_alike() -> None:
    controls = load_controls()
    for event in (KeyEvent("w", True), PadAxis("left_y", -1.0)):
        assert steering(controls, state_of(event), looking=True, dt_s=0.1).flight.forward == 1.0
    both = state_of(KeyEvent("w", True), KeyEvent("s", True))
    assert steering(controls, both, looking=True, dt_s=0.1).flight.forward == 0.0
    wish = steering(controls, state_of(MouseMove(0, 0, 10, -5)), looking=True, dt_s=0.1).flight
    assert wish.look_yaw_rad == pytest.approx(0.022) and wish.look_pitch_rad == pytest.approx(0.011)
    free = steering(controls, state_of(MouseMove(0, 0, 10, -5)), looking=False, dt_s=0.1).flight
    assert free.look_yaw_rad == free.look_pitch_rad == 0.0
    stick = steering(controls, state_of(PadAxis("right_x", 1.0)), looking=False, dt_s=0.1).flight
    assert stick.look_yaw_rad == pytest.approx(0.18)
    controls.invert_y = True
    turned = steering(controls, state_of(MouseMove(0, 0, 0, -5)), looking=True, dt_s=0.1).flight
    assert turned.look_pitch_rad == pytest.approx(-0.011)


def test_the_globe_hears_of_places_and_ways_in_the_picture() -> None:
    controls = load_controls()
    events = (MouseMove(150.0, 25.0, 10.0, -5.0), MouseButton("left", True, 150.0, 25.0), Wheel(0, 2))
    orbit = steering(controls, state_of(*events), looking=False, dt_s=0.1, size=(200.0, 100.0)).orbit
    assert orbit.pointer == pytest.approx((0.5, 0.5)) and orbit.pointer_before == pytest.approx((0.4, 0.4))
    assert orbit.drag and not orbit.tilt and orbit.zoom_steps == 2.0 and orbit.aspect == 2.0


def test_dead_zones_grow_from_nothing() -> None:
    controls = Controls(dead_zone=0.2)
    assert [controls.with_dead_zone(v) for v in (0.0, 0.2, -0.19)] == [0.0, 0.0, 0.0]
    assert controls.with_dead_zone(0.2 + 1e-6) < 1e-5
    assert controls.with_dead_zone(1.0) == 1.0 and controls.with_dead_zone(-1.0) == -1.0
    assert controls.with_dead_zone(0.6) == pytest.approx(0.5)


def test_a_key_with_shift_is_another_key() -> None:
    controls = load_controls()
    plain, shifted = state_of(KeyEvent("v", True)), state_of(KeyEvent("left_shift", True), KeyEvent("v", True))
    assert controls.pressed("debug_view", plain) and not controls.pressed("debug_off", plain)
    assert controls.pressed("debug_off", shifted) and not controls.pressed("debug_view", shifted)
    boosted = state_of(KeyEvent("left_shift", True), KeyEvent("w", True))
    assert controls.value("forward", boosted) == 1.0 and controls.held("boost", boosted)


def test_the_users_file_changes_single_actions(tmp_path: Path) -> None:
    file = tmp_path / "controls.toml"
    file.write_text('bind.forward = ["up", "-down"]\nbind.roll = []\n[gamepad]\ndead_zone = 0.3\n')
    controls, problem = controls_or_defaults(file)
    assert problem == "" and controls.dead_zone == 0.3
    assert controls.value("forward", state_of(KeyEvent("down", True))) == -1.0
    assert controls.value("forward", state_of(KeyEvent("w", True))) == 0.0
    assert controls.value("right", state_of(KeyEvent("d", True))) == 1.0
    named = {what: keys for keys, what in controls.help()}
    assert named[ACTIONS["forward"]] == "Up, Down" and ACTIONS["roll"] not in named
    assert controls_or_defaults(tmp_path / "none.toml")[0].table() == load_controls().table()


def test_remapped_controls_are_saved_and_come_back(tmp_path: Path) -> None:
    controls = load_controls()
    controls.bind("walk", "k", "pad:b")
    controls.invert_y = True
    file = tmp_path / "new" / "controls.toml"
    controls.save(file)
    assert load_controls(file).table() == controls.table()
    assert "forward" not in file.read_text()  # only what differs
    assert [f.name for f in file.parent.iterdir()] == ["controls.toml"]
    with pytest.raises(PresetError, match="unknown action; did you mean 'walk'"):
        controls.bind("wlak", "k")
    with pytest.raises(PresetError, match=r"bind\.walk: 'kk' is no key"):
        controls.bind("walk", "kk")
    (tmp_path / "file").write_text("")
    with pytest.raises(PresetError, match="can't be made"):
        controls.save(tmp_path / "file" / "controls.toml")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("bind.forwrad = ['w']", "unknown action; did you mean 'forward'"),
        ("bind.forward = 'w'", "expected a list"),
        ("bind.forward = ['ww']", "'ww' is no key"),
        ("bind = 3", "bind: expected a table"),
        ("keys.forward = ['w']", "keys: expected a table"),
        ("mouse.invert_y = 1", "true or false"),
        ("gamepad.dead_zone = 2.0", "from 0 to 0.9, found 2.0"),
        ("gamepad.dead_zone = nan", "found nan"),
        ("gamepad.dead = 0.1", "unknown key"),
        ("bind.forward = [", "not valid TOML"),
    ],
)
def test_a_wrong_file_says_what_is_wrong_and_is_left_alone(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "controls.toml"
    file.write_text(text)
    controls, problem = controls_or_defaults(file)
    assert said in problem and str(file) in problem and "default controls are used" in problem
    assert controls.table() == load_controls().table() and file.read_text() == text


def test_two_hundred_damaged_files_never_crash(tmp_path: Path) -> None:
    whole, file, rng = CONTROLS_FILE.read_bytes(), tmp_path / "controls.toml", random.Random(5)
    good = 0  # damage inside of comments goes unnoticed
    for _ in range(200):
        data = bytearray(whole)
        for _ in range(rng.randint(1, 8)):
            data = data or bytearray(b"x")
            at = rng.randrange(len(data))
            kind = rng.randrange(4)
            if kind == 0:
                data[at] = rng.randrange(256)
            elif kind == 1:
                del data[at : at + rng.randint(1, 200)]
            elif kind == 2:
                data[at:at] = bytes(rng.randrange(256) for _ in range(rng.randint(1, 20)))
            else:
                data = data[:at] + data[rng.randrange(len(data)) :] or bytearray(b"x")
        file.write_bytes(data)
        controls, problem = controls_or_defaults(file)
        good += problem == ""
        assert controls.help() and file.read_bytes() == bytes(data)
    assert good < 200


# gamepads


def test_changes_of_a_gamepad_become_events() -> None:
    sent: list[InputEvent] = []
    reader, axes = GamepadReader(sent.append), dict.fromkeys(PAD_AXES, 0.0)
    reader.read((axes, set()))
    assert sent == []
    reader.read(({**axes, "left_x": 0.5}, {"a"}))
    reader.read(({**axes, "left_x": 0.501}, {"a"}))  # trembles
    assert sent == [PadAxis("left_x", 0.5), PadButton("a", True)]
    state = state_of(*sent)
    assert state.pad_axis("left_x") == 0.5 and state.pad_held == state.pad_pressed == {"a"}
    sent.clear()
    reader.read(None)  # pulled out
    assert sent == [PadAxis("left_x", 0.0), PadButton("a", False)]
    state.advance([Focus(False)])
    assert state.pad_axis("left_x") == 0.0 and not state.pad_held


def test_glfw_gamepads_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    import glfw

    from planetfall.engine.hosts import with_glfw

    buttons = [0] * 15
    buttons[glfw.GAMEPAD_BUTTON_Y] = buttons[glfw.GAMEPAD_BUTTON_DPAD_LEFT] = 1
    found = SimpleNamespace(axes=[0.1, -1.0, 0.2, 0.3, -1.0, 1.0], buttons=buttons)
    monkeypatch.setattr(glfw, "joystick_present", lambda n: n == 2)
    monkeypatch.setattr(glfw, "joystick_is_gamepad", lambda n: n == 2)
    monkeypatch.setattr(glfw, "get_gamepad_state", lambda n: found)
    axes, held = with_glfw.gamepad_state() or ({}, set())
    assert axes == {"left_x": 0.1, "left_y": -1.0, "right_x": 0.2, "right_y": 0.3, "left_trigger": 0.0,
                    "right_trigger": 1.0}  # fmt: skip
    assert held == {"y", "dpad_left"}
    monkeypatch.setattr(glfw, "joystick_present", lambda n: False)
    assert with_glfw.gamepad_state() is None


PYGLET_CHILD = """
import json, types
from planetfall.engine.hosts import with_pyglet
pad = types.SimpleNamespace(leftx=0.25, lefty=-1.0, rightx=0.0, righty=0.0, lefttrigger=0.5, righttrigger=0.0,
    dpadx=1.0, dpady=-1.0, a=True, b=False, x=False, y=False, back=False, start=False, guide=False, leftshoulder=True,
    rightshoulder=False, leftstick=False, rightstick=False, opened=0, name="a pad")
def opened(): pad.opened += 1
pad.open = opened
found = with_pyglet._Controllers()
found._manager = types.SimpleNamespace(get_controllers=lambda: [pad])
first = found.state(); axes, held = found.state()
found._manager = types.SimpleNamespace(get_controllers=lambda: [])
print(json.dumps({"axes": axes, "held": sorted(held), "opened": pad.opened, "gone": found.state()}))
"""


@pytest.mark.window
def test_pyglet_controllers_are_read() -> None:
    import json
    import os
    import subprocess

    from planetfall.benchmarks.display import display

    with display() as added:
        done = subprocess.run(
            [sys.executable, "-c", PYGLET_CHILD], capture_output=True, text=True, timeout=60, check=False,
            env={**os.environ, **added}, cwd=Path(__file__).parents[2],
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    assert seen["axes"] == {"left_x": 0.25, "left_y": -1.0, "right_x": 0.0, "right_y": 0.0, "left_trigger": 0.5,
                            "right_trigger": 0.0}  # fmt: skip
    assert seen["held"] == ["a", "dpad_down", "dpad_right", "left_bumper"]
    assert seen["opened"] == 1 and seen["gone"] is None
