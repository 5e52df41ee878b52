"""Controls as data: which action is bound to what, from a TOML file and the user's own on top of it."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...engine.input import InputState
from ...engine.settings.check import PresetError
from ...engine.settings.presets import read_toml, write_toml
from ...engine.settings.suggest import did_you_mean
from .bindings import Binding, BindingError

log = logging.getLogger(__name__)

CONTROLS_FILE = Path(__file__).resolve().parents[2] / "assets" / "presets" / "controls.toml"

ACTIONS: dict[str, str] = {
    "forward": "forward, back",
    "right": "right, left",
    "up": "up, down; on foot: jump, swim up, dive",
    "roll": "roll",
    "look_right": "look around",
    "look_up": "look up and down",
    "speed": "faster, slower; globe: zoom to the pointer",
    "boost": "faster while held",
    "grab": "globe: drag it",
    "tilt": "globe: tilt and turn it",
    "catch_mouse": "catch the mouse",
    "free_mouse": "catch the mouse, let it go",
    "ship": "fly the ship",
    "walk": "walk and swim",
    "orbit": "globe in the hand",
    "next_mode": "next of these three",
    "fly_to": "fly to what the pointer shows",
    "play": "play or stop the scripted descent",
    "start": "back to the start",
    "pause": "stop or start the time",
    "faster": "time runs faster",
    "slower": "time runs slower",
    "hour": "time of day: later, earlier",
    "season": "time of year: later, earlier",
    "keep_place": "keep this place",
    "next_place": "to the next place kept",
    "previous_place": "to the one before",
    "debug_view": "next debug view",
    "debug_off": "no debug view",
    "help": "this help",
    "numbers": "numbers on and off",
    "settings": "settings on and off",
    "journey": "places, time and photos",
    "reload": "load changed shaders",
    "fullscreen": "whole screen",
    "picture": "save a picture here",
    "arrays": "save all arrays of this view here (EXR)",
    "photo": "take a photo as set under places, time and photos",
    "leave": "let the mouse go, close windows, then leave",
}
"""Every action and what the help says about it."""

_TOGETHER: dict[tuple[str, ...], str] = {
    ("look_right", "look_up"): "look around",
    ("grab", "tilt"): "globe: drag it; tilt and turn it",
    ("catch_mouse", "free_mouse"): "catch the mouse; let it go",
    ("ship", "walk", "orbit"): "ship; walk and swim; globe in the hand",
    ("faster", "slower"): "time runs faster; slower",
    ("keep_place", "next_place", "previous_place"): "keep this place; to the next one kept; to the one before",
    ("debug_view", "debug_off"): "next debug view; none",
    ("help", "numbers", "settings"): "this help; numbers; settings",
    ("picture", "arrays", "photo"): "save a picture here; all its arrays (EXR); a photo as set with F4",
}
"""Actions that share a row of the help."""

_NUMBERS = {
    ("mouse", "look_rad_per_pixel"): (1e-5, 0.1),
    ("gamepad", "dead_zone"): (0.0, 0.9),
    ("gamepad", "look_rad_per_s"): (0.05, 20.0),
}


@dataclass
class Controls:
    """What every action is bound to. Actions that are bound to nothing do nothing."""

    bindings: dict[str, tuple[Binding, ...]] = field(default_factory=dict)
    look_rad_per_pixel: float = 0.0022
    invert_y: bool = False
    dead_zone: float = 0.15
    look_rad_per_s: float = 1.8

    def value(self, action: str, state: InputState) -> float:
        """-1..1 from keys, buttons, sticks and triggers together; mouse and wheel are not in it."""
        total = 0.0
        for binding in self._of(action):
            if binding.kind == "pad_axis":
                total += binding.sign * self.with_dead_zone(state.pad_axis(binding.name))
            elif binding.kind in ("key", "mouse", "pad_button") and binding.held(state):
                total += binding.sign
        return min(max(total, -1.0), 1.0)

    def moved(self, action: str, state: InputState) -> float:
        """Pixels of the mouse or steps of the wheel in this frame."""
        total = 0.0
        for binding in self._of(action):
            if binding.kind == "wheel":
                total += binding.sign * state.wheel
            elif binding.kind == "mouse_axis":
                total += binding.sign * (state.mouse_dx if binding.name == "x" else state.mouse_dy)
        return total

    def held(self, action: str, state: InputState) -> bool:
        """Whether one of its keys or buttons is down."""
        return any(binding.held(state) for binding in self._of(action))

    def pressed(self, action: str, state: InputState) -> bool:
        """Whether one of its keys or buttons went down in this frame. Shift V is not V."""
        return any(b.pressed(state) and not self._means_more(b, state) for b in self._of(action))

    def with_dead_zone(self, value: float) -> float:
        """A stick's value with nothing around its middle, and from there on growing from 0 to 1."""
        beyond = (abs(value) - self.dead_zone) / (1.0 - self.dead_zone)
        return math.copysign(min(beyond, 1.0), value) if beyond > 0.0 else 0.0

    def bind(self, action: str, *texts: str) -> None:
        """Bind an action to these and nothing else. PresetError for an unknown action or binding."""
        problems: list[str] = []
        found = _bindings({action: list(texts)}, problems)
        if problems:
            raise PresetError(problems[0], problems)
        self.bindings.update(found)

    def help(self) -> tuple[tuple[str, str], ...]:
        """(keys, what they do) of every action that is bound to something; related ones share a row."""
        rows, said = [], set()
        for action in ACTIONS:
            if action in said:
                continue
            group = next((names for names in _TOGETHER if action in names), (action,))
            said.update(group)
            bound = [name for name in group if self._of(name)]
            keys = [", ".join(_short(list(dict.fromkeys(b.shown for b in self._of(name))))) for name in bound]
            if bound:
                text = _TOGETHER[group] if bound == list(group) and group in _TOGETHER else "; ".join(
                    ACTIONS[name] for name in bound)  # fmt: skip
                rows.append(("; ".join(dict.fromkeys(keys)), text))
        return tuple(rows)

    def table(self) -> dict[str, Any]:
        """As the tables of a settings file."""
        return {
            "mouse": {"look_rad_per_pixel": self.look_rad_per_pixel, "invert_y": self.invert_y},
            "gamepad": {"dead_zone": self.dead_zone, "look_rad_per_s": self.look_rad_per_s},
            "bind": {action: [str(b) for b in self._of(action)] for action in ACTIONS},
        }

    def save(self, path: Path | str) -> None:
        """Write what differs from the defaults; the file is at any time the old or the new one. PresetError."""
        path, defaults, own = Path(path), load_controls().table(), self.table()
        changed = {
            name: {key: value for key, value in table.items() if value != defaults[name][key]}
            for name, table in own.items()
        }
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise PresetError(f"{path.parent}: can't be made: {error.strerror or error}") from error
        write_toml(path, {name: table for name, table in changed.items() if table})

    def _of(self, action: str) -> tuple[Binding, ...]:
        return self.bindings.get(action, ())

    def _means_more(self, binding: Binding, state: InputState) -> bool:
        """Whether a key is held with a modifier that another action asks for."""
        if binding.modifier or binding.kind != "key":
            return False
        others = (b for bound in self.bindings.values() for b in bound)
        return any(b.modifier and b.kind == "key" and b.name == binding.name and b.pressed(state) for b in others)


