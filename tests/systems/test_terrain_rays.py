"""Ray casts and contacts against plain, slow answers: marches of even steps, dense grids. Several kinds of ground."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import queries
from planetfall.query.terrain import TerrainSampler
from planetfall.systems.terrain.crater_paths import found_along, rest_m
from planetfall.systems.terrain.height_octaves import carved
from planetfall.systems.terrain.height_surface import limit
from planetfall.systems.terrain.ray_ground import Kind, detail_of, ground_at, layers_at


@pytest.fixture(scope="module", params=["earth", "moon", "mars", "asteroid"])
def scene(request):
    with pf.load_scene(request.param) as loaded:
        yield loaded


@pytest.fixture(scope="module")
def ground(scene):
    return TerrainSampler(scene)


@pytest.fixture(scope="module")
def earth():
    scene = pf.load_scene("earth")
    yield TerrainSampler(scene)
    scene.release()


def anywhere(sampler, above, pitch_deg, reach, count, seed):
    """Lengths as shares of the radius, so that an asteroid has its own."""
    rng = np.random.default_rng(seed)
    up = rng.normal(size=(count, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    side = np.cross(up, rng.normal(size=up.shape))
    side /= np.linalg.norm(side, axis=1)[:, None]
    pitch = np.radians(rng.uniform(*pitch_deg, count))[:, None]
    origins = up * (sampler.radius_m + sampler.height(up) + above)[:, None]
    return queries.Rays("", origins, side * np.cos(pitch) + up * np.sin(pitch), reach)


@pytest.mark.parametrize(
    ("above_m", "pitch_deg", "reach_m"), [(2.0, (-4.0, 2.0), 1500.0), (30.0, (-12.0, -2.0), 1500.0)]
)
def test_no_ground_before_the_hit(ground, above_m, pitch_deg, reach_m):
    """A march of quarter metres finds nothing that a cast has passed, but a centimetre at its end."""
    scale = min(ground.radius_m / 1.7e6 * 100.0, 1.0)
    asked = anywhere(ground, above_m * scale, pitch_deg, reach_m * scale, 60, 1)
    hit, distance = ground.raycast(asked.origins_m, asked.directions, asked.reach_m)
    assert 0.1 < hit.mean() <= 1.0
    late, looked = queries.earlier_ground(ground, asked, hit, distance, 0.25 * scale)
    assert looked > 3000 and late.max() < 0.01
    assert queries.residual_m(ground, asked, hit, distance) < 1e-6


def test_level_rays_over_hundreds_of_kilometres(earth):
    asked = anywhere(earth, 4000.0, (-3.5, -0.5), 4e5, 40, 2)
    hit, distance = earth.raycast(asked.origins_m, asked.directions, asked.reach_m)
    assert 0.2 < hit.mean() < 1.0 and distance[hit].max() > 1e5
    late, looked = queries.earlier_ground(earth, asked, hit, distance, 20.0)
    assert looked > 50_000 and late.max() < 0.01
    # The same ray from farther back hits the same place: it comes in from space.
    back = asked.origins_m - 1e7 * asked.directions
    clear = ~earth.raycast(asked.origins_m, -asked.directions)[0]
    again, farther = earth.raycast(back, asked.directions, 1e7 + asked.reach_m)
    assert clear.sum() > 10 and (again[clear] == hit[clear]).all()
    both = clear & hit
    np.testing.assert_allclose(farther[both] - 1e7, distance[both], atol=1e-4)


def test_grazing_a_summit(earth):
    """Rays through points just above and just below the ground, along it: the lower ones hit there at the latest."""
    up = queries.land(earth, 40, np.random.default_rng(3))
    normal = earth.normal(up)
    along = np.cross(normal, [0.3, 0.5, 0.8])
    along /= np.linalg.norm(along, axis=1)[:, None]
    ground = up * (earth.radius_m + earth.height(up))[:, None]
    origins = ground - 0.05 * normal - 300.0 * along
    outside = np.linalg.norm(origins, axis=1) - earth.radius_m - earth.height(origins) > 0.0
    hit, distance = earth.raycast(origins[outside], along[outside], 1000.0)
    assert outside.sum() > 5 and hit.all() and (distance <= 300.0 + 1e-6).all()


@pytest.mark.filterwarnings("error")
def test_rays_from_deep_below_hit_where_they_begin(ground):
    """At the planet's centre, too, where no direction is up: the origin itself is below the ground."""
    deep = np.array([[0.0, 0.0, 0.0], [1.0, -2.0, 3.0], [0.0, 0.0, 0.9 * (ground.radius_m + ground.lowest_m)]])
    for way in np.eye(3):
        hit, distance = ground.raycast(deep, way, 10.0 * ground.radius_m)
        assert hit.all() and (distance == 0.0).all()


