"""Free flight in a window: `pf.fly(scene)`. The loop, the keys and what they do; the panels live in systems/tweak."""

from __future__ import annotations

import logging
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol

from .camera import Camera
from .components import Ocean, Sun
from .flights import ScenePath, path
from .recording import camera_settings
from .systems.capture import CaptureError, require_writable, write_png
from .systems.flight import CONTROLS, ShipFlight, flight_input
from .views import View

if TYPE_CHECKING:
    from .engine.input import InputState
    from .renderer import Renderer
    from .scene import Scene

__all__ = ["KEYS", "FlightApp", "Interface", "fly"]

log = logging.getLogger(__name__)

KEYS: tuple[tuple[str, str], ...] = (
    *CONTROLS,
    ("P", "play or stop the scripted descent"),
    ("Home", "back to the start"),
    ("T", "stop or start the time"),
    ("F1", "this help"),
    ("F2", "numbers on and off"),
    ("F3", "panels on and off"),
    ("F5", "load changed shaders"),
    ("F11", "whole screen"),
    ("F12", "save a picture here"),
    ("Escape", "let the mouse go, then leave"),
)
"""What the help shows: (keys, what they do)."""

_STATS_EVERY_S = 0.25  # they are read back from the GPU
_RELOAD_EVERY_S = 0.5
_LONGEST_FRAME_S = 0.5


class Interface(Protocol):
    """What the app needs of a user interface; without one it flies all the same."""

    def begin(self, state: InputState, app: FlightApp, dt_s: float) -> None:
        """Take the frame's events; whatever the interface uses is consumed from `state`."""

    def draw(self, app: FlightApp) -> None:
        """Draw over the picture, into the bound framebuffer."""

    def release(self) -> None: ...


@dataclass
class Shown:
    """What the interface shows of the app, and may change."""

    help: bool = True
    numbers: bool = True
    panels: bool = False
    message: str = ""
    stats: dict[str, int] = field(default_factory=dict)


