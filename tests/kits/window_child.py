"""What the window tests do in a process of its own: `python window_child.py FUNCTION ARGUMENT...` prints JSON."""

from __future__ import annotations

import json
import logging
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np

from planetfall import ASSETS
from planetfall.engine.gpu import Gpu
from planetfall.engine.gpu.imgui_backend import ImguiBackend
from planetfall.engine.hosts.foreign import attach
from planetfall.engine.hosts.window import Window, WindowError, open_window
from planetfall.engine.input import Focus, InputEvent, KeyEvent, MouseButton, MouseMove, Resize, Text, Wheel

SIZE = (320, 240)


def xdotool(*arguments: str) -> str:
    done = subprocess.run(["xdotool", *arguments], capture_output=True, text=True, check=True, timeout=20)
    return done.stdout.strip()


class Session:
    """A window that is polled and swapped until something has happened."""

    def __init__(self, backend: str, **options: Any) -> None:
        library: Any = backend
        self.window: Window = open_window(SIZE, f"planetfall test {backend}", library, vsync=False, **options)
        self.events: list[InputEvent] = []
        self.turn()

    def turn(self) -> None:
        self.events += self.window.poll().events
        self.window.swap()

    def until(self, done: Callable[[], bool], seconds: float = 5.0) -> bool:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.turn()
            if done():
                return True
            time.sleep(0.005)
        return False

    def has(self, test: Callable[[InputEvent], bool]) -> bool:
        return self.until(lambda: any(test(event) for event in self.events))

    def focus(self) -> None:
        found = xdotool("search", "--sync", "--onlyvisible", "--name", self.window.title).split()[-1]
        xdotool("windowfocus", found)
        xdotool("mousemove", "--window", found, "100", "60")
        self.until(lambda: False, 0.3)


def lifecycle(backend: str) -> dict[str, Any]:
    """Open, draw ImGui, take a screenshot, resize, close."""
    session = Session(backend)
    window = session.window
    result: dict[str, Any] = {
        "version": window.ctx.version_code,
        "size": window.size,
        "framebuffer": window.framebuffer_size,
        "ratio": window.pixel_ratio,
        "ui_scale": window.ui_scale,
        "should_close": window.should_close,
    }
    gpu = Gpu(window.ctx, [ASSETS / "shaders"])
    board = (lambda: window.clipboard, lambda text: setattr(window, "clipboard", text))
    ui = ImguiBackend(gpu.scope("ui"), window.ui_scale, board)
    window.clipboard = "päste"
    result["clipboard"] = window.clipboard

    def picture() -> np.ndarray[Any, Any]:
        for _ in range(2):
            with ui.frame(window.size, 0.01, window.pixel_ratio, window.poll().events) as imgui:
                imgui.set_next_window_pos(imgui.ImVec2(10, 10))
                imgui.begin("panel")
                imgui.text("Planetfall")
                imgui.end()
            window.framebuffer.use()
            window.framebuffer.clear(0.1, 0.2, 0.3)
            ui.render(window.framebuffer)
            pixels = window.picture()
            result["errors"] = window.ctx.error
            window.swap()
        return pixels

    first = picture()
    result["background"] = first[-1, -1].tolist()
    result["brightest"] = int(first.max())
    window.size = (480, 360)
    result["resized"] = session.has(lambda e: isinstance(e, Resize) and (e.width, e.height) == (480, 360))
    result["new_size"] = window.framebuffer_size
    second = picture()
    result["corner"] = second[-1, -1].tolist()
    result["new_brightest"] = int(second.max())
    window.title = "another title"
    result["title"] = window.title
    window.vsync = False
    window.mouse_exclusivity = True
    session.turn()
    result["exclusive"] = window.mouse_exclusivity
    window.mouse_exclusivity = False
    window.fullscreen = True
    session.until(lambda: window.framebuffer_size[0] > 480, 2.0)
    result["fullscreen"] = window.framebuffer_size
    result["monitor"] = [window.monitor, [[m.width, m.height] for m in window.monitors]]
    try:
        window.monitor = 7
    except WindowError as error:
        result["no monitor"] = str(error)
    window.fullscreen = False
    session.until(lambda: window.framebuffer_size == (480, 360), 2.0)
    ui.release()
    gpu.release()
    result["errors at the end"] = window.ctx.error
    result["left"] = gpu.counts()
    window.request_close()
    result["asked"] = window.should_close
    window.close()
    window.close()
    result["closed"] = window.should_close
    result["after"] = list(window.poll().events)
    return result


