"""The icosphere as printed: its tables, the recursion, and what it loses."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from planetfall.benchmarks.measure.icosphere_paper import gap_between_levels_m, printed_culling
from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.keys import container_of
from planetfall.engine.surface.triangle_paper import (
    CONTAINED,
    EDGE,
    OUTSIDE,
    hidden,
    select,
    tables,
    volume_state,
)

DATA = Path(__file__).parents[1] / "data" / "terrain_cull_triangles.csv"
RADIUS_M = 6.371e6
SCHEME = TriangleScheme()


def planes_of(forward, up, tan_x, tan_y) -> np.ndarray:
    right = np.cross(forward, up)
    return np.array([right + forward * tan_x, forward * tan_x - right, up + forward * tan_y, forward * tan_y - up])


def test_tables_are_the_printed_ones():
    table = tables(RADIUS_M, 8848.0, np.radians(60.0), 1920, 8.0, 16, 12)
    # A segment of a level is 8 pixels wide, in the middle of the picture, where its triangle is split.
    angle = np.arctan(EDGE * RADIUS_M / 16 / table.split_m[0])
    assert angle == pytest.approx(8.0 * np.radians(60.0) / 1920, rel=1e-12)
    small = tables(RADIUS_M, 8848.0, np.radians(90.0), 100, 8.0, 32, 3)
    assert small.split_m[1] == pytest.approx(1.25 * EDGE * RADIUS_M)  # two and a half edges of level 1
    np.testing.assert_allclose(table.split_m[1:], table.split_m[:-1] / 2, rtol=1e-15)
    over = np.arccos(RADIUS_M / (RADIUS_M + 8848.0))
    assert table.dot[0] == pytest.approx(0.5 + np.sin(over))
    np.testing.assert_allclose(np.arcsin(table.dot[1:]) - over, np.radians(60.0) / 2.0 ** np.arange(1, 13), rtol=1e-9)
    # 37.4 degrees from corner to middle, about half of it a level further down.
    assert table.height[0] - 8848.0 / RADIUS_M == pytest.approx(1.0 / np.cos(np.radians(37.377)), abs=1e-4)
    assert (np.diff(table.height) < 0).all()
    assert table.height[-1] - 1.0 == pytest.approx(8848.0 / RADIUS_M, rel=1e-3)
    with pytest.raises(ValueError, match="between 0 and 90"):
        tables(RADIUS_M, 0.0, 3.0, 4, 8.0, 16, 4)


def test_the_recursion_is_a_partition_of_what_it_keeps():
    zenith = np.array([0.3, -0.5, 0.7]) / np.linalg.norm([0.3, -0.5, 0.7])
    camera = zenith * (RADIUS_M + 3000.0)
    forward = np.cross(zenith, [0, 0, 1.0])
    forward /= np.linalg.norm(forward)
    planes = planes_of(forward, zenith, 0.8, 0.5)
    table = tables(RADIUS_M, 9000.0, np.radians(77.0), 640, 8.0, 16, 20)
    found = select(SCHEME, table, RADIUS_M, camera, planes, 20)
    assert len(np.unique(found.keys)) == len(found.keys) and found.untested > 0 and found.dropped > 0
    leaves = np.sort(found.keys)
    np.testing.assert_array_equal(container_of(leaves, leaves), np.arange(len(leaves)))  # none inside another
    # Every leaf is far enough away, and its parent was not; nothing that is kept is outside of the view as printed.
    away = np.linalg.norm(SCHEME.corners(found.keys).mean(axis=1) * RADIUS_M - camera, axis=1)
    assert (away[found.levels < 20] >= table.split_m[found.levels[found.levels < 20]]).all()
    inner = found.levels > 0
    above = SCHEME.corners(SCHEME.parent(found.keys[inner])).mean(axis=1) * RADIUS_M
    assert (np.linalg.norm(above - camera, axis=1) < table.split_m[found.levels[inner] - 1]).all()


def test_the_three_states():
    table = tables(RADIUS_M, 0.0, 1.0, 1000, 8.0, 16, 8)
    key = SCHEME.at(np.array([1.0, 0.0, 0.0]), 6)[None]
    corners = SCHEME.corners(key) * RADIUS_M
    camera = np.array([RADIUS_M * 2.0, 0.0, 0.0])
    down = planes_of(np.array([-1.0, 0, 0]), np.array([0, 0, 1.0]), 0.5, 0.5)
    away = planes_of(np.array([0.0, 1, 0]), np.array([0, 0, 1.0]), 0.5, 0.5)
    assert volume_state(corners, [6], camera, down, table)[0] == CONTAINED
    assert volume_state(corners, [6], camera, away, table)[0] == OUTSIDE


@pytest.mark.parametrize(("lowest", "seen"), [(True, (0.0, 0.0)), (False, (0.01, 0.08))])
def test_the_printed_culling_on_ground_above_its_sphere_and_below_it(lowest, seen):
    """Independent cases with dense sampling. The source's heights begin at 0: nothing that is seen is dropped from the
    sphere of the lowest ground, a few per cent from one that ground lies below."""
    with DATA.open() as file:
        rows = list(csv.DictReader(file))
    dropped = visible = kept_out = 0
    for row in rows:
        value = {k: float(v) for k, v in row.items() if k not in ("look", "path")}
        at = [np.array([value[f"{name}_{k}"] for k in "xyz"]) for name in ("cam", "fwd", "up")]
        base_m = value["radius_m"] - lowest * value["amp_m"]
        corners = np.array([[[value[f"{corner}{k}"] for k in "xyz"] for corner in "abc"]]) * base_m
        high = np.tan(value["fovy_rad"] / 2)
        wide = high * value["aspect"]
        level, relief_m = int(value["level"]), (1 + lowest) * value["amp_m"]
        table = tables(base_m, relief_m, 2 * np.arctan(wide), 1920, 6.0, 16, level)
        gone = bool(hidden(corners, [level], at[0], planes_of(at[1], at[2], wide, high), table)[0])
        visible += value["visible"] > 0
        dropped += gone and value["visible"] > 0
        kept_out += gone and value["visible"] == 0
    assert seen[0] <= dropped / visible <= seen[1]
    assert kept_out / (len(rows) - visible) > 0.75
    found = printed_culling(np.random.default_rng(1), 1500, sphere_m=None if lowest else 0.0)
    assert found.visible > 150 and (found.visible_dropped > 0) == (not lowest)
    assert found.visible_dropped < 0.15 * found.visible
    assert found.invisible_dropped > 0.6 * found.invisible


def test_a_border_has_its_vertices_where_the_other_side_has_them():
    """A triangle's vertices at a finer neighbour's border don't morph yet, at a coarser one's they have morphed: that
    is so if neighbours differ by a level at most, and the ranges of distance keep to how far vertices reach."""
    rng = np.random.default_rng(5)
    table = tables(RADIUS_M, 18_000.0, np.radians(90.0), 100, 8.0, 32, 20)  # the nearest that anything is split
    begin, end = table.morph_m.T
    assert (begin < end).all()
    planes = np.zeros((4, 3))  # everything is in view
    for _ in range(4):
        zenith = rng.normal(size=3)
        zenith /= np.linalg.norm(zenith)
        ground_m = rng.uniform(0.0, 18_000.0)
        camera = zenith * (RADIUS_M + ground_m + 10.0 ** rng.uniform(0.0, 6.0))
        leaves = np.sort(select(SCHEME, table, RADIUS_M, camera, planes, 12, ground_m).keys)
        level = SCHEME.level(leaves)
        corners = SCHEME.corners(leaves) * (RADIUS_M + ground_m)
        for edge in range(3):
            at = container_of(SCHEME.neighbour(leaves, edge), leaves)
            coarser = (at >= 0) & (level[at] < level)
            assert (level[coarser] - level[at[coarser]] == 1).all() and coarser.any()
            line = np.linspace(0.0, 1.0, 9)[:, None, None]
            a, b = corners[coarser, edge], corners[coarser, (edge + 1) % 3]
            points = a + (b - a) * line
            points *= np.linalg.norm(a, axis=1)[:, None] / np.linalg.norm(points, axis=2, keepdims=True)
            away = np.linalg.norm(points - camera, axis=2)
            assert (away >= end[level[coarser]]).all()
            assert (away <= begin[level[coarser] - 1]).all()


def test_printed_levels_do_not_meet():
    edge, worst = gap_between_levels_m(RADIUS_M, 4)
    assert edge == pytest.approx(33.0, abs=1.0)  # what others measured of the source's own program
    assert 1.5 * edge < worst < 2.0 * edge
    # A chord is off by the third power of its length.
    assert gap_between_levels_m(RADIUS_M, 5)[1] == pytest.approx(worst / 8, rel=0.05)
