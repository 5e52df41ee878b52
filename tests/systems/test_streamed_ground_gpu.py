"""Tiles of elevation that stream, on the GPU: against the float64 twin once they are there, and in pictures."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from countries import hgt_samples, write_country, write_hgt

import planetfall as pf
from planetfall.engine.blocks.bindings import HEIGHT_MAP_UNIT
from planetfall.engine.frame import View
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import forget_ground, real_ground
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.systems.terrain.height import TerrainParams, height_and_gradient, height_at_points
from planetfall.systems.terrain.height_table import octave_table
from planetfall.systems.terrain.real_stream import RealStream
from planetfall.systems.terrain.real_wanted import Eye

RADIUS_M = 6.371e6
PLAIN = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
HEADER = (
    '#define TERRAIN_SOURCES_CHOSEN\n#define TERRAIN_TILED\n#define TERRAIN_STREAMED\n#include "terrain/height.glsl"'
)
BODY = "TerrainPoint p = terrain_point(d, spacing); dh = p.dh; gradient = p.gradient;"
PIXEL_RAD = 3e-3


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A country of 3 minutes, twenty rough tiles of 6 seconds in it, and a hole in one of them: 40 MB in memory."""
    path = tmp_path_factory.mktemp("country")
    write_country(path / "coarse", 42, 3, 8, 9, 21)
    rng = np.random.default_rng(1)
    for south, west in itertools.product(range(43, 47), range(4, 9)):
        rough = hgt_samples(south, west, 601) + rng.normal(0.0, 12.0, (601, 601))
        rough[[0, -1]] = hgt_samples(south, west, 601)[[0, -1]]  # neighbours share their border
        rough[:, [0, -1]] = hgt_samples(south, west, 601)[:, [0, -1]]
        if (south, west) == (46, 8):
            rough[200:300, 200:300] = -32768
        write_hgt(path / "fine", south, west, 601, np.rint(rough).astype(np.int16))
    return path


def eye_at(up, above_m):
    return Eye(up * (RADIUS_M + 1500.0 + above_m), above_m, PIXEL_RAD, -up, 0.8)


# Within a tile, at the border of two, of four, in the hole, at the outer border, in the country and outside.
PLACES = ((46.5, 7.5), (46.4, 8.0), (45.0, 6.999), (46.6, 8.4), (46.7, 9.0), (47.5, 6.5), (20.0, 60.0))


