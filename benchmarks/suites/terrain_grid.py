"""Benches of the projected grid: the source's method against ours, and what a snap moves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ... import Camera, Renderer, path, view
from ..measure import grid_kept, ground, paper_grid, snaps
from ..measure.paper_relief import relief_m
from ..measure.sides import interleaved, side_by_side, snapping, turning
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_least, at_most

SEED = 20240601
VIEWS = ("near", "high", "orbit")
SIZE, POPS_SIZE = (640, 360), (320, 180)
PAPER = {"terrain.method": "paper"}
METHODS: Mapping[str, Mapping[str, Any]] = {
    "ours": {},
    "paper 50^2": {**PAPER, "terrain.paper_grid": 50},
    "paper 100^2": PAPER,
    "paper 200^2": {**PAPER, "terrain.paper_grid": 200},
    "paper 100^2, 10 layers": {**PAPER, "terrain.paper_layers": 10},
}


def _methods(session: Session) -> None:
    """Run time, triangles and error of both methods: against the ground that each draws, and against the scene's."""
    rng = np.random.default_rng(SEED)
    names = ["ours", "paper 100^2"] if session.small else list(METHODS)
    with side_by_side(session, {name: METHODS[name] for name in names}, lambda: preset_scene("earth")) as renderers:
        for place in VIEWS:
            for renderer in renderers.values():
                renderer.settle(view(place))
            held = interleaved(renderers, place, session.runs(15, 4), turning)
            anew = interleaved(renderers, place, session.runs(6, 2), snapping)
            for name, renderer in renderers.items():
                renderer.settle(view(place))
                few = session.runs(20_000, 3000)
                own = renderer.world.resource("height_field")
                found = ground.picture_error(renderer, view(place), rng, few, own)
                scene = ground.picture_error(renderer, view(place), rng, few)
                if found is None or scene is None:
                    continue
                state = renderer.camera_state(view(place))
                radius_m = renderer.scene.planet.radius_m
                scenes: Any = renderer.scene.planet.height_field()
                relief = [relief_m(field, state.direction, radius_m) for field in (own, scenes)]
                stats: Any = renderer.system("terrain")
                counts = stats.statistics()
                session.row(
                    name, place, SIZE, held[name], error=found.p99_px, error_unit="px p99",
                    scene_p99_px=scene.p99_px, worst_px=found.worst_px, snap_ms=anew[name].ms,
                    relief_share=relief[0] / relief[1], triangles=counts["triangles"], vertices=counts["vertices"],
                )  # fmt: skip


def _vertices(session: Session) -> None:
    """The source's vertices, from an anchor, against the float64 twin; and what its frustum test drops."""
    rng = np.random.default_rng(SEED)
    with session.renderer("earth", SIZE, "medium", dict(PAPER)) as renderer:
        for place in ("ground", *VIEWS, "space", "pole"):
            found = paper_grid.vertex_error(renderer, view(place), rng, session.runs(40_000, 4000))
            # Heights round to 0.2 mm, which is more than that at a vertex a metre from the eye.
            target = at_most({"ground": 0.1, "near": 3e-3}.get(place, 1e-3), "px")
            session.row("paper: vertices", place, error=found.worst_px, error_unit="px at 1080 rows", target=target,
                        p99_px=found.p99_px, worst_m=found.worst_m, vertices=found.vertices)  # fmt: skip
            culled = paper_grid.culling(renderer, view(place), session.runs(17, 9))
            session.row("paper: patches dropped though seen", place, error=culled.dropped_seen, target=at_most(0),
                        patches=culled.patches, drawn=culled.drawn, drawn_unseen=culled.kept_unseen)  # fmt: skip


