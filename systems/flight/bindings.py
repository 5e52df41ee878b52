"""What a control is bound to, as text: "w", "mouse:left", "mouse:x", "wheel", "pad:a", "pad:left_x", "-s", "shift+v".

A leading minus turns the value round: the key s is -1 for what w is +1 for.
"""

from __future__ import annotations

from dataclasses import dataclass

from ...engine.input import KEYS, PAD_AXES, PAD_BUTTONS, InputState

BUTTONS = ("left", "middle", "right")
_MODIFIERS = ("shift", "ctrl", "alt")
_NAMES = {
    "pad:a": "pad A", "pad:b": "pad B", "pad:x": "pad X", "pad:y": "pad Y", "wheel": "wheel", "mouse:x": "mouse",
    "mouse:y": "mouse", "mouse:left": "click", "mouse:right": "right button", "mouse:middle": "middle button",
    "space": "Space", "grave": "`", "minus": "-", "equal": "=", "comma": ",", "period": ".", "slash": "/",
    "semicolon": ";", "apostrophe": "'", "left_bracket": "[", "right_bracket": "]", "backslash": "\\",
}  # fmt: skip


class BindingError(ValueError):
    """A binding that names nothing; the message says what could be meant."""


@dataclass(frozen=True, slots=True)
class Binding:
    """One key, button or axis. kind: key, mouse, wheel, pad_button or pad_axis."""

    kind: str
    name: str
    sign: float = 1.0
    modifier: str = ""

    @classmethod
    def parse(cls, text: str) -> Binding:
        """From its text. BindingError for a name that is none."""
        sign, rest = (-1.0, text[1:]) if text.startswith("-") and len(text) > 1 else (1.0, text)
        modifier = ""
        for name in _MODIFIERS:
            if rest.startswith(f"{name}+"):
                modifier, rest = name, rest[len(name) + 1 :]
        device, colon, name = rest.partition(":")
        kind = ""
        if not colon and rest == "wheel":
            kind, name = "wheel", rest
        elif not colon and rest in KEYS:
            kind, name = "key", rest
        elif device == "mouse" and name in (*BUTTONS, "x", "y"):
            kind = "mouse" if name in BUTTONS else "mouse_axis"
        elif device == "pad" and name in PAD_BUTTONS:
            kind = "pad_button"
        elif device == "pad" and name in PAD_AXES:
            kind = "pad_axis"
        if not kind:
            raise BindingError(
                f"{text!r} is no key, button or axis; expected a key such as 'w', 'left_shift' or 'f1', 'wheel', "
                f"'mouse:left' (right, middle, x, y), or 'pad:a' (one of {', '.join((*PAD_BUTTONS, *PAD_AXES))}), with "
                "'-' before it to turn it round and 'shift+', 'ctrl+' or 'alt+' for a key held with it"
            )
        return cls(kind, name, sign, modifier)

    def __str__(self) -> str:
        modifier = f"{self.modifier}+" if self.modifier else ""
        device = {"mouse": "mouse:", "mouse_axis": "mouse:", "pad_button": "pad:", "pad_axis": "pad:"}.get(
            self.kind, ""
        )
        return ("-" if self.sign < 0 else "") + modifier + device + self.name

    @property
    def shown(self) -> str:
        """For people: "Shift V", "pad left stick"."""
        plain = str(Binding(self.kind, self.name))
        text = _NAMES.get(plain)
        if text is None and self.kind == "pad_axis":
            side, _, axis = self.name.partition("_")
            text = f"pad {side} {'trigger' if axis == 'trigger' else 'stick'}"
        if text is None and self.kind == "pad_button":
            text = "pad " + self.name.replace("dpad", "cross").replace("_", " ")
        if text is None:
            text = self.name.replace("_", " ").capitalize()
        return f"{self.modifier.capitalize()} {text}" if self.modifier else text

    def held(self, state: InputState) -> bool:
        """Whether a key or button is down; half way for triggers and sticks."""
        if self.modifier and not _modified(state, self.modifier):
            return False
        if self.kind == "key":
            return self.name in state.keys_held
        if self.kind == "mouse":
            return self.name in state.buttons_held
        if self.kind == "pad_button":
            return self.name in state.pad_held
        return self.kind == "pad_axis" and state.pad_axis(self.name) * self.sign > 0.5

    def pressed(self, state: InputState) -> bool:
        """Whether it went down in this frame."""
        if self.kind == "wheel":
            hit = state.wheel * self.sign > 0.0
        elif self.kind == "key":
            hit = self.name in state.keys_pressed
        elif self.kind == "mouse":
            hit = self.name in state.buttons_pressed
        else:
            hit = self.kind == "pad_button" and self.name in state.pad_pressed
        return hit and (not self.modifier or _modified(state, self.modifier))


def _modified(state: InputState, modifier: str) -> bool:
    held = state.keys_held
    return f"left_{modifier}" in held or f"right_{modifier}" in held


__all__ = ["Binding", "BindingError"]
