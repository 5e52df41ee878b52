"""The native window below moderngl-window's."""

from __future__ import annotations

from typing import Any

__all__ = ["native_window"]


def native_window(window: Any) -> Any:
    """glfw's or pyglet's own, for what moderngl-window passes on no public way to: focus, pads, monitors, clipboard."""
    return window._window
