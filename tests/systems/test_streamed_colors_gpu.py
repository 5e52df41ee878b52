"""Tiles of pictures that stream, on the GPU: against the float64 twin once they are there, and in pictures."""

from __future__ import annotations

import itertools
import time

import numpy as np
import pytest
from countries import fields, tile_at, tile_places, write_hgt, write_picture

import planetfall as pf
from planetfall.engine.blocks.bindings import COLOR_MAP_UNIT
from planetfall.engine.frame import View
from planetfall.engine.real_ground.color_reading import real_colors
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.streamed_colors import StreamedColors
from planetfall.engine.wavelengths import DISPLAY_NM
from planetfall.systems.terrain.color_stream import ColorStream
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.height_table import octave_table
from planetfall.systems.terrain.real_colors import ground_colors, pictured_width_bits, relief_of
from planetfall.systems.terrain.real_wanted import Eye

RADIUS_M = 6.371e6
WORLD = "[planet]\nradius_m = 6.371e6\n[terrain]\nlayers = 6\nclutter = 0.0\nrivers = 0.0\n"
CHOSEN = "#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_PICTURED\n#define TERRAIN_PICTURES_STREAMED\n"
HEADER = f'{CHOSEN}#include "terrain/height.glsl"\n#include "terrain/real_colors.glsl"'
BODY = "ColorsSeen seen = terrain_colors(d, footprint); albedo = seen.albedo; weight = seen.weight;"
OUTPUTS = {"albedo": "vec3", "weight": "float"}
ZOOM, PLACE, ACROSS = 13, (46.5, 7.5), 8
FEW = 8_000_000
PIXEL_RAD = 1e-2


