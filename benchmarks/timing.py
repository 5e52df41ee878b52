"""Wall-clock timing: warm-up, interleaved variants, medians and spread."""

from __future__ import annotations

import gc
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from time import perf_counter_ns
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Timing:
    """Milliseconds of one call: median, 10th and 90th percentile over `runs`."""

    ms: float
    low_ms: float
    high_ms: float
    runs: int

    @classmethod
    def of(cls, samples_ms: list[float]) -> Timing:
        """From measured samples; at least one."""
        low, middle, high = np.quantile(samples_ms, (0.1, 0.5, 0.9))
        return cls(float(middle), float(low), float(high), len(samples_ms))

    def columns(self) -> dict[str, Any]:
        """The time columns of a Row."""
        return {"ms": self.ms, "ms_low": self.low_ms, "ms_high": self.high_ms, "runs": self.runs}


def time_variants(
    variants: Mapping[str, Callable[[], object]],
    runs: int = 20,
    warm_up: int = 3,
    finish: Callable[[], object] | None = None,
    inner: int = 1,
) -> dict[str, Timing]:
    """Time several callables against one another.

    Each round runs every variant once, starting with another one each time, so that a machine that slows down slows
    all alike. finish: called inside the measured time and before it (ctx.finish on a GPU, whose work would otherwise
    count for whoever comes next). inner: calls a sample, for things faster than the clock is good for; the times are
    those of one call. The garbage collector is off while the clock runs.
    """
    if not variants or runs < 1 or inner < 1:
        raise ValueError(
            f"time_variants: expected variants, runs and inner >= 1, found {len(variants)}, {runs}, {inner}"
        )
    names = list(variants)
    samples: dict[str, list[float]] = {name: [] for name in names}
    was_enabled = gc.isenabled()
    gc.collect()
    gc.disable()
    try:
        for turn in range(-warm_up, runs):
            shift = turn % len(names)
            for name in names[shift:] + names[:shift]:
                elapsed = _once(variants[name], finish, inner)
                if turn >= 0:
                    samples[name].append(elapsed)
    finally:
        if was_enabled:
            gc.enable()
    return {name: Timing.of(found) for name, found in samples.items()}


def _once(run: Callable[[], object], finish: Callable[[], object] | None, inner: int) -> float:
    if finish is not None:
        finish()
    started = perf_counter_ns()
    for _ in range(inner):
        run()
    if finish is not None:
        finish()
    return (perf_counter_ns() - started) / (1e6 * inner)
