"""Several planets in one scene: what can be wrong with them, where they are, and what is seen of them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from types import SimpleNamespace

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.space import CameraState, ray_sphere_from
from planetfall.render.discs import SPOT_BELOW_PX, disc_bounds, part_of
from planetfall.scene.companions import Body, bodies, nearest

DISTANCE_M = 3.844e8
MOON_M = 1.7374e6
SIZE = (160, 90)
EXPOSURE = 13.0


def bare_scene() -> pf.Scene:
    """Two globes of rock, without what takes long to make."""
    ground = pf.Terrain(highest_m=8000.0, lowest_m=-8000.0, layers=6, land_share=0.5)
    scene = pf.Scene("earth", {"planet": pf.Planet(), "terrain": ground, "stars": pf.Stars()}, preset="earth")
    moon = pf.Scene("moon", {"planet": pf.Planet(radius_m=MOON_M), "terrain": dataclasses.replace(ground, seed=7)})
    scene.companions.add(moon, pf.Orbit(distance_m=DISTANCE_M, period_s=0.0))
    return scene


@pytest.fixture(scope="module")
def scene() -> Iterator[pf.Scene]:
    with bare_scene() as made:
        yield made


@pytest.fixture(scope="module")
def renderer(scene: pf.Scene) -> Iterator[pf.Renderer]:
    # Blocks of pixels lie elsewhere in a part's own picture.
    with pf.Renderer(scene, SIZE, "low", {"composite.antialiasing": "none", "terrain.shade_every": 1}) as made:
        yield made


@pytest.fixture(scope="module")
def earth_moon() -> Iterator[tuple[pf.Scene, pf.Renderer]]:
    """The preset, with sea and air and without clouds, for the slow tests."""
    scene = pf.load_scene("earth_moon")
    scene.planet.remove(pf.Clouds)
    # Blocks of pixels lie elsewhere in a part's own picture.
    each = dict.fromkeys(("terrain.shade_every", "ocean.shade_every", "terrain.coast_px"), 1)
    with scene, pf.Renderer(scene, SIZE, "low", {"composite.antialiasing": "none", **each}) as renderer:
        yield scene, renderer


def towards(scene: pf.Scene, fov_y_deg: float, from_m: float = 1e7, **also: object) -> pf.Camera:
    """The Moon in the middle, from so far from Earth's centre."""
    moon = bodies(scene, 0.0)[1].centre_m
    ahead = moon / np.linalg.norm(moon)
    return pf.Camera(ahead * from_m, ahead, (0.0, 0.0, 1.0), fov_y_deg, ev100=EXPOSURE, **also)


@pytest.mark.parametrize("base", ["moon", "earth"])
def test_companions_have_names_of_their_own(base):
    """Another name than the preset's, which may be that of the scene's own planet."""
    with pf.load_scene("earth") as scene:
        scene.planet[pf.Terrain].rivers = 0.0
        companion = scene.companions.add(base, pf.Orbit(distance_m=3.844e8), name="two")
        assert companion.scene.planet.name == "two" and list(scene.planets) == ["earth", "two"]
        assert list(companion.scene.planets) == ["two"]
        companion.scene.add(pf.Transform((0.0, 0.0, 0.0), planet="two"))
        sun = pf.Sun(elevation_deg=30.0, latitude_deg=8.0, longitude_deg=-75.0)
        camera = pf.Camera.at(8.0, -75.0, 6000.0, pitch_deg=-90.0, above="ground", planet="two")
        with pf.Renderer(scene, (16, 9), "low") as renderer:
            renderer.snapshot(camera, sun=sun)
            assert renderer.main == "two"


# -- what can be wrong ------------------------------------------------------------------------------------------------


