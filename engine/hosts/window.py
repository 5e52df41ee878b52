"""A window of our own, through moderngl-window: glfw by default, pyglet on request.

`open_window` makes the window and its OpenGL context; `Window` turns the events of either library into the neutral ones
of `engine.input`. Nothing of glfw, pyglet or moderngl-window is imported before a window is opened.
"""

from __future__ import annotations

import importlib
import logging
import os
import sys
import warnings
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np

from ..gpu import gl as G
from ..gpu.gl import GL
from ..gpu.stale_uniforms import keep_uniforms
from ..input import KEYS, InputEvent, InputState, KeyEvent, MouseButton, MouseMove, Resize, Text, Wheel
from .monitors import Monitor, centred, monitor_at

if TYPE_CHECKING:
    from collections.abc import Callable

    import moderngl
    from moderngl_window.context.base import BaseWindow
    from numpy.typing import NDArray

log = logging.getLogger(__name__)

Backend = Literal["glfw", "pyglet"]
BACKENDS: tuple[Backend, ...] = ("glfw", "pyglet")
_BUTTONS: dict[int, Literal["left", "right", "middle"]] = {1: "left", 2: "right", 3: "middle"}
_READ_FRAMEBUFFER, _READ_FRAMEBUFFER_BINDING, _RGBA, _UNSIGNED_BYTE = 0x8CA8, 0x8CAA, 0x1908, 0x1401
_PROBED_VERSIONS = ((4, 5), (4, 3), (4, 1), (3, 3))

_HEADLESS_HINT = (
    "Without a display use `planetfall render` (one picture) or `planetfall record` (a flight), which need none, "
    "or start under a virtual one: `xvfb-run -s '-screen 0 1280x720x24' planetfall fly`."
)


class NoDisplayError(RuntimeError):
    """There is no display to open a window on."""


class WindowError(RuntimeError):
    """The window library is missing or could not make a window."""


class WindowVersionError(WindowError):
    """The display has no OpenGL of the version asked for. `found` is (major, minor), or None if there is none."""

    def __init__(self, required: tuple[int, int], found: tuple[int, int] | None, renderer: str) -> None:
        self.required = required
        self.found = found
        self.renderer = renderer
        seen = f"OpenGL {found[0]}.{found[1]} core ({renderer})" if found else "no OpenGL 3.3 or later core context"
        advice = (
            "macOS stops at OpenGL 4.1; use Linux or Windows."
            if sys.platform == "darwin"
            else "Update the graphics driver, or run on a machine whose GPU has OpenGL 4.3 (2012 and later)."
        )
        needed = f"OpenGL {required[0]}.{required[1]} core"
        super().__init__(f"A window needs {needed}, but this display offers {seen}. {advice}")


class _Platform(Protocol):
    """What with_glfw.py and with_pyglet.py have in common."""

    @staticmethod
    def key_codes(keys: frozenset[str]) -> dict[int, str]: ...
    def pump(self) -> None: ...
    def swap(self) -> None: ...
    @property
    def wants_close(self) -> bool: ...
    def display_scale(self) -> float: ...
    def framebuffer_size(self) -> tuple[int, int]: ...
    @property
    def minimised(self) -> bool: ...
    def monitors(self) -> list[Monitor]: ...
    def position(self) -> tuple[int, int]: ...
    def move(self, x: int, y: int) -> None: ...
    def set_fullscreen(self, monitor: int | None, vsync: bool) -> None: ...
    def clipboard(self) -> str: ...
    def set_clipboard(self, text: str) -> None: ...
    def mouse_y(self, y: float) -> float: ...
    def destroy(self) -> None: ...


