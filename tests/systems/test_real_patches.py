"""TerrainSampler.patch over tiles of elevation, in memory and streamed: the sampler's ground, and one with its
neighbours, across borders of tiles and out into the procedural ground."""

from __future__ import annotations

import numpy as np
import pytest
from countries import hgt_samples, write_country, write_hgt

import planetfall as pf
from planetfall.engine.real_ground.streamed_ground import StreamedGround
from planetfall.systems.terrain.height import TerrainParams

RADIUS_M = 6.371e6
# Within the rough tile, at its border to a coarse one, at its corner, where the country ends, where its margin does.
PLACES = ((46.5, 7.5), (46.5, 8.0), (46.0, 7.0), (48.0, 7.5), (48.12, 7.5), (30.0, 7.5))


@pytest.fixture(scope="module", params=[256.0, 1.0], ids=["in memory", "streamed"])
def scene(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("country")
    write_country(folder / "coarse", 45, 6, 3, 3, 41)
    rough = hgt_samples(46, 7, 801) + np.random.default_rng(1).normal(0.0, 8.0, (801, 801))
    write_hgt(folder / "fine", 46, 7, 801, np.rint(rough).astype(np.int16))
    made = pf.load_scene("earth")
    terrain = made.planet[pf.Terrain]
    terrain.rivers, terrain.height_map_most_mb = 0.0, request.param
    terrain.height_map = str(folder)
    real = TerrainParams.from_component(terrain, RADIUS_M).real
    assert isinstance(real, StreamedGround) == (request.param < 2.0)
    return made


def in_planet(patch):
    return patch.origin_m + patch.positions_m @ patch.axes


@pytest.mark.parametrize("aligned", [False, True], ids=["tangent", "aligned"])
@pytest.mark.parametrize("place", PLACES)
def test_a_patch_is_the_samplers_ground(scene, place, aligned):
    """Heights and normals are those of the sampler in the same directions; the patch comes first, so that it is what
    reads pages. A point of it is a double of 6 371 km: 1 nm."""
    ground = pf.TerrainSampler(scene)
    patch = ground.patch(pf.direction(*place), 2000.0, 60.0, aligned=aligned)
    points = in_planet(patch).reshape(-1, 3)
    assert np.isfinite(patch.heights_m).all() and np.ptp(patch.heights_m) > 1.0
    away = np.linalg.norm(points, axis=1)
    np.testing.assert_allclose(away - RADIUS_M, patch.heights_m.ravel(), rtol=0.0, atol=1e-8)
    # Of one place on the way to a direction and back: 1e-9 m to the side, on slopes of 10 at most.
    np.testing.assert_allclose(ground.height(points), patch.heights_m.ravel(), rtol=0.0, atol=1e-7)
    normals = patch.normals.reshape(-1, 3) @ patch.axes
    np.testing.assert_allclose(normals, ground.normal(points), rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("place", PLACES)
def test_neighbours_share_their_points_to_the_last_bit(scene, place):
    """However many of their points lie in tiles of which kind."""
    ground, size_m, spacing_m = pf.TerrainSampler(scene), 4000.0, 120.0
    here = ground.patch(pf.direction(*place), size_m, spacing_m, aligned=True, normals=False)
    corners = in_planet(here)
    right, up = corners[0, -1] - corners[0, 0], corners[-1, 0] - corners[0, 0]
    sides = ((right, np.s_[:, -1], np.s_[:, 0]), (-right, np.s_[:, 0], np.s_[:, -1]),
             (up, np.s_[-1], np.s_[0]), (-up, np.s_[0], np.s_[-1]))  # fmt: skip
    for step, own, its in sides:
        other = ground.patch(corners.mean(axis=(0, 1)) + step, size_m, spacing_m, aligned=True, frame=here)
        assert other.cell is not None and here.cell is not None and other.cell != here.cell
        np.testing.assert_array_equal(other.heights_m[its], here.heights_m[own])
        np.testing.assert_array_equal(other.positions_m[its], here.positions_m[own])
    parts = ground.patch(pf.direction(*place), 0.5 * size_m, spacing_m, aligned=True, frame=here, normals=False)
    n = len(parts.x_m)
    at = np.argmin(np.linalg.norm(here.positions_m - parts.positions_m[0, 0], axis=-1))
    j, i = np.unravel_index(at, here.heights_m.shape)
    np.testing.assert_array_equal(parts.heights_m, here.heights_m[j : j + n, i : i + n])
