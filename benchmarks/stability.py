"""docs/numerical-stability.md, from the results of `planetfall stress compare` alone."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path

from .machine import device_title
from .schema import Report, ReportError, Row, read_report, write_text
from .store import report_file
from .stress.deviations import ABSOLUTE_BENCH, SUMMARY_BENCH, ULP_BENCH
from .tables import number

__all__ = ["stability", "stability_text"]

SUITE = "compare"
_BAR = 40
"""Characters of a histogram's longest bar."""

_HEAD = """# Numerical stability

Written by `planetfall stress --document` from the results of `planetfall stress compare`; not edited by hand.

Every number below is one that a shader gave at a random place of a random planet, held against float64 (cloud
coordinates: long double) at the very place that single precision was given. Radii are 1 km to 70 000 km (sea: from
10 km), cameras 1 cm to 1e9 m from the ground, times up to 1e8 s; places within a hair of axes, edges and corners of the
cube come often.

- **heights within 1 km**: the height function with all its layers, at vertices within a kilometre of the camera; an ulp
  is that of the height over the anchor, at least of 1 m.
- **heights anywhere**: the same at all other vertices, up to the horizon and beyond.
- **waves**: the displacement of the sea by up to 200 waves, three coordinates; an ulp is that of the case's largest.
- **transmittance of air**: to space, from tables, so that their interpolation is in it as well; an ulp is that of 1.
- **cloud coordinates**: the place in the repeating noise, up to 300 km from the anchor; an ulp is that of the largest
  coordinate before the repeat.

A planet-centred position in single precision would be off by up to 0.25 m on Earth and by 4 m on the largest of these
planets before anything is computed with it.
"""


def stability(results: Path, path: Path) -> Path:
    """Write the page for all results under `results`, beside and renamed. Raises ReportError."""
    write_text(stability_text(results), path)
    return path


def stability_text(results: Path) -> str:
    """The page's text. ReportError where no sweep of the suite has been saved."""
    files = sorted(results.glob(f"*/{report_file('stress', SUITE)}"))
    if not files:
        raise ReportError(f"{results}: no results of stress {SUITE}; run planetfall stress {SUITE} first")
    parts = [_HEAD]
    for file in files:
        parts += _device(read_report(file))
    return "\n".join(parts).rstrip() + "\n"


def _device(report: Report) -> Iterable[str]:
    machine = report.machine
    rows = [row for row in report.rows if row.bench == SUMMARY_BENCH]
    total = sum(int(row.extra.get("numbers") or 0) for row in rows)
    yield f"## {device_title(machine)}\n"
    yield (
        f"{total} numbers. {machine.cpu}; {machine.gl_version}; {report.date[:10]}, commit "
        f"`{report.commit or 'unknown'}`.\n"
    )
    yield _summary(rows)
    for failure in report.failures:
        yield f"Case {failure.index} broke a promise: {'; '.join(failure.messages)}\n"
    for bench, title in ((ULP_BENCH, "Units of the last place"), (ABSOLUTE_BENCH, "Absolute errors")):
        yield f"### {title}\n"
        units = {row.variant: row.error_unit for row in rows}
        for row in (row for row in report.rows if row.bench == bench):
            yield _histogram(row, "ulp" if bench == ULP_BENCH else units.get(row.variant, ""))


def _summary(rows: Sequence[Row]) -> str:
    lines = [
        "| quantity | numbers | median | 99 % | 99.9 % | most | in ulp: median | 99 % | 99.9 % | most |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        unit = f" {row.error_unit}".rstrip()
        own = [f"{_value(row, name)}{unit}" for name in ("median", "p99", "p999")] + [f"{number(row.error)}{unit}"]
        ulps = [_value(row, f"ulp_{name}") for name in ("median", "p99", "p999", "most")]
        lines.append(f"| {' | '.join([row.variant, _value(row, 'numbers'), *own, *ulps])} |")
    return "\n".join(lines) + "\n"


def _value(row: Row, name: str) -> str:
    value = row.extra.get(name)
    return number(float(value)) if isinstance(value, int | float) else ""


def _histogram(row: Row, unit: str) -> str:
    """Bars of the shares; empty bins at both ends are left out."""
    found = [(label, float(share or 0.0)) for label, share in row.extra.items() if isinstance(share, int | float)]
    used = [k for k, (_, share) in enumerate(found) if share > 0.0]
    found = found[used[0] : used[-1] + 1] if used else []
    most = max((share for _, share in found), default=1.0)
    lines = [f"{row.variant}" + (f" ({unit})" if unit else "")]
    for label, share in found:
        bar = "#" * round(_BAR * share / most) or ("." if share > 0.0 else "")
        lines.append(f"{label:>10}  {100.0 * share:8.4f} %  {bar}".rstrip())
    return "```text\n" + "\n".join(lines) + "\n```\n"
