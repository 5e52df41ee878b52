"""Tiles of elevation on a planet: heights, slopes, rays and contacts in float64, pictures, errors."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import weakref
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from countries import hgt_samples, jacksboro, write_country, write_hgt, write_jacksboro

import planetfall as pf
from planetfall.benchmarks.measure.ground import picture_error, vertex_heights
from planetfall.engine.real_ground.resident import real_ground
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.systems.terrain.height import TerrainField, TerrainParams, height_and_gradient, height_at_points

RADIUS_M = 6.371e6
PLAIN = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)


def scene_of(folder, **knobs):
    scene = pf.load_scene("earth")
    terrain = scene.planet[pf.Terrain]
    terrain.rivers, terrain.height_map_detail = 0.0, 0.0
    for name, value in knobs.items():
        setattr(terrain, name, value)
    terrain.height_map = str(folder)
    return scene


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A country of 3 minutes, and a rough tile of 9 seconds in it."""
    path = tmp_path_factory.mktemp("country")
    write_country(path / "coarse", 44, 5, 5, 6, 21)
    rough = hgt_samples(46, 7, 401) + np.random.default_rng(1).normal(0.0, 8.0, (401, 401))
    write_hgt(path / "fine", 46, 7, 401, np.rint(rough).astype(np.int16))
    return path


@pytest.fixture(scope="module", params=[0.0, 1.0], ids=["bare", "detail"])
def params(request, folder):
    return replace(PLAIN, real=real_ground(str(folder), 64_000_000, "x"), height_map_detail=request.param)


def test_heights_are_the_files_and_the_procedural_ones_beyond(tmp_path):
    values = np.rint(np.random.default_rng(2).normal(900.0, 60.0, (41, 41))).astype(np.int16)
    write_hgt(tmp_path, 46, 7, 41, values)
    ground = pf.TerrainSampler(scene_of(tmp_path))
    step = np.arange(41) / 40.0
    latitude, longitude = np.meshgrid(47.0 - step, 7.0 + step, indexing="ij")
    found = ground.height(pf.direction(latitude.ravel(), longitude.ravel()))
    assert np.abs(found - values.ravel()).max() < 1e-3
    far = pf.direction(np.linspace(-80.0, 30.0, 300), np.linspace(-170.0, -60.0, 300))
    plain = scene_of(tmp_path)
    plain.planet[pf.Terrain].height_map = ""
    np.testing.assert_array_equal(ground.height(far), pf.TerrainSampler(plain).height(far))


@pytest.mark.parametrize("most_mb", [256.0, 1.0], ids=["in memory", "streamed"])
def test_high_tiles_leave_the_ground_around_as_it_is(tmp_path, most_mb):
    """Samples above Terrain.highest_m raise the bounds, and nothing else."""
    values = np.rint(np.random.default_rng(2).normal(9500.0, 60.0, (801, 801))).astype(np.int16)
    write_hgt(tmp_path, 46, 7, 801, values)
    scene, plain = scene_of(tmp_path, height_map_most_mb=most_mb), scene_of(tmp_path)
    plain.planet[pf.Terrain].height_map = ""
    far = pf.direction(np.linspace(-80.0, 30.0, 300), np.linspace(-170.0, -60.0, 300))
    ground, without = pf.TerrainSampler(scene), pf.TerrainSampler(plain)
    assert ground.highest_m > values.max() > without.highest_m
    np.testing.assert_array_equal(ground.height(far), without.height(far))


def test_slopes_are_those_of_the_heights(params):
    """In the finest tile, in the country and at its margins; but for how relief comes in there."""
    rng = np.random.default_rng(3)
    for latitude, longitude, most in ((46.5, 7.5, 2e-3), (45.0, 9.0, 2e-3), (43.7, 8.0, 1e-2)):
        up = pf.direction(latitude + rng.uniform(-0.4, 0.4, 1000), longitude + rng.uniform(-0.4, 0.4, 1000))
        side = np.cross(up, [0.3, 0.5, 0.8])
        side /= np.linalg.norm(side, axis=1)[:, None]
        points, step = up * RADIUS_M, 1e-2
        slope = (height_at_points(points + step * side, params) - height_at_points(points - step * side, params)) / 0.02
        height, gradient = height_and_gradient(up, params)
        assert np.quantile(np.abs((gradient * side).sum(axis=1) - slope), 0.98) < most
        np.testing.assert_allclose(height, height_at_points(points, params), atol=1e-6)


