"""What a game asks of rivers: the largest ones, and where water goes at a place."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import planetfall as pf
from planetfall.cli.main import main

CELLS = 40_000


@pytest.fixture(scope="module", autouse=True)
def few_cells(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """A hundredth of the cells, in a cache of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("PLANETFALL_CACHE", str(tmp_path_factory.mktemp("cache")))
        patch.setattr("planetfall.query.drainage.network_below.__defaults__", (CELLS, None))
        yield


@pytest.fixture(scope="module")
def scene() -> Iterator[pf.Scene]:
    with pf.load_scene("earth") as scene:
        yield scene


def test_rivers_run_to_the_sea_or_to_larger_ones(scene: pf.Scene) -> None:
    told: list[float] = []
    rivers = scene.rivers(40, progress=told.append)
    assert told == sorted(told) and told[-1] == 1.0
    assert len(rivers) == 40 and [river.number for river in rivers] == list(range(40))
    sampler = pf.TerrainSampler(scene, drainage_cells=CELLS)
    for river in rivers:
        assert np.allclose(np.linalg.norm(river.path, axis=1), 1.0)
        assert river.reaches_sea or river.into is None or river.into < river.number
        steps = np.linalg.norm(np.diff(river.path, axis=0), axis=1) * scene.planet.radius_m
        assert steps.sum() <= river.length_m <= 1.01 * steps.sum()
        along = sampler.drainage(river.path[:-1])
        assert (np.diff(along.catchment_m2) > 0.0).all() and along.catchment_m2[-1] == river.catchment_m2
        assert along.discharge_m3_s[-1] == river.discharge_m3_s
        assert len(set(along.basin)) == 1 and along.basin[0] >= 0
    assert [river.discharge_m3_s for river in rivers] == sorted((r.discharge_m3_s for r in rivers), reverse=True)
    assert scene.rivers(3)[2].length_m == rivers[2].length_m


def test_water_goes_downstream_to_where_the_river_ends(scene: pf.Scene) -> None:
    river, sampler = scene.rivers(1)[0], pf.TerrainSampler(scene, drainage_cells=CELLS)
    found = sampler.drainage(river.path)
    assert np.allclose(np.linalg.norm(found.downstream[:-1], axis=1), 1.0)
    assert np.abs((found.downstream * river.path).sum(axis=1)).max() < 1e-12
    way = np.diff(river.path, axis=0)
    assert ((found.downstream[:-1] * way).sum(axis=1) / np.linalg.norm(way, axis=1) > 0.99).all()
    # The mouth is the sea's, as is the middle of an ocean.
    assert found.catchment_m2[-1] == 0.0 and found.basin[-1] == -1 and not found.downstream[-1].any()


def test_there_are_none_where_there_can_be_none(scene: pf.Scene) -> None:
    with pf.Scene("ball", {"planet": pf.Planet(radius_m=1e6)}) as ball:
        assert ball.rivers() == []
    below = pf.Terrain(highest_m=-10.0, lowest_m=-9000.0)
    with pf.Scene("sea", {"planet": pf.Planet(), "terrain": below}) as sea, pytest.raises(ValueError, match="height 0"):
        sea.rivers()
    with pf.load_scene("asteroid") as dry:
        valleys = dry.rivers(5)
        assert [river.discharge_m3_s for river in valleys] == [0.0] * 5
        assert [r.catchment_m2 for r in valleys] == sorted((r.catchment_m2 for r in valleys), reverse=True)
    for wrong in (-1, 2.5, True):
        with pytest.raises(ValueError, match="count"):
            scene.rivers(wrong)  # pyright: ignore[reportArgumentType]
    with pytest.raises(ValueError, match=r"directions\[0\]"):
        pf.TerrainSampler(scene, drainage_cells=CELLS).drainage([(0.0, 0.0, 0.0)])


def test_the_command_lists_and_draws_them(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "rivers.png"
    assert main(["rivers", "earth", "--count", "4", "--size", "512x256", "--output", str(file)]) == 0
    said = capsys.readouterr().out
    assert "the sea" in said and str(file) in said
    picture = np.asarray(Image.open(file).convert("RGB")).astype(int)
    assert picture.shape == (256, 512, 3)
    sea = (picture == (30, 60, 110)).all(axis=-1)
    rivers = (picture[..., 2] > picture[..., 0] + 60) & ~sea
    assert (
        0.6 < np.average(sea, weights=np.repeat(np.cos((np.arange(256) - 127.5) / 256 * np.pi)[:, None], 512, 1)) < 0.8
    )
    assert 0.005 < rivers.mean() < 0.1


def test_the_climate_is_that_of_the_rivers(scene: pf.Scene) -> None:
    sampler = pf.TerrainSampler(scene, drainage_cells=CELLS)
    rng = np.random.default_rng(2)
    places = rng.normal(size=(3000, 3))
    places /= np.linalg.norm(places, axis=1)[:, None]
    found, height = sampler.climate(places), sampler.height(places)
    terrain = scene.planet[pf.Terrain]
    # The standard atmosphere's lapse, from -6 degrees at the snow line; the sea is as warm as its level.
    warmer = found.temperature_c + 6.0 - 0.0065 * (found.snow_line_m - np.maximum(height, 0.0))
    assert np.abs(warmer).max() < 1e-9
    poles = sampler.climate([(0.0, 0.0, 2.0), (1.0, 0.0, 0.0)])
    assert poles.snow_line_m == pytest.approx([terrain.snow_line_pole_m, terrain.snow_line_m])
    assert (found.rain_m_year >= 0.0).all() and 0.4 < found.rain_m_year[height > 0.0].mean() < 1.6
    # Nothing runs off that has not fallen: water that leaves a catchment is less than its rain.
    river = scene.rivers(1)[0]
    leaves_m_year = river.discharge_m3_s * 365.2425 * 86400.0 / river.catchment_m2
    assert leaves_m_year < sampler.climate(river.path).rain_m_year.max()
    again = pf.TerrainSampler(scene, drainage_cells=CELLS).climate(places)
    assert np.array_equal(again.rain_m_year, found.rain_m_year)
    with pf.load_scene("mars") as dry:
        assert not pf.TerrainSampler(dry).climate(places[:10]).rain_m_year.any()
    with pytest.raises(ValueError, match=r"directions\[1\]"):
        sampler.climate([(1.0, 0.0, 0.0), (0.0, 0.0, 0.0)])