def redder(pixels, seed):
    """All of it red, with noise."""
    noise = np.random.default_rng(seed).integers(-20, 20, pixels.shape)
    return np.clip(pixels * [0.6, 0.3, 0.3] + [90, 0, 0] + noise, 0, 255).astype(np.uint8)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """64 tiles of 13 m, 22 MB in memory."""
    path = tmp_path_factory.mktemp("pictures")
    x, y = tile_at(ZOOM, *PLACE)
    for j, i in itertools.product(range(-ACROSS // 2, ACROSS // 2), repeat=2):
        write_picture(
            path / "tiles", ZOOM, x + i, y + j, redder(fields(*tile_places(ZOOM, x + i, y + j)), 100 + 9 * j + i)
        )
    return path


def streamed(folder, most=FEW):
    found = real_colors(str(folder / "tiles"), DISPLAY_NM, most, "x", streams=True)
    assert isinstance(found, StreamedColors)
    return found


def eye_at(up, above_m):
    return Eye(up * (RADIUS_M + above_m), above_m, PIXEL_RAD, -up, 0.8)


class Shown:
    """Colours that a stream shows about a place."""

    def __init__(self, gpu, run_compute, colors, place):
        self.up = directions_at(*place)
        self._scope, self._run = gpu.scope("test"), run_compute
        self.stream = ColorStream(self._scope, colors, RADIUS_M, 100.0)
        table = octave_table(TerrainParams(pictured=True, layers=2), self.up)
        table["color"] = (0, pictured_width_bits(colors), 1.0)
        self._block = self._scope.buffer(table.tobytes())

    def __call__(self, d, footprint_rad):
        def bind(_):
            self._block.bind_to_uniform_block(4)
            self.stream.texture.use(COLOR_MAP_UNIT)

        inputs = {"d": d, "footprint": np.full(len(d), footprint_rad, np.float32)}
        out = self._run(BODY, inputs, OUTPUTS, header=HEADER, setup=bind)
        return np.concatenate([out["albedo"], out["weight"][:, None]], axis=1).astype(np.float64)

    def release(self):
        self.stream.release()
        self._scope.release()


@pytest.mark.parametrize("place", [(46.5, 7.5), (46.55, 7.61), (46.5, 7.66), (46.7, 7.9)])
def test_colours_are_the_twins_once_pages_are_there(run_compute, gpu, folder, place):
    """2e-3 of albedo within 700 m, whatever was looked at before; the texture keeps to its budget."""
    colors = streamed(folder)
    shown, view = Shown(gpu, run_compute, colors, place), View()
    width, height = shown.stream.texture.size
    assert 4 * width * height <= FEW
    for at in ((46.42, 7.4), place):
        shown.stream.update(view, eye_at(directions_at(*at), 300.0), PIXEL_RAD, 0.0, at_once=True)
    assert shown.stream.settled(view) and shown.stream.taken > 20
    rng = np.random.default_rng(2)
    side = np.cross(shown.up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth, angle = rng.uniform(0.0, 2.0 * np.pi, (800, 1)), 700.0 * np.sqrt(rng.random((800, 1))) / RADIUS_M
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(shown.up, side)
    d = (RADIUS_M * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * shown.up)).astype(np.float32)
    points = (shown.up * RADIUS_M + d.astype(np.float64)).T
    for footprint_rad in (1e-9, 3e-6, 1e-5):
        values, weight = colors.sample(points, np.full(len(d), footprint_rad))
        assert np.abs(shown(d, footprint_rad) - np.column_stack([values.T, weight])).max() < 2e-3
    shown.release()


def test_nothing_jumps_while_pages_come(run_compute, gpu, folder):
    """Along a way over pages of which some are there, some fade in and some are missing, colours go on evenly, and
    there is no hole."""
    colors = streamed(folder)
    shown, view, frames = Shown(gpu, run_compute, colors, PLACE), View(), []
    along = directions_at(np.full(4001, PLACE[0]), np.linspace(7.4, 7.6, 4001)).T
    d = ((along - shown.up) * RADIUS_M).astype(np.float32)
    for _ in range(3000):
        time.sleep(0.01)  # on a busy machine pages take their time
        shown.stream.update(view, eye_at(shown.up, 300.0), PIXEL_RAD, 1.0 / 30.0, at_once=False)
        if len(frames) < 40 or shown.stream.settled(view):
            frames.append(shown(d, 1e-6))
        if shown.stream.settled(view):
            break
    assert shown.stream.settled(view) and len(frames) > 5
    values, weight = colors.sample(along.T * RADIUS_M, np.full(len(d), 1e-6))
    exact = np.column_stack([values.T, weight])
    assert np.abs(frames[-1] - exact)[1500:2500].max() < 2e-3
    steepest = np.abs(np.diff(exact, axis=0)).max()
    for seen in frames:
        assert seen[:, 3].min() == 1.0 and np.abs(np.diff(seen, axis=0)).max() < 1.3 * steepest
    change = max(np.abs(after - before).max() for before, after in itertools.pairwise(frames[:-1]))
    assert 0.0 < change < 0.35 * np.abs(frames[-1] - frames[0]).max()
    shown.release()


def scene_of(folder, most_mb, **knobs):
    file = folder / "world.toml"
    file.write_text(WORLD)
    scene = pf.load_scene(file)
    for name, value in {"color_map_most_mb": most_mb, "color_map": str(folder / "tiles"), **knobs}.items():
        setattr(scene.planet[pf.Terrain], name, value)
    return scene


CAMERAS = tuple(
    pf.Camera.at(latitude, longitude, above_m, heading_deg=30.0, pitch_deg=pitch, above="ground", ev100=13.0)
    for latitude, longitude, above_m, pitch in ((46.5, 7.5, 300.0, -15.0), (46.46, 7.55, 6000.0, -50.0))
)


def pictures(scene, cameras):
    with pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
        found = []
        for camera in cameras:
            renderer.settle(camera)
            found.append(renderer.render(camera, outputs=("albedo", "distance"))["albedo"])
        return found


@pytest.mark.gpu
@pytest.mark.parametrize("backend", ["grid", "quadtree", "icosphere"])
def test_settled_pictures_are_those_of_all_tiles_in_memory(folder, backend):
    """Whatever was seen before, to half a step of 8 bits."""
    all_of_it = pictures(scene_of(folder, 256.0, backend=backend), CAMERAS)
    there, back = (pictures(scene_of(folder, 12.0, backend=backend), c) for c in (CAMERAS, CAMERAS[::-1]))
    for a, b, c in zip(there, back[::-1], all_of_it, strict=True):
        assert np.abs(a - b).max() < 2e-3 and np.abs(a - c).max() < 2e-3
        assert np.nanstd(c) > 0.02


@pytest.mark.gpu
def test_a_flight_has_no_hole(folder):
    """300 m/s, 100 m above ground, in a budget too small: each frame shows the pictures, never the materials."""
    scene = scene_of(folder, 3.0)
    whole = scene_of(folder, 256.0)
    dt_s, size = 1.0 / 15.0, (48, 27)
    with pf.Renderer(scene, size=size, quality="low") as renderer, pf.Renderer(whole, size=size, quality="low") as all_:
        for k in range(40):
            camera = pf.Camera.at(46.5, 7.45 + k * 300.0 * dt_s / (111_000.0 * 0.69), 100.0, heading_deg=90.0,
                                  pitch_deg=-30.0, above="ground", ev100=13.0)  # fmt: skip
            out = renderer.render(camera, time_s=k * dt_s, outputs=("albedo", "distance"), dt_s=dt_s)
            near = np.isfinite(out["distance"]) & (out["distance"] < 3000.0)
            red, green = out["albedo"][near][:, 0], out["albedo"][near][:, 1]
            assert near.sum() > 600 and (red > 1.4 * green).all()
            if k % 10 == 9:
                seen = all_.render(camera, time_s=k * dt_s, outputs=("albedo",), dt_s=dt_s)["albedo"]
                assert np.abs(seen - out["albedo"])[near].mean() < 0.03


@pytest.mark.gpu
def test_the_sun_goes_out_page_by_page(tmp_path, monkeypatch):
    """By heights that are in memory or stream themselves, as out of all tiles in memory; kept for the next start."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    rng = np.random.default_rng(5)
    longitude, latitude = np.meshgrid(np.linspace(7.0, 8.0, 601), np.linspace(47.0, 46.0, 601))
    heights = 1000.0 + 90.0 * np.sin(300.0 * latitude) * np.sin(260.0 * longitude) + rng.normal(0.0, 2.0, (601, 601))
    write_hgt(tmp_path / "heights", 46, 7, 601, np.rint(heights).astype(np.int16))
    x, y = tile_at(ZOOM, *PLACE)
    for dx, dy in itertools.product(range(4), range(4)):
        at = x + dx, y + dy
        south, east = tile_places(ZOOM, *at)
        light = 0.7 + 0.3 * (np.sin(300.0 * south) * np.cos(260.0 * east))[..., None]  # from the west
        write_picture(tmp_path / "tiles", ZOOM, *at, (fields(*tile_places(ZOOM, *at)) * light).astype(np.uint8))
    knobs = {"height_map": str(tmp_path / "heights"), "color_map_unlit": 1.0, "height_map_detail": 0.0}
    points = directions_at(46.47 - 0.07 * rng.random(300), 7.51 + 0.1 * rng.random(300))
    found = []
    for height_mb, color_mb in ((256.0, 256.0), (256.0, 2.0), (1.0, 2.0)):
        terrain = scene_of(tmp_path, color_mb, height_map_most_mb=height_mb, **knobs).planet[pf.Terrain]
        params = TerrainParams.from_component(terrain, RADIUS_M)
        assert relief_of(params).files is not None
        colors = ground_colors(terrain, params, DISPLAY_NM)
        assert isinstance(colors, StreamedColors) == (color_mb < 256.0)
        assert colors.sets[0].sun_deg is not None
        found.append(colors.sample(points, np.full(300, 1e-9))[0])
    np.testing.assert_array_equal(found[1], found[0])
    np.testing.assert_array_equal(found[2], found[0])
    assert len(list((tmp_path / "cache" / "real_ground").glob("*.index.npz"))) >= 2
    plain = real_colors(str(tmp_path / "tiles"), DISPLAY_NM, 256_000_000, "x").sample(points, np.full(300, 1e-9))[0]
    assert np.abs(plain - found[0]).max() > 0.01
