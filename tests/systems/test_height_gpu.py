"""Heights on the GPU around an anchor against the float64 twin: millimetres, tenths of degrees."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall import Terrain
from planetfall.engine.blocks.bindings import MATERIAL_BLOCK
from planetfall.engine.wavelengths import GIVEN_NM
from planetfall.systems.terrain.height import (
    TerrainParams,
    height_and_gradient,
    height_at_points,
    layer_weight,
)
from planetfall.systems.terrain.height_table import octave_table
from planetfall.systems.terrain.material import TerrainMaterialBlock, material_block

EARTH = TerrainParams()
SPECIAL = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]]
BODY = """TerrainPoint p = terrain_point(d, spacing);
dh = p.dh; gradient = p.gradient; rough = p.roughness; wet = p.moisture;
"""
DETAILED = f"""{BODY}
#include "terrain/ground_detail.glsl"
vec3 finer = rough * ground_detail(d, rough, spacing, footprint).gradient;
vec3 zenith = normalize(d + terrain_table.up * terrain_table.radius_m);
gradient += finer - zenith * dot(zenith, finer);
"""
OUTPUTS = {"dh": "float", "gradient": "vec3", "rough": "float", "wet": "float"}


def anchors(count, seed=4):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return np.concatenate([SPECIAL, d / np.linalg.norm(d, axis=1)[:, None]])


def offsets(up, radius_m, distances_m, seed=0):
    """Foot offsets (N, 3) f32 along arcs of `distances_m` from `up`, in all directions."""
    side = np.cross(up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(distances_m))[:, None]
    angle = (np.asarray(distances_m) / radius_m)[:, None]
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(up, side)
    return (radius_m * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)


@pytest.fixture(params=["storage", "uniform"])
def evaluate(request, run_compute, gpu):
    """evaluate(params, up, offsets, spacing_m, body=, outputs=, **inputs) with the table as either kind of buffer."""
    scope = gpu.scope("test")

    def run(params, up, d, spacing_m, body=BODY, outputs=None, **inputs):
        table = scope.buffer(octave_table(params, up).tobytes())

        def bind(_):
            table.bind_to_storage_buffer(4) if request.param == "storage" else table.bind_to_uniform_block(4)

        defines = {"TERRAIN_TABLE_STORAGE": 1} if request.param == "storage" else {}
        values = {"d": d, "spacing": np.asarray(spacing_m, dtype=np.float32), **inputs}
        header = '#include "terrain/height.glsl"'
        return run_compute(body, values, outputs or OUTPUTS, header=header, defines=defines, setup=bind)

    yield run
    scope.release()


def allowed_m(distances_m):
    """A millimetre within a kilometre of the anchor, beyond it a millionth of the distance: a thousandth of a pixel."""
    return 1e-6 * np.maximum(distances_m, 1000.0)


def height_errors(evaluate, params, up, distances_m, seed=0):
    """|GPU - float64| at offsets along arcs of `distances_m` from `up`, counted from the anchor's ground."""
    d = offsets(up, params.radius_m, distances_m, seed)
    base = height_at_points(up[None] * params.radius_m, params)[0]
    expected = height_at_points(up * params.radius_m + d.astype(np.float64), params) - base
    return np.abs(evaluate(params, up, d, 1e-3)["dh"] - expected)


def test_heights_near_and_far(evaluate):
    for i, up in enumerate(anchors(6)):
        rng = np.random.default_rng(i)
        near = 1000.0 * np.sqrt(rng.random(400))
        far = 10.0 ** rng.uniform(3.0, np.log10(3.1 * EARTH.radius_m), 400)
        assert height_errors(evaluate, EARTH, up, near, i).max() <= 3e-4
        assert (height_errors(evaluate, EARTH, up, far, i) / allowed_m(far)).max() <= 1.0


@pytest.mark.parametrize("radius_m", [1e3, 3e4, 6e5, 3.4e6, 7e7])
def test_heights_of_planets_of_all_sizes(evaluate, radius_m):
    """To the antipode, from poles, edges and corners of the cube's faces, and anywhere."""
    relief_m = min(9000.0, 0.1 * radius_m)
    corner, edge = np.array([[1.0, 1.0, 1.0], [1.0, 0.0, -1.0]])
    for seed, up in enumerate([corner / np.sqrt(3.0), edge / np.sqrt(2.0), *anchors(4)]):
        params = TerrainParams(radius_m, seed + 1, relief_m, -relief_m)
        rng = np.random.default_rng(seed)
        arc = 10.0 ** rng.uniform(-2.0, np.log10(np.pi * radius_m), 500)
        arc[:9] = radius_m * np.pi * np.array([1.0, 0.999, 0.75, 0.5, 0.25, 1e-2, 1e-3, 1e-4, 0.0])
        chord = 2.0 * radius_m * np.sin(0.5 * arc / radius_m)
        assert (height_errors(evaluate, params, up, arc, seed) / allowed_m(chord)).max() <= 1.0


