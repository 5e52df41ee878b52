"""Keys of tree nodes, and that the schemes cut the sphere into cells that meet edge to edge."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.keys import (
    MAX_LEVEL,
    NO_NODE,
    ancestor_of,
    container_of,
    first_inside,
    last_inside,
    level_of,
    pack_path,
    path_of,
    root_of,
)
from planetfall.engine.surface.scheme import QuadScheme, Scheme

SCHEMES: list[Scheme] = [QuadScheme(), TriangleScheme()]
LEVELS = (0, 1, 2, 5, 13, 26)


def random_keys(scheme: Scheme, level: int, rng: np.random.Generator, count: int = 300) -> np.ndarray:
    directions = rng.normal(size=(count, 3))
    return scheme.at(directions / np.linalg.norm(directions, axis=1, keepdims=True), level)


@pytest.fixture(params=SCHEMES, ids=lambda s: s.name)
def scheme(request: pytest.FixtureRequest) -> Scheme:
    return request.param


def test_keys_hold_what_they_were_made_of():
    rng = np.random.default_rng(1)
    for level in (0, 1, 7, MAX_LEVEL):
        root, path = rng.integers(0, 32, 100), rng.integers(0, 4**level, 100)
        keys = pack_path(root, level, path)
        assert keys.min() > NO_NODE
        np.testing.assert_array_equal(root_of(keys), root)
        np.testing.assert_array_equal(level_of(keys), level)
        np.testing.assert_array_equal(path_of(keys), path)


@pytest.mark.parametrize("level", LEVELS)
def test_parents_and_children(scheme: Scheme, level: int):
    keys = random_keys(scheme, level, np.random.default_rng(level))
    children = scheme.children(keys)
    np.testing.assert_array_equal(scheme.parent(children), np.broadcast_to(keys[:, None], children.shape))
    np.testing.assert_array_equal(scheme.child_number(children), np.broadcast_to(np.arange(4), children.shape))
    np.testing.assert_array_equal(scheme.level(children), level + 1)
    np.testing.assert_array_equal(ancestor_of(children[:, 0], level), keys)
    assert (first_inside(keys) <= children[:, 0]).all() and (children[:, 3] <= last_inside(keys)).all()
    if not level:
        assert (scheme.parent(keys) == NO_NODE).all()


@pytest.mark.parametrize("level", LEVELS)
def test_names_come_back(scheme: Scheme, level: int):
    keys = random_keys(scheme, level, np.random.default_rng(level))
    np.testing.assert_array_equal(scheme.pack(*scheme.unpack(keys)), keys)
    np.testing.assert_array_equal(scheme.at(scheme.center(keys), level), keys)


@pytest.mark.parametrize("level", LEVELS)
def test_neighbours_share_an_edge_to_the_bit(scheme: Scheme, level: int):
    keys = random_keys(scheme, level, np.random.default_rng(level))
    if not level:
        keys = scheme.root_keys()
    around = scheme.neighbour(keys[:, None], np.arange(scheme.edges))
    assert len(np.unique(np.append(around[0], keys[0]))) == scheme.edges + 1
    back = scheme.neighbour(around[:, :, None], np.arange(scheme.edges))
    assert (back == keys[:, None, None]).sum(axis=2).min() == 1
    own, theirs = scheme.corners(keys), scheme.corners(around.ravel()).reshape(*around.shape, scheme.edges, 3)
    for edge, ends in enumerate(scheme.edge_corners):
        for end in ends:
            same = (own[:, None, end] == theirs[:, edge]).all(axis=-1)
            assert (same.sum(axis=1) == 1).all()


@pytest.mark.parametrize("level", (0, 1, 4, 12))
def test_children_lie_in_their_parent(scheme: Scheme, level: int):
    rng = np.random.default_rng(level)
    directions = rng.normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    np.testing.assert_array_equal(scheme.parent(scheme.at(directions, level + 1)), scheme.at(directions, level))


def test_corners_of_the_parent_are_corners_of_children(scheme: Scheme):
    keys = random_keys(scheme, 9, np.random.default_rng(3))
    own = scheme.corners(keys)
    inner = scheme.corners(scheme.children(keys).ravel()).reshape(len(keys), -1, 3)
    assert (own[:, :, None] == inner[:, None]).all(axis=-1).any(axis=2).all()


def test_vertices_are_no_farther_apart_than_said(scheme: Scheme):
    for level in (1, 3, 8):
        corners = scheme.corners(random_keys(scheme, level, np.random.default_rng(level), 2000))
        ends = corners[:, scheme.edge_corners]
        angle = 2.0 * np.arcsin(np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=-1) / 2.0)
        assert 0.7 * scheme.spacing_rad(level, 1) < angle.max() <= scheme.spacing_rad(level, 1) * (1 + 1e-12)


def test_containers_are_found():
    scheme = QuadScheme()
    leaves = np.sort(np.concatenate([scheme.root_keys()[1:], scheme.children(scheme.root_keys()[:1])[0]]))
    inside = scheme.children(scheme.children(leaves)).ravel()
    np.testing.assert_array_equal(container_of(inside, leaves), np.repeat(np.arange(9), 16))
    np.testing.assert_array_equal(container_of(leaves, leaves), np.arange(9))
    assert container_of(scheme.root_keys()[:1], leaves)[0] == -1
    assert container_of(leaves, leaves[:0])[0] == -1
