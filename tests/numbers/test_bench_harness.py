"""The bench harness: timing, targets, the results' schema, files, tables, comparison, command line."""

from __future__ import annotations

import json

import msgspec
import numpy as np
import pytest
from rich.console import Console

import planetfall as pf
from planetfall.benchmarks import cli
from planetfall.benchmarks.machine import current_commit, describe_machine, device_slug
from planetfall.benchmarks.schema import Report, ReportError, Row, read_report, write_report
from planetfall.benchmarks.session import Session
from planetfall.benchmarks.store import read_reports, report_path, save_report
from planetfall.benchmarks.suites import LONG, SUITES, benches_of, choose
from planetfall.benchmarks.tables import compare, show_comparison, show_report
from planetfall.benchmarks.target import Target, at_least, at_most
from planetfall.benchmarks.timing import Timing, time_variants
from planetfall.errors import SettingError, UnknownNameError


def report_of(*rows: Row, **changes) -> Report:
    fields = {
        "kind": "bench",
        "suite": "graph",
        "planetfall": "0.0",
        "commit": "abc",
        "date": "2024-01-01T00:00:00Z",
        "duration_s": 1.0,
        "machine": describe_machine(None),
        "rows": list(rows),
    }
    return Report(**{**fields, **changes})


def row(**changes) -> Row:
    return Row(
        **{"suite": "graph", "bench": "execute", "variant": "a", "ms": 1.0, "ms_low": 0.9, "ms_high": 1.1} | changes
    )


def shown(show, *arguments) -> str:
    console = Console(record=True, width=160)
    with console.capture() as capture:
        show(*arguments, console)
    return capture.get()


def test_variants_are_interleaved_and_warmed_up():
    order: list[str] = []
    times = time_variants(
        {"a": lambda: order.append("a"), "b": lambda: order.append("b")}, runs=4, warm_up=2, finish=lambda: None
    )
    assert sorted(order) == ["a"] * 6 + ["b"] * 6
    assert all(set(order[k : k + 2]) == {"a", "b"} for k in range(0, 12, 2)), "a round runs each variant once"
    assert {order[k] for k in range(0, 12, 2)} == {"a", "b"}, "rounds start with different variants"
    assert times["a"].runs == 4 and times["a"].low_ms <= times["a"].ms <= times["a"].high_ms


def test_inner_calls_are_divided_out():
    calls = []
    timing = time_variants({"a": lambda: calls.append(1)}, runs=2, warm_up=1, inner=50)["a"]
    assert len(calls) == 150 and timing.ms < 1.0
    with pytest.raises(ValueError, match="expected variants"):
        time_variants({}, 1)


def test_finish_counts_for_the_variant_that_caused_it():
    clock = iter(range(10_000))
    waits: list[int] = []
    time_variants({"a": lambda: None}, runs=3, warm_up=0, finish=lambda: waits.append(next(clock)))
    assert len(waits) == 6, "before and after each run"


def test_timing_is_median_and_spread():
    timing = Timing.of([float(k) for k in range(101)])
    assert (timing.low_ms, timing.ms, timing.high_ms, timing.runs) == (10.0, 50.0, 90.0, 101)


def test_targets():
    assert str(at_most(0.02, "px")) == "<= 0.02 px" and at_most(1.0).met(1.0) and not at_most(1.0).met(1.1)
    assert str(at_least(0.95)) == ">= 0.95" and at_least(0.95).met(0.96)
    assert str(Target(4.0, 10.0, "px")) == "4 to 10 px" and not Target(4.0, 10.0).met(3.9)
    assert not at_most(1.0).met(float("nan")), "an unknown value keeps no promise"


def test_rows_say_whether_their_target_is_met():
    session = Session("graph")
    session.bench = "execute"
    good = session.row(error=np.float32(0.5), target=at_most(1.0, "px"), seen=np.int64(3))
    slow = session.row(timing=Timing(2.0, 1.0, 3.0, 5), target=at_most(1.0, "ms"), target_on="ms")
    other = session.row(target=at_least(3), target_on="seen", seen=2)
    assert (good.met, slow.met, other.met) == (True, False, False)
    assert good.extra == {"seen": 3} and other.target == "seen >= 3"


def test_a_bench_that_fails_is_named_and_the_others_run():
    def broken(session: Session) -> None:
        raise RuntimeError("no ground here")

    with Session("graph") as session:
        report = session.run({"broken": broken, "fine": lambda s: s.row("x", error=1.0) and None})
    assert report.skipped == {"broken": "RuntimeError: no ground here"} and len(report.rows) == 1


def test_reports_survive_the_disk(tmp_path):
    report = report_of(row(size=(640, 360), extra={"cells": 3, "why": "x", "none": None, "yes": True}))
    path = tmp_path / "deep" / "graph.json"
    write_report(report, path)
    assert read_report(path) == report
    assert [p.name for p in path.parent.iterdir()] == ["graph.json"], "nothing is left beside it"


