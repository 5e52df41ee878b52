"""Cameras, axes, projection, frustum and horizon in float64, and what bad input says."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.space import (
    CameraState,
    SpaceError,
    direction,
    frustum_planes,
    heading_pitch_axes,
    horizon_angle_rad,
    horizon_distance_m,
    latitude_longitude,
    local_axes,
    near_plane_m,
    out_of_view,
    pixel_rays,
    project,
    projection_terms,
    sight_distance_m,
    sphere_outside,
)

RNG = np.random.default_rng(4)
EARTH = 6.371e6


def test_directions_and_back():
    np.testing.assert_array_equal(direction(0, 0), [1, 0, 0])
    np.testing.assert_array_equal(direction(0, 90), [0, 1, 0])
    np.testing.assert_array_equal(direction(90, 123), [0, 0, 1])
    np.testing.assert_array_equal(direction(-90, 0), [0, 0, -1])
    latitude, longitude = RNG.uniform(-90, 90, 500), RNG.uniform(-180, 180, 500)
    found = latitude_longitude(direction(latitude, longitude) * 7e7)
    np.testing.assert_allclose(found[0], latitude, atol=1e-12)
    np.testing.assert_allclose(found[1], longitude, atol=1e-11)
    for bad in ((91, 0), (np.nan, 0), (0, np.inf)):
        with pytest.raises(SpaceError, match="direction"):
            direction(*bad)


def test_headings():
    place = direction(0, 0)
    forward, up = heading_pitch_axes(place, 0, 0)
    np.testing.assert_array_equal(forward, [0, 0, 1])
    np.testing.assert_array_equal(up, [1, 0, 0])
    np.testing.assert_array_equal(heading_pitch_axes(place, 90, 0)[0], [0, 1, 0])
    np.testing.assert_array_equal(heading_pitch_axes(place, 0, -90)[0], [-1, 0, 0])
    np.testing.assert_array_equal(heading_pitch_axes(place, 0, -90)[1], [0, 0, 1])
    place = direction(47.3, 11.2)
    forward, up = heading_pitch_axes(place, 123.0, 17.0)
    north, east = local_axes(place)
    assert forward @ place == pytest.approx(np.sin(np.radians(17)))
    assert np.degrees(np.arctan2(forward @ east, forward @ north)) == pytest.approx(123.0)
    assert forward @ up == pytest.approx(0.0, abs=1e-15)


@pytest.mark.parametrize("latitude", [90.0, -90.0])
def test_at_a_pole_heading_is_the_longitude_looked_along(latitude):
    for heading in (0.0, 30.0, 90.0, 200.0):
        forward, _ = heading_pitch_axes(direction(latitude, 77.0), heading, 0.0)
        np.testing.assert_allclose(forward, direction(0.0, heading), atol=1e-15)


def test_near_a_pole_north_is_still_north():
    place = direction(89.9999999, 60.0)
    forward, _ = heading_pitch_axes(place, 0.0, 0.0)
    np.testing.assert_allclose(forward, [-np.cos(np.radians(60)), -np.sin(np.radians(60)), 0], atol=1e-8)


@pytest.mark.parametrize(
    ("forward", "up"),
    [((0, 0, -1), (0, 0, 1)), ((0, 0, -1), (0, 0, -3)), ((1, 2, 3), (2, 4, 6)), ((0, 0, 1), None), ((1, 0, 0), None)],
)
@pytest.mark.parametrize("position", [(0, 0, 7e6), (7e6, 0, 0), (1e6, 2e6, 3e6), (0, 0, 0)])
def test_forward_parallel_to_up_gives_valid_axes(forward, up, position):
    camera = CameraState.look(position, forward, up)
    np.testing.assert_allclose(camera.axes @ camera.axes.T, np.eye(3), atol=1e-15)
    assert np.linalg.det(np.stack([camera.right, camera.up, -camera.forward])) == pytest.approx(1.0)
    again = CameraState.look(position, forward, up)
    np.testing.assert_array_equal(camera.axes, again.axes)


def test_right_is_right():
    camera = CameraState.look((7e6, 0, 0), (0, 0, 1), (1, 0, 0))
    np.testing.assert_allclose(camera.right, [0, 1, 0], atol=1e-15)  # looking north, east is on the right


@pytest.mark.parametrize(
    ("kwargs", "message"),
    [
        ({"position_m": (np.nan, 0, 0)}, "camera position_m: expected finite"),
        ({"position_m": (1, 2)}, "camera position_m: expected three numbers"),
        ({"position_m": "here"}, "camera position_m: expected three numbers"),
        ({"forward": (0, 0, 0)}, "forward: expected a direction, found the zero vector"),
        ({"forward": (np.inf, 0, 0)}, "forward: expected finite"),
        ({"up": (0, 0, 0)}, "up: expected a direction"),
        ({"up": (0, np.nan, 0)}, "up: expected finite"),
        ({"fov_y_deg": 180.0}, "fov_y_deg: expected a finite number between 0 and 180"),
        ({"fov_y_deg": np.nan}, "fov_y_deg"),
        ({"aspect": 0.0}, "aspect"),
        ({"near_m": -1.0}, "near_m"),
    ],
)
def test_bad_cameras_say_what_is_wrong(kwargs, message):
    good = {"position_m": (7e6, 0, 0), "forward": (0, 0, 1), "up": (1, 0, 0)}
    with pytest.raises(SpaceError, match=message):
        CameraState.look(**(good | kwargs))


def test_bad_frusta_say_what_is_wrong():
    for frustum in ((10, -10, -10, 10), (-90, 10, -10, 10), (-10, 10, np.nan, 10), (-10, 10, -10)):
        with pytest.raises(SpaceError, match="frustum"):
            CameraState.frustum_deg((7e6, 0, 0), (0, 0, 1), (1, 0, 0), frustum)


def test_tiny_and_huge_vectors_are_directions_too():
    for scale in (1e-300, 1e300):
        camera = CameraState.look((7e6, 0, 0), (0, 0, scale), (scale, 0, 0))
        np.testing.assert_array_equal(camera.forward, [0, 0, 1])


def test_symmetric_is_a_case_of_off_axis():
    a = CameraState.look((7e6, 0, 0), (0, 1, 1), (1, 0, 0), 60.0, 1.0)
    b = CameraState.frustum_deg((7e6, 0, 0), (0, 1, 1), (1, 0, 0), (-30, 30, -30, 30))
    assert projection_terms(a) == pytest.approx(projection_terms(b))
    assert projection_terms(a)[2:] == (0.0, 0.0)


def test_tiles_make_up_the_whole_picture():
    whole = CameraState.frustum_deg((7e6, 1e5, 0), (0, 1, 1), (1, 0, 0), (-40, 40, -20, 35))
    sx, sy, ox, oy = projection_terms(whole)
    tile = CameraState(
        whole.position_m, whole.forward, whole.up, whole.right, whole.tan_left, ox, oy, whole.tan_top
    )  # the upper left quarter
    size = (64, 48)
    rays = pixel_rays(whole, size)
    np.testing.assert_allclose(pixel_rays(tile, (32, 24)), rays[:24, :32], atol=1e-15)
    assert sx > 0
    assert sy > 0


def test_project_inverts_pixel_rays():
    camera = CameraState.frustum_deg((6.4e6, 1e5, -3e4), (-1, 2, 3), (1, 0, 0), (-50, 20, -10, 40))
    size = (40, 30)
    rays = pixel_rays(camera, size).reshape(-1, 3)
    distance = 10.0 ** RNG.uniform(-1, 9, len(rays))
    points = camera.position_m + rays * distance[:, None]
    pixels, in_front = project(camera, points, size)
    columns, rows = np.meshgrid(np.arange(40) + 0.5, np.arange(30) + 0.5)
    assert in_front.all()
    np.testing.assert_allclose(pixels, np.stack([columns.ravel(), rows.ravel()], axis=1), atol=1e-5)
    far = distance > 1e3
    np.testing.assert_allclose(pixels[far], np.stack([columns.ravel(), rows.ravel()], axis=1)[far], atol=1e-9)
    np.testing.assert_allclose(pixel_rays(camera, size, pixels[far]), rays[far], atol=1e-12)
    top = project(camera, (camera.position_m + camera.forward * 100 + camera.up * 80)[None], size)[0]
    assert top[0, 1] < project(camera, (camera.position_m + camera.forward * 100)[None], size)[0][0, 1]


def test_points_behind_have_no_pixel():
    camera = CameraState.look((7e6, 0, 0), (0, 0, 1), (1, 0, 0))
    pixels, in_front = project(camera, [[7e6, 0, -1], [7e6, 0, 1], [7e6, 0, 0]], (10, 10))
    np.testing.assert_array_equal(in_front, [False, True, False])
    assert np.isnan(pixels[[0, 2]]).all()
    np.testing.assert_allclose(pixels[1], [5, 5])
    with pytest.raises(SpaceError, match="points_m must have the shape"):
        project(camera, [1, 2, 3], (10, 10))
    with pytest.raises(SpaceError, match="size"):
        project(camera, [[1, 2, 3]], (0, 10))


def test_frustum_planes_agree_with_projection():
    camera = CameraState.frustum_deg((0, 0, 0), (1, 2, -1), (0, 0, 1), (-50, 20, -10, 40))
    points = RNG.normal(size=(5000, 3)) * 1e6
    inside = (points @ frustum_planes(camera).T >= 0).all(axis=1)
    pixels, in_front = project(camera, points, (2, 2))
    with np.errstate(invalid="ignore"):
        seen = in_front & (pixels >= 0).all(axis=1) & (pixels <= 2).all(axis=1)
    np.testing.assert_array_equal(inside, seen)
    assert 100 < seen.sum() < 4900
    assert not sphere_outside(frustum_planes(camera), points[seen], np.zeros(seen.sum())).any()
    radii = 10.0 ** RNG.uniform(4.0, 6.5, 500)
    outside = sphere_outside(np.vstack([frustum_planes(camera), camera.forward]), points[:500], radii)
    assert [out_of_view(camera, *sphere) for sphere in zip(points[:500], radii, strict=True)] == outside.tolist()
    assert 100 < outside.sum() < 400


def test_near_plane():
    assert near_plane_m(2.0) == 0.1
    assert near_plane_m(0.1) == pytest.approx(0.02)
    assert near_plane_m(-5.0) == 1e-3
    assert near_plane_m(1e9) == 0.1
    assert near_plane_m(np.nan) == 1e-3
    assert near_plane_m(np.inf) == 0.1


def test_horizon():
    # A centimetre above Earth the text-book acos has lost half its digits.
    assert horizon_distance_m(0.01, EARTH) == pytest.approx(np.sqrt(0.02 * EARTH), rel=1e-9)
    assert horizon_angle_rad(EARTH, EARTH) == pytest.approx(np.pi / 3)
    assert horizon_distance_m(-3.0, EARTH) == 0.0
    assert sight_distance_m(2.0, 8000.0, EARTH) == pytest.approx(
        horizon_distance_m(2.0, EARTH) + horizon_distance_m(8000.0, EARTH)
    )
