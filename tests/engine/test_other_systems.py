"""GeoTIFFs in coordinate systems other than degrees: heights, joins, rotation, units, keys, blocks, what is broken.

The truth is a field of longitude and latitude in closed form, at places that pyproj alone says, and pairs of
coordinates as published.
"""

from __future__ import annotations

import logging
import sys
import tracemalloc

import numpy as np
import pytest
from geotiffs import AMPLITUDE_M, most_error_m, of_code, pixel_places, waves, write_geotiff

from planetfall.engine.real_ground.found import TileError
from planetfall.engine.real_ground.lattice import directions_at
from planetfall.engine.real_ground.resident import forget_ground, real_ground
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.engine.real_ground.tile_index import open_tiles

pyproj = pytest.importorskip("pyproj")
pytest.importorskip("tifffile")
MOST = 200_000_000
BORDER = 2
"""Pixels next to a border without a neighbour, where samples on one side of a place are missing."""
INNER = slice(BORDER, -BORDER), slice(BORDER, -BORDER)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("PLANETFALL_CACHE", str(tmp_path / "cache"))


def at(folder, longitude, latitude, most=MOST, streams=False):
    """(heights, rest) of the ground at places of any shape."""
    ground = real_ground(str(folder), most, "Terrain.height_map", streams)
    shape = np.shape(longitude)
    height, rest = ground.heights(directions_at(np.ravel(latitude), np.ravel(longitude)))
    return height.reshape(shape), rest.reshape(shape)


def write_tile(folder, code, x, y, step, rows, columns, wave_m, name="a.tif", **words):
    longitude, latitude = pixel_places(code, x, y, step, rows, columns)
    values = waves(longitude, latitude, wave_m).astype(np.float32)
    write_geotiff(folder / name, values, of_code(code), (x, y, step), **words)
    return longitude, latitude


def inside(code, x, y, step, rows, columns, count=4000, seed=1):
    """Random places, a little away from the border."""
    rng = np.random.default_rng(seed)
    px = x + step * rng.uniform(BORDER + 0.5, columns - BORDER - 0.5, count)
    py = y - step * rng.uniform(BORDER + 0.5, rows - BORDER - 0.5, count)
    return pyproj.Transformer.from_crs(code, 4326, always_xy=True).transform(px, py)


# -- heights -----------------------------------------------------------------------------------------------------------

PLACES = {
    "UTM 32N": (32632, 4.2e5, 5.21e6, 10.0),
    "UTM 33S": (32733, 5.5e5, 7.4e6, 1.0),
    "UTM north of 60 degrees": (32633, 5.0e5, 7.3e6, 2.0),
    "LV95": (2056, 2.6e6, 1.2e6, 2.0),
    "ETRS89, LAEA Europe": (3035, 4.32e6, 3.21e6, 25.0),
    "Lambert 93": (2154, 6.5e5, 6.86e6, 5.0),
    "Krovak": (5514, -7.4e5, -1.04e6, 5.0),
    "Antarctica": (3031, -1.2e6, 8.0e5, 10.0),
    "at the south pole": (3031, -700.0, 900.0, 10.0),
    "with the south pole for a corner": (3031, 0.0, 1000.0, 10.0),
    "across the date line": (32660, 7.06e5, 1.9e6, 100.0),
    "State Plane, feet": (2263, 9.9e5, 2.1e5, 10.0),
    "world Mercator": (3395, 8.4e5, 5.8e6, 10.0),
}


