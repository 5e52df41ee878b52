"""Tables of rivers on disk: the same as those that were made, for what they depend on alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from planetfall.components import Terrain
from planetfall.engine.table_cache import TableCache
from planetfall.systems.terrain.drainage.climate import climate_params
from planetfall.systems.terrain.height_params import TerrainParams
from planetfall.systems.terrain.rivers.kept import keep_table, kept_table
from planetfall.systems.terrain.rivers.nodes import rivers_of_ground
from planetfall.systems.terrain.rivers.source import RiverKey
from planetfall.systems.terrain.rivers.table import river_table
from planetfall.systems.terrain.rivers.texture import river_texels

CELLS = 6000
ARRAYS = ("place", "to", "values", "keys", "begin", "lines")


def test_a_table_comes_back_as_it_was(tmp_path: Path) -> None:
    terrain = Terrain(seed=3)
    key = RiverKey(TerrainParams.from_component(terrain, 1.0e6), climate_params(terrain, True), CELLS, 1.0)
    nodes = rivers_of_ground(key.params, key.climate, key.cells, key.strength)
    assert nodes is not None
    made, cache = river_table(nodes, key.params.radius_m, key.params.seed), TableCache("rivers", tmp_path)
    keep_table(key, made, cache)
    assert kept_table(key, cache) is None, "too few nodes to be kept"
    keep_table(key, made, cache, least=1)
    held = kept_table(key, cache)
    assert held is not None
    assert (held.radius_m, held.cell_m, held.seed, held.given) == (made.radius_m, made.cell_m, made.seed, made.given)
    for name in ARRAYS:
        a, b = getattr(held, name), getattr(made, name)
        assert a.dtype == b.dtype, name
        np.testing.assert_array_equal(a, b, name)
    np.testing.assert_array_equal(river_texels(held)[1], river_texels(made)[1])
    others = (
        replace(key, strength=2.0),
        replace(key, cells=CELLS // 2),
        replace(key, params=replace(key.params, erosion=0.123)),
        replace(key, climate=replace(key.climate, humidity=0.123)),
    )
    assert all(kept_table(other, cache) is None for other in others)
