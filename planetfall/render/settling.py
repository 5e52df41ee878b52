"""Renderer.settle: frames until nothing streams, refines or adapts any more."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from ..errors import NotSettled

if TYPE_CHECKING:
    from ..engine.frame import View
    from ..engine.system import System

__all__ = ["settle"]

_MEASURES = "composite"
"""The system that measures what the others have drawn."""
_SETTLE_FRAMES = 64
"""Frames in which no system got further after which settle gives up."""


def settle(
    frame: Callable[[], None],
    view: View,
    running: Callable[[], Sequence[System]],
    current: Callable[[], AbstractContextManager[object]],
    timeout_s: float | None,
    progress: Callable[[float], None] | None,
) -> None:
    """See Renderer.settle. frame: draws one. running: the systems to wait for. current: makes the GL context that."""
    started = time.monotonic()
    waiting, late = [""], True
    step, idle, share = 0, 0, 0.0
    best: list[float] = []
    while idle < _SETTLE_FRAMES:
        with current():
            frame()
            systems = running()
            # The frame in which the last table was done was begun, and its light measured, without it.
            late = any(name != _MEASURES for name in waiting)
            waiting = [s.name for s in systems if not s.settled(view)]  # some read back from the GPU
            # A system may be content before all that it could do is done.
            shares = [s.progress(view) if s.name in waiting else 1.0 for s in systems]
        further = len(shares) != len(best) or any(now > most for now, most in zip(shares, best, strict=True))
        best = [*map(max, shares, best)] if len(shares) == len(best) else shares
        step, idle, share = step + 1, 0 if further else idle + 1, max(share, min(shares, default=1.0))
        if progress is not None:
            progress(1.0 if not waiting else 0.99 * share)
        if not waiting and not late and step >= 2:
            return
        if timeout_s is not None and time.monotonic() - started > timeout_s:
            break
    raise NotSettled(
        f"not settled after {step} frames and {time.monotonic() - started:.1f} s: "
        f"{', '.join(waiting) or 'nothing'}; give it a longer timeout_s"
    )
