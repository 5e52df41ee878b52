"""Suite frame, bench views: a frame of the whole planet, clouds and all, in every view."""

from __future__ import annotations

from ... import view
from ...camera.views import views
from ..measure import frames
from ..session import Session
from ..target import at_most

__all__ = ["bench"]

SIZE = (640, 360)
MOST_MS = {"low": 66.0, "medium": 120.0}
QUICK_VIEWS = ("space", "near", "sea")


def bench(session: Session) -> None:
    """Camera turning, time running: what a flight's frame costs between snaps of the proxy."""
    for quality, most_ms in MOST_MS.items():
        with session.renderer("earth", SIZE, quality, clouds=True) as renderer:
            for name in QUICK_VIEWS if session.extent == "quick" else views(renderer.scene.planet):
                found = frames.time_running(renderer, view(name, renderer.scene.planet), session.runs(9, 5))
                session.row(
                    quality, name, SIZE, found.timing, target=at_most(most_ms, "ms"), target_on="ms",
                    cpu_ms=found.cpu_ms,
                )  # fmt: skip
