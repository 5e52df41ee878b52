"""Height maps: values, poles, date line, edges of the cube, slopes, the GPU's twin; and what is wrong with a file."""

from __future__ import annotations

import logging

import numpy as np
import pytest
from PIL import Image
from test_height_gpu import anchors, evaluate, offsets  # noqa: F401 - evaluate is a fixture

import planetfall as pf
from planetfall.engine.surface import cube_map
from planetfall.engine.surface.cube_map import FACES, face_directions
from planetfall.systems.terrain.height import (
    TerrainField,
    TerrainParams,
    height_and_gradient,
    height_at_points,
)
from planetfall.systems.terrain.height_map import height_map

RADIUS_M = 3.0e6
RANGE_M = (-8000.0, 12000.0)


def wanted(d):
    """A smooth field of some kilometres, for directions (..., 3): known everywhere without a map."""
    x, y, z = np.moveaxis(d / np.linalg.norm(d, axis=-1)[..., None], -1, 0)
    return 3000.0 * x * y + 2500.0 * z * z * x - 2000.0 * y + 1500.0 * np.sin(4.0 * x + 3.0 * z) + 1000.0


def words(heights):
    return np.rint((heights - RANGE_M[0]) / (RANGE_M[1] - RANGE_M[0]) * 65535.0).astype(np.uint16)


def plate(width, height):
    """Directions (height, width, 3) of the pixels of an equirectangular map."""
    longitude = ((np.arange(width) + 0.5) / width * 2.0 - 1.0) * np.pi
    latitude = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    longitude, latitude = np.meshgrid(longitude, latitude)
    return np.stack(
        [np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], axis=-1
    )


