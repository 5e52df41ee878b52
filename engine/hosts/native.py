"""The native window below moderngl-window's."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from moderngl_window.context.glfw.window import Window as GlfwWindow
    from moderngl_window.context.pyglet.window import Window as PygletWindow

__all__ = ["native_window"]


def native_window(window: GlfwWindow | PygletWindow) -> Any:
    """glfw's or pyglet's own, for what moderngl-window passes on no public way to: focus, pads, monitors, clipboard."""
    return window._window
