"""Trunks for games: spheres that touch them, bodies for a physics engine, a walker that goes around them."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest
from app_kit import app_of
from cover_kit import PLACE, woods
from flight_kit import EARTH, pose_at

import planetfall as pf
from planetfall.engine.frame.gbuffer import Surface
from planetfall.systems.cover.stand import Plants, Species
from planetfall.systems.cover.trunks import ACACIA_TRUNK, PALM_TRUNK, TREE_TRUNK, Trunks, touch
from planetfall.systems.flight import FlightInput, Ground, WalkFlight, WalkLimits

TREE = pf.ASSETS / "shaders" / "cover" / "tree.glsl"


@pytest.fixture(scope="module")
def scene():
    with woods() as found:
        yield found


@pytest.fixture(scope="module")
def sampler(scene):
    return pf.CoverSampler(scene)


@pytest.fixture(scope="module")
def trees(sampler):
    return with_trunks(sampler.within(PLACE, 150.0))


def with_trunks(plants: Plants) -> Plants:
    """Without shrubs."""
    return plants.only(plants.species != Species.SHRUB)


def upright(heights_m, species, middle=(0.0, 0.0, EARTH), apart_m=100.0) -> Plants:
    """Trees in a row, so far apart that they don't meet."""
    count = len(heights_m)
    places = np.asarray(middle) + apart_m * np.arange(count)[:, None] * np.array([1.0, 0.0, 0.0])
    places *= (EARTH / np.linalg.norm(places, axis=1))[:, None]
    tall = np.asarray(heights_m, dtype=np.float64)
    names = np.zeros((count, 5), np.int64)
    return Plants(places, tall, 0.3 * tall, np.asarray(species), names, np.zeros((count, 3)), np.zeros(count))


def cone_points(trunks: Trunks, k: int, count: int) -> np.ndarray:
    """Points on the side of a trunk, dense and even, planet-centred."""
    axis = trunks.axes[k]
    east = np.cross((0.0, 1.0, 0.0), axis)
    east /= np.linalg.norm(east)
    low = -trunks.roots_m[k]
    z, turn = (
        c.ravel() for c in np.meshgrid(np.linspace(low, trunks.lengths_m[k], count), np.linspace(0, 2 * np.pi, 90))
    )
    wide = trunks.foot_radii_m[k] * (1.0 - z / trunks.lengths_m[k])
    aside = np.cos(turn)[:, None] * east + np.sin(turn)[:, None] * np.cross(axis, east)
    return trunks.feet_m[k] + z[:, None] * axis + wide[:, None] * aside


# -- the cone --------------------------------------------------------------------------------------------------------


def test_the_cone_is_the_shaders():
    text = TREE.read_text(encoding="utf-8")
    assert float(re.search(r"const float TREE_TRUNK = ([\d.]+);", text)[1]) == TREE_TRUNK
    thick = re.search(r"ACACIA_TRUNK = ([\d.]+), PALM_TRUNK = ([\d.]+);", text)
    assert thick is not None and [float(v) for v in thick.groups()] == [ACACIA_TRUNK, PALM_TRUNK]
    ends = re.search(r"tree_trunk\(found, r, conifer \|\| r.flat_top \? ([\d.]+) : ([\d.]+)\)", text)
    assert ends is not None
    tall, other = (float(v) for v in ends.groups())
    assert float(re.search(r"z < -([\d.]+) \|\| z > height", text)[1]) == 0.05
    kinds = [Species.CONIFER, Species.BROADLEAF, Species.DEAD, Species.ACACIA, Species.PALM]
    found = Trunks.of(upright([10.0] * 5, kinds))
    np.testing.assert_allclose(found.lengths_m, [10.0 * tall, 10.0 * other, 10.0 * other, 10.0 * tall, 10.0 * tall])
    wide = [TREE_TRUNK, TREE_TRUNK, TREE_TRUNK, ACACIA_TRUNK, PALM_TRUNK]
    np.testing.assert_allclose(found.foot_radii_m, [10.0 * w for w in wide])
    np.testing.assert_allclose(found.roots_m, 0.5)


