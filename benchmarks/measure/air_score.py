"""Errors of answers about clear air against the reference's, by class of sun, view and camera.

Per quantity and class: medians, 95th percentiles and maxima, all wavelengths pooled, of
- rel = |a - b| / |b|, where |b| exceeds a floor (1e-7 for radiance, 1e-6 for transmittance);
- wrel = |a - b| / (|b| + 0.1 ref), with ref a brightness that counts to the eye under the same sun: the median of the
  reference over sky views with that sun, at least 1e-4 of the same by day (views from space: the day's). Errors in what
  is black beside it weigh little. For transmittances ref is 10;
- abs, the largest |a - b|; and the number of bad answers: NaN, infinite or negative ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from ..reference.air_medium import Floats
from .air_queries import AirQueries

Kind = Literal["transmittance", "single", "total", "aerial", "irradiance"]
Mask = NDArray[np.bool_]
RADIANCE_FLOOR, TRANSMITTANCE_FLOOR = 1e-7, 1e-6
FAINTEST = 1e-4


@dataclass(frozen=True)
class AirScore:
    """The errors of one quantity in one class; NaN where no value is above the floor."""

    quantity: str
    group: str
    count: int
    """Values that `rel` counts."""
    rel_median: float
    rel_p95: float
    rel_max: float
    wrel_median: float
    wrel_p95: float
    wrel_max: float
    abs_max: float
    bad: int


def classes(kind: Kind, queries: AirQueries) -> dict[str, Mask]:
    """The rows of each class that has any, and all of them first."""
    sun, view, space, hits = queries.sun_zenith_deg, queries.view_zenith_deg, queries.in_space, queries.hits_ground
    found: dict[str, Mask] = {"all": np.ones(len(queries), dtype=bool)}
    if kind == "transmittance":
        found |= {"z<=80": view <= 80.0, "80<z<=89": (view > 80.0) & (view <= 89.0), "z>89": view > 89.0}
    elif kind == "single":
        for name, rows in _suns(sun).items():
            found[f"sky {name}"] = rows & ~hits & ~space
            found[f"ground {name}"] = rows & hits & ~space
    elif kind == "total":
        spans = {
            "sun<=75": sun <= 75.0, "sun 80-88": (sun > 75.0) & (sun <= 88.0), "sun 90": (sun > 88.0) & (sun <= 90.0),
            "sun 92": (sun > 90.0) & (sun <= 92.0), "sun 94-96": sun > 92.0,
        }  # fmt: skip
        found |= {f"in atmosphere {name}": rows & ~space for name, rows in spans.items()}
    elif kind == "aerial":
        found |= {"sun<=85": sun <= 85.0, "sun 90": (sun > 85.0) & (sun <= 90.0), "sun>90": sun > 90.0}
    else:
        found |= {
            "sun<=75": sun <= 75.0, "sun 85-88": (sun > 75.0) & (sun <= 88.0),
            "sun 90-91": (sun > 88.0) & (sun <= 91.0), "sun>91": sun > 91.0,
        }  # fmt: skip
    if kind in ("single", "total"):
        found |= {"space sun<=90": space & (sun <= 90.0), "space sun>90": space & (sun > 90.0)}
    return {name: rows for name, rows in found.items() if rows.any()}


def _suns(sun: Floats) -> dict[str, Mask]:
    return {
        "day": sun <= 75.0,
        "low": (sun > 75.0) & (sun < 90.0),
        "set": (sun >= 90.0) & (sun < 92.0),
        "twilight": sun >= 92.0,
    }


def reference_brightness(kind: Kind, queries: AirQueries, truth: Floats) -> Floats:
    """(N, K) `ref` of each row and column of `truth` (N, K)."""
    if kind == "transmittance":
        return np.full(truth.shape, 10.0)
    sun = queries.sun_zenith_deg
    sky = ~queries.in_space & ~queries.hits_ground if kind == "single" else np.ones(len(queries), dtype=bool)
    day = np.median(truth[sky & ((sun == 30.0) if kind == "single" else (sun <= 75.0))], axis=0)
    ref = np.broadcast_to(day, truth.shape).copy()
    for zenith in np.unique(sun):
        same = sky & (sun == zenith)
        if same.any():
            rows = (sun == zenith) & ~queries.in_space if kind == "single" else sun == zenith
            ref[rows] = np.maximum(np.median(truth[same], axis=0), FAINTEST * day)
    return ref


def score(
    kind: Kind, quantity: str, queries: AirQueries, candidate: Floats, truth: Floats, brightness: Floats | None = None
) -> list[AirScore]:
    """Scores of candidate (N, K) against truth (N, K) in every class.

    `brightness`: `reference_brightness` of a larger grid's rows, when these are a sample of it.
    ValueError when shapes differ or the truth is not finite.
    """
    if candidate.shape != truth.shape or len(truth) != len(queries):
        raise ValueError(f"score: {candidate.shape} answers, {truth.shape} truths, {len(queries)} queries do not fit")
    if not np.isfinite(truth).all():
        raise ValueError("score: the reference has values that are not finite")
    ref = reference_brightness(kind, queries, truth) if brightness is None else brightness
    floor = TRANSMITTANCE_FLOOR if kind == "transmittance" else RADIANCE_FLOOR
    bad = ~np.isfinite(candidate) | (candidate < -1e-9)
    error = np.abs(np.where(np.isfinite(candidate), candidate, 0.0) - truth)
    size = np.abs(truth)
    weighed = error / (size + 0.1 * ref)
    scores: list[AirScore] = []
    for name, rows in classes(kind, queries).items():
        counted = size[rows] > floor
        rel = (error[rows] / np.maximum(size[rows], 1e-300))[counted]
        spreads = (*_spread(rel), *_spread(weighed[rows].ravel()))
        scores.append(
            AirScore(quantity, name, int(counted.sum()), *spreads, float(error[rows].max()), int(bad[rows].sum()))
        )
    return scores


def _spread(values: Floats) -> tuple[float, float, float]:
    if values.size == 0:
        return float("nan"), float("nan"), float("nan")
    return float(np.median(values)), float(np.percentile(values, 95)), float(values.max())
