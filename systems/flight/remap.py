"""Binding an action to what is pressed next, and which actions then share a key. No user interface in it."""

from __future__ import annotations

from ...engine.input import PAD_AXES, InputState
from .bindings import Binding
from .controls import ACTIONS, Controls, load_controls

__all__ = ["LOOKING", "TWO_SIDED", "Catch", "rebind", "rivals"]

TWO_SIDED = frozenset({"forward", "right", "up", "roll", "look_right", "look_up", "speed", "hour", "season"})
"""Actions that go both ways: their bindings may be turned round."""
LOOKING = frozenset({"look_right", "look_up"})
"""Actions that follow the mouse as it moves."""

_MODIFIERS = ("shift", "ctrl", "alt")
_MOVED_PX = 80.0
_PUSHED = 0.6
"""Of a stick's or trigger's way: more than any of them gives by itself."""


class Catch:
    """Waits for the key, button, wheel or axis that an action is to be bound to. sign: -1 for the other way round.

    `take` each frame; ended is "" while it waits, then "bound", "cancelled" (Escape) or "cleared" (Delete).
    """

    def __init__(self, action: str, sign: float = 1.0) -> None:
        self.action, self.sign = action, sign if action in TWO_SIDED else 1.0
        self.ended = ""
        self._modifier_down = ""
        self._moved = [0.0, 0.0]
        self._pads_at_first: dict[str, float] | None = None

    def take(self, state: InputState) -> Binding | None:
        """What was pressed in this frame; None while nothing was, or when it ended without."""
        found = self._key(state) or self._pointer(state) or self._pad(state)
        if found is not None:
            self.ended = "bound"
        return found

    def _key(self, state: InputState) -> Binding | None:
        held = {name for name in _MODIFIERS if {f"left_{name}", f"right_{name}"} & set(state.keys_held)}
        for key in sorted(state.keys_pressed):
            if key == "escape" and self.action != "leave":
                self.ended = "cancelled"
                return None
            if key == "delete":
                self.ended = "cleared"
                return None
            if key.partition("_")[2] in _MODIFIERS:
                self._modifier_down = key  # alone it counts once it is let go
                continue
            # A key that is held to move something means the same with Shift: only single actions ask for a modifier.
            modifier = "" if self.action in TWO_SIDED else next((name for name in _MODIFIERS if name in held), "")
            return Binding("key", key, self.sign, modifier)
        if self._modifier_down in state.keys_released:
            return Binding("key", self._modifier_down, self.sign)
        return None

    def _pointer(self, state: InputState) -> Binding | None:
        for button in sorted(state.buttons_pressed):
            return Binding("mouse", button, self.sign)
        if state.wheel:
            return Binding("wheel", "wheel", self.sign if state.wheel > 0.0 else -self.sign)
        if self.action in LOOKING:
            self._moved[0] += state.mouse_dx
            self._moved[1] += state.mouse_dy
            for axis, moved in zip("xy", self._moved, strict=True):
                if abs(moved) > _MOVED_PX:
                    return Binding("mouse_axis", axis, self.sign if moved > 0.0 else -self.sign)
        return None

    def _pad(self, state: InputState) -> Binding | None:
        for button in sorted(state.pad_pressed):
            return Binding("pad_button", button, self.sign)
        now = {name: state.pad_axis(name) for name in PAD_AXES}
        if self._pads_at_first is None:
            self._pads_at_first = now
        for name, value in now.items():
            if abs(value) > _PUSHED and abs(value - self._pads_at_first[name]) > _PUSHED:
                return Binding("pad_axis", name, self.sign if value > 0.0 else -self.sign)
        return None


def rebind(controls: Controls, action: str, old: Binding | None, new: Binding | None) -> None:
    """Put `new` in the place of `old` among what an action is bound to: None adds it, or takes `old` off."""
    bound = [b for b in controls.bindings.get(action, ()) if b != new or b == old]
    if old in bound:
        at = bound.index(old)
        bound[at : at + 1] = [] if new is None else [new]
    elif new is not None:
        bound.append(new)
    controls.bind(action, *map(str, bound))


def rivals(controls: Controls, defaults: Controls | None = None) -> dict[str, dict[Binding, tuple[str, ...]]]:
    """{action: {its binding: other actions on the same key}}; without those that share one by default, such as a click
    that drags the globe and catches the mouse elsewhere."""
    meant = _shared(load_controls() if defaults is None else defaults)
    found: dict[str, dict[Binding, tuple[str, ...]]] = {}
    for key, users in _shared(controls).items():
        for action, binding in users:
            others = tuple(
                other
                for other, _ in users
                if other != action and not {action, other} <= {user for user, _ in meant.get(key, ())}
            )
            if others:
                found.setdefault(action, {})[binding] = others
    return found


def _shared(controls: Controls) -> dict[tuple[str, str, str], list[tuple[str, Binding]]]:
    """Who uses each key; both ways of an axis are one."""
    users: dict[tuple[str, str, str], list[tuple[str, Binding]]] = {}
    for action in ACTIONS:
        for binding in controls.bindings.get(action, ()):
            users.setdefault((binding.kind, binding.name, binding.modifier), []).append((action, binding))
    return users
