"""Rivers: cells around a sphere, rain, and the way of every piece of land to the sea."""

from __future__ import annotations

import hashlib
import heapq
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from planetfall.engine.table_cache import TableCache
from planetfall.systems.terrain.drainage.cells import NO_CELL, cell_grid
from planetfall.systems.terrain.drainage.climate import ClimateParams, rain_mm, runoff_mm, temperature_c
from planetfall.systems.terrain.drainage.network import Network
from planetfall.systems.terrain.drainage.routing import add_downstream, flow_of
from planetfall.systems.terrain.drainage.solve import solve
from planetfall.systems.terrain.drainage.stored import network_of
from planetfall.systems.terrain.height import TerrainParams

EARTH = TerrainParams(6.371e6, 1, 9000.0, -9000.0, layers=16, land_share=0.3, hills=0.2, mountains=0.4)
CLIMATE = ClimateParams(5200.0, -500.0, 0.5)
CELLS = 40_000


@pytest.fixture(scope="module")
def network() -> Network:
    return solve(EARTH, CLIMATE, CELLS)


# -- cells ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("across", [16, 81])
def test_neighbours_know_one_another(across: int) -> None:
    grid = cell_grid(across)
    around = grid.neighbours(np.arange(grid.count, dtype=np.int32))
    none = around == NO_CELL
    assert none.sum() == 24 and none.sum(axis=1).max() == 1  # three cells at each of the cube's corners
    for k in range(8):
        here = np.flatnonzero(~none[:, k])
        assert (around[around[here, k]] == here[:, None]).any(axis=1).all()
    # Nobody twice, and all of them near: nothing is further than across a corner of the largest cells.
    directions = grid.directions()
    apart = np.linalg.norm(directions[around] - directions[:, None], axis=-1)[~none]
    assert apart.max() < 1.5 * 1.6 * 2.0 / across and apart.min() > 0.4 * 2.0 / across
    assert all(len(set(row[row >= 0])) == (row >= 0).sum() for row in around)


def test_a_cells_middle_lies_in_it_and_areas_fill_the_sphere() -> None:
    grid = cell_grid(81)
    directions = grid.directions()
    assert np.array_equal(grid.locate(directions), np.arange(grid.count))
    areas = grid.areas(directions)
    assert areas.sum() == pytest.approx(4.0 * np.pi, rel=1e-4)  # the rule of middles errs by (2 / across)^2 / 12
    assert areas.max() / areas.min() < 1.6


def test_what_is_read_between_cells_is_continuous_everywhere() -> None:
    grid, rng = cell_grid(48), np.random.default_rng(1)
    values = grid.directions() @ np.array([0.3, -0.5, 0.8])
    places = rng.normal(size=(20_000, 3))
    places[:6000] = np.sign(places[:6000]) * (1.0 + 1e-3 * rng.normal(size=(6000, 3)))  # about corners
    places[6000:12_000, :2] = 1.0 + 1e-3 * rng.normal(size=(6000, 2))  # about an edge
    places /= np.linalg.norm(places, axis=1)[:, None]
    found = grid.interpolated(values, places)
    assert np.abs(found - places @ np.array([0.3, -0.5, 0.8])).max() < 0.02  # half a cell at corners: 0.6 / 48
    near = grid.interpolated(values, places + 1e-7 * rng.normal(size=places.shape))
    assert np.abs(near - found).max() < 1e-5


# -- ways to the sea --------------------------------------------------------------------------------------------------