def has_display() -> bool:
    """Whether a display is likely there: an X11 or Wayland display is named, or the system always has one."""
    if sys.platform.startswith(("win", "darwin", "cygwin")):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_window(
    size: tuple[int, int] = (1280, 720),
    title: str = "Planetfall",
    backend: Backend = "glfw",
    vsync: bool = True,
    fullscreen: bool = False,
    gl_version: tuple[int, int] = (4, 3),
    resizable: bool = True,
    visible: bool = True,
    monitor: int | None = None,
) -> Window:
    """Open a window of `size` (window units) with an OpenGL core context of at least `gl_version`.

    monitor: which one it opens on, the first is 1; None: where the system puts it.

    Raises:
        NoDisplayError: no display, or it refused the connection.
        WindowVersionError: the display's OpenGL is older than `gl_version`; says what was found.
        WindowError: the window library is missing, or could not make a window for another reason; no such monitor.
        ValueError: unknown backend, or a size below 1.
    """
    if backend not in BACKENDS:
        raise ValueError(f"window backend: expected one of {', '.join(BACKENDS)}, found {backend!r}")
    width, height = size
    if int(width) < 1 or int(height) < 1:
        raise ValueError(f"window size: expected at least 1 x 1, found {width} x {height}")
    if not has_display():
        raise NoDisplayError(f"No display found: neither DISPLAY nor WAYLAND_DISPLAY is set. {_HEADLESS_HINT}")
    window, platform_class = _create(
        backend,
        gl_version,
        size=(int(width), int(height)),
        title=title,
        vsync=vsync,
        resizable=resizable,
        visible=visible,
    )
    result = Window(window, platform_class, backend)
    try:
        if monitor is not None:
            result.monitor = monitor
        if fullscreen:  # not at creation: moderngl-window's pyglet window looks for a module that pyglet 2.1 renamed
            result.fullscreen = True
    except BaseException:
        result.close()
        raise
    return result


def _load_platform(backend: Backend) -> Any:
    try:
        module = importlib.import_module(f".with_{backend}", __package__)
    except ImportError as error:
        raise WindowError(
            f"window backend {backend}: could not import it ({error}). Install it with `pip install {backend} "
            "moderngl-window`; on Debian also `apt install libgl1 libegl1 libfontconfig1`."
        ) from error
    except Exception as error:  # importing pyglet.window connects to the display and fails in its own ways
        raise NoDisplayError(
            f"No display found: {os.environ.get('DISPLAY') or 'the display'} refused the connection "
            f"({type(error).__name__}: {error}). {_HEADLESS_HINT}"
        ) from error
    return module.GlfwPlatform if backend == "glfw" else module.PygletPlatform


def _create(backend: Backend, gl_version: tuple[int, int], **options: Any) -> tuple[Any, Any]:
    """A moderngl-window window and the adapter class for it, or one of the errors of `open_window`."""
    platform_class = _load_platform(backend)
    keep_uniforms()
    with warnings.catch_warnings(record=True) as caught:  # glfw tells its reasons as warnings
        warnings.simplefilter("always")
        try:
            return platform_class.window_class(gl_version=gl_version, cursor=True, **options), platform_class
        except Exception as error:
            reason = "; ".join([str(w.message) for w in caught] or [f"{type(error).__name__}: {error}"])
            failure = error
    if "display" in reason.lower() or "failed to initialize glfw" in str(failure).lower():
        raise NoDisplayError(f"No display found ({reason}). {_HEADLESS_HINT}") from failure
    found, renderer = _probe(platform_class)
    if found is None or found < gl_version:
        raise WindowVersionError(gl_version, found, renderer) from failure
    wanted = f"OpenGL {gl_version[0]}.{gl_version[1]}"
    raise WindowError(f"{backend} could not open a window with {wanted}: {reason}") from failure


