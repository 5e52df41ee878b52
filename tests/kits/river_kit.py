"""A few rivers and lakes on any planet, for tests that do not need a solved network."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from planetfall.systems.terrain.height import TerrainParams, height
from planetfall.systems.terrain.rivers.falls import with_falls
from planetfall.systems.terrain.rivers.nodes import RiverNodes
from planetfall.systems.terrain.rivers.table import river_table

STEPS = 8


def walks(params: TerrainParams, count: int = 40, seed: int = 3) -> RiverNodes:
    """Rivers of eight lines each, from places on land, each ending in a lake; lengths scale with the planet."""
    rng = np.random.default_rng(seed)
    size = params.scale
    starts = rng.normal(size=(4000, 3))
    starts /= np.linalg.norm(starts, axis=1)[:, None]
    starts = starts[height(starts, params) > 300.0 * size][:count]
    directions, levels, to, lake = [], [], [], []
    for start in starts:
        east = np.cross(start, [0.0, 0.0, 1.0])
        east /= np.linalg.norm(east)
        place, level = start, float(height(start[None], params)[0])
        for step in range(STEPS):
            aside = rng.normal() * 5e3
            place = place + (east * 12e3 + np.cross(start, east) * aside) * (size / params.radius_m)
            place = place / np.linalg.norm(place)
            if step < STEPS - 1:
                level = max(min(level - 5.0 * size, float(height(place[None], params)[0]) - 30.0 * size), 0.0)
            directions.append(place)
            levels.append(level)
            to.append(len(directions) if step < STEPS - 1 else -1)
            lake.append(step >= STEPS - 2)
    wet = np.array(lake)

    def column(river: float, lakes: float) -> np.ndarray:
        return np.where(wet, lakes, river).astype(np.float32)

    return RiverNodes(
        direction=np.array(directions),
        to=np.array(to, dtype=np.int32),
        level_m=np.array(levels, dtype=np.float32),
        half_width_m=column(60.0, 3000.0) * np.float32(min(size, 1.0)),
        depth_m=column(4.0, 12.0) * np.float32(min(size, 1.0)),
        flat_m=column(600.0, 3500.0) * np.float32(size),
        reach_m=column(6000.0, 6500.0) * np.float32(size),
        lake=wet,
        discharge_m3_s=column(500.0, 500.0),
    )


def with_rivers(params: TerrainParams, count: int = 40, seed: int = 3) -> tuple[TerrainParams, RiverNodes]:
    """The same ground carved by `walks`, and these."""
    nodes = walks(params, count, seed)
    return replace(params, rivers=river_table(nodes, params.radius_m, params.seed)), nodes


def with_waterfalls(params: TerrainParams, count: int = 12, seed: int = 3) -> tuple[TerrainParams, RiverNodes]:
    """As `with_rivers`, of rivers that come down by 120 m on each line, in falls where `with_falls` puts some."""
    nodes = walks(params, count, seed)
    left = STEPS - 2 - np.arange(len(nodes)) % STEPS
    steep = nodes.level_m[STEPS - 1 :: STEPS].repeat(STEPS) + 120.0 * np.maximum(left, 0)
    nodes = with_falls(replace(nodes, level_m=steep.astype(np.float32)), params.radius_m)
    return replace(params, rivers=river_table(nodes, params.radius_m, params.seed)), nodes
