"""Taking the sun out of pictures of the ground: synthetic ones, of a relief known in closed form under a known sun."""

from __future__ import annotations

import numpy as np
import pytest
from countries import fields, tile_at, tile_places, write_hgt, write_picture

import planetfall as pf
from planetfall.engine.display import reflectance
from planetfall.engine.real_ground.color_reading import real_colors
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import real_ground
from planetfall.engine.srgb import srgb_decode, srgb_encode
from planetfall.engine.wavelengths import DISPLAY_NM
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.real_colors import relief_of

RADIUS_M = 6.371e6
AZIMUTH_DEG, ELEVATION_DEG = 140.0, 38.0
SKY = 0.12
ZOOM, PLACE = 13, (46.5, 7.5)


def hills(latitude_deg, longitude_deg):
    """Metres: slopes of up to 35 degrees, hills of 2 km."""
    waves = ((310.0, 170.0), (-150.0, 260.0), (420.0, -90.0), (60.0, 390.0))
    return 1000.0 + 60.0 * sum(np.sin(a * latitude_deg + b * longitude_deg) for a, b in waves)


def cosine(latitude_deg, longitude_deg):
    """n.l on the hills."""
    step = 1e-4
    north_m = np.radians(step) * RADIUS_M
    east_m = north_m * np.cos(np.radians(latitude_deg))
    by_north = (hills(latitude_deg + step, longitude_deg) - hills(latitude_deg - step, longitude_deg)) / (2.0 * north_m)
    by_east = (hills(latitude_deg, longitude_deg + step) - hills(latitude_deg, longitude_deg - step)) / (2.0 * east_m)
    azimuth, elevation = np.radians(AZIMUTH_DEG), np.radians(ELEVATION_DEG)
    east, north, up = np.cos(elevation) * np.sin(azimuth), np.cos(elevation) * np.cos(azimuth), np.sin(elevation)
    lit = (up - by_east * east - by_north * north) / np.sqrt(1.0 + by_east**2 + by_north**2)
    return np.maximum(lit, 0.0)


@pytest.fixture(scope="module")
def valley(tmp_path_factory):
    folder = tmp_path_factory.mktemp("valley")
    step = np.arange(1201) / 1200.0
    longitude, latitude = np.meshgrid(7.0 + step, 47.0 - step)
    write_hgt(folder / "heights", 46, 7, 1201, np.rint(hills(latitude, longitude)).astype(np.int16))
    x, y = tile_at(ZOOM, *PLACE)
    for dx in range(3):
        for dy in range(3):
            places = tile_places(ZOOM, x + dx, y + dy)
            light = (cosine(*places) + SKY) / (np.sin(np.radians(ELEVATION_DEG)) + SKY)
            lit = np.clip(srgb_decode(fields(*places) / 255.0) * light[..., None], 0.0, 1.0)
            write_picture(folder / "picture", ZOOM, x + dx, y + dy, np.rint(255.0 * srgb_encode(lit)).astype(np.uint8))
    sun = f"sun_azimuth_deg = {AZIMUTH_DEG}\nsun_elevation_deg = {ELEVATION_DEG}\n"
    (folder / "known.toml").write_text(f'[[tiles]]\nfolder = "picture"\n{sun}')
    return folder


def seen(valley, path, unlit):
    """Brightness (N,) of the picture, that of its surface without any sun, n.l, and the map."""
    real = real_ground(str(valley / "heights"), 256_000_000, "Terrain.height_map")
    relief = relief_of(TerrainParams(real=real))
    found = real_colors(str(path), DISPLAY_NM, 256_000_000, "Terrain.color_map", unlit, relief)
    x, y = tile_at(ZOOM, *PLACE)
    latitude, longitude = (v[20:-20:3, 20:-20:3].ravel() for v in tile_places(ZOOM, x, y))
    bright = found.sample(directions_at(latitude, longitude), np.full(latitude.size, 1e-9))[0].sum(axis=0)
    surface = reflectance(srgb_decode(fields(latitude, longitude) / 255.0), DISPLAY_NM).sum(axis=1)
    return bright, surface, cosine(latitude, longitude), found


@pytest.mark.parametrize("name", ["known.toml", "picture"])
def test_the_sun_goes_out_of_a_picture(valley, name):
    """Brightness hangs on n.l less than a fourth of what it did (0.82 to 0.03; where the sun is fitted, to 0.11), and
    shading over the true surface is a sixth or less (rms 27 % to 1.1 %; 2.4 %)."""
    before, surface, lit, _ = seen(valley, valley / name, 0.0)
    after, _, _, found = seen(valley, valley / name, 1.0)
    half, _, _, _ = seen(valley, valley / name, 0.5)
    was, left = (abs(np.corrcoef(bright, lit)[0, 1]) for bright in (before, after))
    assert was > 0.7 and left < 0.25 * was

    def shading(bright):
        return np.std(bright / surface) / np.mean(bright / surface)

    assert shading(after) < shading(before) / 6.0 < shading(half)
    assert abs(np.mean(after / surface) - 1.0) < 0.05  # level ground keeps its colour
    azimuth_deg, elevation_deg = found.sets[0].sun_deg
    assert abs(azimuth_deg - AZIMUTH_DEG) < 5.0 and abs(elevation_deg - ELEVATION_DEG) < 10.0


def test_without_relief_the_sun_stays(valley):
    with pytest.raises(pf.SettingError, match=r"color_map_unlit: 0.5 without a height map.*name Terrain.height_map"):
        real_colors(str(valley / "picture"), DISPLAY_NM, 256_000_000, "Terrain.color_map", 0.5)