def test_what_cannot_be():
    with pf.load_scene("earth") as scene:
        twin = pf.Scene("moon", {"planet": pf.Planet(radius_m=MOON_M)})
        scene.companions.add(pf.Scene("moon", {"planet": pf.Planet(radius_m=MOON_M)}))
        with pytest.raises(pf.SettingError, match=r"has a planet of that name \(earth, moon\); give another"):
            scene.companions.add(twin)
        with pytest.raises(pf.SettingError, match=r"'moon' and 'twin' are inside each other: .* are 0 m apart"):
            scene.companions.add(twin, name="twin")
        with pytest.raises(pf.SettingError, match="'earth' and 'near' are inside each other"):
            scene.companions.add(twin, pf.Orbit(distance_m=8e6), name="near")
        with pytest.raises(pf.SettingError, match=r"Orbit\.distance_m: expected a number .*, found nan"):
            pf.Orbit(distance_m=math.nan)
        with pytest.raises(pf.SettingError, match=r"Orbit\.position_m: .*inf"):
            pf.Orbit(position_m=(0.0, math.inf, 0.0))
        with pytest.raises(pf.SettingError, match="no planet 'mon'; did you mean 'moon'"):
            scene.companions.add("mon", name="other")
        with pytest.raises(pf.SettingError, match="its scene is in use already"):
            scene.companions.add(scene, name="itself")
        with pytest.raises(pf.SettingError, match="companions have no companions"):
            scene.companions["moon"].scene.companions.add("asteroid")
        with pytest.raises(pf.SettingError, match="has no companion 'mon'; did you mean 'moon'"):
            scene.companions.remove("mon")
        assert list(scene.planets) == ["earth", "moon"]
        scene.companions["moon"].orbit.distance_m = 7e6
        with pytest.raises(pf.SettingError, match="inside each other"):
            scene.validate()
        scene.companions.remove("moon")
        assert list(scene.planets) == ["earth"] and not scene.companions


@pytest.mark.parametrize(
    ("entry", "said"),
    [
        ('name = "m"', r"companions\[0\]: base: missing; name a preset"),
        ('base = "mon"', r"companions\[0\]: base: no planet 'mon'; did you mean 'moon'"),
        ('base = 3', r"companions\[0\]: base: expected a text, found 3"),
        ('base = "earth_moon"', r"companions\[0\]: base: 'earth_moon' has companions itself"),
        ('base = "moon"\n[companions.orbit]\ndistance = 4e8', "distance: unknown key; did you mean 'distance_m'"),
        ('base = "moon"\n[companions.sun]\n', r"companions\[0\]: sun: unknown table"),
        ('base = "moon"\n[companions.orbit]\ndistance_m = 7e6', "inside each other"),
    ],
)  # fmt: skip
def test_files_that_cannot_be(tmp_path, entry, said):
    file = tmp_path / "scene.toml"
    file.write_text(f'base = "earth"\n[[companions]]\n{entry}\n')
    with pytest.raises(pf.SettingError, match=said):
        pf.load_scene(file)


def test_saved_and_loaded(tmp_path):
    with pf.load_scene("mars_moons") as scene:
        scene.companions["phobos"].orbit.phase_deg = 77.0
        scene.companions["deimos"].scene.planet[pf.Terrain].seed = 99
        scene.save(tmp_path / "again.toml")
        with pf.load_scene(tmp_path / "again.toml") as again:
            assert list(again.planets) == ["mars", "phobos", "deimos"]
            for name, companion in scene.companions.items():
                other = again.companions[name]
                assert other.orbit == companion.orbit
                assert other.scene.planet.components() == companion.scene.planet.components()


# -- where they are ---------------------------------------------------------------------------------------------------


