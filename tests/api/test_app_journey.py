"""What the demo's keys do beyond flying: modes, flights to places, time, places kept, photos."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from app_kit import app_of, press

import planetfall as pf
from planetfall.capture.photos import PhotoPlan
from planetfall.engine.input import Focus, KeyEvent, MouseButton, MouseMove, PadAxis, PadButton, Wheel
from planetfall.engine.space import latitude_longitude
from planetfall.systems.capture import read_png_settings


@pytest.fixture
def scene() -> Any:
    with pf.load_scene("earth") as scene:
        scene.planet.remove(pf.Terrain)
        yield scene


@pytest.fixture(autouse=True)
def own_settings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "settings"
    monkeypatch.setenv("PLANETFALL_CONFIG", str(folder))
    return folder


def run(app: Any, seconds: float, dt_s: float = 0.1) -> None:
    app.dt_s = dt_s
    for _ in range(round(seconds / dt_s)):
        app.frame()


def test_mode_keys(scene: Any) -> None:
    app, window, _ = app_of(scene, camera=pf.Camera.at(0, 0, 50.0))
    window.mouse_exclusivity = True
    for key, mode in (("3", "orbit"), ("1", "ship"), ("2", "ship")):
        press(window, key)
        app.frame()
        assert app.pilot.mode == mode
    assert not window.mouse_exclusivity  # the globe is turned with a pointer
    run(app, 15.0)
    assert app.pilot.mode == "walk"  # flown down to the sea first
    assert app.pilot.walker.swimming
    press(window, "m")
    app.frame()
    assert app.pilot.mode == "orbit"
    window.events = [PadButton("y", True)]
    app.frame()
    assert app.pilot.mode == "ship"


def test_the_globe_is_dragged_and_zoomed_by_the_pointer(scene: Any) -> None:
    app, window, renderer = app_of(scene, camera=pf.Camera.at(0, 0, 1e7, pitch_deg=-90))
    press(window, "3")
    app.frame()
    window.events = [MouseMove(32, 18, 0, 0), MouseButton("left", True, 32, 18)]
    app.frame()
    assert not window.mouse_exclusivity
    window.events = [MouseMove(36, 18, 4, 0)]
    app.frame()
    longitude = latitude_longitude(renderer.drawn[-1][0].position_m)[1]
    assert longitude < -1.0  # the globe follows the pointer to the right, so the camera goes west
    window.events = [MouseButton("left", False, 36, 18)]
    run(app, 3.0)
    height = app.pilot.clearance_m
    window.events = [Wheel(0, 3)]
    run(app, 2.0)
    assert app.pilot.clearance_m == pytest.approx(height * 0.8**3, rel=0.05)


def test_a_gamepad_flies_without_anything_else(scene: Any) -> None:
    app, window, renderer = app_of(scene, camera=pf.Camera.at(0, 0, 1e4))
    window.events = [PadAxis("left_y", -1.0), PadAxis("right_x", 1.0)]
    run(app, 1.0)
    assert renderer.drawn[-1][0].position_m[2] > 100.0  # north
    assert renderer.drawn[-1][0].forward[1] > 0.5  # and turned to the east
    window.events = [Focus(False)]
    run(app, 3.0)
    assert app.ship.speed_m_s < 1.0


def test_flies_to_what_was_pointed_at(scene: Any) -> None:
    app, window, renderer = app_of(scene, camera=pf.Camera.at(0, 0, 1e7, pitch_deg=-90))
    press(window, "f")
    app.frame()
    assert "nothing but sky" in app.shown.message and app.pilot.route is None
    point = pf.direction(10.0, 20.0) * scene.planet.radius_m
    renderer.shown = (point, "sea")
    window.events = [MouseMove(20, 10, 0, 0)]
    press(window, "f")
    app.frame()
    assert app.pilot.route is not None
    heights = []
    for _ in range(200):
        app.dt_s = 0.1
        app.frame()
        heights.append(app.pilot.clearance_m)
    assert min(heights) >= 2.0 - 1e-8 and app.pilot.route is None
    away = point - app.pilot.position_m
    assert np.linalg.norm(away) < 7000.0
    assert away @ app.pilot.pose.forward / np.linalg.norm(away) > 0.999999


def test_time_of_day_and_year(scene: Any) -> None:
    app, window, _ = app_of(scene, camera=pf.Camera.at(40, 20, 1000.0))
    before = app.journey.hour
    window.events = [KeyEvent("right_bracket", True)]
    run(app, 2.0)
    window.events = [KeyEvent("right_bracket", False)]
    app.time_runs = False
    run(app, 0.2)
    assert (app.journey.hour - before) % 24.0 == pytest.approx(3.0, abs=0.1)
    assert scene.sun.mode == "epoch" and "by the sun" in app.shown.message
    hour, season = app.journey.hour, app.journey.season
    window.events = [KeyEvent("equal", True)]
    run(app, 2.0)
    window.events = [KeyEvent("equal", False)]
    app.frame()
    assert (app.journey.season - season) % 1.0 == pytest.approx(0.1, abs=0.005)
    assert app.journey.hour == pytest.approx(hour, abs=0.01)
    stopped = app.journey.hour
    run(app, 1.0)
    assert app.journey.hour == stopped
    app.time_runs, app.time_speed = True, 3600.0
    run(app, 1.0)
    assert (app.journey.hour - stopped) % 24.0 == pytest.approx(1.0, abs=0.02)


def test_places_are_kept_and_visited(scene: Any, own_settings: Path) -> None:
    app, window, _ = app_of(scene, camera=pf.Camera.at(10, 20, 3000.0, heading_deg=40))
    press(window, "n")
    app.frame()
    assert "no place is kept" in app.shown.message
    press(window, "b")
    app.frame()
    first = app.pilot.position_m
    app.place(pf.Camera.at(-30, 100, 500.0))
    press(window, "b")
    app.frame()
    app.to_start()
    again, window, _ = app_of(scene)
    assert again.journey.places.names(scene) == [scene.name, f"{scene.name} 2"]
    press(window, "n")
    again.frame()
    assert np.linalg.norm(again.pilot.position_m - first) < 1e-3
    window.events = [KeyEvent("left_shift", True)]
    press(window, "n")
    again.frame()
    assert latitude_longitude(again.pilot.position_m)[0] == pytest.approx(-30.0)
    assert (own_settings / "places.toml").exists()


def test_damaged_settings_are_said_and_survive(scene: Any, own_settings: Path) -> None:
    own_settings.mkdir()
    for name in ("places.toml", "controls.toml"):
        (own_settings / name).write_text("nonsense = [")
    app, window, _ = app_of(scene)
    assert "controls.toml" in app.shown.message and "places.toml" in app.shown.message
    window.events = [KeyEvent("w", True)]
    run(app, 0.5)
    assert app.ship.speed_m_s > 0.0
    assert (own_settings / "controls.toml").read_text() == "nonsense = ["


class TileRenderer:
    """What a photo asks of a renderer: sizes, and cameras for parts of the picture."""

    def __init__(self, scene: Any) -> None:
        self.scene, self.size, self.released, self.exposure = scene, (64, 36), False, 13.5
        self.stats: dict[str, int] = {}
        self.render_scale = 0.5
        self.sizes: list[tuple[int, int]] = []
        self.cameras: list[Any] = []

    def resize(self, size: tuple[int, int]) -> None:
        self.size = size

    def camera_state(self, camera: Any) -> Any:
        return camera.resolve(self.scene)

    def height_field(self) -> Any:
        return None

    def reload_shaders(self) -> list[str]:
        return []

    def settle(self, camera: Any, time_s: Any, sun: Any = None) -> None: ...
    def render_to(self, *_: Any, **__: Any) -> None: ...

    def render(self, camera: Any, time_s: Any, sun: Any = None, outputs: Any = ("color",)) -> dict[str, Any]:
        assert self.render_scale == 1.0
        self.sizes.append(self.size)
        self.cameras.append(camera)
        return {"color": np.full((self.size[1], self.size[0], 3), len(self.sizes), np.uint8)}


def test_a_photo_is_taken_a_tile_a_frame(scene: Any, tmp_path: Path) -> None:
    app, window, _ = app_of(scene, camera=pf.Camera.at(0, 0, 1e6))
    app.renderer = TileRenderer(scene)
    app.renderer.shader_errors = []  # type: ignore[attr-defined]
    app.journey.photo, app.journey.folder = PhotoPlan((600, 300), 1, 256), tmp_path
    window.events = [KeyEvent("left_shift", True)]
    press(window, "f12")
    app.frame()
    assert app.photographing and app.renderer.size != (64, 36)
    frames = 1
    while app.photographing and frames < 100:
        app.frame()
        frames += 1
    assert frames == 9  # the exposure, and four tiles by two
    assert app.renderer.size == (64, 36) and "saved" in app.shown.message
    assert app.renderer.render_scale == 0.5
    (file,) = tmp_path.glob("*.png")
    told = read_png_settings(file)
    assert told["size"] == [600, 300] and told["exposure"] == 13.5 and told["components"]["ocean"]
    assert all(camera.ev100 == 13.5 for camera in app.renderer.cameras)
    assert json.dumps(told)
    window.events = [KeyEvent("left_shift", True)]
    press(window, "f12")
    app.frame()
    press(window, "escape")
    app.frame()
    assert not app.photographing and not window.should_close and app.renderer.size == (64, 36)
    assert len(list(tmp_path.glob("*.png"))) == 1
