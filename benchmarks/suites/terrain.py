"""Suite terrain: how right the ground is, and what that costs."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np

from ... import Camera, Ocean, Planet, Renderer, Terrain, qualities, view
from ...camera.views import views
from ...engine.space import CameraState
from ...systems.terrain.height import TerrainParams
from ..measure import coverage, ground, motion, positions, positions_quadtree, relief, sea
from ..measure.frames import time_passes
from ..measure.ground_cost import VERTICES, height_runs
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import Target, at_least, at_most
from ..timing import Timing, time_variants
from . import terrain_backends
from .terrain_grid import GRID_BENCHES
from .terrain_icosphere import ICOSPHERE_BENCHES
from .terrain_queries import QUERY_BENCHES
from .terrain_selection import SELECTION_BENCHES
from .terrain_shadows import SHADOW_BENCHES

EARTH_M, GIANT_M = 6.371e6, 7e7
BENCH, FULL_HD = (640, 360), (1920, 1080)
AMPLITUDE_M = 9000.0
SEED = 20240601


def _rng() -> np.random.Generator:
    return np.random.default_rng(SEED)


def _positions(session: Session) -> None:
    """Undisplaced vertices against long double, radii 1 km to 7e7 m and altitudes 1 cm to 1e9 m."""
    rng = _rng()
    altitudes = (0.01, 1.0, 2.0, 100.0, 1e4, 2e6, 1e9) if session.small else (0.01, *(10.0**k for k in range(10)), 2.0)
    with positions.PositionProbe(session.gpu) as probe:
        for radius in (1e3, EARTH_M, GIANT_M):
            for altitude in sorted(altitudes):
                found = probe.measure(radius, altitude, rng)
                session.row(
                    f"radius {radius:g} m, altitude {altitude:g} m",
                    error=found.worst_px,
                    error_unit="px",
                    target=at_most(1e-3, "px") if altitude >= 1.0 else None,
                    f32_planet_coordinates_px=found.baseline_px,
                    not_finite=found.not_finite,
                    vertices=found.vertices,
                )
    for radius in (EARTH_M, GIANT_M):
        for backend, method in (("quadtree", "ours"), ("quadtree", "paper"), ("icosphere", "ours")):
            if session.extent != "quick" or (radius, method) == (EARTH_M, "ours"):
                _tile_positions(session, radius, backend, method)


def _tile_positions(session: Session, radius: float, backend: str, method: str) -> None:
    """Vertices of tiles as drawn; those of the quadtree's article beside them, against its own formula."""
    scene = positions_quadtree.smooth(preset_scene("earth"))
    scene.planet[Planet].radius_m = radius
    overrides = {**positions_quadtree.OVERRIDES, "terrain.backend": backend, "terrain.method": method}
    with session.renderer(scene, positions_quadtree.SIZE, "medium", overrides) as renderer:
        worst: dict[int, float] = {}
        for altitude in (0.5, 1e4, 3e7) if session.small else (0.5, 100.0, 1e4, 1e6, 3e7):
            camera = Camera.at(47.3, 11.2, altitude, pitch_deg=-40.0)
            for level, px in positions_quadtree.worst_px_by_level(renderer, camera).items():
                worst[level] = max(worst.get(level, 0.0), px)
        session.row(
            f"radius {radius:g} m, {backend}, {method}: levels {min(worst)} to {max(worst)}",
            error=max(worst.values()), error_unit="px", target=at_most(1e-3, "px") if method == "ours" else None,
            worst_level=max(worst, key=worst.__getitem__),
        )  # fmt: skip