@pytest.mark.parametrize("what", sorted(PLACES))
def test_heights_are_the_fields(tmp_path, what):
    """At pixels and between them: the curve through pixels, and the one through samples, are as far off as each
    may."""
    code, x, y, step = PLACES[what]
    metres = step * pyproj.CRS.from_epsg(code).axis_info[0].unit_conversion_factor
    wave_m = 30.0 * metres
    longitude, latitude = write_tile(tmp_path / "t", code, x, y, step, 170, 150, wave_m)
    most = 2.0 * most_error_m(1.05 * metres, wave_m) + 0.002
    found, rest = at(tmp_path / "t", longitude, latitude)
    off = found - waves(longitude, latitude, wave_m)
    assert np.abs(off[INNER]).max() < most and not rest.any()
    assert np.sqrt((off[INNER] ** 2).mean()) < 0.25 * most
    if "corner" not in what:  # a pole takes the mean of what is around it
        # A pixel's way down the steepest slope.
        assert np.abs(off).max() < metres * AMPLITUDE_M * 2.0 * np.pi / wave_m
    random = inside(code, x, y, step, 170, 150)
    found, rest = at(tmp_path / "t", *random)
    off = found - waves(*random, wave_m)
    assert np.abs(off).max() < most and np.sqrt((off**2).mean()) < 0.25 * most and not rest.any()


def test_a_plane_stays_one(tmp_path):
    """Linear heights come back to a millimetre: nothing is moved."""
    x, y = 4.2e5, 5.21e6
    px, py = np.meshgrid(np.arange(150) + 0.5, np.arange(150) + 0.5)
    write_geotiff(tmp_path / "t/a.tif", (100.0 + 0.5 * px + 0.25 * py).astype(np.float32), of_code(32632), (x, y, 1.0))
    longitude, latitude = inside(32632, x, y, 1.0, 150, 150)
    column, row = pyproj.Transformer.from_crs(4326, 32632, always_xy=True).transform(longitude, latitude)
    found, _ = at(tmp_path / "t", longitude, latitude)
    assert np.abs(found - (100.0 + 0.5 * (column - x) + 0.25 * (y - row))).max() < 1e-3


@pytest.mark.parametrize("point", [False, True], ids=["areas", "points"])
@pytest.mark.parametrize("turn_deg", [0.0, 30.0, 90.0, 200.0])
@pytest.mark.parametrize("up", [False, True], ids=["rows down", "rows up"])
def test_rotated_files(tmp_path, turn_deg, up, point):
    """By ModelTransformation."""
    c, s, step, flip = np.cos(np.radians(turn_deg)), np.sin(np.radians(turn_deg)), 10.0, 1.0 if up else -1.0
    matrix = (step * c, -flip * step * s, 4.2e5, step * s, flip * step * c, 5.21e6)
    i, j = (v + (0.0 if point else 0.5) for v in np.meshgrid(np.arange(140.0), np.arange(130.0)))
    px, py = matrix[0] * i + matrix[1] * j + matrix[2], matrix[3] * i + matrix[4] * j + matrix[5]
    longitude, latitude = pyproj.Transformer.from_crs(32632, 4326, always_xy=True).transform(px, py)
    values = waves(longitude, latitude, 300.0).astype(np.float32)
    write_geotiff(tmp_path / "t/a.tif", values, of_code(32632), matrix=matrix, point=point)
    found, rest = at(tmp_path / "t", longitude, latitude)
    assert np.abs(found - values)[INNER].max() < 2.0 * most_error_m(10.5, 300.0) and not rest.any()


def test_degrees_may_be_turned_and_have_another_datum(tmp_path):
    """South on top, in degrees; and DHDN, whose degrees lie 150 m from WGS84's."""
    j, i = np.arange(100.0)[:, None], np.arange(120.0)
    longitude, latitude = np.broadcast_arrays(7.0 + (i + 0.5) * 1e-3, 46.0 + (j + 0.5) * 1e-3)
    values = waves(longitude, latitude, 3000.0).astype(np.float32)
    keys = {1024: 2, 2048: 4326}
    write_geotiff(tmp_path / "up/a.tif", values, keys, matrix=(1e-3, 0.0, 7.0, 0.0, 1e-3, 46.0))
    found, rest = at(tmp_path / "up", longitude, latitude)
    assert np.abs(found - values)[INNER].max() < 2.0 * most_error_m(115.0, 3000.0) and not rest.any()
    moved = pyproj.Transformer.from_crs(4314, 4326, always_xy=True).transform(longitude, latitude + 4.0)
    values = waves(*moved, 3000.0).astype(np.float32)
    write_geotiff(tmp_path / "dhdn/a.tif", values[::-1], {1024: 2, 2048: 4314}, (7.0, 50.1, 1e-3))
    found, rest = at(tmp_path / "dhdn", *moved)
    assert np.abs(found - values)[INNER].max() < 2.0 * most_error_m(115.0, 3000.0) and not rest.any()
    by_m = np.radians([(moved[0] - longitude).mean(), (moved[1] - latitude - 4.0).mean()]) * 6.371e6
    assert 50.0 < np.hypot(*by_m) < 300.0