def test_slopes_are_bounded(params):
    rng = np.random.default_rng(4)
    up = pf.direction(rng.uniform(42.0, 50.0, 4000), rng.uniform(3.0, 13.0, 4000))
    _, gradient = height_and_gradient(up, params)
    _, bound = TerrainField(params).height_slope(up)
    assert (np.linalg.norm(gradient, axis=1) > bound).mean() < 2e-3


def test_rays_meet_the_ground(folder):
    """No ray goes through ground, and each ends on it."""
    for detail in (0.0, 1.0):
        ground = pf.TerrainSampler(scene_of(folder, height_map_detail=detail))
        rng = np.random.default_rng(5)
        up = pf.direction(rng.uniform(43.0, 49.5, 120), rng.uniform(4.0, 12.0, 120))
        side = rng.normal(size=(120, 3))
        side -= up * (side * up).sum(axis=1)[:, None]
        way = side / np.linalg.norm(side, axis=1)[:, None] - 0.08 * up
        way /= np.linalg.norm(way, axis=1)[:, None]
        origin = up * (RADIUS_M + ground.height(up) + 1000.0)[:, None]
        hit, distance = ground.raycast(origin, way, 1e5)[:2]
        assert hit.mean() > 0.9
        for k in range(120):
            t = np.linspace(0.0, min(distance[k], 1e5), 1500)
            place = origin[k] + way[k] * t[:, None]
            away = np.linalg.norm(place, axis=1)
            above = away - RADIUS_M - ground.height(place / away[:, None])
            assert above[:-1].min() > -1e-3
            assert not hit[k] or abs(above[-1]) < 1e-3


def test_spheres_touch_it(folder):
    ground = pf.TerrainSampler(scene_of(folder))
    up = pf.direction(np.array([46.51, 46.48]), np.array([7.52, 7.47]))
    centre = up * (RADIUS_M + ground.height(up) + 0.4)[:, None]
    depth, normal = ground.sphere_contact(centre, np.full(2, 0.5))
    assert (depth > 0.05).all() and ((normal * up).sum(axis=1) > 0.5).all()


def test_relief_goes_on_below_the_samples(folder):
    """As rough as the tile: 8 m from sample to sample, 280 m apart; smooth ground gets hardly any."""
    bare, fine = (pf.TerrainSampler(scene_of(folder, height_map_detail=k)) for k in (0.0, 1.0))
    rng = np.random.default_rng(6)
    rough = pf.direction(46.5 + rng.uniform(-0.3, 0.3, 2000), 7.5 + rng.uniform(-0.3, 0.3, 2000))
    smooth = pf.direction(45.0 + rng.uniform(-0.3, 0.3, 2000), 9.0 + rng.uniform(-0.3, 0.3, 2000))
    added = [float(np.std(fine.height(d) - bare.height(d))) for d in (rough, smooth)]
    assert 1.0 < added[0] < 10.0 and added[1] < 0.3 * added[0]