class FlightApp:
    """One flight. `frame()` does one frame, `run()` loops until the window closes.

    window: an engine.hosts Window or anything like it. renderer: made on the window's context. camera: the start; None
    looks down on the planet from three radii above it.
    """

    def __init__(
        self,
        window: Any,
        renderer: Renderer,
        scene: Scene,
        camera: Camera | None = None,
        *,
        sun: Sun | None = None,
        interface: Interface | None = None,
    ) -> None:
        self.window, self.renderer, self.scene, self.interface = window, renderer, scene, interface
        self.shown = Shown()
        self.sun = sun or (camera.sun if isinstance(camera, View) else None)
        self.time_s = camera.time_s if isinstance(camera, View) else 0.0
        self.time_runs = True
        self.dt_s = 1.0 / 60.0
        self.playing: ScenePath | None = None
        self._played_s = 0.0
        self._clock = time.perf_counter
        self._next_stats_s = self._next_reload_s = 0.0
        start = camera or _first_camera(scene)
        state = start.resolve(scene)
        self.fov_y_deg = start.fov_y_deg
        self._start = (state.position_m, state.forward, state.up)
        self.ship = ShipFlight(*self._start, radius_m=scene.planet.radius_m)
        self._meet_ground()
        self.ship.place(*self._start)

    @property
    def looking(self) -> bool:
        """Whether the mouse steers the ship (and not the pointer)."""
        return bool(self.window.mouse_exclusivity)

    @property
    def camera(self) -> Camera:
        """This frame's camera."""
        ship = self.ship
        return Camera(ship.position_m, ship.forward, ship.up, self.fov_y_deg)

    def run(self) -> None:
        """Fly until the window closes."""
        before = self._clock()
        while not self.window.should_close:
            now = self._clock()
            self.dt_s, before = max(now - before, 1e-4), now
            self.frame()

    def frame(self) -> None:
        """Input, flight, picture, interface, swap."""
        state = self.window.poll()
        dt_s = min(self.dt_s, _LONGEST_FRAME_S)
        if self.interface is not None:
            self.interface.begin(state, self, self.dt_s)
        self._keys(state)
        self._move(state, dt_s)
        if self.time_runs:
            self.time_s += dt_s
        width, height = self.window.framebuffer_size
        if width > 0 and height > 0:  # (0, 0) while minimised
            framebuffer = self.window.framebuffer
            sun = self.playing.sun if self.playing is not None and self.playing.sun is not None else self.sun
            self.renderer.render_to(
                framebuffer, self.camera, self.time_s, sun=sun, viewport=(0, 0, width, height), dt_s=dt_s
            )
            self._watch()
            if self.interface is not None:
                self.interface.draw(self)
        self.window.swap()

    # what happens in a frame

    def _keys(self, state: InputState) -> None:
        pressed = state.keys_pressed
        if "left" in state.buttons_pressed and not self.looking:
            self.window.mouse_exclusivity = True
        if "tab" in pressed:
            self.window.mouse_exclusivity = not self.looking
        if "escape" in pressed:
            if self.looking:
                self.window.mouse_exclusivity = False
            else:
                self.window.request_close()
        for key, name in (("f1", "help"), ("f2", "numbers"), ("f3", "panels")):
            if key in pressed:
                setattr(self.shown, name, not getattr(self.shown, name))
        if "f3" in pressed and self.shown.panels:
            self.window.mouse_exclusivity = False
        if "f5" in pressed:
            self._reload()
        if "f11" in pressed:
            self.window.fullscreen = not self.window.fullscreen
        if "f12" in pressed:
            self.save_picture()
        if "t" in pressed:
            self.time_runs = not self.time_runs
        if "p" in pressed:
            self.play(None if self.playing is not None else "descent")
        if "home" in pressed:
            self.play(None)
            self.ship.place(*self._start)

    def play(self, name: str | None) -> None:
        """Start a scripted flight from its beginning; None stops it and leaves the ship where it is."""
        self.playing = None if name is None else path(name, self.scene)
        self._played_s = 0.0

    def _move(self, state: InputState, dt_s: float) -> None:
        self._meet_ground()
        wish = flight_input(state, looking=self.looking, fov_y_deg=self.fov_y_deg)
        if self.playing is None:
            self.ship.update(wish, dt_s)
            return
        self._played_s += dt_s
        camera = self.playing.camera_at(self._played_s)
        self.ship.place(camera.position_m, camera.forward, camera.up)
        steered = wish.forward or wish.right or wish.up or wish.roll
        if steered or self._played_s >= self.playing.duration_s:
            self.play(None)

    def _meet_ground(self) -> None:
        """The ship flies over the planet as it is now: panels may have changed it."""
        planet = self.scene.planet
        ocean = planet.get(Ocean)
        self.ship.radius_m = planet.radius_m
        self.ship.field = self.scene.height_field()
        self.ship.sea_level_m = None if ocean is None else ocean.sea_level_m

    def _watch(self) -> None:
        now = self._clock()
        if now >= self._next_stats_s and (self.shown.numbers or self.shown.panels):
            self._next_stats_s = now + _STATS_EVERY_S
            self.shown.stats = self.renderer.stats
        if now >= self._next_reload_s:
            self._next_reload_s = now + _RELOAD_EVERY_S
            self._reload()

    def _reload(self) -> None:
        changed = self.renderer.reload_shaders()
        if changed:
            self.shown.message = "loaded " + ", ".join(changed)

    def save_picture(self, folder: Path | str = ".") -> Path | None:
        """Write this view, without the interface, as a PNG with its settings; says so in `shown.message`."""
        target = Path(folder) / f"planetfall_{datetime.now():%Y%m%d_%H%M%S_%f}.png"
        try:
            require_writable(target)
            color = self.renderer.render(self.camera, self.time_s, sun=self.sun)["color"]
            settings = {"scene": self.scene.name, "time_s": self.time_s, "camera": camera_settings(self.camera)}
            write_png(target, color, settings)
        except CaptureError as error:
            log.warning("%s", error)
            self.shown.message = str(error)
            return None
        self.shown.message = f"saved {target.resolve()}"
        return target


def fly(
    scene: Scene,
    camera: Camera | None = None,
    *,
    sun: Sun | None = None,
    size: tuple[int, int] = (1280, 720),
    quality: str = "high",
    overrides: Mapping[str, Any] | None = None,
    window: Literal["glfw", "pyglet"] = "glfw",
    fullscreen: bool = False,
    vsync: bool = True,
) -> None:
    """Open a window and fly until it closes. NoDisplayError without a display; WindowVersionError below OpenGL 4.3."""
    from .app_interface import FlightInterface
    from .engine.hosts.window import open_window
    from .renderer import Renderer

    with (
        open_window(size, f"Planetfall: {scene.name}", window, vsync=vsync, fullscreen=fullscreen) as opened,
        # The window may come out larger or smaller than asked for.
        Renderer(scene, opened.framebuffer_size, quality, overrides, ctx=opened.ctx) as renderer,
    ):
        interface = FlightInterface(opened, renderer, scene)
        try:
            FlightApp(opened, renderer, scene, camera, sun=sun, interface=interface).run()
        finally:
            interface.release()


def _first_camera(scene: Scene) -> Camera:
    """Over the day side, three radii up, looking down with north on top."""
    return Camera.at(20.0, 0.0, 3.0 * scene.planet.radius_m, 0.0, -90.0)
