"""Windows on several monitors, moved between screens of different density, minimised: with a stand-in for the system,
because a virtual display has one screen and no window manager. The real one is in test_window."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest
from app_kit import app_of

import planetfall as pf
from planetfall.engine.hosts.monitors import Monitor, centred, monitor_at
from planetfall.engine.hosts.window import Window, WindowError

SMALL = Monitor("laptop", 0, 0, 1280, 800, 60)
LARGE = Monitor("desk", 1280, -200, 2560, 1440, 144)


class System:
    """What a window library says of a window: where it is, on which monitor, with how many pixels a unit."""

    def __init__(self) -> None:
        self.there = [SMALL, LARGE]
        self.density = {SMALL: 2.0, LARGE: 1.0}
        self.at, self.size, self.covered = (100, 100), (640, 360), None
        self.minimised = self.wants_close = False
        self.vsyncs: list[bool] = []

    @staticmethod
    def key_codes(_keys: Any) -> dict[int, str]:
        return {}

    def _on(self) -> Monitor:
        return self.there[monitor_at(self.there, self.at, self.size)]

    def framebuffer_size(self) -> tuple[int, int]:
        return (0, 0) if self.minimised else tuple(round(n * self.density[self._on()]) for n in self.size)  # type: ignore[return-value]

    def display_scale(self) -> float:
        return self.density[self._on()]

    def monitors(self) -> list[Monitor]:
        return list(self.there)

    def position(self) -> tuple[int, int]:
        return self.at

    def move(self, x: int, y: int) -> None:
        self.at = (x, y)

    def set_fullscreen(self, monitor: int | None, vsync: bool) -> None:
        if monitor is None:
            self.at, self.size = self.covered
        else:
            self.covered = self.covered or (self.at, self.size)
            found = self.there[monitor]
            self.at, self.size = (found.x, found.y), (found.width, found.height)
        self.vsyncs.append(vsync)


@pytest.fixture
def system() -> System:
    return System()


@pytest.fixture
def window(system: System) -> Window:
    class Native(SimpleNamespace):
        @property
        def size(self) -> tuple[int, int]:
            return system.size

    return Window(Native(ctx=None, vsync=True), lambda *_: system, "glfw")  # type: ignore[arg-type, return-value]


def test_which_monitor_shows_the_most() -> None:
    there = [SMALL, LARGE]
    assert monitor_at(there, (100, 100), (640, 360)) == 0
    assert monitor_at(there, (1000, 100), (640, 360)) == 1  # 280 columns here, 360 there
    assert monitor_at(there, (9000, 9000), (640, 360)) == 0 == monitor_at([], (0, 0), (1, 1))
    assert centred(LARGE, (640, 360)) == (2240, 340) and centred(SMALL, (4000, 3000)) == (0, 0)
    assert str(LARGE) == "desk, 2560 x 1440, 144 Hz" and str(Monitor("", 0, 0, 5, 4)) == "monitor, 5 x 4"


def test_a_window_is_moved_and_filled_where_it_is(window: Window, system: System) -> None:
    assert [window.monitor, *window.monitors] == [1, SMALL, LARGE]
    window.monitor = 2
    assert window.monitor == 2 and system.at == centred(LARGE, (640, 360))
    window.fullscreen = True
    assert window.fullscreen and window.size == (2560, 1440) and window.monitor == 2
    window.monitor = 1
    assert window.fullscreen and window.size == (1280, 800) and window.monitor == 1
    window.fullscreen = False
    assert not window.fullscreen and window.size == (640, 360) and window.monitor == 2, "where it was"
    assert system.vsyncs == [True] * 3
    window.fullscreen = True
    system.there = [SMALL]  # unplugged
    assert window.monitor == 1


@pytest.mark.parametrize("number", [0, 3, -1])
def test_a_monitor_that_is_not_there_is_named(window: Window, number: int) -> None:
    with pytest.raises(WindowError, match=rf"expected 1 to 2 \(1: laptop, .*; 2: desk.*\), found {number}"):
        window.monitor = number
    assert window.monitor == 1


def test_a_window_that_moves_to_another_density_has_other_pixels(window: Window, system: Any) -> None:
    assert (window.framebuffer_size, window.pixel_ratio, window.ui_scale) == ((1280, 720), 2.0, 1.0)
    system.at = (1500, 0)  # the user drags it: no resize in window units, and no event
    assert (window.framebuffer_size, window.pixel_ratio, window.ui_scale) == ((640, 360), 1.0, 1.0)
    system.density[LARGE] = 1.5  # a system with units of pixels says so by its scale alone
    system.framebuffer_size = lambda: (640, 360)
    assert (window.pixel_ratio, window.ui_scale) == (1.0, 1.5)
    system.minimised = True
    system.framebuffer_size = lambda: (0, 0)
    assert window.minimised and window.framebuffer_size == (0, 0) and window.pixel_ratio == 1.0


@pytest.mark.parametrize("how", ["no pixels", "iconified"])
def test_a_minimised_window_draws_nothing_and_rests(how: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setenv("PLANETFALL_CONFIG", str(tmp_path))
    with pf.load_scene("earth") as scene:
        scene.planet.remove(pf.Terrain)
        app, window, renderer = app_of(scene)
        app.frame()
        assert len(renderer.drawn) == 1
        if how == "no pixels":
            window.framebuffer_size = (0, 0)
        else:
            window.minimised = True
        before, flown = time.perf_counter(), app.time_s
        for _ in range(4):
            app.dt_s = 0.05
            app.frame()
        assert len(renderer.drawn) == 1 and window.swaps == 5 and app.shown.error == ""
        assert time.perf_counter() - before >= 4 * 0.049, "it doesn't turn as fast as it can"
        assert app.time_s > flown
        window.framebuffer_size, window.minimised = (64, 36), False
        app.frame()
        assert len(renderer.drawn) == 2


@pytest.mark.parametrize("cap", [-1.0, float("nan"), float("inf")])
def test_frame_caps_that_cannot_be(cap: float) -> None:
    with pf.load_scene("moon") as scene, pytest.raises(pf.SettingError, match="frame_cap: expected frames a second"):
        pf.fly(scene, frame_cap=cap)