def test_a_real_valley(tmp_path):
    """The fault at Jacksboro, Tennessee, in SRTM's 3 arc seconds, which matplotlib ships: the file's heights, and
    relief below its samples."""
    pytest.importorskip("tifffile")
    found = jacksboro()
    if found is None or not write_jacksboro(tmp_path):
        pytest.skip("matplotlib without its sample data")
    heights, step, west, north = found
    ground = pf.TerrainSampler(scene_of(tmp_path))
    rows, columns = heights.shape
    latitude, longitude = np.meshgrid(
        north - step * (np.arange(rows) + 0.5), west + step * (np.arange(columns) + 0.5), indexing="ij"
    )
    found = ground.height(pf.direction(latitude.ravel(), longitude.ravel())).reshape(heights.shape)
    assert np.abs(found - heights).max() < 1e-3
    # Bumps of 23 m, which samples 93 m apart cannot show.
    fine = pf.TerrainSampler(scene_of(tmp_path, height_map_detail=1.0))
    rng = np.random.default_rng(8)
    latitude, longitude = rng.uniform(36.47, 36.71, 4000), rng.uniform(-84.39, -84.10, 4000)

    def bumps_m(sampler):
        low, here, high = (
            sampler.height(pf.direction(latitude + d * 0.25 * step, longitude)) for d in (-1.0, 0.0, 1.0)
        )
        return float(np.std(low - 2.0 * here + high))

    assert bumps_m(fine) > 1.2 * bumps_m(ground)


def test_paths_count_from_the_scenes_folder(tmp_path):
    write_hgt(tmp_path / "tiles", 46, 7, 31)
    file = tmp_path / "world.toml"
    file.write_text('[planet]\nradius_m = 6.371e6\n[terrain]\nheight_map = "tiles"\nheight_map_detail = 0.0\n')
    found = pf.TerrainSampler(pf.load_scene(file)).height(pf.direction(46.5, 7.5)[None])
    assert abs(found[0] - hgt_samples(46, 7, 31)[15, 15]) < 1e-3


def test_saved_scenes_find_their_tiles(tmp_path, monkeypatch):
    """Named from the working folder: in the scene's own one both move together, elsewhere the path is whole."""
    monkeypatch.chdir(tmp_path)
    write_hgt(tmp_path / "places" / "tiles", 46, 7, 31)
    scene = scene_of(Path("places/tiles"))
    scene.save("places/beside.toml")
    Path("far").mkdir()
    scene.save("far/away.toml")
    for file in ("places/beside.toml", "far/away.toml"):
        found = pf.load_scene(file).planet[pf.Terrain].height_map
        assert Path(found) == tmp_path / "places" / "tiles"
    (tmp_path / "places").rename(tmp_path / "moved")
    assert Path(pf.load_scene("moved/beside.toml").planet[pf.Terrain].height_map) == tmp_path / "moved" / "tiles"
    with pytest.raises(pf.SceneError, match=r"no file .*places/tiles.*correct the path"):
        pf.load_scene("far/away.toml")


@pytest.mark.parametrize("knob", ["height_map", "color_map", "vector_map"])
@pytest.mark.parametrize("path", ["~nobody of that name", "~nobody of that name/a.toml", "x" * 300])
def test_paths_to_nothing_are_told(tmp_path, knob, path):
    """Homes of users who aren't there, and names that no folder takes, in files of scenes and set on them."""
    file = tmp_path / "world.toml"
    file.write_text(f'base = "earth"\n[terrain]\nrivers = 0.0\n{knob} = "{path}"\n')
    with pytest.raises(pf.SceneError, match=rf"Terrain\.{knob}: .*{path}.*correct the (path|file)"):
        pf.load_scene(file).validate()
    scene = pf.load_scene("earth")
    scene.planet[pf.Terrain].rivers = 0.0
    setattr(scene.planet[pf.Terrain], knob, path)
    with pytest.raises(pf.SceneError, match=rf"Terrain\.{knob}: .*{path}.*correct the (path|file)"):
        scene.validate()


def test_one_tile_is_no_map(tmp_path):
    file = write_hgt(tmp_path, 46, 7, 31)
    with pytest.raises(pf.SettingError, match="is one tile; expected the folder"):
        scene_of(file).validate()