@pytest.mark.parametrize("bad", [[0.0, 0.0, 0.0], [np.nan, 1.0, 0.0], [np.inf, 1.0, 0.0]])
def test_bad_rays_are_refused(earth, bad):
    with pytest.raises(ValueError, match=r"directions\[1\]: expected"):
        earth.raycast([[7e6, 0, 0]] * 2, [[0, 1, 0], bad])
    if np.isnan(bad).any():
        with pytest.raises(ValueError, match=r"origins_m\[0\]: expected finite"):
            earth.raycast([bad], [[0, 1, 0]])


def test_rays_that_see_no_ground(earth):
    r = earth.radius_m
    origins = np.array([[r + 1e7, 0, 0], [r + 1e7, 0, 0], [r + 20e3, 0, 0], [0.0, 0.0, 0.0], [r - 5e4, 0, 0]])
    directions = np.array([[1.0, 0, 0], [0, 1, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0]])
    hit, distance = earth.raycast(origins, directions)
    assert hit.tolist() == [False, False, False, True, True], "away, past, level above all ground; then from inside"
    assert np.isinf(distance[:3]).all() and (distance[3:] == 0.0).all()
    assert earth.raycast(np.empty((0, 3)), np.empty((0, 3)))[0].shape == (0,)


def stretches(radius_m, length_m, count, points, rng):
    """Places (3, count, points) on the reference sphere along great circles of `length_m`."""
    up = rng.normal(size=(3, count))
    up /= np.linalg.norm(up, axis=0)
    side = np.cross(up.T, rng.normal(size=(count, 3))).T
    side /= np.linalg.norm(side, axis=0)
    t = np.linspace(0.0, length_m / radius_m, points)
    return radius_m * (up[..., None] * np.cos(t) + side[..., None] * np.sin(t))


@pytest.mark.parametrize("name", ["moon", "mars", "asteroid"])
def test_craters_along_a_stretch_are_all_there(name):
    """Those of each stretch add what all craters add at its ends and, halved, at its middle; between them no ground
    rises above the bounds, which are no statistics here."""
    scene = pf.load_scene(name)
    craters = scene.planet.height_field().model.craters
    scene.release()
    rng = np.random.default_rng(8)
    # Lattices are offset by up to 4096 cells, whose places are rounded likewise; walls are not steeper than 1.
    rounding = 4.0 * np.finfo(float).eps * (4096.0 / craters.frequency[0] + craters.radius_m)
    for k in range(2, len(craters), 3):
        octaves = replace(
            craters, frequency=craters.frequency[: k + 1], offset=craters.offset[: k + 1], shape=craters.shape[: k + 1]
        )
        length = min(0.98 / craters.frequency[k], 0.1 * craters.radius_m)
        places = stretches(craters.radius_m, length, 200, 65, rng)
        true = octaves.heights(places.reshape(3, -1)).reshape(200, 65)
        first, middle, last = (np.ascontiguousarray(places[..., at]) for at in (0, 32, 64))
        each = np.full(200, length)
        found, a, b = found_along(craters, np.arange(k + 1), (first, last), each)
        halves, at_middle = found.halves(craters, middle, 0.5 * each, 200)
        off = np.abs(np.stack([a - true[:, 0], b - true[:, -1], at_middle - true[:, 32]])).max()
        assert off < rounding
        rises = halves.rise(craters, np.repeat(0.5 * each, 2)).reshape(200, 2)
        parts = ((true, found.rise(craters, each)), (true[:, :33], rises[:, 0]), (true[:, 32:], rises[:, 1]))
        for part, bound in parts:
            line = part[:, :1] + (part[:, -1:] - part[:, :1]) * np.linspace(0.0, 1.0, part.shape[1])
            assert ((part - line).max(axis=1) <= bound + rounding).all()
        up, down = rest_m(craters, k + 1)
        rest = craters.heights(places.reshape(3, -1)).reshape(200, 65) - true
        assert rest.max() <= up and rest.min() >= -down


