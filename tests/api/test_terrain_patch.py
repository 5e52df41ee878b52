"""TerrainSampler.patch: lattice-aligned patches meet, whatever their frames; against heights at their points."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.query.terrain import TerrainSampler
from planetfall.systems.terrain.height import TerrainParams

EARTH = TerrainParams(seed=2)
PLACES = {
    "middle of a face": (0.9, 0.2, 0.3),
    "border of two faces": (1.0, 1.0 - 1e-7, 0.2),
    "corner": (1.0, 1.0 - 1e-7, 1.0 - 2e-7),
}


@pytest.fixture(scope="module")
def earth():
    return TerrainSampler.from_params(EARTH)


def place(name):
    d = np.array(PLACES[name])
    return d / np.linalg.norm(d)


def in_planet(patch):
    return patch.origin_m + patch.positions_m @ patch.axes


@pytest.mark.parametrize("name", PLACES)
def test_an_aligned_patch_is_the_ground(earth, name):
    up = place(name)
    patch = earth.patch(up, 64.0, 2.0, aligned=True)
    assert patch.cell is not None
    n = len(patch.x_m)
    assert n - 1 in (16, 32, 64)
    assert f"{n} x {n} points" in repr(patch) and str(patch.cell) in repr(patch) and len(repr(patch)) < 160
    world = in_planet(patch).reshape(-1, 3)
    np.testing.assert_allclose(np.linalg.norm(world, axis=1) - EARTH.radius_m, patch.heights_m.ravel(), atol=1e-7)
    np.testing.assert_allclose(earth.height(world), patch.heights_m.ravel(), atol=1e-6)
    spacing = np.linalg.norm(np.diff(patch.positions_m, axis=1), axis=-1)
    assert 1.0 < np.median(spacing) < 3.0
    a, b, c = patch.positions_m.reshape(-1, 3)[patch.triangles()].swapaxes(0, 1)
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all(), "counter-clockwise from above"
    # It holds the place that was asked for.
    local = patch.to_frame(up[None] * (EARTH.radius_m + earth.height(up)))[0]
    low, high = patch.positions_m.reshape(-1, 3).min(axis=0), patch.positions_m.reshape(-1, 3).max(axis=0)
    assert ((local[:2] > low[:2] - 1e-6) & (local[:2] < high[:2] + 1e-6)).all()
    np.testing.assert_allclose(patch.to_planet(local[None])[0], up * (EARTH.radius_m + earth.height(up)), atol=1e-6)


@pytest.mark.parametrize("name", PLACES)
def test_neighbours_share_their_border_to_the_last_bit(earth, name):
    up = place(name)
    here = earth.patch(up, 64.0, 2.0, aligned=True)
    corners = in_planet(here)
    points = {}
    for dx in (-1, 0, 1):
        for dy in (-1, 0, 1):
            middle = (
                corners.mean(axis=(0, 1))
                + dx * (corners[0, -1] - corners[0, 0])
                + dy * (corners[-1, 0] - corners[0, 0])
            )
            other = earth.patch(middle, 64.0, 2.0, aligned=True, frame=here, normals=False)
            assert other.normals.size == 0
            for position, height in zip(other.positions_m.reshape(-1, 3), other.heights_m.ravel(), strict=True):
                key = tuple(np.rint(position[:2] / 0.01).astype(int))
                near = [(key[0] + i, key[1] + j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
                found = next((k for k in near if k in points), key)
                points.setdefault(found, []).append((*position, height))
    shared = [np.array(p) for p in points.values() if len(p) > 1]
    # A distinct patch in each direction; three at a cube's corner have one less around them.
    side = len(here.x_m)
    assert len(shared) >= 8 * (side - 1)
    for same in shared:
        np.testing.assert_array_equal(same, np.broadcast_to(same[0], same.shape))


def test_cells_name_patches(earth):
    rng = np.random.default_rng(1)
    up = place("border of two faces") + rng.normal(size=(30, 3)) * 5e-6
    cells = earth.patch_cells(up, 64.0, 2.0)
    for direction, cell in zip(up, cells, strict=True):
        assert earth.patch(direction, 64.0, 2.0, aligned=True, normals=False).cell == tuple(cell)


def test_a_border_reaches_into_the_neighbour(earth):
    up = place("middle of a face")
    here = earth.patch(up, 32.0, 1.0, aligned=True)
    wide = earth.patch(up, 32.0, 1.0, aligned=True, border=2, frame=here)
    assert wide.cell == here.cell and wide.border == 2
    np.testing.assert_array_equal(wide.positions_m[2:-2, 2:-2], here.positions_m)
    np.testing.assert_array_equal(wide.heights_m[2:-2, 2:-2], here.heights_m)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"border": 1}, "border=1 is for aligned patches"),
        ({"aligned": True, "border": -1}, "border=-1 is for aligned patches, from 0 up"),
        ({"frame": ([0, 0, 0], np.ones((3, 3)))}, "orthonormal rows"),
        ({"frame": ([0, 0, np.nan], np.eye(3))}, r"frame origin_m\[0\]: expected finite numbers"),
    ],
)
def test_bad_frames_and_borders(earth, options, message):
    with pytest.raises(ValueError, match=message):
        earth.patch([1, 0, 0], 10.0, 1.0, **options)