def test_another_planets_degrees_are_its_own(tmp_path):
    """An equirectangular map of a part of Mars, of a radius of its own."""
    radius, step = 3396190.0, 20.0
    keys = {1024: 1, 3072: 32767, 3075: 17, 3076: 9001, 3078: 0.0, 3080: 180.0, 2048: 32767, 2057: radius, 2058: radius}
    i, j = np.meshgrid(np.arange(120.0) + 0.5, np.arange(110.0) + 0.5)
    longitude, latitude = 180.0 + np.degrees((1e5 + step * i) / radius), np.degrees((3e5 - step * j) / radius)
    values = waves(longitude, latitude, 1200.0).astype(np.float32)
    write_geotiff(tmp_path / "t/a.tif", values, keys, (1e5, 3e5, step))
    found, rest = at(tmp_path / "t", longitude, latitude)
    assert np.abs(found - values)[INNER].max() < 2.0 * most_error_m(40.0, 1200.0) and not rest.any()


# -- joins -------------------------------------------------------------------------------------------------------------


def steps_off(folder, longitude, latitude, wave_m):
    """Heights along lines (lines, places), less the field's: worst, and worst change from place to place."""
    found, rest = at(folder, longitude, latitude)
    assert not rest.any()
    off = found - waves(longitude, latitude, wave_m)
    return np.abs(off).max(), np.abs(np.diff(off, axis=1)).max()


@pytest.mark.parametrize("code", [32632, 2056])
def test_neighbours_join(tmp_path, code):
    """Four tiles of one survey: no gap, and along lines across the joins heights are as good as elsewhere, since each
    tile knows its neighbours' pixels."""
    x, y = {32632: (4.2e5, 5.21e6), 2056: (2.6e6, 1.2e6)}[code]
    for b in (0, 1):
        for a in (0, 1):
            write_tile(tmp_path / "t", code, x + 1000.0 * a, y - 1000.0 * b, 10.0, 100, 100, 300.0, f"{a}{b}.tif")
    to_map = pyproj.Transformer.from_crs(code, 4326, always_xy=True).transform
    along, line = np.linspace(-40.0, 40.0, 1601), np.linspace(-900.0, 900.0, 41)[:, None]
    across = (np.stack(np.broadcast_arrays(x + 1000.0 + along, y - 1000.0 + line)),
              np.stack(np.broadcast_arrays(x + 1000.0 + line, y - 1000.0 + along)))  # fmt: skip
    (found,) = open_tiles(str(tmp_path / "t"), "x")
    assert len(found) == 4 and found.warped.all() and len(found.tile(0)[1].beside) == 3
    for lines in across:
        worst, jump = steps_off(tmp_path / "t", *to_map(*lines), 300.0)
        far, elsewhere = steps_off(tmp_path / "t", *to_map(lines[0] - 300.0, lines[1] + 60.0), 300.0)
        assert worst < 0.25 * most_error_m(10.5, 300.0) and worst < 2.5 * far and jump < 2.0 * elsewhere


