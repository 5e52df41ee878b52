"""A raft that the water of rivers and lakes carries to the sea: by itself, afloat, within the banks, never stuck."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

import planetfall as pf
from planetfall.games.afloat import main as game
from planetfall.games.afloat import raft
from planetfall.games.afloat.drifting import DRAFT_M, Rafts
from planetfall.query.drainage import River
from planetfall.systems.terrain.ground_params import ground_params
from planetfall.systems.terrain.rivers.table import CELL_STEPS, RiverTable

Floats = NDArray[np.float64]
CELLS = 40_000
DAY_S = 86400.0


@pytest.fixture(scope="module")
def scene(tmp_path_factory: pytest.TempPathFactory) -> Iterator[pf.Scene]:
    """Earth with rivers of few cells, in a cache of its own."""
    with pytest.MonkeyPatch.context() as patch, pf.load_scene("earth") as found:
        patch.setenv("PLANETFALL_CACHE", str(tmp_path_factory.mktemp("cache")))
        found.planet[pf.Terrain].drainage_cells = CELLS
        yield found


@pytest.fixture(scope="module")
def sampler(scene: pf.Scene) -> pf.TerrainSampler:
    return pf.TerrainSampler(scene)


def journeys(scene: pf.Scene, sampler: pf.TerrainSampler, count: int) -> list[tuple[River, Floats]]:
    """Rivers of 300 to 400 km with places well above the sea to start from."""
    found = []
    for river in scene.rivers(120):
        if river.reaches_sea and 3e5 < river.length_m < 4e5 and len(found) < count:
            try:
                start = raft.launch(sampler, river.path)
            except ValueError:
                continue
            if sampler.water(start).level_m[0] > 15.0:
                found.append((river, start))
    assert len(found) == count
    return found


def test_rafts_come_to_the_sea(scene: pf.Scene, sampler: pf.TerrainSampler) -> None:
    """From the upper reaches of three rivers: 70 to 230 km as the crow flies, in a day of their time."""
    chosen = journeys(scene, sampler, 3)
    rafts = Rafts(sampler, [start for _, start in chosen])
    start, highest = rafts.up.copy(), rafts.level_m.copy()
    afloat, steps = np.zeros(3), np.zeros(3)
    while not rafts.at_sea.all():
        going = ~rafts.at_sea
        before = rafts.up
        dt_s = np.where(going, rafts.longest_step_s(), 0.0)
        rafts.step(dt_s)
        assert (rafts.time_s < 5.0 * DAY_S).all(), "stuck"
        moved = np.linalg.norm(rafts.up - before, axis=1) * sampler.radius_m
        # A stride by the faster of two currents, 1.5 of it where they grow, what a sweep and two pushes add.
        assert (moved <= 120.0 + 0.3 * dt_s + 10.0).all(), "no jumps"
        assert np.isfinite(rafts.positions_m).all()
        # Where the ground lifts a raft, it is by its draft at most; and it sinks with the water as that falls, 7.5 m/s
        # down slopes of less than 1 in 100, within 0.4 s.
        assert (rafts.height_m - rafts.level_m <= DRAFT_M + 0.03).all()
        assert (rafts.level_m - rafts.height_m <= 0.01).all(), "never drowned: water does not climb"
        # Levels are means of the lines about, in which a place's own is all but alone; at the shore a raft may lie on
        # the river and on the sea by turns.
        assert (rafts.level_m <= highest + np.where(highest > 1.0, 1e-3, 0.05)).all()
        highest = np.minimum(highest, rafts.level_m)
        afloat += (rafts.depth_m > DRAFT_M) & going
        steps += going
    assert (afloat > 0.99 * steps).all()
    assert (rafts.level_m == 0.0).all() and (rafts.depth_m > DRAFT_M).all()
    far_m = np.linalg.norm(rafts.up - start, axis=1) * sampler.radius_m
    assert (far_m > 5e4).all()
    # A cell is 113 km wide: the raft has come out at its own river's mouth.
    for k, (river, _) in enumerate(chosen):
        assert np.linalg.norm(rafts.up[k] - river.mouth) * sampler.radius_m < 1.13e5


def lake_places(table: RiverTable, sampler: pf.TerrainSampler, count: int) -> Floats:
    """Directions (N, 3) all over the lakes."""
    line = np.flatnonzero((table.to >= 0) & (table.values[:, 5] * table.values[table.to, 5] > 0.0))
    rng = np.random.default_rng(4)
    chosen = rng.choice(line, 40 * count)
    a = table.place[chosen] * (table.cell_m / CELL_STEPS)
    reach = table.values[chosen, 1:2] * 0.7
    places = a + rng.uniform(-1.0, 1.0, a.shape) * reach
    places /= np.linalg.norm(places, axis=1)[:, None]
    water = sampler.water(places)
    # Deeper than rivers are.
    places = places[(water.level_m > 1.0) & (water.depth_m > 15.0)]
    assert len(places) >= count
    return places[:count]


def test_lakes_let_rafts_go(scene: pf.Scene, sampler: pf.TerrainSampler) -> None:
    """Slowly, by what flows through, and over no rim into the river that leaves."""
    table = ground_params(scene.planet[pf.Terrain], sampler.radius_m, sea=True).rivers
    assert table is not None
    rafts = Rafts(sampler, lake_places(table, sampler, 4))
    lake_m = rafts.level_m.copy()

    def speed() -> Floats:
        return np.linalg.norm(rafts.current_m_s, axis=1)

    inside = speed() < 2.0
    assert (speed() < 0.1).all()
    for _ in range(2000):
        inside &= speed() < 2.0
        if not inside.any():
            break
        rafts.step(np.where(inside, rafts.longest_step_s(), 0.0))
        assert (rafts.depth_m > 0.0).all()
    assert not inside.any(), "stuck in a lake"
    assert rafts.time_s.max() < 3.0 * 365.0 * DAY_S
    out = rafts.up.copy()
    for _ in range(100):
        rafts.step(rafts.longest_step_s())
    assert (np.linalg.norm(rafts.up - out, axis=1) * sampler.radius_m > 1000.0).all()
    assert (rafts.level_m <= lake_m + 1e-3).all()


def test_no_mountain_stream_holds_a_raft() -> None:
    """Of the shipped preset, with cells of 12 km: steep, narrow, shallow. Each goes on all the time."""
    with pf.load_scene("earth") as scene:
        sampler = pf.TerrainSampler(scene)
        starts: list[Floats] = []
        for river in scene.rivers(60):
            try:
                place = raft.launch(sampler, river.path[: len(river.path) // 2])
            except ValueError:
                continue
            if sampler.water(place).level_m[0] > 500.0:
                starts.append(place)
            if len(starts) == 6:
                break
    assert len(starts) == 6
    rafts = Rafts(sampler, starts)
    high = rafts.level_m.copy()
    afloat = np.zeros(len(starts))
    for _ in range(6):
        before = rafts.up.copy()
        for _ in range(100):
            rafts.step(rafts.longest_step_s())
            assert (rafts.height_m - rafts.level_m <= DRAFT_M + 0.1).all()
            afloat += rafts.depth_m > 0.0
        assert (np.linalg.norm(rafts.up - before, axis=1) * sampler.radius_m > 30.0).all()
    assert (rafts.level_m < high).all()
    assert (afloat > 0.9 * 600).all()


def test_steps_as_short_as_pictures_do_not_shake(scene: pf.Scene, sampler: pf.TerrainSampler) -> None:
    """At 60 Hz: speeds change as slowly as a raft follows its water, and the same way is gone as in long steps."""
    _, start = journeys(scene, sampler, 1)[0]
    rafts, coarse = Rafts(sampler, start), Rafts(sampler, start)
    speeds, heights = [], []
    for _ in range(600):
        rafts.step(1.0 / 60.0)
        speeds.append(rafts.velocity_m_s[0])
        heights.append(rafts.height_m[0])
    for _ in range(5):
        coarse.step(2.0)
    # Currents change by a tenth of their speed over ten metres at most, so within a step by less than 1 cm/s.
    assert np.linalg.norm(np.diff(speeds, axis=0), axis=1).max() < 0.01
    assert np.abs(np.diff(heights)).max() < 0.005
    assert np.linalg.norm(rafts.positions_m - coarse.positions_m) < 1.0


def test_dry_places_and_shallow_rivers_are_refused(sampler: pf.TerrainSampler, scene: pf.Scene) -> None:
    peak = scene.rivers(1)[0].path[0]
    assert sampler.water(peak).depth_m[0] == 0.0
    with pytest.raises(ValueError, match=r"directions\[1\]: a raft needs water"):
        Rafts(sampler, [pf.direction(0.0, -160.0), peak])
    with pytest.raises(ValueError, match=r"nowhere 0\.8 m deep"):
        raft.launch(sampler, peak[None])


@pytest.mark.parametrize("arguments", [["--raft", "-1"], ["--raft", "--hurry", "0"], ["--raft", "--hurry", "nan"]])
def test_bad_options(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        game.main(arguments)
    assert "--hurry above 0" in capsys.readouterr().err


@pytest.mark.gpu
def test_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--raft", "--frames", "2", "--fps", "2", "--hurry", "20", "--size", "96", "54", "--quality", "low"]
    assert game.main([*arguments, "-o", str(tmp_path)]) == 0
    assert f"river {game.RIVER}: 0." in capsys.readouterr().out
    a, b = (np.asarray(Image.open(tmp_path / f"raft_000{k}.png")).astype(int) for k in (0, 1))
    assert a.shape == (54, 96, 3) and a.std() > 10 and np.abs(a - b).max() > 10


def test_in_a_window_the_camera_follows(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    seen: list[pf.Camera] = []
    monkeypatch.setattr(pf, "has_display", lambda: True)

    def fly(scene: pf.Scene, camera: pf.Camera, **options: object) -> None:
        on_frame = options["on_frame"]
        assert callable(on_frame)
        for k in range(30):
            held = on_frame(k / 60.0, 1.0 / 60.0)
            assert isinstance(held, pf.Camera)
            seen.append(held)

    monkeypatch.setattr(pf, "fly", fly)
    assert game.main(["--raft", "-o", str(tmp_path)]) == 0
    places = np.array([camera.position_m for camera in seen])
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert 0.1 < np.linalg.norm(places[-1] - places[0]) < 10.0 and steps.max() < 0.5
