"""Stars, Milky Way and sun: counts, colours, light kept to the pixel, nothing over surfaces, owners' objects."""

from __future__ import annotations

import numpy as np
import pytest
from picture_harness import SUN, Bench, Scene, look

from planetfall.components import Stars
from planetfall.engine.wavelengths import DISPLAY_NM, GIVEN_NM, SUNLIGHT
from planetfall.systems.composite.photometry import expose, luminance_per_radiance
from planetfall.systems.sky import SkySystem, StarsSystem, make_stars
from planetfall.systems.sky.catalogue import (
    GALACTIC_AXES,
    VEGA_IRRADIANCE,
    count_to,
    planck_ratio,
    star_irradiance,
)
from planetfall.systems.sky.sun_disc import disc_radiance

SIZE = (96, 54)


def pixel_solid_angles(block, size):
    """(h, w) sr of every pixel, row 0 on top."""
    x = ((np.arange(size[0]) + 0.5) / size[0] * 2 - 1) * block.projection_scale[0]
    y = (1 - (np.arange(size[1]) + 0.5) / size[1] * 2) * block.projection_scale[1]
    area = 4 * block.projection_scale[0] * block.projection_scale[1] / (size[0] * size[1])
    return area / (1 + x[None, :] ** 2 + y[:, None] ** 2) ** 1.5


def total_light(image, block, size):
    """Irradiance (3,) that a picture of radiance stands for."""
    return np.einsum("hwc,hw->c", image[..., :3], pixel_solid_angles(block, size))


# -- the catalogue -----


COUNTS = [(1.5, 22), (2.5, 93), (3.5, 283), (4.5, 893), (5.5, 2822), (6.5, 8768)]


@pytest.mark.parametrize(("magnitude", "counted"), COUNTS)
def test_star_counts_against_the_catalogues(magnitude, counted):
    stars = make_stars(8768)
    assert np.sum(stars.magnitudes <= magnitude) == pytest.approx(counted, rel=0.27, abs=1)
    assert count_to(magnitude) == pytest.approx(counted, rel=0.27)


def test_a_sky_depends_on_its_seed_only_and_larger_ones_contain_it():
    small, large = make_stars(500, 3), make_stars(4000, 3)
    assert np.array_equal(small.directions, large.directions[:500])
    assert np.array_equal(small.irradiance, large.irradiance[:500])
    assert not np.allclose(make_stars(500, 4).directions, small.directions)
    assert np.allclose(np.linalg.norm(large.directions, axis=1), 1.0)


def test_stars_crowd_towards_the_galactic_plane():
    z = make_stars(20000).directions @ GALACTIC_AXES[2]
    plane, poles = np.mean(np.abs(z) < 0.1) / 0.1, np.mean(np.abs(z) > 0.9) / 0.1
    assert 2.0 < plane / poles < 4.5
    # Around the plane nothing is preferred.
    around = make_stars(20000).directions @ GALACTIC_AXES[:2].T
    assert np.all(np.abs(around.mean(axis=0)) < 0.02)