def test_ground_stays_within_its_bound(scene, ground):
    """All ground between two places against the line between what a ray knows of them, with only the layers and craters
    that it looks at: above the bound in one case of a thousand at most, and then by little."""
    rng = np.random.default_rng(4)
    field = scene.planet.height_field()
    craters = field.model.craters
    over, count = [], 0
    for share in (1e-7, 1e-6, 1e-5, 1e-4, 1e-3):
        length = 2.0 ** round(np.log2(share * ground.radius_m * (100.0 if ground.radius_m < 1e4 else 1.0)))
        detail = detail_of(field.model, length)
        places = stretches(ground.radius_m, length, 300, 41, rng)
        ends = [np.ascontiguousarray(places[..., at]) for at in (0, -1)]
        (base, z, _, kind, _), (last, last_z, _, last_kind, _) = (ground_at(end, detail) for end in ends)
        known = [base + kind[Kind.ROUGH] * (z + detail.mean_m), last + last_kind[Kind.ROUGH] * (last_z + detail.mean_m)]
        bound = detail.rise(np.full(300, length), np.maximum(kind, last_kind))
        if craters is not None:
            found, *added = found_along(craters, np.arange(detail.octaves), tuple(ends), np.full(300, length))
            known = [h + more for h, more in zip(known, added, strict=True)]
            bound += found.rise(craters, np.full(300, length))
        first, final = (limit(field.model.constants, h)[:, None] for h in known)
        true = ground.height(places.reshape(3, -1).T).reshape(300, 41)
        over.append((true - first - (final - first) * np.linspace(0.0, 1.0, 41)).max(axis=1) / bound)
        count += 300
    worst = np.concatenate(over)
    assert (worst > 1.0).sum() <= 0.001 * count + 1 and worst.max() < 1.5


def test_layers_come_in_one_by_one(scene, ground):
    """Relief looked at in steps is the relief of all layers, and heights are the sampler's."""
    field = scene.planet.height_field()
    places = stretches(ground.radius_m, 1e-3 * ground.radius_m, 30, 3, np.random.default_rng(5)).reshape(3, -1)
    finest = float(field.model.wavelength_m[-1])
    before = detail_of(field.model, 2.0 ** np.ceil(np.log2(1e3 * finest)))
    base, z, furrows, kind, cut = ground_at(places, before)
    for _ in range(12):
        now = detail_of(field.model, before.length_m / 2.0)
        if now.layers > before.layers:
            z += layers_at(places, before, now)
        before = now
    assert before.layers == field.model.layers and before.rest_m == 0.0 and before.mean_m == 0.0
    added = field.model.craters.heights(places) if field.model.craters else 0.0
    whole = limit(field.model.constants, base + kind[Kind.ROUGH] * z + added)
    whole = carved(whole, *cut, furrows)
    np.testing.assert_allclose(whole, ground.height(places.T), atol=1e-13 * ground.radius_m)


@pytest.mark.parametrize("radius", [0.5, 2.0])
def test_contacts_are_the_nearest_ground(earth, radius):
    rng = np.random.default_rng(6)
    up = queries.land(earth, 25, rng)
    centers = up * (earth.radius_m + earth.height(up) + radius * rng.uniform(0.2, 1.2, 25))[:, None]
    depth, normal = earth.sphere_contact(centers, radius)
    nearest = queries.nearest_m(earth, centers, radius, 161)
    # A grid's point is up to half a diagonal (0.7 x 3 r / 160) aside of the nearest, and by its square over r farther.
    grid = (0.7 * 3.0 / 160.0) ** 2 * radius
    assert (radius - depth <= nearest + 1e-5 * radius).all() and (radius - depth >= nearest - grid).all()
    touch = centers - normal * (radius - depth)[:, None]
    off = np.linalg.norm(touch, axis=1) - earth.radius_m - earth.height(touch)
    assert np.abs(off).max() < 1e-3 * radius
