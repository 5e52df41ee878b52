"""Valleys that ice has filled: wide floors and steep sides where it was cold and high, all others as they were."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from river_kit import walks

from planetfall.systems.terrain.drainage.climate import ClimateParams
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.rivers.node_arrays import RiverNodes
from planetfall.systems.terrain.rivers.troughs import glaciated, with_troughs

EARTH = TerrainParams(mountains=0.4)
WARM = ClimateParams(9000.0, 9000.0, 0.5)
COLD = ClimateParams(3000.0, 3000.0, 0.5)
"""An ice age's snow line at 2000 m."""


@pytest.fixture(scope="module")
def steep() -> RiverNodes:
    """Valleys that begin at 3000 m and come down to 600 m."""
    nodes = walks(EARTH)
    down = np.arange(len(nodes)) % 8
    levels = np.where(nodes.lake, 600.0, 3000.0 - 400.0 * down)
    floor = np.where(nodes.lake, nodes.flat_m, 100.0).astype(np.float32)
    return replace(nodes, level_m=levels.astype(np.float32), flat_m=floor)


def test_ice_came_from_above_its_line_and_melted_below(steep: RiverNodes) -> None:
    share = glaciated(steep, COLD).reshape(-1, 8)
    assert share.shape[0] > 20
    # At the heads nothing has come down yet; 500 to 1400 m below the line all of it melts.
    assert (share[:, 0] == 0.0).all() and (share[:, 2:4] > 0.9).all()
    assert (share[:, 6:] < 0.05).all() and (np.diff(share[:, 3:6], axis=1) <= 0.0).all()
    assert (glaciated(steep, WARM) == 0.0).all()
    low = replace(steep, level_m=steep.level_m - np.float32(1300.0))
    assert (glaciated(low, COLD) == 0.0).all()
    # Level land in the cold had sheets of ice, which make no valleys.
    assert (glaciated(replace(steep, level_m=np.full_like(steep.level_m, 3000.0)), COLD) == 0.0).all()


def test_floors_are_wide_and_sides_steep(steep: RiverNodes) -> None:
    found = with_troughs(steep, COLD, 1.0)
    share = glaciated(steep, COLD)
    ice = (share > 0.9) & ~steep.lake
    assert ice.sum() > 40
    assert (found.flat_m[ice] > 5.0 * steep.flat_m[ice]).all()
    before, after = (n.reach_m - n.flat_m for n in (steep, found))
    assert (after[ice] < 0.6 * before[ice]).all()
    assert (found.reach_m <= steep.reach_m).all() and (found.reach_m > found.flat_m).all()
    same = (share == 0.0) | steep.lake
    for field in fields(RiverNodes):
        kept = same if field.name in ("flat_m", "reach_m") else slice(None)
        assert np.array_equal(getattr(found, field.name)[kept], getattr(steep, field.name)[kept]), field.name


def test_how_much_water_there_is_changes_no_valley(steep: RiverNodes) -> None:
    part = replace(steep, discharge_m3_s=steep.discharge_m3_s * np.float32(0.25))
    whole, found = with_troughs(steep, COLD, 1.0), with_troughs(part, COLD, 1.0, 0.25)
    assert np.array_equal(whole.flat_m, found.flat_m) and np.array_equal(whole.reach_m, found.reach_m)
