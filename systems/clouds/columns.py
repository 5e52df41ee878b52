"""Heights at which maps of the clouds' shadow know how much sunlight is left: where they lie in the layers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...components import CloudLayer
from ...engine.blocks.layout import zeros
from .layers import kind_of
from .view_block import MOST_INTERVALS, MOST_LAYERS, CloudKind, CloudSpan

__all__ = ["Span", "intervals_of", "span_rows", "spans_of"]

_THIN_INTERVALS = 2
"""Of a span with nothing but cirrus in it: little light is lost there."""


@dataclass(frozen=True)
class Span:
    """Heights with cloud, from base_m to top_m, cut into `intervals` equal ones. Between spans there is none."""

    base_m: float
    top_m: float
    intervals: int


def spans_of(layers: Sequence[CloudLayer], steps: int) -> list[Span]:
    """Spans of layers that are sorted by their bases, lowest first; those that overlap are one.

    steps: how finely a layer is sampled; more intervals than that would be empty.
    """
    merged: list[tuple[float, float, bool]] = []
    for layer in layers:
        base, top, thin = float(layer.base_m), float(layer.top_m), kind_of(layer) == CloudKind.CIRRUS
        if merged and base <= merged[-1][1]:
            low, high, all_thin = merged[-1]
            merged[-1] = low, max(high, top), all_thin and thin
        else:
            merged.append((base, top, thin))
    thick = sum(not thin for _, _, thin in merged)
    left = MOST_INTERVALS - _THIN_INTERVALS * (len(merged) - thick)
    counts = [min(_THIN_INTERVALS if thin else left // max(thick, 1), steps) for _, _, thin in merged]
    return [Span(base, top, count) for (base, top, _), count in zip(merged, counts, strict=True)]


def intervals_of(spans: Sequence[Span]) -> NDArray[np.float32]:
    """(intervals, 2) heights from and to, lowest first."""
    rows = [
        (s.base_m + (s.top_m - s.base_m) * k / s.intervals, s.base_m + (s.top_m - s.base_m) * (k + 1) / s.intervals)
        for s in spans
        for k in range(s.intervals)
    ]
    return np.array(rows, np.float32).reshape(-1, 2)


def span_rows(spans: Sequence[Span]) -> list[CloudSpan]:
    """For CloudViewBlock.spans."""
    rows = [CloudSpan(span.base_m, 1.0 / (span.top_m - span.base_m), span.intervals) for span in spans]
    return rows + [zeros(CloudSpan)] * (MOST_LAYERS - len(rows))
