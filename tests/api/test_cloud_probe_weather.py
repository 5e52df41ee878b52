"""CloudProbe through weather: it is the march of pictures, and keeps to what no march may get wrong."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from air_kit import TINY
from cloud_kit import COARSE, cloudy, renderer_of, texture
from cloud_tables import planet_of

import planetfall as pf
from planetfall.benchmarks.measure.rays import pixel_rays
from planetfall.benchmarks.reference.cloud_shells import Layer, cloud_light, cloud_transmittance
from planetfall.benchmarks.session import Session
from planetfall.benchmarks.stress.clouds import KINDS
from planetfall.components import CloudLayer, Clouds
from planetfall.systems.light.sun import resolve_sun

SUN = pf.Sun(elevation_deg=50.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=10.0)
FINE = {
    **TINY, **COARSE, "clouds.fine_steps": 320, "clouds.sun_steps": 16, "clouds.step_growth": 0.001,
    "clouds.shadow_texels": 256,
}  # fmt: skip
"""Maps of the shadow with texels of 60 m: those of COARSE, 250 m, blur the shafts that probes march."""
EARTH_M = 6.36e6
SIZE = (40, 24)


def layers() -> Clouds:
    made = Clouds(base_m=1200.0, top_m=3200.0, coverage=0.8)
    made.layers = (CloudLayer(base_m=8500.0, top_m=10500.0, extinction_per_m=6e-4, coverage=0.6),)
    return made


def fan(count: int, altitude_m: float = 10.0) -> tuple[Any, Any]:
    """(positions, directions): up from one place, spread over the sky."""
    place = pf.direction(20.0, 10.0)[None]
    up, east = place[0], np.array([0.0, 1.0, 0.0])
    north = np.cross(up, east)
    k = np.arange(count)
    rise, turn = 0.15 + 0.8 * (k + 0.5) / count, 2.399963 * k
    flat = np.sqrt(1.0 - rise**2)
    ways = rise[:, None] * up + flat[:, None] * (np.cos(turn)[:, None] * east + np.sin(turn)[:, None] * north)
    return np.repeat(place * (EARTH_M + altitude_m), count, axis=0), ways


@pytest.mark.parametrize(("altitude_m", "pitch_deg"), [(100.0, 20.0), (4e5, -50.0)], ids=["ground", "400 km"])
def test_it_sees_what_a_picture_shows(altitude_m: float, pitch_deg: float) -> None:
    """What clouds leave of the picture and add to it, shafts and all, pixel by pixel. The picture's air is from
    tables (coarse ones here: 12 x 12 x 6), its steps lie at places of chance, and far away, where maps of the shadow
    are coarser than clouds, a place's own column stands for what is marched behind it here: the median pixel is within
    2 % of the mean light, the mean within 3 % (2.3 % here from 400 km, 0.1 % at another place); other clouds are ten
    times as far off."""
    fov = 40.0 if altitude_m < 1e4 else 0.2  # wider pixels see means, from maps there and marched here
    camera, scene = pf.Camera.at(20.0, 10.0, altitude_m, pitch_deg=pitch_deg, fov_y_deg=fov), cloudy(layers())
    knobs = {key.removeprefix("clouds."): value for key, value in FINE.items() if key.startswith("clouds.")}
    with renderer_of(scene, SIZE, **knobs) as drawn:
        drawn.render(camera, sun=SUN)
        picture = texture(drawn, "clouds.full").reshape(-1, 4)
    state, way = camera.resolve(scene, SIZE[0] / SIZE[1]), resolve_sun(SUN, None).direction
    rays, pixel = pixel_rays(state, SIZE), (state.tan_top - state.tan_bottom) / SIZE[1]
    clear = cloudy(coverage=0.0)
    scene.sun = clear.sun = SUN
    with (
        pf.CloudProbe(scene, quality="low", overrides=FINE) as clouds,
        pf.CloudProbe(clear, quality="low", overrides=FINE, as_pictures=True) as air,
    ):
        none, whole = air.march(state.position_m, rays, way)
        found = []
        for time_s in (0.0, 864e3):
            light, through = clouds.march(state.position_m, rays, way, pixel_rad=pixel, time_s=time_s)
            found.append(np.concatenate([light - through / whole * none, (through / whole)[:, 1:2]], axis=1))
    scale = np.array([*np.abs(picture[:, :3]).mean(axis=0), 1.0])
    error, other = (np.abs(one - picture) / scale for one in found)
    assert np.median(error) < 0.02
    assert np.abs((found[0] - picture).mean(axis=0) / scale).max() < 0.03
    assert other.mean() > 10.0 * error.mean()


def test_uniform_layers_as_pictures_have_them_against_closed_form() -> None:
    """The march of pictures on what is known exactly. It gives up behind 0.4 % of transmittance (OPAQUE)."""
    layer = Layer(1500.0, 2500.0, 1e-3, 1.0, 0.6)
    clouds = Clouds(
        base_m=1500.0,
        top_m=2500.0,
        extinction_per_m=1e-3,
        asymmetry=0.6,
        density_model="uniform",
        height_profile="none",
    )
    places, ways = fan(40)
    sun = np.array([0.3, 0.4, 0.866])
    with pf.CloudProbe(planet_of(clouds, EARTH_M), overrides=FINE, as_pictures=True) as probe:
        light, through = probe.march(places, ways, sun, orders=1, sun_visibility="point")
    truth = cloud_transmittance(EARTH_M, [layer], places, ways)
    kept = truth[:, 0] > 0.01
    np.testing.assert_allclose(through[kept], truth[kept], atol=1e-3)
    once = cloud_light(EARTH_M, [layer], places, ways, sun)
    np.testing.assert_allclose(light[kept, 0], once.radiance[kept, 0], rtol=0.05)


def test_layers_multiply_and_rays_end_anywhere() -> None:
    """What two layers leave is the product of what each leaves; along a ray less and less is left."""
    both, places, ways = layers(), *fan(60)
    low, high = layers(), layers()
    low.layers = ()
    high.coverage = 0.0
    found = []
    for clouds in (low, high, both):
        with pf.CloudProbe(planet_of(clouds, EARTH_M), overrides=FINE) as probe:
            found.append(probe.march(places, ways, [0.3, 0.4, 0.87])[1][:, 0])
            if clouds is both:
                ends = np.linspace(0.0, 3e4, 16)
                along = [probe.march(places[:8], ways[:8], [0.3, 0.4, 0.87], max_distance_m=e) for e in ends]
    # Steps of the high layer begin where the low one's opacity lets them.
    np.testing.assert_allclose(found[2], found[0] * found[1], atol=5e-3)
    assert 0.05 < found[2].mean() < 0.95
    left = np.stack([through[:, 0] for _, through in along])
    assert (left[0] == 1.0).all()
    # Ends lie between steps: a step that is cut has its middle elsewhere.
    assert (np.diff(left, axis=0) < 0.02).all()
    assert (along[0][0] == 0.0).all()


def test_the_same_clouds_from_anywhere_on_a_ray() -> None:
    """A question further along a ray, in front of all cloud, is answered alike: noise stays where it is."""
    places, ways = fan(24)
    with pf.CloudProbe(planet_of(layers(), EARTH_M), overrides=FINE) as probe:
        suns = [0.3, 0.4, 0.87]
        first = probe.march(places, ways, suns)
        moved = probe.march(places + 900.0 * ways, ways, suns)
        apart = probe.march(places + 900.0 * np.roll(ways, 5, axis=0), ways, suns)
    assert np.abs(first[1] - moved[1]).mean() < 0.1 * np.abs(first[1] - apart[1]).mean()
    assert first[0].mean() == pytest.approx(moved[0].mean(), rel=0.03)


def test_from_very_far_and_below_the_ground() -> None:
    with pf.CloudProbe(planet_of(layers(), EARTH_M), overrides=FINE) as probe:
        up = np.array([np.cos(0.4), 0.0, np.sin(0.4)])
        near = probe.march(up * 3.6e7, -up, up, pixel_rad=1e-3)
        far = probe.march(up * 3.6e11, -up, up, pixel_rad=1e-7)
        aside, clear = probe.march(up * 3.6e11, [0.0, 1.0, 0.0], up)
        below = probe.march(up * 6.3e6, up, up)
        floor = probe.march(up * EARTH_M, up, up)
    np.testing.assert_allclose(far[1], near[1], atol=0.05)
    assert not aside.any()
    assert (clear == 1.0).all()
    np.testing.assert_array_equal(below[1], floor[1])


def test_bad_questions_of_weather_are_told_of(tmp_path: Any) -> None:
    scene = cloudy(layers())
    with pf.CloudProbe(scene, quality="low", overrides={**TINY, **COARSE}) as probe:
        question = ([0, 0, 6.4e6], [0, 0, -1], [0, 0, 1])
        with pytest.raises(ValueError, match="time_s: expected one finite number"):
            probe.march(*question, time_s=np.nan)
        with pytest.raises(ValueError, match="pixel_rad: expected one finite number from 0 to 1, found 2"):
            probe.march(*question, pixel_rad=2)
        light, through = probe.march(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 3)))
        assert light.shape == through.shape == (0, 3)
    scene.planet[Clouds].method = "paper_2018"
    with pytest.raises(ValueError, match="marches through layers of density_model 'uniform' only"):
        pf.CloudProbe(scene)
    scene.planet[Clouds].method = "ours"
    scene.planet[Clouds].weather_map = str(tmp_path / "none.png")
    with pytest.raises(ValueError, match=r"none\.png"):
        pf.CloudProbe(scene)


def test_long_ways_through_even_shells_gain_no_light() -> None:
    """Found by a sweep: steps of hundreds of optical depths across a shell that the sun barely reaches had light that
    goes straight on without its loss, 7e4 times the sun's irradiance."""
    sun = [-0.911369930121876, 0.2862845992595594, -0.2957126623877316]
    layers: list[dict[str, Any]] = []
    case = {
        "seed": 1693142412,
        "scene": {
            "planet": {"radius_m": 8879889.650356134},
            "sun": {"direction": sun, "angular_radius_rad": 1e-4},
            "clouds": {
                "base_m": 4419296.241805726, "top_m": 4439944.825178067, "extinction_per_m": 0.0006647745634735277,
                "albedo": 0.999, "asymmetry": 0.85, "height_profile": "none", "density_model": "uniform",
                "layers": layers, "coverage": 0.6, "wind_speed_m_s": 500.0,
            },
        },
    }  # fmt: skip
    with Session("clouds") as session:
        assert KINDS["rays"].check(case, session).messages == []
