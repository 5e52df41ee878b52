"""The Python cost of a whole frame, measured in a process of its own; prints JSON. Run as a module by the graph suite.

On Mesa's software rasteriser the process runs with GALLIUM_NOOP=1: every GL call is made and checked, nothing is drawn,
so what is left is Python and the front end of the driver.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable

import numpy as np


def _times_ms(frame: Callable[[int], None], runs: int) -> list[float]:
    out = []
    for k in range(runs):
        started = time.perf_counter()
        frame(k)
        out.append(1e3 * (time.perf_counter() - started))
    return out


def measure(runs: int) -> dict[str, dict[str, float]]:
    """{"camera still" | "camera turns": {"ms", "low", "high", "update_ms", "passes"}} for the view near."""
    from ... import Camera, view
    from ...render.renderer import Renderer
    from ..scenes import preset_scene

    with Renderer(preset_scene("earth"), size=(160, 90), quality="medium") as renderer:
        target = renderer.ctx.simple_framebuffer((160, 90))
        still = view("near")
        for _ in range(5):
            renderer.render_to(target, still)
        state = renderer.camera_state(still)
        turned = [
            Camera(position_m=state.position_m, forward=state.forward + 1e-6 * k * state.right, up=state.up)
            for k in range(runs)
        ]
        update: list[float] = []

        def at_rest(_: int) -> None:
            renderer.render_to(target, still)
            update.append(renderer.python_ms)

        def turning(k: int) -> None:
            renderer.render_to(target, turned[k], 0.0)
            update.append(renderer.python_ms)

        out = {}
        for name, frame in (("camera still", at_rest), ("camera turns", turning)):
            update.clear()
            times = _times_ms(frame, runs)
            low, middle, high = np.percentile(times, (10, 50, 90))
            out[name] = {
                "ms": float(middle),
                "low": float(low),
                "high": float(high),
                "update_ms": float(np.median(update)),
                "passes": float(len(renderer.passes())),
            }
        return out


if __name__ == "__main__":
    sys.stdout.write(json.dumps(measure(int(sys.argv[1]))))