def test_other_tiles_leave_nothing_behind(folder):
    """What is remembered by ground would hold on to the tiles of each."""
    scene, gone = scene_of(folder), []
    for most_mb in (60.0, 50.0, 40.0):
        scene.planet[pf.Terrain].height_map_most_mb = most_mb
        params = TerrainParams.from_component(scene.planet[pf.Terrain], RADIUS_M)
        TerrainField(params).height_slope(pf.direction(46.5, 7.5)[None])
        pf.TerrainSampler(scene).raycast(1.01 * RADIUS_M * pf.direction(46.5, 7.5), -pf.direction(46.5, 7.5), 1e6)
        gone.append(weakref.ref(params.real))
        del params
    gc.collect()
    assert [ref() is not None for ref in gone] == [False, False, True]


@pytest.mark.parametrize(
    ("knob", "words"),
    [
        ("rivers = 1.0", ("Terrain.rivers", "set it to 0")),
        ("craters = 0.5", ("Terrain.craters", "to 0")),
        ("height_map_range_m = [0.0, 1.0]", ("Terrain.height_map_range_m", "leave it out")),
    ],
)
def test_what_does_not_go_together(tmp_path, knob, words):
    write_hgt(tmp_path / "tiles", 46, 7, 31)
    file = tmp_path / "world.toml"
    file.write_text(f'[planet]\nradius_m = 6.371e6\n[terrain]\nheight_map = "tiles"\n{knob}\n')
    with pytest.raises(pf.SettingError) as caught:
        pf.load_scene(file)
    for word in words:
        assert word in str(caught.value)


def test_tiles_are_no_part_of_a_shared_scene(tmp_path):
    write_hgt(tmp_path / "tiles", 46, 7, 31)
    scene = scene_of(tmp_path / "tiles")
    with pytest.raises(pf.PresetError, match="no part of a shared scene; give the folder along"):
        scene.share(tmp_path / "a.planetfall")


@pytest.mark.gpu
@pytest.mark.parametrize("backend", ["grid", "quadtree", "icosphere"])
def test_pictures_show_the_samplers_ground(folder, backend):
    """The surface is where rays meet the ground, in all three ways to draw it; set on a running scene, too. What is
    between vertices, which are right to a millimetre, is off by a pixel at most, as of any ground."""
    scene = scene_of(folder, backend=backend)
    camera = pf.Camera.at(46.45, 7.5, 3000.0, heading_deg=10.0, pitch_deg=-25.0, above="ground")
    with pf.Renderer(scene, size=(48, 27), quality="medium") as renderer:
        renderer.settle(camera)
        distance = renderer.render(camera, outputs=("distance",))["distance"]
        shown = picture_error(renderer, camera, np.random.default_rng(5))
        terrain = scene.planet[pf.Terrain]
        path, terrain.height_map = terrain.height_map, ""
        renderer.settle(camera)
        other = renderer.render(camera, outputs=("distance",))["distance"]
        terrain.height_map = path
        renderer.settle(camera)
        again = renderer.render(camera, outputs=("distance",))["distance"]
    pixels = np.array([(i, j) for i in range(4, 48, 8) for j in range(14, 27, 4)])
    pose = camera.resolve(scene)
    right = np.cross(pose.forward, pose.up)
    y = np.tan(np.radians(30.0)) * (1.0 - 2.0 * (pixels[:, 1] + 0.5) / 27.0)
    x = np.tan(np.radians(30.0)) * 48.0 / 27.0 * (2.0 * (pixels[:, 0] + 0.5) / 48.0 - 1.0)
    way = pose.forward + x[:, None] * right + y[:, None] * pose.up
    way /= np.linalg.norm(way, axis=1)[:, None]
    origin = np.broadcast_to(pose.position_m, way.shape)
    hit, exact = pf.TerrainSampler(scene).raycast(origin, way, 1e6)[:2]
    found = distance[pixels[:, 1], pixels[:, 0]]
    assert shown is not None and shown.pixels > 500 and shown.worst_px < 1.0 and shown.median_px < 0.05
    # Against rays, without the drawn positions: a pixel is 2.2 degrees, so a tenth of one at 15 degrees and more below
    # the horizon is 1.5 % of a distance.
    assert hit.all() and np.quantile(np.abs(found / exact - 1.0), 0.9) < 0.1 * np.radians(2.2) / np.tan(np.radians(15))
    assert not np.allclose(other, distance, rtol=1e-2)
    np.testing.assert_allclose(again, distance, rtol=1e-4)


