"""From what a gamepad reads now to events of what has changed."""

from __future__ import annotations

from collections.abc import Callable

from ..input import PAD_AXES, PAD_BUTTONS, InputEvent, PadAxis, PadButton

__all__ = ["GamepadReader"]

_STEP = 1.0 / 256.0
"""Sticks tremble; smaller changes are no news."""


class GamepadReader:
    """Sends a PadAxis or PadButton for each change between two looks at a gamepad."""

    def __init__(self, send: Callable[[InputEvent], None]) -> None:
        self._send = send
        self._axes = dict.fromkeys(PAD_AXES, 0.0)
        self._held: set[str] = set()

    def read(self, state: tuple[dict[str, float], set[str]] | None) -> None:
        """Axes and held buttons as they are now; None: no gamepad, or it is not for this window."""
        if state is None and not self._held and not any(self._axes.values()):
            return  # as in nearly all frames without one
        axes, held = ({}, set[str]()) if state is None else state
        for name in PAD_AXES:
            value = axes.get(name, 0.0)
            if abs(value - self._axes[name]) >= _STEP or (value == 0.0) != (self._axes[name] == 0.0):
                self._axes[name] = value
                self._send(PadAxis(name, value))
        for name in PAD_BUTTONS:
            if (name in held) != (name in self._held):
                self._send(PadButton(name, name in held))
        self._held = set(held)