def real_input(backend: str) -> dict[str, Any]:
    """Keys, mouse and text from the X server, through xdotool."""
    if shutil.which("xdotool") is None:
        return {"skipped": "no xdotool"}
    session = Session(backend)
    window = session.window
    session.focus()
    result: dict[str, Any] = {"focus": any(isinstance(e, Focus) and e.focused for e in session.events)}
    keys = {"w": "w", "Shift_L": "left_shift", "F1": "f1", "Prior": "page_up", "Left": "left", "5": "5"}
    for key, name in keys.items():
        xdotool("keydown", key)
        pressed = session.has(lambda e, name=name: e == KeyEvent(name, True))
        held = name in window.input.keys_held
        xdotool("keyup", key)
        released = session.has(lambda e, name=name: e == KeyEvent(name, False))
        result[f"key {name}"] = [pressed, held, released, name in window.input.keys_held]
    repeats = [e for e in session.events if e == KeyEvent("w", True)]
    result["w presses"] = len(repeats)
    result["text"] = session.has(lambda e: isinstance(e, Text) and "w" in e.text)
    found = xdotool("search", "--name", window.title).split()[-1]
    xdotool("mousemove", "--window", found, "120", "80")
    result["move"] = session.has(lambda e: isinstance(e, MouseMove) and (e.x, e.y) == (120, 80))
    xdotool("click", "1")
    result["click"] = session.has(lambda e: e == MouseButton("left", False, 120, 80))
    xdotool("click", "3")
    result["right"] = session.has(lambda e: e == MouseButton("right", True, 120, 80))
    xdotool("click", "4")
    result["wheel"] = session.has(lambda e: isinstance(e, Wheel) and e.dy > 0)
    xdotool("key", "Escape")
    result["escape"] = session.has(lambda e: e == KeyEvent("escape", False))
    result["escape closes"] = window.should_close
    window.mouse_exclusivity = True
    session.until(lambda: False, 0.2)
    session.events.clear()
    for _ in range(4):  # more than fit in the window
        xdotool("mousemove_relative", "--", "90", "-70")
        session.until(lambda: False, 0.1)
    moves = [e for e in session.events if isinstance(e, MouseMove)]
    result["captured by"] = [sum(e.dx for e in moves), sum(e.dy for e in moves)]
    window.mouse_exclusivity = False
    window.close()
    return result


def pyglet_guest() -> dict[str, Any]:
    """A pyglet game draws sprites and labels around a guest: the picture is the same with and without it."""
    import moderngl
    import pyglet

    config = pyglet.gl.Config(major_version=4, minor_version=3, forward_compatible=True, double_buffer=True)
    window = pyglet.window.Window(*SIZE, config=config, vsync=False)
    ctx = moderngl.create_context(require=430)
    label = pyglet.text.Label("Host", x=20, y=150, font_size=40, color=(255, 255, 0, 255))
    shape = pyglet.shapes.Rectangle(100, 20, 120, 60, color=(0, 128, 255))
    guest = attach(ctx, [ASSETS / "shaders"])
    with guest.guest():
        ui = ImguiBackend(guest.gpu.scope("ui"))
        target = guest.gpu.scope("guest").framebuffer([guest.gpu.scope("guest").texture((64, 64), "rgba16f")])

    def frame(with_guest: bool) -> bytes:
        window.switch_to()
        window.clear()
        shape.draw()
        if with_guest:
            with guest.guest():
                target.use()
                target.viewport = (0, 0, 32, 32)
                target.clear(1, 0, 0)
                with ui.frame((64, 64)) as imgui:
                    imgui.text("guest")
                ui.render(target)
        label.draw()
        data = pyglet.image.get_buffer_manager().get_color_buffer().get_image_data().get_data("RGB", SIZE[0] * 3)
        window.flip()
        return bytes(data)

    alone, beside, again = frame(False), frame(True), frame(False)
    result = {"same": alone == beside == again, "brightest": max(alone), "errors": list(guest.guard.errors)}
    with guest.guest():
        ui.release()
    guest.release()
    result["counts"] = guest.gpu.counts()
    window.close()
    return result


def embedded_pyglet(path: str) -> dict[str, Any]:
    """games/embed_pyglet for a few frames; its last picture as a file."""
    import ctypes

    import pyglet

    from planetfall.games.embed_pyglet.main import Game

    game = Game(480, 270)
    frames = 3
    for _ in range(frames):
        game.dispatch_events()
        game.on_refresh(0.05)
        pyglet.image.get_buffer_manager().get_color_buffer().save(path)
        game.flip()
    error, test = pyglet.gl.glGetError(), ctypes.c_int()
    pyglet.gl.glGetIntegerv(pyglet.gl.GL_DEPTH_TEST, ctypes.byref(test))
    game.renderer.release()
    game.close()
    return {"frames": frames, "errors": int(error), "depth test": test.value}


