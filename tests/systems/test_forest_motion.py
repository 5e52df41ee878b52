"""The selection of tiles in motion: nothing jumps, nothing flips to and fro, limits are kept, rest is a function of the
camera."""

from __future__ import annotations

import numpy as np
import pytest
from test_forest import check_cover, check_edges

from planetfall.benchmarks.measure.selection import PIXEL_RAD, MadeGround, above, make_tiles, settle
from planetfall.engine.surface.forest import MORPH_STEPS, Selection
from planetfall.engine.surface.hulls import visible_share
from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.keys import container_of, level_of, parent_of
from planetfall.engine.surface.refinement import MORPH_S
from planetfall.engine.surface.scheme import QuadScheme, Scheme

SCHEMES: list[Scheme] = [QuadScheme(), TriangleScheme()]
FRAME_S = 1.0 / 60.0
UP = np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)
ASIDE = np.cross(UP, [0.0, 0.0, 1.0])


@pytest.fixture(params=SCHEMES, ids=lambda s: s.name)
def ground(request: pytest.FixtureRequest) -> MadeGround:
    return MadeGround(request.param)


def edge_levels(scheme: Scheme, selection: Selection) -> dict[tuple[int, int], float]:
    """The level that each edge between two cells looks like: finer by one is twice as many vertices."""
    beside = scheme.neighbour(selection.keys[:, None], np.arange(scheme.edges))
    shown = selection.levels[:, None] - selection.edge_skip.astype(float) - selection.edge_morph
    keys = np.broadcast_to(selection.keys[:, None], beside.shape)
    pairs = zip(keys.ravel().tolist(), beside.ravel().tolist(), shown.ravel().tolist(), strict=True)
    return {(key, other): level for key, other, level in pairs}


def jump(before: dict[tuple[int, int], float], after: dict[tuple[int, int], float]) -> float:
    """The largest change of an edge's look; an edge of a split tile is compared with those of its children."""
    worst = 0.0
    for old, new in ((before, after), (after, before)):
        for (key, other), level in new.items():
            upper = (int(parent_of(np.int64(key))), int(parent_of(np.int64(other))))
            if (key, other) in old:
                worst = max(worst, abs(level - old[key, other]))
            elif upper[0] != upper[1] and upper in old:
                worst = max(worst, abs(level - old[upper]))
    return worst


def test_nothing_jumps_in_slow_flight(ground: MadeGround):
    forest = ground.forest()
    eye = above(ground, 400.0, UP)
    before = settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, 0.5))
    last, tiles, structure = edge_levels(ground.scheme, before), before, 0
    # The path goes down and sideways by half a percent of the altitude a frame.
    for frame in range(1, 240):
        eye = above(ground, 400.0 * 0.995**frame, UP) + 1.5 * frame * ASIDE
        selection = forest.select(eye, PIXEL_RAD, 0.5, frame * FRAME_S)
        make_tiles(forest, ground, selection.wanted, 1 << 20)
        if frame > 1:
            limit = FRAME_S / MORPH_S + 1.0 / MORPH_STEPS + 1e-6
            now = edge_levels(ground.scheme, selection)
            assert jump(last, now) <= limit
            old = dict(zip(tiles.keys.tolist(), tiles.morph.tolist(), strict=True))
            for key, morph in zip(selection.keys.tolist(), selection.morph.tolist(), strict=True):
                if key in old:
                    assert abs(morph - old[key]) <= limit
            structure += len(set(selection.keys.tolist()) ^ set(tiles.keys.tolist())) > 0
        last, tiles = edge_levels(ground.scheme, selection), selection
    assert structure > 20


def test_a_camera_that_swings_on_a_threshold_changes_no_tiles(ground: MadeGround):
    forest = ground.forest()
    settle(forest, ground, lambda: forest.select(above(ground, 500.0, UP), PIXEL_RAD, 1.0))
    leaves = []
    for frame in range(200):
        eye = above(ground, 500.0 * (1.0 + 0.02 * np.sin(0.4 * frame)), UP)
        selection = forest.select(eye, PIXEL_RAD, 1.0, frame * FRAME_S)
        make_tiles(forest, ground, selection.wanted, 1 << 20)
        leaves.append(forest.leaves())
    assert all(np.array_equal(a, leaves[-1]) for a in leaves[100:])


