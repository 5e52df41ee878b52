"""`planetfall bench --against`: the ratio and its interval, the choice of cases, a commit's checkout, a small run."""

from __future__ import annotations

import json
import subprocess
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from planetfall.benchmarks import against, cli, cli_against
from planetfall.benchmarks.against import CASES, CaseFailed, Child, Outcome, checkout_of, choose_cases, ratio_of
from planetfall.errors import SettingError, SizeError, UnknownNameError


def blocks(factor: float, count: int = 40, noise: float = 0.02, seed: int = 5) -> tuple[list[float], list[float]]:
    """Times of both versions on a machine that gets slower by a half meanwhile."""
    rng = np.random.default_rng(seed)
    drift = np.linspace(50.0, 75.0, count)
    old, new = (drift * np.exp(noise * rng.standard_normal(count)) for _ in range(2))
    return old.tolist(), (new * factor).tolist()


@pytest.mark.parametrize("factor", [0.8, 1.0, 1.1])
def test_a_ratio_is_found_on_a_machine_that_slows_down(factor: float):
    ratio = ratio_of(*blocks(factor))
    assert ratio.low <= ratio.median <= ratio.high and ratio.high - ratio.low < 0.05
    assert ratio.median == pytest.approx(factor, abs=0.015)
    assert ratio.no_slower == (factor <= 1.0)
    assert ratio == ratio_of(*blocks(factor)), "the same times say the same"


def test_the_interval_holds_the_truth_as_often_as_it_says():
    ratios = [ratio_of(*blocks(1.02, 20, seed=seed), resamples=1000) for seed in range(300)]
    # A bootstrap of medians of so few is a little wide: 95 % and somewhat more.
    assert 0.93 <= np.mean([r.low <= 1.02 <= r.high for r in ratios]) <= 0.99


def test_one_hiccup_changes_no_verdict():
    old, new = blocks(1.0)
    new[3] *= 20.0
    assert ratio_of(old, new).no_slower
    assert not against.Ratio(1.01, 1.001, 1.02).no_slower, "surely slower, if by little"
    assert not against.Ratio(1.04, 0.9, 1.2).no_slower, "an interval this wide excuses nothing"
    assert against.Ratio(1.03, 1.0, 1.1).no_slower


def names(*patterns: str) -> list[str]:
    return [str(case) for case in choose_cases(patterns)]


def test_cases_are_chosen_by_their_parts():
    assert len(CASES) == 24 and choose_cases([]) == list(CASES)
    assert names("low.near") == ["low.near.clear", "low.near.clouds"]
    assert names("clouds.sea.medium", "medium.sea") == ["medium.sea.clouds", "medium.sea.clear"], "each once"
    assert len(names("near")) == 6 and len(names("clear")) == 12 and len(names("low")) == 8
    assert names("ultra.space.clear") == ["ultra.space.clear"], "also what is not measured by itself"
    assert names("high") == names("high.near", "high.high", "high.orbit", "high.sea"), "the quality"
    assert names("low.high.clear") == ["low.high.clear"] and names("high.high.clear") == ["high.high.clear"]


@pytest.mark.parametrize(
    ("pattern", "error", "message"),
    [
        ("neer", UnknownNameError, "no cases 'neer'; did you mean 'near'"),
        ("low.medium", SettingError, "names a quality twice: low and medium"),
        ("near.sea", SettingError, "names a view twice"),
        ("", UnknownNameError, "no cases ''"),
    ],
)
def test_patterns_that_mean_nothing_are_said(pattern: str, error: type[Exception], message: str):
    with pytest.raises(error, match=message):
        choose_cases([pattern])


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        (["--count", "30"], SettingError, "go with --against"),
        (["--against", "HEAD", "--quick"], SettingError, "leave them out"),
        (["--against", "HEAD", "--count", "3"], SettingError, "--count must be at least 4, found 3"),
        (["--against", "HEAD", "--frames", "0"], SettingError, "--frames must be at least 1"),
        (["--against", "HEAD", "--size", "big"], SizeError, "expected width x height"),
        (["--against", "HEAD", "neer"], UnknownNameError, "did you mean 'near'"),
    ],
)
def test_options_that_cannot_be_are_said(arguments: list[str], error: type[Exception], message: str):
    with pytest.raises(error, match=message):
        cli.bench_main(arguments)


