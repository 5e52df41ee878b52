"""Water and forests of a vector map on the ground: heights, levels, trees, pictures, and the GPU beside float64."""

from __future__ import annotations

import shutil
from typing import NamedTuple

import numpy as np
import pytest
from countries import write_hgt
from vector_kit import feature, line, polygon, ring, write_map

import planetfall as pf
from planetfall.engine.blocks.bindings import HEIGHT_MAP_UNIT, RIVERS_UNIT
from planetfall.engine.frame.labels import instances_of
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.polygons import Polygons
from planetfall.systems.terrain.ground_params import ground_params
from planetfall.systems.terrain.height import TerrainField, height_at_points
from planetfall.systems.terrain.height_table import canonical_table, octave_table
from planetfall.systems.terrain.real_texture import fixed_unit_m, real_texels
from planetfall.systems.terrain.rivers.texture import river_texels

LATITUDE, LONGITUDE = 46.5, 7.5
RADIUS_M = 6.371e6
SHORE = ring(LONGITUDE, LATITUDE, 0.012, 0.008, 200, 0.12)
ISLAND = ring(LONGITUDE, LATITUDE, 0.0016, 0.0011, 40)
WOOD = ring(LONGITUDE, LATITUDE + 0.014, 0.005, 0.003, 60, 0.2)
OTHER_WOOD = ring(LONGITUDE + 0.02, LATITUDE + 0.014, 0.005, 0.003, 60)
SOUTH = [(LONGITUDE + 0.002 * np.sin(40.0 * t), LATITUDE - 0.05 + 0.046 * t) for t in np.linspace(0.0, 1.0, 60)]
NORTH = [(LONGITUDE - 0.002 * np.sin(40.0 * t), LATITUDE + 0.004 + 0.046 * t) for t in np.linspace(0.0, 1.0, 60)]
SEA_SURFACE = 2


def scene_of(path, folder="", **knobs):
    scene = pf.load_scene("earth")
    terrain = scene.planet[pf.Terrain]
    terrain.rivers, terrain.height_map_detail, terrain.humidity = 0.0, 0.0, 1.0
    for name, value in knobs.items():
        setattr(terrain, name, value)
    terrain.height_map, terrain.vector_map = str(folder), str(path)
    return scene


def plain_of(scene):
    scene.planet[pf.Terrain].vector_map = ""
    return scene


class Valley(NamedTuple):
    folder: str
    file: str
    ground: pf.TerrainSampler
    plain: pf.TerrainSampler


@pytest.fixture(scope="module")
def valley(tmp_path_factory):
    """A valley that falls to the north, of samples of 3 seconds, with a lake, its rivers and two woods."""
    folder = tmp_path_factory.mktemp("valley")
    step = np.arange(1201) / 1200.0
    longitude, latitude = np.meshgrid(7.0 + step, 47.0 - step)
    across_km, along_km = (longitude - LONGITUDE) * 76.0, (latitude - LATITUDE) * 111.0
    heights = 700.0 - 6.0 * along_km + 40.0 * across_km**2 / (1.0 + across_km**2)
    heights += np.random.default_rng(1).normal(0.0, 1.0, heights.shape)
    write_hgt(folder / "tiles", 46, 7, 1201, np.rint(heights).astype(np.int16))
    file = write_map(
        folder / "map.geojson",
        feature(polygon(SHORE, ISLAND[::-1]), natural="water"),
        feature(line(*SOUTH), waterway="river", width=30),
        feature(line(*NORTH), waterway="river", width=30),
        feature({"type": "MultiPolygon", "coordinates": [[WOOD], [OTHER_WOOD]]}, natural="wood"),
    )
    tiles = folder / "tiles"
    scene = scene_of(file, tiles)
    return Valley(str(tiles), file, pf.TerrainSampler(scene), pf.TerrainSampler(plain_of(scene_of(file, tiles))))


def places(count, reach, seed=1):
    rng = np.random.default_rng(seed)
    longitude, latitude = LONGITUDE + reach * rng.uniform(-1, 1, count), LATITUDE + reach * rng.uniform(-1, 1, count)
    return longitude, latitude, np.ascontiguousarray(directions_at(latitude, longitude).T)