def test_rest_is_a_function_of_the_camera(ground: MadeGround):
    rng = np.random.default_rng(12)
    eye = above(ground, 120.0, UP)
    forest = ground.forest()
    fresh = settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, 1.0))
    for _ in range(3):
        travelled = ground.forest()
        clock = 0.0
        for k in range(40):
            way = eye + (39 - k) * rng.normal(size=3) * 20.0
            selection = travelled.select(way, PIXEL_RAD, 1.0, clock)
            make_tiles(travelled, ground, selection.wanted, 1 << 20)
            clock += FRAME_S
        arrived = None
        for _ in range(200):
            selection = travelled.select(eye, PIXEL_RAD, 1.0, clock)
            if make_tiles(travelled, ground, selection.wanted, 1 << 20):
                arrived = clock
            clock += FRAME_S
            if arrived is not None and clock > arrived + 0.3 + 2 * FRAME_S:
                break
        # 0.3 s after the last tile came
        assert not selection.moving
        for name in ("keys", "morph", "edge_skip", "edge_morph"):
            np.testing.assert_array_equal(getattr(selection, name), getattr(fresh, name))


def test_little_ways_change_nothing(ground: MadeGround):
    forest = ground.forest()
    eye = above(ground, 100.0, UP)
    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, 1.0))
    first = forest.select(eye, PIXEL_RAD, 1.0, 0.0)
    before = forest.evaluations
    for k in range(20):
        assert forest.select(eye + 1e-3 * k * ASIDE, PIXEL_RAD, 1.0, k * FRAME_S) is first
    assert forest.evaluations == before
    assert forest.select(eye + 10.0 * ASIDE, PIXEL_RAD, 1.0, 1.0) is not first


@pytest.mark.parametrize("most", (40, 150, 300))
def test_the_budget_is_kept(ground: MadeGround, most: int):
    forest = ground.forest()
    errors = []
    for frame in range(120):
        selection = forest.select(
            above(ground, 40.0 * 1.01**frame, UP), PIXEL_RAD, 0.3, frame * FRAME_S, max_tiles=most
        )
        make_tiles(forest, ground, selection.wanted, 2 * most)
        assert len(forest.leaves()) <= most
        errors.append(selection.error_px)
        assert len(forest.table) <= 2 * most
    check_cover(forest)
    # Smaller when there is less to draw; and with enough tiles what is asked for.
    assert errors[-1] > 0.3
    free = ground.forest()
    assert settle(free, ground, lambda: free.select(above(ground, 40.0, UP), PIXEL_RAD, 0.3)).error_px == 0.3


def test_more_tiles_less_error(ground: MadeGround):
    errors = []
    for most in (60, 120, 240, 480):
        forest = ground.forest()
        eye = above(ground, 20.0, UP)
        selection = settle(forest, ground, lambda f=forest, e=eye, m=most: f.select(e, PIXEL_RAD, 0.3, max_tiles=m))
        assert len(forest.leaves()) > 0.7 * most
        errors.append(selection.error_px)
    assert (np.diff(errors) < 0.0).all()


def test_a_thousand_teleports(ground: MadeGround):
    rng = np.random.default_rng(13)
    forest = ground.forest()
    make_tiles(forest, ground, ground.scheme.root_keys(), 300)
    points = rng.normal(size=(50, 3))
    points = ground.scheme.at(points / np.linalg.norm(points, axis=1, keepdims=True), 24)
    up = UP
    for frame in range(1000):
        up = -up + 0.3 * rng.normal(size=3)
        up /= np.linalg.norm(up)
        eye = above(ground, 10.0 ** rng.uniform(0.0, 6.0), up)
        selection = forest.select(eye, PIXEL_RAD, 1.0, frame * FRAME_S, max_tiles=200)
        make_tiles(forest, ground, selection.wanted[:20], 300)
        assert len(forest.table) <= 300 and len(forest.table.known) <= 600
        assert len(forest.leaves()) <= 200 and len(selection)
        if frame % 50 == 0:
            check_cover(forest)
            assert (container_of(points, forest.leaves()) >= 0).all()
    # What is kept are the roots and what the last frames had use for.
    eye = above(ground, 50.0, UP)
    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, 1.0, max_tiles=200), slots=300)
    assert forest.knows(ground.scheme.root_keys()).all()


