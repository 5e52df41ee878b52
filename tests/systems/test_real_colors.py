"""Tiles of pictures in scenes: all three ways to draw ground, what is saved and shared, and that they cost nothing
where there are none."""

from __future__ import annotations

import logging
import os
import subprocess
import sys

import numpy as np
import pytest
from countries import tile_at, write_fields, write_picture

import planetfall as pf
from planetfall.engine.real_ground.color_reading import real_colors
from planetfall.engine.wavelengths import DISPLAY_NM
from planetfall.systems.terrain.height_table import octave_table

PLACE = (46.5, 7.5)
WORLD = "[planet]\nradius_m = 6.371e6\n[terrain]\nlayers = 6\nclutter = 0.0\nrivers = 0.0\n"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pictures")
    write_fields(folder / "tiles", 13, *PLACE, 4)
    return folder


def scene_of(folder, **knobs):
    file = folder / "world.toml"
    file.write_text(WORLD)
    scene = pf.load_scene(file)
    terrain = scene.planet[pf.Terrain]
    for name, value in {"color_map": str(folder / "tiles"), **knobs}.items():
        setattr(terrain, name, value)
    return scene


@pytest.mark.gpu
@pytest.mark.parametrize("backend", ["grid", "quadtree", "icosphere"])
def test_albedo_is_the_pictures(folder, backend):
    """Looking straight down, pixels show what the twin says of their footprints; on a running scene, too."""
    scene = scene_of(folder, backend=backend)
    camera = pf.Camera.at(*PLACE, 9000.0, pitch_deg=-90.0, fov_y_deg=30.0, above="ground")
    with pf.Renderer(scene, size=(64, 36), quality="medium") as renderer:
        renderer.settle(camera)
        out = renderer.render(camera, outputs=("albedo", "distance"))
        scene.planet[pf.Terrain].color_map = ""
        renderer.settle(camera)
        plain = renderer.render(camera, outputs=("albedo",))["albedo"]
    pose = camera.resolve(scene)
    right = np.cross(pose.forward, pose.up)
    j, i = np.mgrid[0:36, 0:64]
    y, x = np.tan(np.radians(15.0)) * (1.0 - (j + 0.5) / 18.0), np.tan(np.radians(15.0)) * ((i + 0.5) / 18.0 - 64 / 36)
    way = pose.forward + x[..., None] * right + y[..., None] * pose.up
    way /= np.linalg.norm(way, axis=2)[..., None]
    points = (pose.position_m + out["distance"][..., None].astype(float) * way).reshape(-1, 3).T
    found = real_colors(str(folder / "tiles"), DISPLAY_NM, 256_000_000, "Terrain.color_map")
    pixel_rad = 2.0 * np.tan(np.radians(15.0)) / 36.0
    footprint = 0.85 * out["distance"].ravel() * pixel_rad / 6.371e6
    values, weight = found.sample(points, footprint.astype(float))
    assert weight.min() == 1.0
    off = np.abs(out["albedo"].reshape(-1, 3) - values.T)
    assert np.quantile(off, 0.95) < 0.01 and np.std(values, axis=1).max() > 0.02
    assert np.abs(plain - out["albedo"]).mean() > 0.02


@pytest.mark.gpu
def test_far_pictures_do_not_flicker(folder, tmp_path):
    """Stripes a pixel wide, seen from so far that one pixel of the view has many: no pixel changes as it moves."""
    x, y = tile_at(12, *PLACE)
    stripes = np.zeros((256, 256, 3), np.uint8)
    stripes[:, ::2] = 220
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            write_picture(tmp_path / "tiles", 12, x + dx, y + dy, stripes)
    scene = scene_of(tmp_path)
    found = []
    with pf.Renderer(scene, size=(32, 18), quality="medium") as renderer:
        for step in range(3):
            camera = pf.Camera.at(PLACE[0], PLACE[1] + 7e-5 * step, 6e4, pitch_deg=-90.0, fov_y_deg=5.0)
            renderer.settle(camera)
            found.append(renderer.render(camera, outputs=("albedo",))["albedo"])
    assert np.std(found[0][..., 1]) < 0.01 and 0.2 < found[0][..., 1].mean() < 0.6
    assert np.abs(found[1] - found[0]).max() < 0.02 and np.abs(found[2] - found[0]).max() < 0.02


