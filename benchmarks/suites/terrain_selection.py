"""Benches of suite terrain: choosing tiles on the CPU, and culling them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...engine.surface.icosphere import TriangleScheme
from ...engine.surface.scheme import QuadScheme
from ..measure.culling import random_pairs
from ..measure.selection import MadeGround, time_selection
from ..session import Bench, Session
from ..target import at_least, at_most
from ..timing import Timing

LEAVES = 750
SEED = 20240601


def _selection(session: Session) -> None:
    """Selection in numpy with 750 leaves: a camera that moves, one that hardly moves, and the first call."""
    for scheme in (QuadScheme(), TriangleScheme()):
        for name, altitude_m in (("100 m", 100.0), ("10 km", 1e4), ("1000 km", 1e6)):
            found = time_selection(MadeGround(scheme), altitude_m, LEAVES, session.runs(300, 60))
            shared = {"leaves": found.leaves, "tiles": found.tiles}
            for variant, times_us, limit_ms, extra in (
                ("warm", found.warm_us, 0.3, {"changed": found.revisions, "facts_us_a_tile": found.facts_us}),
                ("within the slack", found.still_us, 0.3, {}),
                ("cold", found.cold_us, 2.0, {}),
            ):
                session.row(
                    f"{scheme.name}, {variant}",
                    name,
                    timing=Timing.of([1e-3 * t for t in times_us]),
                    target=at_most(limit_ms, "ms"),
                    target_on="ms",
                    **shared,
                    **extra,
                )


def _culling(session: Session) -> None:
    """Random cells and cameras against dense samples: nothing visible is dropped, most of the rest is."""
    for scheme in (QuadScheme(), TriangleScheme()):
        for radius_m, relief_m in ((6.371e6, 9000.0), (1e4, 1500.0)):
            ground = MadeGround(scheme, radius_m, relief_m)
            found = random_pairs(ground, np.random.default_rng(SEED), session.runs(2500, 200))
            named = f"{scheme.name}, radius {radius_m:g} m"
            session.row(f"{named}: visible ones dropped", error=found.dropped, target=at_most(0), pairs=found.pairs,
                        visible=found.visible)  # fmt: skip
            session.row(f"{named}: invisible ones culled", error=100.0 * found.share, error_unit="%",
                        target=at_least(90.0, "%"), pairs=found.pairs)  # fmt: skip


SELECTION_BENCHES: Mapping[str, Bench] = {"selection": _selection, "culling": _culling}
