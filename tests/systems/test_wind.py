"""Wind: what it does to plants, in numbers and in pictures, and what it is the default of."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from cover_kit import woods

import planetfall as pf
from planetfall.components.wind import ALOFT, blown
from planetfall.engine.frame.gbuffer import Surface
from planetfall.engine.space.axes import direction
from planetfall.systems.cover.sway import GUSTS, sway_at

PLACES = ((0.0, 0.0), (90.0, 0.0), (-90.0, 30.0), (35.2644, 45.0), (0.0, 180.0), (-12.0, 70.0))


def unit(*vector: float) -> np.ndarray:
    return np.asarray(vector) / np.linalg.norm(vector)


# -- sway ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", PLACES, ids=str)
@pytest.mark.parametrize("radius_m", [1e3, 6.371e6, 7e7])
def test_plants_bend_along_the_ground(place, radius_m):
    """Also where the wind's own direction points straight up."""
    for wind in (pf.Wind(speed_m_s=20.0), pf.Wind(speed_m_s=20.0, direction_deg=-123.0, at=(40.0, -60.0))):
        up = direction(*place)
        found = sway_at(wind, radius_m * up, 12.0)
        assert abs(found.bend @ up) < 1e-12 and np.linalg.norm(found.bend) < 0.75
        assert np.isfinite(found.gusts).all() and ((found.gusts[:, 3] >= 0.0) & (found.gusts[:, 3] < 1.0)).all()


@pytest.mark.parametrize("time_s", [0.0, 1e5, 1e9])
@pytest.mark.parametrize("radius_m", [1e3, 6.371e6, 7e7])
def test_gusts_stand_on_the_ground_as_the_camera_moves(radius_m, time_s):
    """The phase at a point is the same from two cameras some metres apart: within a thousandth of a cycle."""
    wind, random = pf.Wind(), np.random.default_rng(4)
    for place in PLACES:
        camera = radius_m * direction(*place)
        other, point = camera + random.uniform(-50, 50, 3), camera + random.uniform(-50, 50, 3)
        one, two = sway_at(wind, camera, time_s), sway_at(wind, other, time_s)
        for k in range(GUSTS):
            phases = [s.gusts[k, :3] @ (point - at) + s.gusts[k, 3] for s, at in ((one, camera), (two, other))]
            assert abs((phases[0] - phases[1] + 0.5) % 1.0 - 0.5) < 1e-3


def test_more_wind_bends_more_and_none_bends_nothing():
    camera = 6.371e6 * direction(20.0, 30.0)
    bends = [float(np.linalg.norm(sway_at(pf.Wind(speed_m_s=v), camera, 0.0).bend)) for v in (0, 2, 5, 10, 20, 60)]
    assert bends[0] == 0.0 and all(a < b for a, b in pairwise(bends)) and bends[-1] < 0.76


def test_gusts_run_with_the_wind():
    """Crests go from where they were along the wind, at less than its speed."""
    wind = pf.Wind(speed_m_s=10.0, direction_deg=90.0)
    camera = 6.371e6 * direction(0.0, 0.0)
    now, later = sway_at(wind, camera, 0.0), sway_at(wind, camera, 0.1)
    along = now.gusts[0, :3]
    moved = ((now.gusts[0, 3] - later.gusts[0, 3]) % 1.0) / np.linalg.norm(along) / 0.1
    assert 2.0 < moved < 10.0 and unit(*along) @ np.array([0.0, 1.0, 0.0]) > 0.99


# -- the default of others -------------------------------------------------------------------------------------------


