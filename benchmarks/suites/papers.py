"""Suite papers: every printed technique beside ours, in milliseconds and error, and how much faster ours is where its
error is no larger.

A row is a printed technique. `ms` and **error** are ours, those of the fastest setting whose error is no larger than
the printed one's; `setting` names it. Where there is none, they are those of our setting with the least error, and
`ratio` is NaN. Printed work counts in every frame in which its source does it: vertices come from tessellation
or vertex shaders in every frame there (`anew_ms`; `held_ms` without that), ours are kept until the next snap.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import view
from ..measure import ground, waves
from ..measure.cloud_paper import against_printed
from ..measure.frames import time_passes
from ..measure.whole import Picture, reference_of, whole_frame
from ..scenes import earth
from ..session import Bench, Session
from ..target import at_least
from .atmosphere import CURVE, air_curve

SEED = 20240601
VIEWS = ("near", "high", "orbit")
SIZE, QUICK_SIZE = (640, 360), (320, 180)
AHEAD = at_least(1.0, "times")
CLOUDS_AHEAD = at_least(6.0, "times")
WAVES_AHEAD = at_least(2.0, "times")
"""Of 100 waves and more."""
PICTURES = (
    "space", "orbit", "day_edge", "high", "coast", "near", "valley", "beach", "sea", "clouds", "dusk", "terminator",
)  # fmt: skip
"""Views of the sheet in docs/sources.md."""
_WHOLE = ("low", "medium")
"""Ours; the sheet shows the last."""
EDGES_PX = (4.0, 8.0, 16.0, 32.0, 64.0)


@dataclass(frozen=True)
class Cost:
    """Of a frame of one setting, and how far its picture is off."""

    ms: float
    error: float


def _row(
    session: Session, technique: str, place: str, printed: Cost, ours: Mapping[str, Cost], unit: str,
    target: Any = AHEAD, size: tuple[int, int] | None = None, **extra: Any,
) -> None:  # fmt: skip
    """One technique; ours by setting."""
    able = {name: cost for name, cost in ours.items() if cost.error <= printed.error}
    if able:
        name = min(able, key=lambda n: able[n].ms)
        ratio = printed.ms / able[name].ms
    else:
        name, ratio = min(ours, key=lambda n: ours[n].error), float("nan")
    session.row(
        technique, place, size, error=ours[name].error, error_unit=unit, ours_ms=ours[name].ms, setting=name,
        printed_ms=printed.ms, printed_error=printed.error, ratio=ratio, target=target, target_on="ratio", **extra,
    )  # fmt: skip


_OURS = {f"grid, edges of {px:g} px": {"terrain.edge_px": px} for px in EDGES_PX}
_PRINTED_GRIDS = {
    f"projected grid {n} x {n}, {layers} layers": {
        "terrain.method": "paper", "terrain.paper_grid": n, "terrain.paper_layers": layers,
    }
    for n, layers in ((50, 5), (100, 5), (200, 5), (100, 0), (100, 10))
}  # fmt: skip
_PRINTED_TILES = {
    f"{name}, as printed": {"terrain.backend": name, "terrain.method": "paper"} for name in ("quadtree", "icosphere")
}
_AIRS = {
    f"low, {columns} x {rows} x {slices}": (
        "low", {"atmosphere.columns": columns, "atmosphere.rows": rows, "atmosphere.slices": slices},
    )
    for columns, rows, slices in ((8, 16, 6), (12, 32, 10))
}  # fmt: skip
"""Tables of a view."""
_MESH = ("terrain.cull", "terrain.vertices", "terrain.gbuffer")


def _ground(session: Session) -> None:
    """Meshes: passes that cull, make and draw them, each waited for. The error is the 99th percentile of pixels to the
    scene's ground without gullies and rivers, which printed heights of a projected grid are not; `mesh_px` are to the
    ground that each draws."""
    size = QUICK_SIZE if session.extent == "quick" else SIZE
    most, rng = session.runs(20_000, 3000), np.random.default_rng(SEED)
    for place in VIEWS:
        at, costs, extras = view(place), {}, {}
        for name, overrides in {**_OURS, **_PRINTED_GRIDS, **_PRINTED_TILES}.items():
            with session.renderer(earth(0.0, 0.0), size, "medium", dict(overrides)) as renderer:
                renderer.settle(at)
                passes = time_passes(renderer, at, session.runs(15, 6))
                held = sum(timing.ms for key, timing in passes.items() if key in _MESH)
                anew = held + sum(timing.ms for key, timing in passes.items() if key == "terrain.vertices (snap)")
                renderer.settle(at)
                drawn = ground.picture_error(renderer, at, rng, most, renderer.height_field())
                truth = ground.picture_error(renderer, at, rng, most)
            assert drawn is not None and truth is not None
            costs[name] = Cost(held if name in _OURS else anew, truth.p99_px)
            extras[name] = {"mesh_px": drawn.p99_px, "held_ms": held, "anew_ms": anew}
        ours = {name: costs[name] for name in _OURS}
        for name in (*_PRINTED_GRIDS, *_PRINTED_TILES):
            _row(session, name, place, costs[name], ours, "px p99", size=size, **extras[name])


def _sea(session: Session) -> None:
    """Waves by their number: passes that make the sea's shape, mean FLIP to a converged picture."""
    size = QUICK_SIZE if session.small else SIZE
    quick = session.extent == "quick"
    for place, altitude in (("1 km", 1000.0),) if quick else (("5 m", 5.0), ("1 km", 1000.0)):
        for count in (20, 100) if quick else (20, 50, 100, 1000):
            seen, times = waves.against_printed(waves.open_sea(altitude), size, count, session.runs(7, 3))
            costs = {name: Cost(times[name].shape.ms, seen[name]) for name in seen}
            ours = {name: cost for name, cost in costs.items() if name.startswith("ours")}
            for name in (name for name in costs if name not in ours):
                _row(
                    session, f"{count} spherical waves, {name}", place, costs[name], ours, "mean FLIP",
                    WAVES_AHEAD if count >= 100 else AHEAD, size,
                )  # fmt: skip