@pytest.mark.parametrize("detail", [0.0, 1.0])
@pytest.mark.parametrize("place", PLACES)
def test_heights_are_the_twins_once_pages_are_there(run_compute, gpu, folder, place, detail):
    """A millimetre within a kilometre, whatever was looked at before; gradients to 2e-3."""
    real = real_ground(str(folder), 12_000_000, "x", streams=True)
    assert isinstance(real, StreamedGround)
    params = replace(PLAIN, real=real, height_map_detail=detail)
    up, scope, view = directions_at(*place), gpu.scope("test"), View()
    stream = RealStream(scope, real, RADIUS_M)
    stream.update(view, eye_at(directions_at(46.2, 7.2), 500.0), PIXEL_RAD, 0.0, at_once=True)
    stream.update(view, eye_at(up, 300.0), PIXEL_RAD, 0.0, at_once=True)
    assert stream.settled(view)
    rng = np.random.default_rng(2)
    side = np.cross(up, [0.3, 0.5, 0.8])
    side /= np.linalg.norm(side)
    azimuth, angle = rng.uniform(0.0, 2.0 * np.pi, (2, 800, 1))
    angle = 1000.0 * np.sqrt(angle / (2.0 * np.pi)) / RADIUS_M
    across = np.cos(azimuth) * side + np.sin(azimuth) * np.cross(up, side)
    d = (RADIUS_M * (np.sin(angle) * across - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)
    block = scope.buffer(octave_table(params, up).tobytes())

    def bind(_):
        block.bind_to_uniform_block(4)
        stream.texture.use(HEIGHT_MAP_UNIT)

    inputs = {"d": d, "spacing": np.full(len(d), 0.1, np.float32)}
    out = run_compute(BODY, inputs, {"dh": "float", "gradient": "vec3"}, header=HEADER, setup=bind)
    points = up * RADIUS_M + d.astype(np.float64)
    expected = height_at_points(points, params) - height_at_points(up[None] * RADIUS_M, params)[0]
    assert np.abs(out["dh"] - expected).max() < 1e-3
    directions = points / np.linalg.norm(points, axis=1)[:, None]
    _, gradient = height_and_gradient(directions, params, 0.1)
    assert np.quantile(np.linalg.norm(out["gradient"] - gradient, axis=1), 0.99) < 2e-3
    stream.release()
    scope.release()


def test_nothing_jumps_while_pages_come(run_compute, gpu, folder):
    """Along a way over pages of which some are there, some fade in and some are missing, heights go on evenly."""
    real = real_ground(str(folder), 12_000_000, "x", streams=True)
    params = replace(PLAIN, real=real, height_map_detail=0.0)
    up, scope, view = directions_at(46.3, 7.5), gpu.scope("test"), View()
    stream = RealStream(scope, real, RADIUS_M)
    frames = []
    block = scope.buffer(octave_table(params, up).tobytes())

    def bind(_):
        block.bind_to_uniform_block(4)
        stream.texture.use(HEIGHT_MAP_UNIT)

    along = directions_at(np.full(6001, 46.3), np.linspace(7.2, 7.8, 6001)).T
    d = ((along - up) * RADIUS_M).astype(np.float32)
    for _ in range(400):
        stream.update(view, eye_at(up, 300.0), PIXEL_RAD, 1.0 / 30.0, at_once=False)
        if len(frames) < 60 or stream.settled(view):
            inputs = {"d": d, "spacing": np.full(len(d), 0.1, np.float32)}
            out = run_compute(BODY, inputs, {"dh": "float", "gradient": "vec3"}, header=HEADER, setup=bind)
            frames.append(out["dh"].astype(np.float64))
        if stream.settled(view):
            break
    assert stream.settled(view) and len(frames) > 5
    expected = height_at_points(along * RADIUS_M, params) - height_at_points(up[None] * RADIUS_M, params)[0]
    assert np.abs(frames[-1] - expected)[2500:3500].max() < 1e-3
    steepest = np.abs(np.diff(expected)).max()
    for heights in frames:
        assert np.isfinite(heights).all() and np.abs(np.diff(heights)).max() < 1.5 * steepest
    # A fade takes 15 frames: none changes more than a sixth of what the fine tiles differ from the coarse ones.
    change = max(np.abs(after - before).max() for before, after in itertools.pairwise(frames[:-1]))
    assert change < 0.2 * np.abs(frames[-1] - frames[0]).max()
    stream.release()
    scope.release()


def scene_of(folder, most_mb, **knobs):
    scene = pf.load_scene("earth")
    terrain = scene.planet[pf.Terrain]
    terrain.rivers, terrain.height_map_detail, terrain.height_map_most_mb = 0.0, 0.0, most_mb
    for name, value in knobs.items():
        setattr(terrain, name, value)
    terrain.height_map = str(folder)
    return scene


CAMERAS = tuple(
    pf.Camera.at(latitude, longitude, above_m, heading_deg=30.0, pitch_deg=pitch, above="ground", ev100=13.0)
    for latitude, longitude, above_m, pitch in ((46.5, 7.6, 300.0, -15.0), (46.1, 7.9, 6000.0, -35.0))
)


def pictures(scene, cameras):
    with pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
        found = []
        for camera in cameras:
            renderer.settle(camera)
            found.append(renderer.render(camera, outputs=("color", "distance")))
        return found


@pytest.mark.gpu
def test_settled_pictures_are_the_same_whatever_was_seen_before(folder):
    """And show the ground that all tiles in memory do, but for what is narrower than a pixel."""
    whole = pictures(scene_of(folder, 256.0), CAMERAS)
    there, back = (pictures(scene_of(folder, 12.0), cameras) for cameras in (CAMERAS, CAMERAS[::-1]))
    for a, b, c in zip(there, back[::-1], whole, strict=True):
        np.testing.assert_array_equal(a["distance"], b["distance"])
        assert np.abs(a["color"].astype(int) - b["color"]).max() <= 1
        np.testing.assert_array_equal(np.isfinite(a["distance"]), np.isfinite(c["distance"]))
        ground = np.isfinite(c["distance"])
        assert np.quantile(np.abs(a["distance"] / c["distance"] - 1.0)[ground], 0.8) < 2e-2
        assert np.abs(a["color"].astype(float) - c["color"]).mean() < 4.0


@pytest.mark.gpu
def test_a_flight_has_no_hole(folder, tmp_path, monkeypatch):
    """300 m/s, 100 m above ground, in frames that wait for nothing: each shows the ground of the settled picture. No
    page has been read before, by whomever: the way over the hills is known from the files themselves."""
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))
    forget_ground()
    scene, dt_s = scene_of(folder, 12.0), 1.0 / 15.0
    tile = np.fromfile(folder / "fine" / "N46E007.hgt", ">i2").reshape(601, 601)
    longitude = 7.3 + 300.0 * dt_s * np.arange(60) / (111_000.0 * 0.69)
    cameras = []
    for east in longitude:
        i = int((east - 7.0) * 600.0)
        above = float(tile[299:303, i - 1 : i + 3].max()) + 100.0
        cameras.append(pf.Camera.at(46.5, float(east), above, heading_deg=90.0, pitch_deg=-20.0, ev100=13.0))
    shown = {}
    with pf.Renderer(scene, size=(48, 27), quality="low") as renderer:
        for k, camera in enumerate(cameras):
            out = renderer.render(camera, time_s=k * dt_s, outputs=("distance",), dt_s=dt_s)
            if k % 10 == 9:
                shown[k] = out["distance"]
    with pf.Renderer(scene, size=(48, 27), quality="low") as still:
        for k, found in shown.items():
            still.settle(cameras[k])
            settled = still.render(cameras[k], outputs=("distance",))["distance"]
            ground = np.isfinite(settled)
            assert ground.mean() > 0.5 and (np.isfinite(found) == ground).mean() > 0.97
            both = ground & np.isfinite(found)
            assert np.quantile(np.abs(found[both] / settled[both] - 1.0), 0.8) < 0.05


@pytest.mark.gpu
def test_what_fits_is_in_memory_and_other_backends_read_it_coarser(folder):
    scene = scene_of(folder, 256.0)
    for most_mb, backend, streams in ((256.0, "grid", False), (12.0, "grid", True), (12.0, "quadtree", False)):
        terrain = scene.planet[pf.Terrain]
        terrain.height_map_most_mb, terrain.backend = most_mb, backend
        params = TerrainParams.from_component(terrain, RADIUS_M)
        assert isinstance(params.real, StreamedGround) == streams
