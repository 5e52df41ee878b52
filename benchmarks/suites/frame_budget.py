"""Suite frame, bench budget: whether automatic quality holds a frame budget, with pictures."""

from __future__ import annotations

import math

from ... import path, view
from ..measure.budget import Held, fly_within, full_costs
from ..scenes import preset_scene
from ..session import Session
from ..target import at_least

__all__ = ["bench"]

SIZE = (320, 180)
SHARE, BETWEEN_S = 95.0, 5.0
BUDGET = 1.0
"""Of what the dearest place costs at full quality at rest: frames in flight cost more."""
LOAD_BUDGET = 1.5
"""Of a frame over the coast at full quality, which costs twice as much every other 20 s."""
PLACES = (0.1, 0.4, 0.7, 0.85, 0.95)
"""Shares of the flight, to find that place."""
STEP_S = 20.0


def bench(session: Session) -> None:
    """The descent, and a load that doubles and halves every 20 s over the coast; clock and cost in processor time."""
    scene = preset_scene("earth", not session.small)
    flown, coast = path("descent", scene), view("coast", scene.planet)
    cameras = [flown.camera_at(share * flown.duration_s) for share in PLACES]
    pace = 2.0 if session.small else 1.0
    seconds = STEP_S * (3 if session.small else 8)
    with session.renderer(scene, SIZE, "medium") as renderer:
        budget_ms = BUDGET * max(full_costs(renderer, cameras, flown.sun))
        lasts_s = flown.duration_s / pace
        held = fly_within(renderer, lambda t: flown.camera_at(pace * t), lasts_s, budget_ms, flown.sun)
        _rows(session, "descent", held)
        budget_ms = LOAD_BUDGET * full_costs(renderer, [coast], coast.sun)[0]
        held = fly_within(renderer, lambda _: coast.camera, seconds, budget_ms, coast.sun, _doubles)
        _rows(session, "load that doubles and halves", held)
    scene.release()


def _doubles(now_s: float) -> float:
    return 1.0 + int(now_s / STEP_S) % 2


def _rows(session: Session, name: str, held: Held) -> None:
    session.row(
        f"{name}: frames within 10 % of the budget", "descent" if name == "descent" else "coast", SIZE,
        error=100.0 * held.share, error_unit="%", target=at_least(SHARE), budget_ms=held.budget_ms,
        frames=len(held.lasts_ms), changes=len(held.changes_s), least_dial=min(held.dials),
        hitches_percent=100.0 * float(held.hitches.mean()), held_of_rest_percent=100.0 * held.share_of_rest,
    )  # fmt: skip
    least_s = held.least_between_s
    session.row(
        f"{name}: least time between changes", "descent" if name == "descent" else "coast", SIZE,
        error=least_s if math.isfinite(least_s) else None, error_unit="s", target=at_least(BETWEEN_S),
    )  # fmt: skip