def test_what_may_be_dropped(ground: MadeGround):
    forest = ground.forest()
    settle(forest, ground, lambda: forest.select(above(ground, 100.0, UP), PIXEL_RAD, 1.0))
    there = forest.leaves()
    settle(forest, ground, lambda: forest.select(above(ground, 100.0, -UP), PIXEL_RAD, 1.0))
    spare = forest.droppable(10_000)
    assert len(spare) > 100
    assert not np.isin(spare, forest.leaves()).any()
    assert not np.isin(spare, ground.scheme.root_keys()).any()
    # The ancestors of what is drawn are of use.
    above_drawn = parent_of(forest.leaves())
    assert not np.isin(spare, above_drawn).any()
    far = there[level_of(there) > 6]
    assert np.isin(far, spare).all()
    forest.forget(spare)
    check_cover(forest)
    selection = forest.select(above(ground, 100.0, -UP), PIXEL_RAD, 1.0)
    assert not len(selection.wanted)
    # A node goes before its parent does.
    place = {key: n for n, key in enumerate(spare.tolist())}
    for key, n in place.items():
        assert place.get(int(parent_of(np.int64(key))), len(spare)) > n


def test_tiles_ahead_come_before_they_are_needed(ground: MadeGround):
    velocity = 300.0 * ASIDE / np.linalg.norm(ASIDE)
    late = []
    for told in (None, velocity):
        forest = ground.forest()
        eye = above(ground, 200.0, UP)
        settle(forest, ground, lambda f=forest, e=eye: f.select(e, PIXEL_RAD, 0.5))
        lacking = 0
        for frame in range(120):
            selection = forest.select(
                eye + frame * FRAME_S * velocity, PIXEL_RAD, 0.5, frame * FRAME_S, velocity_m_s=told
            )
            # Wanted ones whose parent is too coarse now, not soon: that has them first.
            lacking += forest.lacking
            make_tiles(forest, ground, selection.wanted[:8], 1 << 20)
        late.append(lacking)
    assert late[1] < 0.5 * late[0]


@pytest.mark.parametrize("balanced", (True, False))
def test_edges_with_any_tiles_missing(ground: MadeGround, balanced: bool):
    rng = np.random.default_rng(14)
    worst = 0
    for _ in range(6):
        forest = ground.forest(balanced=balanced)
        make_tiles(forest, ground, ground.scheme.root_keys(), 1 << 20)
        for frame in range(12):
            eye = above(ground, 10.0 ** rng.uniform(1.0, 5.0), UP + 0.01 * rng.normal(size=3))
            selection = forest.select(eye, PIXEL_RAD, 2.0, frame * FRAME_S)
            make_tiles(forest, ground, selection.wanted[rng.random(len(selection.wanted)) < 0.5], 1 << 20)
        check_edges(forest, selection)
        check_cover(forest)
        worst = max(worst, int(selection.edge_skip.max()))
    assert worst == 1 if balanced else worst > 1


def test_split_by_distance(ground: MadeGround):
    distances = 1e7 * 2.0 ** -np.arange(12.0)
    forest = ground.forest(metric="distance", split_distance_m=distances, balanced=False)
    eye = above(ground, 2e4, UP)
    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, 1.0))
    table = forest.table
    for split in (True, False):
        rows = np.flatnonzero(table.known & (table.split == split) & table.split[table.supports[:, 0]])
        distance = forest.hulls.distance(eye)
        seen = (visible_share(distance, eye, forest.hulls, ground.radius_m - ground.relief_m) == 1.0)[rows]
        distance = distance[rows]
        # Hidden ones and those beyond the table stay whole; the fade of the horizon is 15 %.
        near = (distance < distances[np.minimum(table.level[rows], 11)]) & (table.level[rows] < 12)
        assert (near == split)[seen].all()