def _coverage(session: Session) -> None:
    """z_s and the covered arc; and that a proxy's grid holds what all its cameras see."""
    rng = _rng()
    arc = coverage.arc_errors(rng, session.runs(20_000, 2000))
    session.row("covered arc", error=arc.worst_arc_r, error_unit="r", target=at_most(1e-9, "r"), cases=arc.cases,
                not_finite=arc.not_finite)  # fmt: skip
    session.row("too short by", error=arc.worst_short_r, error_unit="r", target=at_most(1e-9, "r"), cases=arc.cases)
    missing, outside, points, cases = -np.inf, 0, 0, session.runs(400, 40)
    for _ in range(cases):
        radius = 10.0 ** rng.uniform(3.0, np.log10(GIANT_M))
        highest = 0.1 * radius * 10.0 ** rng.uniform(-6.0, 0.0)
        lowest = -0.1 * radius * 10.0 ** rng.uniform(-6.0, 0.0)
        found = coverage.proxy_covers(radius, 10.0 ** rng.uniform(-2.0, 9.0), highest, lowest, rng)
        missing, outside, points = max(missing, found.worst_missing_r), outside + found.outside, points + found.points
    session.row("seen beyond the proxy's arc", error=missing, error_unit="r", target=at_most(1e-9, "r"), cases=cases)
    session.row("peaks at the limit outside the grid", error=outside, target=at_most(0), cases=points)


def _heights(session: Session) -> None:
    """The GPU's heights against the float64 twin."""
    rng = _rng()
    with session.renderer("earth", BENCH, "high") as renderer:
        for name in _known(renderer, ("ground", "near", "valley", "coast", "high", "orbit", "space")):
            found = ground.vertex_heights(renderer, view(name), rng, session.runs(40_000, 8000))
            if found.near_vertices:
                session.row("all layers, within 1 km", name, error=found.near_m * 1e3, error_unit="mm",
                            target=at_most(1.0, "mm"), vertices_as_drawn=found.drawn_near_m * 1e3,
                            vertices=found.near_vertices)  # fmt: skip
            session.row(
                "all layers, anywhere", name, error=found.by_distance, error_unit="of the distance",
                target=at_most(1e-6, "of the distance"), worst_m=found.anywhere_m,
                vertices_as_drawn=found.drawn_m / AMPLITUDE_M, vertices=found.vertices,
            )  # fmt: skip


def _normals(session: Session) -> None:
    """Vertex normals against the float64 surface at the same footprint, within 1 km; finite differences beside them."""
    rng = _rng()
    with session.renderer("earth", BENCH, "high") as renderer:
        for name in _known(renderer, ("ground", "near", "valley")):
            both = ground.vertex_normals_error(renderer, view(name), rng, session.runs(40_000, 8000))
            for variant, found in zip(("ours", "f32 finite differences"), both, strict=True):
                session.row(
                    variant, name, error=found.p99_deg, error_unit="degrees p99",
                    target=at_most(0.1, "degrees") if variant == "ours" else None,
                    median_deg=found.median_deg, worst_deg=found.worst_deg, vertices=found.vertices,
                )  # fmt: skip


