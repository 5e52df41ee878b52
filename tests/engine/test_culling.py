"""The culling oracle never culls what is visible, and does cull."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from planetfall.engine.space import CameraState, frustum_planes
from planetfall.engine.surface.culling import (
    cell_bounds,
    cells_hidden_by_horizon,
    corner_bounds,
    frustum_hidden,
    horizon_hidden,
)
from planetfall.engine.surface.lattice import cell_corners, direction_of

DATA = Path(__file__).parents[1] / "data"


def rows(name: str) -> list[dict[str, str]]:
    return list(csv.DictReader((DATA / name).open()))


def camera_of(row: dict[str, str]) -> CameraState:
    def vector(name):
        return [float(row[f"{name}_{axis}"]) for axis in "xyz"]

    fov = float(np.degrees(float(row["fovy_rad"])))
    return CameraState.look(vector("cam"), vector("fwd"), vector("up"), fov, float(row["aspect"]))


def test_horizon_table():
    called_hidden = hidden = 0
    for row in rows("terrain_horizon.csv"):
        found = bool(
            horizon_hidden(
                float(row["cam_alt_m"]),
                float(row["target_alt_m"]),
                float(row["angle_rad"]),
                float(row["radius_m"]),
                float(row["hmin_m"]),
            )
        )
        occluded = row["occluded"] == "1"
        assert not (found and not occluded), row
        hidden += occluded
        called_hidden += found
    # Exact up to the last few digits, so next to nothing that is hidden is kept.
    assert called_hidden >= 0.98 * hidden > 20


def test_cells_table():
    culled = invisible = 0
    for row in rows("terrain_cull_chunks.csv"):
        camera = camera_of(row)
        radius, amp = float(row["radius_m"]), float(row["amp_m"])
        cell = tuple(np.array([int(row[k])]) for k in ("face", "level", "ix", "iy"))
        # The table's bounds have six digits.
        low, high = float(row["hmin_m"]) - 1e-5 * amp, float(row["hmax_m"]) + 1e-5 * amp
        bounds = cell_bounds(*cell, low, high, radius, camera.position_m)
        outside = frustum_hidden(bounds, frustum_planes(camera), camera.forward)[0]
        beyond = cells_hidden_by_horizon(camera.position_m, *cell, high, radius, -amp)[0]
        if int(row["visible"]):
            assert not outside and not beyond, row
        if int(row["in_frustum"]):
            assert not outside, row
        if int(row["not_occluded_by_min_sphere"]):
            assert not beyond, row
        invisible += not int(row["visible"])
        culled += bool(outside or beyond)
    assert culled >= 0.8 * invisible


def test_triangles_table():
    culled = invisible = 0
    for row in rows("terrain_cull_triangles.csv"):
        camera = camera_of(row)
        radius, amp = float(row["radius_m"]), float(row["amp_m"])
        corners = np.array([[[float(row[p + a]) for a in "xyz"] for p in "abc"]])
        low, high = float(row["hmin_m"]) - 1e-5 * amp, float(row["hmax_m"]) + 1e-5 * amp
        bounds = corner_bounds(corners, low, high, radius, camera.position_m)
        outside = frustum_hidden(bounds, frustum_planes(camera), camera.forward)[0]
        if int(row["in_frustum"]):
            assert not outside, row
        invisible += not int(row["in_frustum"])
        culled += bool(outside)
    assert culled >= 0.8 * invisible


def test_boxes_contain_their_cells():
    rng = np.random.default_rng(2)
    for level in (0, 1, 2, 5, 12, 20):
        n = 1 << level
        face = rng.integers(0, 6, 20)
        i, j = rng.integers(0, n, (2, 20))
        low, high = -500.0, 9000.0
        origin = cell_corners(face, level, i, j)[0, 0] * 6.371e6
        bounds = cell_bounds(face, np.full(20, level), i, j, low, high, 6.371e6, origin)
        size = 2.0 ** (30 - level)
        u, v = rng.uniform(0, 1, (2, 20, 200))
        u[:, :4], v[:, :4] = [0, 1, 0, 1], [0, 0, 1, 1]
        directions = direction_of(face[:, None], (i[:, None] + u) * size, (j[:, None] + v) * size)
        for h in (low, high):
            points = directions * (6.371e6 + h) - origin
            assert np.all(points >= bounds.low_m[:, None] - 1e-6)
            assert np.all(points <= bounds.high_m[:, None] + 1e-6)


def test_a_camera_inside_the_lowest_sphere_sees_everything():
    assert not horizon_hidden(-600.0, 0.0, 3.0, 6.371e6, -500.0)
    assert not horizon_hidden(-500.0, 100.0, 0.0, 6.371e6, -500.0)


def test_behind_the_planet():
    face, level = np.array([0, 1]), np.array([3, 3])
    i = j = np.array([4, 4])
    hidden = cells_hidden_by_horizon((7e6, 0, 0), face, level, i, j, 9000.0, 6.371e6, -100.0)
    np.testing.assert_array_equal(hidden, [False, True])
