"""Makes docs/images/tweaking.jpg: the settings over a real flight, `python docs/make_ui_picture.py [size]`."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np
from make_images import as_jpeg
from PIL import Image

import planetfall as pf
from planetfall.app.interface import FlightInterface
from planetfall.app.window import FlightApp
from planetfall.engine.gpu import Gpu
from planetfall.engine.hosts.headless import create_headless
from planetfall.engine.input import InputState

TARGET = Path(__file__).parent / "images" / "tweaking.jpg"
CHANGES = (("Ocean", "wind_speed_m_s", 13.0), ("Sun", "elevation_deg", 14.0), ("Sun", "azimuth_deg", 250.0))


class Screen:
    """A framebuffer that the app takes for its window."""

    def __init__(self, ctx: Any, size: tuple[int, int]) -> None:
        self.ctx, self.size = ctx, size
        self.framebuffer_size = size
        self.framebuffer = ctx.simple_framebuffer(size, 4)
        self.pixel_ratio = self.ui_scale = 1.0
        self.clipboard = ""
        self.mouse_exclusivity = self.fullscreen = self.should_close = False
        self._state = InputState()

    def poll(self) -> InputState:
        self._state.advance([])
        return self._state

    def swap(self) -> None: ...

    def request_close(self) -> None: ...


def main(size: tuple[int, int]) -> None:
    ctx = create_headless()
    gpu = Gpu(ctx, [pf.ASSETS / "shaders"])
    scene = pf.load_scene("earth")
    screen: Any = Screen(ctx, size)
    interface = FlightInterface(screen, scene, gpu)
    renderer = pf.Renderer(scene, size, "high", ctx=ctx)
    start = pf.view("coast", scene.planet)
    app = FlightApp(screen, renderer, scene, start, interface=interface, quality="high")
    app.time_runs = False
    app.shown.help, app.shown.numbers, app.shown.panels = False, False, True
    app.frame()
    settings = interface.settings
    for heading, field, value in CHANGES:
        part = settings.bench.store.parts()[heading]
        before = getattr(part, field)
        setattr(part, field, value)
        settings.bench.made(heading, [(field, before, value)])
        settings.bench.history.seal()
    settings.panel.unfold |= {"Sun", "Exposure", "Composite", "Stars"}
    renderer.settle(app.camera, app.time_s)
    for _ in range(12):
        app.frame()
    app.shown.message = ""
    app.frame()
    pixels = np.frombuffer(screen.framebuffer.read(components=3), np.uint8).reshape(size[1], size[0], 3)[::-1]
    TARGET.write_bytes(as_jpeg(Image.fromarray(np.ascontiguousarray(pixels))))
    interface.release()
    renderer.release()


if __name__ == "__main__":
    width, _, height = (sys.argv[1] if len(sys.argv) > 1 else "1280x720").partition("x")
    main((int(width), int(height)))