def test_a_circle_and_its_locked_face(scene):
    orbit = scene.companions["moon"].orbit
    before = dict(vars(orbit))
    try:
        orbit.period_s, orbit.inclination_deg, orbit.node_deg, orbit.phase_deg = 1000.0, 30.0, 40.0, 0.0
        found = np.array([bodies(scene, t)[1].centre_m for t in np.linspace(0.0, 1000.0, 9)])
        assert np.allclose(np.linalg.norm(found, axis=1), DISTANCE_M)
        assert np.allclose(found[0], found[-1], atol=1e-3) and np.allclose(found[0], -found[4], atol=1e-3)
        node = np.radians(40.0)
        assert np.allclose(found[0] / DISTANCE_M, (np.cos(node), np.sin(node), 0.0))
        assert math.isclose(math.degrees(math.asin(found[2][2] / DISTANCE_M)), 30.0, rel_tol=1e-9)  # a quarter later
        for t in (0.0, 130.0, 700.0):
            moon = bodies(scene, t)[1]
            assert np.allclose(moon.axes.T @ moon.axes, np.eye(3)) and np.linalg.det(moon.axes) > 0.0
            face = moon.inside((0.0, 0.0, 0.0))
            assert np.allclose(face / DISTANCE_M, (1.0, 0.0, 0.0))  # Earth is overhead at longitude 0
            assert np.allclose(moon.outside(moon.inside((1.0, 2.0, 3.0))), (1.0, 2.0, 3.0), atol=1e-6)
    finally:
        for name in ("period_s", "inclination_deg", "node_deg", "phase_deg"):
            setattr(orbit, name, before[name])


def test_the_planet_turns_below_its_moon():
    with pf.load_scene("earth") as scene:
        scene.companions.add(pf.Scene("moon", {}), pf.Orbit(period_s=0.0))
        scene.sun = pf.Sun(epoch_s=0.0)
        day = scene.planet.planet.rotation_period_s  # against the stars, among which the orbit lies
        places = [bodies(scene, t)[1].centre_m for t in (0.0, day / 4.0, day)]
        longitudes = [math.degrees(math.atan2(p[1], p[0])) for p in places]
        assert math.isclose((longitudes[0] - longitudes[1]) % 360.0, 90.0, abs_tol=1e-6)
        assert np.allclose(places[0], places[2], atol=10.0)


def test_nothing_stands_before_the_nearest_planet():
    """Random planets that don't touch, random eyes and looks: the first sphere on a look is never behind another."""
    rng = np.random.default_rng(7)
    checked = 0
    for _ in range(60):
        spheres = [(rng.uniform(-10.0, 10.0, 3), 10.0 ** rng.uniform(-1.0, 0.8)) for _ in range(4)]
        apart = all(np.linalg.norm(a[0] - b[0]) > a[1] + b[1] for k, a in enumerate(spheres) for b in spheres[k + 1 :])
        eye = rng.uniform(-12.0, 12.0, 3)
        if not apart or any(np.linalg.norm(eye - c) < r for c, r in spheres):
            continue
        found = [Body(str(k), None, c, np.eye(3), r, r) for k, (c, r) in enumerate(spheres)]  # type: ignore[arg-type]
        main = nearest(found, eye)
        to = main.centre_m + main.radius_m * rng.normal(size=(40, 3)) * 0.5 - eye
        looks = to / np.linalg.norm(to, axis=1, keepdims=True)
        for look in looks:
            hits = {b.name: float(ray_sphere_from(eye - b.centre_m, look, b.radius_m).near_m) for b in found}
            if math.isfinite(hits[main.name]):
                checked += 1
                assert hits[main.name] == min(hits.values())
    assert checked > 300


