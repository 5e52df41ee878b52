"""Forests of a vector map in the ground's own colour, beyond single trees: the picture of shares, the GPU, pictures."""

from __future__ import annotations

import numpy as np
import pytest
from vector_kit import feature, polygon, ring, write_map

import planetfall as pf
from planetfall.engine.blocks.bindings import WOODS_UNIT
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.polygons import Polygons
from planetfall.systems.terrain.height import TerrainField, TerrainParams
from planetfall.systems.terrain.height_table import octave_table
from planetfall.systems.terrain.vector_water.ground import mapped_ground
from planetfall.systems.terrain.woods_map import woods_map

RADIUS_M = 6.371e6


def woods_about(latitude, longitude, size_deg=0.02):
    """A round wood with a clearing, and a square one to the east."""
    flat = size_deg / np.cos(np.radians(latitude))
    round_wood = np.array(ring(longitude, latitude, flat, size_deg, 90, 0.2))
    clearing = np.array(ring(longitude, latitude, 0.4 * flat, 0.4 * size_deg, 50))[::-1]
    east = longitude + 3.0 * flat
    square = np.array([(east + a * flat, latitude + b * size_deg) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    return [(round_wood, clearing), (np.concatenate([square, square[:1]]),)]


@pytest.mark.parametrize("latitude", [0.0, 46.5, -78.0])
def test_shares_are_those_of_the_polygons(latitude):
    woods = Polygons(woods_about(latitude, 7.5))
    found = woods_map(woods, RADIUS_M)
    rows, columns = found.share.shape
    assert max(rows, columns) <= 2048
    row, column = np.mgrid[:rows:7, :columns:7]
    across, up = found.texel_deg
    longitude, latitudes = found.west_deg + (column + 0.5) * across, found.north_deg - (row + 0.5) * up
    inside = woods.inside(longitude.ravel(), latitudes.ravel()).reshape(row.shape)
    share = found.share[::7, ::7]
    assert 0.2 < inside.mean() < 0.8
    assert ((share > 127) == inside).mean() > 0.999
    assert np.isin(share, (0, 255)).mean() > 0.95


def shares_on_gpu(run_compute, scope, found, params, anchor, at, footprint_m=0.5):
    """(N,) what the shader makes of unit directions (N, 3)."""
    size = found.share.shape[::-1]
    texture = scope.texture(size, "r8", found.share, max(size).bit_length(), filter="trilinear")
    block = scope.buffer(octave_table(params, anchor).tobytes())
    header = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_WOODED\n#define TERRAIN_PLACE vec3\n"

    def bind(_):
        block.bind_to_uniform_block(4)
        texture.use(WOODS_UNIT)

    d = ((at - anchor) * RADIUS_M).astype(np.float32)
    return run_compute(f"share = terrain_wooded(d, {footprint_m});", {"d": d}, {"share": "float"},
                       header=f'{header}#include "terrain/woods.glsl"', setup=bind)["share"]  # fmt: skip


def square(west, south, east, north):
    return (np.array([(west, south), (east, south), (east, north), (west, north), (west, south)], dtype=float),)


@pytest.mark.parametrize(("latitude", "longitude"), [(46.5, 7.5), (-0.01, 180.0), (84.0, -179.99)])
def test_on_the_gpu(run_compute, gpu, latitude, longitude):
    """As the picture has it, whatever the anchor: above it, 300 km away, on the other side of the planet."""
    woods = Polygons(woods_about(latitude, longitude))
    found, params = woods_map(woods, RADIUS_M), TerrainParams(woods=woods)
    scope, rng = gpu.scope("test"), np.random.default_rng(1)
    flat = 0.08 / np.cos(np.radians(latitude))
    places = longitude + 0.04 + flat * rng.uniform(-1, 1, 3000), latitude + 0.04 * rng.uniform(-1, 1, 3000)
    places = places[0] + 1e-12, places[1]
    at = directions_at(places[1], places[0]).T
    expected = np.where(woods.boxed(*places), woods.inside(*places), 1.0)
    for anchor, most in ((at[0], 0.01), (directions_at(latitude - 3.0, longitude), 0.02), (-at[0], 0.1)):
        assert (np.abs(shares_on_gpu(run_compute, scope, found, params, anchor, at) - expected) > 0.5).mean() < most
    scope.release()


def test_the_picture_is_made_once(tmp_path):
    """Whatever the anchors are, and for grounds that differ in something else."""
    wood = feature(polygon(ring(7.5, 46.5, 0.1, 0.1)), natural="wood")
    path = write_map(tmp_path / "wood.geojson", wood)
    first, other = (mapped_ground(TerrainParams(mountains=m), path, 1 << 20, 0.0) for m in (0.4, 0.5))
    assert first.woods is other.woods
    woods_map(first.woods, first.radius_m)
    made = woods_map.cache_info().misses
    for k in range(20):
        octave_table(first, directions_at(45.0 + 0.1 * k, 7.0), 0.0)
    assert woods_map.cache_info().misses == made


def test_forests_cut_at_the_date_line_are_bounded_there(tmp_path):
    """As RFC 7946 has them: trees around the rest of the world are none of the map's."""
    parts = [(179.0, 180.0), (-180.0, -179.2), (178.0, 178.5)]
    rings = [[(w, -18), (e, -18), (e, -17), (w, -17), (w, -18)] for w, e in parts]
    path = write_map(tmp_path / "cut.geojson", *(feature(polygon(r), natural="wood") for r in rings))
    params = mapped_ground(TerrainParams(), path, 1 << 20, 0.0)
    assert params.woods.bounds == (178.0, -18.0, 180.8, -17.0)
    longitude = np.array([178.2, 178.7, 179.9, -179.9, -179.3, -179.1, 0.0])
    at = directions_at(np.full(7, -17.5), longitude).T
    np.testing.assert_array_equal(TerrainField(params).wooded(at), [True, False, True, True, True, True, True])


AROUND = {
    "world": [square(-178, 10, -160, 20), square(0, -20, 30, 30), square(150, 0, 176, 25)],
    "cut at the date line": [square(179, 10, 180, 11), square(-180, 10, -179, 11)],
    "wider than the world": [square(-180, 10, -100, 20), square(170, 10, 190, 20)],
}


@pytest.mark.parametrize("name", AROUND)
def test_on_the_gpu_around_the_world(run_compute, gpu, name):
    """The same wherever the anchor is, beyond the map's ends and at a pole, too."""
    woods = Polygons(AROUND[name])
    found, params = woods_map(woods, RADIUS_M), TerrainParams(woods=woods)
    scope, rng = gpu.scope("test"), np.random.default_rng(1)
    _, south, _, north = woods.bounds
    longitude, latitude = rng.uniform(-180, 180, 2000), rng.uniform(south - 2.0, north + 2.0, 2000)
    at = directions_at(latitude, longitude).T
    expected = np.where(woods.boxed(longitude, latitude), woods.inside(longitude, latitude), 1.0)
    for place in ((0.0, 0.0), (15.0, 170.0), (15.0, -170.0), (15.0, 90.0), (89.9999, 30.0), None):
        anchor = np.array([0.0, 0.0, -1.0]) if place is None else directions_at(*place)
        share = shares_on_gpu(run_compute, scope, found, params, anchor, at)
        assert np.isfinite(share).all()
        assert (np.abs(share - expected) > 0.5).mean() < 2e-3, place
    scope.release()


@pytest.mark.parametrize("long_deg", [0.02, 1.5])
@pytest.mark.parametrize("turned", [False, True])
def test_pixels_see_means_in_long_thin_maps_too(run_compute, gpu, long_deg, turned):
    """Stripes of 35 m by turns, in pixels of 300 m."""
    edges = 0.02 * np.linspace(-1.0, 1.0, 129)
    stripes = [(a, -long_deg, b, long_deg) for a, b in zip(edges[:-1:2], edges[1::2], strict=True)]
    woods = Polygons([square(*((s, w, n, e) if turned else (w, s, e, n))) for w, s, e, n in stripes])
    found, params = woods_map(woods, RADIUS_M), TerrainParams(woods=woods)
    scope, rng = gpu.scope("test"), np.random.default_rng(1)
    at = directions_at(rng.uniform(-0.01, 0.01, 500), rng.uniform(-0.01, 0.01, 500)).T
    share = shares_on_gpu(run_compute, scope, found, params, directions_at(0.005, 0.0), at, 300.0)
    assert np.abs(share - 0.5).max() < 0.25
    scope.release()


@pytest.mark.parametrize("bounds", [(7, 46, 7, 47), (7, 46, 8, 46), (7, 46, 7, 46)])
def test_forests_without_an_area_are_nowhere(bounds):
    woods = Polygons([square(*bounds)])
    found = woods_map(woods, RADIUS_M)
    assert not found.share.any()
    table = octave_table(TerrainParams(woods=woods), directions_at(46.0, 7.5))
    assert np.isfinite(table["woods"]["place"]).all()
    assert (table["woods"]["texel_rad"] > 0.0).all()


def test_from_afar_woods_are_where_the_map_has_them(tmp_path):
    """Straight down from 6 km: in the wood as without a map, beside it as with a map that has none there."""
    scene = pf.load_scene("earth")
    terrain = scene.planet[pf.Terrain]
    terrain.rivers, terrain.humidity = 0.0, 1.0
    latitude, longitude = 9.23, 29.98  # forest, by climate
    scene.sun = pf.Sun(elevation_deg=50.0, latitude_deg=latitude, longitude_deg=longitude)
    camera = pf.Camera.at(latitude, longitude, 6_000.0, pitch_deg=-90.0, above="ground").exposed(14.5)

    def wood(west, south, east, north):
        corners = ((west, south), (east, south), (east, north), (west, north), (west, south))
        return feature(polygon([(longitude + a, latitude + b) for a, b in corners]), natural="wood")

    def picture(vector_map=""):
        terrain.vector_map = str(vector_map)
        with pf.Renderer(scene, (160, 90), "low") as renderer:
            return renderer.snapshot(camera).array[..., :3].astype(float)

    specks = wood(-0.1, -0.1, -0.0999, -0.0999), wood(0.0999, 0.0999, 0.1, 0.1)
    bare = write_map(tmp_path / "bare.geojson", *specks)
    half = write_map(tmp_path / "half.geojson", *specks, wood(0.0, -0.1, 0.1, 0.1))
    everywhere, nowhere, mapped = picture(), picture(bare), picture(half)
    wood, beside = np.s_[5:85, 90:155], np.s_[5:85, 5:70]
    assert np.abs(everywhere - nowhere)[..., 0].mean() > 25.0
    assert np.abs(mapped - everywhere)[wood].mean() < 1.0
    assert np.abs(mapped - nowhere)[beside].mean() < 1.0
