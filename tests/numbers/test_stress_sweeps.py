"""Stress sweeps: cases follow from the seed alone, failures are saved and can be run again, short sweeps pass."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks import cli
from planetfall.benchmarks.schema import ReportError, read_report
from planetfall.benchmarks.session import Session
from planetfall.benchmarks.stress import STRESS_SUITES, clouds, replay_file, run_sweep, runner, terrain
from planetfall.benchmarks.stress.runner import Found, Kind, draw_case
from planetfall.errors import SettingError, UnknownNameError


@pytest.fixture
def brittle(monkeypatch):
    """A suite whose cases fail when their number is above one half."""

    def check(case, session):
        found = Found()
        found.note("value", case["value"], "m", 0.5)
        if case["value"] > 0.9:
            raise RuntimeError("much too large")
        return found

    kinds = {"number": Kind(lambda rng: {"value": float(rng.random())}, check)}
    monkeypatch.setattr(runner, "kinds_of", lambda suite: kinds)


@pytest.mark.parametrize("suite", STRESS_SUITES)
def test_cases_follow_from_the_seed_and_survive_json(suite):
    for index in range(20):
        case = draw_case(suite, 7, index)
        assert case == draw_case(suite, 7, index)
        assert case == json.loads(json.dumps(case))
    assert draw_case(suite, 7, 19) != draw_case(suite, 8, 19), "the first may be the same for all seeds"


def test_failures_are_counted_saved_and_run_again(brittle, tmp_path):
    report = run_sweep("space", seed=3, count=30, save_under=tmp_path)
    values = [draw_case("space", 3, k)["value"] for k in range(30)]
    assert [f.index for f in report.failures] == [k for k, value in enumerate(values) if value > 0.5]
    worst = next(r for r in report.rows if r.variant == "number: value")
    assert worst.error == max(v for v in values if v <= 0.9) and worst.extra["case"] == values.index(worst.error)
    count = next(r for r in report.rows if r.variant == "number: failed cases")
    assert count.met is False and count.error == len(report.failures)
    first = report.failures[0]
    again = replay_file(tmp_path / first.file)
    assert again.failures[0].messages == first.messages and again.failures[0].case == first.case


def test_an_exception_is_a_failure_with_its_words(brittle):
    report = run_sweep("space", seed=3, count=60)
    assert any("RuntimeError: much too large" in f.messages for f in report.failures)


def test_replay_says_what_is_wrong_with_a_file(tmp_path):
    path = tmp_path / "x.json"
    with pytest.raises(ReportError, match=r"x\.json cannot be read: No such file.*Expected.*planetfall stress SUITE"):
        replay_file(path)
    path.write_text('{"suite": 3}')
    with pytest.raises(ReportError, match=r"x\.json is not a saved stress case.*Expected.*planetfall stress SUITE"):
        replay_file(path)
    path.write_text('{"suite": "spice", "seed": 1, "index": 1, "case": {}}')
    with pytest.raises(UnknownNameError, match="did you mean 'space'"):
        replay_file(path)


def test_command_line(brittle, tmp_path, capsys):
    assert cli.stress_main(["space", "--seed", "3", "--count", "10", "--output", str(tmp_path)]) == 1
    saved = next(tmp_path.rglob("stress-space.json"))
    assert read_report(saved).kind == "stress"
    failure = next(tmp_path.rglob("space-3-*.json"))
    capsys.readouterr()
    assert cli.stress_main(["--replay", str(failure)]) == 1
    said = json.loads(failure.read_text())["messages"]
    assert said[0] in " ".join(capsys.readouterr().out.split())
    with pytest.raises(SettingError, match="name a suite"):
        cli.stress_main([])
    with pytest.raises(SettingError, match="--count must be at least 1"):
        cli.stress_main(["space", "--count", "0"])


def test_few_cases_do_not_replace_a_whole_sweep(brittle, tmp_path, monkeypatch):
    monkeypatch.setattr(cli, "results_root", lambda: tmp_path)
    cli.stress_main(["space", "--count", "10"])
    assert [file.name for file in tmp_path.glob("*/*.json")] == ["stress-space-quick.json"]


def failures(report):
    return "\n".join(f"case {f.index}: {'; '.join(f.messages)}" for f in report.failures)


@pytest.mark.gpu
def test_space_sweep():
    report = run_sweep("space", seed=1, count=150)
    assert not report.failures, failures(report)


@pytest.mark.gpu
def test_terrain_sweep():
    report = run_sweep("terrain", seed=1, count=6)
    assert not report.failures, failures(report)


@pytest.mark.gpu
def test_holes_and_nan_are_seen():
    """The checks find what they look for, in outputs that were tampered with."""
    found = Found()
    with pf.Renderer(pf.load_scene("moon"), size=(64, 36), quality="low") as renderer:
        camera = pf.Camera.at(10.0, 20.0, 5.0e5, pitch_deg=-60.0)
        out = renderer.render(camera, outputs=terrain.OUTPUTS)
        terrain.check_outputs(found, out)
        terrain.check_holes(found, renderer, renderer.camera_state(camera), out)
        assert found.messages == []
        out["surface"][20, 30] = 0
        terrain.check_holes(found, renderer, renderer.camera_state(camera), out)
        assert found.messages == ["1 holes in the disc, the first at pixel (30, 20)"]
        out["radiance"][3, 4] = np.nan
        terrain.check_outputs(found, out)
    assert "radiance: 1 pixels are not finite" in found.messages
    assert "position: 1 pixels do not agree with surface" in found.messages


@pytest.mark.gpu
def test_frame_sweep():
    report = run_sweep("frame", seed=1, count=5)
    assert not report.failures, failures(report)


@pytest.mark.gpu
def test_atmosphere_sweep():
    report = run_sweep("atmosphere", seed=1, count=14)
    assert {row.variant.split(":")[0] for row in report.rows} == {"probe", "truth", "picture"}
    assert not report.failures, failures(report)


@pytest.mark.gpu
def test_clouds_sweep():
    report = run_sweep("clouds", seed=43, count=5)  # one of each kind
    assert {row.variant.split(":")[0] for row in report.rows} == set(clouds.KINDS)
    assert not report.failures, failures(report)


ODD_AIR = pytest.mark.xfail(
    reason="2 of 200 random airs are further from the exact ones than allowed: transmittance by 1.6e-3, light by 5 %",
    strict=True,
)


@pytest.mark.slow
@pytest.mark.gpu
@pytest.mark.parametrize(
    ("suite", "count"),
    [
        ("space", 3000),
        ("terrain", 100),
        pytest.param("atmosphere", 200, marks=ODD_AIR),
        ("frame", 100),
        ("clouds", 200),
    ],
)
def test_long_sweep(suite, count):
    report = run_sweep(suite, seed=int(np.random.default_rng(0).integers(1000)), count=count)
    assert not report.failures, failures(report)


SAVED = sorted((Path(__file__).parents[1] / "data" / "stress").glob("*.json"))


@pytest.mark.parametrize("file", SAVED, ids=lambda file: file.stem)
def test_what_once_failed_holds(file):
    assert not replay_file(file).failures


def test_clouds_that_hide_all_leave_no_negative_light():
    """A case that a sweep found: printed clouds in the dark, their shafts unlit."""
    case = draw_case("clouds", 1, 20)
    assert case["kind"] == "picture" and case["method"] == "paper_2019"
    with Session("clouds") as session:
        assert runner.check_case("clouds", case, session).messages == []
