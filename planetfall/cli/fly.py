"""`planetfall fly`: free flight in a window."""

from __future__ import annotations

from typing import Literal

from ..errors import CameraError
from .options import CameraOptions, Planet, Quality, Set, Size, SunOptions, parse_overrides, parse_size
from .render import find_view

__all__ = ["fly_command"]


def fly_command(
    planet: Planet = "earth",
    *,
    view: str | None = None,
    camera: CameraOptions = CameraOptions(),  # noqa: B008 - frozen
    sun: SunOptions = SunOptions(),  # noqa: B008 - frozen
    size: Size = "1280x720",
    quality: Quality | None = None,
    overrides: Set = (),
    window: Literal["glfw", "pyglet"] = "glfw",
    fullscreen: bool = False,
    vsync: bool = True,
    monitor: int | None = None,
    frame_cap: float = 0.0,
) -> None:
    """Fly freely in a window; F1 shows the keys.

    Parameters
    ----------
    view
        Start at this named view.
    quality
        low, medium, high, ultra, reference or paper; left out: high, and without a GPU low at a quarter of the pixels.
    window
        The library that opens the window.
    fullscreen
        Start on the whole screen (F11 changes it).
    vsync
        Wait for the display, which avoids torn pictures.
    monitor
        The monitor to open on; the first is 1.
    frame_cap
        Frames a second at most; 0: as many as there can be.
    """
    if view is not None and camera.given():
        raise CameraError("--view and camera options exclude each other: a view brings its own camera")
    pixels, knobs = parse_size(size), parse_overrides(overrides)
    from .. import load_scene
    from ..app.window import fly

    scene = load_scene(planet)
    start = camera.camera() if camera.given() else find_view(view, scene) if view else None
    light = None if start is None else sun.sun(scene, start)
    fly(
        scene, start, sun=light, size=pixels, quality=quality, overrides=knobs, window=window, fullscreen=fullscreen,
        vsync=vsync, monitor=monitor, frame_cap=frame_cap,
    )  # fmt: skip
