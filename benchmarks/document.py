"""docs/benchmarks.md, from the results files alone: tables, fronts, plots, machine, date and commit."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path

from .front import alternatives, front
from .machine import device_title
from .schema import EXTENTS, Report, ReportError, Row, read_report, write_text
from .store import report_file
from .suites import SUITES
from .tables import columns_of, number, row_cells

__all__ = ["document", "document_text"]

BUSY_LOAD = 0.3
"""Runnable processes a CPU above which times are those of a busy machine (schema.Machine.load_average)."""
LONG_TABLE = 16
"""Rows above which a table is folded."""

_HEAD = """# Benchmarks

Written by `planetfall bench --document` from the files under `benchmarks/results`; not edited by hand. How to run and
read them: [benchmarks-howto.md](benchmarks-howto.md).

Times are compared within one run on one machine. **bold** in the column `ms`: no other row of the same view has both
less time and less error (the Pareto front; rows with `cpu_ms` are compared by that). A target in ~~strikes~~ was
missed.
"""


def document(results: Path, path: Path) -> Path:
    """Write the page for all results under `results`, beside and renamed. Raises ReportError."""
    write_text(document_text(results, path.parent), path)
    return path


def document_text(results: Path, page_folder: Path) -> str:
    """The page's text; plots are linked relative to `page_folder`. GPUs come first, then what has most results."""
    folders = sorted({file.parent for file in results.glob("*/*.json")})
    if not folders:
        raise ReportError(f"{results}: no results in this folder; run planetfall bench first")
    devices = [(folder, _reports(folder)) for folder in folders]
    devices.sort(key=lambda device: (device[1][0].machine.is_software, -len(device[1]), device[0].name))
    parts = [_HEAD]
    if all(reports[0].machine.is_software for _, reports in devices):
        parts.append("Not measured on a GPU yet.\n")
    for folder, reports in devices:
        parts += _device(folder, reports, page_folder)
    return "\n".join(parts).rstrip() + "\n"


def _reports(folder: Path) -> list[Report]:
    """The most thorough run of each suite, in the order of the suites."""
    found: dict[tuple[str, str], Report] = {}
    for file in sorted(folder.glob("*.json")):
        if file.name == report_file("stress", "compare"):
            continue  # has a page of its own: docs/numerical-stability.md
        report = read_report(file)
        key = (report.kind, report.suite)
        if key not in found or EXTENTS.index(report.extent) > EXTENTS.index(found[key].extent):
            found[key] = report
    order = list(SUITES)
    return sorted(
        found.values(),
        key=lambda r: (r.kind, order.index(r.suite) if r.suite in order else len(order), r.suite),
    )


def _device(folder: Path, reports: Sequence[Report], page_folder: Path) -> Iterable[str]:
    machine = reports[0].machine
    yield f"## {device_title(machine)}\n"
    yield (
        f"{machine.cpu}, {machine.cpus} CPUs, {machine.memory_bytes / 2**30:.0f} GiB; {machine.gl_version}; "
        f"Python {machine.python}, moderngl {machine.moderngl}, numpy {machine.numpy}; {machine.system}.\n"
    )
    yield _promises(reports)
    for report in reports:
        yield from _suite(report, folder, page_folder)


def _promises(reports: Sequence[Report]) -> str:
    """What was promised and missed, in one table: the first thing that a reader should see."""
    rows = [row for report in reports for row in report.rows if row.met is not None]
    missed = [row for row in rows if row.met is False]
    text = f"{len(rows) - len(missed)} of {len(rows)} promises are kept."
    if not missed:
        return text + "\n"
    lines = [text + " Missed:\n", "| bench | variant | view | ms | error | target |", "|---|---|---|---|---|---|"]
    lines += [
        f"| {row.suite}.{row.bench} | {_plain(row.variant)} | {row.view} | {number(row.ms)} |"
        f" {number(row.error)} {row.error_unit} | {row.target} |"
        for row in missed
    ]
    return "\n".join(lines) + "\n"


def _suite(report: Report, folder: Path, page_folder: Path) -> Iterable[str]:
    title = report.suite if report.kind == "bench" else f"stress {report.suite}"
    yield f"### {title}\n"
    extent = "" if report.extent == "usual" else f", {report.extent} run"
    busy = f"; busy machine (load {report.machine.load_average:g} a CPU)"
    yield (
        f"{SUITES.get(report.suite, '') + '. ' if report.kind == 'bench' else ''}{report.date[:10]}, commit "
        f"`{report.commit or 'unknown'}`, {report.duration_s:.0f} s{extent}"
        f"{busy if report.machine.load_average > BUSY_LOAD else ''}.\n"
    )
    if report.left_out:
        yield f"Left out of the quick run: {', '.join(report.left_out)}.\n"
    for name, why in report.skipped.items():
        yield f"`{name}` did not run: {_plain(why)}\n"
    for failure in report.failures:
        yield f"Case {failure.index} failed: {_plain('; '.join(failure.messages))}\n"
    best = {id(row) for group in alternatives(report.rows) for row in front(group)}
    for bench, rows in groupby(report.rows, key=lambda row: row.bench):
        yield _table(bench, list(rows), best)
        plot = folder / f"{report.suite}-{bench}.png"
        if plot.is_file() and report.kind == "bench":
            yield f"![{report.suite}.{bench}]({Path(os.path.relpath(plot, page_folder)).as_posix()})\n"


def _table(bench: str, rows: list[Row], best: set[int]) -> str:
    names = columns_of(rows)
    lines = [f"| {' | '.join(names)} |", f"|{'---|' * len(names)}"]
    for row in rows:
        cells = {name: _plain(cell) for name, cell in row_cells(row, names).items()}
        if id(row) in best and cells.get("ms"):
            cells["ms"] = f"**{cells['ms']}**"
        if row.met is False:
            cells["target"] = f"~~{cells['target']}~~"
        lines.append(f"| {' | '.join(cells[name] for name in names)} |")
    table = "\n".join(lines)
    if len(rows) > LONG_TABLE:
        return f"<details><summary><b>{bench}</b> ({len(rows)} rows)</summary>\n\n{table}\n\n</details>\n"
    return f"**{bench}**\n\n{table}\n"


def _plain(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")