def test_the_table_knows_no_pictures_without_any(folder):
    """Of ground without pictures nothing is written, and of ground with them moisture stays its own."""
    from planetfall.systems.terrain.height import TerrainParams

    up = np.array([1.0, 0.0, 0.0])
    plain, pictured = (octave_table(TerrainParams(pictured=on, layers=2), up) for on in (False, True))
    assert not plain["real"]["place"].any() and pictured["real"]["place"].any()
    assert plain["color"]["cells"] == pictured["color"]["cells"] == 0


@pytest.mark.gpu
def test_shaders_leave_pictures_out_without_any(folder):
    scene = scene_of(folder)
    for path, there in ((str(folder / "tiles"), True), ("", False)):
        scene.planet[pf.Terrain].color_map = path
        with pf.Renderer(scene, size=(16, 9), quality="low") as renderer:
            renderer.render(pf.Camera.at(*PLACE, 500.0, above="ground"))
            expanded = renderer.gpu.shaders.sources.expand("terrain/shade.comp")
            assert ("#define TERRAIN_PICTURED" in expanded.text) == there


def test_paths_and_sharing(folder, tmp_path):
    (tmp_path / "fields").mkdir()
    write_fields(tmp_path / "fields", 13, *PLACE, 1)
    file = tmp_path / "world.toml"
    file.write_text(WORLD + 'color_map = "fields"\n')
    scene = pf.load_scene(file)
    assert scene.planet[pf.Terrain].color_map == str(tmp_path / "fields")
    with pytest.raises(pf.PresetError, match=r"tiles of pictures.*give the folder along"):
        scene.share(tmp_path / "a.planetfall")


def test_a_broken_tile_is_one_warning(tmp_path, caplog):
    """However often a scene is looked at."""
    write_fields(tmp_path / "tiles", 13, *PLACE, 2)
    (tmp_path / "tiles" / "13" / "4266").mkdir(exist_ok=True)
    broken = tmp_path / "tiles" / "13" / "4266" / "7.png"
    broken.write_bytes(b"no picture")
    file = tmp_path / "world.toml"
    file.write_text(WORLD + 'color_map = "tiles"\n')
    with caplog.at_level(logging.WARNING):
        scene = pf.load_scene(file)
        with pf.Renderer(scene, size=(16, 9), quality="low") as renderer:
            renderer.render(pf.Camera.at(*PLACE, 500.0, above="ground"))
    assert sum(str(broken) in record.message for record in caplog.records) == 1


@pytest.mark.parametrize(
    ("knobs", "words"),
    [
        ('color_map = "nowhere"', ("nowhere", "color_map")),
        ('color_map = "empty"', ("no tile of a picture", "zoom/x/y")),
        ('color_map = "tiles"\ncolor_map_unlit = 1.0', ("color_map_unlit: 1 without a height map", "height_map")),
    ],
)
def test_what_does_not_go_is_said_before_any_gpu_work(tmp_path, knobs, words):
    (tmp_path / "empty").mkdir()
    write_fields(tmp_path / "tiles", 13, *PLACE, 1)
    file = tmp_path / "world.toml"
    file.write_text(WORLD + knobs + "\n")
    with pytest.raises(pf.SettingError) as caught:
        pf.load_scene(file)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.gpu
def test_shaders_are_what_all_drivers_take(folder, tmp_path):
    file = tmp_path / "world.toml"
    file.write_text(f'{WORLD}color_map = "{folder}/tiles"\n')
    code = (
        "import sys, planetfall as pf\n"
        "scene = pf.load_scene(sys.argv[1])\n"
        "camera = pf.Camera.at(46.5, 7.5, 300.0, pitch_deg=-25.0, above='ground', ev100=13.0)\n"
        "with pf.Renderer(scene, size=(48, 27), quality='low') as renderer:\n"
        "    renderer.render(camera, outputs=('color', 'albedo'))\n"
    )
    told = subprocess.run(
        [sys.executable, "-P", "-c", code, str(file)],
        check=False, env={**os.environ, "PLANETFALL_VALIDATE": "1"}, capture_output=True, text=True,
    )  # fmt: skip
    assert told.returncode == 0, told.stderr[-2000:]
