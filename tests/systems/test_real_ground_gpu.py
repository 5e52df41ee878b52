"""Tiles of elevation on the GPU against the float64 twin: millimetres around an anchor and around the centre."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from countries import land, write_country, write_hgt, write_png_tile
from geotiffs import of_code, write_geotiff

from planetfall.engine.blocks.bindings import HEIGHT_MAP_UNIT
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import real_ground
from planetfall.systems.terrain.height import TerrainParams, height_and_gradient, height_at_points
from planetfall.systems.terrain.height_table import canonical_table, octave_table
from planetfall.systems.terrain.real_texture import fixed_unit_m, real_texels

RADIUS_M = 6.371e6
PLAIN = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
CHOSEN = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_TILED\n"
BODY = "TerrainPoint p = terrain_point(d, spacing); dh = p.dh; gradient = p.gradient;"
OUTPUTS = {"dh": "float", "gradient": "vec3"}
CANONICAL = "Pair h; TerrainPoint p = terrain_canonical(Pair3(high, low), spacing, h); metres = vec2(h.high, h.low);"


@pytest.fixture(scope="module", params=[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)], ids=["bare", "detail", "gullies"])
def country(tmp_path_factory, request):
    """Tiles of 3 minutes, one of 3 seconds among them that is rough, and pixels of 7 m within that one."""
    folder = tmp_path_factory.mktemp("country")
    write_country(folder / "coarse", 40, 0, 10, 20, 21)
    rough = np.random.default_rng(1).normal(1500.0, 20.0, (1201, 1201))
    write_hgt(folder / "fine", 46, 7, 1201, np.rint(rough).astype(np.int16))
    x, y = 8514, 5792  # of zoom 14, about 46.5 N, 7.1 E
    for dx in range(2):
        write_png_tile(folder / "finest", 14, x + dx, y)
    real = real_ground(str(folder), 256_000_000, "Terrain.height_map")
    detail, erosion = request.param
    return replace(PLAIN, real=real, height_map_detail=detail, erosion=erosion)


@pytest.fixture
def evaluate(run_compute, gpu):
    """evaluate(params, table, body, header, inputs, outputs)"""
    scope = gpu.scope("test")

    def run(params, table, body, header, inputs, outputs):
        block = scope.buffer(table.tobytes())
        words = real_texels(params.real, fixed_unit_m(params.radius_m), params.radius_m)
        texture = scope.texture(words.shape[::-1], "r32ui", words)

        def bind(_):
            block.bind_to_uniform_block(4)
            texture.use(HEIGHT_MAP_UNIT)

        chosen = CHOSEN + ("#define TERRAIN_ERODED\n" if params.erosion > 0.0 else "")
        return run_compute(body, inputs, outputs, header=f"{chosen}#include {header}", setup=bind)

    yield run
    scope.release()


def offsets(up, distances_m, seed):
    side = np.cross(up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(distances_m))[:, None]
    angle = (distances_m / RADIUS_M)[:, None]
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(up, side)
    return (RADIUS_M * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)


# Within the finest tiles and at their border, in the fine one and at its border, in the country, at its edge, outside.
ANCHORS = ((46.55, 7.09), (46.555, 7.112), (46.3, 7.8), (46.5, 8.0), (47.0, 7.5), (44.3, 12.2), (40.0, 5.0),
           (39.4, 4.0), (10.0, 80.0))  # fmt: skip


@pytest.mark.parametrize("place", ANCHORS)
def test_heights_around_an_anchor(evaluate, country, place):
    """A millimetre within a kilometre, a millionth of the distance beyond; gradients to 2e-3."""
    up = directions_at(*place)
    table = octave_table(country, up)
    base = height_at_points(up[None] * RADIUS_M, country)[0]
    rng = np.random.default_rng(2)
    distances_m = np.concatenate([1000.0 * np.sqrt(rng.random(600)), 10.0 ** rng.uniform(3.0, 5.5, 400)])
    d = offsets(up, distances_m, 3)
    for spacing in (0.1, 300.0, 2e4):
        inputs = {"d": d, "spacing": np.full(len(d), spacing, np.float32)}
        out = evaluate(country, table, BODY, '"terrain/height.glsl"', inputs, OUTPUTS)
        points = up * RADIUS_M + d.astype(np.float64)
        expected = height_at_points(points, country) - base
        error = np.abs(out["dh"] - expected)
        if spacing < 1.0:  # wider ones show less of the procedural ground
            assert error[:600].max() < 1e-3
            assert (error[600:] / distances_m[600:]).max() < 1e-6
        directions = points / np.linalg.norm(points, axis=1)[:, None]
        _, gradient = height_and_gradient(directions, country, spacing)
        off = np.linalg.norm(out["gradient"] - gradient, axis=1)
        assert np.quantile(off[:600], 0.99) < 2e-3
        assert np.quantile(off, 0.99) < 2e-2


@pytest.mark.parametrize("place", ANCHORS)
def test_heights_around_the_centre(evaluate, country, place):
    """Tiles of ground: a millimetre, whatever the place."""
    rng = np.random.default_rng(4)
    d = directions_at(*place) + rng.normal(size=(1500, 3)) * 10.0 ** rng.uniform(-6.0, -1.5, (1500, 1))
    d /= np.linalg.norm(d, axis=1)[:, None]
    high = d.astype(np.float32)
    inputs = {"high": high, "low": (d - high).astype(np.float32), "spacing": np.full(len(d), 0.1, np.float32)}
    out = evaluate(country, canonical_table(country), CANONICAL, '"terrain/canonical_height.glsl"', inputs,
                   {"metres": "vec2"})  # fmt: skip
    found = out["metres"].astype(np.float64).sum(axis=1)
    expected = height_at_points(d * RADIUS_M, country)
    assert np.abs(found - expected).max() < 1e-3


@pytest.fixture(scope="module", params=[(0.0, 0.0), (1.0, 1.0)], ids=["bare", "gullies"])
def world(tmp_path_factory, request):
    """All of a planet in pixels of 1 degree, and tiles of 3 minutes on both sides of the date line."""
    tifffile = pytest.importorskip("tifffile")
    folder = tmp_path_factory.mktemp("world")
    write_country(folder, 10, 178, 2, 4, 21)
    latitude, longitude = (89.5 - np.arange(180))[:, None], -179.5 + np.arange(360)
    keys = (1, 1, 0, 2, 1024, 0, 1, 2, 1025, 0, 1, 1)
    tags = [
        (33550, "d", 3, (1.0, 1.0, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, -180.0, 90.0, 0.0), True),
        (34735, "H", len(keys), keys, True),
    ]
    tifffile.imwrite(folder / "all.tif", land(latitude, longitude).astype(np.float32), extratags=tags)
    detail, erosion = request.param
    real = real_ground(str(folder), 64_000_000, "x")
    return replace(PLAIN, real=real, height_map_detail=detail, erosion=erosion)


@pytest.mark.parametrize(
    "place", [(90.0, 0.0), (89.7, 12.0), (-90.0, 0.0), (-89.99, 100.0), (11.3, 180.0), (0.0, 180.0)]
)
def test_poles_and_the_date_line(evaluate, world, place):
    """A millimetre there, too."""
    up = directions_at(*place)
    d = offsets(up, 10.0 ** np.random.default_rng(5).uniform(0.0, 3.0, 800), 6)
    inputs = {"d": d, "spacing": np.full(len(d), 0.1, np.float32)}
    out = evaluate(world, octave_table(world, up), BODY, '"terrain/height.glsl"', inputs, OUTPUTS)
    expected = height_at_points(up * RADIUS_M + d.astype(np.float64), world)
    base = height_at_points(up[None] * RADIUS_M, world)[0]
    assert np.abs(out["dh"] - (expected - base)).max() < 1e-3
    places = (points := up * RADIUS_M + d.astype(np.float64)) / np.linalg.norm(points, axis=1)[:, None]
    high = places.astype(np.float32)
    inputs = {"high": high, "low": (places - high).astype(np.float32), "spacing": np.full(len(d), 0.1, np.float32)}
    out = evaluate(world, canonical_table(world), CANONICAL, '"terrain/canonical_height.glsl"', inputs,
                   {"metres": "vec2"})  # fmt: skip
    assert np.abs(out["metres"].astype(np.float64).sum(axis=1) - expected).max() < 1e-3


@pytest.mark.parametrize("where", [(2056, 2.6e6, 1.2e6), (32633, 5.0e5, 7.3e6), (3031, -3.0e4, 2.0e4)])
def test_a_survey_in_another_system(evaluate, tmp_path, where):
    """Pixels of 1 m with noise of 1 m, on lattices of 1 m, with fewer columns in the north, and far fewer by a pole."""
    pyproj = pytest.importorskip("pyproj")
    pytest.importorskip("tifffile")
    code, x, y = where
    values = np.random.default_rng(1).normal(800.0, 1.0, (300, 300)).astype(np.float32)
    write_geotiff(tmp_path / "t/a.tif", values, of_code(code), (x, y, 1.0))
    real = real_ground(str(tmp_path / "t"), 64_000_000, "x")
    survey = replace(PLAIN, real=real, height_map_detail=0.0)
    longitude, latitude = pyproj.Transformer.from_crs(code, 4326, always_xy=True).transform(x + 150.3, y - 140.7)
    up = directions_at(latitude, longitude)
    d = offsets(up, 400.0 * np.sqrt(np.random.default_rng(2).random(1000)), 3)
    inputs = {"d": d, "spacing": np.full(len(d), 0.1, np.float32)}
    out = evaluate(survey, octave_table(survey, up), BODY, '"terrain/height.glsl"', inputs, OUTPUTS)
    points = up * RADIUS_M + d.astype(np.float64)
    expected = height_at_points(points, survey) - height_at_points(up[None] * RADIUS_M, survey)[0]
    assert np.abs(out["dh"] - expected).max() < 1e-3