def test_bounds_of_a_disc():
    """Against points of the sphere's outline, wide beside the axis and around the eye."""
    camera = CameraState.look((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 90.0, 1.0)
    for centre in ((0.0, 0.0, 5.0), (3.0, -2.0, 4.0), (-6.0, 1.0, 2.0)):
        c, radius = np.array(centre), 1.5
        distance = np.linalg.norm(c)
        ahead, angle = c / distance, math.asin(radius / distance)
        u = np.cross(ahead, (0.3, 0.7, -0.2))
        u /= np.linalg.norm(u)
        around = np.linspace(0.0, 2.0 * np.pi, 20_001)[:, None]
        rim = ahead * math.cos(angle) + math.sin(angle) * (u * np.cos(around) + np.cross(ahead, u) * np.sin(around))
        x, y = rim[:, 0] / rim[:, 2], rim[:, 1] / rim[:, 2]
        assert np.allclose(disc_bounds(camera, c, radius), (x.min(), x.max(), y.min(), y.max()), atol=1e-6)
    assert disc_bounds(camera, np.array([0.0, 0.0, -5.0]), 1.5) is None
    assert np.allclose(disc_bounds(camera, np.array([0.0, 0.0, 1.0]), 1.5), (-1.0, 1.0, -1.0, 1.0))


# -- what is seen -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("across_px", [40.0, 9.0, 4.2, 3.8, 2.0, 0.7])
def test_a_disc_has_its_place_and_size(renderer, scene, across_px):
    """The share of the picture that is hidden, against the solid angle of a sphere: discs, and spots below 4 pixels."""
    camera = towards(scene, 1.0)
    away = DISTANCE_M - 1e7
    tangent = math.tan(math.asin(MOON_M / away))
    fov = 2.0 * math.degrees(math.atan(tangent * SIZE[1] / across_px))
    camera = pf.Camera(camera.position_m, camera.forward, camera.up, fov, ev100=EXPOSURE)
    part = part_of(camera.resolve(scene, SIZE[0] / SIZE[1]), SIZE, bodies(scene, 0.0)[1])
    assert part is not None and (part.spot_px > 0.0) == (across_px * 8e3 / MOON_M + across_px < SPOT_BELOW_PX)
    renderer.settle(camera)
    hidden = renderer.render(camera, outputs=("companions.light",))["companions.light"][..., 3]
    # Ground of +-0.5 % of the radius and single samples along the outline: within 4 % of the area, 0.1 pixels of place.
    assert math.isclose(hidden.sum(), math.pi * (0.5 * across_px) ** 2, rel_tol=0.04)
    rows, columns = np.mgrid[: SIZE[1], : SIZE[0]] + 0.5
    assert abs((hidden * columns).sum() / hidden.sum() - SIZE[0] / 2) < 0.1
    assert abs((hidden * rows).sum() / hidden.sum() - SIZE[1] / 2) < 0.1


def test_light_does_not_jump_between_spot_and_disc(renderer, scene):
    """All light of the Moon, and its brightest pixel, a little above and below the size at which it becomes a spot."""
    # The angle at which the disc is 4 pixels wide.
    diameter = 2.0 * math.tan(math.asin((MOON_M + 8e3) / (DISTANCE_M - 1e7)))
    edge = 2.0 * math.degrees(math.atan(diameter * SIZE[1] / SPOT_BELOW_PX / 2.0))
    sun = pf.Sun(direction=(-1.0, 1.2, 0.4))
    light = []
    for fov in (edge * 1.005, edge * 0.995):
        camera = towards(scene, fov)
        part = part_of(camera.resolve(scene, SIZE[0] / SIZE[1]), SIZE, bodies(scene, 0.0)[1])
        assert part is not None and (part.spot_px > 0.0) == (fov > edge)
        renderer.settle(camera, sun=sun)
        shown = renderer.render(camera, sun=sun, outputs=("companions.light",))["companions.light"][..., :3]
        pixel = math.tan(math.radians(fov) / 2.0) ** 2
        light.append(shown.sum(axis=(0, 1)) * pixel)
    # 600 samples of ground whose albedo varies as much as its mean, against other 800: 1 / sqrt(600) + 1 / sqrt(800).
    assert np.allclose(light[0], light[1], rtol=0.08)


def either_side(scene: pf.Scene, renderer: pf.Renderer, look: float, fov_y_deg: float) -> list[dict[str, np.ndarray]]:
    """Pictures from a metre before and behind the place where the camera's planet changes."""
    earth, moon = bodies(scene, 0.0)
    ahead = moon.centre_m / DISTANCE_M
    middle = (DISTANCE_M**2 + earth.reach_m**2 - moon.reach_m**2) / (2.0 * DISTANCE_M)
    sun = pf.Sun(direction=(0.3, 0.9, 0.3))
    pictures = []
    for side in (-1.0, 1.0):
        camera = pf.Camera(ahead * (middle + side), ahead * look, (0.0, 0.0, 1.0), fov_y_deg, ev100=EXPOSURE)
        renderer.settle(camera, sun=sun)
        pictures.append(renderer.render(camera, sun=sun, outputs=("color", "radiance")))
        assert renderer.main == ("earth" if side < 0.0 else "moon")
        assert np.allclose(renderer.camera_state(camera).position_m, camera.position_m, atol=1e-3)
    return pictures


@pytest.mark.parametrize(("look", "fov_y_deg"), [(1.0, 1.5), (-1.0, 4.5)])
def test_the_picture_is_the_same_whoever_is_main(renderer, scene, look, fov_y_deg):
    one, other = (p["radiance"].astype(np.float64) for p in either_side(scene, renderer, look, fov_y_deg))
    # Pixels have the same rays but for rounding (a part's own frustum): along outlines a few fall on the other side.
    differ = np.abs(one - other).max(axis=-1) > 0.01 * one.max()
    assert one.max() > 0.01 and differ.sum() <= 0.005 * (one.max(axis=-1) > 1e-4).sum()


@pytest.mark.slow
@pytest.mark.parametrize(("look", "fov_y_deg"), [(1.0, 1.5), (-1.0, 4.5)])
def test_the_preset_is_the_same_whoever_is_main(earth_moon, look, fov_y_deg):
    scene, renderer = earth_moon
    scene.companions["moon"].orbit.phase_deg = 0.0
    pictures = either_side(scene, renderer, look, fov_y_deg)
    one, other = (p["radiance"].astype(np.float64) for p in pictures)
    # Whether a pixel on a coast is land or sea is up to rounding at 190 000 km, and land is up to twice as bright: some
    # hundred of them change all light by less than a hundredth.
    assert math.isclose(one.sum(), other.sum(), rel_tol=0.01)
    shades = [p["color"].astype(np.float64) for p in pictures]
    assert np.abs(shades[0] - shades[1]).mean() < 1.0  # of 255; a picture brighter by 1 % differs by two


def frames_of(planet) -> list[int]:
    """Frames that were drawn of each view of a planet."""
    return [view.frames for view in planet.views]


def test_out_of_sight_costs_nothing(renderer, scene):
    behind = towards(scene, 40.0)
    behind = pf.Camera(behind.position_m, -behind.forward, behind.up, 40.0, ev100=EXPOSURE)
    below = pf.Camera.at(0.0, 178.0, 1e4, pitch_deg=-40.0, ev100=EXPOSURE)  # looks at the Moon through Earth
    for camera in (behind, below):
        renderer.render(camera)
        member = renderer.planets["moon"]
        drawn = frames_of(member)
        renderer.render(camera)
        assert frames_of(member) == drawn
        assert "companions.layer" not in [p.name for p in renderer.passes() if p.ran]


def test_the_moon_hides_sun_and_stars(renderer, scene):
    moon = bodies(scene, 0.0)[1].centre_m
    sun = pf.Sun(direction=tuple(moon), angular_radius_rad=0.003)
    camera = towards(scene, 2.0)
    renderer.settle(camera, sun=sun)
    dark = renderer.render(camera, sun=sun, outputs=("radiance",))["radiance"]
    assert float(dark[45, 80].max()) < 1e-3  # the sun's disc is 5e4
    removed = scene.companions["moon"]
    scene.companions.remove("moon")
    try:
        bright = renderer.render(camera, sun=sun, outputs=("radiance",))["radiance"]
        assert float(bright[45, 80].max()) > 1e3 and renderer.main == "earth"
    finally:
        scene.companions.add(removed.scene, removed.orbit, "moon")


@pytest.mark.slow
def test_air_dims_and_reddens_it(earth_moon):
    """Low over the sea against above the air: by the transmittance that the probe computes in float64."""
    scene, renderer = earth_moon
    scene.companions["moon"].orbit.phase_deg = 0.0
    moon = bodies(scene, 0.0)[1].centre_m
    ahead = moon / DISTANCE_M
    away = math.radians(86.0)
    up = np.array([math.cos(away), math.sin(away), 0.0])
    sun = pf.Sun(direction=(-1.0, -0.1, 0.0))
    light = []
    place = up * (scene.planet.radius_m + 3000.0)
    for position in (place, ahead * 6.6e6):
        to = moon - position
        camera = pf.Camera(position, to, (0.0, 0.0, 1.0), 1.2, ev100=EXPOSURE)
        renderer.settle(camera, sun=sun)
        found = renderer.render(camera, sun=sun, outputs=("radiance", "companions.light"))
        inside = found["companions.light"][..., 3] == 1.0
        sky = np.median(found["radiance"][found["companions.light"][..., 3] == 0.0], axis=0)
        light.append(found["radiance"][inside].mean(axis=0) - sky)
    to = (moon - place) / np.linalg.norm(moon - place)
    probe = pf.AtmosphereProbe(scene)
    through = probe.transmittance(place, to)
    assert np.allclose(light[0] / light[1], np.ravel(through), rtol=0.05)


# -- what a program asks ----------------------------------------------------------------------------------------------


def test_cameras_over_a_companion(renderer, scene):
    camera = pf.Camera.at(5.0, 60.0, 50.0, 270.0, -20.0, above="ground", planet="moon", ev100=EXPOSURE)
    arrays = renderer.render(camera, outputs=("color", "position", "surface", "distance"))
    assert renderer.main == "moon" and (arrays["surface"] == 1).mean() > 0.5
    state = renderer.camera_state(camera)
    assert abs(np.linalg.norm(state.position_m) - MOON_M) < 1e4
    found = renderer.pick(camera, 80.0, 80.0)
    assert found is not None and found[1] == "terrain"
    pixel, ahead = renderer.project(camera, found[0])
    assert ahead[0] and np.allclose(pixel[0], (80.5, 80.5), atol=0.6)
    # The same place in the scene's own axes gives the same picture.
    moon = bodies(scene, 0.0)[1]
    turned = (moon.axes @ v for v in (state.forward, state.up))
    other = pf.Camera(moon.outside(state.position_m), *turned, camera.fov_y_deg, ev100=EXPOSURE)
    again = renderer.render(other, outputs=("color", "distance"))
    assert np.abs(again["color"].astype(int) - arrays["color"].astype(int)).mean() < 0.5
    there = renderer.pick(other, 80.0, 80.0)
    assert there is not None and np.allclose(moon.inside(there[0]), found[0], atol=1.0)
    height = renderer.height_field()
    assert height is not None and height.highest_m == scene.companions["moon"].scene.height_field().highest_m


def test_a_paused_scene_comes_to_rest(scene):
    with pf.Renderer(scene, SIZE, "low") as renderer:
        camera = towards(scene, 3.0)
        renderer.settle(camera)
        target = renderer.ctx.simple_framebuffer(SIZE)
        for _ in range(60):
            renderer.render_to(target, camera, dt_s=0.016)
        member = renderer.planets["moon"]
        before = frames_of(member)
        renderer.render_to(target, camera, dt_s=0.016)
        assert frames_of(member) == before  # nothing is drawn again
        scene.companions["moon"].scene.planet[pf.Terrain].rock_albedo = (0.3, 0.1, 0.1)
        renderer.render_to(target, camera, dt_s=0.016)
        assert frames_of(member) != before


def test_further_views_and_release(scene):
    renderer = pf.Renderer(scene, SIZE, "low")
    gpu = renderer.gpu
    with renderer.add_view((64, 36)) as view:
        renderer.render(towards(scene, 3.0))
        over = pf.Camera.at(5.0, 60.0, 500.0, 270.0, -20.0, planet="moon", ev100=EXPOSURE)
        assert view.render(over)["color"].shape == (36, 64, 3)
        assert renderer.render(towards(scene, 3.0))["color"].any() and renderer.main == "earth"
        member = renderer.planets["moon"].gpu
    renderer.release()
    assert not gpu.counts() and not member.counts()


def test_a_picture_tells_of_companions(tmp_path):
    from planetfall.capture.shot import shot_settings
    from planetfall.systems.capture import write_png

    scene = bare_scene()
    scene.companions["moon"].orbit.phase_deg = 33.0
    camera = pf.Camera.at(5.0, 60.0, 500.0, planet="moon")
    state = camera.resolve(scene)
    file = tmp_path / "shot.png"
    told = shot_settings(scene, state, 0.0, (4, 4), quality="low", over="moon")
    write_png(file, np.zeros((4, 4, 3), np.uint8), told)
    shot = pf.load_shot(file)
    assert shot.scene.companions["moon"].orbit == scene.companions["moon"].orbit and shot.camera.planet == "moon"
    assert np.allclose(shot.camera.resolve(shot.scene).position_m, state.position_m)


def test_the_sun_in_the_axes_of_the_cameras_planet(scene):
    """Towards the sun over the Moon is the scene's direction, turned: told from its ground, it is the same point."""
    moon = bodies(scene, 0.0)[1]
    over = pf.Camera.at(5.0, 60.0, 500.0, planet="moon")
    found = pf.sun_direction(scene, camera=over)
    there = moon.outside(found * 1e6) - moon.centre_m
    assert np.allclose(there / 1e6, pf.sun_direction(scene), atol=1e-6)
    assert not np.allclose(there / 1e6, found, atol=0.1)
    told = pf.view("earthrise", scene.planet)  # over the Moon, with a sun of its own, told in the Moon's axes
    high = pf.direction(told.sun.latitude_deg, told.sun.longitude_deg) @ pf.sun_direction(scene, camera=told)
    assert math.isclose(float(high), math.sin(math.radians(told.sun.elevation_deg)), abs_tol=1e-12)
    with pytest.raises(pf.UnknownNameError, match="no planet 'luna'"):
        pf.sun_direction(scene, camera=pf.Camera.at(5.0, 60.0, 500.0, planet="luna"))


def test_faults_and_memory_of_all_planets(scene, monkeypatch):
    """Over the Moon, where its own renderer draws: what fails in it and what it takes is told by the one asked."""
    from planetfall.app.interface import fault_name

    with pf.Renderer(scene, SIZE, "low", {"composite.antialiasing": "none"}) as renderer:
        target = renderer.ctx.simple_framebuffer(SIZE)
        renderer.tolerant = True
        over = pf.Camera.at(5.0, 60.0, 500.0, 270.0, -20.0, planet="moon", ev100=EXPOSURE)
        renderer.render_to(target, over)
        assert not renderer.faults
        member = renderer.planets["moon"]
        own, theirs = renderer.gpu.memory_bytes(), member.gpu.memory_bytes()
        assert sum(theirs.values()) > 2**20
        assert sum(renderer.memory_bytes.values()) == sum(own.values()) + sum(theirs.values())
        assert renderer.memory_bytes["terrain"] >= theirs["terrain"] > 0

        def broken(self, frame):
            raise ZeroDivisionError("no stars tonight")

        monkeypatch.setattr(type(member.system("stars")), "update", broken)
        on = pf.Camera.at(5.1, 60.0, 500.0, 270.0, -20.0, planet="moon", ev100=EXPOSURE)  # a still one comes to rest
        renderer.render_to(target, on)
        (fault,) = renderer.faults.list
        assert renderer.faults and (fault.system, fault.planet) == ("stars", "moon")
        assert "no stars tonight" in fault.report
        several = SimpleNamespace(planets=SimpleNamespace(several=True))
        assert fault_name(several, fault) == "stars of moon"  # type: ignore[arg-type]
        monkeypatch.undo()
        renderer.try_again()
        renderer.render_to(target, over)
        assert not renderer.faults


def test_broken_shaders_of_all_planets(scene, monkeypatch):
    """Every planet has programs of its own: each error is told once, whoever has it."""
    with pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.render(pf.Camera.at(5.0, 60.0, 500.0, planet="moon", ev100=EXPOSURE))
        assert renderer.shader_errors == []
        kind = type(renderer.gpu.shaders)
        broken = {id(renderer.gpu.shaders): [ValueError("both")]}
        broken[id(renderer.planets["moon"].gpu.shaders)] = [ValueError("both"), ValueError("the Moon's")]
        monkeypatch.setattr(kind, "errors", property(lambda self: broken[id(self)]))
        assert [str(error) for error in renderer.shader_errors] == ["both", "the Moon's"]
