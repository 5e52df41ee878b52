"""Benches of the icosphere: beside the other backends, and what its source's method loses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ... import Ocean, view
from ..measure import frames, ground, holes, icosphere_holes, icosphere_paper
from ..measure.positions_icosphere import IcospherePositions, special_places
from ..measure.sides import interleaved, side_by_side, turning
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_most

SEED = 20240601
VIEWS = ("near", "high", "orbit")
SIZE = (640, 360)
METHODS: Mapping[str, Mapping[str, Any]] = {
    "grid": {"terrain.backend": "grid"},
    "quadtree": {"terrain.backend": "quadtree"},
    "icosphere": {"terrain.backend": "icosphere"},
    "icosphere, paper": {"terrain.backend": "icosphere", "terrain.method": "paper"},
}


def _methods(session: Session) -> None:
    """Frames of a turning camera, triangles and error: the icosphere, ours and as printed, beside the others."""
    rng = np.random.default_rng(SEED)
    with side_by_side(session, METHODS, lambda: preset_scene("earth"), SIZE) as made:
        for place in VIEWS:
            for renderer in made.values():
                renderer.settle(view(place))
            times = interleaved(made, place, session.runs(15, 4), turning)
            for name, renderer in made.items():
                renderer.settle(view(place))
                found = ground.picture_error(renderer, view(place), rng, session.runs(20_000, 3000))
                system: Any = renderer.system("terrain")
                counts = system.statistics()
                session.row(
                    name, place, SIZE, times[name], error=None if found is None else found.p99_px,
                    error_unit="px p99", triangles=counts["triangles"], vertices=counts["vertices"],
                    tiles=counts["cells"], tiles_selected=counts["cells_selected"],
                )  # fmt: skip


def _vertices(session: Session) -> None:
    """Vertices against extended precision on each level; how many a second are assembled, and drawn."""
    rng = np.random.default_rng(SEED)
    with IcospherePositions(session.gpu) as probe:
        for radius in (6.371e6, 7e7):
            places = [*special_places(), *rng.normal(size=(session.runs(12, 3), 3))]
            worst = [max(probe.worst_px(radius, level, place) for place in places) for level in range(25)]
            session.row(f"radius {radius:g} m, levels 0 to 24", error=max(worst), error_unit="px",
                        target=at_most(1e-3, "px"), worst_level=int(np.argmax(worst)), places=len(places))  # fmt: skip
    # The source draws 60 million vertices a frame on its GPU (GTX 1080), with basic shading: heights from a texture.
    for name in ("icosphere", "icosphere, paper"):
        with session.renderer("earth", SIZE, "medium", dict(METHODS[name])) as renderer:
            renderer.settle(view("near"))
            passes = frames.time_passes(renderer, view("near"), session.runs(9, 3))
            system: Any = renderer.system("terrain")
            counts = system.statistics()
            made = counts["cells_selected"] * system.backend.shape.vertices
            assembling = passes.get("terrain.vertices (snap)") or passes["terrain.vertices"]
            session.row(f"{name}: all vertices anew", "near", SIZE, assembling, vertices=made,
                        million_vertices_a_second=made / assembling.ms / 1e3)  # fmt: skip
            drawing = passes["terrain.gbuffer"]
            session.row(f"{name}: drawn", "near", SIZE, drawing, vertices=counts["vertices"],
                        million_vertices_a_second=counts["vertices"] / drawing.ms / 1e3)  # fmt: skip


def _paper(session: Session) -> None:
    """What the printed method loses: seen triangles that culling drops, cracks, vertices that levels don't share."""
    spheres = {"the lowest ground's sphere": None, "a sphere with ground below it": 0.0}
    for name, sphere_m in spheres.items():
        rng = np.random.default_rng(SEED)
        found = icosphere_paper.printed_culling(rng, session.runs(12_000, 2000), sphere_m=sphere_m)
        session.row(f"printed: seen triangles dropped, {name}", error=100.0 * found.visible_dropped / found.visible,
                    error_unit="%", seen=found.visible, unseen_dropped=found.invisible_dropped / found.invisible,
                    unseen=found.invisible)  # fmt: skip
    _holes(session)
    for level in (2, 4, 8, 12):
        edge, worst = icosphere_paper.gap_between_levels_m(6.371e6, level)
        session.row(f"printed: levels {level} and {level + 1} apart", error=worst, error_unit="m", along_an_edge_m=edge)


def _holes(session: Session) -> None:
    """Edges whose two sides differ, inside the icosahedron's triangles and between them; holes by what makes them."""
    scene, size = preset_scene("earth"), (160, 90)
    scene.planet.remove(Ocean)  # it would lie behind the holes
    printed, ours = METHODS["icosphere, paper"], METHODS["icosphere"]
    rng = np.random.default_rng(SEED)
    with (
        session.renderer(scene, size, "low", dict(printed)) as made,
        session.renderer(scene, size, "low", dict(ours)) as truth,
    ):
        cameras = [*map(view, VIEWS), *(holes.random_camera(made, rng) for _ in range(session.runs(200, 12)))]
        edges = [icosphere_holes.borders(made, camera) for camera in cameras]
        pixels = [icosphere_holes.hole_pixels(made, truth, camera) for camera in cameras]
    session.row("printed: open edges inside base triangles", size=size, error=sum(e.inner_open for e in edges),
                error_unit="edges", target=at_most(0), edges=sum(e.inner for e in edges),
                cameras=len(cameras))  # fmt: skip
    session.row("printed: open edges between base triangles", size=size, error=max(e.base_px for e in edges),
                error_unit="px apart", open=sum(e.base_open for e in edges),
                edges=sum(e.base for e in edges))  # fmt: skip
    session.row("printed: holes in pictures", size=size, error=sum(p.cracks + p.dropped for p in pixels),
                error_unit="pixels", cracks=sum(p.cracks for p in pixels), dropped=sum(p.dropped for p in pixels),
                cameras=len(cameras))  # fmt: skip


ICOSPHERE_BENCHES: Mapping[str, Bench] = {
    "icosphere": _methods,
    "icosphere_vertices": _vertices,
    "icosphere_paper": _paper,
}