def away_m(rings, longitude, latitude):
    """Distance to rings."""
    metres = np.array([np.cos(np.radians(LATITUDE)), 1.0]) * np.radians(1.0) * RADIUS_M
    here, found = np.stack([longitude, latitude], axis=1) * metres, np.full(len(longitude), np.inf)
    for points in rings:
        a, b = (np.array(points)[part] * metres for part in (slice(None, -1), slice(1, None)))
        for start, way in zip(a, b - a, strict=True):
            t = np.clip((here - start) @ way / (way @ way), 0.0, 1.0)
            found = np.minimum(found, np.hypot(*(here - start - t[:, None] * way).T))
    return found


def test_a_lake_lies_in_its_polygon_at_the_lowest_height_of_its_rim(valley):
    longitude, latitude, directions = places(4000, 0.02)
    water = valley.ground.water(directions)
    lake = Polygons([(np.array(SHORE), np.array(ISLAND[::-1]))])
    inside, off = lake.inside(longitude, latitude), away_m([SHORE, ISLAND], longitude, latitude)
    river = away_m([SOUTH, NORTH], longitude, latitude) < 60.0
    clear = (off > 3.0) & ~river
    wet = ~np.isnan(water.level_m)
    assert 0.1 < inside.mean() < 0.8
    assert np.array_equal(wet[clear], inside[clear]), "within 3 m of the shore, and on the island"
    level = np.unique(water.level_m[inside & clear].round(4))
    rim = valley.plain.height(np.ascontiguousarray(directions_at(*np.array(SHORE).T[::-1]).T)).min()
    assert len(level) == 1 and rim - 1.5 < level[0] <= rim + 0.01
    assert 5.0 < water.depth_m.max() < 8.0
    far = (off > 130.0) & ~inside & (away_m([SOUTH, NORTH], longitude, latitude) > 200.0)
    np.testing.assert_allclose(valley.ground.height(directions[far]), valley.plain.height(directions[far]), atol=1e-3)


def test_rivers_never_rise_and_run_below_their_banks(valley):
    for points in (SOUTH, NORTH):
        t = np.linspace(0.0, 1.0, 800)
        at = np.stack([np.interp(t, np.linspace(0, 1, 60), np.array(points)[:, k]) for k in (0, 1)])
        directions = np.ascontiguousarray(directions_at(at[1], at[0]).T)
        water = valley.ground.water(directions)
        assert not np.isnan(water.level_m).any()
        # Where a river comes to a lake both levels mix.
        assert np.diff(water.level_m).max() < 0.02 and np.ptp(water.level_m) > 10.0
        assert water.depth_m.min() > 0.2
        east = np.ascontiguousarray(directions_at(at[1], at[0] + 40.0 / 76_500.0).T)
        lake = Polygons([(np.array(SHORE),)]).inside(at[0], at[1]) | (away_m([SHORE], at[0], at[1]) < 60.0)
        assert np.isnan(valley.ground.water(east).level_m[~lake]).all()
        speed = np.linalg.norm(water.current_m_s[~lake], axis=1)
        assert speed.min() > 0.05


def test_trees_stand_in_woods_alone_within_their_bounds(valley):
    scene = scene_of(valley.file, valley.folder)
    plain = plain_of(scene_of(valley.file, valley.folder))
    for one in (scene, plain):  # reeds grow along the map's rivers
        one.planet[pf.Cover].species = ()
    everywhere, found = pf.CoverSampler(plain), pf.CoverSampler(scene)
    middle = pf.direction(LATITUDE + 0.014, LONGITUDE + 0.01)
    woods = Polygons([(np.array(WOOD),), (np.array(OTHER_WOOD),)])

    def degrees(plants):
        x, y, z = plants.up.T
        return np.degrees(np.arctan2(y, x)), np.degrees(np.arctan2(z, np.hypot(x, y)))

    plants, others = found.within(middle, 900.0), everywhere.within(middle, 900.0)
    longitude, latitude = degrees(plants)
    boxed = woods.boxed(longitude, latitude)
    assert len(plants) > 20 and woods.inside(longitude[boxed], latitude[boxed]).all() and boxed.any()
    kept = woods.inside(*degrees(others)) | ~woods.boxed(*degrees(others))
    names = set(instances_of(others.names[kept]).tolist())
    assert set(plants.instances.tolist()) <= names and len(plants) > 0.9 * len(names)
    scene.planet[pf.Cover].mask = lambda d: np.zeros(len(d))
    assert not len(pf.CoverSampler(scene).within(middle, 900.0))


