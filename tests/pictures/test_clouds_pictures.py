"""Clouds in pictures: skipped where there are none, the same from near and far, at rest and in flight, never broken."""

from __future__ import annotations

import math

import numpy as np
import pytest
from air_kit import radiance
from cloud_kit import cloudy, opacity, ran, renderer_of, texture

import planetfall as pf
from planetfall.components import CloudLayer, Clouds
from planetfall.systems.clouds.history import MOVING, NONE, STILL, History, block_order

UP = pf.Sun(elevation_deg=60.0, azimuth_deg=200.0, latitude_deg=20.0, longitude_deg=10.0)
DRAWN = {"clouds.march", "clouds.resolve", "clouds.composite"}


def down_on(half_m: float, altitude_m: float) -> pf.Camera:
    """A square of the cloud tops, 2 half_m wide, from above."""
    fov = 2.0 * math.degrees(math.atan(half_m / (altitude_m - 2000.0)))
    return pf.Camera.at(20.0, 10.0, altitude_m, pitch_deg=-90.0, fov_y_deg=fov)


# -- what runs ------------------------------------------------------------------------------------------------------


def test_no_pass_where_no_ray_can_meet_a_layer_or_nothing_is_covered() -> None:
    scene = cloudy()
    with renderer_of(scene) as renderer:
        renderer.render(pf.Camera.at(20.0, 10.0, 1e7, pitch_deg=-90.0), sun=UP)
        assert ran(renderer) >= DRAWN
        renderer.render(pf.Camera.at(20.0, 10.0, 1e7, pitch_deg=90.0), sun=UP)
        assert not ran(renderer) & DRAWN
        renderer.render(pf.Camera.at(20.0, 10.0, -10.0, pitch_deg=20.0), sun=UP)
        assert ran(renderer) >= DRAWN  # no sea: a camera below the reference sphere is no diver
        scene.planet[Clouds].coverage = 0.0
        renderer.render(pf.Camera.at(20.0, 10.0, 1e3), sun=UP)
        assert not ran(renderer)
        scene.planet[Clouds].coverage = 0.5
        renderer.render(pf.Camera.at(20.0, 10.0, 1e3), sun=UP)
        assert ran(renderer) >= DRAWN
        scene.planet.remove(Clouds)
        renderer.render(pf.Camera.at(20.0, 10.0, 1e3), sun=UP)
        assert not ran(renderer)


def test_clouds_that_are_not_there_leave_the_picture_as_it_is() -> None:
    camera = pf.Camera.at(20.0, 10.0, 1e3, pitch_deg=10.0)
    scene, clear = cloudy(coverage=0.0), cloudy()
    clear.planet.remove(Clouds)
    with renderer_of(scene) as one, renderer_of(clear) as other:
        np.testing.assert_array_equal(radiance(one, camera, sun=UP), radiance(other, camera, sun=UP))


def test_a_still_settled_picture_costs_no_rays_and_stays() -> None:
    camera = pf.Camera.at(20.0, 10.0, 1e3, pitch_deg=10.0)
    with renderer_of(cloudy(), stride=2, samples=8) as renderer:
        renderer.settle(camera, sun=UP)
        first = renderer.render(camera, sun=UP)["color"]
        assert "clouds.march" not in ran(renderer)
        np.testing.assert_array_equal(renderer.render(camera, sun=UP)["color"], first)
        elsewhere = pf.Camera.at(-40.0, 90.0, 5e3)
        renderer.render(elsewhere, sun=UP)
        assert "clouds.march" in ran(renderer)
        renderer.settle(camera, sun=UP)
        np.testing.assert_array_equal(renderer.render(camera, sun=UP)["color"], first)


def test_a_picture_by_itself_depends_on_nothing_before_it() -> None:
    camera, other = pf.Camera.at(20.0, 10.0, 1e3, pitch_deg=10.0), pf.Camera.at(21.0, 10.0, 1200.0)
    with renderer_of(cloudy(), stride=2) as renderer:
        first = opacity(renderer, camera, sun=UP)
        opacity(renderer, other, sun=UP)
        np.testing.assert_array_equal(opacity(renderer, camera, sun=UP), first)


# -- history --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("stride", [1, 2, 3, 4, 8])
def test_every_pixel_of_a_block_has_its_turn(stride: int) -> None:
    order = block_order(stride)
    assert sorted(order) == [(x, y) for x in range(stride) for y in range(stride)]


