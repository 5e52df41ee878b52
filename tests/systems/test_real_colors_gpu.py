"""Tiles of pictures on the GPU against the float64 twin."""

from __future__ import annotations

import numpy as np
import pytest
from countries import globe, tile_at, tile_places, write_color_tiff, write_fields, write_picture

from planetfall.engine.blocks.bindings import COLOR_MAP_UNIT
from planetfall.engine.display import reflectance
from planetfall.engine.real_ground.color_reading import real_colors
from planetfall.engine.real_ground.lattice import directions_at, sphere_place
from planetfall.engine.srgb import srgb_decode
from planetfall.engine.wavelengths import DISPLAY_NM
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.height_table import octave_table
from planetfall.systems.terrain.real_colors import color_texels, pictured_width_bits

RADIUS_M = 6.371e6
CHOSEN = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_PICTURED\n"
HEADER = f'{CHOSEN}#include "terrain/height.glsl"\n#include "terrain/real_colors.glsl"'
BODY = "ColorsSeen seen = terrain_colors(d, footprint); albedo = seen.albedo; weight = seen.weight;"
OUTPUTS = {"albedo": "vec3", "weight": "float"}


@pytest.fixture
def evaluate(run_compute, gpu):
    """evaluate(colors, up, d, footprint_rad)"""
    scope = gpu.scope("test")

    def run(found, up, d, footprint_rad):
        table = octave_table(TerrainParams(pictured=True, layers=2), up)
        table["color"] = (0, pictured_width_bits(found), 1.0)
        block = scope.buffer(table.tobytes())
        words = color_texels(found, RADIUS_M)
        texture = scope.texture(words.shape[::-1], "r32ui", words)

        def bind(_):
            block.bind_to_uniform_block(4)
            texture.use(COLOR_MAP_UNIT)

        inputs = {"d": d, "footprint": footprint_rad.astype(np.float32)}
        return run_compute(BODY, inputs, OUTPUTS, header=HEADER, setup=bind)

    yield run
    scope.release()


def offsets(up, distances_m, seed):
    side = np.cross(up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, len(distances_m))[:, None]
    angle = (distances_m / RADIUS_M)[:, None]
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(up, side)
    return (RADIUS_M * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)


def compare(evaluate, found, place, most):
    up = directions_at(*place)
    rng = np.random.default_rng(4)
    distances_m = np.concatenate([3000.0 * np.sqrt(rng.random(2000)), 10.0 ** rng.uniform(3.0, 6.0, 1000)])
    d = offsets(up, distances_m, 5)
    points = (up * RADIUS_M + d.astype(np.float64)).T
    for footprint_rad in (1e-9, 3e-6, 4e-5, 3e-3):
        footprint = np.full(len(d), footprint_rad)
        out = evaluate(found, up, d, footprint)
        values, weight = found.sample(points, footprint)
        off = np.abs(np.concatenate([out["albedo"] - values.T, (out["weight"] - weight)[:, None]], axis=1)).max(axis=1)
        assert off[:2000].max() < most, (footprint_rad, off[:2000].max())
        assert np.quantile(off, 0.999) < 20.0 * most  # far from the anchor float knows places to decimetres
    return weight


@pytest.fixture(scope="module")
def country(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")
    write_fields(folder, 15, 46.5, 7.5, 4)
    write_fields(folder, 11, 46.5, 7.5, 2, "jpg")
    return real_colors(str(folder), DISPLAY_NM, 256_000_000, "Terrain.color_map")


@pytest.mark.parametrize("place", [(46.5, 7.5), (46.508, 7.51), (46.6, 7.6), (46.8, 7.7), (45.0, 9.0)])
def test_colours_around_an_anchor(evaluate, country, place):
    compare(evaluate, country, place, 2e-3)


@pytest.fixture(scope="module", params=["degrees", "mercator"])
def world(tmp_path_factory, request):
    folder = tmp_path_factory.mktemp("world")
    if request.param == "mercator":
        for x in range(4):
            for y in range(4):
                write_picture(folder, 2, x, y, globe(*tile_places(2, x, y)))
    else:
        pytest.importorskip("tifffile")
        longitude, latitude = np.meshgrid(np.arange(-179.75, 180.0, 0.5), np.arange(89.75, -90.0, -0.5))
        write_color_tiff(folder / "all.tif", globe(latitude, longitude), -180.0, 90.0, 0.5)
    return request.param, real_colors(str(folder), DISPLAY_NM, 256_000_000, "Terrain.color_map")


@pytest.mark.parametrize(
    "place", [(90.0, 0.0), (-89.99, 30.0), (0.0, 180.0), (50.0, -179.999), (84.9, 10.0), (20.0, 40.0)]
)
def test_poles_and_the_date_line(evaluate, world, place):
    """As the twin there, and as what the picture was made from: no seam."""
    kind, found = world
    weight = compare(evaluate, found, place, 2e-3)
    if kind == "mercator" and abs(place[0]) > 85.0:
        return
    assert weight[:2000].min() == 1.0
    points = directions_at(np.full(64, place[0]), place[1] + np.linspace(-0.01, 0.01, 64))
    values, _ = found.sample(points, np.full(64, 1e-9))
    latitude, longitude = sphere_place(points)
    exact = reflectance(srgb_decode(globe(latitude, longitude) / 255.0), DISPLAY_NM)
    assert np.abs(values.T - exact).max() < 0.05 and np.abs(np.diff(values, axis=1)).max() < 2e-3


def test_pixels_of_centimetres_are_in_their_place(evaluate, tmp_path):
    """Noise of pixels of 10 cm: to a hundredth of one within 100 m of the anchor."""
    zoom, place = 20, (46.5, 7.5)
    x, y = tile_at(zoom, *place)
    rng = np.random.default_rng(6)
    for dx in (-1, 0):
        for dy in (-1, 0):
            write_picture(tmp_path, zoom, x + dx, y + dy, rng.integers(0, 255, (256, 256, 3)).astype(np.uint8))
    found = real_colors(str(tmp_path), DISPLAY_NM, 256_000_000, "Terrain.color_map")
    up = directions_at(*(float(v[0, 0]) for v in tile_places(zoom, x, y)))
    d = offsets(up, 20.0 * np.sqrt(rng.random(3000)), 7)
    footprint = np.full(len(d), 1e-10)
    out = evaluate(found, up, d, footprint)
    values, weight = found.sample((up * RADIUS_M + d.astype(np.float64)).T, footprint)
    assert weight.max() == 1.0 and np.std(values[0]) > 0.1
    assert np.abs(out["albedo"] - values.T).max() < 0.015