def test_a_map_without_tiles_and_a_sea_with_an_island(tmp_path):
    """On procedural ground, across the date line; a coast to the left of which is land."""
    sea = [[179.99, -50.01], [-179.99, -50.01], [-179.99, -49.99], [179.99, -49.99], [179.99, -50.01]]
    island = [[x - 360.0 * (x > 180.0), y] for x, y in ring(179.999, -50.0, 0.002, 0.002, 40)]
    path = write_map(tmp_path / "a.geojson", feature(polygon(sea), natural="bay"),
                     feature(line(*island), natural="coastline"))  # fmt: skip
    ground = pf.TerrainSampler(scene_of(path))
    latitude = np.full(200, -50.0)
    longitude = 180.0 + np.linspace(-0.009, 0.009, 200)
    height = ground.height(np.ascontiguousarray(directions_at(latitude, longitude).T))
    on_island = np.abs(longitude - 179.999) < 0.0018
    beside = np.abs(longitude - 179.999) > 0.0022
    assert (height[on_island] > 0.0).all() and (height[beside] < 0.0).all() and height.min() > -13.0
    outside = np.ascontiguousarray(directions_at(np.full(9, -49.98), np.linspace(179.9, 180.1, 9)).T)
    plain = pf.TerrainSampler(plain_of(scene_of(path)))
    np.testing.assert_allclose(ground.height(outside), plain.height(outside), atol=1e-6)


def test_the_same_file_gives_the_same_ground(valley, tmp_path):
    copy = shutil.copy(valley.file, tmp_path / "copy.geojson")
    again = pf.TerrainSampler(scene_of(copy, valley.folder))
    _, _, directions = places(300, 0.02, 5)
    assert np.array_equal(again.height(directions), valley.ground.height(directions))
    first, second = again.water(directions), valley.ground.water(directions)
    assert np.array_equal(first.level_m, second.level_m, equal_nan=True)


@pytest.mark.parametrize(
    ("knobs", "words"),
    [
        ({"rivers": 1.0}, ("Terrain.rivers is 1", "set it to 0")),
        ({"craters": 0.5}, ("Terrain.craters is 0.5",)),
    ],
)
def test_what_does_not_go_with_it(tmp_path, knobs, words):
    path = write_map(tmp_path / "a.geojson", feature(polygon(SHORE), natural="water"))
    with pytest.raises(ValueError, match=words[0]):
        pf.TerrainSampler(scene_of(path, **knobs))


def test_errors_come_before_any_drawing(tmp_path):
    (tmp_path / "a.geojson").write_text('{"type": "FeatureCollection",\n "features": [}', encoding="utf-8")
    with pytest.raises(ValueError, match=r"Terrain\.vector_map: .*a\.geojson, line 2"):
        scene_of(tmp_path / "a.geojson").validate()


def test_a_scene_file_names_it_from_its_own_place(tmp_path):
    write_map(tmp_path / "a.geojson", feature(polygon(WOOD), natural="wood"))
    scene = scene_of(tmp_path / "a.geojson")
    scene.save(tmp_path / "a.toml")
    assert 'vector_map = "a.geojson"' in (tmp_path / "a.toml").read_text(encoding="utf-8")
    found = pf.load_scene(tmp_path / "a.toml").planet[pf.Terrain].vector_map
    assert found == str(tmp_path / "a.geojson")


HEADER = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_TILED\n"


@pytest.mark.parametrize("canonical", [False, True])
def test_heights_on_the_gpu(run_compute, gpu, valley, canonical):
    """Within a millimetre of float64: on shores, beds, banks, and where levels end."""
    terrain = scene_of(valley.file, valley.folder).planet[pf.Terrain]
    params = ground_params(terrain, RADIUS_M)
    scope = gpu.scope("test")
    rng = np.random.default_rng(3)
    up = directions_at(LATITUDE + 0.004, LONGITUDE)
    axis = rng.normal(size=(3000, 3))
    d = up + axis * (1000.0 * rng.random((3000, 1)) / RADIUS_M / np.linalg.norm(axis, axis=1)[:, None])
    d /= np.linalg.norm(d, axis=1)[:, None]
    table = canonical_table(params) if canonical else octave_table(params, up)
    block = scope.buffer(table.tobytes())
    words = real_texels(params.real, fixed_unit_m(params.radius_m), params.radius_m)
    texture = scope.texture(words.shape[::-1], "r32ui", words)

    def bind(_):
        block.bind_to_uniform_block(4)
        texture.use(HEIGHT_MAP_UNIT)

    spacing = np.full(len(d), 0.1, np.float32)
    if canonical:
        high = d.astype(np.float32)
        inputs = {"high": high, "low": (d - high).astype(np.float32), "spacing": spacing}
        body = "Pair h; TerrainPoint p = terrain_canonical(Pair3(high, low), spacing, h); metres = vec2(h.high, h.low);"
        header = HEADER + '#include "terrain/canonical_height.glsl"'
        out = run_compute(body, inputs, {"metres": "vec2"}, header=header, setup=bind)
        found = out["metres"].astype(np.float64).sum(axis=1)
        points = d * RADIUS_M
    else:
        offset = ((d - up) * RADIUS_M).astype(np.float32)
        points = up * RADIUS_M + offset.astype(np.float64)
        header = HEADER + '#include "terrain/height.glsl"'
        out = run_compute(
            "dh = terrain_point(d, spacing).dh;", {"d": offset, "spacing": spacing}, {"dh": "float"}, header=header,
            setup=bind,
        )  # fmt: skip
        found = out["dh"] + height_at_points(up[None] * RADIUS_M, params)[0]
    scope.release()
    assert np.abs(found - height_at_points(points, params)).max() < 1e-3