def test_what_may_be_taken_over() -> None:
    with renderer_of(cloudy(), stride=2, samples=4) as renderer:

        def frame(camera: pf.Camera, **more: float) -> History:
            renderer.render(camera, sun=UP, dt_s=0.1, **more)
            return renderer.views[0].found(renderer.system("clouds").method).history

        renderer.settle(pf.Camera.at(-40.0, 10.0, 1000.0))  # or the air's tables would refine between two frames
        here = pf.Camera.at(20.0, 10.0, 1000.0)
        assert frame(here).mode == NONE
        assert frame(here).mode == STILL
        assert frame(pf.Camera.at(20.0, 10.0, 1030.0)).mode == MOVING
        assert frame(pf.Camera.at(20.0, 10.0, 1030.0, heading_deg=20.0)).mode == MOVING
        assert frame(pf.Camera.at(20.0, 10.0, 1030.0, heading_deg=170.0)).mode == NONE  # turned round
        assert frame(pf.Camera.at(20.2, 10.0, 1030.0, heading_deg=170.0)).mode == NONE  # 22 km away
        assert frame(pf.Camera.at(20.2, 10.0, 1030.0, heading_deg=170.0), time_s=86400.0).mode == NONE
        renderer.resize((48, 18))
        assert frame(pf.Camera.at(20.2, 10.0, 1030.0, heading_deg=170.0), time_s=86400.0).mode == NONE


def test_flight_shows_what_a_picture_by_itself_does() -> None:
    """After a second of flight each pixel is that of a still picture, but for the noise of steps and sharp edges that
    moved by less than a pixel; a picture of somewhere else is several times as far away."""
    scene = cloudy(coverage=0.7)

    def at(metres: float) -> pf.Camera:
        return pf.Camera.at(-36.0 + metres / 111e3, -62.0, 800.0, pitch_deg=15.0)

    with renderer_of(scene, (96, 54), stride=2, fine_steps=96) as renderer:
        renderer.settle(at(0.0))  # the weather is drawn: it fades in while one flies
        for k in range(20):
            renderer.render(at(10.0 * k), sun=UP, dt_s=0.05)
        flown = 1.0 - texture(renderer, "clouds.full")[..., 3]
        still = opacity(renderer, at(190.0), sun=UP)
        elsewhere = opacity(renderer, at(9000.0), sun=UP)
    assert np.abs(flown - still).mean() < 0.25 * np.abs(elsewhere - still).mean()


# -- the same clouds from everywhere --------------------------------------------------------------------------------


def test_the_same_clouds_from_near_and_far() -> None:
    """Pixels of 2 km: from 100 km, 1000 km and 36 000 km the same place has the same clouds, pixel by pixel."""
    with renderer_of(cloudy(air=False, coverage=0.8), (32, 32), shape_texels=64) as renderer:
        near, far, farthest = (opacity(renderer, down_on(32e3, d), sun=UP) for d in (4e5, 4e6, 36e6))
    assert near.std() > 0.1
    # Rays from 400 km are 5 degrees off the vertical at the picture's edge: a tenth of a pixel in 2.5 km.
    assert np.corrcoef(near.ravel(), far.ravel())[0, 1] > 0.97
    assert np.corrcoef(far.ravel(), farthest.ravel())[0, 1] > 0.99
    assert farthest.mean() == pytest.approx(near.mean(), abs=0.02)


def test_mean_opacity_hardly_depends_on_how_much_of_the_clouds_is_resolved() -> None:
    fine, coarse = [], []
    scene = cloudy(air=False)
    for size, found in ((128, fine), (4, coarse)):
        with renderer_of(scene, (size, size), shape_texels=64, map_texels=512) as renderer:
            for latitude, longitude in ((20, 10), (-40, 100), (5, -60), (50, 0), (-15, -120)):
                fov = 2.0 * math.degrees(math.atan(60e3 / (1e6 - 2e3)))
                camera = pf.Camera.at(latitude, longitude, 1e6, pitch_deg=-90.0, fov_y_deg=fov)
                sun = pf.Sun(direction=tuple(pf.direction(latitude, longitude)))
                found.append(opacity(renderer, camera, sun=sun).mean())
    assert np.mean(coarse) == pytest.approx(np.mean(fine), abs=0.08)
    assert np.abs(np.subtract(coarse, fine)).max() < 0.2
    assert np.corrcoef(coarse, fine)[0, 1] > 0.9


