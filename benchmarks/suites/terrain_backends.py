"""Benches of suite terrain that compare the backends: error, time and triangles; popping in flight; holes."""

from __future__ import annotations

import numpy as np

from ... import path, qualities, view
from ..measure import ground, holes, popping
from ..measure.frames import time_frames
from ..scenes import preset_scene
from ..session import Session
from ..target import at_most

BACKENDS = ("grid", "quadtree", "icosphere")
VIEWS = ("near", "high", "orbit")
BENCH, SMALL = (640, 360), (96, 54)
SEED = 20240601
FRAME_S = 1.0 / 60.0


def backends(session: Session) -> None:
    """Error on screen against time and triangles: which backend is best where."""
    rng = np.random.default_rng(SEED)
    steps = ("medium", "high") if session.small else [q for q in qualities() if q not in ("paper", "reference")]
    for quality in steps:
        for name in BACKENDS:
            with session.renderer("earth", BENCH, quality, {"terrain.backend": name}) as renderer:
                for place in VIEWS:
                    renderer.settle(view(place))
                    found = ground.picture_error(renderer, view(place), rng, session.runs(20_000, 4000))
                    times = time_frames(renderer, view(place), session.runs(9, 4))
                    if found is None:
                        continue
                    session.row(
                        f"{name}, {quality}", place, BENCH, times.turning, error=found.p99_px, error_unit="px p99",
                        target=at_most(1.0, "px") if quality == "high" else None,
                        snap_ms=times.snapping.columns()["ms"],
                        triangles=renderer.stats["triangles"], vertices=renderer.stats["vertices"],
                        median_px=found.median_px, worst_px=found.worst_px,
                    )  # fmt: skip


def popping_in_flight(session: Session) -> None:
    """How far ground moves on screen from one frame to the next, the camera's motion apart."""
    size = (320, 180)
    parts = {
        "low": [(10.0, session.runs(240, 40))],
        "descent": [(second, session.runs(60, 10)) for second in (2.0, 14.0, 22.0, 30.0, 38.0, 46.0, 52.0, 57.0)],
    }
    for name in BACKENDS:
        scene = preset_scene("earth")
        with session.renderer(scene, size, "high", {"terrain.backend": name}) as renderer:
            for flight, starts in parts.items():
                way = path(flight, scene)
                flown = [
                    popping.popping(renderer, [way.camera_at(begin + k * FRAME_S) for k in range(count + 1)], FRAME_S)
                    for begin, count in starts
                ]
                session.row(
                    name, flight, size, error=max(f.p999_px for f in flown), error_unit="px p99.9",
                    target=at_most(1.0, "px"), p99_px=max(f.p99_px for f in flown),
                    worst_px=max(f.worst_px for f in flown), frames=sum(f.frames for f in flown),
                    moving_frames=float(np.mean([f.changed for f in flown])),
                )  # fmt: skip


def holes_in_the_disc(session: Session) -> None:
    """Background inside the planet's disc, over random cameras, from the first frame on."""
    planets = {"earth": session.runs(2000, 30), "moon": session.runs(300, 10), "asteroid": session.runs(300, 10)}
    for name in BACKENDS:
        for planet, count in planets.items():
            with session.renderer(planet, SMALL, "low", {"terrain.backend": name}) as renderer:
                found = holes.find_holes(renderer, count, np.random.default_rng(SEED))
            session.row(
                f"{name}, {planet}", size=SMALL, error=found.holes, error_unit="pixels", target=at_most(0),
                cameras=found.cameras, pixels=found.pixels, where="; ".join(found.where),
            )  # fmt: skip
