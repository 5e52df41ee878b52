"""OceanSampler, and the waves of a scene: files, bad input, changes."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.reference.waves import displaced

WAVE = {"origin": (10.0, 20.0), "amplitude_m": 0.5, "wavelength_m": 40.0, "steepness": 0.6, "speed_rad_s": 1.2}


def sphere(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


@pytest.fixture(scope="module")
def earth():
    with pf.load_scene("earth") as scene:
        scene.planet[pf.Ocean].wave_count = 20
        yield scene


@pytest.fixture(scope="module")
def shores(earth):
    """Directions of water 0.1 to 30 m deep, and of land next to it."""
    start = pf.direction(3.17913, 143.61471)
    v = start + 4e-4 * sphere(4000, 3)
    v /= np.linalg.norm(v, axis=1)[:, None]
    ground = pf.TerrainSampler(earth).height(v)
    return v[(ground < -0.1) & (ground > -30.0)][:200], v[ground > 0.5][:50]


# -- the sea ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("time_s", [0.0, 3.3, 1e8])
def test_the_point_that_was_displaced_is_found_again(earth, shores, time_s):
    sampler = pf.OceanSampler(earth)
    for v in (sphere(300), shores[0]):
        place = v * (sampler.radius_m + sampler.sea_level_m) + sampler.displacement(v, time_s)
        there = np.linalg.norm(place, axis=1)
        found = sampler.height(place / there[:, None], time_s)
        # Where waves fold nothing, only this point of the calm sea comes there; found to 0.1 mm on slopes below 1.
        np.testing.assert_allclose(found, there - sampler.radius_m, atol=2e-4)


def test_heights_and_normals_belong_together(earth, shores):
    """The normal against differences of the height: a surface over directions, in shallow water as well."""
    sampler = pf.OceanSampler(earth)
    v = np.concatenate([sphere(80, 5), shores[0][:80]])
    step = 0.05 / sampler.radius_m
    east = np.cross([0.0, 0.0, 1.0], v)
    east /= np.linalg.norm(east, axis=1)[:, None]
    normal = sampler.normal(v, 7.7)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    for side in (east, np.cross(v, east)):
        ends = [v * math.cos(step) + s * side * math.sin(step) for s in (1.0, -1.0)]
        a, b = (d * (sampler.radius_m + sampler.height(d, 7.7))[:, None] for d in ends)
        along = (a - b) / np.linalg.norm(a - b, axis=1)[:, None]
        # 5 cm to either side on waves of 2 m and longer; heights are found to 0.1 mm on slopes of a few tenths.
        assert np.abs((normal * along).sum(axis=1)).max() < 2e-3


def test_the_sea_ends_at_the_shore(earth, shores):
    sampler = pf.OceanSampler(earth)
    shallow, land = shores
    assert len(shallow) > 100 and len(land) == 50
    depth = sampler.sea_level_m - pf.TerrainSampler(earth).height(shallow)
    height = np.stack([sampler.height(shallow, t) for t in np.linspace(0.0, 60.0, 30)])
    # In shallow water waves are as high as the sum of A tanh(k depth), and tanh(x) < x: no trough reaches the bed, as
    # the sum of A k is 0.5 here.
    waves = sampler.waves
    steep = float(np.sum(waves.amplitude_m * waves.wave_number_per_m))
    assert steep < 0.6
    assert (np.abs(height) < 0.6 * depth).all() and (depth < 2.0).sum() > 5
    assert np.abs(height[:, depth > 15.0]).max() > 0.4
    np.testing.assert_allclose(sampler.height(land, 3.0), 0.0, atol=1e-8)


@pytest.mark.parametrize(("radius", "time_s"), [(6e4, 0.0), (6.371e6, 1e8), (7e7, 1e8)])
def test_heights_against_extended_precision(radius, time_s):
    """Points of a bottomless sea, displaced by code of its own: the inversion promises 1 mm."""
    ocean = pf.Ocean(wave_count=20, wind_speed_m_s=12.0)
    sampler = pf.OceanSampler(SimpleNamespace(planet={pf.Planet: pf.Planet(radius_m=radius), pf.Ocean: ocean}))
    w = sampler.waves
    calm = sphere(4000, 9)
    away = np.arccos(np.clip(np.abs(calm @ w.origins.T), 0.0, 1.0))
    calm = calm[(away > w.fade_rad[:, 1]).all(axis=1)][:300]
    assert len(calm) > 50
    there = displaced(calm, w.origins, w.amplitude_m, w.wavelength_m, w.steepness, w.speed_rad_s, w.radius_m, time_s)
    distance = np.sqrt((there * there).sum(axis=1))
    found = sampler.height((there / distance[:, None]).astype(np.float64), time_s)
    assert np.abs(found - (distance - np.longdouble(radius))).max() < 1e-3


def test_times_and_a_snapshot(earth):
    sampler = pf.OceanSampler(earth)
    v = sphere(5)
    times = np.array([0.0, 1.0, 2.0, 1e6, 5.0])
    together = sampler.height(v, times)
    np.testing.assert_allclose(together, [sampler.height(d, t)[0] for d, t in zip(v, times, strict=True)], atol=1e-6)
    np.testing.assert_allclose(sampler.height(3e7 * v, times), together)
    assert sampler.height(np.zeros((0, 3)), 0.0).shape == (0,) and sampler.normal(np.zeros((0, 3)), 0.0).shape == (0, 3)
    before = sampler.height(v, 0.0)
    ocean = earth.planet[pf.Ocean]
    ocean.wind_speed_m_s = 3.0
    try:
        np.testing.assert_array_equal(sampler.height(v, 0.0), before)
        assert not np.allclose(pf.OceanSampler(earth).height(v, 0.0), before)
    finally:
        ocean.wind_speed_m_s = 8.0


def test_a_sea_without_ground_and_without_waves():
    scene = SimpleNamespace(planet={pf.Planet: pf.Planet(radius_m=1e6), pf.Ocean: pf.Ocean(sea_level_m=50.0)})
    sampler = pf.OceanSampler(scene)
    assert 0.05 < sampler.height(sphere(50), 0.0).std() < 1.0
    assert sampler.height(sphere(50), 0.0).mean() == pytest.approx(50.0, abs=0.3)
    scene.planet[pf.Ocean].wind_speed_m_s = scene.planet[pf.Ocean].swell_height_m = 0.0
    smooth = pf.OceanSampler(scene)
    np.testing.assert_allclose(smooth.height(sphere(50), 9.0), 50.0, atol=1e-8)
    np.testing.assert_allclose(smooth.normal(sphere(50), 9.0), sphere(50), atol=1e-15)


@pytest.mark.parametrize("method", ["paper_2018", "paper_2019"])
def test_printed_methods_are_sampled_as_such(method):
    ocean = pf.Ocean(waves=[pf.Wave(**WAVE)], method=method)
    sampler = pf.OceanSampler(SimpleNamespace(planet={pf.Planet: pf.Planet(), pf.Ocean: ocean}))
    v = sphere(40)
    place = v * sampler.radius_m + sampler.displacement(v, 2.0)
    there = np.linalg.norm(place, axis=1)
    found = sampler.height(place / there[:, None], 2.0)
    np.testing.assert_allclose(found, there - sampler.radius_m, atol=2e-4)


@pytest.mark.parametrize(
    ("directions", "time_s", "text"),
    [
        ([[0.0, 0.0, 0.0]], 0.0, r"directions\[0\]: expected a direction, found the zero vector"),
        ([[1.0, 0.0, 0.0], [math.nan, 0.0, 1.0]], 0.0, r"directions\[1\]: expected finite numbers"),
        ([1.0, 0.0], 0.0, r"directions: expected vectors of shape \(N, 3\)"),
        ([[1.0, 0.0, 0.0]], math.inf, "time_s: expected finite seconds, found inf"),
        (sphere(3), [0.0, 1.0], r"time_s: expected one number or 3, found shape \(2,\)"),
    ],
)
def test_bad_questions(earth, directions, time_s, text):
    sampler = pf.OceanSampler(earth)
    for ask in (sampler.height, sampler.normal, sampler.displacement):
        with pytest.raises(ValueError, match=text):
            ask(directions, time_s)


def test_no_sea():
    with (
        pf.load_scene("moon") as scene,
        pytest.raises(ValueError, match=r"no Ocean component; add one with scene\.plan"),
    ):
        pf.OceanSampler(scene)


# -- what a scene says ------------------------------------------------------------------------------------------------


def test_waves_of_a_file_and_back(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(
        'base = "earth"\n[ocean]\nwind_at = [10, -20]\nmethod = "paper_2019"\n'
        "[[ocean.waves]]\norigin = [10, 20]\namplitude_m = 0.5\nwavelength_m = 40\nsteepness = 0.6\nspeed_rad_s = 1.2\n"
        "[[ocean.waves]]\nwavelength_m = 90.5\n"
    )
    with pf.load_scene(path) as scene:
        ocean = scene.planet[pf.Ocean]
        assert ocean.waves == (pf.Wave(**WAVE), pf.Wave(wavelength_m=90.5)) and ocean.wind_at == (10.0, -20.0)
        assert ocean.waves[1].speed_rad_s is None and ocean.method == "paper_2019"
        scene.save(tmp_path / "again.toml")
        with pf.load_scene(tmp_path / "again.toml") as again:
            assert again.planet[pf.Ocean] == ocean
        assert len(pf.OceanSampler(scene).waves) == 2
        ocean.waves = []
        scene.save(tmp_path / "none.toml")
        with pf.load_scene(tmp_path / "none.toml") as none:
            assert none.planet[pf.Ocean].waves == () and len(pf.OceanSampler(none).waves) == ocean.wave_count


def test_waves_as_tables_in_python(earth):
    ocean = pf.Ocean()
    ocean.waves = [WAVE, pf.Wave()]
    assert ocean.waves[0] == pf.Wave(**WAVE)
    ocean.waves = [dict(WAVE, origin=np.array([1.0, 2.0]), amplitude_m=np.float32(0.25))]
    assert ocean.waves[0].origin == (1.0, 2.0) and ocean.waves[0].amplitude_m == 0.25


@pytest.mark.parametrize(
    ("field", "value", "text"),
    [
        ("wind_speed_m_s", -1.0, r"Ocean\.wind_speed_m_s: expected a number from 0 to 60 m/s, found -1"),
        ("wind_speed_m_s", math.nan, r"Ocean\.wind_speed_m_s: .* found nan\. Give a finite number"),
        ("fetch_m", 0.0, r"Ocean\.fetch_m: expected a number from 100"),
        ("wave_count", 1001, r"Ocean\.wave_count: expected a whole number from 1 to 1000, found 1001"),
        ("wave_count", 0, r"Ocean\.wave_count: .* found 0\. The nearest allowed value is 1"),
        ("wind_at", (91.0, 0.0), r"Ocean\.wind_at: expected a latitude from -90 to 90 and a longitude .* found \(91"),
        ("wind_at", (0.0, math.nan), r"Ocean\.wind_at: .* Give finite numbers"),
        ("wind_at", 3.0, r"Ocean\.wind_at: expected a latitude"),
        ("method", "paper", r"Ocean\.method: .*did you mean 'paper_201"),
        ("waves", 3, r"Ocean\.waves: expected 0 to 1000 tables with origin, .* found 3\. Give a list of tables"),
        ("waves", [3], r"Ocean\.waves\[0\]: expected a table with origin, amplitude_m, .*, found 3"),
        ("waves", [WAVE] * 1001, r"Ocean\.waves: expected 0 to 1000 waves, found 1001"),
        ("waves", [WAVE, dict(WAVE, amplitude_m=-1)], r"Ocean\.waves\[1\]\.amplitude_m: expected a number from 0"),
        ("waves", [dict(WAVE, amplitude_m=math.nan)], r"Ocean\.waves\[0\]\.amplitude_m: .* found nan"),
        ("waves", [dict(WAVE, wavelength_m=0)], r"Ocean\.waves\[0\]\.wavelength_m: expected a number from 0.01"),
        ("waves", [dict(WAVE, wavelength_m=-5.0)], r"wavelength_m: .* found -5"),
        ("waves", [dict(WAVE, steepness=-0.1)], r"Ocean\.waves\[0\]\.steepness"),
        ("waves", [dict(WAVE, speed_rad_s=math.inf)], r"Ocean\.waves\[0\]\.speed_rad_s: .* found inf"),
        ("waves", [dict(WAVE, origin=(100.0, 0.0))], r"Ocean\.waves\[0\]\.origin: expected a latitude from -90 to 90"),
        (
            "waves",
            [dict(WAVE, wavelenght_m=3)],
            r"waves\[0\] has no setting 'wavelenght_m'; did you mean 'wavelength_m'",
        ),
        ("waves", [pf.Wave(wavelength_m=-1.0)], r"Ocean\.waves\[0\]\.wavelength_m"),
        ("waves", [dict(WAVE, steepness=20.0)], r"is 1\.570\d+, and above 1 .* Multiply all steepness by 0\.636"),
        ("waves", [dict(WAVE, steepness=6.4)] * 3, r"Ocean\.waves: the sum of steepness x amplitude_m"),
    ],
)
def test_bad_waves_are_refused_where_they_are_assigned(field, value, text):
    ocean = pf.Ocean()
    with pytest.raises(pf.SettingError, match=text):
        setattr(ocean, field, value)
    assert getattr(ocean, field) == getattr(pf.Ocean(), field)
    with pytest.raises(pf.SettingError, match=text):
        pf.Ocean(**{field: value})


def test_bad_waves_in_a_file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text("[ocean]\nwave_count = 2000\n[[ocean.waves]]\namplitude_m = nan\n")
    with pytest.raises(pf.PresetError) as info:
        pf.load_scene(path)
    assert "ocean.wave_count: expected a whole number from 1 to 1000, found 2000" in str(info.value)
    assert "ocean.waves[0].amplitude_m: expected a number from 0 to 10000 m, found nan" in str(info.value)
    path.write_text("[[ocean.waves]]\nsteepness = 30.0\n")
    with pytest.raises(pf.PresetError, match=r"ocean\.waves: the sum of steepness"):
        pf.load_scene(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[ocean]\nsea_level_m = 70000\n[atmosphere]\nthickness_m = 60000\n",
         r"Ocean\.sea_level_m \(70000\) is above the top of the air, Atmosphere\.thickness_m \(60000\)"),
        ("[planet]\nradius_m = 1000\n[[ocean.waves]]\nwavelength_m = 5000.0\n", r"at most the radius of the sea, 1000"),
        ("[planet]\nradius_m = 1000\n[[ocean.waves]]\nwavelength_m = 500.0\namplitude_m = 300\nsteepness = 0.0\n",
         r"expected 100 m at most of all waves together"),
    ],
)  # fmt: skip
def test_a_sea_that_does_not_fit_its_planet(tmp_path, text, message):
    path = tmp_path / "my.toml"
    path.write_text(text)
    with pytest.raises(pf.SceneError, match=message):
        pf.load_scene(path)
