"""The icosphere's lattice: integers, exactness, neighbours across all edges, a partition of the sphere."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.icosphere import (
    ACROSS_EDGE,
    ACROSS_ROOT,
    CORNERS,
    EDGE_OVER_HEIGHT,
    FULL,
    ROOT_VECTORS,
    ROOTS,
    TriangleScheme,
    direction_of,
    locate,
    snap,
    vector_of,
)

SCHEME = TriangleScheme()


def random_points(count: int, seed: int):
    rng = np.random.default_rng(seed)
    b = rng.integers(0, FULL + 1, count)
    c = rng.integers(0, FULL + 1, count)
    over = b + c > FULL
    return rng.integers(0, 20, count), np.where(over, FULL - b, b), np.where(over, FULL - c, c)


def test_the_solid_is_regular():
    assert len(ROOTS) == 20 and len(np.unique(ROOTS)) == 12
    assert (np.bincount(ROOTS.ravel()) == 5).all()
    vectors = ROOT_VECTORS.astype(float)
    edges = np.linalg.norm(vectors - vectors[:, [1, 2, 0]], axis=2)
    assert np.ptp(edges) / edges.mean() < 1e-12
    assert (np.linalg.det(vectors) > 0).all()
    assert ACROSS_ROOT[ACROSS_ROOT, ACROSS_EDGE].tolist() == np.repeat(np.arange(20), 3).reshape(20, 3).tolist()


def test_vectors_are_exact_in_float64():
    root, b, c = random_points(20000, 1)
    v = vector_of(root, b, c)
    np.testing.assert_array_equal(v.astype(np.float64).astype(np.int64), v)
    weights = np.stack([FULL - b - c, b, c], axis=-1)
    terms = weights[..., None].astype(np.float64) * ROOT_VECTORS[root].astype(np.float64)
    for order in ([0, 1, 2], [2, 0, 1], [1, 2, 0]):
        np.testing.assert_array_equal((terms[:, order[0]] + terms[:, order[1]]) + terms[:, order[2]], v)


def test_locate_inverts_direction():
    root, b, c = random_points(5000, 2)
    inside = (b > 0) & (c > 0) & (b + c < FULL)
    root, b, c = root[inside], b[inside], c[inside]
    directions = direction_of(root, b, c)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=3e-16)
    found, fb, fc = locate(directions * np.random.default_rng(3).uniform(1e-3, 1e9, (len(b), 1)))
    np.testing.assert_array_equal(found, root)
    np.testing.assert_allclose(fb, b, atol=1e-6)
    np.testing.assert_allclose(fc, c, atol=1e-6)
    for got, wanted in zip(snap(directions), (root, b, c), strict=True):
        np.testing.assert_array_equal(got, wanted)


@pytest.mark.parametrize("direction", [*np.eye(3), *-np.eye(3), *CORNERS.astype(float), *ROOT_VECTORS.sum(axis=1)])
def test_special_directions_are_found(direction):
    root, b, c = locate(np.asarray(direction, float))
    assert b >= 0 and c >= 0 and b + c <= FULL
    back = direction_of(*snap(direction))
    assert np.linalg.norm(back - direction / np.linalg.norm(direction)) < 1.3 / FULL
    for level in (0, 1, 9, 26):
        key = SCHEME.at(direction, level)
        assert SCHEME.level(key) == level and SCHEME.unpack(key)[0] == root
        np.testing.assert_array_equal(SCHEME.pack(*SCHEME.unpack(key)), key)


def test_edges_meet_in_opposite_directions():
    for level in (0, 1, 2, 3):
        keys = SCHEME.root_keys()
        for _ in range(level):
            keys = SCHEME.children(keys).ravel()
        root, b, c = SCHEME.corner_points(keys)
        own = vector_of(root[:, None], b, c)
        for edge in range(3):
            beside, other = SCHEME.across(keys, edge)
            their_root, their_b, their_c = SCHEME.corner_points(beside)
            theirs = vector_of(their_root[:, None], their_b, their_c)
            rows = np.arange(len(keys))
            np.testing.assert_array_equal(own[:, edge], theirs[rows, (other + 1) % 3])
            np.testing.assert_array_equal(own[:, (edge + 1) % 3], theirs[rows, other])


def test_cells_are_a_partition():
    """Exact volumes of the cones over all cells of a level add up to those of the roots: no gap, no overlap."""
    for level in (1, 3):
        keys = SCHEME.root_keys()
        for _ in range(level):
            keys = SCHEME.children(keys).ravel()
        root, b, c = SCHEME.corner_points(keys)
        side = FULL >> level
        det = (b[:, 1] - b[:, 0]) * (c[:, 2] - c[:, 0]) - (b[:, 2] - b[:, 0]) * (c[:, 1] - c[:, 0])
        assert (det == side * side).all()  # upright and inverted, all counter-clockwise
        assert (np.bincount(root) == 4**level).all()
        assert len(np.unique(np.stack([root, b.sum(axis=1), c.sum(axis=1)]), axis=1).T) == len(keys)


def test_children_fill_their_parent():
    rng = np.random.default_rng(6)
    keys = SCHEME.at(rng.normal(size=(200, 3)), 11)
    _, b, c = SCHEME.corner_points(keys)
    _, kb, kc = SCHEME.corner_points(SCHEME.children(keys).ravel())
    kb, kc = kb.reshape(-1, 4, 3), kc.reshape(-1, 4, 3)
    for child in range(3):
        np.testing.assert_array_equal(kb[:, child, child], b[:, child])
        np.testing.assert_array_equal(kc[:, child, child], c[:, child])
    # The middle child's corners are the middles of the edges; corner e lies opposite to the parent's corner e.
    for corner in range(3):
        ends = [(corner + 1) % 3, (corner + 2) % 3]
        np.testing.assert_array_equal(2 * kb[:, 3, corner], b[:, ends].sum(axis=1))
        np.testing.assert_array_equal(2 * kc[:, 3, corner], c[:, ends].sum(axis=1))


def test_distortion_is_what_is_said():
    level = 6
    keys = SCHEME.root_keys()
    for _ in range(level):
        keys = SCHEME.children(keys).ravel()
    corners = SCHEME.corners(keys)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1) / 2
    edges = np.linalg.norm(corners - corners[:, [1, 2, 0]], axis=2)
    assert area.max() / area.min() == pytest.approx(1.98, abs=0.06)
    assert area.sum() == pytest.approx(4 * np.pi, rel=1e-3)
    longest = SCHEME.spacing_rad(level, 1)
    assert 0.999 * longest < edges.max() <= longest
    assert edges.min() / longest == pytest.approx(0.678, abs=0.01)
    assert pytest.approx(1.3232, abs=1e-4) == EDGE_OVER_HEIGHT