def _probe(platform_class: Any) -> tuple[tuple[int, int] | None, str]:
    """The newest OpenGL core version that this display gives, for the error message."""
    for version in _PROBED_VERSIONS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                window = platform_class.window_class(gl_version=version, size=(16, 16), visible=False)
            except Exception as error:
                log.debug("no OpenGL %d.%d window: %s", *version, error)
                continue
        code = window.ctx.version_code
        renderer = str(window.ctx.info["GL_RENDERER"])
        platform_class(window, lambda _event: None).destroy()
        return (code // 100, code // 10 % 10), renderer
    return None, ""


class Window:
    """An open window. Make one with `open_window`.

    A frame: `state = window.poll()`, draw into `window.framebuffer` (pass `window.framebuffer_size` along: moderngl
    does not learn about resizes), `window.swap()`. Loop while `not window.should_close`; then `close()`.

    Attributes:
        ctx: the moderngl context.
        backend: "glfw" or "pyglet".
        input: the state that `poll` returns.
    """

    def __init__(self, window: BaseWindow, platform_class: Callable[..., _Platform], backend: Backend) -> None:
        self.backend = backend
        self.ctx: moderngl.Context = window.ctx
        self.input = InputState()
        self._window = window
        self._queue: list[InputEvent] = []
        self._platform = platform_class(window, self._queue.append)
        self._key_names = self._platform.key_codes(KEYS)
        self._close_asked = False
        self._closed = False
        self._pointer_returns = False
        self._full: int | None = None
        # Escape and F11 belong to the game, not to the window library.
        window.exit_key = None
        window.fullscreen_key = None
        window.key_event_func = self._on_key
        window.mouse_position_event_func = self._on_mouse_move
        window.mouse_drag_event_func = self._on_mouse_move
        window.mouse_press_event_func = self._on_mouse_press
        window.mouse_release_event_func = self._on_mouse_release
        window.mouse_scroll_event_func = self._on_wheel
        window.unicode_char_entered_func = self._on_text
        window.resize_func = self._on_resize
        window.close_func = self._on_close

    # -- events ------------------------------------------------------------------------------------------------------
    def _on_key(self, code: int, action: object, _modifiers: object) -> None:
        keys = self._window.keys
        # glfw's actions are numbers (with a third one for repeats) and pyglet's are strings: compare, don't interpret.
        if action not in (keys.ACTION_PRESS, keys.ACTION_RELEASE):
            return
        name = self._key_names.get(code)
        if name is None:
            log.debug("%s key code %s has no neutral name", self.backend, code)
            return
        self._queue.append(KeyEvent(name, action == keys.ACTION_PRESS))

    def _on_mouse_move(self, x: float, y: float, dx: float, dy: float) -> None:
        if self._pointer_returns:  # glfw puts it back to where it was hidden: that jump is no movement
            self._pointer_returns = False
            dx = dy = 0
        self._queue.append(MouseMove(float(x), self._platform.mouse_y(float(y)), float(dx), float(dy)))

    def _on_mouse_press(self, x: float, y: float, button: int) -> None:
        self._queue.append(MouseButton(_BUTTONS[button], True, float(x), self._platform.mouse_y(float(y))))

    def _on_mouse_release(self, x: float, y: float, button: int) -> None:
        self._queue.append(MouseButton(_BUTTONS[button], False, float(x), self._platform.mouse_y(float(y))))

    def _on_wheel(self, dx: float, dy: float) -> None:
        self._queue.append(Wheel(float(dx), float(dy)))

    def _on_text(self, text: str) -> None:
        printable = "".join(c for c in text if c.isprintable())  # pyglet sends Enter as text
        if printable:
            self._queue.append(Text(printable))

    def _on_resize(self, width: int, height: int) -> None:
        self._queue.append(Resize(int(width), int(height)))

    def _on_close(self) -> None:
        self._close_asked = True

    def poll(self) -> InputState:
        """Take in what happened since the last call."""
        if not self._closed:
            self._platform.pump()
        self.input.advance(self._queue)
        self._queue.clear()
        return self.input

    # -- frame -------------------------------------------------------------------------------------------------------
    def swap(self) -> None:
        """Show what was drawn."""
        if not self._closed:
            self._platform.swap()

    @property
    def framebuffer(self) -> moderngl.Framebuffer:
        """The window's own framebuffer. Its size attribute may be stale: use `framebuffer_size`.

        moderngl's read() of it works but leaves a GL error behind: use `picture`.
        """
        return self.ctx.screen

    def picture(self) -> NDArray[np.uint8]:
        """What has been drawn since the last swap, (H, W, 3), row 0 on top. Waits for the GPU; leaves no GL error."""
        width, height = self.framebuffer_size
        pixels = np.empty((height, width, 4), np.uint8)
        gl = GL(self.ctx)
        bound = gl.integer(_READ_FRAMEBUFFER_BINDING)
        bind = gl.function("glBindFramebuffer", None, G.enum, G.uint)
        bind(_READ_FRAMEBUFFER, 0)
        gl.function("glReadPixels", None, *[G.int_] * 4, G.enum, G.enum, G.c.c_void_p)(
            0, 0, width, height, _RGBA, _UNSIGNED_BYTE, pixels.ctypes.data
        )
        bind(_READ_FRAMEBUFFER, bound)
        return pixels[::-1, :, :3]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height in window units, the units of mouse positions."""
        width, height = self._window.size
        return int(width), int(height)

    @size.setter
    def size(self, size: tuple[int, int]) -> None:
        self._window.size = size

    @property
    def framebuffer_size(self) -> tuple[int, int]:
        """Width and height in pixels; (0, 0) while minimised on some systems.

        A window that moves to a screen with other pixels has others, without a resize in window units.
        """
        width, height = self._platform.framebuffer_size()
        return int(width), int(height)

    @property
    def minimised(self) -> bool:
        """Whether nobody can see it: there is nothing to draw then."""
        return self._platform.minimised

    @property
    def pixel_ratio(self) -> float:
        """Framebuffer pixels per window unit."""
        width = self.size[0]
        return self.framebuffer_size[0] / width if width > 0 and self.framebuffer_size[0] > 0 else 1.0

    @property
    def ui_scale(self) -> float:
        """How much larger than on a 96 dpi screen text should be, in window units (1 to 4)."""
        return min(max(self._platform.display_scale() / self.pixel_ratio, 1.0), 4.0)

    @property
    def title(self) -> str:
        return str(self._window.title)

    @title.setter
    def title(self, title: str) -> None:
        self._window.title = title

    @property
    def vsync(self) -> bool:
        return bool(self._window.vsync)

    @vsync.setter
    def vsync(self, on: bool) -> None:
        self._window.vsync = on

    @property
    def fullscreen(self) -> bool:
        """Whether it covers the whole of its monitor. Setting it takes the monitor that shows most of the window."""
        return self._full is not None

    @fullscreen.setter
    def fullscreen(self, on: bool) -> None:
        if on != self.fullscreen:
            self._fill(self.monitor if on else None)

    @property
    def monitors(self) -> tuple[Monitor, ...]:
        """Those that are there now; they come and go."""
        return tuple(self._platform.monitors())

    @property
    def monitor(self) -> int:
        """The number of the monitor that it is on, the first is 1. Setting it moves the window there, whole screen or
        not; WindowError where there is none of that number."""
        if self._full is not None and self._full <= len(self.monitors):
            return self._full
        return monitor_at(self.monitors, self._platform.position(), self.size) + 1

    @monitor.setter
    def monitor(self, number: int) -> None:
        there = self.monitors
        if not 1 <= number <= len(there):
            listed = "; ".join(f"{k}: {monitor}" for k, monitor in enumerate(there, 1)) or "none that can be named"
            raise WindowError(f"monitor: expected 1 to {len(there)} ({listed}), found {number}")
        if self._full is not None:
            self._fill(number)
        elif number != self.monitor:
            self._platform.move(*centred(there[number - 1], self.size))

    def _fill(self, number: int | None) -> None:
        self._platform.set_fullscreen(None if number is None else number - 1, self.vsync)
        self._full = number

    @property
    def mouse_exclusivity(self) -> bool:
        """Whether the pointer is hidden and held: then only `mouse_dx` and `mouse_dy` mean anything."""
        return bool(self._window.mouse_exclusivity)

    @mouse_exclusivity.setter
    def mouse_exclusivity(self, on: bool) -> None:
        if on != self.mouse_exclusivity:
            self._pointer_returns = self.backend == "glfw" and not on
            self._window.mouse_exclusivity = on

    @property
    def clipboard(self) -> str:
        """The system's clipboard as text; "" if it holds none."""
        return self._platform.clipboard()

    @clipboard.setter
    def clipboard(self, text: str) -> None:
        self._platform.set_clipboard(text)

    # -- end ---------------------------------------------------------------------------------------------------------
    @property
    def should_close(self) -> bool:
        """Whether the user closed the window, `request_close` was called or it is closed already."""
        return self._closed or self._close_asked or self._platform.wants_close

    def request_close(self) -> None:
        """Make `should_close` true; the loop ends in its own time."""
        self._close_asked = True

    def close(self) -> None:
        """Destroy the window and its context. Release everything that lives in the context first."""
        if self._closed:
            return
        self._closed = True
        self._platform.destroy()

    def __enter__(self) -> Window:
        return self

    def __exit__(self, *_exc: object) -> None:
        self.close()
