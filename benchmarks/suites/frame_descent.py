"""Suite frame, bench descent: how evenly the frames of the flight from space to the ground come."""

from __future__ import annotations

from ..measure import descent
from ..scenes import preset_scene
from ..session import Session
from ..target import at_most

__all__ = ["bench"]

SIZE, QUICK_SIZE = (640, 360), (320, 180)
P99_OVER_MEDIAN, WORST_OVER_MEDIAN = 2.0, 4.0
FLIGHTS = 3
"""Of them the most even counts: what else a machine does comes by chance, a hitch of ours each time."""


def bench(session: Session) -> None:
    """Percentiles of the frames after the first second, by the clock and in processor time; work per frame."""
    # With few frames each makes a snap, and what a flight is like from frame to frame isn't seen.
    quick = session.extent == "quick"
    size, frames = QUICK_SIZE if session.small else SIZE, 40 if quick else 600
    for clouds in (False,) if quick else (False, True):
        name = "with clouds" if clouds else "without clouds"
        scene = preset_scene("earth", clouds)
        flight = descent.descent(scene, frames)
        flights = []
        for _ in range(1 if quick else FLIGHTS):
            with session.renderer(scene, size, "medium") as renderer:
                flights.append(descent.fly_timed(renderer, flight))
        scene.release()
        clock = min((descent.percentiles(f, flight.frame_s) for f in flights), key=lambda p: p.p99_over_median)
        used = min((descent.percentiles(f, flight.frame_s, True) for f in flights), key=lambda p: p.p99_over_median)
        session.row(
            f"{name}: p99 over the median", "descent", size, error=clock.p99_over_median,
            target=at_most(P99_OVER_MEDIAN), p50_ms=clock.p50_ms, p99_ms=clock.p99_ms,
            of_cpu=used.p99_over_median, frames=frames,
        )  # fmt: skip
        session.row(
            f"{name}: worst frame over the median", "descent", size, error=clock.worst_over_median,
            target=at_most(WORST_OVER_MEDIAN), worst_ms=clock.worst_ms, of_cpu=used.worst_over_median, frames=frames,
        )  # fmt: skip
        most = descent.most(flights[-1][1:])
        del most["ms"], most["cpu_ms"]
        built = [f"{t * flight.frame_s:.0f} s" for t, f in enumerate(flights[-1]) if f.programs_built]
        session.row(f"{name}: most of a frame", "descent", size, **most, programs_built_at=", ".join(built))
