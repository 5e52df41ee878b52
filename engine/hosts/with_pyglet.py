"""What the window host needs of pyglet beyond moderngl-window: key names, focus, clipboard, display scale.

Imported only when a pyglet window is opened: importing it connects to the display.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from moderngl_window.context.pyglet.window import Window as PygletWindow
from pyglet.window import key as pyglet_key

from ..input import Focus, InputEvent, PointerLeft
from .gamepad import GamepadReader
from .monitors import Monitor
from .native import native_window

log = logging.getLogger(__name__)

_PAD_AXES = {
    "left_x": "leftx", "left_y": "lefty", "right_x": "rightx", "right_y": "righty",
    "left_trigger": "lefttrigger", "right_trigger": "righttrigger",
}  # fmt: skip
_PAD_BUTTONS = {
    **{name: name for name in ("a", "b", "x", "y", "back", "start", "guide")},
    "left_bumper": "leftshoulder", "right_bumper": "rightshoulder",
    "left_thumb": "leftstick", "right_thumb": "rightstick",
}  # fmt: skip

_NAMES: dict[str, tuple[str, ...]] = {
    "page_up": ("PAGEUP",),
    "page_down": ("PAGEDOWN",),
    "caps_lock": ("CAPSLOCK",),
    "num_lock": ("NUMLOCK",),
    "scroll_lock": ("SCROLLLOCK",),
    "print_screen": ("PRINT",),
    "left_bracket": ("BRACKETLEFT",),
    "right_bracket": ("BRACKETRIGHT",),
    "left_shift": ("LSHIFT",),
    "right_shift": ("RSHIFT",),
    "left_ctrl": ("LCTRL",),
    "right_ctrl": ("RCTRL",),
    "left_alt": ("LALT", "LOPTION"),
    "right_alt": ("RALT", "ROPTION"),
    "left_super": ("LWINDOWS", "LCOMMAND", "LMETA"),
    "right_super": ("RWINDOWS", "RCOMMAND", "RMETA"),
    # With the number lock off the number pad sends other symbols; it is the same key all the same.
    "numpad_0": ("NUM_0", "NUM_INSERT"),
    "numpad_1": ("NUM_1", "NUM_END"),
    "numpad_2": ("NUM_2", "NUM_DOWN"),
    "numpad_3": ("NUM_3", "NUM_PAGE_DOWN", "NUM_NEXT"),
    "numpad_4": ("NUM_4", "NUM_LEFT"),
    "numpad_5": ("NUM_5", "NUM_BEGIN"),
    "numpad_6": ("NUM_6", "NUM_RIGHT"),
    "numpad_7": ("NUM_7", "NUM_HOME"),
    "numpad_8": ("NUM_8", "NUM_UP"),
    "numpad_9": ("NUM_9", "NUM_PAGE_UP", "NUM_PRIOR"),
    "numpad_decimal": ("NUM_DECIMAL", "NUM_DELETE", "NUM_SEPARATOR"),
}


def _names(key: str) -> tuple[str, ...]:
    if key in _NAMES:
        return _NAMES[key]
    if key.isdigit():
        return (f"_{key}",)
    if key.startswith("numpad_"):
        return (key.upper().replace("NUMPAD_", "NUM_"),)
    return (key.upper(),)


class _Controllers:
    """pyglet's gamepads; they come and go. Its own event loop reads them, so a step of that is taken with each look."""

    def __init__(self) -> None:
        self._manager: Any = None
        self._open: Any = None
        try:
            import pyglet.input

            self._manager = pyglet.input.ControllerManager()
        except Exception as error:  # no right to read the devices, or none of the system's libraries for them
            log.info("no gamepads: %s: %s", type(error).__name__, error)

    def state(self) -> tuple[dict[str, float], set[str]] | None:
        """Axes and held buttons of the first gamepad, or None."""
        there = [] if self._manager is None else self._manager.get_controllers()
        pad = there[0] if there else None
        if pad is not self._open:
            self._open = pad
            if pad is not None:
                try:
                    pad.open()
                except Exception as error:  # pyglet's own kinds, by system; also when it is open already
                    log.info("gamepad %s: %s", getattr(pad, "name", "?"), error)
        if pad is None:
            return None
        import pyglet.app

        pyglet.app.platform_event_loop.step(0.0)
        held = {name for name, theirs in _PAD_BUTTONS.items() if getattr(pad, theirs)}
        for name, along, sign in (("left", pad.dpadx, -1), ("right", pad.dpadx, 1), ("down", pad.dpady, -1),
                                  ("up", pad.dpady, 1)):  # fmt: skip
            if along * sign > 0.5:
                held.add(f"dpad_{name}")
        return {name: float(getattr(pad, theirs)) for name, theirs in _PAD_AXES.items()}, held