@pytest.fixture(scope="module")
def large(tmp_path_factory):
    """The same with a tile of 1.5 seconds: 23 MB."""
    path = tmp_path_factory.mktemp("large")
    write_country(path / "coarse", 44, 5, 5, 6, 21)
    rough = hgt_samples(46, 7, 2401) + np.random.default_rng(1).normal(0.0, 8.0, (2401, 2401))
    write_hgt(path / "fine", 46, 7, 2401, np.rint(rough).astype(np.int16))
    return path


@pytest.mark.gpu
@pytest.mark.parametrize("streams", [False, True], ids=["in memory", "streamed"])
@pytest.mark.parametrize("place", [(46.45, 7.5), (46.3, 8.0), (46.0, 7.0), (49.0, 8.0), (49.2, 8.0)])
def test_vertices_of_the_grid_are_the_samplers_ground(folder, large, place, streams):
    """To 1 mm within 1 km, and a millionth of the distance beyond: in the rough tile, at its border and its corner, at
    the country's edge and in the margin around it. The picture is so small that less than a page around the camera
    shows much: those beside it are there all the same. Vertices of the other backends: test_tiles.py."""
    scene = scene_of(large, height_map_most_mb=12.0) if streams else scene_of(folder)
    camera = pf.Camera.at(*place, 300.0, heading_deg=10.0, pitch_deg=-10.0, above="ground")
    with pf.Renderer(scene, size=(48, 27), quality="medium") as renderer:
        renderer.settle(camera)
        found = vertex_heights(renderer, camera, np.random.default_rng(2), most=5000)
        assert isinstance(renderer.system("terrain").backend.ground.params.real, StreamedGround) == streams
    assert found.near_vertices > 1000
    assert found.near_m < 1e-3
    # Drawn vertices leave out what is too fine for their distance of the procedural ground around, not of tiles.
    assert found.drawn_near_m < (1e-3 if place[0] < 49.1 else 1e-2)
    assert streams or found.by_distance < 1e-6  # pages that the camera doesn't see aren't there


@pytest.mark.gpu
def test_a_planet_of_another_size_has_its_tiles(folder):
    """Places of samples are counted on the sphere: a texture of another radius is off by metres."""
    scene = scene_of(folder)
    camera = pf.Camera.at(46.45, 7.5, 300.0, heading_deg=10.0, pitch_deg=-25.0, above="ground")
    with pf.Renderer(scene, size=(48, 27), quality="low") as renderer:
        renderer.render(camera)
        scene.planet[pf.Planet].radius_m = 3e6
        renderer.settle(camera)
        found = renderer.render(camera, outputs=("distance",))["distance"]
    with pf.Renderer(scene, size=(48, 27), quality="low") as renderer:
        renderer.settle(camera)
        np.testing.assert_allclose(found, renderer.render(camera, outputs=("distance",))["distance"], rtol=1e-5)


@pytest.mark.gpu
@pytest.mark.parametrize("backend", ["grid", "quadtree"])
def test_shaders_and_passes_are_what_all_drivers_take(folder, tmp_path, backend):
    file = tmp_path / "world.toml"
    file.write_text(
        f'[planet]\nradius_m = {RADIUS_M}\n[terrain]\nheight_map = "{folder}"\nbackend = "{backend}"\nlayers = 6\n'
    )
    code = (
        "import sys, planetfall as pf\n"
        "scene = pf.load_scene(sys.argv[1])\n"
        "camera = pf.Camera.at(46.45, 7.5, 300.0, pitch_deg=-25.0, above='ground', ev100=13.0)\n"
        "with pf.Renderer(scene, size=(48, 27), quality='low') as renderer:\n"
        "    renderer.render(camera)\n"
    )
    told = subprocess.run(
        [sys.executable, "-P", "-c", code, str(file)],
        check=False, env={**os.environ, "PLANETFALL_VALIDATE": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr[-2000:]