def beside_rivers(count=2000, away_m=180.0, seed=7):
    """Unit directions (N, 3) about both rivers, and how far each is from their lines, metres."""
    rng = np.random.default_rng(seed)
    lines = [np.array(way) for way in (SOUTH, NORTH)]
    a, b = (np.concatenate([way[k : len(way) - 1 + k] for way in lines]) for k in (0, 1))
    at, t = rng.integers(len(a), size=count), rng.random((count, 1))
    metre = np.degrees(1.0 / RADIUS_M) / np.array([np.cos(np.radians(LATITUDE)), 1.0])
    found = a[at] + t * (b[at] - a[at]) + rng.uniform(-away_m, away_m, (count, 2)) * metre
    p, start, way = found[:, None] / metre, a[None] / metre, (b - a)[None] / metre
    along = np.clip(((p - start) * way).sum(axis=2) / (way * way).sum(axis=2), 0.0, 1.0)
    away = np.sqrt(((p - start - along[..., None] * way) ** 2).sum(axis=2)).min(axis=1)
    return np.ascontiguousarray(directions_at(found[:, 1], found[:, 0]).T), away


def test_banks_of_mapped_rivers_are_wetter(valley):
    """1 in their water, 0 from 100 m from it on; rivers that are 30 m wide."""
    params = ground_params(scene_of(valley.file, valley.folder).planet[pf.Terrain], RADIUS_M)
    field = TerrainField(params)
    d, away = beside_rivers()
    north_south = np.abs(d[:, 2] - np.sin(np.radians(LATITUDE))) > np.radians(0.014)  # no lake's water near
    near = field.beside_water(d[north_south])
    # Lines leave out up to a tenth of their half width, and a metre.
    expected = np.clip(1.0 - (away[north_south] - 15.0) / 100.0, 0.0, 1.0)
    np.testing.assert_allclose(near, expected, atol=0.03)
    assert (near == 1.0).any() and (near == 0.0).any()
    # In the middle of the lake no line of a river is near.
    assert field.beside_water(directions_at(LATITUDE, LONGITUDE + 0.006)[None]).max() == 0.0


@pytest.mark.parametrize("canonical", [False, True])
def test_banks_on_the_gpu(run_compute, gpu, valley, canonical):
    """Moisture of vertices is float64's along mapped rivers: trees of both stand at the same places."""
    params = ground_params(scene_of(valley.file, valley.folder).planet[pf.Terrain], RADIUS_M)
    field, scope = TerrainField(params), gpu.scope("test")
    up = directions_at(LATITUDE + 0.02, LONGITUDE)
    d, _ = beside_rivers()
    _, texels = river_texels(params.waters)
    waters = scope.texture(texels.shape[1::-1], "rgba32ui", texels)
    words = real_texels(params.real, fixed_unit_m(params.radius_m), params.radius_m)
    texture = scope.texture(words.shape[::-1], "r32ui", words)

    def moisture(wetter):
        table = canonical_table(params) if canonical else octave_table(params, up)
        table["rivers"]["wetter"] = wetter
        block = scope.buffer(table.tobytes())

        def bind(_):
            block.bind_to_uniform_block(4)
            texture.use(HEIGHT_MAP_UNIT)
            waters.use(RIVERS_UNIT)

        spacing = np.full(len(d), 4.0, np.float32)
        header = HEADER + "#define TERRAIN_RIVERS\n"
        if canonical:
            high = d.astype(np.float32)
            inputs = {"high": high, "low": (d - high).astype(np.float32), "spacing": spacing}
            body, file = "Pair h; wet = terrain_canonical(Pair3(high, low), spacing, h).moisture;", "canonical_height"
        else:
            inputs = {"d": ((d - up) * RADIUS_M).astype(np.float32), "spacing": spacing}
            body, file = "wet = terrain_point(d, spacing).moisture;", "height"
        header += f'#include "terrain/{file}.glsl"'
        return run_compute(body, inputs, {"wet": "float"}, header=header, setup=bind)["wet"].astype(np.float64)

    dry = moisture(0.0)
    np.testing.assert_allclose(dry, field.moisture(d), atol=2e-4)
    near = field.beside_water(d)
    assert (near > 0.3).sum() > 500
    for wetter in (0.5, 1.0):
        np.testing.assert_allclose(moisture(wetter), np.minimum(dry + 0.4 * wetter * near, 1.0), atol=2e-4)
    scope.release()


