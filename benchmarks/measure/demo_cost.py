"""What Python costs in a whole frame of the demo: events, flight, picture, interface and swap, in a window of its own;
prints JSON. Run as a module by the graph suite, with GALLIUM_NOOP=1 on Mesa's software rasteriser (see python_cost).
"""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any

import numpy as np

SIZE = (1280, 720)
_WARM_UP = 40


def _write_whole_buffers() -> None:
    """Mesa 22.3's driver that draws nothing (GALLIUM_NOOP) damages its own memory when a part of a buffer is written in
    each frame, as the sea's waves are once time runs. Filled up, such writes cost some microseconds more."""
    import moderngl

    plain = moderngl.Buffer.write

    def whole(self: Any, data: Any, *, offset: int = 0) -> None:
        given = bytes(data)
        plain(self, bytes(offset) + given + bytes(self.size - offset - len(given)))

    moderngl.Buffer.write = whole  # type: ignore[method-assign]


class _Timed:
    """The interface, with the processor time it takes."""

    def __init__(self, interface: Any) -> None:
        self._interface = interface
        self.spent_s = 0.0

    def begin(self, state: Any, app: Any, dt_s: float) -> None:
        began = time.thread_time()
        self._interface.begin(state, app, dt_s)
        self.spent_s += time.thread_time() - began

    def draw(self, app: Any) -> None:
        began = time.thread_time()
        self._interface.draw(app)
        self.spent_s += time.thread_time() - began

    def release(self) -> None:
        self._interface.release()


def _measured(app: Any, runs: int) -> dict[str, float]:
    """Medians in ms: of a frame, with its spread, of this thread's processor time without the swap (which copies the
    picture to the display on a software rasteriser), of the swap, and of the interface's share. The 10th percentile is
    what other programs beside this one lengthen least. laid_out_ms: of the interface in frames that lay it out anew,
    which is one in three here."""
    app.to_start()  # every time the same flight
    for _ in range(_WARM_UP):
        app.frame()
    wall, own, interface, swaps = [], [], [], []
    plain = app.window.swap

    def swap() -> None:
        began = time.thread_time()
        plain()
        swaps.append(1e3 * (time.thread_time() - began))

    app.window.swap = swap
    for _ in range(runs):
        app.interface.spent_s = 0.0
        began, began_own = time.perf_counter(), time.thread_time()
        app.frame()
        wall.append(1e3 * (time.perf_counter() - began))
        own.append(1e3 * (time.thread_time() - began_own) - swaps[-1])
        interface.append(1e3 * app.interface.spent_s)
    app.window.swap = plain
    low, middle, high = np.percentile(wall, (10, 50, 90))
    return {
        "ms": float(middle),
        "low": float(low),
        "high": float(high),
        "cpu_ms": float(np.median(own)),
        "swap_ms": float(np.median(swaps)),
        "cpu_p10_ms": float(np.percentile(own, 10)),
        "interface_ms": float(np.median(interface)),
        "laid_out_ms": float(np.percentile(interface, 90)),
    }


def measure(runs: int) -> dict[str, dict[str, float]]:
    """{what is shown: what _measured says}: from the view near, time runs."""
    from ... import view
    from ...app.interface import FlightInterface
    from ...app.renderer import renderer_maker
    from ...app.window import FlightApp
    from ...engine.hosts.window import open_window
    from ...engine.input import KeyEvent
    from ..scenes import preset_scene

    scene = preset_scene("earth")
    with open_window(SIZE, "bench", vsync=False) as window:
        _, make = renderer_maker(scene, window, "medium")
        renderer = make("medium", {})
        interface = FlightInterface(window, scene)
        timed: Any = _Timed(interface)
        app = FlightApp(window, renderer, scene, view("near", scene.planet), interface=timed, quality="medium")
        shown, settings = app.shown, interface.settings
        shown.help = shown.numbers = False
        out: dict[str, dict[str, float]] = {}
        try:
            # Nothing is drawn, and what the GPU would have measured (exposure, counts) is not: nothing waits for it.
            out["nothing shown, at rest"] = _measured(app, runs)
            window.input.advance([KeyEvent("w", True)])
            out["nothing shown, flying"] = _measured(app, runs)
            shown.numbers = True
            out["numbers, flying"] = _measured(app, runs)
            shown.numbers, shown.panels = False, True
            out["panel, flying"] = _measured(app, runs)
            settings.unfold()
            out["all knobs of the planet open, flying"] = _measured(app, runs)
            settings.turn_to = "Quality"
            out["all knobs of quality open, flying"] = _measured(app, runs)
        finally:
            interface.release()
            renderer.release()
            scene.release()
    return out


if __name__ == "__main__":
    if os.environ.get("GALLIUM_NOOP"):
        _write_whole_buffers()
    sys.stdout.write(json.dumps(measure(int(sys.argv[1]))))