@pytest.fixture(scope="module")
def png(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "heights.png"
    Image.fromarray(words(wanted(plate(512, 256)))).save(path)
    return path


@pytest.fixture(scope="module")
def rough_png(tmp_path_factory):
    """The same with relief of its own down to the pixels, so that there is something to go on with."""
    path = tmp_path_factory.mktemp("maps") / "rough.png"
    noise = np.random.default_rng(3).normal(size=(256, 512)) * 150.0
    Image.fromarray(words(wanted(plate(512, 256)) + noise)).save(path)
    return path


def params_of(path, **changes):
    found = height_map(str(path), RANGE_M)
    return TerrainParams(RADIUS_M, 3, 1.0, -1.0, 16, height_map=found, **{"height_map_detail": 0.0, **changes})


def sphere(count, seed=0):
    d = np.random.default_rng(seed).normal(size=(count, 3))
    return d / np.linalg.norm(d, axis=1)[:, None]


def test_heights_are_the_maps(png):
    """A step of 16 bits is 0.3 m; pixels are 37 km wide, and the cubic misses a field that bends over 1000 km by
    (pixel / length)^4 of its height at the most: centimetres, twice (the map, and the cube made of it)."""
    d = sphere(5000)
    error = np.abs(TerrainField(params_of(png)).height(d) - wanted(d))
    assert error.max() < 1.0 and np.median(error) < 0.3


def test_neither_pole_nor_date_line_nor_edge_shows(png):
    """Small circles around poles, walks across the date line and across edges and corners of the cube: the difference
    from the field itself stays what it is elsewhere, and nothing jumps."""
    field = TerrainField(params_of(png))
    turn = np.linspace(0.0, 2.0 * np.pi, 721)
    walks = []
    for z in (1.0, -1.0):
        for angle in (1e-6, 1e-3, 0.02):
            walks.append(np.stack([angle * np.cos(turn), angle * np.sin(turn), np.full_like(turn, z)], axis=1))
    step = np.linspace(-0.02, 0.02, 721)
    walks.append(np.stack([-np.ones_like(step), step, np.full_like(step, 0.3)], axis=1))  # the date line
    walks.append(np.stack([np.ones_like(step), 1.0 + step, np.full_like(step, 0.4)], axis=1))  # an edge
    walks.append(np.stack([1.0 + step, np.ones_like(step), 1.0 - 0.5 * step], axis=1))  # a corner
    walks.append(np.stack([np.full_like(step, 0.2), 1.0 + step, -np.ones_like(step)], axis=1))
    for walk in walks:
        d = walk / np.linalg.norm(walk, axis=1)[:, None]
        error = field.height(d) - wanted(d)
        assert np.abs(error).max() < 1.0
        length = np.linalg.norm(np.diff(d, axis=0), axis=1) * RADIUS_M
        assert np.abs(np.diff(error)).max() < 1e-4 * length.max() + 1e-6  # 1 m in a quarter of a pixel


def test_both_faces_have_the_same_heights_on_an_edge(rough_png):
    """From both sides, to the last bit that a float32 sample has: nothing is averaged away."""
    cube = height_map(str(rough_png), RANGE_M).cube
    inner = cube.levels[0][:, 1:-1, 1:-1]
    np.testing.assert_array_equal(inner[0][:, -1], inner[1][:, 0])  # +X and +Y
    np.testing.assert_array_equal(inner[0][-1], inner[4][0])  # +X and north
    np.testing.assert_array_equal(inner[0][0], inner[5][-1])  # +X and south


def test_slopes_are_those_of_the_heights(rough_png):
    params = params_of(rough_png, height_map_detail=1.0, height_map_blend=0.5, craters=0.3)
    d = sphere(2000, 2)
    t = np.cross(d, np.roll(d, 1, axis=1) + 0.1)
    t /= np.linalg.norm(t, axis=1)[:, None]
    points, step = d * RADIUS_M, 1e-2
    slope = (height_at_points(points + step * t, params) - height_at_points(points - step * t, params)) / (2.0 * step)
    _, gradient = height_and_gradient(d, params)
    assert np.quantile(np.abs((gradient * t).sum(axis=1) - slope), 0.95) < 2e-4


def test_weights_are_the_twins(run_compute):
    """Products and sums below 8, at most eight roundings of half a unit in their last place."""
    f = np.linspace(0.0, 1.0, 101, dtype=np.float32)
    body = "weights = terrain_map_weights(f); slopes = terrain_map_weight_slopes(f);"
    outputs = {"weights": "vec4", "slopes": "vec4"}
    out = run_compute(body, {"f": f}, outputs, header='#include "terrain/height.glsl"')
    exact = f.astype(np.float64)
    assert np.abs(out["weights"] - cube_map.face_weights(exact).T).max() <= 8 * 2.0**-22
    assert np.abs(out["slopes"] - cube_map.face_weight_slopes(exact).T).max() <= 8 * 2.0**-22


@pytest.mark.parametrize("changes", [{}, {"height_map_detail": 1.0, "height_map_blend": 1.0, "craters": 0.5}])
def test_heights_on_the_gpu(evaluate, gpu, rough_png, changes):  # noqa: F811
    params = params_of(rough_png, **changes)
    picture = params.height_map.cube.atlas()
    texture = gpu.ctx.texture(picture.shape[1::-1], 2, picture.tobytes(), dtype="f4")
    texture.use(15)
    near, far = [], []
    for i, up in enumerate([*anchors(3), np.array([1.0, 1.0, 0.3]) / np.linalg.norm([1.0, 1.0, 0.3])]):
        base = height_at_points(up[None] * RADIUS_M, params)[0]
        rng = np.random.default_rng(i)
        for distances, errors in (
            (1000.0 * np.sqrt(rng.random(300)), near),
            (10.0 ** rng.uniform(3.0, 6.8, 300), far),
        ):
            d = offsets(up, RADIUS_M, distances, i)
            expected = height_at_points(up * RADIUS_M + d.astype(np.float64), params) - base
            errors.append(np.abs(evaluate(params, up, d, 1e-3)["dh"] - expected))
            # A float offset of 1000 km is good to decimetres: slopes of metres of relief there are not comparable.
            for spacing in (1e-3, 6e4) if errors is near else (6e4,):
                directions = up * RADIUS_M + d.astype(np.float64)
                directions /= np.linalg.norm(directions, axis=1)[:, None]
                _, gradient = height_and_gradient(directions, params, spacing)
                found = evaluate(params, up, d, spacing)["gradient"]
                assert np.quantile(np.linalg.norm(found - gradient, axis=1), 0.99) < 2e-3
    texture.release()
    assert np.max(near) <= 1e-3
    assert np.quantile(far, 0.99) <= 1e-6 * 20000.0 and np.max(far) < 0.2


def test_relief_goes_on_below_the_map(rough_png):
    """Height differences over distances shorter than a pixel (37 km), with and without detail; and they grow with rough
    maps only."""

    def rms(params, distance):
        field, d = TerrainField(params), sphere(3000, 7)
        t = np.cross(d, [0.3, 0.5, 0.81])
        e = d + distance / RADIUS_M * t / np.linalg.norm(t, axis=1)[:, None]
        return np.std(field.height(e / np.linalg.norm(e, axis=1)[:, None]) - field.height(d))

    bare, fine = (params_of(rough_png, height_map_detail=k) for k in (0.0, 1.0))
    assert rms(fine, 500.0) > 4.0 * rms(bare, 500.0)
    # 150 m from pixel to pixel; ground whose differences grow as distance^0.55..0.85 has 150 (1/74)^H m over 500 m.
    assert 150.0 * 2.0**0.5 / 74.0**0.95 < rms(fine, 500.0) < 150.0 * 2.0**0.5 / 74.0**0.45


def test_six_faces_are_the_same_map(tmp_path, png):
    size = 200
    at = (2.0 * np.arange(size) + 1.0 - size) / size
    for k, name in enumerate(FACES):
        d = face_directions(k, *np.broadcast_arrays(at[None, :], at[::-1, None]))  # rows go down in a picture
        Image.fromarray(words(wanted(d))).save(tmp_path / f"relief_{name}.png")
    d = sphere(4000, 3)
    for path in (tmp_path / "relief_{face}.png",):
        assert np.abs(TerrainField(params_of(path)).height(d) - wanted(d)).max() < 1.0
    for name in FACES:
        (tmp_path / f"relief_{name}.png").rename(tmp_path / f"{name}.png")
    assert np.abs(TerrainField(params_of(tmp_path)).height(d) - wanted(d)).max() < 1.0


def test_tiff_and_grid_lines(tmp_path):
    """Metres as they are, floats or whole numbers with a sign; 2 h - 1 columns are registered on grid lines."""
    tifffile = pytest.importorskip("tifffile")
    longitude, latitude = np.meshgrid(np.linspace(-np.pi, np.pi, 361), np.linspace(np.pi / 2, -np.pi / 2, 181))
    d = np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)], -1)
    for kind in (np.float32, np.int16):
        path = tmp_path / f"{np.dtype(kind)}.tif"
        tifffile.imwrite(path, np.rint(wanted(d)).astype(kind))
        params = TerrainParams(RADIUS_M, 3, height_map=height_map(str(path), None), height_map_detail=0.0)
        assert np.abs(TerrainField(params).height(sphere(3000)) - wanted(sphere(3000))).max() < 2.0


