"""What the window shows over the picture: numbers, help, what went wrong, and the settings window."""

from __future__ import annotations

import logging
import math
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import ASSETS
from ..components import DebugView
from ..engine.gpu import Gpu
from ..engine.input import Focus, InputEvent, KeyEvent, MouseMove
from ..render.faults import Fault, Faults
from ..systems.tweak import FrameHistory, HudData, apply_style, draw_hud
from .journey import clock_text
from .journey_window import JourneyWindow
from .panels import SettingsWindow

if TYPE_CHECKING:
    from ..engine.hosts.window import Window
    from ..engine.input import InputState
    from ..scene.scene import Scene
    from .flight import Flight

__all__ = ["FlightInterface"]

_FRAMES = 240
_TRACE_LINES = 9
"""Of a traceback that are shown; the log has all."""

_LAID_OUT_S = 0.045
"""Nobody reads faster than this: while nobody does anything, so often numbers and windows are laid out anew, unless
something else is to be shown. Frames in between draw them again as they were, at a tenth of the cost."""
_AWAKE_S = 0.3
"""After the last event that windows could take they are laid out in every frame for so long."""

_CLOCK_EVERY_S = 0.1
"""So often the clock by the sun is worked out anew: where the sun stands takes longer than all other lines."""

_MODES = {"ship": "ship", "walk": "on foot", "orbit": "globe"}


class _LaidOut(NamedTuple):
    """What windows are laid out for."""

    help: bool
    numbers: bool
    panels: bool
    journey: bool
    message: str
    errors: tuple[str, ...]
    size: tuple[int, int]
    pixel_ratio: float
    scale: float


class FlightInterface:
    """The app's `Interface` on ImGui. window: an open Window.

    gpu: on the window's context; left out, it makes one of its own, so that the interface outlives any renderer.
    """

    def __init__(self, window: Window, scene: Scene, gpu: Gpu | None = None) -> None:
        self._window = window
        self._gpu = gpu
        self._own_gpu: Gpu | None = None
        self._scope: Any = None
        self.ui: Any = None
        self._shows = False
        self._laid_out: _LaidOut | None = None
        self._age_s = self._quiet_s = 0.0
        self._missed: tuple[InputEvent, ...] = ()
        self._clock: tuple[float, str] = (-1.0, "")
        self._history = FrameHistory(_FRAMES)
        self.settings = SettingsWindow(scene, self._history)
        self.journey = JourneyWindow()
        self._logger = logging.getLogger("planetfall")
        self._logger.addHandler(self.settings.log)

    def begin(self, state: InputState, app: Flight, dt_s: float) -> None:
        """Build the frame's interface, and hide from `state` what it used. Nothing to show: nothing of ImGui runs."""
        self._history.add(dt_s * 1e3)
        self.settings.remember(app)
        shown = app.shown
        errors = _errors(app)
        wanted = bool(shown.help or shown.numbers or shown.panels or shown.journey or shown.message or errors)
        if not wanted:
            self._shows, self._laid_out = False, None
            return
        ui = self._backend()
        if not self._shows:  # it has missed events: no key is down that it knows of
            self._shows = True
            ui.feed((Focus(False), Focus(True)))
        size, ratio = self._window.size, self._window.pixel_ratio
        ui.scale = self._window.ui_scale
        chosen = (shown.help, shown.numbers, shown.panels, shown.journey)
        laid_out = _LaidOut(*chosen, shown.message, errors, size, ratio, ui.scale)
        self._missed += state.events
        if not self._may_wait(state, app, laid_out, dt_s):
            self._lay_out(state, app, errors)
        # F1, F3 and the like go on working while a slider has the focus; only typing takes the keyboard. With Ctrl
        # held, keys are the settings' (undo), not the ship's.
        shortcut = shown.panels and not app.looking and bool({"left_ctrl", "right_ctrl"} & state.keys_held)
        state.consume(keyboard=ui.wants_text or shortcut, mouse=ui.wants_mouse and not app.looking)

    def _lay_out(self, state: InputState, app: Flight, errors: tuple[str, ...]) -> None:
        """One frame of ImGui, for as long as the last one was shown."""
        shown, window = app.shown, self._window
        dt_s, self._age_s = self._age_s, 0.0
        events, self._missed = self._missed, ()
        if self.settings.controls.waiting:  # what is pressed now is to be bound, and means nothing else
            self.settings.controls.take(state, app)
            state.consume(keyboard=True, mouse=True, pad=True)
            events = tuple(event for event in events if isinstance(event, MouseMove | Focus))
        frame = self.ui.frame(window.size, dt_s, window.pixel_ratio, events=events, mouse=not app.looking)
        with frame as imgui:
            right = self.settings.width(imgui) if shown.panels else 0.0
            helps = shown.help and not shown.panels
            draw_hud(self.hud(app, helps, errors), numbers=shown.numbers, help=helps, right=right)
            if shown.panels:
                self.settings.draw(imgui, app)
            if shown.journey:
                self.journey.draw(imgui, app)

    def _may_wait(self, state: InputState, app: Flight, laid_out: _LaidOut, dt_s: float) -> bool:
        """Whether what was laid out last may be shown once more: it is young, and nothing has happened to it."""
        self._age_s += dt_s
        windows = app.shown.panels or app.shown.journey
        busy = laid_out != self._laid_out or self.ui.wants_text or self.settings.controls.waiting
        if windows and not app.looking:
            busy = busy or bool(state.events) or bool(state.buttons_held)
        elif windows:
            busy = busy or any(isinstance(event, KeyEvent) for event in state.events)
        self._laid_out = laid_out
        self._quiet_s = 0.0 if busy else self._quiet_s + dt_s
        # A window that is new, or has grown, has its size one layout later.
        return self._quiet_s > (_AWAKE_S if windows else dt_s) and self._age_s < _LAID_OUT_S

    def draw(self, app: Flight) -> None:
        if self._shows:
            self.ui.render(self._window.framebuffer)

    def release(self) -> None:
        self._logger.removeHandler(self.settings.log)
        if self.ui is not None:
            self.ui.release()
            self._scope.release()
            self.ui = self._scope = None
        if self._own_gpu is not None:
            self._own_gpu.release()
            self._own_gpu = None

    def _backend(self) -> Any:
        """The ImGui backend, made when something is first shown."""
        if self.ui is None:
            from ..engine.gpu.imgui_backend import ImguiBackend

            window = self._window

            def paste() -> str:
                return window.clipboard

            def copy(text: str) -> None:
                window.clipboard = text

            if self._gpu is None and self._own_gpu is None:
                self._own_gpu = Gpu(window.ctx, [ASSETS / "shaders"])
            used = self._gpu or self._own_gpu
            assert used is not None
            self._scope = used.scope("ui")
            self.ui = ImguiBackend(self._scope, clipboard=(paste, copy))
            with self.ui.current() as imgui:
                apply_style(imgui)
        return self.ui

    def hud(self, app: Flight, helps: bool, errors: tuple[str, ...]) -> HudData:
        shown = app.shown
        data = HudData(message=shown.message, errors=errors, controls=_help(app) if helps else ())
        if shown.numbers:
            mean_ms = self._history.mean_ms
            data.fps, data.frame_ms = 1000.0 / mean_ms if mean_ms > 0.0 else 0.0, mean_ms
            data.history_ms = self._history.values_ms
            data.cells, data.vertices, data.triangles = (
                shown.stats.get(name) for name in ("cells", "vertices", "triangles")
            )
            data.lines = _lines(app, self._clock_text(app))
            data.refining = getattr(app.renderer, "refining", ())
        return data

    def _clock_text(self, app: Flight) -> str:
        now = time.perf_counter()
        if now >= self._clock[0]:
            self._clock = (now + _CLOCK_EVERY_S, f"{clock_text(app.journey.hour)} by the sun")
        return self._clock[1]


