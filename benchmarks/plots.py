"""Plots of reports, beside their files: run time against error of the air. Needs matplotlib, the extra "plots"."""

from __future__ import annotations

from pathlib import Path

from .schema import Report, Row

MISSING = "no plot: matplotlib is missing; pip install planetfall[plots]"
_CURVE = "curve"


def save_plots(report: Report, folder: Path) -> list[Path]:
    """Writes the plots of a report that has any; their paths. ImportError without matplotlib."""
    rows = [row for row in report.rows if report.suite == "atmosphere" and row.bench == _CURVE]
    if report.quick or not rows:
        return []
    path = folder / f"{report.suite}-{_CURVE}.png"
    _curve(rows, path)
    return [path]


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


def _processor_ms(row: Row) -> float:
    return float(row.extra["cpu_ms"] or 0.0)


def _errors(row: Row) -> dict[str, float]:
    """By class of question: the row's own, and its extras."""
    own = row.error_unit.removeprefix("p95, ")
    extras = {name: float(value or 0.0) for name, value in row.extra.items() if name != "cpu_ms"}
    return {own: row.error or 0.0, **extras}
