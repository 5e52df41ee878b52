"""Suite clouds: errors of the march through homogeneous clouds against float64 references."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..measure import cloud_shafts, clouds
from ..session import Bench, Session
from ..target import Target, at_most

QUALITIES = ("low", "medium", "high", "ultra", "reference")
MEDIANS = {"high": 3e-2, "reference": 1e-2}
"""What is promised of single scattering in shells, by quality."""


def _accuracy(session: Session) -> None:
    """The table of promises: shells in vacuum and in air, shafts of light, slabs of all orders."""
    for method in ("paper_2018", "paper_2019"):
        for name, shells in {**clouds.SHELLS, **clouds.IN_AIR}.items():
            if len(shells.layers) == 1:  # as printed
                found = clouds.errors_of(shells, "high", session.runs(300, 60), method)
                _rows(session, f"{method}: {name}", found, None, None, False)
    qualities = ("high", "reference") if session.quick else QUALITIES
    for quality in qualities:
        judged = quality == "reference"
        for name, shells in clouds.SHELLS.items():
            found = clouds.errors_of(shells, quality, session.runs(1000, 300))
            median = at_most(MEDIANS[quality]) if quality in MEDIANS else None
            _rows(session, f"{quality}: shell, {name}", found, median, at_most(5e-2) if judged else None, True)
        for name, shells in clouds.IN_AIR.items():
            found = clouds.errors_of(shells, quality, session.runs(300, 60))
            limits = (at_most(2e-2), at_most(0.1)) if judged else (None, None)
            _rows(session, f"{quality}: in air, {name}", found, *limits, judged)
        for name, shells in clouds.SHAFTS.items():
            found = clouds.errors_of(shells, quality, session.runs(300, 60))
            _rows(session, f"{quality}: shafts of light, {name}", found, at_most(5e-2), None, judged)
        # As pictures have them: maps of the shadow, a few steps along a ray.
        size = (16, 10) if not session.quick else (8, 5)
        for name, made, shots in (
            ("even shell", cloud_shafts.uniform_clouds(), cloud_shafts.UNIFORM),
            ("weather", cloud_shafts.weather_clouds(), cloud_shafts.WEATHER),
        ):
            relative = cloud_shafts.shaft_errors(made, shots[::2] if session.quick else shots, quality, size)
            session.row(
                f"{quality}: pictures, shafts of light, {name}", error=float(np.median(relative)),
                error_unit="rel median", target=at_most(5e-2) if judged or name == "weather" else None,
                p95=float(np.percentile(relative, 95)), answers=len(relative),
            )  # fmt: skip
        # Of the deepest slab every photon is followed through hundreds of events.
        for depth in clouds.SLAB_DEPTHS[:3] if session.quick else clouds.SLAB_DEPTHS:
            photons = int(session.runs(640_000, 40_000) / max(depth / 2.0, 1.0))
            found, noise = clouds.slab_errors(depth, quality, photons)
            session.row(
                f"{quality}: all orders, slab of depth {depth:g}", error=found.worst, error_unit="rel max",
                target=at_most(0.3), median=found.median, noise=noise, answers=found.count,
            )  # fmt: skip


def _rows(
    session: Session, name: str, found: clouds.Errors, median: Target | None, p95: Target | None, through: bool
) -> None:
    session.row(
        name, error=found.median, error_unit="rel median", target=median, worst=found.worst, bad=found.bad,
        answers=found.count,
    )  # fmt: skip
    session.row(name, error=found.p95, error_unit="rel p95", target=p95)
    session.row(f"{name}: transmittance", error=found.transmittance, error_unit="abs max",
        target=at_most(1e-4) if through else None,
    )  # fmt: skip


BENCHES: Mapping[str, Bench] = {"accuracy": _accuracy}
