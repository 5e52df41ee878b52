"""How fast a window draws: what a frame costs, a cap on frames a second, and automatic quality."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from ..engine.gpu.timers import GpuTimers
from ..errors import SettingError
from .auto_quality import AutoQuality

if TYPE_CHECKING:
    from ..render.renderer import Renderer

__all__ = ["Pace", "check_frame_cap"]

_UNSEEN_S = 0.05
_SPIN_S = 0.001
"""A system's sleep may last this much longer than asked for."""


def check_frame_cap(frame_cap: float) -> None:
    """SettingError for anything but a number from 0 on."""
    if not (isinstance(frame_cap, int | float) and math.isfinite(frame_cap) and frame_cap >= 0.0):
        raise SettingError(f"frame_cap: expected frames a second, 0 for as many as can be, found {frame_cap!r}")


class Pace:
    """begin() before a frame's work, end() after it and before it is shown.

    frame_cap: frames a second at most; 0: as many as there can be. auto: automatic quality, off until it has a budget.
    cost_ms: of the last frame, without waiting for the display: the longer of what the program and the GPU took.
    """

    def __init__(self) -> None:
        self.frame_cap = 0.0
        self.auto = AutoQuality()
        self.cost_ms = 0.0
        self._began_s = self._due_s = 0.0
        self._timers: GpuTimers | None = None
        self._gpu_ms: list[float | None] = [None]
        self._renderer: Renderer | None = None

    def begin(self, renderer: Renderer) -> None:
        """The frame's work begins."""
        self._began_s = time.perf_counter()
        if self.auto.budget_ms is None or renderer.gpu.caps.is_software:
            self._drop_timers()
        elif self._timers is None or self._renderer is not renderer:
            self._drop_timers()
            self._timers, self._renderer = GpuTimers(renderer.gpu, 1), renderer
        if self._timers is not None:
            self._timers.begin(0)

    def end(self, renderer: Renderer, visible: bool = True) -> None:
        """The frame is drawn: take its time, and wait where a cap or a budget says so. visible: False for a window that
        is minimised, which waits: nothing was drawn, and displays don't hold up what they don't show."""
        if not visible:
            _wait_until(self._began_s + _UNSEEN_S)
            return
        wait_ms = 0.0
        if self.auto.budget_ms is not None:
            gpu_ms = 0.0
            if self._timers is not None:
                self._timers.end(0)
                self._timers.collect(self._gpu_ms)
                gpu_ms = self._gpu_ms[0] or 0.0
            else:
                renderer.ctx.finish()  # a software renderer: what is left to do is done by this program anyway
            self.cost_ms = max((time.perf_counter() - self._began_s) * 1e3, gpu_ms)
            wait_ms = self.auto.frame(renderer, self.cost_ms)
        else:
            self.cost_ms = (time.perf_counter() - self._began_s) * 1e3
        if self.frame_cap > 0.0:
            wait_ms = max(wait_ms, 1e3 / self.frame_cap - self.cost_ms)
        if wait_ms > 0.0:
            _wait_until(self._began_s + 1e-3 * (self.cost_ms + wait_ms))

    def release(self) -> None:
        """Before the context goes."""
        self._drop_timers()

    def _drop_timers(self) -> None:
        if self._timers is not None:
            self._timers.release()
            self._timers = None


def _wait_until(when_s: float) -> None:
    while (left := when_s - time.perf_counter()) > 0.0:
        time.sleep(max(left - _SPIN_S, 0.0))
