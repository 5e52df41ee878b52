"""docs/benchmarks.md, every promise and the tables of each device, from the results files alone."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Sequence
from itertools import groupby
from pathlib import Path

from .front import alternatives, front
from .machine import device_title
from .schema import EXTENTS, Report, ReportError, Row, read_report, write_text
from .stress.runner import STRESS_SUITES
from .suites import SUITES, benches_of
from .tables import columns_of, number, row_cells

__all__ = ["document", "document_text", "promises_text", "tables_text"]

BUSY_LOAD = 0.3
"""Runnable processes a CPU above which times are those of a busy machine (schema.Machine.load_average)."""
LONG_TABLE = 16
"""Rows above which a table is folded."""

_HEAD = """# Benchmarks

Written by `planetfall bench --document` from the files under `benchmarks/results`; not edited by hand. How to run and
read benches: [benchmarks-howto.md](benchmarks-howto.md).

A promise is a bound that a measurement has to keep: the most time it may take (on an idle machine), the largest error,
a range. Below: how many are kept and which are missed; bench by bench: [every promise]({promises}).
All measurements, in tables with plots, lie beside the results of each device.
Beside a browser's sky and clouds: [how frames are compared]({peers}).
"""
_PROMISES_HEAD = """# Every promise

Written by `planetfall bench --document` from the files in these folders; not edited by hand. What each bench promises,
and how many of its promises each device kept.
"""
_TABLES_HEAD = """Written by `planetfall bench --document` from the files beside this one; not edited by hand.

Times are compared within one run on one machine. **bold** in the column `ms`: no other row of the same view has both
less time and less error (the Pareto front; rows with `cpu_ms` are compared by that). A target in ~~strikes~~ was
missed.
"""
TABLES = "tables.md"
"""A device's tables, in the folder of its results."""
PROMISES = "README.md"
"""Every promise, beside the folders of the devices."""
PEERS = "benchmarks-howto.md#beside-a-browsers-sky-and-clouds"
MOST_TARGETS = 4
"""Different targets of a bench that are named one by one."""


def document(results: Path, path: Path) -> Path:
    """Write the page of all `results`; beside them every promise and each device's tables. Raises ReportError."""
    page = document_text(results, path.parent)
    write_text(promises_text(results), results / PROMISES)
    for folder, reports in _devices(results):
        write_text(tables_text(folder, reports), folder / TABLES)
    write_text(page, path)
    return path


def document_text(results: Path, page_folder: Path) -> str:
    """The page's text; tables are linked relative to `page_folder`. GPUs come first, then what has most results."""
    devices = _devices(results)
    parts = [_HEAD.format(promises=_link(results / PROMISES, page_folder), peers=PEERS)]
    if all(reports[0].machine.is_software for _, reports in devices):
        parts[0] += (
            "No suite was run on a GPU yet. What frames, pictures and tests were on one: [drivers](drivers.md#a-gpu).\n"
        )
    parts.append(_in_short(devices))
    for folder, reports in devices:
        link = _link(folder / TABLES, page_folder)
        parts.append(f"## {device_title(reports[0].machine)}\n")
        parts.append(f"{_machine(reports)}[All tables]({link}). {_missed(reports)}")
    return "\n".join(parts).rstrip() + "\n"


def _link(file: Path, page_folder: Path) -> str:
    return Path(os.path.relpath(file, page_folder)).as_posix()


def promises_text(results: Path) -> str:
    """A row a bench: what is promised, and how many promises each device kept of how many."""
    devices = _devices(results)
    columns = [_by_bench(reports) for _, reports in devices]
    lines = [_PROMISES_HEAD, *_header(("bench", "what it measures", "promised"), devices)]
    for name in dict.fromkeys(name for column in columns for name in column):
        targets = list(dict.fromkeys(row.target for column in columns for row in column.get(name, ())))
        more = f", and {len(targets) - MOST_TARGETS} more" if len(targets) > MOST_TARGETS else ""
        counts = " | ".join(_kept(column.get(name, [])) for column in columns)
        lines.append(f"| {name} | {_what(name)} | {_plain('; '.join(targets[:MOST_TARGETS]))}{more} | {counts} |")
    return "\n".join(lines) + "\n"


def tables_text(folder: Path, reports: Sequence[Report] | None = None) -> str:
    """All rows of a device's results, bench by bench; plots are linked beside."""
    reports = _reports(folder) if reports is None else reports
    parts = [f"# {device_title(reports[0].machine)}\n", _TABLES_HEAD, _machine(reports)]
    for report in reports:
        parts += _suite(report, folder)
    return "\n".join(parts).rstrip() + "\n"


