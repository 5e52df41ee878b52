"""Hulls of cells: distances are lower bounds, culling drops nothing visible and most of what is not."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from planetfall.benchmarks.measure.culling import cell_samples, random_pairs
from planetfall.benchmarks.measure.selection import MadeGround, settle
from planetfall.engine.space import CameraState, frustum_planes
from planetfall.engine.surface.hulls import (
    CONTAINED,
    INTERSECTING,
    OUTSIDE,
    SQUARE_ROUNDING,
    Hulls,
    cells_hidden,
    frustum_states,
    hull_points,
    polygons_hidden,
)
from planetfall.engine.surface.icosphere import TriangleScheme
from planetfall.engine.surface.nodes import node_shape
from planetfall.engine.surface.scheme import QuadScheme, Scheme

DATA = Path(__file__).parents[1] / "data"
SCHEMES: list[Scheme] = [QuadScheme(), TriangleScheme()]
schemes = pytest.mark.parametrize("scheme", SCHEMES, ids=lambda s: s.name)


def rows(name: str) -> list[dict[str, str]]:
    return list(csv.DictReader((DATA / name).open()))


def camera_of(row: dict[str, str]) -> tuple[CameraState, np.ndarray]:
    def vector(name):
        return [float(row[f"{name}_{axis}"]) for axis in "xyz"]

    fov = float(np.degrees(float(row["fovy_rad"])))
    camera = CameraState.look(vector("cam"), vector("fwd"), vector("up"), fov, float(row["aspect"]))
    return camera, np.concatenate([frustum_planes(camera), camera.forward[None]])


def bounds_of(row: dict[str, str]) -> tuple[float, float, float, float]:
    """Radius, relief, lowest and highest ground; the table's bounds have six digits."""
    radius, relief = float(row["radius_m"]), float(row["amp_m"])
    return radius, relief, float(row["hmin_m"]) - 1e-5 * relief, float(row["hmax_m"]) + 1e-5 * relief


def test_table_of_chunks():
    scheme, culled, invisible = QuadScheme(), 0, 0
    for row in rows("terrain_cull_chunks.csv"):
        camera, planes = camera_of(row)
        radius, relief, low, high = bounds_of(row)
        key = scheme.pack(*(np.array([int(row[k])]) for k in ("face", "level", "ix", "iy")))
        hidden = cells_hidden(scheme, key, low, high, radius, camera.position_m, planes, -relief)[0]
        assert not (hidden and int(row["visible"])), row
        invisible += not int(row["visible"])
        culled += bool(hidden)
    assert culled >= 0.9 * invisible > 100


def test_table_of_triangles():
    culled = invisible = 0
    for row in rows("terrain_cull_triangles.csv"):
        camera, planes = camera_of(row)
        radius, relief, low, high = bounds_of(row)
        corners = np.array([[[float(row[p + a]) for a in "xyz"] for p in "abc"]])
        hidden = polygons_hidden(corners, radius + low, radius + high, radius - relief, camera.position_m, planes)[0]
        assert not (hidden and int(row["visible"])), row
        invisible += not int(row["visible"])
        culled += bool(hidden)
    assert culled >= 0.9 * invisible > 100


@schemes
@pytest.mark.parametrize("radius_m", (1e4, 6.371e6))
def test_random_pairs(scheme: Scheme, radius_m: float):
    ground = MadeGround(scheme, radius_m, 1.5e-3 * radius_m if radius_m > 1e5 else 0.15 * radius_m)
    found = random_pairs(ground, np.random.default_rng(5), 200)
    assert found.dropped == 0
    assert 20 < found.visible < 180
    assert found.share >= 0.9


@pytest.mark.slow
@schemes
def test_many_random_pairs(scheme: Scheme):
    ground = MadeGround(scheme)
    found = random_pairs(ground, np.random.default_rng(6), 5000)
    assert found.dropped == 0
    assert found.share >= 0.9


