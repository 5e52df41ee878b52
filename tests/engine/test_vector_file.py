"""Vector maps from GeoJSON: what features are, errors, and places in polygons."""

from __future__ import annotations

import json
import time

import numpy as np
import pytest
from vector_kit import feature, line, polygon, ring, write_map

from planetfall.engine.real_ground.polygons import Polygons
from planetfall.engine.real_ground.tile_files import TileError
from planetfall.engine.real_ground.vector_file import vector_map

SQUARE = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]]


def test_features_are_what_their_properties_say(tmp_path):
    course = line((7.0, 46.0), (7.1, 46.0))
    path = write_map(
        tmp_path / "a.geojson",
        feature(polygon(SQUARE), natural="water"),
        feature(polygon(SQUARE), kind="lake", level_m=412.5),
        feature(polygon(SQUARE), natural="water", water="river"),
        feature(polygon(SQUARE), waterway="riverbank"),
        feature(polygon(SQUARE), natural="bay"),
        feature({"type": "MultiPolygon", "coordinates": [[SQUARE], [SQUARE]]}, landuse="forest"),
        feature(polygon(SQUARE), natural="scrub"),
        feature(course, waterway="river", width="12.5 m"),
        feature(course, waterway="canal"),
        feature({"type": "MultiLineString", "coordinates": [course["coordinates"]] * 2}, waterway="stream"),
        feature({"type": "GeometryCollection", "geometries": [course, {"type": "Point", "coordinates": [0, 0]}]},
                kind="river"),
        feature(line(*SQUARE), natural="water"),
        feature(line(*SQUARE), natural="coastline"),
        feature(line(*SQUARE[::-1][:3]), natural="coastline"),
        feature(line(*SQUARE[::-1][2:]), natural="coastline"),
        feature({"type": "Point", "coordinates": [0.0, 0.0]}, natural="water"),
        feature(course, natural="wood"),
        feature(course, highway="path"),
        feature(course, waterway="ditch"),
        feature(None, natural="water"),
    )  # fmt: skip
    found = vector_map(path)
    assert dict(found.counts) == {"lake": 4, "bank": 1, "sea": 1, "forest": 2, "river": 4, "coast": 3}
    assert (len(found.lakes), len(found.banks), len(found.forests), len(found.seas)) == (3, 2, 2, 2)
    assert len(found.islands) == 1, "land to the left of a coastline"
    assert [found.lakes[k].level_m for k in range(2)] == [None, 412.5]
    assert [course.width_m for course in found.rivers] == [12.5, 12.0, 3.0, 3.0, 20.0]
    assert [course.stated for course in found.rivers] == [True, False, False, False, False]
    assert sum(found.ignored.values()) == 5
    assert found.ignored["waterway=ditch"] == found.ignored["no geometry"] == 1