def git(folder: Path, *arguments: str) -> str:
    who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
    done = subprocess.run(["git", "-C", str(folder), *who, *arguments], capture_output=True, text=True, check=True)
    return done.stdout.strip()


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout with two commits."""
    folder = tmp_path / "checkout"
    folder.mkdir()
    git(folder, "init", "-q")
    for text in ("old", "new"):
        (folder / "version").write_text(text)
        git(folder, "add", ".")
        git(folder, "commit", "-q", "-m", text)
    return folder


@pytest.mark.parametrize("ended_by", [None, RuntimeError, KeyboardInterrupt])
def test_a_commit_is_checked_out_and_removed_whatever_happens(checkout: Path, ended_by: type[BaseException] | None):
    (checkout / "version").write_text("changed since")

    def use() -> None:
        with checkout_of("HEAD~1", checkout) as (commit, folder):
            assert (folder / "version").read_text() == "old" and commit == git(checkout, "rev-parse", "HEAD~1")
            assert folder.parent.parent == checkout.parent
            (folder / "made").write_text("compiled files and the like")
            if ended_by is not None:
                raise ended_by

    if ended_by is None:
        use()
    else:
        with pytest.raises(ended_by):
            use()
    assert list(checkout.parent.iterdir()) == [checkout]
    assert len(git(checkout, "worktree", "list").splitlines()) == 1
    assert (checkout / "version").read_text() == "changed since"


def test_what_cannot_be_checked_out_is_said(checkout: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    for wrong in ("nothing", "", "--all", "HEAD:version"):
        with pytest.raises(SettingError, match=f"no commit {wrong!r}"), checkout_of(wrong, checkout):
            pass
    with pytest.raises(SettingError, match=f"needs a git checkout of planetfall; {tmp_path} is none"):
        checkout_of("HEAD", tmp_path).__enter__()
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SettingError, match="needs git"):
        checkout_of("HEAD", checkout).__enter__()


def test_a_version_that_does_not_start_is_named(checkout: Path):
    (checkout / "planetfall").mkdir()
    (checkout / "planetfall" / "__init__.py").write_text("raise ValueError('too old')")
    child = Child("old", checkout)
    try:
        child.open(CASES[0], (32, 18))
        with pytest.raises(CaseFailed, match="old: ended with 1: ValueError: too old"):
            child.opened()
    finally:
        child.close()


def test_the_exit_code_and_the_file_say_what_came_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys):
    """Frames are made up: near is 20 % slower, of the sea there is no picture."""

    @contextmanager
    def nothing(commit: str):
        yield "0123456789abcdef", tmp_path

    def made_up(case: against.Case, old: Path, **_: object) -> Outcome:
        if case.view == "sea":
            raise CaseFailed("old: UnknownNameError: no view 'sea'")
        times = blocks(1.2 if case.view == "near" else 0.9)
        return Outcome(case, ratio_of(*times), ratio_of(*times), tuple(times[0]), tuple(times[1]))

    monkeypatch.setattr(cli_against, "checkout_of", nothing)
    monkeypatch.setattr(cli_against, "measure_case", made_up)
    assert cli.bench_main(["--against", "HEAD", "low.orbit"]) == 0
    assert cli.bench_main(["--against", "HEAD", "low.orbit", "low.near"]) == 1
    file = tmp_path / "found.json"
    assert cli.bench_main(["--against", "HEAD", "low.orbit", "low.sea.clear", "--json", str(file)]) == 1
    said = capsys.readouterr().out
    assert "no slower" in said and "not measured: old: UnknownNameError" in said and "0123456789ab ->" in said
    found = json.loads(file.read_text())
    assert [row["no_slower"] for row in found["rows"]] == [True, True] and not found["no_slower"]
    assert list(found["not_measured"]) == ["low.sea.clear"] and len(found["rows"][0]["new_cpu_ms"]) == 40


@pytest.mark.gpu
@pytest.mark.skipif(not (against.ROOT / ".git").exists(), reason="not a git checkout")
def test_frames_of_a_commit_are_measured_beside_those_of_this_checkout():
    """In processes of their own, each with the library that it is meant to have."""
    told: list[tuple[int, int]] = []
    (case,) = choose_cases(["low.near.clear"])
    with checkout_of("HEAD") as (_, old):
        done = against.measure_case(
            case, old, size=(64, 36), blocks=4, frames=2, run_up=4, progress=lambda *now: told.append(now)
        )
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert len(done.old_cpu_ms) == len(done.new_cpu_ms) == 4 and min(done.old_cpu_ms + done.new_cpu_ms) > 0.0
    # So few and so small frames say little, but not that one version takes twice as long as itself.
    assert 0.5 < done.cpu.median < 2.0 and done.cpu.low <= done.cpu.median <= done.cpu.high
