"""Threads of a software renderer, one to a processor.

llvmpipe's threads sleep between draws, and the scheduler often wakes both on the processor that submitted the draw: one
then draws the whole picture while the other core looks on, for the few milliseconds that the draw takes
(docs/decisions.md says how to measure it).
"""

from __future__ import annotations

import contextlib
import logging
import os
from pathlib import Path

__all__ = ["OFF", "spread_threads"]

log = logging.getLogger(__name__)

OFF = "PLANETFALL_PIN"
"""Environment variable: 0 leaves the threads to the scheduler."""

_NAME = "llvmpipe-"
_TASKS = Path("/proc/self/task")


def spread_threads() -> int:
    """Give each of llvmpipe's rasteriser threads in this process a processor of its own; how many were given one.

    0, and nothing done, where the system isn't Linux, where their number isn't that of the processors that this
    process may use (then a few would leave the rest idle, or share), or where the environment says PLANETFALL_PIN=0.
    """
    if os.environ.get(OFF, "").strip() == "0" or not hasattr(os, "sched_setaffinity"):
        return 0
    processors = sorted(os.sched_getaffinity(0))
    threads = _threads()
    if len(processors) < 2 or {number for number, _ in threads} != set(range(len(processors))):
        return 0
    given = 0
    for number, thread in threads:
        # A thread that has ended by now, or that somebody has given a place already, is left alone.
        with contextlib.suppress(OSError):
            if os.sched_getaffinity(thread) == set(processors):
                os.sched_setaffinity(thread, {processors[number]})
                given += 1
    if given:
        log.debug("%d threads of the software renderer, one to a processor", given)
    return given


def _threads() -> list[tuple[int, int]]:
    """(number, thread id) of llvmpipe's rasteriser threads."""
    found = []
    with contextlib.suppress(OSError):
        for task in _TASKS.iterdir():
            with contextlib.suppress(OSError):
                name = (task / "comm").read_text(encoding="utf-8", errors="replace").strip()
                number = name.removeprefix(_NAME)
                if number != name and number.isdecimal():
                    found.append((int(number), int(task.name)))
    return sorted(found)