def test_rings_that_are_not_closed_are_and_open_coasts_are_not(tmp_path):
    path = write_map(
        tmp_path / "a.geojson",
        feature(polygon(SQUARE[:-1]), natural="water"),
        feature(polygon(SQUARE[:2]), natural="water"),
        feature(line(*SQUARE[:3]), natural="coastline"),
    )
    found = vector_map(path)
    assert found.repaired == 2 and np.array_equal(found.lakes[0].polygons[0][0], SQUARE)
    assert len(found.lakes) == 1 and not found.islands and not found.seas
    assert any("fewer than four" in why for why in found.ignored)
    assert any("open coastline" in why for why in found.ignored)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ("is empty", "export it again")),
        ('{"type": "FeatureCollection",\n "features": [}', ("line 2", "no JSON")),
        ('{"type": "FeatureCollection", "features": []}', ("holds no feature",)),
        ('{"type": "Topology"}', ("expected 'FeatureCollection'", "'Topology'", "ogr2ogr")),
        ("[1, 2]", ("expected 'FeatureCollection'",)),
        ('{"type": "FeatureCollection", "features": [3]}', ("features[0]", "'Feature'", "3")),
        (json.dumps(feature({"type": "Curve"}, natural="water")), ("geometry.type", "'Curve'", "Polygon")),
        (json.dumps(feature(line((2600000.0, 1200000.0), (1.0, 1.0)), kind="river")),
         ("coordinates[0]", "look like metres", "EPSG:4326")),
        (json.dumps(feature(line((46.0, 97.0), (46.0, 98.0)), kind="river")), ("longitude comes first",)),
        (json.dumps(feature(polygon([[0, 0], [1], [1, 1], [0, 0]]), kind="lake")), ("coordinates[0][1]", "position")),
        (json.dumps(feature(polygon([[0, 0], ["a", 1], [1, 1], [0, 0]]), kind="lake")), ("'a'", "position")),
        (json.dumps(feature(line((0.0, 0.0), (1.0, 1.0)), kind="river", width="wide")), ("properties.width", "'wide'")),
        ('{"type": "Feature", "crs": {"properties": {"name": "EPSG:2056"}}}', ("EPSG:2056", "expected degrees")),
    ],
)  # fmt: skip
def test_errors_say_what_and_where(tmp_path, text, words):
    path = tmp_path / "a.geojson"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(TileError) as error:
        vector_map(str(path))
    for word in (str(path), *words):
        assert word in str(error.value)


@pytest.mark.parametrize("width", ["~10", "3;5", "<2", "12'", "10 metres", "0"])
def test_widths_that_mappers_write_as_texts_are_left_out(tmp_path, width):
    path = write_map(
        tmp_path / "a.geojson",
        feature(line((0.0, 0.0), (1.0, 1.0)), waterway="stream", width=width),
        feature(line((0.0, 0.0), (1.0, 1.0)), waterway="river", width="12 m"),
    )
    found = vector_map(path)
    assert [(course.width_m, course.stated) for course in found.rivers] == [(3.0, False), (12.0, True)]
    assert any(width in why for why in found.ignored)


@pytest.mark.parametrize(
    "text",
    [
        json.dumps(feature(line((0.0, 0.0), (1.0, 1.0)), kind="river", width=10**400)),
        json.dumps(feature(line((0.0, 0.0), (10**400, 1.0)), kind="river")),
        '{"type": "FeatureCollection", "features": ' + "1" * 5000 + "}",
        '{"type": "FeatureCollection", "crs": {"properties": ["x"]}, "features": []}',
    ],
)
def test_numbers_and_types_that_no_file_should_have(tmp_path, text):
    (tmp_path / "a.geojson").write_text(text, encoding="utf-8")
    with pytest.raises(TileError, match=r"a\.geojson"):
        vector_map(str(tmp_path / "a.geojson"))


def test_kinds_of_other_types_are_ignored(tmp_path):
    square = [[0, 0], [1, 0], [1, 1], [0, 0]]
    path = write_map(
        tmp_path / "a.geojson",
        feature(polygon(square), kind=["lake"]),
        feature(polygon(square), kind="lake", water=[1]),
    )
    assert len(vector_map(path).lakes) == 1


def test_a_missing_file(tmp_path):
    with pytest.raises(TileError, match="expected a GeoJSON file, found nothing"):
        vector_map(str(tmp_path / "none.geojson"))
    with pytest.raises(TileError, match="found a folder"):
        vector_map(str(tmp_path))


def test_a_file_that_changes_is_read_again(tmp_path):
    path = write_map(tmp_path / "a.geojson", feature(polygon(SQUARE), natural="water"))
    assert vector_map(path) is vector_map(path)
    write_map(tmp_path / "a.geojson", *[feature(polygon(SQUARE), natural="water")] * 2)
    assert len(vector_map(path).lakes) == 2


def winding(rings, x, y):
    """Whether places lie in a polygon with holes, one by one."""
    odd = np.zeros(len(x), bool)
    for points in rings:
        a, b = np.array(points)[:-1], np.array(points)[1:]
        for (ax, ay), (bx, by) in zip(a, b, strict=True):
            on = ((ay > y) != (by > y)) & (x < (bx - ax) * (y - ay) / (by - ay + 1e-300) + ax)
            odd ^= on
    return odd


