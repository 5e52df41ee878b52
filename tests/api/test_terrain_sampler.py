"""TerrainSampler: heights, normals, rays, contacts and patches against plain geometry."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

import planetfall as pf
from planetfall.query.terrain import TerrainSampler
from planetfall.systems.terrain.height import TerrainParams, height

EARTH = TerrainParams(seed=2)
ROCK = TerrainParams(1000.0, 9, 90.0, -80.0, 10, 0.5, plains=0.0, mountains=0.0, roughness=4.0)
WORLDS = {"earth": EARTH, "rock": ROCK}


@pytest.fixture(scope="module")
def earth():
    return TerrainSampler.from_params(EARTH)


def sphere(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def side_of(up):
    t = np.cross(up, [0.2, 0.5, 0.7])
    return t / np.linalg.norm(t, axis=1)[:, None]


def test_a_snapshot_of_a_scene():
    terrain = pf.Terrain(seed=5)
    scene = SimpleNamespace(planet={pf.Planet: pf.Planet(radius_m=3e6), pf.Terrain: terrain})
    sampler = TerrainSampler(scene)
    d = sphere(10)
    before = sampler.height(d)
    np.testing.assert_allclose(before, height(d, TerrainParams.from_component(terrain, 3e6)))
    np.testing.assert_allclose(sampler.height(1e-200 * d), before)
    terrain.seed = 6
    np.testing.assert_array_equal(sampler.height(d), before)
    with pytest.raises(ValueError, match=r"no Terrain component; add one with scene\.planet\.add"):
        TerrainSampler(SimpleNamespace(planet={pf.Planet: pf.Planet()}))


def test_a_planet_has_a_name():
    with pf.load_scene("earth_moon") as scene:
        name = next(n for n, planet in scene.planets.items() if planet is not scene.planet)
        named = pf.TerrainSampler(scene, planet=name)
        d = sphere(10)
        np.testing.assert_array_equal(named.height(d), pf.TerrainSampler(scene, scene.planets[name]).height(d))
        assert named.radius_m == scene.planets[name].radius_m != scene.planet.radius_m


@pytest.mark.parametrize("name", WORLDS)
def test_normals_stand_on_the_surface(name):
    params = WORLDS[name]
    sampler, up = TerrainSampler.from_params(params), sphere(40)
    normal = sampler.normal(up)
    np.testing.assert_allclose(np.linalg.norm(normal, axis=1), 1.0)
    step = 0.02 * params.scale * 0.5 ** (params.layers - 16) / params.radius_m
    for side in (side_of(up), np.cross(up, side_of(up))):
        ends = [up * np.cos(step) + s * side * np.sin(step) for s in (1.0, -1.0)]
        a, b = (d * (params.radius_m + sampler.height(d))[:, None] for d in ends)
        along = (a - b) / np.linalg.norm(a - b, axis=1)[:, None]
        assert np.abs((normal * along).sum(axis=1)).max() < 2e-3


@pytest.mark.parametrize("name", WORLDS)
def test_rays_down_find_the_height(name):
    params = WORLDS[name]
    sampler, up = TerrainSampler.from_params(params), sphere(50, 3)
    ground = params.radius_m + sampler.height(up)
    for above in (2.0, 1e4, 3.6e7):
        hit, distance = sampler.raycast(up * (ground + above)[:, None], -up)
        assert hit.all()
        np.testing.assert_allclose(distance, above, atol=2e-6 + 1e-14 * above)
    hit, distance = sampler.raycast(up * (ground + 100.0)[:, None], -up, 99.0)
    assert not hit.any() and np.isinf(distance).all()
    hit, _ = sampler.raycast(up * (ground + 2.0)[:, None], up)
    assert not hit.any()
    hit, distance = sampler.raycast(up * (ground - 1.0)[:, None], up)
    assert hit.all() and (distance == 0.0).all()


@pytest.mark.parametrize("name", WORLDS)
def test_slanting_rays_stop_at_the_first_ground(name):
    params = WORLDS[name]
    sampler, up = TerrainSampler.from_params(params), sphere(60, 4)
    side, ground = side_of(up), params.radius_m + sampler.height(up)
    origin = up * (ground + 0.1 * (params.highest_m - params.lowest_m))[:, None]
    ray = side - 0.15 * up
    ray /= np.linalg.norm(ray, axis=1)[:, None]
    hit, distance = sampler.raycast(origin, ray)
    assert hit.mean() > 0.5
    for i in np.flatnonzero(hit):
        end = origin[i] + distance[i] * ray[i]
        assert abs(np.linalg.norm(end) - params.radius_m - sampler.height(end)[0]) < 1e-4
        points = origin[i] + np.linspace(0.0, distance[i] * (1.0 - 1e-9), 800)[:, None] * ray[i]
        clearance = np.linalg.norm(points, axis=1) - params.radius_m - sampler.height(points)
        assert clearance.min() > -1e-3 * distance[i] * 0.01, "it did not pass through a hill"


def test_rays_past_the_planet_and_grazing_plains(earth):
    hit, _ = earth.raycast([[1e8, 0.0, 0.0], [1e8, 0.0, 0.0]], [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    assert not hit.any()
    up = sphere(10, 9)
    eye = up * (EARTH.radius_m + earth.height(up) + 2.0)[:, None]
    hit, distance = earth.raycast(eye, side_of(up))
    assert (distance[hit] < 1e6).all()


@pytest.mark.parametrize("radius", [0.5, 20.0])
def test_spheres_touch_the_ground(earth, radius):
    up = sphere(25, 5)
    normal = earth.normal(up)
    ground = up * (EARTH.radius_m + earth.height(up))[:, None]
    depth, out = earth.sphere_contact(ground + normal * (0.9 * radius), radius)
    assert (depth > 0.1 * radius - 1e-5 * radius).all(), "the point below is at 0.9 radius, others may be nearer"
    assert (depth < 0.5 * radius).all()
    assert ((out * normal).sum(axis=1) > 0.3).all()
    depth, out = earth.sphere_contact(ground + up * 3000.0, radius)
    np.testing.assert_allclose(depth, radius - 3000.0, rtol=1e-6)
    np.testing.assert_allclose(out, up)
    depth, _ = earth.sphere_contact(ground - up * radius, radius)
    assert (depth > radius).all()
    # Push out twice: clear of the ground.
    centers = ground + normal * (0.2 * radius)
    for _ in range(6):
        depth, out = earth.sphere_contact(centers, radius)
        centers = centers + out * np.maximum(depth, 0.0)[:, None]
    assert earth.sphere_contact(centers, radius)[0].max() < 0.02 * radius


def test_sweeps_stop_at_contact(earth):
    up = sphere(12, 6)
    ground = EARTH.radius_m + earth.height(up)
    start, end = up * (ground + 50.0)[:, None], up * (ground - 50.0)[:, None]
    hit, fraction, normal = earth.sweep(start, end, 1.0)
    assert hit.all() and (np.abs((normal * earth.normal(up)).sum(axis=1)) > 0.5).all()
    centers = start + fraction[:, None] * (end - start)
    depth, _ = earth.sphere_contact(centers, 1.0)
    assert np.abs(depth).max() < 0.05
    hit, fraction, _ = earth.sweep(start, start + up * 10.0, 1.0)
    assert not hit.any() and (fraction == 1.0).all()
    hit, fraction, _ = earth.sweep(end, start, 1.0)
    assert hit.all() and (fraction == 0.0).all()


def test_a_patch_is_the_ground_in_a_local_frame(earth):
    up = sphere(1, 7)[0]
    patch = earth.patch(up, 200.0, 10.0)
    assert patch.positions_m.shape == (21, 21, 3)
    np.testing.assert_allclose(patch.positions_m[10, 10], 0.0, atol=1e-6)
    np.testing.assert_allclose(patch.axes @ patch.axes.T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(np.cross(patch.axes[0], patch.axes[1]), up, atol=1e-12)
    world = patch.origin_m + patch.positions_m.reshape(-1, 3) @ patch.axes
    distance = np.linalg.norm(world, axis=1)
    np.testing.assert_allclose(distance - EARTH.radius_m, patch.heights_m.ravel(), atol=1e-6)
    np.testing.assert_allclose(earth.height(world), patch.heights_m.ravel(), atol=1e-5)
    np.testing.assert_allclose(patch.positions_m[:, :, 0], np.broadcast_to(patch.x_m, (21, 21)), atol=0.2)
    a, b, c = patch.positions_m.reshape(-1, 3)[patch.triangles()].swapaxes(0, 1)
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()
    assert (patch.normals[..., 2] > 0.0).all()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.height([[1, 0, 0], [0, 0, 0]]), r"directions\[1\]: expected a direction, found the zero vector"),
        (
            lambda s: s.normal([[1, 0, float("nan")]]),
            r"directions\[0\]: expected finite numbers, found \[1.0, 0.0, nan",
        ),
        (lambda s: s.height([[1, 0]]), r"directions: expected vectors of shape \(N, 3\), found shape \(1, 2\)"),
        (lambda s: s.raycast(np.ones((2, 3)), np.ones((3, 3))), r"the same number of vectors, found 2 and 3"),
        (lambda s: s.raycast([[1, 0, 0]], [[1, 0, 0]], -1.0), r"max_distance_m\[0\]: .* from 0 up, found -1.0"),
        (lambda s: s.sphere_contact([[1, 0, 0]], [1, 2]), r"radii_m: expected one number or 1, found shape \(2,\)"),
        (lambda s: s.patch([1, 0, 0], 10.0, 20.0), r"0 < spacing_m <= size_m, found size_m=10.0, spacing_m=20.0"),
        (lambda s: s.patch([1, 0, 0], 1e5, 1.0), r"100001 x 100001 points are too many"),
        (lambda s: s.height("abc"), r"directions: expected real numbers, all rows equally long, found 'abc'"),
        (lambda s: s.sphere_contact([[1, 0, 0]], "wide"), r"radii_m: expected real numbers"),
        (lambda s: s.patch([1, 0, 0], 10.0, 1.0, frame=3), r"frame: expected a TerrainPatch or \(origin_m, axes\)"),
        (lambda s: pf.TerrainSampler("earth"), r"expected a scene such as pf.load_scene\('earth'\), found 'earth'"),
        (lambda s: pf.TerrainSampler(pf.load_scene("moon"), "mars"), r"planet must be one of scene.planets, .* 'mars'"),
    ],
)
def test_bad_input_says_what_and_where(earth, call, message):
    with pytest.raises(ValueError, match=message):
        call(earth)


def test_nothing_but_numbers_of_a_place_is_taken():
    sampler = pf.TerrainSampler(pf.load_scene("moon"))
    place = np.array([[0.0, 0.0, 1.0]])
    with pytest.raises(ValueError, match=r"centers_m\[0\]"):
        sampler.sphere_contact([[0.0, 0.0, 0.0]], 1.0)
    with pytest.raises(ValueError, match=r"start_m\[0\]: no ground is nearest to the planet's centre"):
        sampler.sweep([[0.0, 0.0, 0.0]], place * 1.8e6, 1.0)
    with pytest.raises(ValueError, match=r"radii_m\[0\]"):
        sampler.sphere_contact(place * 1.8e6, np.inf)
    for footprint_m in (np.nan, -1.0):
        with pytest.raises(ValueError, match="footprint_m"):
            sampler.normal(place, footprint_m)


def test_ground_that_no_renderer_would_draw_is_refused():
    scene = pf.load_scene("asteroid")
    scene.planet[pf.Planet].radius_m = 500.0
    scene.planet[pf.Terrain].highest_m, scene.planet[pf.Terrain].lowest_m = 600.0, -100.0
    with pytest.raises(pf.SettingError, match="highest_m"):
        pf.TerrainSampler(scene)
