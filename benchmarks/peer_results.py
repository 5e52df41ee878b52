"""What somebody else's renderer took, measured in a browser on this machine: files that suite `peers` compares with."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import msgspec

from ..errors import SettingError

__all__ = [
    "FILES", "PEERS", "SIZE", "VIEWS", "PeerResultsError", "PeerRun", "PeerView", "read_peer_results", "runs_of_peer",
    "same_renderer",
]  # fmt: skip

PEERS = "peers"
"""The suite."""

SIZE = (640, 360)
VIEWS = ("ground", "air10km", "space")
_HOW = 'docs/benchmarks-howto.md, "Beside a browser\'s sky and clouds", says how they are made and what stands in them'

Milliseconds = Annotated[float, msgspec.Meta(gt=0.0)]


class PeerResultsError(SettingError):
    """A folder or a file of the peer's results that can't be used. Says which, and what to do."""


class PeerView(msgspec.Struct, frozen=True, kw_only=True):
    """Frames of one view: milliseconds until each had been drawn."""

    first_ms: Milliseconds
    """The first frame of all, shaders compiled in it."""
    median_ms: Milliseconds
    p10_ms: Milliseconds
    p95_ms: Milliseconds
    n: Annotated[int, msgspec.Meta(ge=1)]
    """Frames that were timed."""


class PeerRun(msgspec.Struct, frozen=True, kw_only=True):
    """One run of the peer: without clouds, or with them at one quality. Other fields of the file are left alone."""

    renderer: str
    """UNMASKED_RENDERER_WEBGL."""
    size: tuple[int, int]
    with_clouds: bool = msgspec.field(name="withClouds")
    load_ms: Milliseconds
    """From the page's being there until the first frame could be drawn."""
    views: dict[str, PeerView]
    quality: str | None = None


@dataclass(frozen=True)
class _File:
    name: str
    with_clouds: bool
    quality: str | None


FILES: Mapping[str, _File] = {
    "sky": _File("gl_c0_default.json", False, None),
    "clouds low": _File("gl_c1_low.json", True, "low"),
    "clouds high": _File("gl_c1_high.json", True, "high"),
}
"""Files of a folder, by what was drawn."""
_NEEDS: Mapping[str, tuple[str, ...]] = {
    "sky": ("sky",), "clouds": ("clouds low", "clouds high"), "whole": ("sky",), "start": ("sky", "clouds low")
}  # fmt: skip


def runs_of_peer(bench: str) -> tuple[str, ...]:
    """Names in FILES of the runs that a bench of suite peers is about."""
    return _NEEDS[bench]


def read_peer_results(folder: Path | None, wanted: Iterable[str] = FILES) -> dict[str, PeerRun]:
    """The runs that are wanted, by their names in FILES. PeerResultsError where one is missing or malformed."""
    if folder is None:
        raise PeerResultsError(f"peers: no results of the peer were given; add --peer-results FOLDER. {_HOW}")
    if not folder.is_dir():
        raise PeerResultsError(f"--peer-results {folder}: expected a folder, found {_what(folder)}. {_HOW}")
    return {name: _read(folder / FILES[name].name, FILES[name]) for name in wanted}


def _what(path: Path) -> str:
    return "a file" if path.exists() else "nothing of that name"


def _read(path: Path, expected: _File) -> PeerRun:
    try:
        data = path.read_bytes()
    except OSError as error:
        raise PeerResultsError(
            f"{path}: cannot be read ({error.strerror or error}); measure the peer "
            f"{'with' if expected.with_clouds else 'without'} clouds"
            f"{f' at quality {expected.quality}' if expected.quality else ''} first. {_HOW}"
        ) from None
    try:
        run = msgspec.json.decode(data, type=PeerRun)
    except msgspec.MsgspecError as error:
        raise PeerResultsError(f"{path}: not a run of the peer: {error}. {_HOW}") from None
    problem = _problem(run, expected)
    if problem:
        raise PeerResultsError(f"{path}: {problem}; measure again. {_HOW}")
    return run


def _problem(run: PeerRun, expected: _File) -> str | None:
    if tuple(run.size) != SIZE:
        return f"size: expected {SIZE[0]} x {SIZE[1]}, found {run.size[0]} x {run.size[1]}"
    if run.with_clouds != expected.with_clouds:
        return f"withClouds: expected {_json(expected.with_clouds)}, found {_json(run.with_clouds)}"
    if run.quality is not None and expected.quality is not None and run.quality != expected.quality:
        return f'quality: expected "{expected.quality}", found "{run.quality}"'
    missing = [name for name in VIEWS if name not in run.views]
    if missing:
        return f"views: {', '.join(missing)} missing, found {', '.join(run.views) or 'none'}"
    for name, seen in run.views.items():
        if not seen.p10_ms <= seen.median_ms <= seen.p95_ms:
            found = f"{seen.p10_ms:g}, {seen.median_ms:g}, {seen.p95_ms:g}"
            return f"views.{name}: expected p10_ms <= median_ms <= p95_ms, found {found}"
    return None


def _json(value: bool) -> str:
    return "true" if value else "false"


def same_renderer(theirs: str, ours: str) -> bool:
    """Whether WebGL's name of a renderer is that of OpenGL's: browsers wrap it, and leave commas out."""
    plain = _plain(ours)
    return bool(plain) and plain in _plain(theirs)


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9.]+", " ", name.lower()).strip()
