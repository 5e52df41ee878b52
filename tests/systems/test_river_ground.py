"""Ground that rivers carve: the float64 twin with all lines, its gradient, the GPU against it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from river_kit import with_rivers, with_waterfalls

from planetfall.benchmarks.measure import queries
from planetfall.engine.blocks.bindings import RIVERS_UNIT
from planetfall.query.terrain import TerrainSampler
from planetfall.systems.terrain.height import TerrainField, TerrainParams, height, height_and_gradient, height_at_points
from planetfall.systems.terrain.height_table import canonical_table, octave_table
from planetfall.systems.terrain.rivers.bends import unbent
from planetfall.systems.terrain.rivers.falls import STEEPNESS
from planetfall.systems.terrain.rivers.table import RiverTable, cell_keys, river_table
from planetfall.systems.terrain.rivers.texture import river_texels
from planetfall.systems.terrain.rivers.valleys import valleys, waters

EARTH = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
PLAIN = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_RIVERS\n#define TERRAIN_CARVED\n"
RADII = (1e3, 6e5, 3.4e6, 6.371e6, 7e7)


def sized(radius_m: float, seed: int = 1) -> TerrainParams:
    relief_m = min(9000.0, 0.1 * radius_m)
    return replace(EARTH, radius_m=radius_m, seed=seed, highest_m=relief_m, lowest_m=-relief_m)


def near_rivers(params, nodes, count, away_m, seed=1):
    """Unit directions (N, 3) within some lengths of rivers."""
    rng = np.random.default_rng(seed)
    places = nodes.direction[rng.integers(len(nodes.direction), size=count)]
    places = places + rng.normal(size=(count, 3)) * (away_m / params.radius_m)
    return places / np.linalg.norm(places, axis=1)[:, None]


@pytest.fixture(scope="module")
def earth():
    return with_rivers(EARTH)


@pytest.mark.parametrize("radius_m", RADII)
def test_a_cell_names_all_lines_that_reach_into_it(radius_m):
    """The same as with every line in every cell."""
    params, nodes = with_rivers(sized(radius_m), count=6)
    table = params.rivers
    assert isinstance(table, RiverTable)
    directions = near_rivers(params, nodes, 1500, 5e3 * params.scale)
    points = np.ascontiguousarray(directions.T) * radius_m
    keys = np.unique(cell_keys(np.floor(points / table.cell_m).astype(np.int64)))
    lines = np.flatnonzero(table.to >= 0).astype(np.int32)
    begin = (len(lines) * np.arange(len(keys) + 1)).astype(np.int32)
    whole = replace(table, keys=keys, begin=begin, lines=np.tile(lines, len(keys)))
    found, expected = valleys(table, points), valleys(whole, points)
    assert (found.open < 1.0).mean() > 0.5
    np.testing.assert_array_equal(found.open, expected.open)
    np.testing.assert_array_equal(found.raised, expected.raised)
    inside = found.open < 1.0
    np.testing.assert_allclose(found.base_m[inside], expected.base_m[inside], rtol=1e-12, atol=1e-9)


@pytest.mark.parametrize("radius_m", RADII)
def test_the_gradient_is_that_of_the_heights(radius_m):
    params, nodes = with_rivers(sized(radius_m), count=10)
    at = near_rivers(params, nodes, 1000, 4e3 * params.scale)
    _, gradient = height_and_gradient(at, params)
    side = np.cross(at, [0.3, 0.2, 1.0])
    side /= np.linalg.norm(side, axis=1)[:, None]
    step_m = 2e-4 * min(params.scale, 1.0) * 100.0
    ends = [at + sign * side * (step_m / radius_m) for sign in (1.0, -1.0)]
    high, low = (height(e / np.linalg.norm(e, axis=1)[:, None], params) for e in ends)
    error = np.abs((high - low) / (2.0 * step_m) - (gradient * side).sum(axis=1))
    # Lines' ends, floors' edges and the watersheds between valleys have creases that a step may lie across.
    assert np.percentile(error, 98) < 2e-3
    assert np.median(error) < 2e-4


def test_a_river_lies_in_its_valley(earth):
    """On the line the ground is the bed, beyond the valley it is as it was, and the water is level across a lake."""
    params, nodes = earth
    middle = np.flatnonzero((nodes.to >= 0) & ~nodes.lake)
    table = params.rivers
    points = np.ascontiguousarray(nodes.direction.T) * params.radius_m
    found = waters(table, points)
    cut = valleys(table, points)
    far = cut.open == 1.0
    plain = height(nodes.direction, EARTH)
    np.testing.assert_array_equal(height(nodes.direction, params)[far], plain[far])
    within = found.beyond_m < 0.0
    assert within.any()
    bed = found.level_m[within] - height(nodes.direction, params)[within]
    # The bed is nowhere above its own form; the ground may dip below it where that is not filled (lakes, the sea).
    assert (bed - found.depth_m[within]).min() > -1e-9
    lakes = np.flatnonzero(nodes.lake & (nodes.to >= 0))
    half = points[:, lakes] * 0.5 + points[:, nodes.to[lakes]] * 0.5
    half *= params.radius_m / np.linalg.norm(half, axis=0)
    level = waters(table, half)
    wet = level.beyond_m < 0.0
    assert wet.sum() > 0.9 * len(lakes)
    np.testing.assert_allclose(level.level_m[wet], nodes.level_m[lakes][wet], atol=1e-3)
    assert len(middle) > 100


def test_slopes_are_bounded(earth):
    params, nodes = earth
    at = near_rivers(params, nodes, 3000, 4e3)
    _, gradient = height_and_gradient(at, params)
    _, bound = TerrainField(params).height_slope(at)
    assert (np.linalg.norm(gradient, axis=1) > bound).mean() < 1e-3


def test_places_alone_and_in_a_batch_are_the_same(earth):
    params, nodes = earth
    at = near_rivers(params, nodes, 64, 4e3)
    whole = height(at, params)
    assert np.abs(np.array([height(at[k : k + 1], params)[0] for k in range(64)]) - whole).max() < 1e-9


def test_no_lines_at_all():
    """Nodes without a line leave the ground as it is."""
    _, nodes = with_rivers(EARTH, count=2)
    params = replace(EARTH, rivers=river_table(replace(nodes, to=np.full_like(nodes.to, -1)), EARTH.radius_m, 1))
    at = near_rivers(params, nodes, 50, 2e3)
    np.testing.assert_array_equal(height(at, params), height(at, EARTH))


# -- the GPU -----------------------------------------------------------------------------------------------------------


def offsets(up, radius_m, distances_m, seed):
    side = np.cross(up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(distances_m))[:, None]
    angle = (distances_m / radius_m)[:, None]
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(up, side)
    return (radius_m * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)


@pytest.fixture
def evaluate(run_compute, gpu):
    """evaluate(params, table, body, header, inputs, outputs)"""
    scope = gpu.scope("test")

    def run(params, table, body, header, inputs, outputs):
        _, texels = river_texels(params.rivers)
        texture = scope.texture(texels.shape[1::-1], "rgba32ui", texels.view(np.uint32))
        block = scope.buffer(table.tobytes())

        def bind(_):
            block.bind_to_uniform_block(4)
            texture.use(RIVERS_UNIT)

        return run_compute(body, inputs, outputs, header=f"{PLAIN}#include {header}", setup=bind)

    yield run
    scope.release()


BODY = "TerrainPoint p = terrain_point(d, 1e-3); dh = p.dh; gradient = p.gradient;"


@pytest.mark.parametrize("radius_m", RADII)
def test_heights_around_an_anchor(evaluate, radius_m):
    """A millimetre within a kilometre, a millionth of the distance beyond; gradients to 1e-4, on valleys' sides."""
    params, nodes = with_rivers(sized(radius_m), count=12)
    for k, up in enumerate(near_rivers(params, nodes, 5, 1e3 * params.scale, seed=7)):
        rng = np.random.default_rng(k)
        near = min(1000.0, 0.02 * radius_m) * np.sqrt(rng.random(400))
        distances = np.concatenate([near, 10.0 ** rng.uniform(0.0, np.log10(0.02 * radius_m), 400)])
        d = offsets(up, radius_m, distances, k)
        points = up * radius_m + d.astype(np.float64)
        base = height_at_points(up[None] * radius_m, params)[0]
        outputs = {"dh": "float", "gradient": "vec3"}
        found = evaluate(params, octave_table(params, up), BODY, '"terrain/height.glsl"', {"d": d}, outputs)
        error = np.abs(found["dh"] - (height_at_points(points, params) - base))
        assert (error / (1e-6 * np.maximum(distances, 1000.0))).max() <= 1.0
        _, gradient = height_and_gradient(points / radius_m, params, 1e-3)
        assert np.percentile(np.linalg.norm(found["gradient"] - gradient, axis=1), 99) < 1e-4