def test_numbers_that_json_lacks_become_null(tmp_path):
    path = tmp_path / "graph.json"
    write_report(report_of(row(error=float("nan"), extra={"x": float("inf")})), path)
    again = read_report(path).rows[0]
    assert again.error is None and again.extra == {"x": None}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not a results file"),
        ('{"kind": "bench"}', "missing required field"),
        ('{"kind": "dance"}', "Invalid enum value"),
    ],
)
def test_a_file_that_is_no_report_is_named(tmp_path, text, message):
    path = tmp_path / "x.json"
    path.write_text(text)
    with pytest.raises(ReportError, match=message) as caught:
        read_report(path)
    assert str(path) in str(caught.value)


def test_another_schema_and_a_missing_file_are_refused(tmp_path):
    path = tmp_path / "x.json"
    data = msgspec.to_builtins(report_of())
    path.write_text(json.dumps({**data, "schema": 99}))
    with pytest.raises(ReportError, match="expected schema 1, found 99"):
        read_report(path)
    with pytest.raises(ReportError, match="cannot be read: No such file"):
        read_report(tmp_path / "nothing.json")


def test_results_that_cannot_be_written_are_said(tmp_path):
    blocked = tmp_path / "file"
    blocked.write_text("")
    with pytest.raises(ReportError, match=r"cannot be written.*--output"):
        save_report(report_of(), blocked)


def test_results_are_kept_by_device(tmp_path):
    machine = msgspec.structs.replace(
        describe_machine(None), gl_renderer="llvmpipe (LLVM 15.0.6, 256 bits)", is_software=True, cpus=2,
        cpu="Intel(R) Core(TM) i5-8250U CPU @ 1.60GHz",
    )  # fmt: skip
    folder = "llvmpipe-llvm-15-0-6-256-bits-2cpu-intel-core-i5-8250u-cpu-1-60ghz"
    assert device_slug(machine) == folder
    other = msgspec.structs.replace(machine, cpu="AMD EPYC")
    assert device_slug(other) == "llvmpipe-llvm-15-0-6-256-bits-2cpu-amd-epyc", "its times are another machine's"
    hardware = msgspec.structs.replace(machine, gl_renderer="NVIDIA GeForce RTX 4070/PCIe/SSE2", is_software=False)
    assert device_slug(hardware) == "nvidia-geforce-rtx-4070-pcie-sse2"
    path = report_path(report_of(machine=machine), tmp_path)
    assert path == tmp_path / folder / "graph.json"
    assert report_path(report_of(machine=machine, extent="quick"), tmp_path).name == "graph-quick.json"
    assert report_path(report_of(machine=machine, kind="stress"), tmp_path).name == "stress-graph.json"


def test_machine_and_commit_are_recorded():
    machine = describe_machine(None)
    assert machine.cpus >= 1 and machine.python.startswith("CPython") and machine.cpu
    assert isinstance(current_commit(), str)


def test_tables_show_what_is_there():
    text = shown(
        show_report, report_of(row(target="<= 2 ms", met=True, extra={"passes": 30}), row(variant="b", ms=None))
    )
    assert "execute" in text and "passes" in text and "30" in text and "1 of 1 targets met" in text
    failed = shown(show_report, report_of(row(met=False, target="<= 0.5 ms"), skipped={"guard": "no GL"}))
    assert "0 of 1 targets met" in failed and "guard: did not run: no GL" in failed


def test_tables_in_files_are_as_wide_as_their_columns(monkeypatch):
    """In a pipe nobody has 80 columns; a terminal, and a width that was asked for, stay what they are."""
    many = row(variant="a name that is rather long", extra={f"a_column_called_{k}": 1234.5 + k for k in range(30)})
    for columns, terminal in (("", False), ("100", False), ("", True)):
        monkeypatch.delenv("COLUMNS", raising=False)
        if columns:
            monkeypatch.setenv("COLUMNS", columns)
        console = Console(force_terminal=terminal, width=None if columns else 80, color_system=None, record=True)
        with console.capture() as capture:
            show_report(report_of(many), console)
        text = capture.get()
        whole = not columns and not terminal
        assert ("a_column_called_29" in text) == whole and ("a name that is rather long" in text) == whole
        assert whole or max(map(len, text.splitlines())) <= int(columns or 80)


@pytest.mark.gpu
@pytest.mark.slow
def test_the_demos_frame_and_start_are_measured():
    """In a window of their own, under Xvfb where there is no display."""
    with Session("graph") as session:
        report = session.run({"demo_python": benches_of("graph")["demo_python"]})
    assert not report.skipped and len(report.rows) == 6
    assert all(0.0 < r.extra["interface_ms"] < r.extra["cpu_ms"] for r in report.rows)
    with Session("startup") as session:
        report = session.run({"window": benches_of("startup")["window"]})
    times = [r.ms for r in report.rows]
    assert not report.skipped and times == sorted(times) and len(times) == 4