def test_exr(tmp_path):
    exr = pytest.importorskip("OpenEXR")
    path = tmp_path / "heights.exr"
    pixels = wanted(plate(256, 128)).astype(np.float32)
    exr.File({"compression": exr.ZIP_COMPRESSION, "type": exr.scanlineimage}, {"Y": pixels}).write(str(path))
    params = TerrainParams(RADIUS_M, 3, height_map=height_map(str(path), None), height_map_detail=0.0)
    assert np.abs(TerrainField(params).height(sphere(3000)) - wanted(sphere(3000))).max() < 2.0


def _scene(tmp_path, **terrain):
    lines = [f"{k} = {v!r}" if not isinstance(v, tuple) else f"{k} = {list(v)}" for k, v in terrain.items()]
    file = tmp_path / "world.toml"
    file.write_text(f"[planet]\nradius_m = {RADIUS_M}\n[terrain]\n" + "\n".join(lines) + "\n")
    return file


def test_paths_count_from_the_scenes_folder(tmp_path, png):
    (tmp_path / "maps").mkdir()
    (tmp_path / "maps" / "h.png").write_bytes(png.read_bytes())
    scene = pf.load_scene(_scene(tmp_path, height_map="maps/h.png", height_map_range_m=RANGE_M))
    assert scene.planet[pf.Terrain].height_map == str(tmp_path / "maps" / "h.png")
    d = sphere(200)
    found = pf.TerrainSampler(scene).height(d)
    assert np.abs(found - wanted(d)).max() < 1000.0, "the map, and relief below its pixels"


def bad_files(folder, png):
    """What is wrong -> (the setting's value, range, words of the message)."""

    def save(name, array):
        Image.fromarray(array).save(folder / name)
        return str(folder / name)

    cut = folder / "cut.png"
    cut.write_bytes(png.read_bytes()[:4000])
    text = folder / "text.png"
    text.write_text("no picture")
    faces = folder / "faces"
    faces.mkdir(exist_ok=True)
    for name in FACES[:4]:
        Image.fromarray(np.zeros((8, 8), np.uint16)).save(faces / f"{name}.png")
    flat = np.zeros((64, 128), np.uint16)
    return {
        "missing": (str(folder / "none.png"), RANGE_M, ("none.png", "no file")),
        "truncated": (str(cut), RANGE_M, ("cut.png", "can't be read")),
        "no picture": (str(text), RANGE_M, ("text.png", "can't be read")),
        "ending": (save("h.bmp", np.zeros((64, 128), np.uint8)), RANGE_M, ("h.bmp", "ending")),
        "aspect": (save("a.png", np.zeros((64, 100), np.uint16)), RANGE_M, ("100 x 64", "twice as wide")),
        "colours": (save("c.png", np.zeros((64, 128, 3), np.uint8)), RANGE_M, ("3 channels", "color_map")),
        "no range": (save("n.png", flat), None, ("height_map_range_m", "65535")),
        "range backwards": (save("b.png", flat), (100.0, -100.0), ("height_map_range_m", "swap")),
        "too high": (save("r.png", flat + 65535), (0.0, 9e5), ("quarter", "3e+06")),
        "faces missing": (str(faces), RANGE_M, ("pz", "missing")),
    }  # fmt: skip


