"""Cameras: places, axes, off-axis frusta, what belongs to which scene, and refused input."""

import math

import numpy as np
import pytest

import planetfall as pf


def test_a_camera_over_a_place():
    with pf.load_scene("moon") as scene:
        camera = pf.Camera.at(0.0, 90.0, 1000.0, planet=scene.planet)
        np.testing.assert_allclose(camera.position_m, [0, scene.planet.radius_m + 1000.0, 0], atol=1e-6)
        np.testing.assert_allclose(camera.forward, [0, 0, 1], atol=1e-15)  # heading 0 is north
        np.testing.assert_allclose(camera.up, [0, 1, 0], atol=1e-15)
        east = pf.Camera.at(0.0, 90.0, 1000.0, heading_deg=90.0)
        np.testing.assert_allclose(east.forward, [-1, 0, 0], atol=1e-15)
        down = pf.Camera.at(10.0, 20.0, 5.0, pitch_deg=-90.0)
        np.testing.assert_allclose(down.forward, -pf.direction(10.0, 20.0), atol=1e-15)


def test_at_a_pole_heading_is_a_longitude():
    camera = pf.Camera.at(90.0, 77.0, 10.0, heading_deg=90.0)
    np.testing.assert_allclose(camera.forward, [0, 1, 0], atol=1e-15)


def test_position_and_axes():
    free = pf.Camera(position_m=(7e6, 0, 0), forward=(-2, 0, 0.5), up=(0, 0, 3))
    assert free.forward @ free.up == pytest.approx(0.0, abs=1e-15)
    assert np.linalg.norm(free.forward) == pytest.approx(1.0) and np.linalg.norm(free.up) == pytest.approx(1.0)
    assert free.position_m.tolist() == [7e6, 0, 0]
    free.position_m[0] = 0.0
    assert free.position_m[0] == 7e6


@pytest.mark.parametrize("above", ["sphere", "ground"])
def test_a_place_without_a_planet_is_nowhere_yet(above):
    camera = pf.Camera.at(0.0, 0.0, 2.0, above=above)
    assert camera.up.tolist() == [1, 0, 0]  # the same over every planet
    with pf.load_scene("moon") as scene:
        for unknown in (camera, pf.Camera.at(0.0, 0.0, 2.0, above=above, planet="moon"), pf.view("orbit")):
            with pytest.raises(pf.CameraError, match=r"no position yet; ask camera\.resolve\(scene\)\.position_m"):
                unknown.position_m
            assert np.isfinite(unknown.resolve(scene).position_m).all()
        assert np.isfinite(pf.view("orbit", scene.planet).position_m).all()


def test_a_camera_cannot_be_changed():
    camera = pf.Camera.at(0.0, 0.0, 2.0)
    for fixed in (camera, pf.view("orbit"), pf.Camera((7e6, 0, 0), (0, 1, 0), (0, 0, 1))):
        for name in ("planet", "fov_y_deg", "frustum_deg", "ev100", "position_m", "name", "_optics", "anything"):
            with pytest.raises(AttributeError, match=rf"can't be changed, and '{name}' was assigned; make a new one"):
                setattr(fixed, name, 1.0)
    with pytest.raises(AttributeError, match="'name' was deleted"):
        del fixed.name
    assert camera.exposed(12.0).ev100 == 12.0 and camera.ev100 is None
    shown = pf.view("orbit", "earth")
    assert shown.exposed(12.0).ev100 == 12.0 and shown.ev100 != 12.0 and shown.exposed(12.0).time_s == shown.time_s


def test_above_ground_is_above_the_higher_of_land_and_sea(monkeypatch):
    class Bumpy:
        highest_m, lowest_m = 500.0, -500.0

        def height(self, directions):
            return 400.0 * np.asarray(directions)[:, 0]

    with pf.load_scene("earth") as scene:
        monkeypatch.setattr(scene, "height_field", lambda planet=None: Bumpy())
        radius = scene.planet.radius_m

        def altitude(longitude, altitude_m=2.0):
            camera = pf.Camera.at(0.0, longitude, altitude_m, above="ground", planet=scene.planet)
            return np.linalg.norm(camera.position_m) - radius

        assert altitude(0.0) == pytest.approx(402.0, abs=1e-6)
        assert altitude(180.0) == pytest.approx(2.0, abs=1e-6)  # the sea bed is at -400 m, the sea at 0
        assert altitude(180.0, -5.0) == pytest.approx(-5.0, abs=1e-6)
        scene.planet.remove(pf.Ocean)
        assert altitude(180.0) == pytest.approx(-398.0, abs=1e-6)


def test_the_planet_of_the_scene_it_is_rendered_in_counts():
    camera = pf.Camera.at(0.0, 0.0, 100.0)
    with pf.load_scene("moon") as moon, pf.load_scene("small") as small:
        assert camera.resolve(moon).position_m[0] == moon.planet.radius_m + 100.0
        assert camera.resolve(small).position_m[0] == small.planet.radius_m + 100.0
        with pytest.raises(pf.CameraError, match="belongs to planet 'moon' of another scene"):
            pf.Camera.at(0, 0, 1, planet=moon.planet).resolve(small)
        named = pf.Camera.at(0, 0, 1, planet="small")
        assert named.resolve(small).position_m[0] == small.planet.radius_m + 1.0
        with pytest.raises(pf.UnknownNameError, match="the scene has no planet 'small'; its planets: moon"):
            named.resolve(moon)


