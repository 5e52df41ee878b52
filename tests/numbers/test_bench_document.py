"""The page of results that the program writes, and the Pareto fronts in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from tiers import skip_if_results_are_new

from planetfall import SettingError
from planetfall.benchmarks import cli
from planetfall.benchmarks.document import PROMISES, TABLES, document, document_text, promises_text, tables_text
from planetfall.benchmarks.front import ALTERNATIVES, alternatives, front
from planetfall.benchmarks.machine import describe_machine
from planetfall.benchmarks.plots import save_plots
from planetfall.benchmarks.schema import Report, ReportError, Row
from planetfall.benchmarks.store import results_root, save_report
from planetfall.benchmarks.suites import SUITES, benches_of

ROOT = Path(__file__).parents[2]


def error_row(variant: str, ms: float | None, error: float | None, view: str = "near", **changes) -> Row:
    return Row(
        suite="terrain", bench="error", variant=variant, view=view, ms=ms, error=error, error_unit="px", **changes
    )


def report_of(*rows: Row, **changes) -> Report:
    machine = changes.pop("machine", describe_machine(None))
    fields = {
        "kind": "bench",
        "suite": "terrain",
        "planetfall": "0.0",
        "commit": "abc123",
        "date": "2026-01-02T00:00:00Z",
    }
    return Report(**{**fields, "duration_s": 1.0, "machine": machine, "rows": list(rows), **changes})


def test_the_front_is_what_nothing_beats_in_both():
    rows = [error_row("low", 1, 9), error_row("bad", 3, 5), error_row("medium", 2, 4), error_row("high", 8, 1)]
    assert [row.variant for row in front(rows)] == ["low", "medium", "high"]
    assert [row.variant for row in front([error_row("a", 1, 2), error_row("b", 1, 1)])] == ["b"], "equal times"


def test_only_rows_that_answer_the_same_question_are_compared():
    rows = [error_row("a", 1, 2), error_row("b", 2, 1), error_row("c", 1, 1, "high"), error_row("d", None, 1)]
    rows.append(Row(suite="frame", bench="knobs", variant="on", view="near", ms=1, error=1, error_unit="px"))
    assert [[row.variant for row in group] for group in alternatives(rows)] == [["a", "b"]]


def test_every_bench_of_alternatives_is_there():
    known = {f"{suite}.{bench}" for suite in SUITES for bench in benches_of(suite)}
    assert set(ALTERNATIVES) <= known


def test_the_page_says_machine_commit_front_misses_and_failures(tmp_path):
    rows = [
        error_row("low", 1.0, 9.0, target="<= 5 px", met=False),
        error_row("slow | wrong", 7.0, 9.5, target="<= 10 px", met=True),
    ]
    report = report_of(*rows, skipped={"terrain.holes": "no GL"})
    save_report(report, tmp_path)
    save_report(report_of(error_row("quick", 1.0, 1.0), extent="quick"), tmp_path)
    page = document(tmp_path, tmp_path / "page.md")
    short = page.read_text()
    (tables,) = tmp_path.glob(f"*/{TABLES}")
    text = tables.read_text()
    assert "commit `abc123`" in text and report.machine.cpu in text and report.machine.cpu in short
    assert f"({tables.relative_to(tmp_path).as_posix()})" in short
    what = "Run time against error, over qualities: the drawn ground against TerrainSampler in pixels"
    assert f"| terrain.error | {what} | <= 5 px; <= 10 px | **1 of 2** |" in (tmp_path / PROMISES).read_text()
    assert f"| terrain | {SUITES['terrain']} | **1 of 2** |" in short and "| all | | **1 of 2** |" in short
    assert "1 of 2 promises are kept. Missed" in short and "| terrain.error | 1 of 2 | low | near | 1 | 9 px |" in short
    assert "~~<= 5 px~~" in text
    assert "| **1** |" in text and "**7**" not in text and "slow \\| wrong" in text
    assert "`terrain.holes` did not run: no GL" in text
    assert "quick" not in text.split("## ", 1)[1], "a usual run replaces the quick one"


def test_gpus_come_first(tmp_path):
    from msgspec.structs import replace

    machine = describe_machine(None)
    soft = replace(machine, gl_renderer="A soft one", is_software=True)
    save_report(report_of(machine=soft), tmp_path)
    assert "No suite was run on a GPU" in document_text(tmp_path, tmp_path)
    save_report(report_of(machine=replace(machine, gl_renderer="Zed GPU", is_software=False)), tmp_path)
    text = document_text(tmp_path, tmp_path)
    assert (
        text.index("## Zed GPU") < text.index("## A soft one")
        and text.index("Zed") < text.index("soft one")
        and "No suite was run on a GPU" not in text
    )


def test_no_results_is_an_error(tmp_path):
    with pytest.raises(ReportError, match="no results in this folder"):
        document(tmp_path, tmp_path / "page.md")


def test_the_command_writes_beside_other_results(tmp_path, capsys):
    save_report(report_of(error_row("a", 1, 2)), tmp_path)
    assert cli.bench_main(["--document", "--output", str(tmp_path)]) == 0
    assert (tmp_path / "benchmarks.md").read_text().startswith("# Benchmarks")


def test_the_page_in_docs_is_what_the_results_say():
    """`planetfall bench --document` after a run that is to be committed."""
    skip_if_results_are_new(results_root())
    page = (ROOT / "docs" / "benchmarks.md").read_text()
    assert page == document_text(results_root(), ROOT / "docs")
    assert len(page.splitlines()) <= 80, "one page: rows belong into the tables"
    assert (results_root() / PROMISES).read_text() == promises_text(results_root())
    for folder in {file.parent for file in results_root().glob("*/*.json")}:
        assert (folder / TABLES).read_text() == tables_text(folder)


def test_the_farthest_off_is_named(tmp_path):
    near = error_row("near it", 1.0, 6.0, target="<= 5 px", met=False)
    ratio = error_row("a part", 1.0, 1.0, target="share >= 0.9", met=False, extra={"share": 0.3})
    far = error_row("a range", 1.0, 1.0, target="2 to 3 px", met=False)
    save_report(report_of(near, ratio, far), tmp_path)
    assert "| terrain.error | 3 of 3 | a part |" in document_text(tmp_path, tmp_path)


def test_fronts_are_plotted(tmp_path):
    pytest.importorskip("matplotlib")
    rows = [
        error_row(name, ms, error, view) for view in ("near", "high") for name, ms, error in (("a", 1, 2), ("b", 2, 1))
    ]
    (made,) = save_plots(report_of(*rows), tmp_path)
    assert made.name == "terrain-error.png" and made.stat().st_size > 5000


def test_plots_of_a_saved_file_even_of_a_quick_run(tmp_path, capsys):
    pytest.importorskip("matplotlib")
    report = report_of(*(error_row(name, ms, error, "near") for name, ms, error in (("a", 1, 2), ("b", 2, 1))))
    report.extent = "quick"
    saved = save_report(report, tmp_path)
    assert not save_plots(report, tmp_path)
    assert cli.bench_main(["--plot", str(saved)]) == 0
    assert [path.name for path in saved.parent.glob("*.png")] == ["terrain-quick-error.png"]
    report.rows = []
    save_report(report, tmp_path)
    with pytest.raises(SettingError, match=r"--plot: .* has no bench of time against error; those are atmosphere"):
        cli.bench_main(["--plot", str(saved)])