@pytest.mark.parametrize("what", sorted([
    "missing", "truncated", "no picture", "ending", "aspect", "colours", "no range", "range backwards", "too high",
    "faces missing",
]))  # fmt: skip
def test_bad_files_say_what_where_and_what_to_do(tmp_path, png, what):
    path, range_m, words_of = bad_files(tmp_path, png)[what]
    file = _scene(tmp_path, height_map=path, **({"height_map_range_m": range_m} if range_m else {}))
    with pytest.raises(pf.SettingError) as caught:
        pf.load_scene(file)
    for word in ("Terrain.height_map", *words_of):
        assert word in str(caught.value), str(caught.value)


def test_no_numbers_are_refused(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    heights = wanted(plate(64, 32)).astype(np.float32)
    heights[5, 7] = np.nan
    tifffile.imwrite(tmp_path / "nan.tif", heights)
    with pytest.raises(pf.SettingError, match=r"1 values that are no finite numbers, the first at column 7, row 5"):
        height_map(str(tmp_path / "nan.tif"), None)


@pytest.mark.parametrize(("step_deg", "whole"), [(360.0 / 64.0, True), (1.0 / 64.0, False)])
def test_a_geotiff_of_a_region_is_not_stretched_over_the_planet(tmp_path, step_deg, whole):
    tifffile = pytest.importorskip("tifffile")
    tags = [
        (33550, "d", 3, (step_deg, step_deg, 0.0), True),
        (33922, "d", 6, (0.0, 0.0, 0.0, -180.0, 90.0, 0.0), True),
        (34735, "H", 12, (1, 1, 0, 2, 1024, 0, 1, 2, 1025, 0, 1, 1), True),
    ]
    heights = wanted(plate(64, 32)).astype(np.float32)
    tifffile.imwrite(tmp_path / "n.tif", heights, extratags=tags, metadata=None)
    if whole:
        assert height_map(str(tmp_path / "n.tif"), None) is not None
        return
    with pytest.raises(pf.SettingError, match=r"n\.tif is 1 degrees of longitude wide; expected 360.*name the folder"):
        height_map(str(tmp_path / "n.tif"), None)


def test_eight_bits_are_warned_of(tmp_path, caplog):
    Image.fromarray(np.zeros((32, 64), np.uint8)).save(tmp_path / "eight.png")
    with caplog.at_level(logging.WARNING):
        height_map(str(tmp_path / "eight.png"), RANGE_M)
    assert "8 bits" in caplog.text and "78.4 m" in caplog.text


def test_a_broken_map_leaves_the_last_good_ground(tmp_path, png):
    scene = pf.load_scene(_scene(tmp_path, height_map=str(png), height_map_range_m=RANGE_M, color_map=""))
    camera = pf.Camera.at(10.0, 20.0, 20000.0, pitch_deg=-30.0)
    with pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
        renderer.settle(camera)
        before = renderer.render(camera)["color"]
        for name in ("height_map", "color_map"):
            good = getattr(scene.planet[pf.Terrain], name)
            setattr(scene.planet[pf.Terrain], name, str(tmp_path / "gone.png"))
            with pytest.raises(pf.SettingError, match=r"gone\.png"):
                renderer.render(camera)
            for _ in range(2):
                after = renderer.render(camera)["color"]
            np.testing.assert_array_equal(after, before)
            setattr(scene.planet[pf.Terrain], name, good)
            np.testing.assert_array_equal(renderer.render(camera)["color"], before)


def test_a_colour_map_is_seen_where_it_says(tmp_path):
    """Red east, blue west; the border is where it belongs, from orbit."""
    picture = np.zeros((64, 128, 3), np.uint8)
    picture[:, :64], picture[:, 64:] = (40, 60, 180), (180, 60, 40)
    Image.fromarray(picture).save(tmp_path / "colors.png")
    scene = pf.load_scene(_scene(tmp_path, color_map=str(tmp_path / "colors.png"), highest_m=10.0, lowest_m=-10.0))
    scene.sun = pf.Sun(elevation_deg=80.0, azimuth_deg=0.0, latitude_deg=0.0, longitude_deg=0.0)
    camera = pf.Camera.at(0.0, 0.0, 6e6, pitch_deg=-90.0)
    with pf.Renderer(scene, size=(64, 48), quality="low") as renderer:
        renderer.settle(camera)
        color = renderer.render(camera)["color"].astype(float)
    left, right = color[24, 24], color[24, 40]
    assert left[2] > 1.5 * left[0] and right[0] > 1.5 * right[2]
    assert np.abs(color[24, 28:36, 0] - color[24, 28:36, 2]).min() < 60.0, "they meet in the middle"