def test_alone_a_border_goes_straight_on(tmp_path):
    """Without its neighbour's pixels the last half of a pixel is an extrapolation, of the second order."""
    write_tile(tmp_path / "t", 32632, 4.2e5, 5.21e6, 10.0, 100, 100, 300.0)
    to_map = pyproj.Transformer.from_crs(32632, 4326, always_xy=True).transform
    longitude, latitude = to_map(np.full(81, 4.2e5 + 1.0), 5.21e6 - np.linspace(20.0, 980.0, 81))
    found, rest = at(tmp_path / "t", longitude, latitude)
    assert np.abs(found - waves(longitude, latitude, 300.0)).max() < 6.0 * most_error_m(10.5, 300.0)
    assert not rest.any()


@pytest.mark.parametrize("cut", [False, True], ids=["overlapping", "cut at the border"])
def test_two_zones_join(tmp_path, cut):
    """UTM 32 and 33 at 12 degrees east have one lattice. Cut there, each is a stair of pixels."""
    wave_m, step = 600.0, 20.0
    for code in (32632, 32633):
        x, y = pyproj.Transformer.from_crs(4326, code, always_xy=True).transform(12.0, 48.0)
        x, y = step * np.floor(x / step) - 1500.0, step * np.floor(y / step) + 1500.0
        longitude, latitude = pixel_places(code, x, y, step, 150, 150)
        values = waves(longitude, latitude, wave_m).astype(np.float32)
        if cut:
            values[(longitude > 12.0) == (code == 32632)] = -9999.0
        tags = ((42113, "s", 0, "-9999", True),)
        write_geotiff(tmp_path / f"t/{code}.tif", values, of_code(code), (x, y, step), tags=tags)
    (found,) = open_tiles(str(tmp_path / "t"), "x")
    assert len(found) == 2
    longitude, latitude = np.broadcast_arrays(
        12.0 + np.linspace(-0.002, 0.002, 1201), 48.0 + np.linspace(-0.01, 0.01, 31)[:, None]
    )
    worst, jump = steps_off(tmp_path / "t", longitude, latitude, wave_m)
    most = 2.0 * most_error_m(1.05 * step, wave_m)
    assert worst < (4.0 * most if cut else most) and jump < most


def test_gaps_stay_gaps(tmp_path):
    """A hole's border lies where the file's does, to half a sample, and its inside shows what is below."""
    longitude, latitude = pixel_places(32632, 4.2e5, 5.21e6, 10.0, 200, 200)
    values = waves(longitude, latitude, 300.0).astype(np.float32)
    values[60:140, 60:140] = np.nan
    write_geotiff(tmp_path / "t/a.tif", values, of_code(32632), (4.2e5, 5.21e6, 10.0))
    (tiles,) = open_tiles(str(tmp_path / "t"), "x")
    from planetfall.engine.real_ground.survey import survey

    (facts,), _ = survey([tiles])
    share = tiles.lattice.sample_m(6.371e6)
    assert abs(facts.voids / facts.samples - 0.16) < 0.01 and 9.0 < share < 10.1
    hole = np.isnan(values)
    _, rest = at(tmp_path / "t", longitude[~hole], latitude[~hole])
    assert not rest.any()
    assert (at(tmp_path / "t", longitude[95:105, 95:105], latitude[95:105, 95:105])[1] == 0.0).all()  # coarser levels


# -- units, keys -------------------------------------------------------------------------------------------------------

FOOT, US_FOOT = 0.3048, 1200.0 / 3937.0
UNITS = {
    "VerticalUnits": ({4099: 9002}, (), FOOT, 0.0),
    "US feet": ({4099: 9003}, (), US_FOOT, 0.0),
    "a vertical system in feet": ({4096: 6360}, (), US_FOOT, 0.0),
    "a vertical system in metres": ({4096: 5703}, (), 1.0, 0.0),
    "the band": ({4099: 9001}, ('<Item name="UNITTYPE" sample="0" role="unittype">ft</Item>',), FOOT, 0.0),
    "scale and offset": (
        {}, ('<Item name="a" sample="0" role="scale">0.5</Item>', '<Item name="b" sample="0" role="offset">7</Item>'),
        0.5, 7.0,
    ),
}  # fmt: skip


