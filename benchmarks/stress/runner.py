"""Runs a stress suite: case k of a seed is always the same; failing cases are saved and can be run again.

A suite is a module with `KINDS`: name -> Kind. Kind.draw(rng) makes a case (a dict that JSON can hold, nothing else),
Kind.check(case, context) returns a Found: what was measured, and a message for each promise that was broken. The first
cases may be given, as `FIXED`; `COUNT` says how many cases a sweep has that is told no number.
"""

from __future__ import annotations

import importlib
import logging
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import msgspec
import numpy as np

from ... import __version__
from ...engine.settings.suggest import did_you_mean
from ...errors import UnknownNameError
from ..machine import current_commit, device_slug, now_utc
from ..plots import MISSING, draw_series
from ..schema import Failure, Report, ReportError, write_json, write_text
from ..session import Progress, Session
from .deviations import Deviations, add_rows

log = logging.getLogger(__name__)

Case = dict[str, Any]
USUAL_COUNT = 100

STRESS_SUITES: Mapping[str, str] = {
    "space": "Rays, projection, coverage and lattice: pure mathematics and the GPU's part of it",
    "terrain": "Random planets and cameras: no NaN, no hole in the disc, heights as the float64 twin has them",
    "atmosphere": "Random air: nothing NaN, infinite or negative; physical air as the float64 reference has it",
    "clouds": "Random layers of cloud: light that is finite, exact transmittance, no jump at any boundary",
    "ocean": "Random seas: waves in shaders as in float64, no hole, nothing that is not finite",
    "frame": "Random scenes, cameras, suns and sizes: finite pictures, no GL error",
    "compare": "A million numbers of the GPU against float64: heights, waves, air, cloud coordinates",
    "descent": "From 36 000 km to 2 m: pops of the ground and steps of brightness between all frames",
}


@dataclass
class Found:
    """What one case gave. values: the worst of each becomes a row; name -> (value, unit)."""

    values: dict[str, tuple[float, str]] = field(default_factory=dict)
    messages: list[str] = field(default_factory=list)
    series: dict[str, list[float]] = field(default_factory=dict)
    """Columns of equal length that say more than their worst: saved as a table and drawn."""
    deviations: dict[str, Deviations] = field(default_factory=dict)
    """Of many numbers from float64, by quantity: pooled over all cases."""

    def expect(self, good: bool, message: str) -> None:
        """A promise: when it is broken, the message is kept."""
        if not good:
            self.messages.append(message)

    def note(self, name: str, value: float, unit: str = "", at_most: float | None = None) -> None:
        """A measured value and its limit."""
        value = float(value)
        self.values[name] = (value, unit)
        if at_most is not None:
            self.expect(value <= at_most, f"{name}: expected <= {at_most:g} {unit}, found {value:.4g}")


@dataclass(frozen=True)
class Kind:
    """One sort of case of a suite."""

    draw: Callable[[np.random.Generator], Case]
    check: Callable[[Case, Session], Found]
    weight: float = 1.0
    """How often, beside the suite's other kinds."""


class ReplayFile(msgspec.Struct):
    """A failing case on disk."""

    suite: str
    seed: int
    index: int
    case: Case
    messages: list[str] = []
    planetfall: str = ""


def kinds_of(suite: str) -> Mapping[str, Kind]:
    """The kinds of a suite. UnknownNameError names the nearest suite."""
    if suite not in STRESS_SUITES:
        raise UnknownNameError(f"no stress suite {suite!r}; {did_you_mean(suite, STRESS_SUITES, 'suites')}")
    return _module(suite).KINDS


def usual_count(suite: str) -> int:
    """How many cases a sweep has that is told no number."""
    kinds_of(suite)
    return int(getattr(_module(suite), "COUNT", USUAL_COUNT))


def _module(suite: str) -> ModuleType:
    return importlib.import_module(f".{suite}", __package__)


def draw_case(suite: str, seed: int, index: int) -> Case:
    """Case `index` of a seed: {"kind": ..., ...}."""
    kinds = kinds_of(suite)
    fixed = getattr(_module(suite), "FIXED", ())
    if index < len(fixed):
        return dict(fixed[index])
    rng = np.random.default_rng([seed, index])
    weights = np.array([kind.weight for kind in kinds.values()])
    name = list(kinds)[int(rng.choice(len(kinds), p=weights / weights.sum()))]
    return {"kind": name, **kinds[name].draw(rng)}


def check_case(suite: str, case: Case, session: Session) -> Found:
    """Run one case; an exception is a broken promise too."""
    kinds = kinds_of(suite)
    if case.get("kind") not in kinds:
        raise ReportError(f"a case of suite {suite}: expected kind {', '.join(kinds)}, found {case.get('kind')!r}")
    quiet = logging.getLogger("planetfall")
    level = quiet.level
    quiet.setLevel(logging.ERROR)  # cameras in the ground are lifted with a warning, and there are many
    try:
        return kinds[case["kind"]].check(case, session)
    except Exception as error:
        log.debug("case failed", exc_info=True)
        return Found(messages=[f"{type(error).__name__}: {error}"])
    finally:
        quiet.setLevel(level)


