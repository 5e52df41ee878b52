"""Bench of clouds in pictures against paths of light through them."""

from __future__ import annotations

import logging
from typing import Any

from ..measure import cloud_path_scores as scores
from ..measure import cloud_paths as measure
from ..session import Session
from ..target import Target, at_most

__all__ = ["pathtraced"]

log = logging.getLogger(__name__)
QUALITIES = ("low", "medium", "high")
PROMISED = {"low": 2.0, "high": 1.0}
"""Multiples of what is promised, by quality."""
MEDIAN, P95, CONTRAST = 0.2, 0.6, 0.25
MOST_S = 1200.0
"""For the truth of a view, where none is stored."""


def pathtraced(session: Session) -> None:
    """Light of weather clouds in windows of named views against paths of light through the same clouds, without air:
    log2 of the ratio, local contrast. Truths are followed where none is kept for just these clouds (not in a quick
    run)."""
    truths: dict[str, measure.Truth] = {}
    for name, shot in measure.SHOTS.items():
        held = measure.held_truth(name, shot)
        if held is None and session.extent != "quick":
            held = measure.truth_of(session.gpu, shot, MOST_S)
            measure.store_truth(name, shot, held)
        if held is None:
            log.warning("clouds.pathtraced: no truth of %s for these clouds; run without --quick", name)
        elif held.judged.any():
            truths[name] = held
    session.release()
    shots = {name: measure.SHOTS[name] for name in truths}
    for name, truth in truths.items():
        session.row(
            "traced", name, measure.WINDOW, error=float((truth.error / truth.wanted)[truth.judged].mean()),
            error_unit="standard errors wanted", reached=truth.reached, paths=float(truth.paths.mean()),
            seconds=truth.seconds,
        )  # fmt: skip
    for quality in QUALITIES:
        for name, window in measure.drawn(shots, quality).items():
            found, times = scores.score_of(truths[name], window), PROMISED.get(quality)
            places: dict[str, Any] = {at: value for at, value in found.places.items() if found.shares[at] > 0.01}
            size = measure.WINDOW
            session.row(
                quality, name, size, error=found.median, error_unit="log2 median", noise=found.noise, **places,
                target=None if times is None else at_most(times * MEDIAN),
            )  # fmt: skip
            session.row(
                quality, name, size, error=found.p95, error_unit="log2 p95",
                target=None if times is None else at_most(times * P95),
            )  # fmt: skip
            within = None if times is None else Target(1.0 - times * CONTRAST, 1.0 + times * CONTRAST)
            session.row(quality, name, size, error=found.contrast, error_unit="of the traced contrast", target=within)