def test_heights_for_wide_pixels(run_compute, gpu):
    """In float throughout: a tenth of a metre beside pixels of 50 m, anywhere in view."""
    scope, worst = gpu.scope("test"), 0.0
    for i, up in enumerate(anchors(6)):
        table = scope.buffer(octave_table(EARTH, up).tobytes())
        d = offsets(up, EARTH.radius_m, 10.0 ** np.random.default_rng(i).uniform(3.0, np.log10(6e6), 400), i)
        out = run_compute(
            "h = terrain_far_height(d, 1e-3);", {"d": d}, {"h": "float"},
            header='#include "terrain/far_height.glsl"', setup=lambda _, t=table: t.bind_to_uniform_block(4),
        )  # fmt: skip
        expected = height_at_points(up * EARTH.radius_m + d.astype(np.float64), EARTH)
        worst = max(worst, float(np.abs(out["h"] - expected).max()))
    scope.release()
    assert worst <= 0.1


def test_float_does_for_coasts_of_wide_pixels(run_compute, gpu):
    """With TERRAIN_FLOAT, and the height alone: a fifth of a pixel of 10 m at a slope of 1 % as far as
    100 km; gradients as in double."""
    scope = gpu.scope("test")
    body = "TerrainPoint p = terrain_point(d, spacing); h = p.dh; g = p.gradient;"
    for i, up in enumerate(anchors(4)):
        table = scope.buffer(octave_table(EARTH, up).tobytes())
        distances = 10.0 ** np.random.default_rng(i).uniform(2.0, np.log10(6e6), 800)
        d = offsets(up, EARTH.radius_m, distances, i)
        inputs = {"d": d, "spacing": np.float32(1e-3)}

        def bind(_, table=table):
            table.bind_to_uniform_block(4)

        def run(header, body, outputs, bind=bind, inputs=inputs):
            return run_compute(body, inputs, outputs, header=f'{header}.glsl"', setup=bind)

        exact = run('#include "terrain/height', body, {"h": "float", "g": "vec3"})
        found = run('#define TERRAIN_FLOAT\n#include "terrain/height', body, {"h": "float", "g": "vec3"})
        alone = run('#include "terrain/far_height', "h = terrain_far_height(d, spacing);", {"h": "float"})
        expected = height_at_points(up * EARTH.radius_m + d.astype(np.float64), EARTH)
        base = height_at_points(up[None] * EARTH.radius_m, EARTH)[0]
        for off in (np.abs(found["h"] + base - expected), np.abs(alone["h"] - expected)):
            assert off[distances < 1e5].max() <= 0.02 and off.max() <= 0.1
            assert np.quantile(off[distances < 3e5], 0.99) <= 0.01
        assert np.linalg.norm(found["g"] - exact["g"], axis=1).max() <= 1e-3
    scope.release()


@pytest.mark.parametrize(
    ("extent_m", "mean_px", "most_px"), [(50.0, 0.02, 0.25), (800.0, 0.02, 0.25), (12e3, 0.03, 0.75), (40e3, 0.1, 1.0)]
)
def test_heights_around_a_middle(run_compute, gpu, extent_m, mean_px, most_px):
    """Places of a block of 4 x 4 pixels by the long noises of its middle: how far that moves a coast in the mean, and
    of a hundred places one. Pixels that are 19 km long are seen along the limb."""
    scope, pixel_m = gpu.scope("test"), extent_m / np.sqrt(4.5)
    body = """TerrainAround around = terrain_around(terrain_broad(d), d, extent);
        there = terrain_keeps_around(extent) ? 1u : 0u;
        h = terrain_height_around(around, d + e, spacing) - terrain_far_height(d + e, spacing);
        g = terrain_point(d + e, spacing / 12.0).gradient;"""
    off, slope = [], []
    for i, up in enumerate(anchors(6)):
        table = scope.buffer(octave_table(EARTH, up).tobytes())
        rng = np.random.default_rng(i)
        d = offsets(up, EARTH.radius_m, 10.0 ** rng.uniform(3.0, 6.0, 400), i)
        e = rng.normal(size=d.shape)
        foot = up + d / EARTH.radius_m
        e -= (e * foot).sum(axis=1, keepdims=True) * foot
        e *= extent_m * np.sqrt(rng.random((len(d), 1))) / np.linalg.norm(e, axis=1, keepdims=True)
        inputs = {"d": d, "e": e, "extent": np.float32(extent_m), "spacing": np.float32(12.0 * pixel_m)}
        out = run_compute(
            body, inputs, {"there": "uint", "h": "float", "g": "vec3"},
            header='#define TERRAIN_FLOAT\n#define TERRAIN_AROUND_FAR\n#include "terrain/height_around.glsl"',
            setup=lambda _, t=table: t.bind_to_uniform_block(4),
        )  # fmt: skip
        assert out["there"].all()
        off.append(np.abs(out["h"]))
        slope.append(np.linalg.norm(out["g"], axis=1))
    scope.release()
    metres, slopes = np.concatenate(off), np.concatenate(slope)
    assert metres.mean() <= mean_px * pixel_m * slopes.mean()
    assert np.quantile(metres / slopes, 0.99) <= most_px * pixel_m