def test_places_in_polygons_with_holes():
    rings = [np.array(ring(7.0, 46.0, 0.5, 0.3, 400, 0.2)), np.array(ring(7.1, 46.0, 0.1, 0.1, 50))]
    found = Polygons([tuple(rings), (np.array(ring(8.0, 46.0, 0.2, 0.1)),)])
    rng = np.random.default_rng(1)
    x, y = rng.uniform(6.0, 8.5, 5000), rng.uniform(45.5, 46.5, 5000)
    expected = winding(rings, x, y) | winding([ring(8.0, 46.0, 0.2, 0.1)], x, y)
    assert np.array_equal(found.inside(x, y), expected) and 0.1 < expected.mean() < 0.6
    turned = Polygons([tuple(each[::-1] for each in rings), (np.array(ring(8.0, 46.0, 0.2, 0.1)),)])
    assert np.array_equal(turned.inside(x, y), expected), "whichever way rings turn"


def test_shares_of_samples_are_areas():
    rings = [np.array(ring(50.3, 40.2, 30.0, 25.0, 300, 0.2)), np.array(ring(45.0, 40.0, 5.0, 8.0, 50))]
    area = Polygons([tuple(rings)])
    share = area.shares(area.edges[:, 0::2], 99.0 - area.edges[:, 1::2], 100, 120)[::-1]  # rows go south
    # Finer samples by asking each.
    step = (np.arange(8) + 0.5) / 8.0 - 0.5
    x, y = np.meshgrid((np.arange(120)[:, None] + step).ravel(), (np.arange(100)[:, None] + step).ravel())
    asked = area.inside(x.ravel(), y.ravel()).reshape(100, 8, 120, 8).mean(axis=(1, 3))
    assert np.abs(share - asked).max() < 0.2 and abs(share.sum() / asked.sum() - 1.0) < 1e-3


def test_across_the_date_line_and_around_a_pole(tmp_path):
    cut = {"type": "MultiPolygon", "coordinates": [
        [[[179.0, 10.0], [180.0, 10.0], [180.0, 12.0], [179.0, 12.0], [179.0, 10.0]]],
        [[[-180.0, 10.0], [-179.0, 10.0], [-179.0, 12.0], [-180.0, 12.0], [-180.0, 10.0]]],
    ]}  # fmt: skip
    uncut = polygon([[179.0, 20.0], [-179.0, 20.0], [-179.0, 22.0], [179.0, 22.0], [179.0, 20.0]])
    cap = polygon([[-180.0, 80.0], [180.0, 80.0], [180.0, 90.0], [-180.0, 90.0], [-180.0, 80.0]])
    path = write_map(tmp_path / "a.geojson", *(feature(each, natural="wood") for each in (cut, uncut, cap)))
    areas = [Polygons(patch.polygons) for patch in vector_map(path).forests]
    x = np.array([178.9, 179.5, 180.0, -179.5, -178.9, 0.0])
    inside = [False, True, True, True, False, False]
    assert areas[0].inside(x, np.full(6, 11.0)).tolist() == inside
    assert areas[1].inside(x, np.full(6, 21.0)).tolist() == inside
    assert areas[2].inside(x, np.full(6, 85.0)).all() and not areas[2].inside(x, np.full(6, 79.0)).any()


def test_ten_thousand_vertices_take_less_than_a_second(tmp_path):
    path = write_map(tmp_path / "a.geojson", feature(polygon(ring(7.0, 46.0, 0.1, 0.1, 10_000, 0.3)), natural="wood"))
    rng = np.random.default_rng(1)
    x, y = rng.uniform(6.8, 7.2, 20_000), rng.uniform(45.8, 46.2, 20_000)
    begin = time.process_time()
    area = Polygons(vector_map(path).forests[0].polygons)
    assert 0.1 < area.inside(x, y).mean() < 0.9
    assert time.process_time() - begin < 1.0