def _devices(results: Path) -> list[tuple[Path, list[Report]]]:
    folders = sorted({file.parent for file in results.glob("*/*.json")})
    if not folders:
        raise ReportError(f"{results}: no results in this folder; run planetfall bench first")
    devices = [(folder, _reports(folder)) for folder in folders]
    return sorted(devices, key=lambda device: (device[1][0].machine.is_software, -len(device[1]), device[0].name))


def _reports(folder: Path) -> list[Report]:
    """The most thorough run of each suite, in the order of the suites."""
    found: dict[tuple[str, str], Report] = {}
    for file in sorted(folder.glob("*.json")):
        if file.name.startswith("stress-compare"):
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


def _machine(reports: Sequence[Report]) -> str:
    machine = reports[0].machine
    return (
        f"{machine.cpu}, {machine.cpus} CPUs, {machine.memory_bytes / 2**30:.0f} GiB; {machine.gl_version}; "
        f"Python {machine.python}, moderngl {machine.moderngl}, numpy {machine.numpy}; {machine.system}.\n"
    )


def _by_bench(reports: Iterable[Report]) -> dict[str, list[Row]]:
    """The rows that promise something, by the name of their bench."""
    found: dict[str, list[Row]] = {}
    for report in reports:
        for row in report.rows:
            if row.met is not None:
                name = f"{'stress ' if report.kind == 'stress' else ''}{row.suite}.{row.bench}"
                found.setdefault(name, []).append(row)
    return found


Devices = Sequence[tuple[Path, Sequence[Report]]]


def _in_short(devices: Devices) -> str:
    """A row a suite: what it measures, and how many promises each device kept of how many."""
    columns = [[row for rows in _by_bench(reports).values() for row in rows] for _, reports in devices]
    lines = ["## In short\n", *_header(("suite", "what it measures"), devices)]
    for suite in dict.fromkeys(row.suite for column in columns for row in column):
        counts = " | ".join(_kept([row for row in column if row.suite == suite]) for column in columns)
        lines.append(f"| {suite} | {_plain({**STRESS_SUITES, **SUITES}.get(suite, ''))} | {counts} |")
    return "\n".join([*lines, f"| all | | {' | '.join(map(_kept, columns))} |"]) + "\n"


def _header(columns: Sequence[str], devices: Devices) -> list[str]:
    names = [*columns, *(_plain(device_title(reports[0].machine)) for _, reports in devices)]
    return [f"| {' | '.join(names)} |", f"|{'---|' * len(names)}"]


def _what(bench: str) -> str:
    """What a bench measures: the first sentence about it; nothing of one that is gone."""
    suite, _, name = bench.partition(".")
    if suite.startswith("stress "):
        return _plain(STRESS_SUITES.get(suite.removeprefix("stress "), ""))
    found = benches_of(suite).get(name) if suite in SUITES else None
    return _plain(" ".join(((found and found.__doc__) or "").split()).partition(". ")[0].rstrip("."))


def _kept(rows: Sequence[Row]) -> str:
    """ "3 of 4"; bold where something was missed, empty where nothing was measured."""
    kept = sum(row.met is True for row in rows)
    text = f"{kept} of {len(rows)}" if rows else ""
    return f"**{text}**" if kept < len(rows) else text


def _missed(reports: Sequence[Report]) -> str:
    """What was promised and missed: of each bench the row that is farthest off."""
    benches = _by_bench(reports)
    rows = [row for rows in benches.values() for row in rows]
    kept = sum(row.met is True for row in rows)
    text = f"{kept} of {len(rows)} promises are kept."
    if kept == len(rows):
        return text + "\n"
    lines = [
        text + " Missed, with the one of each bench that is farthest off:\n",
        "| bench | missed | farthest off | view | ms | error | target |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, promised in benches.items():
        missed = [row for row in promised if row.met is False]
        if missed:
            worst = max(missed, key=_times_off)
            lines.append(
                f"| {name} | {len(missed)} of {len(promised)} | {_plain(worst.variant)} | {worst.view} |"
                f" {number(worst.ms)} | {number(worst.error)} {worst.error_unit} | {worst.target} |"
            )
    return "\n".join(lines) + "\n"


def _times_off(row: Row) -> float:
    """How many times its target a row is; 1 where the target is no single bound."""
    words = re.fullmatch(r"(\w+ )?([<>]=) ([-+\d.e]+)(.*)", row.target)
    if words is None:
        return 1.0
    name, least, bound = (words[1] or "").strip(), words[2] == ">=", float(words[3])
    found = row.extra.get(name) if name else row.ms if words[4].strip() == "ms" else row.error
    if not isinstance(found, (int, float)) or found == 0.0 or bound == 0.0:
        return 1.0
    return bound / found if least else found / bound


def _suite(report: Report, folder: Path) -> Iterable[str]:
    title = report.suite if report.kind == "bench" else f"stress {report.suite}"
    yield f"## {title}\n"
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
            yield f"![{report.suite}.{bench}]({plot.name})\n"


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
