"""River nodes: levels that never climb, lakes that are level, widths of their water, and the same bits everywhere."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure.land import network_shape
from planetfall.engine.table_cache import TableCache
from planetfall.systems.terrain.drainage import stored
from planetfall.systems.terrain.drainage.cells import cell_grid
from planetfall.systems.terrain.drainage.climate import ClimateParams, climate_params
from planetfall.systems.terrain.drainage.packing import pack, unpack
from planetfall.systems.terrain.drainage.places import PLACES, place_directions
from planetfall.systems.terrain.drainage.solve import Solution, solve_streams
from planetfall.systems.terrain.height import TerrainParams, height
from planetfall.systems.terrain.rivers import bays
from planetfall.systems.terrain.rivers.bays import find_bays, with_bays
from planetfall.systems.terrain.rivers.falls import with_falls
from planetfall.systems.terrain.rivers.nodes import RiverNodes, nodes_of, rivers_of_ground
from planetfall.systems.terrain.rivers.troughs import with_troughs

EARTH = TerrainParams(6.371e6, 1, 9000.0, -9000.0, layers=16, land_share=0.3, hills=0.2, mountains=0.4)
CLIMATE = ClimateParams(5200.0, -500.0, 0.5)
CELLS = 40_000
MANY_CELLS = 400_000
"""38 km: enough lakes and rivers to count."""


@pytest.fixture(scope="module")
def large() -> Solution:
    return solve_streams(EARTH, CLIMATE, MANY_CELLS)


@pytest.fixture(scope="module")
def solution() -> Solution:
    return solve_streams(EARTH, CLIMATE, CELLS)


@pytest.fixture(scope="module")
def nodes(solution: Solution) -> RiverNodes:
    return nodes_of(solution.network.grid, solution.streams, EARTH)


@pytest.fixture(scope="module")
def preset() -> TerrainParams:
    with pf.load_scene("earth") as scene:
        return TerrainParams.from_component(scene.planet[pf.Terrain], scene.planet.radius_m)


@pytest.fixture(scope="module")
def shipped(preset: TerrainParams, tmp_path_factory: pytest.TempPathFactory) -> RiverNodes:
    """Of the preset earth, by nobody's solving."""
    with pytest.MonkeyPatch.context() as patch, pf.load_scene("earth") as scene:
        patch.setenv("PLANETFALL_CACHE", str(tmp_path_factory.mktemp("cache")))
        patch.setattr(stored, "solve_streams", None)
        patch.setattr(bays, "find_bays", None)
        found = rivers_of_ground(preset, climate_params(scene.planet[pf.Terrain]))
    assert found is not None
    return found