def load_controls(path: Path | str | None = None) -> Controls:
    """The default controls, with the file's changes if there is one of that name.

    PresetError with everything that is wrong in the file.
    """
    controls = Controls()
    _apply(controls, CONTROLS_FILE)
    if path is not None and Path(path).exists():
        _apply(controls, Path(path))
    return controls


def controls_or_defaults(path: Path | str) -> tuple[Controls, str]:
    """The user's controls and "", or the defaults and what is wrong with the file, which is left as it is."""
    try:
        return load_controls(path), ""
    except PresetError as error:
        log.warning("%s", error)
        return load_controls(), f"{error}\nThe default controls are used; the file was left as it is."


def _apply(controls: Controls, path: Path) -> None:
    problems: list[str] = []
    data = read_toml(path)
    tables = ("mouse", "gamepad", "bind")
    for name, table in data.items():
        if name not in tables or not isinstance(table, Mapping):
            problems.append(f"{name}: expected a table; {did_you_mean(name, tables, 'tables')}")
        elif name != "bind":
            for key, value in table.items():
                _number(controls, name, key, value, problems)
    bound = data.get("bind", {})
    controls.bindings.update(_bindings(bound if isinstance(bound, Mapping) else {}, problems))
    if problems:
        raise PresetError(f"{path}: {len(problems)} problems:\n" + "\n".join(f"  - {p}" for p in problems), problems)


def _number(controls: Controls, table: str, key: str, value: Any, problems: list[str]) -> None:
    if (table, key) == ("mouse", "invert_y"):
        if isinstance(value, bool):
            controls.invert_y = value
        else:
            problems.append(f"mouse.invert_y: expected true or false, found {value!r}")
        return
    limits = _NUMBERS.get((table, key))
    if limits is None:
        known = [k for t, k in (*_NUMBERS, ("mouse", "invert_y")) if t == table]
        problems.append(f"{table}.{key}: unknown key; {did_you_mean(key, known, 'keys')}")
    elif isinstance(value, bool) or not isinstance(value, int | float) or not limits[0] <= value <= limits[1]:
        problems.append(f"{table}.{key}: expected a number from {limits[0]:g} to {limits[1]:g}, found {value!r}")
    else:
        setattr(controls, key, float(value))


def _bindings(table: Mapping[str, Any], problems: list[str]) -> dict[str, tuple[Binding, ...]]:
    found: dict[str, tuple[Binding, ...]] = {}
    for action, texts in table.items():
        if action not in ACTIONS:
            problems.append(f"bind.{action}: unknown action; {did_you_mean(action, ACTIONS, 'actions')}")
            continue
        if not isinstance(texts, list) or not all(isinstance(text, str) for text in texts):
            problems.append(f'bind.{action}: expected a list of texts such as ["w", "-s"], found {texts!r}')
            continue
        parsed = []
        for text in texts:
            try:
                parsed.append(Binding.parse(text))
            except BindingError as error:
                problems.append(f"bind.{action}: {error}")
        found[action] = tuple(parsed)
    return found


def _short(shown: list[str]) -> list[str]:
    """ "Left shift, Right shift" is Shift to a reader."""
    texts: list[str] = []
    for text in shown:
        side, _, rest = text.partition(" ")
        twin = {"Left": "Right", "Right": "Left"}.get(side)
        both = twin is not None and f"{twin} {rest}" in shown and rest in ("shift", "ctrl", "alt")
        name = rest.capitalize() if both else text
        if name not in texts:
            texts.append(name)
    return texts


__all__ = ["ACTIONS", "CONTROLS_FILE", "Controls", "controls_or_defaults", "load_controls"]