def run_sweep(
    suite: str, seed: int = 1, count: int = 100, save_under: Path | None = None, progress: Progress | None = None
) -> Report:
    """Cases 0 .. count - 1 of a seed. save_under: failing cases go to <device>/failures/ below it."""
    kinds_of(suite)
    worst: dict[tuple[str, str], tuple[float, str, int, int]] = {}
    failures: list[Failure] = []
    started, date = time.monotonic(), now_utc()
    ran: dict[str, int] = {}
    series: dict[int, tuple[Case, dict[str, list[float]]]] = {}
    deviations: dict[str, list[Deviations]] = {}
    with Session(suite) as session:
        for index in range(count):
            case = draw_case(suite, seed, index)
            found = check_case(suite, case, session)
            ran[case["kind"]] = ran.get(case["kind"], 0) + 1
            for name, part in found.deviations.items():
                deviations.setdefault(name, []).append(part)
            if found.series:
                series[index] = (case, found.series)
            for name, (value, unit) in found.values.items():
                before = worst.get((case["kind"], name), (-np.inf, unit, index, 0))
                keep = before if before[0] >= value else (value, unit, index, 0)
                worst[case["kind"], name] = (*keep[:3], before[3] + 1)
            if found.messages:
                failures.append(Failure(suite=suite, seed=seed, index=index, case=case, messages=found.messages))
            if progress is not None:
                progress(f"{len(failures)} failed" if failures else "", index + 1, count)
        report = _report(session, date, started)
    session.bench = "worst"
    for (kind, name), (value, unit, index, cases) in worst.items():
        session.row(f"{kind}: {name}", error=value, error_unit=unit, seed=seed, case=index, cases=cases)
    for kind, cases in sorted(ran.items()):
        failed = sum(failure.case["kind"] == kind for failure in failures)
        session.row(f"{kind}: failed cases", error=failed, seed=seed, cases=cases)
        session.rows[-1].target, session.rows[-1].met = "<= 0", failed == 0
    add_rows(session, deviations)
    report.rows, report.failures = session.rows, failures
    if save_under is not None:
        for failure in failures:
            save_failure(failure, save_under / device_slug(report.machine) / "failures")
        for index, (case, columns) in series.items():
            if index < len(getattr(_module(suite), "FIXED", ())):
                save_series(suite, case, columns, save_under / device_slug(report.machine))
    return report


def save_series(suite: str, case: Case, columns: Mapping[str, list[float]], folder: Path) -> Path:
    """A case's columns as a table, drawn beside it where matplotlib is; the table's path."""
    path = folder / f"stress-{suite}-{case['kind']}-{len(next(iter(columns.values()))) + 1}.csv"
    rows = zip(*columns.values(), strict=True)
    lines = [",".join(columns), *(",".join(f"{value:.7g}" for value in row) for row in rows)]
    write_text("\n".join(lines) + "\n", path)
    try:
        draw_series(columns, f"{suite}: {case['kind']}", path.with_suffix(".png"))
    except ImportError:
        log.info(MISSING)
    return path


_REPLAYED = (
    "Expected the file of a failing case, such as failures/space-1-12.json; `planetfall stress SUITE` names those it"
    " writes. Without the file, `planetfall stress space --seed 1 --count 13` runs that case again, after twelve others"
)


def save_failure(failure: Failure, folder: Path) -> None:
    """Write a case that `replay_file` can read; its name is noted in failure.file."""
    path = folder / f"{failure.suite}-{failure.seed}-{failure.index}.json"
    replay = ReplayFile(failure.suite, failure.seed, failure.index, failure.case, failure.messages, __version__)
    write_json(msgspec.to_builtins(replay), path)
    failure.file = str(path)


def replay_file(path: Path) -> Report:
    """Run the one case of a file again. ReportError when it isn't such a file."""
    try:
        replay = msgspec.json.decode(path.read_bytes(), type=ReplayFile)
    except OSError as error:
        raise ReportError(f"stress: {path} cannot be read: {error.strerror or error}. {_REPLAYED}") from None
    except msgspec.MsgspecError as error:
        raise ReportError(f"stress: {path} is not a saved stress case: {error}. {_REPLAYED}") from None
    kinds_of(replay.suite)
    started, date = time.monotonic(), now_utc()
    with Session(replay.suite) as session:
        found = check_case(replay.suite, replay.case, session)
        report = _report(session, date, started)
        session.bench = "replay"
        for name, (value, unit) in found.values.items():
            session.row(f"{replay.case['kind']}: {name}", error=value, error_unit=unit, seed=replay.seed,
                        case=replay.index)  # fmt: skip
    report.rows = session.rows
    if found.messages:
        report.failures = [
            Failure(suite=replay.suite, seed=replay.seed, index=replay.index, case=replay.case,
                    messages=found.messages, file=str(path))
        ]  # fmt: skip
    return report


def _report(session: Session, date: str, started: float) -> Report:
    return Report(
        kind="stress",
        suite=session.suite,
        planetfall=__version__,
        commit=current_commit(),
        date=date,
        duration_s=round(time.monotonic() - started, 1),
        machine=session.machine(),
    )