def segments(nodes: RiverNodes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(upper end, lower end, is a lake's)."""
    upper = np.flatnonzero(nodes.to >= 0)
    lower = nodes.to[upper]
    return upper, lower, nodes.lake[upper] & nodes.lake[lower]


def same(a: RiverNodes, b: RiverNodes) -> bool:
    pairs = [(getattr(a, f.name), getattr(b, f.name)) for f in fields(RiverNodes)]
    return all(x.dtype == y.dtype and x.tobytes() == y.tobytes() for x, y in pairs)


def whole(nodes: RiverNodes, params: TerrainParams, climate: ClimateParams, cells: int) -> RiverNodes:
    """With troughs, bays and falls, as `rivers_of_ground` gives them."""
    found = with_bays(with_troughs(nodes, climate, params.scale), find_bays(nodes, params, cells))
    return with_falls(found, params.radius_m)


# -- what the ground's evaluator relies on ----------------------------------------------------------------------------


def test_arrays_are_as_agreed(nodes: RiverNodes) -> None:
    assert nodes.direction.shape == (len(nodes), 3) and nodes.direction.dtype == np.float64
    assert nodes.to.dtype == np.int32 and nodes.lake.dtype == bool
    for name in ("level_m", "half_width_m", "depth_m", "flat_m", "reach_m", "discharge_m3_s"):
        values = getattr(nodes, name)
        assert values.shape == (len(nodes),) and values.dtype == np.float32
        ends = (nodes.to < 0) & (name == "level_m")  # below the sea
        assert np.isfinite(values).all() and ((values >= 0.0) | ends).all(), name
    assert np.abs(np.linalg.norm(nodes.direction, axis=1) - 1.0).max() < 1e-15
    assert (nodes.flat_m >= nodes.half_width_m).all() and (nodes.reach_m > nodes.flat_m).all()
    assert ((nodes.depth_m > 0.0) == (nodes.half_width_m > 0.0)).all()


def test_water_never_climbs_and_all_of_it_comes_to_a_mouth(nodes: RiverNodes) -> None:
    upper, lower, _ = segments(nodes)
    assert (nodes.level_m[upper] >= nodes.level_m[lower]).all()
    assert (nodes.discharge_m3_s[lower] >= nodes.discharge_m3_s[upper]).all()
    end = np.where(nodes.to >= 0, nodes.to, np.arange(len(nodes)))
    for _ in range(32):
        end = end[end]
    assert (nodes.to[end] == -1).all()
    # From the sea's level on rivers go a bit further below it, where their banks are under water too; dry valleys end.
    assert (nodes.level_m[nodes.to < 0][nodes.half_width_m[nodes.to < 0] == 0.0] == 0.0).all()
    ends = np.flatnonzero((nodes.to < 0) & (nodes.half_width_m > 0.0))
    before = np.flatnonzero(np.isin(nodes.to, ends))
    assert len(before) == len(ends) and (nodes.level_m[before] == 0.0).all()
    banks_m = 0.3 + 0.6 * nodes.depth_m[ends]
    assert (nodes.level_m[ends] < -banks_m).all()
    assert (np.linalg.norm(nodes.direction[upper] - nodes.direction[lower], axis=1) > 0.0).all()


def test_lakes_are_level_and_wide_and_rivers_are_not(large: Solution) -> None:
    grid = large.network.grid
    nodes = nodes_of(grid, large.streams, EARTH)
    upper, lower, lake = segments(nodes)
    assert lake.sum() > 10
    assert (nodes.level_m[upper[lake]] == nodes.level_m[lower[lake]]).all()
    # Elsewhere water is as wide as 7.2 sqrt(Q) says, at both ends, to the rounding of float32.
    for end in (upper[~lake], lower[~lake]):
        wet = end[nodes.half_width_m[end] > 0.0]
        assert nodes.half_width_m[wet] == pytest.approx(3.6 * np.sqrt(nodes.discharge_m3_s[wet]), rel=1e-6)
        assert nodes.depth_m[wet] == pytest.approx(0.27 * nodes.discharge_m3_s[wet] ** 0.390625, rel=1e-6)
    cell_m = EARTH.radius_m * np.sqrt(4.0 * np.pi / grid.count)
    assert 0.3 * cell_m < nodes.half_width_m.max() <= 0.601 * cell_m


def test_a_dry_world_has_valleys_without_water(solution: Solution) -> None:
    dry = solve_streams(EARTH, ClimateParams(5200.0, -500.0, 0.5, sea=False), CELLS)
    found = nodes_of(dry.network.grid, dry.streams, EARTH)
    assert len(found) > 0.8 * len(solution.streams.cells)
    assert not found.half_width_m.any() and not found.depth_m.any() and not found.lake.any()
    assert found.flat_m.max() > 500.0


def test_strength_scales_the_water(nodes: RiverNodes, solution: Solution, monkeypatch: pytest.MonkeyPatch) -> None:
    half = nodes_of(solution.network.grid, solution.streams, EARTH, 0.25)
    count = len(solution.streams.cells)
    assert np.array_equal(half.to, nodes.to) and np.array_equal(half.level_m[:count], nodes.level_m[:count])
    both = (half.half_width_m > 0.0) & ~nodes.lake
    assert half.half_width_m[both] == pytest.approx(0.5 * nodes.half_width_m[both], rel=1e-6)
    assert (half.half_width_m > 0.0).sum() < (nodes.half_width_m > 0.0).sum()
    monkeypatch.setattr(stored, "solve_streams", None)  # nobody may solve anything
    assert rivers_of_ground(EARTH, CLIMATE, CELLS, 0.0) is None


@pytest.mark.parametrize("radius_m", [500.0, 6.0e4, 3.39e6])
def test_on_planets_of_all_sizes(radius_m: float) -> None:
    highest_m = min(0.1 * radius_m, 9000.0)
    params = TerrainParams(radius_m, 3, highest_m, -highest_m, layers=10, land_share=0.5)
    found = rivers_of_ground(params, CLIMATE, 6000, cache=TableCache("drainage", ""))
    assert found is not None
    upper, lower, lake = segments(found)
    assert (found.level_m[upper] >= found.level_m[lower]).all()
    assert (found.level_m[upper[lake]] == found.level_m[lower[lake]]).all()
    assert (found.flat_m >= found.half_width_m).all() and (found.reach_m > found.flat_m).all()
    # Levels are many, not steps of a few; valleys go with the planet, by powers of two.
    assert found.level_m.max() > 0.1 * highest_m and len(np.unique(found.level_m)) > 0.3 * len(streams_above(found))
    dry = found.half_width_m == 0.0
    if dry.any():
        assert 1000.0 <= found.reach_m[dry].max() / params.scale <= 8800.0


def streams_above(nodes: RiverNodes) -> np.ndarray:
    """Nodes above the sea."""
    return np.flatnonzero(nodes.level_m > 0.0)


# -- ways, places, ground ---------------------------------------------------------------------------------------------


def test_nodes_lie_in_the_cells_that_rivers_go_through(nodes: RiverNodes, solution: Solution) -> None:
    network, streams = solution.network, solution.streams
    count = len(streams.cells)
    assert np.array_equal(network.grid.locate(nodes.direction[:count]), streams.cells)
    index = network.index[streams.cells]
    assert np.array_equal(network.places[index], nodes.direction[:count])
    # The way of the network is the way of the nodes, over edges of lakes and mouths.
    to = nodes.to[:count].copy()
    for _ in range(2):
        between = to >= count
        to[between] = nodes.to[to[between]]
    goes_on = to >= 0
    assert np.array_equal(network.receiver[index[goes_on]], index[to[goes_on]])
    assert network.sea[network.receiver[index[~goes_on]]].all()


def test_places_stay_in_their_cells() -> None:
    grid = cell_grid(30)
    cells = np.arange(grid.count, dtype=np.int32)
    at = [place_directions(grid, cells, k) for k in range(PLACES)]
    assert all(np.array_equal(grid.locate(place), cells) for place in at)
    assert len({place.tobytes() for place in at}) == PLACES


def test_ground_lies_above_the_rivers(shipped: RiverNodes, preset: TerrainParams) -> None:
    """Of the preset earth: cells of 113 km would tell nothing of the ground between them."""
    upper, lower, lake = segments(shipped)
    rng = np.random.default_rng(3)
    chosen = rng.choice(np.flatnonzero(~lake), 2000, replace=False)
    upper, lower = upper[chosen], lower[chosen]
    for share in (0.0, 0.5):
        place = shipped.direction[upper] * (1.0 - share) + shipped.direction[lower] * share
        level = shipped.level_m[upper] * (1.0 - share) + shipped.level_m[lower] * share
        below = []
        for _ in range(3):
            beside = place + rng.normal(scale=1000.0 / preset.radius_m, size=place.shape)
            ground = height(beside / np.linalg.norm(beside, axis=1)[:, None], preset)
            below.append((ground < level) & (ground > 0.0))
        assert np.mean(below) < 0.05, (share, np.mean(below))
    # Few canyons: as far below the ground as the Grand Canyon, at one node in a hundred at most.
    cut = height(shipped.direction[upper], preset) - shipped.level_m[upper]
    assert (cut > 1600.0).mean() < 0.01


def test_rivers_are_as_rivers_are(large: Solution, record_property: Callable[[str, object], None]) -> None:
    """Numbers of real ones: concavity 0.4 to 0.6 (Tucker and Whipple 2002), Hack's exponent 0.5 to 0.6, streams of one
    order 3 to 5 times those of the next (Horton, Strahler). Few cells scatter, so bounds are wider by 0.15."""
    shape = network_shape(large, EARTH)
    for name, value in (("concavity", shape.concavity), ("Hack", shape.hack), ("bifurcation", str(shape.ratios))):
        record_property(name, value)
    assert shape.undrained == 0 and shape.climbing == 0
    assert 0.25 < shape.concavity < 0.75
    assert 0.45 < shape.hack < 0.7
    assert all(2.5 < ratio < 6.5 for ratio in shape.ratios[:2]), shape.ratios


# -- what is kept -----------------------------------------------------------------------------------------------------


def test_packed_numbers_come_back() -> None:
    rng = np.random.default_rng(0)
    arrays = [rng.integers(0, 2**16, 1000).astype(np.uint16), np.arange(1000, dtype=np.uint32) * 4_000_000]
    kinds = {"a": np.uint16, "b": np.uint32}
    packed = pack(arrays)
    found = unpack(packed, kinds)
    assert all(np.array_equal(found[name], a) for name, a in zip(kinds, arrays, strict=True))
    with pytest.raises(ValueError, match="cannot be read"):
        unpack(packed[:-20], kinds)
    with pytest.raises(ValueError, match="bytes are not 5"):
        unpack(pack([np.zeros(3, dtype=np.uint8)]), {"a": np.uint8, "b": np.uint32})


def test_kept_nodes_have_the_same_bits(nodes: RiverNodes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = TableCache("drainage", tmp_path)
    first = rivers_of_ground(EARTH, CLIMATE, CELLS, cache=cache)
    assert first is not None and same(first, whole(nodes, EARTH, CLIMATE, CELLS))
    told: list[float] = []
    monkeypatch.setattr(stored, "solve_streams", None)
    monkeypatch.setattr(bays, "find_bays", None)
    again = rivers_of_ground(EARTH, CLIMATE, CELLS, progress=told.append, cache=cache)
    assert again is not None and same(again, first) and told == [1.0]
    # Rivers don't depend on relief finer than 256 m.
    finer = TerrainParams(6.371e6, 1, 9000.0, -9000.0, layers=12, land_share=0.3, hills=0.2, mountains=0.4)
    assert rivers_of_ground(finer, CLIMATE, CELLS, cache=cache) is not None


def test_the_preset_earths_rivers_are_shipped(shipped: RiverNodes) -> None:
    assert 250_000 <= len(shipped) <= 490_000
    assert stored.SHIPPED.folder is not None
    assert sum(file.stat().st_size for file in stored.SHIPPED.folder.iterdir()) < 4_000_000


@pytest.mark.slow
def test_what_is_shipped_is_what_would_be_solved(preset: TerrainParams, shipped: RiverNodes) -> None:
    with pf.load_scene("earth") as scene:
        climate = climate_params(scene.planet[pf.Terrain])
    made = solve_streams(preset, climate)
    found = nodes_of(made.network.grid, made.streams, preset)
    assert same(whole(found, preset, climate, made.network.grid.count), shipped), (
        "raise _VERSION in drainage/stored.py, write the files anew with its ship() and rivers/nodes.py's ship_bays()"
    )


def print_fingerprint() -> None:
    """For another process: all bits of the nodes."""
    made = solve_streams(EARTH, CLIMATE, CELLS)
    found, hashed = nodes_of(made.network.grid, made.streams, EARTH), hashlib.sha256()
    found = whole(found, EARTH, CLIMATE, CELLS)
    for field in fields(RiverNodes):
        hashed.update(np.ascontiguousarray(getattr(found, field.name)).tobytes())
    sys.stdout.write(hashed.hexdigest())


def test_other_processors_find_the_same_bits() -> None:
    code = "from test_river_nodes import print_fingerprint; print_fingerprint()"
    found = []
    for masked in (
        "",
        "AVX2 FMA3 AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR X86_V3 X86_V4",
    ):
        folders = [str(Path(__file__).parent), *sys.path]
        env = os.environ | {"PYTHONPATH": os.pathsep.join(folders), "PYTHONWARNINGS": "ignore"}
        if masked:
            env["NPY_DISABLE_CPU_FEATURES"] = masked
        run = subprocess.run([sys.executable, "-P", "-c", code], env=env, capture_output=True, text=True, check=True)
        found.append(run.stdout.strip())
    assert len(found[0]) == 64 and found[0] == found[1]
