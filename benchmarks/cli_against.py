"""`planetfall bench --against`: its options, its lines and its file."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path

import msgspec
from cyclopts import Group, Parameter
from rich.console import Console
from rich.text import Text

from ..cli.options import parse_size
from ..errors import SettingError
from .against import CaseFailed, Outcome, checkout_of, choose_cases, measure_case
from .machine import current_commit, describe_machine, now_utc
from .schema import write_json

__all__ = ["AgainstOptions", "run_against"]

ProgressBar = Callable[[str], AbstractContextManager[Callable[[str, int, int], None]]]

_AGAINST = Group(
    "Against",
    help="Frames of the working tree and of another commit in turns: processor time, new over old. Then the names are "
    "those of cases: low, near, low.near, low.near.clouds, low.near.clear; left out, low, medium and high in near, "
    "high, orbit and sea, without clouds and with.",
)


@Parameter(name="*", group=_AGAINST, negative="")
@dataclass(frozen=True)
class AgainstOptions:
    """What `--against` takes."""

    against: str | None = None
    "A commit, branch or tag of this checkout. Exit code 1 if a case got slower."
    count: int = 20
    "Blocks of frames of each version, in turns; at least 4."
    frames: int = 8
    "Frames a block."
    size: str = "640x360"
    "Width x height in pixels."
    json: Path | None = None
    "Write all figures to this file as well."

    def given(self) -> bool:
        """Whether any option was given at all."""
        return self != AgainstOptions()


def run_against(options: AgainstOptions, patterns: Sequence[str], console: Console, progress: ProgressBar) -> bool:
    """Measure and show; whether every case is no slower. progress: a bar of a case.

    SettingError for options that can't be, before anything is drawn.
    """
    if options.against is None:
        raise SettingError("bench: --count, --frames, --size and --json go with --against COMMIT")
    for name, least in (("count", 4), ("frames", 1)):
        if getattr(options, name) < least:
            raise SettingError(f"--{name} must be at least {least}, found {getattr(options, name)}")
    size, cases = parse_size(options.size), choose_cases(patterns)
    outcomes: list[Outcome] = []
    failed: dict[str, str] = {}
    with checkout_of(options.against) as (commit, old):
        new = current_commit()
        console.print(f"{commit[:12]} -> {new}, {options.size}: processor time a frame", highlight=False)
        console.print(f"{'case':22}{'old ms':>9}{'new ms':>9}{'new/old':>9}   {'95 %':16}by the clock", style="bold")
        for number, case in enumerate(cases, 1):
            with progress(f"{case} ({number} of {len(cases)})") as told:
                try:
                    outcome = measure_case(
                        case, old, size=size, blocks=options.count, frames=options.frames,
                        progress=lambda done, of, told=told: told("", done, of),
                    )  # fmt: skip
                except CaseFailed as error:
                    outcome, failed[str(case)] = None, str(error)
            if outcome is None:
                console.print(Text(f"{case!s:22}not measured: {failed[str(case)]}", style="red"), soft_wrap=True)
            else:
                outcomes.append(outcome)
                console.print(_line(outcome), soft_wrap=True)
    good = not failed and all(outcome.cpu.no_slower for outcome in outcomes)
    if options.json is not None:
        found = {
            "old": commit,
            "new": new,
            "date": now_utc(),
            "machine": msgspec.to_builtins(describe_machine(None)),
            "size": size,
            "count": options.count,
            "frames": options.frames,
            "no_slower": good,
            "rows": [outcome.row() for outcome in outcomes],
            "not_measured": failed,
        }
        write_json(found, options.json)
        console.print(f"written: {options.json}", highlight=False, soft_wrap=True)
    return good


def _line(outcome: Outcome) -> Text:
    cpu = outcome.cpu
    old, new = (sorted(times)[len(times) // 2] for times in (outcome.old_cpu_ms, outcome.new_cpu_ms))
    interval, wall = f"{cpu.low:.3f} .. {cpu.high:.3f}", outcome.wall.median
    line = Text(f"{outcome.case!s:22}{old:9.1f}{new:9.1f}{cpu.median:9.3f}   {interval:16}{wall:9.3f}     ")
    return line.append("no slower" if cpu.no_slower else "slower", "green" if cpu.no_slower else "red")
