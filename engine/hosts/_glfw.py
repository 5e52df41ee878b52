"""What the window host needs of glfw beyond moderngl-window: key names, focus, clipboard, display scale.

Imported only when a glfw window is opened.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import glfw
from moderngl_window.context.glfw.window import Window as GlfwWindow

from ..input import PAD_AXES, PAD_BUTTONS, Focus, InputEvent, PointerLeft
from .gamepad import GamepadReader

_ODD_NAMES = {
    "grave": "GRAVE_ACCENT",
    "left_ctrl": "LEFT_CONTROL",
    "right_ctrl": "RIGHT_CONTROL",
}


def _code(key: str) -> int:
    name = _ODD_NAMES.get(key, key.upper().replace("NUMPAD_", "KP_"))
    return int(getattr(glfw, f"KEY_{name}"))


def _gamepad() -> tuple[dict[str, float], set[str]] | None:
    """Axes and held buttons of the first gamepad, or None. glfw brings the table that knows its layout."""
    for number in range(glfw.JOYSTICK_1, glfw.JOYSTICK_LAST + 1):
        if not (glfw.joystick_present(number) and glfw.joystick_is_gamepad(number)):
            continue
        state = glfw.get_gamepad_state(number)
        if state is None:
            continue
        axes = {name: float(state.axes[getattr(glfw, f"GAMEPAD_AXIS_{name.upper()}")]) for name in PAD_AXES}
        for name in ("left_trigger", "right_trigger"):  # glfw has them from -1
            axes[name] = 0.5 * (axes[name] + 1.0)
        return axes, {name for name in PAD_BUTTONS if state.buttons[getattr(glfw, f"GAMEPAD_BUTTON_{name.upper()}")]}
    return None


class GlfwPlatform:
    """Adapter around a moderngl-window glfw window."""

    window_class: type[Any] = GlfwWindow

    def __init__(self, window: Any, send: Callable[[InputEvent], None]) -> None:
        self._window = window
        self._native = window._window
        self._send = send
        self._pad = GamepadReader(send)
        glfw.set_window_focus_callback(self._native, self._on_focus)
        glfw.set_cursor_enter_callback(self._native, self._on_cursor_enter)

    @staticmethod
    def key_codes(keys: frozenset[str]) -> dict[int, str]:
        """Native key code -> neutral name."""
        return {_code(key): key for key in keys}

    def _on_focus(self, _window: object, focused: int) -> None:
        self._send(Focus(bool(focused)))

    def _on_cursor_enter(self, _window: object, entered: int) -> None:
        if not entered and not self._window.mouse_exclusivity:
            self._send(PointerLeft())

    def pump(self) -> None:
        glfw.poll_events()
        focused = glfw.get_window_attrib(self._native, glfw.FOCUSED)
        self._pad.read(_gamepad() if focused else None)

    def swap(self) -> None:
        glfw.swap_buffers(self._native)

    @property
    def wants_close(self) -> bool:
        return bool(glfw.window_should_close(self._native))

    def display_scale(self) -> float:
        """How much larger than at 96 dpi things should be drawn, in framebuffer pixels."""
        return float(glfw.get_window_content_scale(self._native)[0])

    def clipboard(self) -> str:
        text = glfw.get_clipboard_string(self._native)
        return text.decode("utf-8", "replace") if isinstance(text, bytes) else (text or "")

    def set_clipboard(self, text: str) -> None:
        glfw.set_clipboard_string(self._native, text)

    def mouse_y(self, y: float) -> float:
        return y

    def destroy(self) -> None:
        # Not moderngl-window's destroy(): that terminates glfw, and with it every other window of the process.
        glfw.destroy_window(self._native)
