"""Bench of clouds in pictures against paths of light through them."""

from __future__ import annotations

import logging
from typing import Any

import numpy as np

from ...systems.capture import write_png
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
"""For the truth of a view, in all runs together."""
REACHED = 0.95
"""Share of its pixels whose standard error is as wanted, with which a truth is done."""


def pathtraced(session: Session) -> None:
    """Light of weather clouds in windows of named views against paths of light through the same clouds, without air:
    log2 of the ratio, local contrast. Truths are followed as far as none that is good enough is kept for just these
    clouds (not in a quick run). Windows side by side, traced, low, medium, high: a picture beside the truths."""
    truths: dict[str, measure.Truth] = {}
    for name, shot in measure.SHOTS.items():
        held = measure.held_truth(name, shot)
        left_s = MOST_S - (0.0 if held is None else held.seconds)
        if session.extent != "quick" and left_s > 0.0 and (held is None or held.reached < REACHED):
            held = measure.truth_of(session.gpu, shot, left_s, before=held)
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
    windows = {quality: measure.drawn(shots, quality) for quality in QUALITIES}
    for name, truth in truths.items():
        sheet = scores.sheet(truth, {quality: windows[quality][name] for quality in QUALITIES})
        write_png(measure.truth_path(name).with_suffix(".png"), sheet)
    for quality in QUALITIES:
        for name, window in windows[quality].items():
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
            by_opacity: dict[str, Any] = {at: v for at, v in found.by_opacity.items() if np.isfinite(v)}
            session.row(
                quality, name, size, error=found.light, error_unit="of the traced light", opacity=found.opacity,
                **by_opacity,
            )  # fmt: skip
            within = None if times is None else Target(1.0 - times * CONTRAST, 1.0 + times * CONTRAST)
            session.row(quality, name, size, error=found.contrast, error_unit="of the traced contrast", target=within)