@pytest.mark.parametrize("species", [Species.BROADLEAF, Species.CONIFER])
def test_depths_agree_with_the_nearest_of_many_points_of_the_cone(species):
    trunks = Trunks.of(upright([14.0], [species]))
    points, rng = cone_points(trunks, 0, 3000), np.random.default_rng(2)
    centers = trunks.feet_m[0] + rng.uniform((-2.5, -2.5, 0.0), (2.5, 2.5, 13.0), (300, 3))
    depth, normal = touch(trunks, centers, np.full(300, 0.4))
    away = np.linalg.norm(centers[:, None] - points[None, ::7], axis=2).min(axis=1)
    offset = centers - trunks.feet_m[0]
    z = offset @ trunks.axes[0]
    aside = np.linalg.norm(offset - z[:, None] * trunks.axes[0], axis=1)
    inside = aside < trunks.foot_radii_m[0] * (1.0 - z / trunks.lengths_m[0])
    # Points are 5 mm apart along the trunk, times 7, and 2 cm around it: a millimetre from 10 cm, less farther away.
    clear = ~inside & (away > 0.1)
    assert clear.sum() > 200
    np.testing.assert_allclose(depth[clear], 0.4 - away[clear], atol=2e-3)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-12)
    # What is pushed out by its depth only touches.
    pushed, _ = touch(trunks, centers + normal * depth[:, None], np.full(300, 0.4))
    np.testing.assert_allclose(pushed, 0.0, atol=1e-6)


def test_in_the_middle_of_a_trunk_it_is_pushed_aside():
    trunks = Trunks.of(upright([14.0], [Species.BROADLEAF]))
    depth, normal = touch(trunks, trunks.feet_m + 2.0 * trunks.axes, np.array([0.3]))
    assert depth[0] == pytest.approx(0.3 + 14.0 * TREE_TRUNK * (1.0 - 2.0 / 11.2), rel=1e-3)
    assert abs(float(normal[0] @ trunks.axes[0])) < 0.05


def test_of_several_trunks_the_deepest_counts():
    trunks = Trunks.of(upright([20.0, 10.0], [0, 0], apart_m=1.0))
    middle = trunks.feet_m.mean(axis=0, keepdims=True) + trunks.axes[:1]
    depth, normal = touch(trunks, middle, np.array([0.5]))
    alone = [
        touch(Trunks.of(upright([20.0, 10.0], [0, 0], apart_m=1.0).only([k])), middle, np.array([0.5])) for k in (0, 1)
    ]
    assert alone[0][0][0] > alone[1][0][0]
    np.testing.assert_array_equal((depth[0], *normal[0]), (alone[0][0][0], *alone[0][1][0]))


# -- the sampler -----------------------------------------------------------------------------------------------------


def test_contacts_are_those_of_the_trees_there(sampler, trees):
    """Wherever spheres are, and however many at once: as of all trees around, one by one."""
    rng = np.random.default_rng(4)
    inner = with_trunks(sampler.within(PLACE, 60.0))
    centers = inner.positions_m[rng.integers(len(inner), size=150)] + rng.normal(size=(150, 3)) * (1.5, 1.5, 1.5)
    radii = rng.uniform(0.1, 3.0, 150)
    depth, normal = sampler.sphere_contact(centers, radii)
    everything, aside = touch(Trunks.of(trees), centers, radii)
    np.testing.assert_allclose(depth, everything, atol=1e-6)
    np.testing.assert_allclose(normal, aside, atol=1e-5)
    one = sampler.sphere_contact(centers[7], radii[7])
    np.testing.assert_allclose(one[0], depth[7:8], atol=1e-6)
    assert (depth > 0.0).sum() > 20 and (depth < 0.0).sum() > 20


@pytest.mark.parametrize("radius_m", [15.0, 150.0, 900.0])
def test_wide_spheres_touch_trunks_of_other_plots(sampler, radius_m):
    """A ball whose side touches the trunk of a tree far from what is below its middle."""
    inner = sampler.within(PLACE, 30.0)
    foot = inner.positions_m[inner.heights_m.argmax()]
    up = foot / np.linalg.norm(foot)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    center = foot + 1.0 * up + radius_m * east
    depth, _ = sampler.sphere_contact(center, radius_m)
    assert depth[0] > 0.1


def test_far_from_trees_there_is_none(scene, sampler):
    sea = pf.view("sea", scene.planet).camera.resolve(scene).position_m
    for center in (PLACE * (EARTH + 50_000.0), sea, PLACE * 10.0):
        depth, normal = sampler.sphere_contact(center, 1.0)
        assert depth[0] == -np.inf
        np.testing.assert_allclose(normal[0], center / np.linalg.norm(center))
    depth, normal = sampler.sphere_contact(np.zeros((0, 3)), 1.0)
    assert depth.shape == (0,) and normal.shape == (0, 3)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda s: s.sphere_contact([[1, 0]], 1.0),
            r"centers_m: expected vectors of shape \(N, 3\), found shape \(1, 2\)",
        ),
        (lambda s: s.sphere_contact([[1, 0, np.nan]], 1.0), r"centers_m\[0\]: expected finite numbers"),
        (lambda s: s.sphere_contact([[0, 0, 0]], 1.0), r"centers_m\[0\]: .*planet's centre"),
        (lambda s: s.sphere_contact([[1, 0, 0]], [1, 2]), r"radii_m: expected one number or 1, found shape \(2,\)"),
        (
            lambda s: s.sphere_contact([[1, 0, 0]], -1.0),
            r"radii_m\[0\]: expected a number of metres from 0 up, found -1",
        ),
        (lambda s: s.sphere_contact(np.eye(3), [1, 2, 2e3]), r"radii_m\[2\]: expected at most 1000 m, found 2000"),
        (lambda s: s.bodies(PLACE, -1.0), r"radius_m: expected metres above 0"),
        (lambda s: s.bodies(np.eye(3), 10.0), r"direction: expected one, \(3,\), found 3"),
        (
            lambda s: s.bodies(PLACE, 10.0, frame=3),
            r"frame: expected a TerrainPatch or \(origin_m, axes\), found 3",
        ),
    ],
)
def test_bad_input_is_named(sampler, call, message):
    with pytest.raises(ValueError, match=message):
        call(sampler)