def test_a_change_of_the_planet_moves_the_camera():
    with pf.load_scene("small") as scene:
        camera = pf.Camera.at(0.0, 0.0, 100.0, planet=scene.planet)
        scene.planet.planet.radius_m = 7e4
        assert camera.position_m[0] == 7.01e4


def test_frusta():
    with pf.load_scene("moon") as scene:
        state = pf.Camera.at(0, 0, 10, fov_y_deg=90.0).resolve(scene, aspect=2.0)
        assert (state.tan_left, state.tan_right) == pytest.approx((-2.0, 2.0))
        assert (state.tan_bottom, state.tan_top) == pytest.approx((-1.0, 1.0))
        tile = pf.Camera.at(0, 0, 10, frustum_deg=(0.0, 45.0, -45.0, 10.0)).resolve(scene)
        tangents = (tile.tan_left, tile.tan_right, tile.tan_bottom, tile.tan_top)
        assert tangents == pytest.approx((0.0, 1.0, -1.0, math.tan(math.radians(10.0))))


def test_up_along_forward_falls_back():
    with pf.load_scene("moon") as scene:
        for forward in ((0, 0, -1), (0, 0, 1)):
            camera = pf.Camera(position_m=(0, 0, 2e6), forward=forward, up=(0, 0, 1))
            state = camera.resolve(scene)
            assert np.all(np.isfinite(state.up)) and abs(state.up @ state.forward) < 1e-12
            np.testing.assert_array_equal(state.up, camera.up)


NAN = math.nan


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: pf.Camera.at(NAN, 0, 1), r"latitude_deg: expected a number from -90 to 90, found nan"),
        (lambda: pf.Camera.at(91, 0, 1), r"latitude_deg: expected a number from -90 to 90, found 91"),
        (lambda: pf.Camera.at(0, math.inf, 1), r"longitude_deg: expected a number, found inf"),
        (lambda: pf.Camera.at(0, 0, "high"), r"altitude_m: expected a number, found 'high'"),
        (lambda: pf.Camera.at(0, 0, 1, pitch_deg=100), r"pitch_deg: expected a number from -90 to 90, found 100"),
        (lambda: pf.Camera.at(0, 0, 1, fov_y_deg=0), r"fov_y_deg: expected a number from 0\.001 to 179, found 0"),
        (lambda: pf.Camera.at(0, 0, 1, above="sea"), r"above: expected 'sphere' or 'ground', found 'sea'"),
        (lambda: pf.Camera.at(0, 0, 1, planet=3), r"planet: expected a name, scene\.planet or None, found 3"),
        (lambda: pf.Camera((NAN, 0, 0), (1, 0, 0), (0, 0, 1)), r"position_m: expected three finite numbers"),
        (lambda: pf.Camera((0, 0, 0), (1, 0, 0), (0, 0, 1)), r"position_m: .*the planet's centre has no up"),
        (lambda: pf.Camera((1, 0, 0), (0, 0, 0), (0, 0, 1)), r"forward: expected a vector other than zero, found \(0,"),
        (lambda: pf.Camera((1, 0, 0), (1, 0, 0), (0, 0, 0)), r"up: expected a vector other than zero"),
        (lambda: pf.Camera((1, 0), (1, 0, 0), (0, 0, 1)), r"position_m: expected three numbers .*, found \(1, 0\)"),
        (lambda: pf.Camera("abc", (1, 0, 0), (0, 0, 1)), r"position_m: expected three numbers"),
        (lambda: pf.Camera.at(0, 0, 1, frustum_deg=(1, 0, 0, 1)), r"expected left < right and bottom < top"),
        (lambda: pf.Camera.at(0, 0, 1, frustum_deg=(0, 1, 0)), r"frustum_deg: expected \(left, right, bottom, top\)"),
        (lambda: pf.Camera.at(0, 0, 1, frustum_deg=(0, 90, 0, 1)), r"right: expected an angle from -89\.5 to 89\.5"),
        (lambda: pf.Camera.at(0, 0, 1, frustum_deg=(0, NAN, 0, 1)), r"right: expected an angle .* found nan"),
    ],
)  # fmt: skip
def test_refused_input(make, message):
    with pytest.raises(pf.CameraError, match=message):
        make()


def test_below_the_planets_centre():
    with pf.load_scene("asteroid") as scene:
        camera = pf.Camera.at(0, 0, -2000.0)
        with pytest.raises(
            pf.CameraError, match=r"altitude_m: expected more than -1000 m \(the planet's centre\), found -2000"
        ):
            camera.resolve(scene)


def test_repr_says_what_it_is():
    assert repr(pf.Camera.at(1, 2, 3, above="ground")) == (
        "Camera.at(1, 2, 3, heading_deg=0, pitch_deg=0, fov_y_deg=60, above='ground')"
    )
    assert repr(pf.Camera((7e6, 0, 0), (0, 1, 0), (0, 0, 1))).startswith("Camera(position_m=[7000000.0, 0.0, 0.0]")