def test_the_anchor_is_not_seen() -> None:
    """A proxy that is held puts the anchor elsewhere; noise, weather and shells stay where they are."""
    scene = cloudy(air=False)
    scene.planet[Clouds].layers = (CloudLayer(base_m=5e3, top_m=7e3, extinction_per_m=1e-3, coverage=0.8),)  # ice
    here = pf.Camera.at(20.0, 10.0, 9000.0, pitch_deg=-60.0)
    with renderer_of(scene) as one, renderer_of(scene) as other:
        fresh = opacity(one, here, sun=UP)
        for step in range(12):
            other.render(pf.Camera.at(20.0 + 0.0012 * (11 - step), 10.0, 9000.0, pitch_deg=-60.0), sun=UP)
        held = opacity(other, here, sun=UP)
        anchors = [r.views[0].proxy.anchor_m for r in (one, other)]
    assert np.linalg.norm(np.subtract(*anchors)) > 300.0
    # Offsets of kilometres in f32 are good to a millimetre, noise of 29 m to 3e-5.
    assert np.abs(held - fresh).mean() < 1e-3


def test_layers_that_overlap_in_view_and_ice_above_are_drawn_from_all_sides() -> None:
    clouds = Clouds(coverage=0.7)
    clouds.layers = (CloudLayer(base_m=8000.0, top_m=10000.0, extinction_per_m=6e-4, coverage=0.6),)
    with renderer_of(cloudy(clouds)) as renderer:
        for altitude in (10.0, 2500.0, 6000.0, 9000.0, 12e3, 4e5):
            for pitch in (-40.0, 0.0, 40.0):
                found = radiance(renderer, pf.Camera.at(20.0, 10.0, altitude, pitch_deg=pitch), sun=UP)
                assert found.max() < 1.0


# -- nothing breaks -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("radius_m", [1e3, 6.36e6, 7e7])
def test_no_planet_camera_or_sun_breaks_it(radius_m: float) -> None:
    base, top = (50.0, 90.0) if radius_m < 1e5 else (1500.0, 4000.0)
    scene = cloudy(radius_m=radius_m, base_m=base, top_m=top, coverage=0.7)
    directions = [(0.0, 0.0, 1.0), (0.3, -0.8, 0.2), (-1.0, 0.0, 0.0)]
    with renderer_of(scene, (16, 9)) as renderer:
        for altitude in (0.0, base - 1e-3, base, base + 1e-3, top - 1e-3, top, top + 1e-3, 3.0 * top, 3.0 * radius_m):
            for number, pitch in enumerate((-90.0, -20.0, 0.0, 30.0, 90.0)):
                camera = pf.Camera.at(40.0, 10.0, altitude, pitch_deg=pitch)
                sun = pf.Sun(direction=directions[number % 3])
                found = radiance(renderer, camera, sun=sun, time_s=1e8 if number == 2 else 0.0)
                assert np.isfinite(found).all() and found.min() >= 0.0


@pytest.mark.parametrize("boundary", ["base_m", "top_m"])
def test_crossing_a_boundary_in_steps_of_a_metre_is_smooth(boundary: str) -> None:
    clouds = Clouds(coverage=0.7)
    edge = getattr(clouds, boundary)
    with renderer_of(cloudy(clouds), fine_steps=256) as renderer:
        seen = [
            radiance(renderer, pf.Camera.at(20.0, 10.0, edge + k, pitch_deg=20.0), sun=UP).mean() for k in range(-4, 5)
        ]
    steps = np.abs(np.diff(seen))
    # The crossing itself (steps 3 and 4) is no larger than three times what its neighbours are.
    assert steps[3:5].max() < 3.0 * np.delete(steps, [3, 4]).max() + 1e-6


def test_steps_towards_the_sun_change_in_a_running_renderer_whether_maps_are_asked_or_not() -> None:
    """Few steps leave the rest to the maps of the shadow and many do without: two programs, to and fro."""
    scene, camera = cloudy(coverage=0.7), pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=20.0)
    elsewhere = pf.Camera.at(20.0, 10.0, 100.0, pitch_deg=80.0)
    with renderer_of(scene, sun_steps=12) as many, renderer_of(scene, sun_steps=2) as few:
        for one in (many, few):
            one.settle(elsewhere)  # the air's tables are whole, or they would still refine between these pictures
        alone = [radiance(one, camera, sun=UP) for one in (many, few)]
        assert np.abs(alone[0] - alone[1]).max() > 0.0
        for _ in range(2):
            for steps, expected in zip((12, 2), alone, strict=True):
                few.retune({"clouds.sun_steps": steps})
                np.testing.assert_array_equal(radiance(few, camera, sun=UP), expected)