def test_waves_and_weather_take_the_wind_where_theirs_is_not_set():
    wind = pf.Wind(speed_m_s=15.0, direction_deg=200.0, at=(10.0, 20.0))
    sea = blown(pf.Ocean(), wind)
    assert (sea.wind_speed_m_s, sea.wind_direction_deg, tuple(sea.wind_at)) == (15.0, 200.0, (10.0, 20.0))
    own = blown(pf.Ocean(wind_speed_m_s=3.0, wind_direction_deg=10.0), wind)
    assert (own.wind_speed_m_s, own.wind_direction_deg, tuple(own.wind_at)) == (3.0, 10.0, (0.0, 0.0))
    assert blown(pf.Clouds(), wind).wind_speed_m_s == ALOFT * 15.0
    assert blown(pf.Clouds(wind_speed_m_s=40.0), wind).wind_speed_m_s == 40.0
    for component in (pf.Ocean(), pf.Clouds()):
        assert blown(component, None) is component
        assert blown(component, pf.Wind()) is component, "by default both are the same breeze"


def test_a_sampler_of_the_sea_feels_the_wind():
    heights = []
    for speed_m_s in (None, 2.0, 25.0):
        with pf.load_scene("earth") as scene:
            if speed_m_s is not None:
                scene.planet.add(pf.Wind(speed_m_s=speed_m_s))
            scene.planet[pf.Ocean].swell_height_m = 0.0
            sampler = pf.OceanSampler(scene)
            heights.append(float(np.std(sampler.height(direction(0.0, np.linspace(-140.0, -139.9, 400)), 0.0))))
    assert heights[1] < 0.5 * heights[0] < 0.25 * heights[2]


def test_a_scene_file_keeps_it(tmp_path):
    with pf.load_scene("earth") as scene:
        scene.planet.add(pf.Wind(speed_m_s=13.0, gusts=0.9))
        scene.save(tmp_path / "windy.toml")
    with pf.load_scene(tmp_path / "windy.toml") as again:
        assert (again.planet[pf.Wind].speed_m_s, again.planet[pf.Wind].gusts) == (13.0, 0.9)


@pytest.mark.parametrize("speed_m_s", [-1.0, 61.0, float("nan")])
def test_a_bad_speed_is_refused(speed_m_s):
    with pytest.raises(pf.SettingError, match=r"Wind\.speed_m_s"), pf.load_scene("earth") as scene:
        scene.planet.add(pf.Wind(speed_m_s=speed_m_s))


# -- pictures --------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def scene():
    with woods() as found:
        yield found


def shown(scene, *times_s, size=(240, 135)):
    overrides = {"cover.reach_m": 60.0, "composite.antialiasing": "none", "terrain.shade_every": 1}
    view, out = pf.view("meadow", scene.planet), []
    with pf.Renderer(scene, size=size, quality="low", overrides=overrides) as renderer:
        renderer.settle(view)
        for time_s in times_s:
            found = renderer.render(view, time_s=time_s, outputs=("radiance", "surface", "distance"))
            out.append({name: value.copy() for name, value in found.items()})
    return out


def test_grass_and_trees_move_and_nothing_else_does(scene):
    scene.planet[pf.Wind].speed_m_s = 12.0
    one, two = shown(scene, 0.0, 0.7)
    moved = np.abs(one["radiance"] / two["radiance"] - 1.0).max(axis=-1) > 0.02
    ground = one["surface"] == Surface.TERRAIN
    near, far = ground & (one["distance"] < 8.0), ground & (one["distance"] > 60.0)
    trees = (one["surface"] == Surface.COVER) & (two["surface"] == Surface.COVER) & (one["distance"] < 60.0)
    assert moved[near].mean() > 0.1 and moved[trees].mean() > 0.05
    # The shadows of trees stay where they are.
    assert (
        moved[far].mean() < 0.01
        and not moved[(one["surface"] == Surface.NONE) & (two["surface"] == Surface.NONE)].any()
    )


def test_without_wind_all_stands_still(scene):
    scene.planet[pf.Wind].speed_m_s = 0.0
    try:
        one, two = shown(scene, 0.0, 0.7)
    finally:
        scene.planet[pf.Wind].speed_m_s = 8.0
    land = np.isin(one["surface"], (Surface.TERRAIN, Surface.COVER))
    np.testing.assert_array_equal(one["radiance"][land], two["radiance"][land])