def _help(app: Flight) -> tuple[tuple[str, str], ...]:
    """The keys, and where they are changed."""
    settings = app.controls.bindings.get("settings", ())
    return (*app.controls.help(), (f"{settings[0].shown if settings else 'settings'}, Controls", "change any of these"))


def _errors(app: Flight) -> tuple[str, ...]:
    shown = app.shown
    broken = tuple(f"{error}\nThe last good one is used." for error in shown.shader_errors)
    broken += tuple(
        f"{fault_name(app, fault)} is switched off: it raised {_last_lines(fault.report)}\n"
        "F5, or a change, tries it again."
        for fault in getattr(app.renderer, "faults", Faults()).list
    )
    return (*broken, shown.error) if shown.error else broken


def fault_name(app: Flight, fault: Fault) -> str:
    """The system, and whose it is where there are several."""
    return f"{fault.system} of {fault.planet}" if app.planets.several else fault.system


def _last_lines(report: str) -> str:
    """The end of a traceback: what was raised and where, first what matters."""
    lines = report.strip().splitlines()
    return "\n".join([lines[-1], *lines[-_TRACE_LINES:-1]])


def _lines(app: Flight, clock: str) -> tuple[str, ...]:
    pilot = app.pilot
    throttle = app.ship.throttle if pilot.mode == "ship" else 1.0
    lines = [
        f"{_MODES[pilot.mode]}: {length(pilot.clearance_m)} above ground",
        f"{length(pilot.speed_m_s)}/s" + ("" if throttle == 1.0 else f"   throttle {throttle:.2g}"),
        place(*(float(value) for value in pilot.position_m)),
        clock,
    ]
    if app.planets.several:
        lines.insert(1, f"over {app.planets.name}")
    if app.planets.crossing is not None:
        crossing = app.planets.crossing
        lines.append(f"flying to {crossing.target}: {crossing.time_s:.0f} of {crossing.duration_s:.0f} s")
    if pilot.route is not None:
        lines.append(f"flying there: {pilot.route_s:.0f} of {pilot.route.duration_s:.0f} s")
    if app.playing is not None:
        lines.append(f"{app.playing.name}: {app.played_s:.0f} of {app.playing.duration_s:.0f} s")
    if not app.time_runs:
        lines.append("time stopped")
    elif app.time_speed != 1.0:
        lines.append(f"time x {app.time_speed:g}")
    if app.debug_view != "off":
        lines.append(f"debug view: {app.debug_view}")
    if any(shown.freeze for _, (shown,) in app.scene.world.query(DebugView)):
        lines.append("tiles and frustum are frozen")
    return tuple(lines)


def place(x: float, y: float, z: float) -> str:
    """Latitude and longitude of a position."""
    latitude, longitude = math.degrees(math.atan2(z, math.hypot(x, y))), math.degrees(math.atan2(y, x))
    return f"{abs(latitude):.4f} {'S' if latitude < 0 else 'N'}  {abs(longitude):.4f} {'W' if longitude < 0 else 'E'}"


def length(metres: float) -> str:
    """A length in the unit that suits it."""
    if abs(metres) >= 1e5:
        return f"{metres / 1e3:,.0f} km".replace(",", " ")
    if abs(metres) >= 1e4:
        return f"{metres / 1e3:.1f} km"
    return f"{metres:.0f} m" if abs(metres) >= 100.0 else f"{metres:.1f} m"
