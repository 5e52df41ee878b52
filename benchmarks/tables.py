"""Reports as tables on the terminal, and two runs side by side."""

from __future__ import annotations

import os
from collections.abc import Iterable
from itertools import groupby

from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from .front import alternatives, front
from .schema import Report, Row

_SPREAD = "p10 .. p90"
_WIDEST = 2000
HISTOGRAM = "histogram"
"""Benches whose names begin so are too wide for a terminal: pages show them."""


def show_report(report: Report, console: Console) -> None:
    """A table for each bench, then what could not run."""
    machine = report.machine
    tables = [
        rows_table(bench, list(rows))
        for bench, rows in groupby(report.rows, key=lambda row: row.bench)
        if not bench.startswith(HISTOGRAM)
    ]
    widen(console, tables)
    console.print(
        f"[bold]{report.suite}[/] {report.kind}  planetfall {report.planetfall} {report.commit}  {report.date}  "
        f"{report.duration_s:g} s{'' if report.extent == 'usual' else f'  ({report.extent})'}",
        highlight=False,
    )
    console.print(
        f"{machine.cpu}, {machine.cpus} CPUs, load {machine.load_average:g}; {machine.gl_renderer or 'no GL'} "
        f"({machine.gl_version}); {machine.python}",
        style="dim",
        highlight=False,
    )
    for table in tables:
        console.print(table)
    for name, why in report.skipped.items():
        console.print(Text(f"{name}: did not run: {why}", style="red"))
    if report.left_out:
        console.print(f"left out of a quick run: {', '.join(report.left_out)}", style="dim")
    for failure in report.failures:
        place = f" -> {failure.file}" if failure.file else ""
        console.print(Text(f"case {failure.index}: {'; '.join(failure.messages)}{place}", style="red"), soft_wrap=True)
    missed = [row for row in report.rows if row.met is False]
    promised = sum(row.met is not None for row in report.rows)
    if promised:
        style = "yellow" if missed else "green"
        console.print(f"{promised - len(missed)} of {promised} targets met", style=style)


def widen(console: Console, tables: Iterable[Table]) -> None:
    """Make a console that is no terminal (a file, a pipe) as wide as its widest table: in 80 columns nobody could read
    many. One that COLUMNS gives a width stays."""
    if console.is_terminal or "COLUMNS" in os.environ:
        return
    unbound = console.options.update(width=_WIDEST)
    widths = [Measurement.get(console, unbound, table).maximum for table in tables]
    console.width = max(console.width, *widths, 0)


def rows_table(title: str, rows: list[Row]) -> Table:
    """Only the columns that some row uses."""
    table = Table(title=title, title_justify="left", title_style="bold", pad_edge=False)
    names = columns_of(rows)
    for name in names:
        left = name in ("variant", "view", "size", "target")
        table.add_column(name, justify="left" if left else "right", style="dim" if name == _SPREAD else "")
    best = {id(row) for group in alternatives(rows) for row in front(group)}
    for row in rows:
        cells: dict[str, Text | str] = dict(row_cells(row, names))
        if "target" in cells:
            cells["target"] = Text(row.target, style={True: "green", False: "bold red", None: ""}[row.met])
        if id(row) in best and "ms" in cells:
            cells["ms"] = Text(str(cells["ms"]), style="bold green")
        table.add_row(*(cells[name] for name in names))
    return table


def columns_of(rows: Iterable[Row]) -> list[str]:
    """Names of the columns that some row uses, in order; extras last."""
    rows = list(rows)
    has = {
        "variant": any(row.variant for row in rows),
        "view": any(row.view for row in rows),
        "size": any(row.size for row in rows),
        "ms": any(row.ms is not None for row in rows),
        _SPREAD: any(row.ms is not None for row in rows),
        "error": any(row.error is not None for row in rows),
        "target": any(row.target for row in rows),
    }
    return [name for name in has if has[name]] + list(dict.fromkeys(key for row in rows for key in row.extra))


def row_cells(row: Row, names: Iterable[str]) -> dict[str, str]:
    """A row's text by column."""
    cells = {
        "variant": row.variant,
        "view": row.view,
        "size": "" if row.size is None else f"{row.size[0]} x {row.size[1]}",
        "ms": number(row.ms),
        _SPREAD: "" if row.ms is None else f"{number(row.ms_low)} .. {number(row.ms_high)}",
        "error": "" if row.error is None else f"{number(row.error)} {row.error_unit}".rstrip(),
        "target": row.target,
    }
    return {name: cells[name] if name in cells else _value(row.extra.get(name)) for name in names}


def compare(old: Report, new: Report) -> list[tuple[Row, Row]]:
    """Rows of the same measurement in both, in the order of the new one."""
    before = {_key(row): row for row in old.rows}
    return [(before[_key(row)], row) for row in new.rows if _key(row) in before]


def show_comparison(old: Report, new: Report, console: Console) -> None:
    """Times as ratios, errors side by side; new / old, so below 1 is faster."""
    if old.machine.gl_renderer != new.machine.gl_renderer or old.machine.cpu != new.machine.cpu:
        console.print(
            f"different machines ({old.machine.cpu}, {old.machine.gl_renderer} and {new.machine.cpu}, "
            f"{new.machine.gl_renderer}): compare errors only, not times",
            style="yellow",
        )
    pairs = compare(old, new)
    table = Table(title=f"{new.suite}: {old.commit or old.date} -> {new.commit or new.date}", title_justify="left")
    for name in ("bench", "variant", "view"):
        table.add_column(name)
    for name in ("ms old", "ms new", "new / old", "error old", "error new"):
        table.add_column(name, justify="right")
    for before, after in pairs:
        ratio = Text("")
        if before.ms and after.ms is not None:
            apart = (after.ms_low or 0.0) > (before.ms_high or 0.0) or (after.ms_high or 0.0) < (before.ms_low or 0.0)
            share = after.ms / before.ms
            # Coloured only where the spreads do not overlap.
            ratio = Text(f"{share:.2f}", style="" if not apart else "red" if share > 1 else "green")
        table.add_row(
            after.bench, after.variant, after.view, number(before.ms), number(after.ms), ratio,
            f"{number(before.error)} {before.error_unit}".strip(), f"{number(after.error)} {after.error_unit}".strip(),
        )  # fmt: skip
    widen(console, [table])
    console.print(table)
    gone = _names(old.rows) - _names(new.rows)
    added = _names(new.rows) - _names(old.rows)
    if gone or added:
        console.print(f"only in the old run: {len(gone)}; only in the new one: {len(added)}", style="dim")


def number(value: float | None) -> str:
    """Three digits; whole numbers as such."""
    if value is None:
        return ""
    if isinstance(value, int) or (abs(value) < 1e7 and value == round(value)):
        return f"{value:.0f}"
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:.4g}"


def _value(value: bool | int | float | str | None) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    return value if isinstance(value, str) else number(value)


def _key(row: Row) -> tuple[str, str, str, str]:
    return row.bench, row.variant, row.view, str(row.size)


def _names(rows: Iterable[Row]) -> set[tuple[str, str, str, str]]:
    return {_key(row) for row in rows}
