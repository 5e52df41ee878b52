"""The window host under a real X server, glfw and pyglet, and the guest in somebody else's window."""

from __future__ import annotations

import pytest
from window_fixtures import RunWindow, display, run_child, run_window

from planetfall.engine.gpu import Gpu
from planetfall.engine.hosts.foreign import attach
from planetfall.engine.hosts.window import NoDisplayError, WindowVersionError, open_window
from planetfall.engine.input import Focus, InputState, KeyEvent, MouseButton, MouseMove, Resize, Text, Wheel

__all__ = ["display", "run_window"]

BACKENDS = ["glfw", "pyglet"]
OLD_GL = {
    "MESA_GL_VERSION_OVERRIDE": "4.1",
    "MESA_GLSL_VERSION_OVERRIDE": "410",
    "LIBGL_ALWAYS_SOFTWARE": "1",
}


@pytest.mark.window
@pytest.mark.parametrize("backend", BACKENDS)
def test_open_draw_resize_close(run_window: RunWindow, backend: str) -> None:
    seen = run_window("lifecycle", backend)
    assert seen["version"] >= 430
    assert seen["size"] == seen["framebuffer"] == [320, 240]
    assert seen["ratio"] == 1.0
    assert 1.0 <= seen["ui_scale"] <= 4.0
    assert not seen["should_close"]
    assert seen["clipboard"] == "päste"
    assert seen["background"] == seen["corner"] == [26, 51, 76]
    assert seen["brightest"] > 200
    assert seen["new_brightest"] > 200
    assert seen["resized"]
    assert seen["new_size"] == [480, 360]
    assert seen["title"] == "another title"
    assert seen["exclusive"]
    number, monitors = seen["monitor"]
    assert seen["fullscreen"] == monitors[number - 1] and seen["fullscreen"][0] > 480
    assert f"expected 1 to {len(monitors)}" in seen["no monitor"]
    assert seen["errors"] == seen["errors at the end"] == "GL_NO_ERROR"
    assert seen["left"] == {}
    assert seen["asked"]
    assert seen["closed"]


@pytest.mark.window
@pytest.mark.parametrize("backend", BACKENDS)
def test_keys_and_mouse(run_window: RunWindow, backend: str) -> None:
    seen = run_window("real_input", backend)
    if "skipped" in seen:
        pytest.skip(seen["skipped"])
    for name in ("w", "left_shift", "f1", "page_up", "left", "5"):
        assert seen[f"key {name}"] == [True, True, True, False], name
    assert seen["w presses"] == 1  # no repeats
    for name in ("text", "move", "click", "right", "wheel", "escape"):
        assert seen[name], name
    assert not seen["escape closes"]
    dx, dy = seen["captured by"]
    assert dx >= 180
    assert dy <= -140


@pytest.mark.window
@pytest.mark.parametrize("backend", BACKENDS)
def test_settings_with_a_real_mouse(run_window: RunWindow, backend: str) -> None:
    seen = run_window("tweak_by_clicks", backend, timeout=150)
    if "skipped" in seen:
        pytest.skip(seen["skipped"])
    assert not seen["imgui before"]  # nothing of it is imported before something shows
    assert seen["panels"] and seen["drawn"] and seen["error"] == "" and seen["gl"] == "GL_NO_ERROR"
    assert seen["dragged"] > seen["first"]
    assert seen["steps"] == 1
    assert seen["undone"] and seen["done again"]


@pytest.mark.window
def test_guest_in_a_pyglet_game(run_window: RunWindow) -> None:
    seen = run_window("pyglet_guest")
    assert seen["same"]
    assert seen["brightest"] > 200
    assert seen["errors"] == []
    assert seen["counts"] == {}


@pytest.mark.parametrize("backend", BACKENDS)
def test_no_display_says_what_to_do(backend: str) -> None:
    nothing = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}
    for environment in (nothing, {**nothing, "DISPLAY": ":4711"}):
        seen = run_child("refused", backend, environment=environment)
        assert seen["error"] == "NoDisplayError", seen
        assert seen["message"].startswith("No display found")
        assert "planetfall render" in seen["message"]
        assert "planetfall record" in seen["message"]
        assert "xvfb-run" in seen["message"]


@pytest.mark.window
@pytest.mark.parametrize("backend", BACKENDS)
def test_old_opengl_names_what_was_found(run_window: RunWindow, backend: str) -> None:
    seen = run_window("refused", backend, environment=OLD_GL)
    assert seen["error"] == "WindowVersionError", seen
    assert seen["found"] == [4, 1]
    assert "needs OpenGL 4.3 core" in seen["message"]
    assert "offers OpenGL 4.1 core" in seen["message"]


def test_bad_arguments() -> None:
    with pytest.raises(ValueError, match=r"expected one of glfw, pyglet, found 'sdl'"):
        open_window(backend="sdl")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"at least 1 x 1, found 0 x 10"):
        open_window((0, 10))
    assert issubclass(NoDisplayError, RuntimeError)
    assert "no OpenGL 3.3" in str(WindowVersionError((4, 3), None, ""))


def test_input_state() -> None:
    state = InputState()
    state.advance([KeyEvent("w", True), MouseMove(5, 6, 2, 1), MouseMove(7, 8, 2, 2), Wheel(0, 1), Text("w")])
    assert (state.keys_held, state.keys_pressed, state.axis("s", "w")) == ({"w"}, {"w"}, 1.0)
    assert (state.mouse_x, state.mouse_y, state.mouse_dx, state.mouse_dy) == (7, 8, 4, 3)
    assert (state.wheel, state.text, state.resized) == (1, "w", False)
    state.advance([MouseButton("left", True, 1, 2), Resize(10, 20)])
    assert (state.keys_held, state.keys_pressed, state.mouse_dx, state.wheel, state.text) == ({"w"}, set(), 0, 0, "")
    assert (state.buttons_held, state.buttons_pressed, state.resized) == ({"left"}, {"left"}, True)
    state.consume(keyboard=True, mouse=True)
    assert not state.keys_held
    assert not state.buttons_held
    assert state.axis("s", "w") == 0.0
    state.advance([])
    assert (state.keys_held, state.buttons_held) == ({"w"}, {"left"})
    state.advance([Focus(False)])
    assert (state.keys_held, state.keys_released, state.buttons_released) == (set(), {"w"}, {"left"})


@pytest.mark.gpu
def test_attach_takes_a_context_only(gpu: Gpu) -> None:
    with pytest.raises(TypeError, match=r"moderngl\.create_context"):
        attach(object())  # type: ignore[arg-type]
    with attach(gpu.ctx) as host:
        assert host.ctx is gpu.ctx
        host.fit(texture_units=4)
        with host.guest():
            host.gpu.scope("guest").buffer(reserve=16)
    assert host.gpu.counts() == {}
    assert gpu.ctx.error == "GL_NO_ERROR"