def test_heights_beside_a_fall(evaluate):
    """The same where the ground is as steep as 2 in 1 and rivers' lines are 30 m long."""
    params, nodes = with_waterfalls(EARTH)
    radius_m = params.radius_m
    lips = np.flatnonzero(drops(nodes) > 20.0)
    assert len(lips) > 10
    places = unbent(nodes.direction[lips[:6]].T * radius_m, radius_m, params.seed).T / radius_m
    for k, up in enumerate(places):
        d = offsets(up, radius_m, 10.0 ** np.random.default_rng(k).uniform(0.0, 3.0, 600), k)
        points = up * radius_m + d.astype(np.float64)
        outputs = {"dh": "float", "gradient": "vec3"}
        found = evaluate(params, octave_table(params, up), BODY, '"terrain/height.glsl"', {"d": d}, outputs)
        expected = height_at_points(points, params) - height_at_points(up[None] * radius_m, params)[0]
        assert np.ptp(expected) > 20.0
        assert np.abs(found["dh"] - expected).max() <= 1e-3


def drops(nodes):
    """How far each line of falls comes down (N,), 0 for other lines."""
    to = nodes.to
    drop = np.where(to >= 0, nodes.level_m - nodes.level_m[to], 0.0)
    length = np.linalg.norm(nodes.direction - nodes.direction[to], axis=1) * EARTH.radius_m
    return np.where(drop > 0.5 * STEEPNESS * length, drop, 0.0)