def _snaps(session: Session) -> None:
    """What the ground does on screen at snaps: the same camera before and after, in level flight and sinking."""
    count = session.runs(6, 2)
    for name, overrides in (
        ("ours", {}),
        ("ours, no fade", {"terrain.fade_s": 0.0}),
        ("paper 100^2", PAPER),
        ("paper 100^2, 10 layers", METHODS["paper 100^2, 10 layers"]),
    ):
        with session.renderer("earth", POPS_SIZE, "medium", dict(overrides)) as renderer:
            for place in ("ground", *VIEWS):
                state = renderer.camera_state(view(place))
                cell_m = _clearance_m(renderer, state.position_m)
                found = snaps.pops(renderer, list(snaps.forward_path(state, 0.03 * cell_m, 60)), count)
                moved = snaps.Pops.quantile
                share = float(np.median(found.unpaired)) if name == "ours" and found.unpaired else None
                session.row(
                    f"{name}: the ground moves in a frame", place, POPS_SIZE, error=max(found.a_frame, default=0.0),
                    error_unit="px p99.9", target=at_most(1.0, "px") if name == "ours" else None,
                    at_once_px=moved(found.at_once, 0.999), at_once_median_px=moved(found.at_once, 0.5),
                    in_all_px=moved(found.in_all, 0.999), worst_px=moved(found.at_once, 1.0), snaps=found.snaps,
                    moving_share=share,
                )  # fmt: skip


def _descent(session: Session) -> None:
    """Vertices that the old grid had too never move: all snaps of the standard descent."""
    with session.renderer("earth", POPS_SIZE, "medium") as renderer:
        flight = path("descent", renderer.scene)
        cameras = [flight.camera_at(t) for t in flight.times_s(session.runs(600, 240))]
        found = snaps.shared_vertices_move(renderer, cameras)
        session.row("ours: vertices that both grids have move by", "descent", POPS_SIZE, error=found.worst_px,
                    error_unit="px", target=at_most(0.05, "px"), p999_px=found.p999_px, snaps=found.snaps,
                    shared=found.shared, vertices=found.vertices)  # fmt: skip
        session.row("ours: drawn vertices that the old grid had", "descent", POPS_SIZE, error=found.shared,
                    target=at_least(0.95), snaps=found.snaps)  # fmt: skip
    _kept(session)


def _kept(session: Session) -> None:
    """Level flight: the share of vertices after a snap that lie within a tenth of their distance of one before it, of
    the printed grid when it moves by a cell and when its patches are cut anew; the most of the grid's points that any
    move keeps; and ours beside, whose vertices are at the same place or not, in steps of a third of the altitude."""
    flights = {"100 m": (100.0, 0.8), "10 km": (1e4, 0.65), "2000 km": (2e6, 0.3)}
    for name, (altitude_m, least) in flights.items():
        with session.renderer("earth", POPS_SIZE, "medium", dict(PAPER)) as renderer:
            sight = grid_kept.Sight(altitude_m)
            flight = grid_kept.level_cameras(renderer, altitude_m, 0.1 * sight.cell_m, 10 * session.runs(8, 4))
            moves, cuts = grid_kept.flown(renderer, flight)
        with session.renderer("earth", POPS_SIZE, "medium") as renderer:
            flight = grid_kept.level_cameras(renderer, altitude_m, altitude_m / 3.0, session.runs(40, 24))
            ours = snaps.shared_vertices_move(renderer, [Camera(c.position_m, c.forward, c.up) for c in flight])
        most, step = grid_kept.most_points(sight)
        session.row(f"paper: vertices found again, {name}", "level", POPS_SIZE,
                    error=min(k.vertices for k in moves), target=at_least(least), moves=len(moves),
                    points=min(k.points for k in moves), points_at_most=most, best_step_cells=max(step[:2]),
                    cut_anew=float(np.median([k.vertices for k in cuts])) if cuts else 1.0, cuts=len(cuts),
                    ours=ours.shared, snaps_ours=ours.snaps)  # fmt: skip


def _clearance_m(renderer: Renderer, position_m: Any) -> float:
    renderer.render(view("near"))
    field = renderer.world.resource("height_field")
    distance = float(np.linalg.norm(position_m))
    return max(distance - renderer.scene.planet.radius_m - float(field.height(position_m[None] / distance)[0]), 0.5)


GRID_BENCHES: Mapping[str, Bench] = {
    "grid_methods": _methods,
    "grid_vertices": _vertices,
    "grid_snaps": _snaps,
    "grid_descent": _descent,
}
