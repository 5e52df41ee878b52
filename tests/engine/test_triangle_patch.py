"""Triangular patches: numbering, triangles, the parent's vertices, edges between any levels at any morph."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from planetfall.engine.surface.icosphere import FULL, FULL_BITS, TriangleScheme, vector_of
from planetfall.engine.surface.triangle_patch import (
    along,
    assemble,
    collapsed,
    edge_of,
    even_vertices,
    on_edge,
    patch_indices,
    vertex_count,
    vertex_index,
    vertex_place,
)

SCHEME = TriangleScheme()
SIZES = (2, 8, 16, 64)


def points_of(key: int, segments: int) -> np.ndarray:
    """The integer vectors of a tile's vertices, straight from its corners."""
    root, b, c = SCHEME.corner_points(np.array([key]))
    p, q = vertex_place(np.arange(vertex_count(segments)), segments)
    weights = np.stack([segments - p - q, p, q], axis=-1)
    return vector_of(root, (weights @ b[0]) // segments, (weights @ c[0]) // segments)


def area(p, q, triangles) -> np.ndarray:
    """Twice the area of triangles in steps."""
    a, b, c = triangles.T
    return (p[b] - p[a]) * (q[c] - q[a]) - (p[c] - p[a]) * (q[b] - q[a])


@pytest.mark.parametrize("segments", SIZES)
def test_numbers_and_triangles(segments):
    k = np.arange(vertex_count(segments))
    p, q = vertex_place(k, segments)
    np.testing.assert_array_equal(vertex_index(p, q, segments), k)
    assert p.min() == q.min() == 0 and (p + q).max() == segments
    triangles = patch_indices(segments).astype(np.int64)
    assert len(triangles) == segments**2 and (area(p, q, triangles) == 1).all()
    sides = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert len(np.unique(sides, axis=0)) == len(sides)  # each side once in each direction
    lonely = {tuple(s) for s in sides.tolist()} - {tuple(s[::-1]) for s in sides.tolist()}
    assert len(lonely) == 3 * segments


@pytest.mark.parametrize("segments", SIZES)
def test_edges_run_from_corner_to_corner(segments):
    corners = [(0, 0), (segments, 0), (0, segments)]
    t = np.arange(segments + 1)
    for edge in range(3):
        p, q = on_edge(edge, t, segments)
        assert (p[0], q[0]) == corners[edge] and (p[-1], q[-1]) == corners[(edge + 1) % 3]
        np.testing.assert_array_equal(along(p, q, edge, segments), t)
        assert (edge_of(p, q, segments)[1:-1] == edge).all() and (edge_of(p, q, segments)[[0, -1]] == -1).all()


@pytest.mark.parametrize("segments", (4, 16))
def test_even_vertices_are_the_parents(segments):
    """Vertex by vertex through the integers of the lattice: even ones are the parent's own, the others lie in the
    middle of an edge of the parent's triangles."""
    rng = np.random.default_rng(1)
    k = np.arange(vertex_count(segments))
    inside = np.full_like(k, -1)
    parents = patch_indices(segments).astype(np.int64)
    for key in SCHEME.at(rng.normal(size=(8, 3)), 5):
        names = {tuple(v): n for n, v in enumerate(points_of(int(key), segments).tolist())}
        sides = {frozenset(s) for t in parents.tolist() for s in ((t[0], t[1]), (t[1], t[2]), (t[2], t[0]))}
        for child in SCHEME.children(key):
            own = points_of(int(child), segments)
            a, b = even_vertices(k, inside, 0, segments)
            for n in k:
                if a[n] == b[n]:
                    assert a[n] == n and tuple(own[n].tolist()) in names
                else:
                    assert tuple(own[n].tolist()) not in names
                    np.testing.assert_array_equal(own[a[n]] + own[b[n]], 2 * own[n])
                    assert frozenset((names[tuple(own[a[n]].tolist())], names[tuple(own[b[n]].tolist())])) in sides


@pytest.mark.parametrize("segments", (4, 16))
def test_no_triangle_turns_over_whatever_the_edges_skip(segments):
    k = np.arange(vertex_count(segments))
    p, q = vertex_place(k, segments)
    edge = edge_of(p, q, segments)
    triangles = patch_indices(segments).astype(np.int64)
    for skips in product(range(segments.bit_length()), repeat=3):
        stands = collapsed(k, edge, np.where(edge < 0, 0, np.array(skips)[edge]), segments)
        sizes = area(p, q, stands[triangles])
        assert sizes.min() >= 0 and sizes.sum() == segments**2, skips
        for side in range(3):
            used = np.unique(along(p[stands], q[stands], side, segments)[edge == side])
            assert (used % (1 << skips[side]) == 0).all()


def test_the_same_edge_from_both_sides_at_any_skip_and_morph():
    """Tiles of random levels side by side, roots' edges too: what is drawn along the common edge is the same set of
    bits."""
    rng = np.random.default_rng(2)
    segments = 16
    for _ in range(150):
        level, skip = int(rng.integers(0, 12)), int(rng.integers(0, 4))
        coarse = int(SCHEME.at(rng.normal(size=3), level))
        edge = int(rng.integers(3))
        beside = int(SCHEME.neighbour(coarse, edge))
        fine = [beside]
        for _ in range(skip):
            fine = [int(child) for key in fine for child in SCHEME.children(key)]
        morph = np.float32(rng.uniform()) if skip == 0 else np.float32(0)
        wanted = drawn_edge(coarse, edge, 0, morph, segments, rng)
        found = set()
        for key in fine:
            for side in range(3):
                up = int(SCHEME.neighbour(key, side))
                for _ in range(skip):
                    up = int(SCHEME.parent(up))
                if up == coarse and SCHEME.level(np.int64(key)) == level + skip:
                    found |= drawn_edge(key, side, skip, morph, segments, rng)
        assert found == wanted


def drawn_edge(key: int, edge: int, skip: int, morph: np.float32, segments: int, rng) -> set[bytes]:
    """What a tile draws along an edge, whatever its other edges and its inside do."""
    points = points_of(key, segments)
    # A height from the name of the point alone, as rough as can be.
    mixed = (points * np.array([73856093, 19349663, 83492791])).sum(axis=1)
    height = ((mixed ^ mixed >> 13) % 9973).astype(np.float32)
    vertices = np.concatenate([points / FULL, height[:, None]], axis=1).astype(np.float32)
    skips, morphs = rng.integers(0, 4, 3), rng.uniform(size=3)
    skips[edge], morphs[edge] = skip, morph
    drawn = assemble(vertices, rng.uniform(), skips, np.where(skips > 0, 0, morphs), segments)
    return {row.tobytes() for row in drawn[vertex_index(*on_edge(edge, np.arange(segments + 1), segments), segments)]}


def test_fully_morphed_children_are_their_parent():
    """At morph 1 the four children's triangles lie on their parent's: each vertex is one of its vertices, or the mean
    of two that it has an edge between."""
    segments, rng = 16, np.random.default_rng(3)
    key = int(SCHEME.at(rng.normal(size=3), 4))
    heights = {tuple(v): h for v, h in zip(points_of(key, segments).tolist(), rng.normal(size=999), strict=False)}
    for child in SCHEME.children(key):
        points = points_of(int(child), segments)
        own = np.array([heights.get(tuple(v), 1e6) for v in points.tolist()], np.float32)[:, None]
        drawn = assemble(own, 1.0, [0, 0, 0], [1, 1, 1], segments)
        assert np.abs(drawn).max() < 1e3  # nothing of what only the child has
        again = assemble(drawn, 1.0, [0, 0, 0], [1, 1, 1], segments)
        np.testing.assert_array_equal(again, drawn)


@pytest.mark.gpu
@pytest.mark.parametrize("bits", (3, 4, 6))
def test_shader_and_twin_agree(run_compute, bits):
    segments = 1 << bits
    rng = np.random.default_rng(bits)
    k = np.tile(np.arange(vertex_count(segments)), 4)
    skip = rng.integers(0, bits + 1, len(k))
    keys = SCHEME.at(rng.normal(size=(len(k), 3)), FULL_BITS - 6 - rng.integers(0, 20, len(k)))
    root, level, i, j = SCHEME.unpack(keys)
    out = run_compute(
        """edge = tile_edge(k);
        tile_even(k, edge, skip, a, b);
        stands = tile_collapsed(k, edge, skip);
        bc = pf_triangle_lattice(TileName(name.x, name.y, name.z, name.w), pf_triangle_place(k, TILE_SEGMENTS));""",
        {"k": k, "skip": skip, "name": np.stack([root, level, i, j], axis=1)},
        {"edge": "int", "a": "int", "b": "int", "stands": "int", "bc": "ivec2"},
        header='#include "terrain/tiles/triangle.glsl"',
        defines={"TILE_LOG2": bits},
    )
    p, q = vertex_place(k, segments)
    edge = edge_of(p, q, segments)
    np.testing.assert_array_equal(out["edge"], edge)
    for name, expected in zip("ab", even_vertices(k, edge, skip, segments), strict=True):
        np.testing.assert_array_equal(out[name], expected)
    np.testing.assert_array_equal(out["stands"], collapsed(k, edge, skip, segments))
    _, b, c = SCHEME.corner_points(keys)
    weights = np.stack([segments - p - q, p, q], axis=-1)
    np.testing.assert_array_equal(out["bc"], np.stack([(weights * x).sum(axis=1) // segments for x in (b, c)], axis=1))
