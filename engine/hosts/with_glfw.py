"""What the window host needs of glfw beyond moderngl-window: key names, focus, clipboard, display scale.

Imported only when a glfw window is opened.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable
from typing import Any

import glfw
from moderngl_window.context.glfw.window import Window as GlfwWindow

from ..input import PAD_AXES, PAD_BUTTONS, Focus, InputEvent, PointerLeft
from .gamepad import GamepadReader
from .monitors import Monitor
from .native import native_window

_JOYSTICKS = range(glfw.JOYSTICK_1, glfw.JOYSTICK_LAST + 1)
_LOOK_EVERY = 30
"""Frames between two looks for joysticks that have come."""
_ODD_NAMES = {
    "grave": "GRAVE_ACCENT",
    "left_ctrl": "LEFT_CONTROL",
    "right_ctrl": "RIGHT_CONTROL",
}


def _code(key: str) -> int:
    name = _ODD_NAMES.get(key, key.upper().replace("NUMPAD_", "KP_"))
    return int(getattr(glfw, f"KEY_{name}"))


def gamepad_state(numbers: Iterable[int] = _JOYSTICKS) -> tuple[dict[str, float], set[str]] | None:
    """Axes and held buttons of the first gamepad among these joysticks, or None. glfw brings the table that knows its
    layout."""
    for number in numbers:
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


def _monitor(handle: Any) -> Monitor:
    mode = glfw.get_video_mode(handle)
    name = glfw.get_monitor_name(handle)
    x, y = glfw.get_monitor_pos(handle)
    shown = name.decode("utf-8", "replace") if isinstance(name, bytes) else str(name or "")
    return Monitor(shown, x, y, mode.size.width, mode.size.height, mode.refresh_rate)


class GlfwPlatform:
    """Adapter around a moderngl-window glfw window."""

    window_class: type[Any] = GlfwWindow

    def __init__(self, window: GlfwWindow, send: Callable[[InputEvent], None]) -> None:
        self._window = window
        self._native = native_window(window)
        self._send = send
        self._pad = GamepadReader(send)
        self._place = (0, 0, *glfw.get_window_size(self._native))
        # Each question to the system is a round trip to the display: what changes is told instead.
        self._focused = bool(glfw.get_window_attrib(self._native, glfw.FOCUSED))
        self._minimised = bool(glfw.get_window_attrib(self._native, glfw.ICONIFIED))
        self._pumps, self._joysticks = 0, list[int]()
        self._pixels: tuple[int, int] | None = None
        self._scale: float | None = None
        glfw.set_window_focus_callback(self._native, self._on_focus)
        glfw.set_window_iconify_callback(self._native, self._on_iconify)
        glfw.set_framebuffer_size_callback(self._native, self._on_framebuffer_size)
        glfw.set_window_content_scale_callback(self._native, self._on_scale)
        glfw.set_cursor_enter_callback(self._native, self._on_cursor_enter)

    @staticmethod
    def key_codes(keys: frozenset[str]) -> dict[int, str]:
        """Native key code -> neutral name."""
        return {_code(key): key for key in keys}

    def _on_focus(self, _window: object, focused: int) -> None:
        self._focused = bool(focused)
        self._send(Focus(self._focused))

    def _on_iconify(self, window: object, iconified: int) -> None:
        self._minimised = bool(iconified)
        self._window.glfw_window_iconify(window, iconified)

    def _on_framebuffer_size(self, _window: object, width: int, height: int) -> None:
        self._pixels = (width, height)

    def _on_scale(self, _window: object, across: float, _down: float) -> None:
        self._scale = float(across)

    def _on_cursor_enter(self, _window: object, entered: int) -> None:
        if not entered and not self._window.mouse_exclusivity:
            self._send(PointerLeft())

    def pump(self) -> None:
        glfw.poll_events()
        if self._pumps % _LOOK_EVERY == 0:
            self._joysticks = [number for number in _JOYSTICKS if glfw.joystick_present(number)]
        self._pumps += 1
        self._pad.read(gamepad_state(self._joysticks) if self._focused else None)

    def swap(self) -> None:
        glfw.swap_buffers(self._native)

    @property
    def wants_close(self) -> bool:
        return bool(glfw.window_should_close(self._native))

    def display_scale(self) -> float:
        """How much larger than at 96 dpi things should be drawn, in framebuffer pixels."""
        if self._scale is None:
            self._scale = float(glfw.get_window_content_scale(self._native)[0])
        return self._scale

    def framebuffer_size(self) -> tuple[int, int]:
        if self._pixels is None:
            width, height = glfw.get_framebuffer_size(self._native)
            self._pixels = (width, height)
        return self._pixels

    @property
    def minimised(self) -> bool:
        return self._minimised

    def monitors(self) -> list[Monitor]:
        return [_monitor(handle) for handle in glfw.get_monitors()]

    def position(self) -> tuple[int, int]:
        with warnings.catch_warnings():  # Wayland tells nobody where a window is
            warnings.simplefilter("ignore")
            x, y = glfw.get_window_pos(self._native)
        return x, y

    def move(self, x: int, y: int) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            glfw.set_window_pos(self._native, x, y)

    def set_fullscreen(self, monitor: int | None, vsync: bool) -> None:
        """Cover a monitor at its own resolution; None: back to the window from before."""
        if monitor is None:
            nowhere: Any = None  # a window
            glfw.set_window_monitor(self._native, nowhere, *self._place, glfw.DONT_CARE)
        else:
            if glfw.get_window_monitor(self._native) is None:
                self._place = (*self.position(), *glfw.get_window_size(self._native))
            handle = glfw.get_monitors()[monitor]
            mode = glfw.get_video_mode(handle)
            glfw.set_window_monitor(self._native, handle, 0, 0, *mode.size, mode.refresh_rate)
        self._pixels = self._scale = None
        glfw.swap_interval(int(vsync))  # some systems forget it with the change

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
