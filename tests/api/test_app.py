"""The window's loop: keys, flight, time, pictures; with stand-ins for the window and the renderer."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from app_kit import FakeRenderer, app_of, press

import planetfall as pf
from planetfall.benchmarks.display import display
from planetfall.engine.input import KeyEvent, MouseButton, MouseMove, Wheel
from planetfall.systems.capture import read_png_settings
from planetfall.systems.debug import NAMED_VIEWS


@pytest.fixture
def scene() -> Any:
    with pf.load_scene("earth") as scene:
        scene.planet.remove(pf.Terrain)
        yield scene


def test_runs_until_the_window_closes(scene: Any) -> None:
    app, window, renderer = app_of(scene)
    window.frames_left = 3
    app.run()
    assert window.swaps == len(renderer.drawn) == 3
    assert renderer.drawn[2][1] > renderer.drawn[0][1]


def test_starts_where_it_was_told(scene: Any) -> None:
    app, _, _ = app_of(scene)
    assert app.ship.altitude_m == pytest.approx(2e6, rel=1e-3)  # the view "orbit"
    start = pf.Camera.at(10, 20, 5000, heading_deg=90, fov_y_deg=40)
    app, _, renderer = app_of(scene, camera=start)
    app.frame()
    camera = renderer.drawn[0][0]
    np.testing.assert_allclose(camera.position_m, start.resolve(scene).position_m, rtol=1e-12)
    np.testing.assert_allclose(camera.forward, start.forward, atol=1e-12)
    assert camera.fov_y_deg == 40


def test_a_game_may_hold_the_camera(scene: Any) -> None:
    """A camera that on_frame returns is where the picture is taken from; None leaves it to the player."""
    places = [None, pf.Camera.at(10, 20, 5000, heading_deg=90, fov_y_deg=40), None]
    told = iter(places)
    app, _, renderer = app_of(scene, on_frame=lambda time_s, dt_s: next(told))
    for _ in places:
        app.frame()
    free, held, after = (np.array(drawn[0].position_m) for drawn in renderer.drawn)
    expected = places[1].resolve(scene)
    np.testing.assert_allclose(held, expected.position_m, rtol=1e-12)
    assert renderer.drawn[1][0].fov_y_deg == 40
    assert np.linalg.norm(free - held) > 1e6
    # From there the player flies on.
    np.testing.assert_allclose(after, held, rtol=1e-9)


def test_the_sun_of_a_view_is_put_into_the_scene(scene: Any) -> None:
    """So that the panel turns the sun that shines, and not one behind it."""
    view = pf.view("orbit", scene.planet)
    assert view.sun is not None
    app, _, renderer = app_of(scene, camera=view)
    app.frame()
    assert renderer.drawn[0][2] is None and scene.sun == view.sun
    assert app.time_s >= view.time_s
    app, _, _ = app_of(scene, camera=view, sun=pf.Sun(direction=(0, 0, 1)))
    assert scene.sun.direction == (0, 0, 1)
    app.go_to("space")
    assert scene.sun == pf.view("space", scene.planet).sun
    app.to_start()
    assert scene.sun.direction == (0, 0, 1)


def test_keys_fly_and_the_mouse_looks_once_it_is_caught(scene: Any) -> None:
    app, window, renderer = app_of(scene, camera=pf.Camera.at(0, 0, 1e5))
    window.events = [KeyEvent("w", True), MouseMove(5, 5, 30, 0)]
    before = renderer.drawn
    app.dt_s = 0.1
    app.frame()
    first = before[0][0]
    assert first.position_m[2] > 0.0  # north
    assert abs(first.forward[1]) < 1e-12
    window.events = [MouseButton("left", True, 5, 5)]
    app.frame()
    assert window.mouse_exclusivity
    window.events = [MouseMove(0, 0, 30, 0)]
    app.frame()
    assert renderer.drawn[-1][0].forward[1] > 1e-3  # to the east
    window.events = [Wheel(0, 1)]
    app.frame()
    assert app.ship.throttle > 1.0


def test_escape_lets_go_then_leaves(scene: Any) -> None:
    app, window, _ = app_of(scene)
    window.mouse_exclusivity = True
    app.shown.panels = True
    press(window, "escape")
    app.frame()
    assert not window.mouse_exclusivity and not window.should_close
    press(window, "escape")
    app.frame()
    assert not app.shown.panels and not window.should_close
    press(window, "escape")
    app.frame()
    assert window.should_close


def test_switches(scene: Any) -> None:
    app, window, renderer = app_of(scene)
    help_before, numbers_before = app.shown.help, app.shown.numbers
    window.mouse_exclusivity = True
    press(window, "f1", "f2", "f3", "f11")
    app.frame()
    assert (app.shown.help, app.shown.numbers) == (not help_before, not numbers_before)
    assert app.shown.panels and not window.mouse_exclusivity and window.fullscreen
    renderer.changed = ["terrain/shade.frag"]
    press(window, "f5")
    app.frame()
    assert "terrain/shade.frag" in app.shown.message and renderer.invalidated >= 1
    press(window, "t")
    app.frame()
    stopped = app.time_s
    app.frame()
    assert app.time_s == stopped
    press(window, "t", "page_up")
    app.dt_s = 0.1
    app.frame()
    assert app.time_s - stopped == pytest.approx(0.4)
    for _ in range(2):
        press(window, "page_down")
        app.frame()
    assert app.time_speed == 0.25


def test_the_descent_plays_and_the_player_takes_over(scene: Any) -> None:
    app, window, _renderer = app_of(scene)
    app.dt_s = 0.5
    press(window, "p")
    app.frame()
    assert app.playing is not None and app.playing.sun is not None
    assert scene.sun.elevation_deg == app.playing.sun.elevation_deg
    heights = []
    for _ in range(20):
        app.frame()
        heights.append(app.ship.altitude_m)
    assert heights == sorted(heights, reverse=True)
    window.events = [KeyEvent("w", True)]
    app.frame()
    assert app.playing is None
    window.events = [KeyEvent("w", False)]
    press(window, "home")
    app.frame()
    assert app.ship.altitude_m == pytest.approx(2e6, rel=1e-3)


def test_the_ship_flies_over_the_planet_as_it_is_now(scene: Any) -> None:
    app, _, _ = app_of(scene, camera=pf.Camera.at(0, 0, 50))
    scene.planet[pf.Ocean].sea_level_m = 400.0
    app.dt_s = 0.1
    app.frame()
    assert app.ship.altitude_m >= 402.0 - 1e-6
    scene.planet.remove(pf.Ocean)
    app.frame()
    assert app.pilot.ground.sea_level_m is None


def test_minimised_windows_draw_nothing(scene: Any) -> None:
    app, window, renderer = app_of(scene)
    window.framebuffer_size = (0, 0)
    app.frame()
    assert not renderer.drawn and window.swaps == 1


def test_numbers_are_read_rarely(scene: Any) -> None:
    app, _, renderer = app_of(scene)
    reads = []
    type(renderer).stats = property(lambda self: reads.append(1) or {"cells": 3}, lambda self, value: None)  # type: ignore[assignment]
    try:
        now = [0.0]
        app.clock = lambda: now[0]
        for _ in range(100):
            app.frame()
            now[0] += 0.01
        assert len(reads) == 4 and app.shown.stats == {"cells": 3}
    finally:
        del type(renderer).stats


def test_pictures_are_saved_with_their_settings(scene: Any, tmp_path: Path) -> None:
    app, _, _ = app_of(scene)
    file = app.save_picture(tmp_path)
    assert file is not None and read_png_settings(file)["components"]["sun"] and str(file) in app.shown.message
    assert app.save_picture(tmp_path / "none") is None
    assert "does not exist" in app.shown.message


def test_messages_fade(scene: Any) -> None:
    app, _, _ = app_of(scene)
    now = [0.0]
    app.clock = lambda: now[0]
    app.say("hello")
    app.frame()
    assert app.shown.message == "hello"
    now[0] = 10.0
    app.frame()
    assert app.shown.message == ""


def test_a_window_says_that_it_has_its_own_lens(scene: Any, caplog: pytest.LogCaptureFixture) -> None:
    lens = pf.Intrinsics(64, 36, 50.0, 50.0, 31.5, 17.5)
    app_of(scene, camera=pf.Camera((7e6, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), intrinsics=lens))
    assert "a window has a lens of its own" in caplog.text


def test_debug_views_by_key(scene: Any) -> None:
    app, window, _ = app_of(scene)
    seen = []
    for _ in range(len(NAMED_VIEWS) + 1):
        press(window, "v")
        app.frame()
        seen.append(app.debug_view)
    assert seen[:3] == ["normals", "depth", "distance"] and seen[-1] == "off"
    assert not scene.environment.has(pf.DebugView)  # nothing is left in the scene
    for view in list(NAMED_VIEWS.values())[1:]:
        app.renderer.graph.analysis.model.specs.pop(view.resource, None)  # a scene without any of them
    press(window, "v")
    app.frame()
    assert app.debug_view == "normals"
    press(window, "v")
    app.frame()
    assert app.debug_view == "off", "what the graph has not is passed over"
    app.debug_view = "depth"
    window.events = [KeyEvent("left_shift", True), KeyEvent("v", True)]
    app.frame()
    assert app.debug_view == "off"


class FakeInterface:
    """Draws nothing."""

    def begin(self, state: Any, app: Any, dt_s: float) -> None: ...
    def draw(self, app: Any) -> None: ...
    def release(self) -> None: ...


def test_an_error_while_drawing_is_shown_and_the_window_stays(scene: Any, caplog: pytest.LogCaptureFixture) -> None:
    app, window, renderer = app_of(scene, interface=FakeInterface())
    cleared = []
    window.framebuffer = SimpleNamespace(use=lambda: None, clear=lambda *color: cleared.append(color), viewport=None)
    renderer.fails = RuntimeError("the terrain fell over")
    renderer.fails.add_note("in pass 'terrain.shade' (system 'terrain') of the frame graph")
    app.frame()
    renderer.fails = AttributeError("a consequence")
    app.frame()
    assert window.swaps == len(cleared) == 2
    assert "RuntimeError: the terrain fell over" in app.shown.error and "terrain.shade" in app.shown.error
    assert sum("could not be drawn" in record.message for record in caplog.records) == 1
    renderer.fails = None
    app.frame()
    assert app.shown.error == "" and len(renderer.drawn) == 1
    alone, _, broken = app_of(scene)
    broken.fails = RuntimeError("nobody to show it to")
    with pytest.raises(RuntimeError, match="nobody"):
        alone.frame()


def test_a_lost_context_ends_the_flight(scene: Any) -> None:
    """Nothing can be drawn any more, by F5 neither: the caller prints what happened and where the scene is kept."""
    app, _, renderer = app_of(scene, interface=FakeInterface())
    renderer.fails = pf.ContextLostError("the OpenGL context was lost")
    with pytest.raises(pf.ContextLostError):
        app.run()
    assert app.shown.error == ""
    app.journey.step_photo = lambda: (_ for _ in ()).throw(renderer.fails)  # type: ignore[method-assign]
    with pytest.raises(pf.ContextLostError):
        app.photograph()


def test_f5_starts_a_broken_renderer_anew(scene: Any) -> None:
    made = []

    def make(quality: str, overrides: Any) -> Any:
        made.append((quality, dict(overrides)))
        return FakeRenderer()

    app, window, renderer = app_of(scene, interface=FakeInterface(), make_renderer=make, quality="low")
    window.framebuffer = SimpleNamespace(use=lambda: None, clear=lambda *color: None, viewport=None)
    renderer.fails = RuntimeError("broken")
    app.frame()
    press(window, "f5")
    app.frame()
    assert made == [("low", {})] and renderer.released and app.renderer is not renderer and app.shown.error == ""
    app.set_quality("hihg")
    assert "did you mean 'high'?" in app.shown.message and app.quality == "low" and len(made) == 1
    app.set_quality("medium", {"terrain.edge_px": 1e9})
    assert "terrain.edge_px" in app.shown.message and app.quality == "low"
    app.set_quality("medium", {"terrain.edge_px": 9.0})
    assert made[-1] == ("medium", {"terrain.edge_px": 9.0})


def test_a_debug_view_that_goes_away_is_switched_off(scene: Any) -> None:
    app, _, renderer = app_of(scene, interface=FakeInterface())
    app.debug_view = "debug.wireframe"
    renderer.fails = pf.GraphError("no pass creates 'debug.wireframe'")
    app.frame()
    assert app.debug_view == "off" and "no 'debug.wireframe'" in app.shown.message and app.shown.error == ""


def test_fly_says_what_is_wrong_before_a_window_is_seen(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(pf.SettingError, match="did you mean 'high'"):
        pf.fly(scene, quality="hihg")
    with pytest.raises(pf.SceneError, match=r"fly: expected a scene such as pf\.load_scene"):
        pf.fly("earth")  # type: ignore[arg-type]
    with pytest.raises(pf.SettingError, match=r"terrain\.edge_px"):
        pf.fly(scene, overrides={"terrain.edg_px": 1.0})
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    if sys.platform.startswith("linux"):
        with pytest.raises(pf.expected_errors(), match=r"No display found.*DISPLAY.*planetfall record"):
            pf.fly(scene)


def test_help_names_every_key_that_works(scene: Any) -> None:
    app, _, _ = app_of(scene)
    named = "; ".join(keys.lower() for keys, _ in app.controls.help())
    for key in ("w, s", "space, ctrl", "shift", "f1, pad start", "f2", "f3", "f4", "f5", "f11", "f12", "p", "t", "tab"):
        assert f"; {key}" in f"; {named}", key


WINDOW_SCRIPT = """
import json, sys
import planetfall as pf
from planetfall.app.window import FlightApp
from planetfall.app.interface import FlightInterface
from planetfall.engine.hosts.window import open_window

