"""Plots of reports, beside their files: run time against error. Needs matplotlib, extra "plots"."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby, takewhile
from pathlib import Path

from .front import alternatives, axis_of, front, row_ms
from .schema import Report, Row
from .store import report_file

MISSING = "no plot: matplotlib is missing; pip install planetfall[plots]"
_CURVE, _BACKENDS = "curve", "backends"


def save_plots(report: Report, folder: Path, quick: bool = False) -> list[Path]:
    """Writes the plots of a report that has any; their paths. quick: those of a quick run, too, under names of their
    own. ImportError without matplotlib."""
    made: list[Path] = []
    if report.extent == "quick" and not quick:
        return made
    stem = report_file("bench", report.suite, report.extent).removesuffix(".json")
    for suite, bench, draw in (("atmosphere", _CURVE, _curve), ("terrain", _BACKENDS, _backends)):
        rows = [row for row in report.rows if report.suite == suite and row.bench == bench]
        if rows:
            made.append(folder / f"{stem}-{bench}.png")
            draw(rows, made[-1])
    drawn = {path.stem for path in made}
    for bench, groups in groupby(alternatives(report.rows), key=lambda group: group[0].bench):
        if f"{stem}-{bench}" not in drawn:
            made.append(folder / f"{stem}-{bench}.png")
            _fronts(bench, list(groups), made[-1])
    return made


def _fronts(bench: str, groups: list[list[Row]], path: Path) -> None:
    """A panel a view (or unit), a point a row; the line is the Pareto front."""
    from matplotlib.figure import Figure  # pyright: ignore[reportMissingImports]

    across = min(len(groups), 3)
    down = -(-len(groups) // across)
    figure = Figure(figsize=(4.6 * across, 3.8 * down), dpi=110, layout="constrained")
    panels = figure.subplots(down, across, squeeze=False).ravel()
    for axes, group in zip(panels, groups, strict=False):
        points = {id(row): (row_ms(row), row.error) for row in group}
        # Words that all labels begin with say nothing.
        words = zip(*(row.variant.split() for row in group), strict=False)
        shared = len(list(takewhile(lambda word: len(set(word)) == 1, words)))
        best = front(group)
        axes.plot(*zip(*(points[id(row)] for row in best), strict=True), "-", color="C0", alpha=0.5)
        for row in group:
            color = "C0" if row in best else "0.6"
            axes.plot(*points[id(row)], "o", color=color)
            label = " ".join(row.variant.split()[shared:]) or row.variant
            axes.annotate(label, points[id(row)], (4, 4), textcoords="offset points", fontsize=7, color=color)
        logs = {"yscale": "log"} if all((row.error or 0.0) > 0.0 for row in group) else {}
        axes.set(xlabel=axis_of(group[0]), ylabel=group[0].error_unit, title=group[0].view or bench, **logs)
        axes.grid(which="both", alpha=0.25)
        axes.margins(0.15)
    for axes in panels[len(groups) :]:
        axes.remove()
    figure.savefig(path)


def _backends(rows: list[Row], path: Path) -> None:
    """A panel a view, a line a backend, a point a quality: time of a frame against the error on screen."""
    from matplotlib.figure import Figure  # pyright: ignore[reportMissingImports]

    views = list(dict.fromkeys(row.view for row in rows))
    figure = Figure(figsize=(4.2 * len(views), 4.2), dpi=110, layout="constrained")
    for axes, view in zip(figure.subplots(1, len(views), squeeze=False)[0], views, strict=True):
        for number, backend in enumerate(dict.fromkeys(row.variant.split(", ")[0] for row in rows)):
            own = [row for row in rows if row.view == view and row.variant.startswith(f"{backend}, ")]
            points = [(float(row.ms or 0.0), float(row.error or 0.0)) for row in own]
            axes.plot(*zip(*points, strict=True), "o-", color=f"C{number}", label=backend)
            for row, place in zip(own, points, strict=True):
                axes.annotate(row.variant.split(", ")[1], place, (4, 4), textcoords="offset points", fontsize=7)
        axes.set(yscale="log", xlabel="frame, turning, 640 x 360 (ms)", title=view)
        axes.grid(which="both", alpha=0.25)
        axes.margins(0.12)
    figure.axes[0].set(ylabel="99th percentile of the error on screen (px)")
    figure.axes[0].legend()
    figure.savefig(path)


def _curve(rows: list[Row], path: Path) -> None:
    """One line a class of question, one point a quality, both axes logarithmic."""
    from matplotlib.figure import Figure  # pyright: ignore[reportMissingImports]

    figure = Figure(figsize=(8.0, 5.0), dpi=110, layout="constrained")
    axes = figure.subplots()
    ours = sorted((row for row in rows if row.variant != "paper"), key=_processor_ms)
    paper = [row for row in rows if row.variant == "paper"]
    for number, name in enumerate(_errors(rows[0])):
        color = f"C{number}"
        axes.plot([_processor_ms(r) for r in ours], [_errors(r)[name] for r in ours], "o-", color=color, label=name)
        axes.plot([_processor_ms(r) for r in paper], [_errors(r)[name] for r in paper], "x", color=color, ms=9)
    below, above = ((0, -14), "top"), ((0, 8), "bottom")
    for row in rows:
        offset, side = above if row.variant == "paper" else below
        lowest = (max if row.variant == "paper" else min)(_errors(row).values())
        label = "paper (x)" if row.variant == "paper" else row.variant
        place = (_processor_ms(row), lowest)
        axes.annotate(label, place, offset, textcoords="offset points", ha="center", va=side)
    axes.set(
        xscale="log", yscale="log", xlabel="processor time of sky and air, camera climbing, 640 x 360 (ms)",
        ylabel="95th percentile of the error",
    )  # fmt: skip
    axes.margins(0.12)
    axes.xaxis.set_major_formatter("{x:g}")
    axes.xaxis.set_minor_formatter("{x:g}")
    axes.grid(which="both", alpha=0.25)
    axes.legend()
    figure.savefig(path)


def draw_series(columns: Mapping[str, Sequence[float]], title: str, path: Path) -> None:
    """Lines over the first column, which is logarithmic and runs from high to low, as a flight down does."""
    from matplotlib.figure import Figure  # pyright: ignore[reportMissingImports]

    (across, places), *lines = columns.items()
    figure = Figure(figsize=(8.0, 4.0), dpi=110, layout="constrained")
    axes = figure.subplots()
    for name, values in lines:
        axes.plot(places, values, "-", linewidth=1.0, label=name)
    axes.set(xscale="log", xlabel=across, title=title)
    axes.invert_xaxis()
    axes.grid(which="both", alpha=0.25)
    axes.legend()
    figure.savefig(path)


def _processor_ms(row: Row) -> float:
    return float(row.extra["cpu_ms"] or 0.0)


def _errors(row: Row) -> dict[str, float]:
    """By class of question: the row's own, and its extras."""
    own = row.error_unit.removeprefix("p95, ")
    extras = {name: float(value or 0.0) for name, value in row.extra.items() if name != "cpu_ms"}
    return {own: row.error or 0.0, **extras}