def test_the_ground_is_greener_along_mapped_rivers(valley):
    """Where trees end the ground's own colour has them, by what the samplers' trees follow: Cover.riparian."""
    scene = scene_of(valley.file, valley.folder, humidity=0.45)
    cover = scene.planet[pf.Cover]
    place = SOUTH[25]
    sun = pf.Sun(elevation_deg=50.0, azimuth_deg=180.0, latitude_deg=place[1], longitude_deg=place[0])
    camera = pf.Camera.at(place[1], place[0], 900.0, pitch_deg=-90.0, above="ground")
    shown = {}
    overrides = {"cover.reach_m": 100.0, "composite.antialiasing": "none"}
    with pf.Renderer(scene, (160, 90), "low", overrides) as renderer:
        for riparian in (0.0, 1.0):
            cover.riparian = riparian
            renderer.settle(camera)
            out = renderer.render(camera, sun=sun, outputs=("albedo", "position", "surface"))
            shown[riparian] = {name: value.copy() for name, value in out.items()}
        eye = renderer.camera_state(camera).position_m
    land = (shown[0.0]["surface"] == 1) & (shown[1.0]["surface"] == 1) & (shown[0.0]["albedo"].min(axis=-1) > 0.02)
    at = shown[0.0]["position"][land] + eye
    field = TerrainField(ground_params(scene.planet[pf.Terrain], RADIUS_M))
    near = field.beside_water(at / np.linalg.norm(at, axis=1, keepdims=True))
    dry, wet = (shown[k]["albedo"][land].sum(axis=-1) for k in (0.0, 1.0))
    assert (near > 0.6).sum() > 50 and np.median(wet[near > 0.6] / dry[near > 0.6]) < 0.97
    assert np.median(np.abs(wet / dry - 1.0)[near == 0.0]) < 0.01


def test_pixels_of_water_are_where_the_sampler_has_it(valley):
    scene = scene_of(valley.file, valley.folder)
    scene.planet.remove(pf.Cover)
    scene.sun = pf.Sun(elevation_deg=50.0, azimuth_deg=120.0, latitude_deg=LATITUDE, longitude_deg=LONGITUDE)
    camera = pf.Camera.at(LATITUDE - 0.012, LONGITUDE, 700.0, heading_deg=0.0, pitch_deg=-40.0, above="ground")
    with pf.Renderer(scene, size=(240, 136), quality="medium") as renderer:
        renderer.settle(camera)
        seen = renderer.render(camera, outputs=("surface", "position"))
        state = renderer.camera_state(camera)
    offset = seen["position"].astype(np.float64).reshape(-1, 3)
    shown = np.isfinite(offset).all(axis=1)
    points = offset[shown] + state.position_m
    distance, far = np.linalg.norm(offset[shown], axis=1), np.linalg.norm(points, axis=1)
    water = valley.ground.water(points / far[:, None])
    wet, drawn = ~np.isnan(water.level_m), (seen["surface"].ravel() == SEA_SURFACE)[shown]
    near = distance < 4000.0
    assert 0.1 < wet[near].mean() < 0.9
    # Pixels are up to 20 m wide there, and a shore passes some of them.
    assert (wet == drawn)[near].mean() > 0.985
    both = wet & drawn & near
    # By the shore distant vertices may stand above it.
    assert np.quantile(np.abs(far - RADIUS_M - water.level_m)[both], 0.95) < 0.05
