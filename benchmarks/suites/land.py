"""Suite land: what water has made of it: the shape of its network, where drops end, and what all that costs."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from ... import Planet, Terrain, TerrainSampler, view
from ...systems.terrain.drainage.climate import climate_params
from ...systems.terrain.drainage.solve import solve_streams
from ...systems.terrain.height import TerrainField, TerrainParams
from ..measure import queries
from ..measure.frames import time_frames
from ..measure.land import descend, network_shape
from ..scenes import earth, preset_scene
from ..session import Bench, Session
from ..target import Target, at_least, at_most
from ..timing import time_variants

Floats = NDArray[np.float64]
SEED = 20261126
GROUNDS: Mapping[str, tuple[float, float]] = {"plain": (0.0, 0.0), "gullies": (1.0, 0.0), "gullies, rivers": (1.0, 1.0)}
"""Terrain.erosion and Terrain.rivers by variant."""


def land_network(session: Session) -> None:
    """The preset earth's network, solved anew: every cell drains, no reach climbs, and its numbers are those of real
    ones."""
    scene = preset_scene("earth")
    terrain = scene.planet[Terrain]
    params = TerrainParams.from_component(terrain, scene.planet[Planet].radius_m)
    cells = session.runs(terrain.drainage_cells, 200_000)
    shape = network_shape(solve_streams(params, climate_params(terrain, True), cells), params)
    session.row("cells of land without a way to the sea", error=shape.undrained, target=at_most(0), cells=shape.cells)
    session.row("reaches that climb", error=shape.climbing, target=at_most(0))
    session.row("slope by area: concavity", error=shape.concavity, target=Target(0.4, 0.55))
    session.row("length by area: Hack's exponent", error=shape.hack, target=Target(0.5, 0.6))
    session.row("bifurcation, first order by second", error=shape.ratios[0], target=Target(3.0, 5.0),
                ratios=str(shape.ratios))  # fmt: skip


def land_descent(session: Session) -> None:
    """Drops on random land, down the final ground in steps of 25 m, filling pits of up to 3 m."""
    count = session.runs(3000, 300)
    for name, (erosion, rivers) in GROUNDS.items():
        scene = earth(erosion, rivers)
        sampler, field = TerrainSampler(scene), scene.planet.height_field()
        assert isinstance(field, TerrainField)
        found = descend(field, queries.land(sampler, count, np.random.default_rng(SEED)))
        session.row(
            name, error=100.0 * found.arrived, error_unit="%",
            target=at_least(90.0, "%") if rivers else None, sea=found.sea, water=found.water, floor=found.floor,
            pit=found.pit, lost=found.lost, median_way_m=found.median_way_m, places=found.places,
        )  # fmt: skip


def _banks(count: int) -> Floats:
    """Directions (N, 3) in the largest rivers of preset earth."""
    paths = np.concatenate([river.path for river in earth(1.0, 1.0).rivers(20)])
    return paths[np.random.default_rng(SEED).integers(len(paths), size=count)]


def land_cost(session: Session) -> None:
    """The same ground without, with gullies, with rivers too, in turns: heights, rays, frames."""
    samplers = {name: TerrainSampler(earth(*knobs)) for name, knobs in GROUNDS.items()}
    places = queries.land(samplers["plain"], 1000, np.random.default_rng(SEED))
    runs = {name: lambda s=sampler: s.height(places) for name, sampler in samplers.items()}
    for name, timing in time_variants(runs, session.runs(40, 10), 3).items():
        session.row(f"1000 heights, {name}", timing=timing)
    rivers, banks = samplers["gullies, rivers"], _banks(1000)
    runs = {"land": lambda: rivers.water(places), "rivers": lambda: rivers.water(banks)}
    for name, timing in time_variants(runs, session.runs(40, 10), 3).items():
        session.row(f"1000 places' water, {name}", timing=timing)
    asked = {
        name: queries.rays(sampler, "level", 2.0, (0.0, 0.0), 1e4, 200, np.random.default_rng(SEED))
        for name, sampler in samplers.items()
    }
    cast = {
        name: lambda s=sampler, a=asked[name]: s.raycast(a.origins_m, a.directions, a.reach_m)
        for name, sampler in samplers.items()
    }
    for name, timing in time_variants(cast, session.runs(10, 3), 1).items():
        session.row(f"200 level rays of 10 km from 2 m, {name}", timing=timing)
    for place in ("valley", "high", "orbit"):
        for name, knobs in GROUNDS.items():
            with session.renderer(earth(*knobs), (640, 360), "medium") as renderer:
                session.row(name, place, timing=time_frames(renderer, view(place), session.runs(20, 6)).turning)


BENCHES: Mapping[str, Bench] = {"network": land_network, "descent": land_descent, "cost": land_cost}
