"""Which settings are worth their time: those that no other beats in both run time and error.

Only some benches have rows that are alternatives for the same picture; in the others (a knob's cost beside what it
shows, errors by radius) a front would say nothing.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import groupby

from .schema import Row

__all__ = ["ALTERNATIVES", "alternatives", "axis_of", "front", "row_ms"]

ALTERNATIVES: dict[str, str] = {
    "atmosphere.curve": "cpu_ms",
    "clouds.curve": "cpu_ms",
    "ocean.speed": "",
    "terrain.backends": "",
    "terrain.error": "",
    "terrain.grid_methods": "",
    "terrain.icosphere": "",
    "whole.asteroid": "",
    "whole.earth": "",
    "whole.hazy": "",
    "whole.mars": "",
    "whole.moon": "",
    "whole.small": "",
}
"""Benches whose rows of one view, size and unit are alternatives, and the extra that is their time (empty: ms)."""


def row_ms(row: Row) -> float | None:
    """The time that a row of ALTERNATIVES is judged by, in ms."""
    extra = ALTERNATIVES.get(f"{row.suite}.{row.bench}", "")
    value = row.extra.get(extra) if extra else row.ms
    return float(value) if isinstance(value, int | float) else None


def axis_of(row: Row) -> str:
    """What row_ms is, for who draws it."""
    return "processor time (ms)" if ALTERNATIVES.get(f"{row.suite}.{row.bench}") == "cpu_ms" else "ms"


def alternatives(rows: Iterable[Row]) -> list[list[Row]]:
    """Rows of ALTERNATIVES with time and error, in groups that answer the same question; two rows or more each."""
    fit = [
        row
        for row in rows
        if f"{row.suite}.{row.bench}" in ALTERNATIVES and row.error is not None and row_ms(row) is not None
    ]

    def question(row: Row) -> tuple[str, str, str, str]:
        return row.bench, row.view, str(row.size), row.error_unit

    groups = [list(group) for _, group in groupby(sorted(fit, key=question), key=question)]
    return [group for group in groups if len(group) > 1]


def front(group: Sequence[Row]) -> list[Row]:
    """The Pareto front of a group, fastest first: each has less error than every faster one."""
    best: list[Row] = []
    for row in sorted(group, key=lambda r: (row_ms(r), r.error)):
        if not best or (row.error or 0.0) < (best[-1].error or 0.0):
            best.append(row)
    return best