def embedded_moderngl_window(path: str, backend: str) -> dict[str, Any]:
    """games/embed_moderngl_window for a few frames; its last picture as a file."""
    import moderngl_window
    from PIL import Image

    from planetfall.games.embed_moderngl_window.main import Game

    result: dict[str, Any] = {"frames": 0}

    class Watched(Game):
        window_size = (400, 200)

        def on_render(self, time: float, frame_time: float) -> None:
            result.setdefault("errors of the library", self.ctx.error)  # from before the first frame
            super().on_render(time, frame_time)
            result["frames"] += 1
            result["errors"] = self.ctx.error
            result["renderer"] = self.renderer
            if result["frames"] == 1:
                self.wnd.size = (480, 270)  # as a user pulls at a corner
            if result["frames"] == 3:
                place = self.wnd.fbo.viewport
                picture = Image.frombytes("RGB", place[2:], self.wnd.fbo.read(viewport=place, components=3))
                result["aspect"] = self.camera.projection.aspect_ratio
                picture.transpose(Image.Transpose.FLIP_TOP_BOTTOM).save(path)
                self.wnd.close()

    moderngl_window.run_window_config(Watched, args=("--window", backend))
    result["left"] = result.pop("renderer").gpu.counts()
    return result


def refused(backend: str, version: str = "4.3") -> dict[str, Any]:
    """The error that opening a window gives."""
    major, minor = version.split(".")
    library: Any = backend
    try:
        open_window(SIZE, backend=library, gl_version=(int(major), int(minor)))
    except Exception as error:
        return {"error": type(error).__name__, "message": str(error), "found": getattr(error, "found", None)}
    return {"error": None}


def tweak_by_clicks(backend: str) -> dict[str, Any]:
    """The settings with a real mouse and real keys: F3, drag a slider, Ctrl Z, Ctrl Y."""
    if shutil.which("xdotool") is None:
        return {"skipped": "no xdotool"}
    import planetfall as pf
    from planetfall.app.interface import FlightInterface
    from planetfall.app.window import FlightApp
    from planetfall.systems.tweak import panel

    boxes: dict[str, tuple[float, float, float]] = {}
    original = panel.edit

    def recorded(imgui: Any, rule: Any, value: Any) -> Any:
        low, width = imgui.get_cursor_screen_pos(), imgui.calc_item_width()
        boxes[rule.name] = (low.x, low.x + width, low.y + imgui.get_frame_height() / 2)
        return original(imgui, rule, value)

    panel.edit = recorded
    session = Session(backend)
    window = session.window
    window.size = (480, 400)
    session.until(lambda: window.framebuffer_size == (480, 400), 2.0)
    scene = pf.load_scene("asteroid")
    renderer = pf.Renderer(scene, (480, 400), "low", ctx=window.ctx)
    interface = FlightInterface(window, scene)
    app = FlightApp(window, renderer, scene, interface=interface, quality="low")
    app.time_runs = app.shown.help = app.shown.numbers = False
    composite = scene.environment[pf.Composite]
    imported = "imgui_bundle" in sys.modules

    def until(done: Callable[[], bool], seconds: float = 20.0) -> bool:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            app.frame()
            if done():
                return True
        return False

    until(lambda: False, 0.3)
    result: dict[str, Any] = {"imgui before": imported or "imgui_bundle" in sys.modules, "first": composite.bloom}
    found = xdotool("search", "--sync", "--onlyvisible", "--name", window.title).split()[-1]
    xdotool("windowfocus", found)
    until(lambda: False, 0.3)
    xdotool("key", "F3")
    result["panels"] = until(lambda: app.shown.panels)
    interface.settings.panel.search = "bloom"
    result["drawn"] = until(lambda: "bloom" in boxes)
    until(lambda: False, 0.3)
    x0, x1, y = boxes["bloom"]

    def point(share: float) -> None:
        xdotool("mousemove", "--window", found, str(round(x0 + share * (x1 - x0))), str(round(y)))
        until(lambda: False, 0.4)

    point(0.1)
    xdotool("mousedown", "1")
    until(lambda: False, 0.4)
    for share in (0.3, 0.5, 0.7):
        point(share)
    result["dragged"] = composite.bloom
    xdotool("mouseup", "1")
    until(lambda: not interface.settings.bench.history.open)
    result["steps"] = len(interface.settings.bench.history)
    xdotool("key", "ctrl+z")
    result["undone"] = until(lambda: composite.bloom == result["first"])
    xdotool("key", "ctrl+y")
    result["done again"] = until(lambda: composite.bloom == result["dragged"])
    result["error"] = app.shown.error
    interface.release()
    renderer.release()
    scene.release()
    result["gl"] = window.ctx.error
    window.close()
    return result


if __name__ == "__main__":
    logging.basicConfig(level=logging.WARNING)
    answer = globals()[sys.argv[1]](*sys.argv[2:])
    sys.stdout.write(json.dumps(answer) + "\n")
    sys.stdout.flush()
