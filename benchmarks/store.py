"""Where results are kept: a folder for each device, a file for each suite."""

from __future__ import annotations

from pathlib import Path

from .machine import device_slug
from .schema import Extent, Report, ReportError, read_report, write_report

_HERE = Path(__file__).resolve().parent


def results_root() -> Path:
    """benchmarks/results in a checkout; planetfall-results in the current folder for an installed package."""
    in_checkout = (_HERE.parent / "pyproject.toml").is_file()
    return _HERE / "results" if in_checkout else Path.cwd() / "planetfall-results"


def document_path(root: Path) -> Path:
    """docs/benchmarks.md for the checkout's own results; benchmarks.md in any other folder of results."""
    return _page(root, "benchmarks.md")


def stability_path(root: Path) -> Path:
    """The same for numerical-stability.md."""
    return _page(root, "numerical-stability.md")


def _page(root: Path, name: str) -> Path:
    own = root.resolve() == _HERE / "results"
    return _HERE.parent / "docs" / name if own else root / name


def report_path(report: Report, root: Path) -> Path:
    """<root>/<device>/<suite>.json; stress runs, quick and full ones beside, under names of their own."""
    return root / device_slug(report.machine) / report_file(report.kind, report.suite, report.extent)


def report_file(kind: str, suite: str, extent: Extent = "usual") -> str:
    """Name of a suite's file in the folder of a device."""
    return f"{'stress-' if kind == 'stress' else ''}{suite}{'' if extent == 'usual' else f'-{extent}'}.json"


def save_report(report: Report, root: Path) -> Path:
    """Write a report where it belongs; the file of the run before is replaced."""
    path = report_path(report, root)
    write_report(report, path)
    return path


def read_reports(place: Path) -> dict[str, Report]:
    """Reports by file name: of one file, or of all files of a folder and its folders."""
    if place.is_dir():
        files = sorted(p for p in place.rglob("*.json") if "failures" not in p.parts)
        if not files:
            raise ReportError(f"{place}: no results in this folder; expected *.json written by planetfall bench")
        return {path.stem: read_report(path) for path in files}
    report = read_report(place)
    return {report.suite: report}