def _monitor(screen: Any) -> Monitor:
    try:
        name, rate = str(screen.get_monitor_name()), int(screen.get_mode().rate or 0)
    except Exception as error:  # without the X server's extensions for it
        log.debug("monitor: %s: %s", type(error).__name__, error)
        name, rate = "", 0
    return Monitor("" if name == "Unknown" else name, screen.x, screen.y, screen.width, screen.height, rate)


class PygletPlatform:
    """Adapter around a moderngl-window pyglet window."""

    window_class: type[Any] = PygletWindow

    def __init__(self, window: PygletWindow, send: Callable[[InputEvent], None]) -> None:
        self._window = window
        self._native = native_window(window)
        self._send = send
        self._pad = GamepadReader(send)
        self._controllers = _Controllers()
        self._focused = True
        self._native.event("on_activate")(lambda: self._on_focus(True))
        self._native.event("on_deactivate")(lambda: self._on_focus(False))
        self._native.event("on_mouse_leave")(self._on_mouse_leave)

    @staticmethod
    def key_codes(keys: frozenset[str]) -> dict[int, str]:
        """Native key code -> neutral name."""
        pairs = ((name, key) for key in keys for name in _names(key))
        return {int(getattr(pyglet_key, name)): key for name, key in pairs if hasattr(pyglet_key, name)}

    def _on_focus(self, focused: bool) -> None:
        self._focused = focused
        self._send(Focus(focused))

    def _on_mouse_leave(self, _x: int, _y: int) -> None:
        if not self._window.mouse_exclusivity:
            self._send(PointerLeft())

    def pump(self) -> None:
        self._native.switch_to()
        self._native.dispatch_events()
        self._pad.read(self._controllers.state() if self._focused else None)

    def swap(self) -> None:
        self._native.flip()

    @property
    def wants_close(self) -> bool:
        return bool(self._native.has_exit)

    def display_scale(self) -> float:
        """How much larger than at 96 dpi things should be drawn, in framebuffer pixels."""
        return float(self._native.dpi) / 96.0

    def framebuffer_size(self) -> tuple[int, int]:
        width, height = self._native.get_framebuffer_size()
        return width, height

    @property
    def minimised(self) -> bool:
        return not self._window.visible

    def monitors(self) -> list[Monitor]:
        return [_monitor(screen) for screen in self._native.display.get_screens()]

    def position(self) -> tuple[int, int]:
        x, y = self._native.get_location()
        return x, y

    def move(self, x: int, y: int) -> None:
        self._native.set_location(x, y)

    def set_fullscreen(self, monitor: int | None, vsync: bool) -> None:
        """Cover a monitor at its own resolution; None: back to the window from before."""
        if monitor is None:
            self._native.set_fullscreen(False)
        else:
            self._native.set_fullscreen(True, screen=self._native.display.get_screens()[monitor])
        self._native.set_vsync(vsync)

    def clipboard(self) -> str:
        return str(self._native.get_clipboard_text() or "")

    def set_clipboard(self, text: str) -> None:
        self._native.set_clipboard_text(text)

    def mouse_y(self, y: float) -> float:
        # pyglet counts rows from the bottom and moderngl-window turns row y into height - y: one too many.
        return y - 1.0

    def destroy(self) -> None:
        self._native.close()