def test_trunks_are_where_the_picture_shows_them(scene, sampler):
    """Rays through pixels that meet a trunk two metres ahead, and pixels that show it, are the same but for its rim."""
    eye = pf.view("forest", scene.planet).camera.resolve(scene).position_m
    around = sampler.within(eye, 60.0)
    broad = around.only((around.species == Species.BROADLEAF) & (around.heights_m > 10.0))
    foot = broad.positions_m[np.linalg.norm(broad.positions_m - eye, axis=1).argmin()]
    up = foot / np.linalg.norm(foot)
    east = np.cross((0.0, 0.0, 1.0), up)
    east /= np.linalg.norm(east)
    latitude, longitude = (float(v) for v in pf.latitude_longitude(foot + 2.0 * east))
    camera = pf.Camera.at(latitude, longitude, 1.5, above="ground", heading_deg=-90.0)
    overrides = {"cover.reach_m": 60.0, "composite.antialiasing": "none"}
    with pf.Renderer(scene, size=(160, 90), quality="low", overrides=overrides) as renderer:
        renderer.settle(camera)
        out = renderer.render(camera, outputs=("surface", "distance"))
        state = renderer.camera_state(camera)
    rows, columns = np.arange(30, 56, 5), np.arange(160)
    seen = ((out["surface"] == Surface.COVER) & (out["distance"] < 2.5))[rows]
    x = state.tan_left + (columns + 0.5) / 160.0 * (state.tan_right - state.tan_left)
    y = state.tan_top + (rows + 0.5) / 90.0 * (state.tan_bottom - state.tan_top)
    rays = state.forward + x[None, :, None] * state.right + y[:, None, None] * state.up
    points = state.position_m + rays[:, :, None] * np.linspace(1.0, 2.4, 141)[:, None]
    depth, _ = sampler.sphere_contact(points.reshape(-1, 3), 0.0)
    met = (depth.reshape(*seen.shape, -1) > 0.0).any(axis=-1)
    assert (met.sum(axis=1) > 15).all()
    assert (np.abs(met.astype(int) - seen).sum(axis=1) <= 2).all()


# -- bodies ----------------------------------------------------------------------------------------------------------


def test_bodies_hold_their_trunks(scene, sampler):
    found = sampler.bodies(PLACE, 80.0)
    trees = with_trunks(sampler.within(PLACE, 80.0))
    np.testing.assert_array_equal(found.names, trees.names)
    trunks = Trunks.of(trees)
    low = found.to_planet(found.middles_m - found.half_lengths_m[:, None] * found.directions)
    high = found.to_planet(found.middles_m + found.half_lengths_m[:, None] * found.directions)
    np.testing.assert_allclose(high, trunks.feet_m + trunks.lengths_m[:, None] * trunks.axes, atol=1e-6)
    np.testing.assert_allclose(low, trunks.feet_m - trunks.roots_m[:, None] * trunks.axes, atol=1e-6)
    # At 1.3 m a ball that touches the cylinder touches the cone.
    tall = trunks.lengths_m > 2.6
    aside = np.cross(trunks.axes, (0.0, 0.0, 1.0))
    aside /= np.linalg.norm(aside, axis=1)[:, None]
    rim = trunks.feet_m + 1.3 * trunks.axes + found.radii_m[:, None] * aside
    away, _ = trunks.distance(np.flatnonzero(tall), (rim - trunks.feet_m)[tall])
    np.testing.assert_allclose(away, 0.0, atol=1e-6)
    assert (found.radii_m < found.foot_radii_m).all() and len(found) > 100
    # Its origin is the ground at the place, as of a patch there.
    patch = pf.TerrainSampler(scene).patch(PLACE, 20.0, 1.0, normals=False)
    np.testing.assert_allclose(found.origin_m, patch.origin_m, atol=1e-6)
    np.testing.assert_allclose(found.axes, patch.axes, atol=1e-12)
    assert abs(found.middles_m[:, 2]).max() < 80.0