@pytest.mark.parametrize("warped", [True, False])
@pytest.mark.parametrize("what", sorted(UNITS))
def test_units_of_heights(tmp_path, what, warped):
    more, items, unit, offset = UNITS[what]
    keys = {**(of_code(32632) if warped else {1024: 2, 2048: 4326}), **more}
    place = (4.2e5, 5.21e6, 10.0) if warped else (7.0, 47.0, 1e-3)
    tags = ((42112, "s", 0, f"<GDALMetadata>{''.join(items)}</GDALMetadata>", True),) if items else ()
    write_geotiff(tmp_path / "t/a.tif", np.full((50, 50), 1000.0, np.float32), keys, place, tags=tags)
    where = inside(32632, *place, 50, 50, 20) if warped else (7.025, 46.975)
    found, _ = at(tmp_path / "t", *where)
    assert np.abs(found - (1000.0 * unit + offset)).max() < 1e-3


GRS80 = {2048: 32767, 2057: 6378137.0, 2059: 298.257222101}
BY_KEYS = {
    "tmerc": ({3075: 1, 3080: 9.0, 3081: 0.0, 3092: 0.9996, 3082: 5e5, 3083: 0.0, 2048: 4326}, 32632, 4.2e5, 5.21e6),
    "UTM by its projection": ({3074: 16032, 2048: 4326}, 32632, 4.2e5, 5.21e6),
    "lcc": (
        {3075: 8, 3078: 49.0, 3079: 44.0, 3084: 3.0, 3085: 46.5, 3086: 7e5, 3087: 6.6e6, **GRS80}, 2154, 6.5e5, 6.86e6,
    ),
    "aea": ({3075: 11, 3078: 29.5, 3079: 45.5, 3080: -96.0, 3081: 23.0, 3082: 0.0, 2048: 4269}, 5070, 1e5, 1.9e6),
    "stere": ({3075: 15, 3081: -71.0, 3095: 0.0, 3092: 1.0, 2048: 4326}, 3031, -1.2e6, 8e5),
    "stere by a scale": (
        {3075: 15, 3081: 90.0, 3095: 0.0, 3092: 0.994, 3082: 2e6, 3083: 2e6, 2048: 4326}, 32661, 2.2e6, 2.3e6,
    ),
    "laea": ({3075: 10, 3088: 10.0, 3089: 52.0, 3082: 4.321e6, 3083: 3.21e6, 2048: 4258}, 3035, 4.3e6, 3.2e6),
    "feet": (
        {3075: 8, 3076: 9003, 3078: 41.0 + 2.0 / 60.0, 3079: 40.0 + 2.0 / 3.0, 3084: -74.0, 3085: 40.0 + 1.0 / 6.0,
         3086: 984250.0, 3087: 0.0, 2048: 4269}, 2263, 9.9e5, 2.1e5,
    ),
    "a projection in another unit": ({3072: 32632, 3076: 9002}, 32632, 4.2e5 / FOOT, 5.21e6 / FOOT),
    "PROJ": ({1026: "+proj=utm +zone=32 +datum=WGS84 +units=m +no_defs +type=crs"}, 32632, 4.2e5, 5.21e6),
    "WKT": ({3073: "ESRI PE String = {esri}"}, 32632, 4.2e5, 5.21e6),
    "a name": ({1026: "WGS 84 / UTM zone 32N|WGS 84"}, 32632, 4.2e5, 5.21e6),
    "an ESRI code": ({3072: 54030}, "ESRI:54030", 1e6, 4e6),
    "a shift of the datum": (
        {3075: 1, 3080: 9.0, 3081: 0.0, 3092: 1.0, 3082: 3.5e6, 3083: 0.0, 2048: 32767, 2056: 7004,
         2062: [598.1, 73.7, 418.2, 0.202, 0.045, -2.455, 6.7]},
        "+proj=tmerc +lat_0=0 +lon_0=9 +k=1 +x_0=3500000 +y_0=0 +ellps=bessel "
        "+towgs84=598.1,73.7,418.2,0.202,0.045,-2.455,6.7 +units=m +type=crs", 3.5e6, 5.4e6,
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", sorted(BY_KEYS))
def test_systems_by_keys_are_those_of_their_codes(tmp_path, what):
    """To 1e-9 degrees, 0.1 mm."""
    from planetfall.engine.real_ground.geo_system import system_of
    from planetfall.engine.real_ground.geo_tags import geo_header

    keys, code, x, y = BY_KEYS[what]
    if 3073 in keys:
        keys = {3073: keys[3073].format(esri=pyproj.CRS.from_epsg(code).to_wkt("WKT1_ESRI"))}
    keys = {1024: 1, 3072: 32767, **keys}
    file = write_geotiff(tmp_path / "a.tif", np.zeros((4, 4), np.float32), keys, (x, y, 10.0))
    system = system_of(file, geo_header(file))
    px, py = x + np.array([0.0, 500.0, 1e4]), y + np.array([0.0, -500.0, 2e4])
    unit = FOOT if what == "a projection in another unit" else 1.0
    truth = pyproj.Transformer.from_crs(code, 4326, always_xy=True).transform(px * unit, py * unit)
    found = system.place(px, py)
    assert np.abs(np.subtract(found, truth)).max() < 1e-9
    assert np.abs(np.subtract(system.model(*found), (px, py))).max() < 1e-3


CLARKE, AIRY = {2057: 6378206.4, 2059: 294.978698}, {2057: 6377563.396, 2059: 299.32496}
PUBLISHED = {
    # IOGP guidance note 7-2 (Coordinate Conversions and Transformations including Formulas), worked examples, on their
    # own datums: keys that name none leave its degrees.
    "Lambert conic, 2 parallels": (
        {3075: 8, 3076: 9003, 3084: -99.0, 3085: 27.0 + 50.0 / 60.0, 3078: 28.0 + 23.0 / 60.0, 3079: 30.0 + 17.0 / 60.0,
         3086: 2e6, 3087: 0.0, 2048: 32767, **CLARKE}, 28.5, -96.0, 2963503.91, 254759.80,
    ),
    "Transverse Mercator": (
        {3075: 1, 3081: 49.0, 3080: -2.0, 3092: 0.9996012717, 3082: 4e5, 3083: -1e5, 2048: 32767, **AIRY},
        50.5, 0.5, 577274.99, 69740.50,
    ),
    "Polar stereographic, A": ({3072: 32661}, 73.0, 44.0, 3320416.75, 632668.43),
    "Polar stereographic, B": ({3072: 3032}, -75.0, 120.0, 7255380.79, 7053389.56),
    # swisstopo: the old observatory of Berne, the origin of LV95.
    "LV95": ({3072: 2056}, 46.951082877, 7.438632495, 2600000.0, 1200000.0),
    # pyproj's own test of its documentation.
    "UTM": ({3072: 32610}, 34.36116666, -120.108, 765975.641, 3805993.134),
}  # fmt: skip


@pytest.mark.parametrize("what", sorted(PUBLISHED))
def test_published_coordinates(tmp_path, what):
    from planetfall.engine.real_ground.geo_system import system_of
    from planetfall.engine.real_ground.geo_tags import geo_header

    keys, latitude, longitude, x, y = PUBLISHED[what]
    file = write_geotiff(tmp_path / "a.tif", np.zeros((4, 4), np.float32), {1024: 1, 3072: 32767, **keys}, (x, y, 10.0))
    found = system_of(file, geo_header(file)).model(np.array([longitude]), np.array([latitude]))
    most = 0.1 if what == "LV95" else 0.012  # the shift to WGS84 is known to 1 m
    assert abs(found[0][0] - x) < most and abs(found[1][0] - y) < most


# -- blocks ------------------------------------------------------------------------------------------------------------


LAYOUTS = {
    "mapped": {},
    "tiles": {"tile": (256, 256)},
    "strips, compressed": {"rowsperstrip": 16, "compression": "zlib"},
    "tiles, compressed": {"tile": (128, 256), "compression": "zlib"},
}


@pytest.mark.parametrize("layout", sorted(LAYOUTS))
def test_streamed_heights_are_those_in_memory(tmp_path, layout):
    """Bit by bit, with joins and holes, however files are laid out."""
    for a in (0, 1):
        x = 4.2e5 + 9000.0 * a
        longitude, latitude = pixel_places(32632, x, 5.21e6, 15.0, 700, 600)
        values = waves(longitude, latitude, 450.0).astype(np.float32)
        values[100:300, 200:350] = np.nan
        write_geotiff(tmp_path / f"t/{a}.tif", values, of_code(32632), (x, 5.21e6, 15.0), **LAYOUTS[layout])
    rng = np.random.default_rng(4)
    px, py = 4.2e5 + rng.uniform(-300.0, 18300.0, 3000), 5.21e6 - rng.uniform(-300.0, 10800.0, 3000)
    longitude, latitude = pyproj.Transformer.from_crs(32632, 4326, always_xy=True).transform(px, py)
    whole, whole_rest = at(tmp_path / "t", longitude, latitude)
    forget_ground()
    assert isinstance(real_ground(str(tmp_path / "t"), 4_000_000, "x", True), StreamedGround)
    few, few_rest = at(tmp_path / "t", longitude, latitude, 4_000_000, True)
    np.testing.assert_array_equal(few, whole)
    np.testing.assert_array_equal(few_rest, whole_rest)


def test_large_files_are_read_in_parts(tmp_path):
    """A window of a file of 6000 x 6000 pixels, 144 MB: only its tiles are decoded."""
    from planetfall.engine.real_ground.tile_files import find_tile, read_part

    i, j = np.arange(6000.0), np.arange(6000.0)[:, None]
    values = (1000.0 + 0.1 * i + 0.05 * j).astype(np.float32)
    file = tmp_path / "a.tif"
    write_geotiff(file, values, of_code(32632), (4.2e5, 5.21e6, 1.0), tile=(256, 256), compression="zlib")
    del values
    tracemalloc.start()
    found = find_tile(file, file.relative_to(tmp_path), file.stat().st_size)
    part = read_part(file, found, slice(3000, 3240), slice(4000, 4240))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert part is not None and part.shape == (240, 240) and not np.isnan(part).any()
    assert peak < 12_000_000


# -- what can't be used ------------------------------------------------------------------------------------------------

UTM = of_code(32632)
BROKEN = {
    "no such code": ({1024: 1, 3072: 29999}, {}, ("EPSG:29999", "doesn't know", "gdalwarp -t_srs EPSG:4326")),
    "geocentric": ({1024: 3}, {}, ("GTModelTypeGeoKey 3", "expected 1", "gdalwarp")),
    "no projection": ({1024: 1, 3072: 32767}, {}, ("projection that isn't known", "EPSG code", "gdalwarp")),
    "half a projection": ({1024: 1, 3072: 32767, 3075: 8, 3078: 49.0}, {}, ("ProjStdParallel2GeoKey", "gdalwarp")),
    "no WKT": ({1024: 1, 3072: 32767, 3073: "PROJCS[nothing"}, {}, ("PROJ can't make", "gdalwarp")),
    "a unit nobody knows": ({**UTM, 3076: 9999}, {}, ("unit 9999", "9001 (metre)", "gdalwarp")),
    "a unit of no length": ({**UTM, 3076: 32767, 3077: 0.0}, {}, ("ProjLinearUnitSizeGeoKey 0", "above 0")),
    "far outside": (UTM, {"place": (4e9, 5e9, 10.0)}, ("no longitude and latitude", "UTM zone 32N", "gdalwarp")),
    "a line": (UTM, {"matrix": (1.0, 2.0, 0.0, 1.0, 2.0, 0.0)}, ("ModelTransformation", "have an area", "gdalwarp")),
    "no number": (UTM, {"matrix": (1.0, 0.0, float("nan"), 0.0, -1.0, 0.0)}, ("numbers", "gdalwarp")),
    "no place": (UTM, {"place": ()}, ("doesn't say where it is", "ModelTransformation")),
    "no keys": ({}, {}, ("not in which coordinate system", "-a_srs")),
    "points alone": (
        UTM, {"place": (), "tags": ((33922, "d", 24, tuple(float(v) for v in range(24)), True),)},
        ("tie points alone, 4", "gdalwarp"),
    ),
}  # fmt: skip


@pytest.mark.parametrize("what", sorted(BROKEN))
def test_what_cannot_be_placed_says_so(tmp_path, caplog, what):
    keys, words, said = BROKEN[what]
    words = {"place": (4.2e5, 5.21e6, 10.0), **words}
    if "matrix" in words:
        words["place"] = ()
    write_geotiff(tmp_path / "t/a.tif", np.zeros((8, 8), np.float32), keys, **words)
    with caplog.at_level(logging.WARNING), pytest.raises(TileError):
        at(tmp_path / "t", 7.0, 47.0)
    for word in ("Terrain.height_map", "a.tif", *said):
        assert word in caplog.text, caplog.text


@pytest.mark.parametrize("much", [10, 300, 0.6])
def test_half_a_file_is_left_out(tmp_path, caplog, much):
    write_tile(tmp_path / "t", 32632, 4.2e5, 5.21e6, 10.0, 100, 100, 300.0, "whole.tif")
    write_tile(
        tmp_path / "t", 32632, 4.3e5, 5.21e6, 10.0, 100, 100, 300.0, "half.tif", tile=(32, 32), compression="zlib"
    )
    file = tmp_path / "t/half.tif"
    data = file.read_bytes()
    file.write_bytes(data[: much if isinstance(much, int) else int(much * len(data))])
    with caplog.at_level(logging.WARNING):
        _, rest = at(tmp_path / "t", *inside(32632, 4.2e5, 5.21e6, 10.0, 100, 100, 50))
    assert not rest.any() and sum("half.tif" in r.getMessage() for r in caplog.records) == 1
    assert "left out" in caplog.text


def test_without_pyproj_it_is_named_and_looked_for_again(tmp_path, caplog, monkeypatch):
    """Degrees need none; and what was refused for it is used once it is there."""
    write_tile(tmp_path / "t", 32629, 4.2e5, 5.21e6, 10.0, 100, 100, 300.0)
    values = np.full((20, 20), 700.0, np.float32)
    write_geotiff(tmp_path / "t/degrees.tif", values, {1024: 2, 2048: 4258}, (20.0, 47.0, 1e-3))
    place = inside(32629, 4.2e5, 5.21e6, 10.0, 100, 100, 50)
    with monkeypatch.context() as context:
        context.setitem(sys.modules, "pyproj", None)
        with caplog.at_level(logging.WARNING):
            assert len(open_tiles(str(tmp_path / "t"), "x")) == 1
        assert "EPSG:32629" in caplog.text and "pip install 'planetfall[maps]'" in caplog.text
    assert len(open_tiles(str(tmp_path / "t"), "x")) == 2
    assert not at(tmp_path / "t", *place)[1].any()


def test_few_lattices_do_for_all(tmp_path):
    """Of one size of pixels wherever a survey is below 60 degrees, and samples as fine as pixels."""
    for number, (code, x, y) in enumerate(
        ((32632, 4.2e5, 1e6), (32633, 6e5, 6.5e6), (2056, 2.6e6, 1.2e6), (27700, 4e5, 3e5))
    ):
        write_geotiff(tmp_path / f"t/{number}.tif", np.zeros((8, 8), np.float32), of_code(code), (x, y, 1.0))
    (found,) = open_tiles(str(tmp_path / "t"), "x")
    assert 0.9 < found.lattice.sample_m(6.371e6) < 1.0 and len(found) == 4
