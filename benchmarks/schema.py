"""What a bench or stress run writes: one JSON schema, checked on reading and writing.

A row is one measurement: time, error, or both. Speed is compared within one run on one machine, error against a float64
reference, so the machine, the driver and the commit are part of every file.
"""

from __future__ import annotations

import math
import os
import tempfile
from pathlib import Path
from typing import Any, Literal, get_args

import msgspec

from ..engine.settings import SettingError

SCHEMA_VERSION = 1

Scalar = bool | int | float | str


class Machine(msgspec.Struct, frozen=True, kw_only=True):
    """Where the numbers come from. Holds no host or user names."""

    system: str
    cpu: str
    cpus: int
    memory_bytes: int
    python: str
    numpy: str
    moderngl: str
    gl_renderer: str
    gl_vendor: str
    gl_version: str
    is_software: bool
    load_average: float
    """Runnable processes a CPU at the start of the run: above about 0.3 the times are those of a busy machine."""


class Row(msgspec.Struct, kw_only=True):
    """One measurement. Times are wall-clock milliseconds: median, 10th and 90th percentile of `runs` runs."""

    suite: str
    bench: str
    """What is measured: "undisplaced positions", "heights", ..."""
    variant: str = ""
    """Which of several things compared: a quality, a radius, "ours", "f32 finite differences"."""
    view: str = ""
    size: tuple[int, int] | None = None
    ms: float | None = None
    ms_low: float | None = None
    ms_high: float | None = None
    runs: int = 0
    error: float | None = None
    error_unit: str = ""
    target: str = ""
    """What the project promises, in words with the unit: "<= 0.02 px". Empty: nothing promised."""
    met: bool | None = None
    extra: dict[str, Scalar | None] = {}


class Failure(msgspec.Struct, kw_only=True):
    """A stress case that went wrong; `planetfall stress --replay FILE` runs it again."""

    suite: str
    seed: int
    index: int
    case: dict[str, Any]
    messages: list[str]
    file: str = ""


Extent = Literal["quick", "usual", "full"]
"""How much of a suite was run: what fits into a minute, all of it with small samples, all of it with large ones."""
EXTENTS: tuple[Extent, ...] = get_args(Extent)


class Report(msgspec.Struct, kw_only=True):
    """One suite's run."""

    schema: int = SCHEMA_VERSION
    kind: Literal["bench", "stress"]
    suite: str
    planetfall: str
    commit: str
    date: str
    """UTC, ISO 8601."""
    duration_s: float
    extent: Extent = "usual"
    left_out: list[str] = []
    """Benches of the suite that a quick run has not run, because they take long."""
    machine: Machine
    rows: list[Row] = []
    failures: list[Failure] = []
    seconds: dict[str, float] = {}
    """How long each bench took."""
    skipped: dict[str, str] = {}
    """Benches that could not run, and why."""


class ReportError(SettingError):
    """A results file that can't be read: not there, not JSON, another schema. Names the file and the place in it."""


def read_report(path: Path) -> Report:
    """A results file, checked. Raises ReportError."""
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ReportError(f"{path}: cannot be read: {error.strerror or error}") from None
    try:
        report = msgspec.json.decode(data, type=Report)
    except msgspec.MsgspecError as error:
        raise ReportError(f"{path}: not a results file of this schema: {error}") from None
    if report.schema != SCHEMA_VERSION:
        raise ReportError(
            f"{path}: expected schema {SCHEMA_VERSION}, found {report.schema}; run the bench again with this version"
        )
    return report


def write_report(report: Report, path: Path) -> None:
    """Write beside, then rename: a reader never sees half a file. Raises ReportError where that is not possible."""
    write_json(msgspec.to_builtins(report), path)
    read_report(path)


def write_json(value: Any, path: Path) -> None:
    """Any JSON value, indented, written beside and renamed. NaN and infinity become null."""
    write_text((msgspec.json.format(msgspec.json.encode(_finite(value)), indent=1) + b"\n").decode(), path)


def write_text(text: str, path: Path) -> None:
    """Written beside and renamed. Raises ReportError where that is not possible."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        handle, beside = tempfile.mkstemp(prefix=path.name + ".", suffix=".part", dir=path.parent)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(text.encode())
            os.chmod(beside, 0o644)
            os.replace(beside, path)
        except BaseException:
            Path(beside).unlink(missing_ok=True)
            raise
    except OSError as error:
        raise ReportError(f"{path}: cannot be written: {error.strerror or error}; choose another --output") from None


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(key): _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