def _jitter(session: Session) -> None:
    """A camera 2 m above ground in 1 mm steps and 0.01 degree turns: fixed points against their true projection."""
    rng = _rng()
    steps = session.runs(1000, 200)
    for radius in (EARTH_M, GIANT_M):
        with _earth(session, radius, (64, 36), "high") as renderer:
            camera = _standing(renderer)
            for what, cameras in (
                ("1 mm steps", motion.along(camera, 1e-3, steps)),
                ("0.01 degree turns", motion.turned(camera, 0.01, steps // 2)),
            ):
                found = motion.jitter(renderer, cameras, rng)
                session.row(f"radius {radius:g} m, {what}", error=found.worst_px, error_unit="px",
                            target=at_most(0.02, "px"), p99_px=found.p99_px, steps=found.steps, points=found.points,
                            snaps=found.snaps)  # fmt: skip


def _proxy(session: Session) -> None:
    """What a held proxy keeps and what a snap changes."""
    rng = _rng()
    for radius in (EARTH_M, GIANT_M):
        with _earth(session, radius, BENCH if session.small else FULL_HD, "high") as renderer:
            camera = _standing(renderer)
            held = motion.hold(renderer, Camera(camera.position_m, camera.forward, camera.up))
            session.row(f"radius {radius:g} m, held: vertices that changed bits", error=0 if held.identical else 1,
                        target=at_most(0), frames=held.frames, ran_again=", ".join(held.ran))  # fmt: skip
            snapped = motion.snap(renderer, motion.along(camera, 1e-2, 400), rng)
            if snapped is None:
                raise RuntimeError("the proxy did not snap within 4 m at 2 m altitude")
            session.row(
                f"radius {radius:g} m, snap at 2 m: vertices within 1 km that the old grid had",
                error=snapped.shared, target=at_least(0.95), vertices=snapped.vertices,
                of_those_in_triangles=snapped.drawn_shared,
                on_the_old_lattice=snapped.on_lattice, snap_m=snapped.distance_m,
            )  # fmt: skip
            # A cell of a grid, as Michelic 2018 has it, is what lies between four vertices; ours come in patches of 16.
            session.row(f"radius {radius:g} m, finest grid cell at 2 m", error=snapped.finest_spacing_m, error_unit="m",
                        target=at_most(1.0, "m"), patch_m=snapped.finest_cell_m)  # fmt: skip
            session.row(f"radius {radius:g} m, snap at 2 m: ground moves in all by", size=renderer.size,
                        error=snapped.worst_px, error_unit="px", target=at_most(1.0, "px"),
                        p99_px=snapped.p99_px)  # fmt: skip


def _edges(session: Session) -> None:
    """Lengths of triangle edges on screen."""
    for quality in ("high",) if session.small else ("medium", "high"):
        with session.renderer("earth", FULL_HD, quality) as renderer:
            for name in ("ground", "high", "orbit"):
                found = ground.edge_lengths(renderer, view(name))
                extra = {"p99_px": found.p99_px, "worst_px": found.worst_px, "vertices": found.vertices_drawn,
                         "triangles": found.triangles_drawn, "edges_seen": found.edges,
                         "median_with_hidden_px": found.all_median_px}  # fmt: skip
                named: dict[str, Any] = {"view": name, "size": FULL_HD}
                session.row(f"{quality}: median", error=found.median_px, error_unit="px",
                            target=Target(4.0, 10.0, "px"), **named, **extra)  # fmt: skip
                session.row(f"{quality}: p99", error=found.p99_px, error_unit="px", target=at_most(20.0, "px"), **named)
                session.row(f"{quality}: vertices drawn", error=found.vertices_drawn, target=at_most(200_000), **named)


def _error(session: Session) -> None:
    """Run time against error, over qualities: the drawn ground against TerrainSampler in pixels."""
    rng = _rng()
    sizes = (BENCH,) if session.small else (BENCH, FULL_HD)
    for quality in ("medium", "high") if session.small else [q for q in qualities() if q not in ("paper", "reference")]:
        for size in sizes:
            with session.renderer("earth", size, quality) as renderer:
                for name in _views(session, renderer):
                    found = ground.picture_error(renderer, view(name), rng, session.runs(20_000, 4000))
                    if found is None:
                        continue
                    timing = None
                    if size == BENCH or name in ("near", "high", "orbit"):
                        timing = _frame_time(session, renderer, view(name))
                    session.row(
                        quality, name, size, timing, error=found.p99_px, error_unit="px p99",
                        target=at_most(1.0, "px") if quality == "high" else None,
                        median_px=found.median_px, worst_px=found.worst_px, p99_m=found.p99_m, pixels=found.pixels,
                    )  # fmt: skip


def _sea(session: Session) -> None:
    """The drawn sea against float64: where its surface lies, and on which side of coasts and limb each pixel is.
    Without waves: the true sea is the sphere of its level."""
    rng, scene = _rng(), preset_scene("earth")
    scene.planet[Ocean].wind_speed_m_s = scene.planet[Ocean].swell_height_m = 0.0
    with session.renderer(scene, BENCH, "high") as renderer:
        for name in _known(renderer, ("space", "orbit", "high", "coast", "beach", "sea", "limb", "under")):
            found = sea.sea_error(renderer, view(name), rng, session.runs(3000, 1000), 500 if session.small else None)
            if found.sea_pixels:
                session.row("surface", name, BENCH, error=found.p99_px, error_unit="px p99",
                            target=at_most(1.0, "px"), worst_px=found.worst_px, distance_p99=found.p99_distance,
                            pixels=found.sea_pixels)  # fmt: skip
            for variant, classes, most in (("coasts and limb", found.edge, 1.0), ("whole picture", found.sampled, 0.1)):
                session.row(f"{variant}: more than a pixel off", name, BENCH, error=100.0 * classes.wrong_beyond,
                            error_unit="%", target=at_most(most, "%"), other_than_true=100.0 * classes.wrong,
                            pixels=classes.pixels, worst_px=found.worst_off_px, lost=found.lost)  # fmt: skip


def _frame_time(session: Session, renderer: Renderer, camera: Camera) -> Any:
    """Frames whose camera turns a little each time: culled and drawn anew, proxy held."""
    state = renderer.camera_state(camera)
    cameras = motion.turned(state, 0.01, 4)
    target = renderer.ctx.simple_framebuffer(renderer.size)

    def frame() -> None:
        cameras.append(cameras.pop(0))
        renderer.render_to(target, cameras[0])

    timing = time_variants({"": frame}, session.runs(9, 4), 2, renderer.ctx.finish)[""]
    renderer.gpu.leave(target)
    target.release()
    return timing


def _relief(session: Session) -> None:
    """How rough the land is at each scale, beside measurements; what the planet is made of."""
    scene = preset_scene("earth")
    measured = relief.MEASURED
    found = relief.roughness(scene, 60_000)
    for distance, ours in found.items():
        real = measured.get(distance)
        session.row(
            f"rms height difference over {distance:g} m", error=ours, error_unit="m",
            target=None if real is None else Target(0.5 * real, 2.0 * real, "m"), measured_m=real,
            source=relief.SOURCE if real is not None else "",
        )  # fmt: skip
    most = relief.UNRELATED_M
    session.row("rms height difference of land anywhere", error=relief.unrelated(scene, session.runs(40_000, 10_000)),
                error_unit="m", target=Target(0.5 * most, 2.0 * most, "m"), measured_m=most,
                source=relief.UNRELATED_SOURCE)  # fmt: skip
    whole = relief.composition(scene, session.runs(200_000, 40_000))
    session.row("land", error=100.0 * whole.land_share, error_unit="%", target=Target(25.0, 40.0, "%"))
    session.row("highest peak found", error=whole.highest_m, error_unit="m", target=at_least(6000.0, "m"))
    session.row("lowest seabed found", error=whole.lowest_m, error_unit="m", target=at_most(-4000.0, "m"))


def _sources(session: Session) -> None:
    """What craters and maps add to a vertex, in one run: the moon as it is, and without them."""
    scene = preset_scene("moon")
    whole = TerrainParams.from_component(scene.planet[Terrain], scene.planet[Planet].radius_m)
    worlds = {
        "noise alone": replace(whole, craters=0.0, height_map=None),
        "with craters": replace(whole, height_map=None),
        "with a map": replace(whole, craters=0.0),
        "with both": whole,
    }
    with session.renderer("moon", (64, 36), "low") as renderer:
        for spacing_m in (1.0, 100.0, 15e3):
            with height_runs(renderer.gpu, worlds, spacing_m) as runs:
                times = time_variants(runs, session.runs(15, 5), 3)
            for name, timing in times.items():
                session.row(
                    f"{VERTICES} vertices, {name}", f"{spacing_m:g} m apart", timing=timing,
                    ns_per_vertex=1e6 * timing.ms / VERTICES, times=timing.ms / times["noise alone"].ms,
                )  # fmt: skip

    _source_shading(session)


def _source_shading(session: Session) -> None:
    """The pass that shades the ground, with craters and map, and without; the second's time is the unit."""
    bare = preset_scene("moon")
    bare.planet[Terrain].craters, bare.planet[Terrain].height_map = 0.0, ""
    names = ("without sources", "with both")
    found: dict[tuple[str, str], list[float]] = {}
    session.release()
    with Renderer(bare, (640, 360), "medium") as plain, Renderer(preset_scene("moon"), (640, 360), "medium") as whole:
        for _ in range(session.runs(8, 4)):  # in turns
            for seen in ("near", "orbit"):
                for name, renderer in zip(names, (plain, whole), strict=True):
                    passes = time_passes(renderer, view(seen).camera, 4)
                    found.setdefault((seen, name), []).append(passes["terrain.shade"].low_ms)
    times = {key: Timing.of(samples) for key, samples in found.items()}
    for (seen, name), timing in times.items():
        session.row(
            f"shading, {name}", seen, timing=timing, times=timing.low_ms / times[seen, names[0]].low_ms
        )  # fmt: skip


def _sampler(session: Session) -> None:
    """TerrainSampler: the CPU's heights."""
    from ... import TerrainSampler

    sampler = TerrainSampler(preset_scene("earth"))
    rng = _rng()
    many = rng.normal(size=(1000, 3))
    many /= np.linalg.norm(many, axis=1, keepdims=True)
    one = many[:1].copy()
    times = time_variants({"1000 points": lambda: sampler.height(many)}, session.runs(60, 20), 5)
    times |= time_variants({"1 point": lambda: sampler.height(one)}, session.runs(60, 20), 5, inner=20)
    for name, limit in (("1000 points", 2.0), ("1 point", 0.1)):
        session.row(f"height, {name}, 16 layers", timing=times[name], target=at_most(limit, "ms"), target_on="ms")


def _known(renderer: Renderer, names: tuple[str, ...]) -> list[str]:
    there = views(renderer.scene.planet)
    return [name for name in names if name in there]


def _views(session: Session, renderer: Renderer) -> list[str]:
    """All views of the planet in a full run, else those that tables print."""
    return _known(renderer, ("near", "high", "orbit")) if session.small else views(renderer.scene.planet)


@contextmanager
def _earth(session: Session, radius_m: float, size: tuple[int, int], quality: str) -> Iterator[Renderer]:
    scene = preset_scene("earth")
    scene.planet[Planet].radius_m = radius_m
    with session.renderer(scene, size, quality) as renderer:
        yield renderer


def _standing(renderer: Renderer) -> CameraState:
    """2 m above land, looking a little down: at the view "ground", or the nearest land on other radii."""
    rng = np.random.default_rng(1)
    field, place = renderer.scene.planet.height_field(), renderer.camera_state(view("ground"))
    tries = place.direction + np.concatenate(
        [[np.zeros(3)], rng.normal(size=(400, 3)) * np.geomspace(1e-4, 1, 400)[:, None]]
    )
    tries /= np.linalg.norm(tries, axis=1, keepdims=True)
    assert field is not None
    heights = field.height(tries)
    land = int(np.argmax(heights > 20.0))
    zenith = tries[land]
    level = np.cross(zenith, np.cross(place.forward, zenith))
    level /= np.linalg.norm(level)
    position = zenith * (renderer.scene.planet.radius_m + float(heights[land]) + 2.0)
    return renderer.camera_state(Camera(position, level * 0.97 - zenith * 0.24, zenith))


BENCHES: Mapping[str, Bench] = {
    "positions": _positions,
    "coverage": _coverage,
    "heights": _heights,
    "normals": _normals,
    "jitter": _jitter,
    "proxy": _proxy,
    "edges": _edges,
    "error": _error,
    "sea": _sea,
    "relief": _relief,
    "sampler": _sampler,
    "height sources": _sources,
    **QUERY_BENCHES,
    **GRID_BENCHES,
    **SELECTION_BENCHES,
    "backends": terrain_backends.backends,
    "popping": terrain_backends.popping_in_flight,
    "holes": terrain_backends.holes_in_the_disc,
    **ICOSPHERE_BENCHES,
    **SHADOW_BENCHES,
}
