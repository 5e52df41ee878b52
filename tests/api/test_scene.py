"""Scenes: presets, files, handles and named views; everything is checked before a GPU is needed."""

import gc
import subprocess
import sys
import weakref

import pytest

import planetfall as pf
from planetfall.camera.views import view_entries
from planetfall.engine.settings import revision
from planetfall.scene.kinds import PRESETS

PLANETS = ["asteroid", "earth", "hazy", "mars", "moon", "small"]
VIEWS = [
    "space",
    "limb",
    "orbit",
    "high",
    "clouds",
    "fair",
    "overcast",
    "cloud_sea",
    "shafts",
    "cloud_shadows",
    "day_edge",
    "coast",
    "near",
    "valley",
    "ground",
    "beach",
    "sea",
    "dusk",
    "night",
    "pole",
    "terminator",
    "under",
    "noon",
    "sunset",
    "dawn",
    "edge",
    "glint",
    "glitter",
    "shallows",
    "waterline",
    "moonrise",
    "earthrise",
    "phobos",
    "river",
    "lake",
    "lakeside",
    "mangroves",
    "delta",
    "canyon",
    "ranges",
    "waterfall",
    "forest",
    "meadow",
    "savanna",
    "desert",
    "palms",
    "treeline",
    "canopy",
    "grove",
    "woodland",
]


@pytest.fixture
def earth():
    with pf.load_scene("earth") as scene:
        yield scene


# -- what there is ----------------------------------------------------------------------------------------------------


def test_planets():
    assert pf.planets() == PLANETS
    for name in PLANETS:
        with pf.load_scene(name) as scene:
            assert scene.name == scene.preset == name and scene.about
            assert scene.planet is scene.planets[name]
            assert scene.planet.has(pf.Terrain) and list(scene.planets) == [name]


def test_a_scene_is_a_world(earth):
    assert [e for e, _ in earth.world.query(pf.Planet, pf.Terrain)] == [earth.planet.entity]
    assert len(earth.world.query(pf.Sun)) == 1
    assert earth.planet[pf.Ocean].sea_level_m == 0.0
    assert earth.planet.radius_m == 6.371e6 and earth.planet.planet is earth.planet[pf.Planet]
    assert pf.Ocean in earth.planet and pf.Sun not in earth.planet
    assert "Planet, Terrain, Ocean" in repr(earth.planet)


def test_components_come_and_go(earth):
    before = earth.world.structure_revision
    taken = earth.planet.remove(pf.Ocean)
    assert isinstance(taken, pf.Ocean) and not earth.planet.has(pf.Ocean)
    assert earth.world.structure_revision > before
    with pytest.raises(
        pf.MissingError, match=r"planet 'earth' has no Ocean, only Planet, Terrain, Atmosphere, Cover; add one with add"
    ):
        earth.planet[pf.Ocean]
    with pytest.raises(pf.MissingError, match="has no Ocean"):
        earth.planet.remove(pf.Ocean)
    assert earth.planet.add(pf.Ocean(sea_level_m=5.0)).sea_level_m == 5.0
    with pytest.raises(TypeError, match=r"write Ocean\(\)"):
        earth.planet.add(pf.Ocean)
    with pytest.raises(pf.SceneError, match="can't be without its Planet"):
        earth.planet.remove(pf.Planet)


def test_each_component_has_its_place(earth):
    with pytest.raises(pf.SceneError, match=r"Sun belongs to the scene, not to a planet; assign scene\.sun"):
        earth.planet.add(pf.Sun())
    with pytest.raises(pf.SceneError, match=r"Ocean belongs to a planet; add it with scene\.planet\.add"):
        earth.environment.add(pf.Ocean())
    with pytest.raises(pf.MissingError, match=r"it belongs to the scene: scene\.environment\[pf\.Stars\]"):
        earth.planet[pf.Stars]


def test_the_sun(earth):
    old = revision(earth.sun)
    earth.sun = pf.Sun(direction=(0, 1, 0))
    assert earth.sun.mode == "direction" and revision(earth.sun) != old
    with pytest.raises(
        pf.SceneError, match=r"expected a pf\.Sun, found \(1, 0, 0\)\. Write scene\.sun = pf\.Sun\(direction"
    ):
        earth.sun = (1, 0, 0)
    with pytest.raises(pf.SettingError, match=r"Sun\.elevation_deg: expected a number from -90 to 90 deg"):
        earth.sun.elevation_deg = 91.0


# -- names and files --------------------------------------------------------------------------------------------------


