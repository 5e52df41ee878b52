"""The integer lattice: faces, cells, neighbours, canonical border points."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.lattice import (
    FACE_AXES,
    FULL,
    HALF,
    canonical_lattice,
    cell_center,
    cell_corners,
    cell_edge_m,
    cell_of,
    direction_of,
    locate,
    neighbour,
    snap,
)

RNG = np.random.default_rng(20)


def border_points(face: int) -> tuple[np.ndarray, np.ndarray]:
    """Lattice points on the four edges of a face, corners included."""
    along = np.concatenate([[0, 1, HALF, FULL - 1, FULL], RNG.integers(0, FULL, 20)])
    zero, full = np.zeros_like(along), np.full_like(along, FULL)
    return np.concatenate([zero, full, along, along]), np.concatenate([along, along, zero, full])


def test_axes_are_right_handed_and_cover_the_cube():
    for x, y, z in FACE_AXES:
        np.testing.assert_array_equal(np.cross(x, y), z)
    assert sorted(map(tuple, FACE_AXES[:, 2])) == sorted(map(tuple, np.concatenate([np.eye(3), -np.eye(3)])))


def test_locate_inverts_direction():
    face = RNG.integers(0, 6, 2000)
    i, j = RNG.integers(1, FULL, (2, 2000))
    directions = direction_of(face, i, j)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, atol=3e-16)
    found, fi, fj = locate(directions * RNG.uniform(1e-3, 1e9, (2000, 1)))
    np.testing.assert_array_equal(found, face)
    np.testing.assert_allclose(fi, i, atol=1e-6)
    np.testing.assert_allclose(fj, j, atol=1e-6)


def test_border_points_have_one_name_and_one_direction():
    for face in range(6):
        i, j = border_points(face)
        named = canonical_lattice(face, i, j)
        assert np.all(named[0] <= face)
        np.testing.assert_array_equal(direction_of(*named), direction_of(face, i, j))
        again = canonical_lattice(*named)
        np.testing.assert_array_equal(np.stack(again), np.stack(named))


def test_every_edge_and_corner_is_shared():
    points: dict[tuple[int, int, int], set[int]] = {}
    for face in range(6):
        for i in (0, HALF, FULL):
            for j in (0, HALF, FULL):
                if (i, j) != (HALF, HALF):
                    name = tuple(int(a) for a in canonical_lattice(face, i, j))
                    points.setdefault(name, set()).add(face)
    counts = sorted(len(faces) for faces in points.values())
    assert counts == [2] * 12 + [3] * 8


@pytest.mark.parametrize("level", [0, 1, 2, 5, 29])
def test_neighbours_touch_along_the_edge(level):
    n = 1 << level
    ends = np.unique(np.array([0, n // 2, n - 1]))
    face, i, j, edge = (a.ravel() for a in np.meshgrid(np.arange(6), ends, ends, np.arange(4)))
    other = neighbour(face, level, i, j, edge)
    assert all(np.all((a >= 0) & (a < max(6, n))) for a in other)
    size = np.int64(1) << (30 - level)
    pick = np.array([[0, 2], [1, 3], [0, 1], [2, 3]])

    def names(f, a, b):
        ii = (a[:, None] + np.array([0, 1, 0, 1])) * size
        jj = (b[:, None] + np.array([0, 0, 1, 1])) * size
        return np.stack(canonical_lattice(f[:, None], ii, jj), axis=-1)

    mine, theirs = names(face, i, j), names(*other)
    for row in range(len(face)):
        shared = {tuple(p) for p in mine[row]} & {tuple(p) for p in theirs[row]}
        assert shared == {tuple(p) for p in mine[row][pick[edge[row]]]}
        assert tuple(a[row] for a in other) != (face[row], i[row], j[row])


def test_cells_contain_what_they_should():
    directions = RNG.normal(size=(500, 3))
    for level in (0, 3, 12, 30):
        face, i, j = cell_of(directions, level)
        found, fi, fj = locate(directions)
        np.testing.assert_array_equal(found, face)
        size = 2.0 ** (30 - level)
        assert np.all((fi >= i * size) & (fi <= (i + 1) * size) & (fj >= j * size) & (fj <= (j + 1) * size))
        middle = cell_center(face, level, i, j)
        np.testing.assert_array_equal(np.stack(cell_of(middle, level)), np.stack([face, i, j]))


def test_edge_length_bound():
    for level in (0, 1, 4, 10):
        n = 1 << level
        face = RNG.integers(0, 6, 400)
        i, j = RNG.integers(0, n, (2, 400))
        c = cell_corners(face, level, i, j)
        chords = np.stack([np.linalg.norm(c[:, a] - c[:, b], axis=1) for a, b in ((0, 1), (2, 3), (0, 2), (1, 3))])
        longest = 2 * np.arcsin(chords / 2).max(axis=0)
        bound = cell_edge_m(level, 1.0)
        assert np.all(longest <= bound * (1 + 1e-9))
        assert np.all(longest >= bound * (0.78 if level == 0 else 0.91))


def test_snap_is_the_nearest_corner():
    directions = RNG.normal(size=(300, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    for level in (0, 4, 20, 30):
        point = snap(directions, level)
        distance = np.linalg.norm(direction_of(*point) - directions, axis=1)
        assert np.all(distance <= np.sqrt(0.5) * np.pi / 2 * 2.0**-level * 1.0001 + 1e-15)
        size = 1 << (30 - level)
        assert np.all(point[1] % size == 0)
        assert np.all(point[2] % size == 0)
