"""Bench terrain.queries: what games ask of the ground on the CPU, its time and how right it is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ... import TerrainSampler
from ..measure import queries
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_most
from ..timing import time_variants

SEED = 20260401


def terrain_queries(session: Session) -> None:
    """Heights, rays, spheres, patches of earth at 16 layers, and rays over craters. Rays against a fine march, spheres
    against dense grids."""
    sampler = TerrainSampler(preset_scene("earth"))
    rng = np.random.default_rng(SEED)
    places = queries.land(sampler, 1000, rng)
    timing = time_variants({"": lambda: sampler.height(places)}, session.runs(40, 10), 3)[""]
    session.row("1000 heights", timing=timing, target=at_most(2.0, "ms"), target_on="ms")
    for name, above_m, pitch_deg, reach_m, limit_ms in queries.SETS:
        asked = queries.rays(sampler, name, above_m, pitch_deg, reach_m, 1000, rng)
        _ray_row(session, sampler, asked, limit_ms)
    for planet, sets in (("moon", queries.SETS), ("mars", queries.SETS), ("asteroid", queries.SMALL_SETS)):
        other = TerrainSampler(preset_scene(planet))
        for name, above_m, pitch_deg, reach_m, limit_ms in sets:
            asked = queries.rays(other, f"{planet}, {name}", above_m, pitch_deg, reach_m, 1000, rng)
            _ray_row(session, other, asked, limit_ms, share=0.25)
    for radius in (0.5, 1.0, 5.0):
        _sphere_row(session, sampler, places[:200], radius, rng)
    start = places[:200] * (sampler.radius_m + sampler.height(places[:200]) + 20.0)[:, None]
    end = start - 40.0 * places[:200]
    timing = time_variants({"": lambda: sampler.sweep(start, end, 1.0)}, session.runs(10, 3), 1)[""]
    session.row("200 sweeps of a ball of 1 m over 40 m", timing=timing)
    for spacing in (0.6, 10.0):
        timing = time_variants(
            {"": lambda s=spacing: sampler.patch(places[0], 64.0 * s, s, aligned=True, normals=False)},
            session.runs(20, 5), 2,
        )[""]  # fmt: skip
        session.row(f"patch of 65 x 65 points, {spacing:g} m", timing=timing)


def _ray_row(
    session: Session, sampler: TerrainSampler, asked: queries.Rays, limit_ms: float, share: float = 1.0
) -> None:
    def cast() -> None:
        sampler.raycast(asked.origins_m, asked.directions, asked.reach_m)

    timing = time_variants({"": cast}, session.runs(7, 3), 1)[""]
    hit, distance = sampler.raycast(asked.origins_m, asked.directions, asked.reach_m)
    few = round(share * (session.runs(200, 20) if asked.reach_m > 1e4 else session.runs(1000, 100)))
    part = queries.Rays(asked.name, asked.origins_m[:few], asked.directions[:few], asked.reach_m)
    step = 10.0 if asked.reach_m > 1e4 else asked.reach_m * 1e-4
    late, looked = queries.earlier_ground(sampler, part, hit[:few], distance[:few], step)
    what = f"1000 rays to {asked.reach_m / 1e3:g} km, {asked.name}"
    session.row(what, timing=timing, target=at_most(limit_ms, "ms"), target_on="ms",
                cpu_ms=queries.cpu_ms(cast), numpy_cpu_ms=queries.numpy_cpu_ms(cast),
                hit_share=float(hit.mean()))  # fmt: skip
    session.row(f"{what}: ground before the hit", error=100.0 * float(late.max()), error_unit="cm",
                target=at_most(1.0, "cm"), late_rays=int((late > 0.01).sum()), rays=few, march_step_m=step,
                points=looked)  # fmt: skip
    session.row(f"{what}: hit off the ground", error=1e6 * queries.residual_m(sampler, asked, hit, distance),
                error_unit="um", target=at_most(1e4, "um"))  # fmt: skip


def _sphere_row(
    session: Session, sampler: TerrainSampler, places: np.ndarray, radius: float, rng: np.random.Generator
) -> None:
    ground = sampler.radius_m + sampler.height(places)
    centers = places * (ground + radius * rng.uniform(0.3, 1.1, len(places)))[:, None]

    def touch() -> None:
        sampler.sphere_contact(centers, radius)

    timing = time_variants({"": touch}, session.runs(20, 5), 2)[""]
    few = session.runs(60, 15)
    depth = sampler.sphere_contact(centers, radius)[0][:few]
    true = radius - queries.nearest_m(sampler, centers[:few], radius)
    session.row(f"200 spheres of {radius:g} m", timing=timing, target=at_most(5.0, "ms"), target_on="ms",
                cpu_ms=queries.cpu_ms(touch, 15), numpy_cpu_ms=queries.numpy_cpu_ms(touch, 15))  # fmt: skip
    # The grid's nearest point is at most a spacing aside of the true one, which makes it lie that much farther away.
    grid_m = (3.0 * radius / 240.0) ** 2 / radius
    session.row(f"200 spheres of {radius:g} m: depth", error=1e3 * float(np.abs(depth - true).max()), error_unit="mm",
                target=at_most(1.0 + 1e3 * grid_m, "mm"), spheres=few)  # fmt: skip


QUERY_BENCHES: Mapping[str, Bench] = {"queries": terrain_queries}