@schemes
def test_distances_are_lower_bounds(scheme: Scheme):
    rng = np.random.default_rng(8)
    radius, ratios = 6.371e6, []
    for _ in range(300):
        level = int(rng.integers(0, 20))
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        size = float(scheme.spacing_rad(level, 1))
        key = scheme.at(up[None], level)
        low, high = np.sort(rng.uniform(-1.0, 1.0, 2)) * min(0.1, size) * radius
        towards = up + rng.normal(size=3) * size * rng.choice([0.3, 1.0, 4.0])
        eye = towards / np.linalg.norm(towards) * (radius + rng.normal() * size * radius)
        center, reach, normals = node_shape(scheme, key)
        hulls = Hulls.of(center, reach, normals, np.array([radius + low]), np.array([radius + high]), radius)
        found = float(hulls.distance(eye)[0])
        samples = cell_samples(scheme.corners(key)[0], 65)
        heights = np.linspace(low, high, 17)
        nearest = min(np.linalg.norm(samples * (radius + h) - eye, axis=1).min() for h in heights)
        assert found**2 <= nearest**2 + SQUARE_ROUNDING * (2.0 * radius) ** 2
        ratios.append(found / nearest)
    # Samples are a 64th of a cell apart; a bound that says little would not be near them.
    assert np.median(ratios) > 0.9


@schemes
def test_three_states(scheme: Scheme):
    rng = np.random.default_rng(9)
    ground = MadeGround(scheme)
    count = np.zeros(3, int)
    for _ in range(150):
        up = rng.normal(size=3)
        up /= np.linalg.norm(up)
        level = int(rng.integers(3, 14))
        size = float(scheme.spacing_rad(level, 1)) * ground.radius_m
        camera = CameraState.look(
            up * (ground.radius_m + 20e3 + size * rng.uniform(0.3, 6.0)),
            -up + 0.5 * rng.normal(size=3),
            rng.normal(size=3),
            60.0,
            1.5,
        )
        planes = frustum_planes(camera)
        key = scheme.at(up[None], level)
        points = hull_points(scheme.corners(key), ground.radius_m - 100.0, ground.radius_m + 900.0, camera.position_m)
        state = int(frustum_states(points, planes)[0])
        count[state] += 1
        samples = cell_samples(scheme.corners(key)[0], 33)
        inside = [
            ((samples * (ground.radius_m + h) - camera.position_m) @ planes.T >= 0.0).all(axis=1) for h in (-100, 900)
        ]
        assert state != OUTSIDE or not np.any(inside)
        assert state != CONTAINED or np.all(inside)
    assert count[OUTSIDE] and count[INTERSECTING] and count[CONTAINED]


@schemes
def test_the_walk_finds_what_single_tests_find(scheme: Scheme):
    ground = MadeGround(scheme)
    forest = ground.forest()
    up = np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)
    eye = up * (ground.radius_m + float(ground.height(up[None])[0]) + 200.0)
    selection = settle(forest, ground, lambda: forest.select(eye, 1e-3, 0.5))
    camera = CameraState.look(eye, np.cross(up, [0.0, 0.0, 1.0]) - 0.2 * up, up, 60.0, 16 / 9)
    planes = np.concatenate([frustum_planes(camera), camera.forward[None]])
    walked = forest.visible(selection, eye, planes)
    facts = forest.facts(selection.keys)
    corners = scheme.corners(selection.keys)
    points = hull_points(corners, ground.radius_m + facts.low_m, ground.radius_m + facts.high_m, eye)
    alone = frustum_states(points, planes)
    # Never less than single tests; a contained node may add tiles that touch its border, and nothing else.
    assert walked.seen[alone != OUTSIDE].all()
    assert walked.seen.sum() <= 1.2 * (alone != OUTSIDE).sum() + 2
    assert 0 < walked.seen.sum() < 0.7 * len(selection)
    assert walked.contained > 0
    assert walked.tested < len(selection)