def random_ground(across: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Heights full of hollows, neighbours and distances of all cells of a grid."""
    grid, rng = cell_grid(across), np.random.default_rng(seed)
    height = rng.normal(size=grid.count) + 0.3
    height[rng.integers(0, grid.count, 50)] = 0.5  # equals
    neighbours = grid.neighbours(np.arange(grid.count, dtype=np.int32)).astype(np.int64)
    directions = grid.directions()
    apart = np.linalg.norm(directions[neighbours] - directions[:, None], axis=-1)
    return height, neighbours, np.where(neighbours >= 0, apart, 1.0)


@pytest.mark.parametrize("seed", range(4))
def test_every_hollow_is_left_over_its_lowest_pass(seed: int) -> None:
    height, neighbours, apart = random_ground(20, seed)
    sea = height < -0.8
    flow = flow_of(height, sea, neighbours, apart)
    # Height of the highest place on the way, from the sea up.
    highest = height.copy()
    for cell in flow.order:
        to = flow.receiver[cell]
        assert to == cell or to in neighbours[cell]
        if not sea[cell]:
            highest[cell] = max(height[cell], highest[to])
    assert sea[flow.order[: flow.starts[1]]].all() and sea[flow.order].sum() == flow.starts[1]
    # The flood that comes in from the sea (Barnes, Lehman and Mulla 2014) rises as high before it reaches the place.
    flood = np.where(sea, height, np.inf)
    queue = [(height[cell], int(cell)) for cell in np.flatnonzero(sea)]
    heapq.heapify(queue)
    while queue:
        level, cell = heapq.heappop(queue)
        for to in neighbours[cell]:
            if to >= 0 and flood[to] == np.inf:
                flood[to] = max(level, height[to])
                heapq.heappush(queue, (flood[to], int(to)))
    assert flow.hollows > 50
    assert np.array_equal(np.maximum(highest, height)[~sea], flood[~sea])


def test_without_hollows_water_takes_the_steepest_way() -> None:
    grid = cell_grid(24)
    directions = grid.directions()
    neighbours = grid.neighbours(np.arange(grid.count, dtype=np.int32)).astype(np.int64)
    apart = np.linalg.norm(directions[neighbours] - directions[:, None], axis=-1)
    height = directions[:, 2] + 0.5  # a smooth hill over the north pole
    flow = flow_of(height, height <= 0.0, neighbours, np.where(neighbours >= 0, apart, 1.0))
    land = height > 0.0
    slopes = np.where(neighbours >= 0, height[:, None] - height[neighbours], -np.inf) / np.maximum(apart, 1e-9)
    taken = (height - height[flow.receiver])[land] / np.linalg.norm(directions - directions[flow.receiver], axis=1)[
        land
    ]
    assert flow.hollows == 0 and np.array_equal(taken, slopes.max(axis=1)[land])


def test_land_without_a_sea_is_refused() -> None:
    height, neighbours, apart = random_ground(16, 0)
    with pytest.raises(ValueError, match="no way to the sea"):
        flow_of(height, np.zeros(len(height), dtype=bool), neighbours, apart)


def test_what_comes_downstream_is_all_that_is_above() -> None:
    height, neighbours, apart = random_ground(16, 5)
    sea = height < -1.0
    flow = flow_of(height, sea, neighbours, apart)
    own = np.random.default_rng(2).uniform(size=len(height))
    expected = own.copy()
    for cell in flow.order[::-1]:
        if flow.receiver[cell] != cell:
            expected[flow.receiver[cell]] += expected[cell]
    assert np.allclose(add_downstream(flow, own), expected, rtol=1e-13)


# -- rain -------------------------------------------------------------------------------------------------------------


def test_rain_falls_before_mountains_and_not_behind() -> None:
    grid = cell_grid(96)
    directions = grid.directions()
    longitude, sine = np.arctan2(directions[:, 1], directions[:, 0]), directions[:, 2]
    land = (np.abs(longitude) < 0.5) & (np.abs(sine - 0.72) < 0.12)  # westerlies
    ridge = np.exp(-((longitude / 0.08) ** 2))
    flat = rain_mm(grid, np.where(land, 200.0, -1000.0), CLIMATE)
    hilly = rain_mm(grid, np.where(land, 200.0 + 3000.0 * ridge, -1000.0), CLIMATE)
    inner = np.abs(sine - 0.72) < 0.06
    before, behind = inner & (np.abs(longitude + 0.08) < 0.04), inner & (np.abs(longitude - 0.25) < 0.08)
    assert hilly[before].mean() > 2.0 * flat[before].mean()
    assert hilly[behind].mean() < 0.6 * flat[behind].mean()


def test_there_are_rain_forests_and_deserts(network: Network) -> None:
    grid = cell_grid(81)
    directions = grid.directions()
    rain = rain_mm(grid, np.where(np.abs(directions[:, 1]) < 0.3, 200.0, -1000.0), CLIMATE)
    land, latitude = np.abs(directions[:, 1]) < 0.3, np.degrees(np.arcsin(np.abs(directions[:, 2])))
    belts = {name: rain[land & (np.abs(latitude - at) < 4.0)].mean() for name, at in (("wet", 4.0), ("dry", 27.0))}
    assert belts["wet"] > 4.0 * belts["dry"]
    assert (rain >= 0.0).all() and network.runoff_mm.min() >= 0.0
    # As on Earth: rain of 0.8 m a year on land, of which 0.3 run off; both within a factor of two.
    assert 150.0 < network.runoff_mm[~network.sea].mean() < 600.0


def test_warmth_follows_the_snow_line() -> None:
    poles = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
    found = temperature_c(poles, np.array([-500.0, 5200.0, 0.0]), CLIMATE)
    assert found[1] == pytest.approx(-6.0) and found[2] == pytest.approx(27.8)
    assert found[0] == pytest.approx(-6.0 - 0.0065 * 500.0)  # below the sea it is as warm as on it


def test_less_runs_off_than_falls() -> None:
    rain = np.geomspace(1.0, 1e4, 200)
    for warm in (-20.0, 0.0, 10.0, 30.0):
        runs = runoff_mm(rain, np.full(200, warm))
        assert (runs >= 0.0).all() and (runs <= rain).all() and (np.diff(runs) >= 0.0).all()
    # A wet tropical catchment and a steppe, by Turc's own formula.
    assert runoff_mm(np.array([2000.0, 300.0]), np.array([25.0, 10.0])) == pytest.approx([673.7, 20.25], abs=0.1)


# -- rivers -----------------------------------------------------------------------------------------------------------


def test_all_land_reaches_the_sea(network: Network) -> None:
    land = ~network.sea
    assert network.sea[network.mouth].all()
    assert network.catchment_m2[network.sea].sum() == pytest.approx(network.area_m2[land].sum(), rel=1e-12)
    assert network.area_m2[land].sum() == pytest.approx(0.3 * 4.0 * np.pi * 6.371e6**2, rel=0.05)
    down = network.receiver[land]
    assert (network.discharge_m3_s[down] >= network.discharge_m3_s[land]).all()


def test_rivers_part_the_land_and_none_crosses_another(network: Network) -> None:
    streams = network.streams(10_000)
    water = [network.discharge_m3_s[stream.cells[-2]] for stream in streams]
    assert water == sorted(water, reverse=True)
    seen = np.zeros(len(network.cells), dtype=int)
    for stream in streams:
        assert np.array_equal(network.receiver[stream.cells[:-1]], stream.cells[1:])
        np.add.at(seen, stream.cells[:-1], 1)
        if stream.into >= 0:
            assert stream.cells[-1] in streams[stream.into].cells[:-1]
        else:
            assert network.sea[stream.cells[-1]]
    assert (seen[~network.sea] == 1).all()


def test_a_second_start_finds_the_same_rivers(network: Network, tmp_path: Path) -> None:
    cache = TableCache("drainage", tmp_path)
    for time in range(2):
        found = network_of(EARTH, CLIMATE, CELLS, cache=cache)
        for name in ("cells", "receiver", "offset", "runoff_mm"):
            assert np.array_equal(getattr(found, name), getattr(network, name)), (time, name)
    assert len(list(tmp_path.rglob("*.npz"))) == 1
    network_of(EARTH, ClimateParams(5200.0, -500.0, 0.8), CELLS, cache=cache)
    assert len(list(tmp_path.rglob("*.npz"))) == 2


def test_a_broken_file_is_solved_anew(network: Network, tmp_path: Path) -> None:
    cache = TableCache("drainage", tmp_path)
    network_of(EARTH, CLIMATE, CELLS, cache=cache)
    (file,) = tmp_path.rglob("*.npz")
    file.write_bytes(file.read_bytes()[:1000])
    assert np.array_equal(network_of(EARTH, CLIMATE, CELLS, cache=cache).receiver, network.receiver)


def test_ground_without_land_or_sea_is_refused() -> None:
    with pytest.raises(ValueError, match="height 0"):
        solve(TerrainParams(6.371e6, 1, -100.0, -9000.0, layers=4), CLIMATE, 6000)


def print_fingerprint() -> None:
    """For another process: what everything depends on."""
    made = solve(EARTH, CLIMATE, CELLS)
    hashed = hashlib.sha256()
    for part in (made.cells, made.receiver, made.runoff_mm, made.discharge_m3_s):
        hashed.update(np.ascontiguousarray(part).tobytes())
    sys.stdout.write(hashed.hexdigest())


def test_other_processors_find_the_same_bits() -> None:
    code = "from test_drainage import print_fingerprint; print_fingerprint()"
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