@pytest.mark.parametrize(
    "params",
    [
        TerrainParams(500.0, 9, 50.0, -50.0, 8, 0.5, plains=0.0, mountains=0.0, roughness=4.0),
        TerrainParams(7e7, 2),
        TerrainParams(layers=1),
        TerrainParams(layers=6),
    ],
    ids=["asteroid", "giant", "one layer", "six layers"],
)
def test_other_worlds(evaluate, params):
    up = anchors(1)[-1]
    arc = 10.0 ** np.random.default_rng(1).uniform(-2.0, np.log10(params.radius_m), 500)
    assert (height_errors(evaluate, params, up, arc) / allowed_m(2.0 * arc / np.pi)).max() <= 1.0


def test_heights_count_from_any_level(evaluate, run_compute, gpu):
    up = anchors(1)[-1]
    scope = gpu.scope("test")
    table = scope.buffer(octave_table(EARTH, up, 1234.5).tobytes())
    out = run_compute(
        "dh = terrain_point(d, 1.0).dh;", {"d": np.zeros((1, 3))}, {"dh": "float"},
        header='#include "terrain/height.glsl"', setup=lambda _: table.bind_to_uniform_block(4),
    )  # fmt: skip
    scope.release()
    assert out["dh"][0] == pytest.approx(height_at_points(up[None] * EARTH.radius_m, EARTH)[0] - 1234.5, abs=1e-3)


@pytest.mark.parametrize(("spacing", "footprint"), [(2.0, 0.05), (10.0, 0.5), (40.0, 40.0)])
def test_normals_with_the_detail_of_the_pixel(evaluate, gpu, spacing, footprint):
    """What vertices have and what the ground's light adds to it are together the gradient that the footprint shows."""
    angles, scope = [], gpu.scope("test")
    materials = scope.uniform_block(TerrainMaterialBlock, MATERIAL_BLOCK, "terrain_material_block")
    for i, up in enumerate(anchors(4)):
        materials.write(material_block(Terrain(), EARTH, up, GIVEN_NM))
        materials.bind()
        d = offsets(up, EARTH.radius_m, 1000.0 * np.sqrt(np.random.default_rng(i).random(300)), i)
        points = up * EARTH.radius_m + d.astype(np.float64)
        directions = points / np.linalg.norm(points, axis=1)[:, None]
        _, gradient = height_and_gradient(directions, EARTH, footprint)
        out = evaluate(EARTH, up, d, spacing, DETAILED, footprint=np.float32(footprint))
        a, b = (directions - g for g in (gradient, out["gradient"]))
        cross = np.linalg.norm(np.cross(a, b), axis=1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1)
        angles.append(np.degrees(np.arcsin(cross)))
        assert (out["rough"] > 0.0).all() and (out["rough"] < 1.3).all()
        assert (out["wet"] >= 0.0).all() and (out["wet"] <= 1.0).all()
    scope.release()
    assert np.quantile(angles, 0.99) <= 0.01


def test_band_limited_gradients_at_all_spacings(evaluate):
    up = anchors(1)[-1]
    d = offsets(up, EARTH.radius_m, np.full(200, 3e5))
    points = up * EARTH.radius_m + d.astype(np.float64)
    directions = points / np.linalg.norm(points, axis=1)[:, None]
    for spacing in (7.0, 90.0, 1500.0, 3e4):
        _, gradient = height_and_gradient(directions, EARTH, spacing)
        np.testing.assert_allclose(evaluate(EARTH, up, d, spacing)["gradient"], gradient, atol=2e-4)


def test_layers_too_short_for_the_spacing_fade_from_heights(evaluate):
    up = anchors(1)[-1]
    d = offsets(up, EARTH.radius_m, np.linspace(0.0, 1e5, 300))
    fine = evaluate(EARTH, up, d, 1e-3)["dh"]
    for spacing, limit in ((0.25, 1e-3), (30.0, 4.0), (1000.0, 120.0)):
        coarse = evaluate(EARTH, up, d, spacing)["dh"]
        assert np.abs(coarse - fine).max() <= limit
    steps = evaluate(EARTH, up, np.repeat(d[:1], 400, axis=0), np.geomspace(0.1, 1e5, 400))["dh"]
    assert np.abs(np.diff(steps)).max() < 30.0, "no jump where a layer leaves"


def test_weights_are_the_twins(run_compute):
    ratio = np.linspace(0.5, 6.0, 200)
    out = run_compute(
        "w = terrain_layer_weight(x, 1.0);", {"x": ratio}, {"w": "float"}, header='#include "terrain/height.glsl"'
    )
    np.testing.assert_allclose(out["w"], layer_weight(ratio, 1.0), atol=1e-6)