def test_unknown_names():
    with pytest.raises(pf.UnknownNameError) as info:
        pf.load_scene("erth")
    assert str(info.value) == (
        "no planet 'erth'; did you mean 'earth'? planets: asteroid, earth, earth_moon, hazy, mars, mars_moons, moon, "
        "small, woods. A path to a TOML file works as well"
    )
    with pytest.raises(pf.PresetError, match=r"nix\.toml: no such file"):
        pf.load_scene("nix.toml")
    with pytest.raises(pf.UnknownNameError, match="the name is empty; planets: asteroid"):
        pf.load_scene("")
    with pytest.raises(pf.UnknownNameError, match="expected the name of a planet or a path, found 3"):
        pf.load_scene(3)
    with (
        pf.load_scene("moon") as scene,
        pytest.raises(pf.UnknownNameError, match="has no planet 'mon'; did you mean 'moon'"),
    ):
        scene.planets["mon"]


def test_save_and_load_are_equal(tmp_path, earth):
    earth.planet[pf.Ocean].sea_level_m = 12.5
    earth.planet[pf.Terrain].layers = 3
    earth.sun = pf.Sun(epoch_s=3e8, calendar="earth")
    earth.environment.remove(pf.Stars)
    path = tmp_path / "mine.toml"
    earth.save(path)
    with pf.load_scene(path) as again, pf.load_scene(str(path)) as by_text:
        assert again.planet.components() == earth.planet.components() == by_text.planet.components()
        assert {type(c): c for c in again.environment.components()} == {
            type(c): c for c in earth.environment.components()
        }
        assert (again.name, again.about, again.preset) == (earth.name, earth.about, "earth")
    with pytest.raises(pf.PresetError, match="doesn't exist; make it first"):
        earth.save(tmp_path / "none" / "x.toml")


def test_a_file_may_stand_on_a_base(tmp_path):
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text('base = "mars"\n[terrain]\nseed = 9\n[sun]\ndirection = [1, 0, 0]\n[Ocean]\nsea_level_m = -3000\n')
    second.write_text('base = "first.toml"\nname = "wet"\n[ocean]\nroughness = 0.5\n')
    with pf.load_scene("mars") as mars, pf.load_scene(second) as scene:
        assert scene.name == "wet" and scene.preset == "mars"
        assert scene.planet.planet == mars.planet.planet
        assert scene.planet[pf.Terrain].seed == 9
        assert scene.planet[pf.Terrain].highest_m == mars.planet[pf.Terrain].highest_m
        assert scene.planet[pf.Ocean] == pf.Ocean(sea_level_m=-3000.0, roughness=0.5)
        assert scene.sun.mode == "direction" and scene.sun.irradiance == mars.sun.irradiance
    first.write_text('base = "second.toml"\n')
    with pytest.raises(pf.PresetError, match="base: goes round in a circle"):
        pf.load_scene(second)
    first.write_text('base = "marz"\n')
    with pytest.raises(pf.PresetError, match=r"first\.toml: base: no planet 'marz'; did you mean 'mars'"):
        pf.load_scene(first)
    first.write_text("base = 3\n")
    with pytest.raises(pf.PresetError, match=r"base: expected a text, found 3\. Put it in quotes"):
        pf.load_scene(first)


def test_an_almost_empty_file_is_a_scene(tmp_path):
    path = tmp_path / "bare.toml"
    path.write_text("[planet]\nradius_m = 1000\n")
    with pf.load_scene(path) as scene:
        assert scene.planet.components() == (pf.Planet(radius_m=1000.0),)
        assert scene.preset is None and scene.name == "bare"
        assert {type(c) for c in scene.environment.components()} == {pf.Sun, pf.Exposure, pf.Composite}
        assert scene.planet.ground_height_m([[1, 0, 0]]) == [0.0]
        scene.planet.add(pf.Ocean(sea_level_m=7.0))
        assert scene.planet.surface_height_m([[1, 0, 0], [0, 1, 0]]).tolist() == [7.0, 7.0]


def test_parts_that_do_not_fit_together(tmp_path):
    path = tmp_path / "odd.toml"
    path.write_text(
        "[planet]\nradius_m = 1000\n[terrain]\nhighest_m = 100\nlowest_m = 500\n[ocean]\nsea_level_m = 400\n"
        "[exposure]\nmin_ev100 = 5\nmax_ev100 = 2\n"
    )
    with pytest.raises(pf.SceneError) as info:
        pf.load_scene(path)
    text = str(info.value)
    assert text.startswith(f"{path}: scene 'odd': ")
    assert "Terrain.lowest_m (500) has to be below highest_m (100)" in text
    assert "Terrain.lowest_m (500) is more than a quarter of Planet.radius_m (1000); use at most 250" in text
    assert "Ocean.sea_level_m (400) is more than a quarter of" in text
    assert "Exposure.min_ev100 (5) is above max_ev100 (2)" in text
    with pf.load_scene("moon") as scene:
        scene.planet[pf.Terrain].lowest_m = 15000.0
        with pytest.raises(pf.SceneError, match="has to be below highest_m"):
            scene.save(tmp_path / "no.toml")
        assert not (tmp_path / "no.toml").exists()


