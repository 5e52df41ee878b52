"""Suite peers: our frames over those of a browser's sky and clouds, whose own measurements are given as files.

The error column is the ratio of the medians, ours over theirs.
"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from ..child import answer_of, keeping_bytecode
from ..measure.peer_scenes import SCENES
from ..measure.peers import PageFrames, page_frames
from ..peer_results import SIZE, VIEWS, PeerRun, read_peer_results, runs_of_peer, same_renderer
from ..session import Bench, Session
from ..target import Target, at_most
from ..timing import Timing

__all__ = ["BENCHES"]

_RATIO = "of the peer's"


@dataclass(frozen=True)
class _Case:
    """What of ours is held against which run of theirs."""

    variant: str
    scene: str
    quality: str
    theirs: str
    most: float | None
    """What the ratio may be; None: nothing is promised."""


_SKY = (
    _Case("low", "sky", "low", "sky", 0.2),
    _Case("medium", "sky", "medium", "sky", None),
)
_CLOUDS = (
    _Case("low", "clouds", "low", "clouds low", 0.07),
    _Case("high", "clouds", "high", "clouds high", 0.08),
)
_WHOLE = (
    _Case("low, no gullies, rivers and trees", "bare", "low", "sky", 0.6),
    _Case("low", "whole", "low", "sky", 0.75),
    _Case("medium", "whole", "medium", "sky", 1.2),
    _Case("high", "whole", "high", "sky", 3.0),
)
_START = (
    _Case("sky, low", "sky", "low", "sky", 1.0),
    _Case("clouds, low", "clouds", "low", "clouds low", 1.0),
    _Case("whole planet, low; their sky", "whole", "low", "sky", 1.0),
)


def _frames(session: Session, cases: Iterable[_Case]) -> None:
    theirs = read_peer_results(session.peer_results, runs_of_peer(session.bench))
    quick = session.extent == "quick"
    runs, more = (5, {"run_up": 3}) if quick else (session.runs(60, 20), {})
    for case in cases:
        with SCENES[case.scene]() as scene, session.renderer(scene, SIZE, case.quality) as renderer:
            for view in VIEWS:
                for way, found in page_frames(renderer, view, runs, **more).items():
                    _frame_row(session, case, view, way, found, theirs[case.theirs])


def _frame_row(session: Session, case: _Case, view: str, way: str, found: PageFrames, theirs: PeerRun) -> None:
    peer = theirs.views[view]
    same, target = _promise(session, case, theirs)
    session.row(
        f"{case.variant}; {way}", view, SIZE, found.timing, error=found.timing.ms / peer.median_ms, error_unit=_RATIO,
        target=target, n=found.timing.runs, p95_ms=found.p95_ms, cpu_ms=found.cpu_ms, peer_ms=peer.median_ms,
        peer_n=peer.n, peer_p10_ms=peer.p10_ms, peer_p95_ms=peer.p95_ms, same_renderer=same,
        peer_renderer=theirs.renderer,
    )  # fmt: skip


def _promise(session: Session, case: _Case, theirs: PeerRun) -> tuple[bool, Target | None]:
    """Whether both used the same renderer; what is promised then: of two renderers, a ratio says nothing."""
    same = same_renderer(theirs.renderer, session.machine().gl_renderer)
    return same, at_most(case.most) if same and case.most is not None else None


def _sky(session: Session) -> None:
    """Sky and air over plain ground, against the same of the peer."""
    _frames(session, _SKY)


def _clouds(session: Session) -> None:
    """The same with clouds, against the peer's clouds of the same quality."""
    _frames(session, _CLOUDS)


def _whole(session: Session) -> None:
    """A whole planet with ground, sea, clouds and shadows, against the peer's sky without clouds."""
    _frames(session, _WHOLE)


def _start(session: Session) -> None:
    """From the command to the first picture, in a fresh process that finds warm caches, against the peer's loading and
    first frame, which leave out the start of the browser."""
    theirs = read_peer_results(session.peer_results, runs_of_peer(session.bench))
    for case in _START:
        with keeping_bytecode() as again:
            _first_picture(case, again)
            warm = [_first_picture(case, again) for _ in range(session.runs(9, 5))]
        peer = theirs[case.theirs]
        parts = peer.load_ms, peer.views[VIEWS[0]].first_ms
        timing = Timing.of([run["first picture"] for run in warm])
        same, target = _promise(session, case, peer)
        session.row(
            case.variant, VIEWS[0], SIZE, timing, error=timing.ms / sum(parts), error_unit=_RATIO, target=target,
            n=timing.runs, import_ms=min(run["import"] for run in warm), peer_ms=sum(parts), peer_load_ms=parts[0],
            peer_first_ms=parts[1], same_renderer=same, peer_renderer=peer.renderer,
        )  # fmt: skip


def _first_picture(case: _Case, environment: Mapping[str, str]) -> dict[str, float]:
    module = "planetfall.benchmarks.measure.peer_start"
    return answer_of("-m", module, str(time.time()), case.scene, case.quality, environment=environment)


BENCHES: Mapping[str, Bench] = {"sky": _sky, "clouds": _clouds, "whole": _whole, "start": _start}
