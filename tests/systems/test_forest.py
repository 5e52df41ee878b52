"""The selection of tiles: no hole, no overlap, both sides of an edge alike, whatever is known."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.benchmarks.measure.selection import MadeGround, make_tiles, settle
from planetfall.engine.surface.forest import Forest, Selection
from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.keys import container_of, first_inside, last_inside, level_of
from planetfall.engine.surface.scheme import QuadScheme, Scheme

SCHEMES: list[Scheme] = [QuadScheme(), TriangleScheme()]
PIXEL_RAD = np.radians(60.0) / 1080


@pytest.fixture(params=SCHEMES, ids=lambda s: s.name)
def ground(request: pytest.FixtureRequest) -> MadeGround:
    return MadeGround(request.param)


def place(ground: MadeGround, altitude_m: float, direction=(0.3, -0.5, 0.8)) -> np.ndarray:
    up = np.asarray(direction, dtype=np.float64)
    up = up / np.linalg.norm(up)
    return up * (ground.radius_m + ground.height(up[None])[0] + altitude_m)


def check_cover(forest: Forest) -> None:
    """Leaves cover every direction once: as intervals of keys they fill those of the roots without gap or overlap."""
    leaves = forest.leaves()
    roots = np.sort(forest.scheme.root_keys())
    assert (last_inside(leaves)[:-1] < first_inside(leaves)[1:]).all()
    share = 4.0 ** -level_of(leaves).astype(np.float64)
    at = container_of(leaves, roots)
    np.testing.assert_array_equal(np.bincount(at, weights=share, minlength=len(roots)), 1.0)


def check_edges(forest: Forest, selection: Selection) -> None:
    """Brute force: what lies across an edge, and that both sides say the same."""
    leaves = set(forest.leaves().tolist())
    scheme = forest.scheme
    row = {key: n for n, key in enumerate(selection.keys.tolist())}
    for n, key in enumerate(selection.keys.tolist()):
        for edge in range(scheme.edges):
            beside = int(scheme.neighbour(np.int64(key), edge))
            skip, up = 0, beside
            while up and up not in leaves:
                up, skip = int(scheme.parent(up)), skip + 1
            assert selection.edge_skip[n, edge] == (skip if up else 0)
            if up == beside and beside in row:
                back = [e for e in range(scheme.edges) if int(scheme.neighbour(np.int64(beside), e)) == key]
                both = {float(selection.edge_morph[n, edge]), float(selection.edge_morph[row[beside], back[0]])}
                assert both == {float(max(selection.morph[n], selection.morph[row[beside]]))}
            elif up != beside:
                assert selection.edge_morph[n, edge] == 0.0


@pytest.mark.parametrize("altitude_m", (2.0, 1e4, 1e6))
def test_settled(ground: MadeGround, altitude_m: float):
    forest = ground.forest()
    selection = settle(forest, ground, lambda: forest.select(place(ground, altitude_m), PIXEL_RAD, 1.0))
    assert not selection.moving and not len(selection.wanted)
    assert (np.diff(selection.distance_m) >= 0.0).all()
    assert selection.edge_skip.max() <= 1
    check_cover(forest)
    check_edges(forest, selection)
    again = forest.select(place(ground, altitude_m), PIXEL_RAD, 1.0)
    assert again.revision == selection.revision


def test_every_direction_is_in_one_tile_while_tiles_arrive(ground: MadeGround):
    rng = np.random.default_rng(4)
    forest = ground.forest()
    directions = rng.normal(size=(2000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    make_tiles(forest, ground, ground.scheme.root_keys(), 1000)
    points = ground.scheme.at(directions, 26)
    for frame in range(60):
        selection = forest.select(place(ground, 300.0 - 4.0 * frame), PIXEL_RAD, 1.0, frame / 60)
        check_cover(forest)
        assert (container_of(points, forest.leaves()) >= 0).all()
        assert selection.edge_skip.max() <= 1
        # Tiles arrive late, in any order, and some are lost.
        wanted = selection.wanted[rng.random(len(selection.wanted)) < 0.3]
        make_tiles(forest, ground, wanted, 1000)
        known = forest.leaves()
        lost = known[(rng.random(len(known)) < 0.02) & (level_of(known) > 0)]
        forest.forget(lost)
        check_edges(forest, forest.select(place(ground, 300.0 - 4.0 * frame), PIXEL_RAD, 1.0, frame / 60))


def test_bad_input():
    ground = MadeGround(QuadScheme())
    forest = ground.forest()
    with pytest.raises(ValueError, match="eye_m"):
        forest.select((0.0, 0.0, 0.0), PIXEL_RAD, 1.0)
    with pytest.raises(ValueError, match="eye_m"):
        forest.select((np.nan, 0.0, 0.0), PIXEL_RAD, 1.0)
    with pytest.raises(ValueError, match="error_px"):
        forest.select((7e6, 0.0, 0.0), PIXEL_RAD, 0.0)
    with pytest.raises(ValueError, match="low_m"):
        forest.set_facts(ground.scheme.root_keys(), 1.0, 0.0, 1.0)
    with pytest.raises(ValueError, match="metric"):
        Forest(QuadScheme(), 1e6, 0.0, 1.0, metric="distance")