def test_bodies_in_the_frame_of_a_patch(scene, sampler):
    own = sampler.bodies(PLACE, 40.0)
    patch = pf.TerrainSampler(scene).patch(pf.direction(9.233, 29.98), 50.0, 1.0, normals=False)
    for frame in (patch, (patch.origin_m, patch.axes)):
        found = sampler.bodies(PLACE, 40.0, frame=frame)
        np.testing.assert_allclose(found.to_planet(found.middles_m), own.to_planet(own.middles_m), atol=1e-6)
        np.testing.assert_allclose(found.directions @ found.axes, own.directions @ own.axes, atol=1e-12)
        np.testing.assert_allclose(found.to_frame(found.to_planet(found.middles_m)), found.middles_m, atol=1e-6)


@pytest.mark.parametrize("axis", [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, 0.0, -1.0)])
def test_rotations_turn_an_engines_axis_along_the_trunk(sampler, axis):
    found = sampler.bodies(PLACE, 40.0)
    x, y, z, w = found.rotations(axis).T
    own = np.tile(axis, (len(found), 1))
    vector = np.stack([x, y, z], axis=1)
    t = 2.0 * np.cross(vector, own)
    turned = own + w[:, None] * t + np.cross(vector, t)
    np.testing.assert_allclose(turned, found.directions, atol=1e-9)


# -- on foot ---------------------------------------------------------------------------------------------------------


def nearest_trunk_m(body: WalkFlight, trunks: Trunks) -> float:
    """From the axis of the walker to a trunk's, at the waist."""
    waist = body.position_m * (1.0 - 0.7 / np.linalg.norm(body.position_m))
    return -float(touch(trunks, waist[None], np.zeros(1))[0][0])


@pytest.mark.parametrize("aside_m", [0.0, 0.2, -0.5])
def test_a_walker_goes_around_a_trunk(aside_m):
    pose = pose_at(0.0, 0.0, 50.0, heading=90.0)
    up, east, north = np.eye(3)
    foot = up * EARTH + 5.0 * east + aside_m * north
    tree = upright([15.0], [0])
    trunks = Trunks.of(dataclasses.replace(tree, positions_m=foot[None]))
    body = WalkFlight(Ground(EARTH), pose.position_m, pose.forward, obstacles=lambda c, r: touch(trunks, c, r))
    nearest = np.inf
    for _ in range(240):
        body.update(FlightInput(forward=1.0), 1.0 / 60.0)
        nearest = min(nearest, nearest_trunk_m(body, trunks))
    gone = float(body.position_m @ east)
    assert nearest == pytest.approx(WalkLimits().body_m, abs=1e-3)
    # Straight at its middle it stands before it; beside that it slides along and goes on.
    assert gone < 5.0 if aside_m == 0.0 else gone > 8.0
    free = WalkFlight(Ground(EARTH), pose.position_m, pose.forward)
    for _ in range(240):
        free.update(FlightInput(forward=1.0), 1.0 / 60.0)
    assert float(free.position_m @ east) > 15.0


def test_in_a_forest_a_walker_is_never_in_a_trunk(scene, sampler, trees):
    trunks, field = Trunks.of(trees), scene.height_field()
    start = PLACE * (EARTH + 5000.0)
    forward = np.cross((0.0, 0.0, 1.0), PLACE)
    body = WalkFlight(Ground(EARTH, field), start, forward, obstacles=sampler.sphere_contact)
    met = 0
    for step in range(900):
        body.update(FlightInput(forward=1.0, look_yaw_rad=0.004 * (step % 7)), 1.0 / 60.0)
        away = nearest_trunk_m(body, trunks)
        assert away > WalkLimits().body_m - 0.02
        met += away < WalkLimits().body_m + 0.05
    assert met > 3


def test_the_flight_knows_the_trunks_of_the_planet_below(scene, sampler):
    """On foot alone; after felled trees and changed knobs."""
    app, _, renderer = app_of(scene)
    renderer.field = scene.height_field()
    app.frame()
    assert app.pilot.walker.obstacles is None
    app.place(pf.Camera.at(9.23, 29.98, 1.7, above="ground"))
    app.switch("walk")
    app.frame()
    cover, found = scene.planet[pf.Cover], sampler.within(PLACE, 30.0)
    breast = found.positions_m[:1] * (1.0 + 1.0 / EARTH)
    depth, _ = app.pilot.walker.obstacles(breast, np.array([0.35]))
    assert depth[0] == pytest.approx(sampler.sphere_contact(breast, 0.35)[0][0], abs=1e-6) and depth[0] > 0.3
    try:
        cover.felled = found.names[:1]
        app.frame()
        assert app.pilot.walker.obstacles(breast, np.array([0.35]))[0][0] < 0.3
        cover.felled, cover.density = (), 0.0
        app.frame()
        assert app.pilot.walker.obstacles is None
    finally:
        cover.felled, cover.density = (), 1.0
