"""Long sweeps over tiles of elevation made up at random: sets of many resolutions over one another, single pixels,
holes, tiles by poles and at the date line. Heights, rays and contacts in float64, in memory and streamed."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from countries import land, write_country, write_hgt, write_png_tile
from numpy.typing import NDArray

import planetfall as pf
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import real_ground
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.systems.terrain.height import TerrainField, TerrainParams

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1800)]
RADIUS_M = 6.371e6
PLAIN = TerrainParams(mountains=0.4, roughness=1.35, hills=0.2)
SEEDS = range(8)
VOID = -32768
Floats = NDArray[np.float64]


def write_pixels(file: Path, values: Floats, west: float, north: float, step: float) -> None:
    """A GeoTIFF in degrees; west, north: of its corner."""
    import tifffile

    keys = (1, 1, 0, 3, 1024, 0, 1, 2, 1025, 0, 1, 1, 2048, 0, 1, 4326)
    tags = [(33550, "d", 3, (step, step, 0.0), True), (33922, "d", 6, (0.0, 0.0, 0.0, west, north, 0.0), True),
            (34735, "H", len(keys), keys, True)]  # fmt: skip
    file.parent.mkdir(parents=True, exist_ok=True)
    tifffile.imwrite(file, values.astype(np.float32), extratags=tags)


@dataclass
class Made:
    """A country of tiles: its folder, its boxes (south, west, north, east), and samples known in closed form: where
    they are (latitudes, longitudes), and their heights."""

    folder: Path
    boxes: list[tuple[float, float, float, float]]
    samples: list[tuple[Floats, Floats, Floats]]


def holes(rng: np.random.Generator, values: NDArray[np.int16]) -> None:
    """Single voids, and wide ones."""
    side = len(values)
    values[rng.random(values.shape) < rng.choice([0.0, 0.01, 0.2])] = VOID
    for _ in range(rng.integers(0, 3)):
        j, i = rng.integers(0, side, 2)
        values[j : j + rng.integers(1, side), i : i + rng.integers(1, side)] = VOID


def made(folder: Path, seed: int) -> Made:
    rng = np.random.default_rng(seed)
    found = Made(folder, [], [])
    if seed % 3 == 0:  # all of the planet, with its poles
        step = float(rng.choice([1.0, 2.0, 4.0]))
        v, u = np.arange(0.5 * step, 180.0, step), np.arange(0.5 * step, 360.0, step)
        write_pixels(folder / "all.tif", land((90.0 - v)[:, None], u - 180.0), -180.0, 90.0, step)
        found.boxes += [(84.0, -180.0, 90.0, 180.0), (-90.0, -180.0, -84.0, 180.0)]
    if seed % 3 == 1:  # about the poles
        for south in (89, -90):
            for west in range(-180, 180, 1 if seed % 2 else 2):
                write_hgt(folder, south, west, 5)
        found.boxes += [(89.0, -180.0, 90.0, 180.0), (-90.0, -180.0, -89.0, 180.0)]
    # All sets together have room for 24 levels.
    coarse, sides = int(rng.choice([5, 11, 21])), rng.choice([31, 101, 401], 2, replace=False)
    for south, west in ((int(rng.integers(-60, 60)), 179), (46, 7), (int(rng.integers(-80, 80)), -3)):
        write_country(folder / "coarse", south - 1, west - 1, 3, 3, coarse)
        found.boxes.append((south - 1.2, west - 1.2, south + 2.2, west + 2.2))
        for dj, di in itertools.product(range(2), range(2)):
            side = int(rng.choice(sides))
            at = south + dj, (west + di + 180) % 360 - 180
            step = np.arange(side) / (side - 1)
            latitude, longitude = np.meshgrid(at[0] + 1.0 - step, at[1] + step, indexing="ij")
            rough = land(latitude, longitude) + rng.normal(0.0, rng.choice([0.0, 5.0, 60.0]), (side, side))
            values = np.rint(rough).astype(np.int16)
            holes(rng, values)
            if dj == di == 0:
                values[side // 2, side // 2] = 9000  # a spike among all that
                inside = values[1:-1, 1:-1]
                there = inside != VOID
                found.samples.append(
                    (latitude[1:-1, 1:-1][there], longitude[1:-1, 1:-1][there], inside[there].astype(float))
                )
            write_hgt(folder / f"fine{side}", *at, side, values)
            found.boxes.append((at[0] - 0.1, at[1] - 0.1, at[0] + 1.1, at[1] + 1.1))
    x, y = 133 * 64 + int(rng.integers(0, 40)), 90 * 64 + int(rng.integers(0, 40))
    for dx, dy in itertools.product(range(2), range(2)):
        write_png_tile(folder / "pictured", 14, x + dx, y + dy, int(rng.choice([64, 64, 1])))
    south, west = np.degrees(np.arctan(np.sinh(np.pi * (1.0 - (y + 2.0) / 8192.0)))), x / 16384.0 * 360.0 - 180.0
    found.boxes.append((south - 0.01, west - 0.01, south + 0.06, west + 0.06))
    step = float(rng.choice([0.01, 0.37]))
    for number in range(3):  # of one pixel
        place = rng.uniform(-80.0, 80.0), rng.choice([rng.uniform(-180.0, 179.0), 179.99])
        place = tuple(float(np.rint(v / step) * step) for v in place)  # all of one set
        write_pixels(folder / f"one{number}.tif", np.full((1, 1), 777.0), place[1], place[0], step)
        found.samples.append((np.array([place[0] - 0.5 * step]), np.array([place[1] + 0.5 * step]), np.array([777.0])))
        found.boxes.append((place[0] - 20.0 * step, place[1] - 20.0 * step, place[0] + 20.0 * step,
                            place[1] + 20.0 * step))  # fmt: skip
    return found


def places(country: Made, rng: np.random.Generator, count: int) -> Floats:
    """Directions (N, 3): in and around boxes, next to their borders, to poles and to the date line, and anywhere."""
    latitude, longitude = [], []
    for south, west, north, east in country.boxes:
        latitude.append(rng.uniform(south, north, count))
        longitude.append(rng.uniform(west, east, count))
        near = 10.0 ** rng.uniform(-10.0, -1.0, (2, count)) * rng.choice([-1.0, 1.0], (2, count))
        latitude.append(np.rint(rng.uniform(south, north, count)) + near[0])
        longitude.append(rng.uniform(west, east, count))
        latitude.append(rng.uniform(south, north, count))
        longitude.append(np.rint(rng.uniform(west, east, count)) + near[1])
    pole = 90.0 - 10.0 ** rng.uniform(-12.0, 0.5, count)
    latitude += [pole, -pole, np.array([90.0, -90.0])]
    longitude += [rng.uniform(-180.0, 180.0, count), rng.uniform(-180.0, 180.0, count), np.zeros(2)]
    everywhere = rng.normal(size=(3, count))
    found = directions_at(np.clip(np.concatenate(latitude), -90.0, 90.0), np.concatenate(longitude))
    found = np.concatenate([found, everywhere / np.linalg.norm(everywhere, axis=0)], axis=1)
    return np.ascontiguousarray(found.T)


def sideways(up: Floats, rng: np.random.Generator) -> Floats:
    side = rng.normal(size=up.shape)
    side -= up * (side * up).sum(axis=1)[:, None]
    return side / np.linalg.norm(side, axis=1)[:, None]


@pytest.fixture(scope="module", params=[(seed, detail) for seed in SEEDS for detail in (0.0, 1.0)],
                ids=lambda p: f"{p[0]}-{'detail' if p[1] else 'bare'}")  # fmt: skip
def case(request, tmp_path_factory):
    pytest.importorskip("tifffile")
    seed, detail = request.param
    country = made(tmp_path_factory.mktemp("country"), seed)
    real = real_ground(str(country.folder), 256_000_000, "x")
    params = replace(PLAIN, real=real, height_map_detail=detail)
    return country, params, np.random.default_rng(1000 + seed)


def test_heights_are_finite_bounded_and_continuous(case):
    country, params, rng = case
    ground, field = pf.TerrainSampler.from_params(params), TerrainField(params)
    up = places(country, rng, 300)
    here, bound = field.height_slope(up)
    assert np.isfinite(here).all() and np.isfinite(bound).all()
    assert (here >= ground.lowest_m).all() and (here <= ground.highest_m).all()
    np.testing.assert_allclose(here, ground.height(up), rtol=0.0, atol=1e-6)
    normal = ground.normal(up)
    assert np.isfinite(normal).all() and ((normal * up).sum(axis=1) > 0.0).all()
    for step_m in (1e-3, 0.1, 3.0):
        beside = up + sideways(up, rng) * (step_m / RADIUS_M)
        beside /= np.linalg.norm(beside, axis=1)[:, None]
        there, other = field.height_slope(beside)
        steepest = np.maximum(bound, other)
        # Places are doubles of 6 371 km: 1 nm, and so are heights.
        over = np.abs(there - here) - 1e-7 - steepest * step_m
        assert (over <= 0.0).all(), "nothing jumps"


def test_samples_are_the_files(case):
    country, params, _ = case
    if params.height_map_detail > 0.0:
        pytest.skip("relief below samples is added to them")
    ground = pf.TerrainSampler.from_params(params)
    for latitude, longitude, metres in country.samples[:3]:
        found = ground.height(np.ascontiguousarray(directions_at(latitude, longitude).T))
        # Of a finer set, which may lie on top, other samples.
        assert (np.abs(found - metres) < 1e-3).mean() > (0.2 if len(metres) > 1 else 0.0)
    for latitude, longitude, metres in country.samples[3:]:
        assert np.isfinite(ground.height(np.ascontiguousarray(directions_at(latitude, longitude).T)) - metres).all()


def test_streamed_heights_are_the_same_to_the_bit(case):
    country, params, rng = case
    few = real_ground(str(country.folder), 1_000_000, "x", streams=True)
    assert isinstance(few, StreamedGround)
    up = places(country, rng, 60)
    there = pf.TerrainSampler.from_params(replace(params, real=few)).height(up)
    np.testing.assert_array_equal(there, pf.TerrainSampler.from_params(params).height(up))


def test_rays_end_on_the_ground(case):
    """To a millimetre, and go through none before; with relief below samples but for one of 3000, which goes through
    the spike of 9 km, whose sides are 88 degrees steep."""
    country, params, rng = case
    ground = pf.TerrainSampler.from_params(params)
    up = places(country, rng, 12)
    way = sideways(up, rng) - rng.choice([0.02, 0.1, 0.5, 3.0, 100.0], len(up))[:, None] * up
    way /= np.linalg.norm(way, axis=1)[:, None]
    origin = up * (RADIUS_M + ground.height(up) + 10.0 ** rng.uniform(-1.0, 4.0, len(up)))[:, None]
    hit, distance = ground.raycast(origin, way, 3e4)
    assert hit.mean() > 0.5
    reach = np.where(hit, distance, 3e4)
    t = reach[:, None] * np.sort(rng.random((len(up), 400)), axis=1)
    place = origin[:, None] + way[:, None] * t[..., None]
    away = np.linalg.norm(place, axis=-1)
    above = away - RADIUS_M - ground.height((place / away[..., None]).reshape(-1, 3)).reshape(away.shape)
    through = (above.min(axis=1) < -1e-3).mean()
    assert through <= (0.0 if params.height_map_detail == 0.0 else 2e-3)
    end = (origin + way * reach[:, None])[hit]
    away = np.linalg.norm(end, axis=1)
    assert np.abs(away - RADIUS_M - ground.height(end / away[:, None])).max() < 1e-3


def test_spheres_touch_the_ground(case):
    """A sphere that falls stops where it touches: to a millimetre, from above, on the ground that heights say. Wider
    ones than the shortest relief touch at several places on slopes of 60 degrees and more, of which one is found."""
    country, params, rng = case
    ground = pf.TerrainSampler.from_params(params)
    up = places(country, rng, 12)
    up = up[np.hypot(up[:, 0], up[:, 1]) * RADIUS_M > 100.0]
    radius = 10.0 ** rng.uniform(-1.0, 0.7, len(up))
    most = 0.01 if params.height_map_detail == 0.0 else 0.05
    start = up * (RADIUS_M + ground.height(up) + 3.0 * radius + 5.0)[:, None]
    end = up * (RADIUS_M + ground.height(up) - 5.0)[:, None]
    hit, fraction, normal = ground.sweep(start, end, radius)
    assert hit.all() and np.isfinite(normal).all()
    centre = start + fraction[:, None] * (end - start)
    depth, out = ground.sphere_contact(centre, radius)
    assert (np.abs(depth) > 1e-3).mean() < most
    touched = centre - out * (radius - depth)[:, None]
    away = np.linalg.norm(touched, axis=1)
    off = np.abs(away - RADIUS_M - ground.height(touched / away[:, None]))
    assert (off > 1e-3).mean() < most
