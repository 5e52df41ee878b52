"""Many differences between the GPU and float64: pooled over cases, counted into histograms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..session import Session

__all__ = ["ABSOLUTE_BENCH", "ABSOLUTE_EDGES", "SUMMARY_BENCH", "ULP_BENCH", "ULP_EDGES", "Deviations", "add_rows"]

Floats = NDArray[np.float64]

ULP_EDGES = (0.5, *(float(2**k) for k in range(13)))
ABSOLUTE_EDGES = tuple(10.0**k for k in range(-12, 2))
SUMMARY_BENCH, ULP_BENCH, ABSOLUTE_BENCH = "errors", "histogram in ulp", "histogram in absolute errors"


@dataclass(frozen=True)
class Deviations:
    """Of some numbers: in units of the last place of single precision, and as they are."""

    ulp: Floats
    absolute: Floats
    unit: str

    @classmethod
    def of(cls, got: Floats, true: Floats, unit: str, spacing: Floats) -> Deviations:
        """From arrays of one shape; spacing: of single-precision numbers, where they are."""
        off = np.abs(np.asarray(got, np.float64) - true)
        return cls((off / spacing).ravel(), off.ravel(), unit)

    @classmethod
    def pooled(cls, parts: Iterable[Deviations]) -> Deviations:
        """All of them together; one or more, of one unit."""
        parts = list(parts)
        return cls(np.concatenate([p.ulp for p in parts]), np.concatenate([p.absolute for p in parts]), parts[0].unit)


def shares(values: Floats, edges: Sequence[float]) -> dict[str, Any]:
    """Share of the values up to each edge and above the one before, and of those beyond the last, by label."""
    places = np.searchsorted(np.asarray(edges), values, side="left")
    counted = np.bincount(places, minlength=len(edges) + 1) / max(len(values), 1)
    labels = [*(f"<= {edge:g}" for edge in edges), f"> {edges[-1]:g}"]
    return {label: float(share) for label, share in zip(labels, counted, strict=True)}


def add_rows(session: Session, found: Mapping[str, Sequence[Deviations]]) -> None:
    """Three benches: quantiles of each quantity, its histogram in ulp, and the one in its own unit."""
    pooled = {name: Deviations.pooled(parts) for name, parts in found.items() if parts}
    session.bench = SUMMARY_BENCH
    for name, all_of in pooled.items():
        median, p99, p999 = np.quantile(all_of.absolute, (0.5, 0.99, 0.999))
        ulps = np.quantile(all_of.ulp, (0.5, 0.99, 0.999))
        session.row(
            name, error=all_of.absolute.max(), error_unit=all_of.unit, numbers=len(all_of.ulp), median=median, p99=p99,
            p999=p999, ulp_median=ulps[0], ulp_p99=ulps[1], ulp_p999=ulps[2], ulp_most=all_of.ulp.max(),
        )  # fmt: skip
    session.bench = ULP_BENCH
    for name, all_of in pooled.items():
        session.row(name, **shares(all_of.ulp, ULP_EDGES))
    session.bench = ABSOLUTE_BENCH
    for name, all_of in pooled.items():
        session.row(name, **shares(all_of.absolute, ABSOLUTE_EDGES))