def test_comparison_pairs_rows_and_warns_of_other_machines():
    old = report_of(row(), row(variant="gone"))
    new = report_of(row(ms=2.0, ms_low=1.9, ms_high=2.1), row(variant="new"))
    assert [(a.ms, b.ms) for a, b in compare(old, new)] == [(1.0, 2.0)]
    text = shown(show_comparison, old, new)
    assert "2.00" in text and "only in the old run: 1; only in the new one: 1" in text
    other = report_of(row(), machine=msgspec.structs.replace(new.machine, cpu="another"))
    assert "compare errors only" in shown(show_comparison, old, other)


def test_every_suite_has_benches_and_wrong_names_get_help():
    for suite in SUITES:
        assert benches_of(suite)
    assert list(choose(["terrain.normals"])["terrain"]) == ["normals"]
    assert list(choose([])) == list(SUITES)
    with pytest.raises(UnknownNameError, match="did you mean 'terrain'"):
        choose(["terain"])
    with pytest.raises(UnknownNameError, match="did you mean 'normals'"):
        choose(["terrain.normal"])


def test_a_quick_run_leaves_out_what_is_named():
    for suite, names in LONG.items():
        assert set(names) < set(benches_of(suite))
        assert set(choose([suite], quick=True)[suite]) == set(benches_of(suite)) - set(names)
    assert list(choose(["terrain.popping"], quick=True)["terrain"]) == ["popping"], "asked for by name, it runs"
    text = shown(show_report, report_of(row(), extent="quick", left_out=["popping", "holes"]))
    assert "(quick)" in text and "left out of a quick run: popping, holes" in text
    with pytest.raises(SettingError, match="--quick and --full exclude each other"):
        cli.bench_main(["graph", "--quick", "--full"])
    assert Session("graph", "quick").runs(9, 2) == Session("graph").runs(9, 2) == 2
    assert Session("graph", "full").runs(9, 2) == 9


def test_command_line_lists_runs_and_saves(tmp_path, capsys):
    assert cli.bench_main(["--list"]) == 0
    assert "terrain" in capsys.readouterr().out
    assert cli.bench_main(["graph.compile", "--quick", "--no-save"]) == 0
    assert "30 passes" in capsys.readouterr().out
    assert cli.bench_main(["graph.compile", "--quick"]) == 0
    assert "not saved: only a part of the suite" in capsys.readouterr().out
    assert cli.bench_main(["graph.compile", "--quick", "--output", str(tmp_path)]) == 0
    assert [path.name for path in tmp_path.rglob("*.json")] == ["graph-quick.json"]


def test_command_line_compares_files_and_folders(tmp_path, capsys):
    for name in ("old", "new"):
        save_report(report_of(row()), tmp_path / name)
    file = next((tmp_path / "old").rglob("graph.json"))
    assert cli.bench_main(["--compare", str(tmp_path / "old"), str(tmp_path / "new")]) == 0
    assert cli.bench_main(["--compare", str(file), str(file)]) == 0
    assert "graph: abc -> abc" in capsys.readouterr().out
    assert list(read_reports(tmp_path / "new")) == ["graph"]
    empty = tmp_path / "empty"
    empty.mkdir()
    with pytest.raises(ReportError, match="no results in this folder"):
        read_reports(empty)


@pytest.mark.gpu
def test_graph_suite_runs():
    with Session("graph", "quick") as session:
        benches = benches_of("graph")
        report = session.run({name: benches[name] for name in ("execute", "compile", "resize", "guard")})
    assert not report.skipped and report.machine.gl_renderer
    assert {r.bench for r in report.rows} == {"execute", "compile", "resize", "guard"}


@pytest.mark.gpu
def test_a_forgotten_proxy_is_made_again():
    from planetfall.benchmarks.measure.frames import forget_proxy

    with pf.load_scene("moon") as scene, pf.Renderer(scene, size=(32, 18), quality="low") as renderer:
        forget_proxy(renderer)  # there is none yet
        generations = []
        for forget in (False, False, True):
            if forget:
                forget_proxy(renderer)
            renderer.render(pf.view("near"), dt_s=0.1)
            generations.append(renderer.views[0].proxy.generation)
        assert generations[0] == generations[1] < generations[2]


def test_the_sum_of_passes_is_no_more_than_frames_take():
    """By the driver's timers, which on software renderers are times of the processor as well."""
    from planetfall.benchmarks.measure.frames import gpu_passes_ms, time_frames

    with pf.load_scene("earth") as scene, pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
        view = pf.view("near")
        renderer.settle(view)
        ms = sum(gpu_passes_ms(renderer, view, 4).values())
        frame = time_frames(renderer, view, 6).turning
    assert 0.0 < ms < 3.0 * frame.high_ms