def _air(session: Session) -> None:
    """Tables of 2008 and 2017 as printed: sky and air of a climbing camera, by class of question."""
    found = list(air_curve(session, _AIRS))
    costs: dict[str, dict[str, Cost]] = {
        name: {quality: Cost(cost.wall.ms, errors[name]) for quality, cost, errors in found} for name in CURVE
    }
    for name, by_quality in costs.items():
        printed = by_quality.pop("paper")
        _row(session, f"precomputed air: {name}", "10 km, climbing", printed, by_quality, f"rel p95, {name}")


def _clouds(session: Session) -> None:
    """Both marches through the printed texture: processor time of the clouds in flight, mean FLIP to the reference."""
    size = (192, 108) if session.small else SIZE
    session.release()
    found = against_printed({name: view(name) for name in VIEWS}, size, session.runs(33, 8), session.runs(16, 5))
    for place in VIEWS:
        ours = {name: Cost(found[name, place].ms, found[name, place].error) for name in ("low", "high")}
        for year in ("2018", "2019"):
            cost = found[f"paper_{year}", place]
            _row(
                session, f"clouds of {year}", place, Cost(cost.ms, cost.error), ours, "mean FLIP", CLOUDS_AHEAD, size,
            )  # fmt: skip


def _pictures(session: Session) -> None:
    """Whole frames of quality `paper` beside ours, at the views of the sheet: milliseconds of a turning camera, and
    mean FLIP to quality `reference`, of ground without gullies and rivers. Printed vertices are made in every frame.
    Where the printed ground has a place of its own, its picture is of another coast or valley than the reference's."""
    session.release()
    scene, size = earth(0.0, 0.0, clouds=True), QUICK_SIZE
    names = PICTURES[:2] if session.extent == "quick" else PICTURES
    references: dict[str, Picture] = {name: reference_of(scene, view(name, scene.planet), size) for name in names}
    costs: dict[str, dict[str, Cost]] = {}
    for quality in ("paper", *_WHOLE):
        with session.renderer(scene, size, quality) as renderer:
            for name in names:
                seen = view(name, scene.planet)
                found = whole_frame(renderer, seen, references[name], session.runs(15, 5))
                ms, error = found.cost.timing.ms, found.mean_flip
                if quality == "paper":
                    passes = time_passes(renderer, seen, session.runs(6, 3))
                    ms += sum(timing.ms for key, timing in passes.items() if key == "terrain.vertices (snap)")
                costs.setdefault(name, {})[quality] = Cost(ms, float("nan") if error is None else error)
    for name, by_quality in costs.items():
        printed, sheet = by_quality.pop("paper"), by_quality[_WHOLE[-1]]
        extra = {f"{_WHOLE[-1]}_ms": sheet.ms, f"{_WHOLE[-1]}_error": sheet.error}
        _row(session, "whole picture", name, printed, by_quality, "mean FLIP", size=size, **extra)
    scene.release()


BENCHES: Mapping[str, Bench] = {"ground": _ground, "sea": _sea, "air": _air, "clouds": _clouds, "pictures": _pictures}