scene = pf.load_scene("earth")
with open_window((160, 90), "test", sys.argv[1]) as window:
    with pf.Renderer(scene, window.framebuffer_size, "low", ctx=window.ctx) as renderer:
        interface = FlightInterface(window, scene)
        app = FlightApp(window, renderer, scene, pf.view("near", scene.planet), interface=interface)
        app.shown.help = app.shown.numbers = False
        for _ in range(3):
            app.frame()
        window.size = (200, 120)
        for _ in range(3):
            app.frame()
        window.request_close()
        app.run()
        interface.release()
        print(json.dumps({"size": renderer.size, "ran": [p.name for p in renderer.passes() if p.ran]}))
"""


@pytest.mark.window
@pytest.mark.parametrize("backend", ["glfw", "pyglet"])
def test_flies_in_a_real_window(backend: str) -> None:
    """The whole chain: window, renderer on its context, interface, resize, end."""
    with display() as added:
        done = subprocess.run(
            [sys.executable, "-c", WINDOW_SCRIPT, backend], capture_output=True, text=True, timeout=120, check=False,
            env={**os.environ, **added}, cwd=Path(__file__).parents[2],
        )  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout.splitlines()[-1])
    assert "composite.tonemap" in answer["ran"]
    assert answer["size"] == [200, 120]
