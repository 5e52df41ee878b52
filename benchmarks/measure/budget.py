"""Automatic quality with pictures: a real flight under a frame budget.

Cost and clock are processor time of the whole process, so that other programs hardly count: a frame lasts what it cost,
or the budget where it was early, and the flight goes on by that. Nothing is really waited for.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer, Sun
from ...app.auto_quality import AutoQuality

__all__ = ["TOLERANCE", "Held", "fly_within", "full_costs"]

TOLERANCE = 0.1
"""Of the budget: a frame that lasts longer or less long by more is not held."""
_HITCH = 1.5
_AROUND = 10
"""Frames before and after, for what is usual around a frame."""


@dataclass(frozen=True)
class Held:
    """One flight. lasts_ms: each frame. dials: at the end of each frame. changes_s: when quality was changed."""

    budget_ms: float
    lasts_ms: tuple[float, ...]
    dials: tuple[float, ...]
    changes_s: tuple[float, ...]

    @property
    def share(self) -> float:
        """Of the frames that lasted the budget within TOLERANCE."""
        off = np.abs(np.array(self.lasts_ms) - self.budget_ms)
        return float(np.mean(off <= TOLERANCE * self.budget_ms))

    @property
    def hitches(self) -> NDArray[np.bool_]:
        """Frames that last half as long again as those around them: work that comes at once, such as a snap of the
        grid, which no change of quality could foresee."""
        lasts = np.array(self.lasts_ms)
        around = [np.median(lasts[max(k - _AROUND, 0) : k + _AROUND + 1]) for k in range(len(lasts))]
        return lasts > _HITCH * np.array(around)

    @property
    def share_of_rest(self) -> float:
        """As share, of the frames that are no hitches."""
        rest = np.array(self.lasts_ms)[~self.hitches]
        return float(np.mean(np.abs(rest - self.budget_ms) <= TOLERANCE * self.budget_ms))

    @property
    def least_between_s(self) -> float:
        """The least time between two changes; infinite for fewer than two."""
        return min((b - a for a, b in itertools.pairwise(self.changes_s)), default=float("inf"))


def fly_within(
    renderer: Renderer,
    camera_at: Callable[[float], Camera],
    seconds: float,
    budget_ms: float | None,
    sun: Sun | None = None,
    load: Callable[[float], float] = lambda _: 1.0,
) -> Held:
    """Fly for so many seconds of the flight's clock. budget_ms: None flies at full quality, and frames last what they
    cost. load(t): a frame costs so many times what it does."""
    auto = AutoQuality()
    auto.budget_ms = budget_ms
    target = renderer.ctx.simple_framebuffer(renderer.size)
    now_s, lasts, dials = 0.0, [], []
    try:
        while now_s < seconds:
            began = time.process_time()
            dt_s = 1e-3 * lasts[-1] if lasts else 0.0
            viewport = (0, 0, *target.size)
            renderer.render_to(target, camera_at(now_s), now_s, sun, viewport=viewport, dt_s=dt_s)
            renderer.ctx.finish()
            cost_ms = 1e3 * (time.process_time() - began) * load(now_s)
            wait_ms = auto.frame(renderer, cost_ms, now_s + 1e-3 * cost_ms)
            lasts.append(cost_ms + wait_ms)
            dials.append(auto.dial)
            now_s += 1e-3 * lasts[-1]
    finally:
        renderer.gpu.leave(target)
        target.release()
    changes = tuple(change.at_s for change in auto.changes)
    auto.budget_ms = None  # full quality again
    return Held(budget_ms or 0.0, tuple(lasts), tuple(dials), changes)


def full_costs(renderer: Renderer, cameras: list[Camera], sun: Sun | None, frames: int = 3) -> list[float]:
    """Processor time in ms of a frame at full quality at each camera: the least of some, once tiles are there."""
    found = []
    for camera in cameras:
        renderer.settle(camera, sun=sun)
        times = []
        for k in range(frames):
            began = time.process_time()
            renderer.render(camera, 0.02 * (k + 1), sun=sun, dt_s=0.02)
            times.append(1e3 * (time.process_time() - began))
        found.append(min(times))
    return found
