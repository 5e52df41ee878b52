"""What the actions of the controls do in a flight: one function for each, found by its name."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING

from ..errors import SettingError
from ..systems.debug import NAMED_VIEWS
from ..systems.flight import ACTIONS, MODES, Mode
from .shown import Shown

if TYPE_CHECKING:
    from ..engine.input import InputState
    from .flight import Flight

__all__ = ["act"]

_FASTEST_TIME = 1e6
_TIME_STEP = 4.0
_HOURS_PER_S = 1.5
_YEARS_PER_S = 0.05
_SHOWN_AS = {"help": "help", "numbers": "numbers", "settings": "panels", "journey": "journey"}


def act(app: Flight, state: InputState, dt_s: float) -> None:
    """Do what was asked for in this frame, but for steering."""
    controls = app.controls
    for action, sign in (("hour", _HOURS_PER_S), ("season", _YEARS_PER_S)):
        pushed = controls.value(action, state)
        if pushed:
            (app.journey.later if action == "hour" else app.journey.later_in_year)(pushed * sign * dt_s)
    if not (state.keys_pressed or state.buttons_pressed or state.pad_pressed or state.wheel):
        return
    # Which of two actions on one button counts depends on the mode as it was before either.
    globe, caught = app.pilot.mode == "orbit", app.looking
    for action in ACTIONS:
        if action in _DO and controls.pressed(action, state):
            if action == "catch_mouse" and (globe or caught):
                continue
            _DO[action](app, state)


def _catch(app: Flight, _state: InputState) -> None:
    app.window.mouse_exclusivity = True


def _free(app: Flight, _state: InputState) -> None:
    app.window.mouse_exclusivity = not app.looking and app.pilot.mode != "orbit"


def _leave(app: Flight, _state: InputState) -> None:
    shown = app.shown
    if app.photographing:
        app.journey.stop_photo()
    elif app.looking:
        app.window.mouse_exclusivity = False
    elif shown.panels or shown.journey:
        shown.panels = shown.journey = False
    else:
        app.window.request_close()


def _toggle(name: str) -> None:
    def toggle(app: Flight, _state: InputState) -> None:
        setattr(app.shown, name, not getattr(app.shown, name))
        if name in ("panels", "journey") and getattr(app.shown, name):
            app.window.mouse_exclusivity = False

    _DO[next(action for action, shown in _SHOWN_AS.items() if shown == name)] = toggle


def _mode(mode: Mode) -> None:
    _DO[mode] = lambda app, _state: app.switch(mode)


def _next_mode(app: Flight, _state: InputState) -> None:
    app.switch(MODES[(MODES.index(app.pilot.mode) + 1) % len(MODES)])


def _fly_to(app: Flight, state: InputState) -> None:
    app.fly_to_pixel(None if app.looking else (state.mouse_x, state.mouse_y))


def _reload(app: Flight, _state: InputState) -> None:
    if app.shown.error and app.can_change_quality:
        app.set_quality(app.quality, app.overrides)
    else:
        app.renderer.try_again()
        app.reload_shaders()


def _fullscreen(app: Flight, _state: InputState) -> None:
    app.window.fullscreen = not app.window.fullscreen


def _pause(app: Flight, _state: InputState) -> None:
    app.time_runs = not app.time_runs


def _pace(factor: float) -> None:
    def pace(app: Flight, _state: InputState) -> None:
        app.time_speed = min(max(app.time_speed * factor, 1.0 / 64.0), _FASTEST_TIME)
        app.say(f"time runs {app.time_speed:g} times as fast")

    _DO["faster" if factor > 1.0 else "slower"] = pace


def _resources(app: Flight) -> Collection[str] | None:
    """Names of what the frame graph makes or could make; None before the first frame."""
    try:
        return app.renderer.graph.analysis.model.specs
    except SettingError:
        return None


def _debug_view(app: Flight, _state: InputState) -> None:
    there = _resources(app)
    names = ("off", *(name for name, view in NAMED_VIEWS.items() if there is None or view.resource in there))
    now = names.index(app.debug_view) if app.debug_view in names else 0
    app.debug_view = names[(now + 1) % len(names)]
    app.say(f"debug view: {app.debug_view}")


def _debug_off(app: Flight, _state: InputState) -> None:
    app.debug_view = "off"
    app.say("debug view: off")


_DO = {
    "catch_mouse": _catch,
    "free_mouse": _free,
    "leave": _leave,
    "next_mode": _next_mode,
    "fly_to": _fly_to,
    "reload": _reload,
    "fullscreen": _fullscreen,
    "pause": _pause,
    "debug_view": _debug_view,
    "debug_off": _debug_off,
    "picture": lambda app, _state: app.save_picture(),
    "arrays": lambda app, _state: app.save_picture(suffix=".exr"),
    "photo": lambda app, _state: app.journey.start_photo(),
    "play": lambda app, _state: app.play(None if app.playing is not None else "descent"),
    "start": lambda app, _state: app.to_start(),
    "keep_place": lambda app, _state: app.journey.keep_place(),
    "next_place": lambda app, _state: app.journey.next_place(1),
    "previous_place": lambda app, _state: app.journey.next_place(-1),
}
for _name in _SHOWN_AS.values():
    _toggle(_name)
for _kind in MODES:
    _mode(_kind)
for _factor in (_TIME_STEP, 1.0 / _TIME_STEP):
    _pace(_factor)

assert all(hasattr(Shown, name) or name in Shown.__dataclass_fields__ for name in _SHOWN_AS.values())
