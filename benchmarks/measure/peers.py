"""Frames as a browser's page times them, for suite `peers`."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ... import Renderer
from ..timing import Timing
from . import peer_scenes
from .frames import RUN_UP
from .motion import turned

__all__ = ["WAYS", "PageFrames", "page_frames"]

STEP_S = 0.016
"""The peer's frame by its own clock."""
WAYS: Mapping[str, tuple[float, float]] = {"time running": (0.0, STEP_S), "turning": (0.01, 0.0)}
"""Degrees that the camera turns, and seconds that go by, in each frame: as the peer's page has it, where we need not
draw again what did not change; and one in which all pixels are new."""


@dataclass(frozen=True)
class PageFrames:
    """Frames of a view, each waited for."""

    timing: Timing
    p95_ms: float
    cpu_ms: float
    """Median of the processor time, of all cores."""


def page_frames(renderer: Renderer, view: str, runs: int, run_up: int = RUN_UP) -> dict[str, PageFrames]:
    """By name in WAYS: a view of peer_scenes, settled, then `run_up` frames that don't count and `runs` that do."""
    camera, sun = peer_scenes.camera(view), peer_scenes.sun()
    renderer.settle(camera, peer_scenes.TIME_S, sun)
    state, target = renderer.camera_state(camera), renderer.ctx.simple_framebuffer(renderer.size)
    found = {}
    for way, (turn_deg, step_s) in WAYS.items():
        wall_ms: list[float] = []
        used_ms: list[float] = []
        cameras = turned(state, turn_deg, run_up + runs)
        for number, seen in enumerate(cameras):
            renderer.ctx.finish()
            began, began_used = time.perf_counter(), time.process_time()
            moment_s = peer_scenes.TIME_S + number * step_s
            renderer.render_to(target, seen, time_s=moment_s, sun=sun, dt_s=STEP_S)
            renderer.ctx.finish()
            wall_ms.append(1e3 * (time.perf_counter() - began))
            used_ms.append(1e3 * (time.process_time() - began_used))
        wall_ms, used_ms = wall_ms[-runs:], used_ms[-runs:]
        p95_ms = float(np.quantile(wall_ms, 0.95))
        found[way] = PageFrames(Timing.of(wall_ms), p95_ms, float(np.median(used_ms)))
    renderer.gpu.leave(target)
    target.release()
    return found