def test_galactic_axes():
    assert np.allclose(GALACTIC_AXES @ GALACTIC_AXES.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(GALACTIC_AXES) == pytest.approx(1.0)
    centre = GALACTIC_AXES[0]  # right ascension 266.405 deg, declination -28.936 deg (J2000)
    assert np.degrees(np.arctan2(centre[1], centre[0])) % 360 == pytest.approx(266.405, abs=0.01)
    assert np.degrees(np.arcsin(centre[2])) == pytest.approx(-28.936, abs=0.01)


def test_star_light():
    # The sun as a star: V = -26.74 and 5772 K come within 15 % of the solar irradiance at the three wavelengths.
    for nm, sunlight in SUNLIGHT.items():
        assert star_irradiance(np.array(-26.74), np.array(5772.0), nm) == pytest.approx(np.array(sunlight), rel=0.15)
    assert star_irradiance(np.array(0.0), np.array(1e4))[1] == pytest.approx(VEGA_IRRADIANCE)
    assert planck_ratio(np.array(3500.0), 680.0) > 1.0 > planck_ratio(np.array(20000.0), 680.0)
    colors = make_stars(9000).irradiance
    ratio = colors[:, 2] / colors[:, 0]
    assert np.mean(ratio > 1.3) > 0.25 and np.mean(ratio < 0.7) > 0.15  # bluish and reddish ones


# -- the sun -----


def test_limb_darkened_disc_keeps_the_irradiance():
    radius = 0.004675
    theta = np.linspace(0, radius, 200001)
    radiance = disc_radiance(np.sin(theta), np.array(SUN), radius)
    light = np.trapezoid(radiance * (2 * np.pi * np.sin(theta) * np.cos(theta))[:, None], theta, axis=0)
    np.testing.assert_allclose(light, SUN, rtol=1e-4)
    limb, middle = disc_radiance(np.sin(radius * np.array([0.999, 0.0])), np.array(SUN), radius)
    edge = limb / middle
    assert edge[0] > edge[1] > edge[2]  # the limb is redder than the middle


@pytest.fixture(scope="module")
def sky(gpu):
    with Bench(gpu, [Scene(), SkySystem()], size=SIZE) as bench:
        yield bench


@pytest.mark.parametrize("fov_y_deg", [0.8, 3.0, 10.0, 30.0, 90.0])
def test_drawn_sun_keeps_the_irradiance(sky, fov_y_deg):
    """From a disc of 34 pixels' radius down to one of 0.15, wherever it stands between pixel centres."""
    errors = []
    for k in range(5):
        off = np.radians(fov_y_deg) / SIZE[1] * np.array([0.21, 0.37]) * k
        block = look((1.0, *off), fov_y_deg=fov_y_deg, size=SIZE)
        light = total_light(sky.render(block).read("scene.radiance"), block, SIZE)
        errors.append(light / SUN - 1.0)
    assert np.max(np.abs(errors)) < (0.04 if fov_y_deg < 20 else 0.08)


@pytest.mark.parametrize("nm", [GIVEN_NM, DISPLAY_NM], ids=["given", "display"])
def test_drawn_sun_against_its_twin(gpu, nm):
    block = look(fov_y_deg=1.2, size=SIZE)
    settings = {"light.wavelengths": "given" if nm == GIVEN_NM else "display"}
    with Bench(gpu, [Scene(), SkySystem()], size=SIZE, settings=settings) as bench:
        image = bench.render(block).read("scene.radiance")[..., :3]
    x = ((np.arange(SIZE[0]) + 0.5) / SIZE[0] * 2 - 1) * block.projection_scale[0]
    y = (1 - (np.arange(SIZE[1]) + 0.5) / SIZE[1] * 2) * block.projection_scale[1]
    tangent = np.hypot(x[None, :], y[:, None])
    sine = tangent / np.sqrt(1 + tangent**2)
    expected = disc_radiance(sine, np.array(SUN), 0.004675, nm)
    inside = sine < 0.96 * np.sin(0.004675)
    outside = sine > 1.06 * np.sin(0.004675)
    np.testing.assert_allclose(image[inside], expected[inside], rtol=2e-3)
    assert np.all(image[outside] == 0.0)


def test_no_sun_behind_the_camera_nor_over_a_surface(gpu, sky):
    assert not sky.render(look((-1, 0, 0), fov_y_deg=60, size=SIZE)).read("scene.radiance")[..., :3].any()
    depth = np.zeros(SIZE[::-1])
    depth[:, : SIZE[0] // 2] = 0.5
    with Bench(gpu, [Scene(depth), SkySystem()], size=SIZE) as half:
        image = half.render(look(fov_y_deg=2.0, size=SIZE)).read("scene.radiance")[..., :3]
    assert not image[:, : SIZE[0] // 2].any() and image[:, SIZE[0] // 2 :].max() > 1e4


def test_sixteen_bit_radiance_stays_finite(gpu):
    with Bench(gpu, [Scene(), SkySystem()], size=SIZE, settings={"sky.radiance_format": "rgba16f"}) as bench:
        image = bench.render(look(size=SIZE, hdr_per_radiance=100.0, radiance_per_hdr=0.01)).read("scene.radiance")
    assert np.isfinite(image).all() and image.max() == pytest.approx(6e4, rel=1e-3)


# -- stars -----


@pytest.fixture(scope="module")
def night(gpu):
    with Bench(gpu, [Scene(), SkySystem(), StarsSystem()], [Stars()], SIZE) as bench:
        yield bench


def around_a_star(rank=0):
    """A view at a bright star with the galaxy's pole up, and its irradiance."""
    field = make_stars(8768)
    return field.directions[rank], field.irradiance[rank]


def behind(direction):
    """A sun that a camera looking along `direction` doesn't see."""
    return -direction


def test_a_stars_light_does_not_depend_on_where_it_falls(night):
    direction, irradiance = around_a_star()
    side = np.cross(direction, [0.0, 0.0, 1.0])
    lights, peaks = [], []
    for k in range(12):
        block = look(direction + side * (k / 12 * 0.002), fov_y_deg=4.0, size=SIZE, sun_direction=behind(direction))
        image = night.render(block).read("scene.radiance")[..., :3]
        image = image - np.median(image, axis=(0, 1))  # without the light of the galaxy
        y, x = np.unravel_index(np.argmax(image[..., 1]), image.shape[:2])
        alone = np.zeros_like(image)
        alone[y - 5 : y + 6, x - 5 : x + 6] = image[y - 5 : y + 6, x - 5 : x + 6]
        lights.append(total_light(alone, block, SIZE))
        peaks.append(image[..., 1].max())
    np.testing.assert_allclose(lights, np.broadcast_to(irradiance, (12, 3)), rtol=2e-3)
    assert np.ptp(np.sum(lights, axis=1)) / np.sum(irradiance) < 1.5e-3  # no twinkling while the camera turns
    assert max(peaks) / min(peaks) < 2.2


def test_stars_stay_where_the_sky_is(night):
    """Turned star axes move the stars in the planet's axes and nothing else."""
    direction, _ = around_a_star()
    block = look(direction, fov_y_deg=4.0, size=SIZE, sun_direction=behind(direction))
    before = night.render(block).read("scene.radiance")
    c, s = np.cos(1.0), np.sin(1.0)
    axes = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    night.frame.star_axes = axes
    away = night.render(block).read("scene.radiance")
    turned = look(axes @ direction, fov_y_deg=4.0, size=SIZE, sun_direction=behind(direction))
    after = night.render(turned).read("scene.radiance")
    night.frame.star_axes = None
    assert away[..., 1].max() < 0.1 * before[..., 1].max()
    np.testing.assert_allclose(after, before, rtol=0.02, atol=0.02 * before.max())


def test_stars_at_the_edge_of_the_picture_do_not_pop(night):
    direction, irradiance = around_a_star()
    side = np.cross(direction, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    reach = np.tan(np.radians(2.0)) * SIZE[0] / SIZE[1]
    pixel = 2 * reach / SIZE[0]
    peaks = []
    for k in np.linspace(-3, 4, 15):
        block = look(direction + side * (reach + k * pixel), fov_y_deg=4.0, size=SIZE, sun_direction=behind(direction))
        image = night.render(block).read("scene.radiance")[..., 1]
        peaks.append((image - np.median(image)).max())
    peak = 0.325 * irradiance[1] / pixel**2
    assert np.max(np.abs(np.diff(peaks))) < 0.45 * peak  # half a pixel a step: a spot's own slope
    assert peaks[-1] < 1e-2 * peak


def test_daylight_hides_the_stars_and_night_shows_them(night):
    direction, _ = around_a_star()
    block = look(direction, size=SIZE, sun_direction=behind(direction))
    image = night.render(block).read("scene.radiance")[..., :3]
    assert expose(image, 15.0, GIVEN_NM).max() < 0.25 / 255 / 12.92  # not half a step of an 8-bit picture
    assert expose(image, -4.0, GIVEN_NM).max() > 0.02


def test_galaxy_brightness(gpu, night):
    """Integrated starlight: some 25-60 stars of magnitude 10 a square degree at the poles, 100-900 along the plane."""
    s10 = 1.19e-11
    centre, pole = GALACTIC_AXES[0], GALACTIC_AXES[2]
    levels = {}
    for name, forward, up in (("pole", pole, centre), ("centre", centre, pole), ("anti", -centre, pole)):
        block = look(forward, up, 20.0, SIZE, sun_direction=-forward)
        levels[name] = np.median(night.render(block).read("scene.radiance")[..., 1]) / s10
    assert 15 < levels["pole"] < 60
    assert 100 < levels["centre"] < 900
    assert levels["pole"] < levels["anti"] < levels["centre"]


def test_density_brightness_and_seed(night):
    stars = night.world.query(Stars)[0][1][0]
    direction, _ = around_a_star()
    block = look(direction, size=SIZE, sun_direction=behind(direction))
    usual = night.render(block).read("scene.radiance")
    stars.brightness = 2.0
    np.testing.assert_allclose(night.render(block).read("scene.radiance")[..., :3], 2 * usual[..., :3], rtol=1e-3)
    stars.brightness = 1.0
    stars.seed = 7
    assert not np.allclose(night.render(block).read("scene.radiance"), usual, rtol=0.1)
    stars.seed = 1
    stars.density = 0.0
    assert not night.render(block).read("scene.radiance")[..., :3].any()
    stars.density = 1.0
    np.testing.assert_array_equal(night.render(block).read("scene.radiance"), usual)


def test_only_sky_pixels_get_stars(gpu):
    depth = np.zeros(SIZE[::-1])
    depth[: SIZE[1] // 2] = 1e-9  # very far away, but something
    direction, _ = around_a_star()
    with Bench(gpu, [Scene(depth), SkySystem(), StarsSystem()], [Stars()], SIZE) as bench:
        block = look(direction, size=SIZE, sun_direction=behind(direction))
        image = bench.render(block).read("scene.radiance")[..., :3]
    assert not image[: SIZE[1] // 2].any() and image[SIZE[1] // 2 :].all(axis=2).any()


def test_everything_is_freed_and_the_map_is_made_once(gpu):
    before = gpu.counts()
    with Bench(gpu, [Scene(), SkySystem(), StarsSystem()], [Stars()], SIZE) as bench:
        for _ in range(3):
            bench.render(look(size=SIZE))
        ran = {p.name: p.ran for p in bench.plan.passes}
        assert not ran["stars.galaxy_map"] and ran["stars.draw"]
        assert gpu.counts()["stars"] and gpu.counts()["sky"]
    assert gpu.counts() == before


def test_white_balance_of_the_sun():
    """Sunlight is white by definition of the three numbers."""
    assert np.ptp(np.array(SUN) * luminance_per_radiance(GIVEN_NM)) < 1e-6 * 133.1e3


def test_stars_cost_nothing_by_day(gpu):
    from planetfall.components import Exposure
    from planetfall.engine.space import CameraState

    exposure = Exposure(mode="fixed", ev100=15.0)
    systems = [Scene(), SkySystem(), StarsSystem()]
    with Bench(gpu, systems, [Stars(), exposure], SIZE, outputs=frozenset()) as bench:
        bench.frame.camera = CameraState.look(np.array([7e6, 0, 0]), (0, 1, 0), (0, 0, 1), 60.0, 16 / 9)

        def drawn() -> bool:
            bench.render(look(size=SIZE))
            return next(p.ran for p in bench.plan.passes if p.name == "stars.draw")

        assert not drawn()
        exposure.ev100 = 0.0
        assert drawn()
        exposure.ev100, exposure.mode = 15.0, "auto"
        assert drawn()  # nobody knows yet how bright the scene is
        bench.frame.ev100 = 14.0
        assert not drawn()


def test_no_star_is_brighter_than_the_bound():
    from planetfall.systems.sky.system import BRIGHTEST_STAR, STAR_FALL, STAR_PEAK

    brightest = max(make_stars(3, seed).irradiance.max() for seed in range(200))
    assert 0.5 * BRIGHTEST_STAR < brightest <= BRIGHTEST_STAR
    assert 1.0 / (2 * np.pi * 0.7**2) < STAR_PEAK
    for seed in range(8):
        strongest = make_stars(8768, seed).irradiance.max(axis=1)
        assert (strongest <= BRIGHTEST_STAR * np.arange(1, 8769) ** -STAR_FALL).all()


def test_no_part_of_the_galaxy_is_brighter_than_the_bound(gpu):
    from planetfall.systems.sky.system import BRIGHTEST_CLOUD

    brightest = 0.0
    for seed in (1, 7, 1234):
        with Bench(gpu, [Scene(), SkySystem(), StarsSystem()], [Stars(seed=seed)], SIZE, ("stars.galaxy",)) as bench:
            map_of_it = bench.render(look(size=SIZE)).read("stars.galaxy")[..., :3]
        brightest = max(brightest, 600.0 * 1.19e-11 * float(map_of_it.max()))
    assert 0.1 * BRIGHTEST_CLOUD < brightest < BRIGHTEST_CLOUD


def _chosen(renderer):
    """(does the galaxy show, how many stars) of the last frame."""
    draws = np.frombuffer(renderer.graph.resource("stars.draws").read(), np.uint32)
    return bool(draws[0]), int(draws[5])


def test_an_automatic_exposure_hides_what_cannot_show_and_nothing_else():
    import planetfall as pf

    day, low = pf.view("orbit"), pf.Sun(elevation_deg=20.0)  # not in a picture of the zenith
    overrides = {"exposure.mode": "auto", "composite.dither": False}
    with pf.Renderer(pf.load_scene("earth"), (160, 90), "low", overrides) as renderer:
        state = renderer.camera_state(day)
        here = pf.Camera(state.position_m, state.forward, state.up)
        away = pf.Camera(state.position_m, state.position_m / np.linalg.norm(state.position_m), state.up)

        def sequence():
            renderer.settle(here, sun=low)
            found, counts = [], []
            # Moving by a hand's breadth: a frame of a scene at rest is the copy of a picture, and chooses nothing.
            drifting = [pf.Camera(here.position_m * (1.0 + 1e-8 * k), here.forward, here.up) for k in range(1, 5)]
            for camera in (*drifting, *(away,) * 6):
                found.append(renderer.render(camera, sun=low, dt_s=1 / 60)["color"].astype(int))
                counts.append(_chosen(renderer))
            return found, counts

        few, counts = sequence()
        stars = renderer.system("stars")
        choose = stars.expose

        def all_of_them(frame, component, shown):
            choose(frame, component, shown)
            shown.all = True

        stars.expose = all_of_them
        every, _ = sequence()
    assert not counts[3][0] and counts[3][1] < 100, "a sunlit planet in the picture"
    assert counts[-1][1] == 8768 and counts[-1][0], "nothing but stars in it"
    for a, b in zip(few[:4], every[:4], strict=True):
        assert np.abs(a - b).max() <= 1