def test_heights_in_float(evaluate, earth):
    """A tenth of a metre, as without rivers."""
    params, nodes = earth
    for k, up in enumerate(near_rivers(params, nodes, 4, 3e3, seed=9)):
        d = offsets(up, params.radius_m, 10.0 ** np.random.default_rng(k).uniform(3.0, 6.0, 600), k)
        found = evaluate(
            params, octave_table(params, up), "h = terrain_far_height(d, 1e-3);", '"terrain/far_height.glsl"', {"d": d},
            {"h": "float"},
        )  # fmt: skip
        assert np.abs(found["h"] - height_at_points(up * params.radius_m + d.astype(np.float64), params)).max() <= 0.1


@pytest.mark.parametrize("radius_m", RADII)
def test_canonical_heights(evaluate, radius_m):
    """Of one direction alone, to a millimetre."""
    params, nodes = with_rivers(sized(radius_m), count=12)
    at = near_rivers(params, nodes, 4000, 3e3 * params.scale)
    high = at.astype(np.float32)
    found = evaluate(
        params, canonical_table(params), "Pair h; terrain_canonical(Pair3(a, b), 1e-3, h); x = h.high; y = h.low;",
        '"terrain/canonical_height.glsl"', {"a": high, "b": (at - high).astype(np.float32)},
        {"x": "float", "y": "float"},
    )  # fmt: skip
    error = np.abs(found["x"].astype(np.float64) + found["y"] - height(at, params))
    assert error.max() <= 1e-3


# -- rays --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("erosion", "falls"), [(0.0, False), (1.0, False), (1.0, True)])
def test_no_ground_before_the_hit(earth, erosion, falls):
    """A march of half metres along rays beside rivers finds nothing that a cast has passed, but a centimetre."""
    params, nodes = with_waterfalls(EARTH) if falls else earth
    sampler = TerrainSampler.from_params(replace(params, erosion=erosion))
    up = near_rivers(params, nodes, 60, 3e3, seed=11)
    rng = np.random.default_rng(4)
    side = np.cross(up, rng.normal(size=up.shape))
    side /= np.linalg.norm(side, axis=1)[:, None]
    pitch = np.radians(rng.uniform(-10.0, 1.0, len(up)))[:, None]
    origins = up * (params.radius_m + sampler.height(up) + 20.0)[:, None]
    asked = queries.Rays("", origins, side * np.cos(pitch) + up * np.sin(pitch), 3000.0)
    hit, distance = sampler.raycast(asked.origins_m, asked.directions, asked.reach_m)
    assert 0.3 < hit.mean() < 1.0
    late, looked = queries.earlier_ground(sampler, asked, hit, distance, 0.5)
    assert looked > 3000 and late.max() < 0.01
    assert queries.residual_m(sampler, asked, hit, distance) < 1e-6