def test_a_games_own_component_is_not_saved_but_said(tmp_path, earth, caplog):
    class Fuel:
        pass

    earth.planet.add(Fuel())
    earth.save(tmp_path / "x.toml")
    assert "not saved, as scene files don't know these components: Fuel" in caplog.text


def test_forgotten_scenes_are_freed():
    found = weakref.ref(pf.load_scene("moon"))
    gc.collect()
    assert found() is None


# -- views ------------------------------------------------------------------------------------------------------------


def test_view_names():
    assert pf.views() == list(VIEWS)
    assert "clouds" not in pf.views("mars") and {"clouds", "beach"} <= set(pf.views("earth"))
    for dry in ("mars", "moon", "asteroid"):
        assert not {"coast", "beach", "sea", "under", "glint", "glitter", "shallows", "waterline"} & set(pf.views(dry))
    assert "high" not in pf.views("asteroid")
    with pf.load_scene("earth") as scene:
        scene.planet.remove(pf.Ocean)
        assert "sea" not in pf.views(scene.planet) and "sea" not in pf.views(scene)


def test_view_errors():
    with pytest.raises(pf.UnknownNameError, match="no view 'vally'; did you mean 'valley'\\?"):
        pf.view("vally")
    with pytest.raises(pf.UnknownNameError, match=r"no view 'sea' of planet 'moon': it needs ocean\. Its views: space"):
        pf.view("sea", planet="moon")
    with pytest.raises(pf.UnknownNameError, match="it needs a radius of at least 50000 m"):
        pf.view("high", planet="asteroid")
    with pytest.raises(pf.UnknownNameError, match="no planet 'mond'; did you mean 'moon'"):
        pf.view("near", planet="mond")


@pytest.mark.parametrize("name", VIEWS)
def test_every_view_has_camera_sun_time_and_exposure(name, earth):
    view = pf.view(name)
    assert isinstance(view, pf.Camera) and view.camera is view and view.about
    assert view.time_s >= 0.0 and -10.0 < view.ev100 < 20.0
    sun = view.sun
    assert sun is not None and sun.irradiance == earth.sun.irradiance
    for vector in (view.forward, view.up):
        assert vector @ vector == pytest.approx(1.0)


def test_views_follow_the_scene_they_are_used_in(tmp_path):
    view = pf.view("orbit")
    with pf.load_scene("earth") as earth, pf.load_scene("mars") as mars:
        for scene in (earth, mars, earth):
            state = view.resolve(scene, 2.0)
            scale = scene.planet.radius_m / 6.371e6
            assert state.altitude_m(scene.planet.radius_m) == pytest.approx(2.0e6 * scale)
            for placed in (view.in_scene(scene), pf.view("orbit", scene.planet).in_scene(scene)):
                assert placed.sun.irradiance == scene.sun.irradiance
                assert (placed.pose.position_m == state.position_m).all() and placed.time_s is not None
            assert (pf.view("orbit", scene.planet).position_m == state.position_m).all()


def test_views_file_with_mistakes(tmp_path):
    path = tmp_path / "views.toml"
    path.write_text(
        '[view.a]\nlatitude = 3\nfov_y_deg = 500\nneeds = ["ozean"]\n[view.a.planet.marz]\nabove = "sea"\n[viw.b]\n'
    )
    with pytest.raises(pf.PresetError) as info:
        view_entries(path)
    text = str(info.value)
    assert text.startswith(f"{path}: ")
    assert "view.a.latitude: unknown key; did you mean 'latitude_deg'?" in text
    assert "view.a.fov_y_deg: expected a number from 1 to 170 deg, found 500" in text
    assert "view.a.needs: did you mean 'ocean'?" in text
    assert "view.a.planet.marz: no such planet preset; did you mean 'mars'?" in text
    assert "view.a.planet.marz.above: expected one of 'sphere', 'ground', found 'sea'" in text
    assert "viw: unknown key" in text


def test_reading_presets_needs_no_gpu_package():
    code = (
        "import sys, planetfall as pf; s = pf.load_scene('earth'); pf.view('orbit').resolve(s); "
        "bad = {m.split('.')[0] for m in sys.modules} & {'moderngl', 'glfw', 'pyglet', 'imgui_bundle', 'PIL'}; "
        "sys.exit(str(bad) if bad else 0)"
    )
    result = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr


def test_presets_lie_where_they_should():
    assert (PRESETS / "planets" / "earth.toml").is_file() and (PRESETS / "views.toml").is_file()
