"""Ring selection: the split rule, no holes and no overlaps, watertight topology, limits."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.coverage import coverage
from planetfall.engine.surface.lattice import (
    FACE_AXES,
    FULL,
    canonical_lattice,
    cell_center,
    cell_edge_m,
    cell_of,
    direction_of,
)
from planetfall.engine.surface.lattice_anchor import LatticeAnchor
from planetfall.engine.surface.nearest import NearestPoint
from planetfall.engine.surface.selection import CellSet, rows_in, select_rings

EARTH = 6.371e6
PLACES = {
    "north pole": (0, 0, 1),
    "south pole": (0, 0, -1),
    "face corner": (1, 1, 1),
    "next to a corner": (1, 1.0001, -0.9999),
    "face edge": (1, 0.3, 1),
    "equator": (1, 0, 0),
    "anywhere": (0.31, -0.52, 0.71),
}


def masked_index(quads: int, delta: np.ndarray) -> np.ndarray:
    """What the vertex shader does to indices along an edge: rounded down to a multiple of 2^delta. (N, quads + 1)."""
    k = np.arange(quads + 1)[None, :]
    return (k >> delta[:, None]) << delta[:, None]


def border_segments(cells: CellSet) -> np.ndarray:
    """All segments of all cells' borders as pairs of canonical lattice points, (M, 2, 3), empty ones left out."""
    q = cells.quads
    step = (FULL >> cells.level.astype(np.int64))[:, None] // q
    zero = np.zeros((len(cells), q + 1), np.int64)
    segments = []
    for edge in range(4):
        along = masked_index(q, cells.edge_delta[:, edge].astype(np.int64))
        fixed = zero if edge in (0, 2) else zero + q
        k, l = (fixed, along) if edge < 2 else (along, fixed)
        name = canonical_lattice(
            cells.face[:, None],
            (cells.i.astype(np.int64)[:, None] * q + k) * step,
            (cells.j.astype(np.int64)[:, None] * q + l) * step,
        )
        points = np.stack(name, axis=-1)
        pairs = np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 2, 3)
        segments.append(pairs[(pairs[:, 0] != pairs[:, 1]).any(axis=1)])
    return np.concatenate(segments)


def segment_counts(cells: CellSet) -> np.ndarray:
    """How often each undirected segment occurs."""
    segments = border_segments(cells)
    _, number = np.unique(segments.reshape(-1, 3), axis=0, return_inverse=True)
    ends = np.sort(number.reshape(-1, 2), axis=1)
    return np.unique(ends, axis=0, return_counts=True)[1]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("altitude", "radius"), [(2.0, EARTH), (3e5, EARTH), (0.01, 1e3), (50.0, 1e3), (1e9, 7e7)])
def test_watertight(place, altitude, radius):
    anchor = LatticeAnchor(PLACES[place], radius)
    cells = select_rings(anchor, altitude, 0.0, radius, 0.1, quads=8)
    counts = segment_counts(cells)
    # The whole sphere is selected, so each segment has a cell on both sides.
    np.testing.assert_array_equal(counts, 2)
    assert cells.edge_delta.max(initial=0) <= 1
    area = (4.0 ** -cells.level.astype(float)).sum()
    assert area == pytest.approx(6.0, rel=1e-12)


def test_random_cameras_are_watertight_and_balanced():
    rng = np.random.default_rng(9)
    for _ in range(12):
        radius = 10.0 ** rng.uniform(3, 7.8)
        altitude = 10.0 ** rng.uniform(-2, 9)
        quads = int(rng.choice([4, 8, 16]))
        angle = 0.8 / quads * 10.0 ** rng.uniform(-0.5, 0.5)
        bumps = rng.normal(size=3) * 5

        def height(d, scale=radius, k=bumps):
            return 0.01 * scale * np.sin(d @ k * 40)

        anchor = LatticeAnchor(rng.normal(size=3), radius)
        ground = float(height(anchor.direction[None])[0])
        cells = select_rings(anchor, altitude, ground, radius, angle, quads, height_at=height)
        np.testing.assert_array_equal(segment_counts(cells), 2)
        assert cells.edge_delta.max(initial=0) <= np.log2(quads)


def test_wild_angles_are_still_balanced():
    # Cells as wide as they are far: rings so narrow that neighbours would differ by more levels than a cell has quads.
    for quads in (2, 4):
        for place in PLACES.values():
            cells = select_rings(LatticeAnchor(place, EARTH), 1.0, 0.0, EARTH, 3.0, quads)
            assert cells.edge_delta.max() <= np.log2(quads)
            np.testing.assert_array_equal(segment_counts(cells), 2)


@pytest.mark.parametrize("altitude", [2.0, 1e4, 3e6])
def test_the_rule_holds_for_every_cell(altitude):
    angle, quads = 0.03, 16
    anchor = LatticeAnchor((0.31, -0.52, 0.71), EARTH)
    cells = select_rings(anchor, altitude, 500.0, EARTH, angle, quads, min_spacing_m=0.02)
    finest = cells.level.max()
    settled = cells.spacing_m <= angle * cells.distance_m * (1 + 1e-9)
    assert np.all(settled | (cells.level == finest))
    assert np.all(np.diff(cells.distance_m) >= 0)
    # Its parent would have been too coarse.
    sphere = EARTH + 500.0
    nearest = NearestPoint(anchor.direction, FACE_AXES)
    deep = cells.level > 0
    level = cells.level[deep] - 1
    scale = (np.pi / 2) * np.exp2(-level.astype(float))
    low = np.stack([cells.i[deep] >> 1, cells.j[deep] >> 1]) * scale - np.pi / 4
    chord2 = nearest.chord_squared(cells.face[deep].astype(int), np.tan(low), np.tan(low + scale))
    distance = np.sqrt(chord2 * sphere * (sphere + altitude) + altitude**2)
    assert np.all(cell_edge_m(level, EARTH) / quads > angle * distance * (1 - 1e-9))
    # So the spacing lies between half the wanted angle (of the farthest point of the parent) and the wanted angle.
    assert cells.spacing_m.min() >= 0.02


def test_distance_to_cells_is_exact():
    rng = np.random.default_rng(3)
    u, v = (a.ravel() for a in np.meshgrid(np.linspace(0, 1, 41), np.linspace(0, 1, 41)))
    for place in [*PLACES.values(), *rng.normal(size=(10, 3))]:
        direction = np.asarray(place, float) / np.linalg.norm(place)
        nearest = NearestPoint(direction, FACE_AXES)
        for level in (0, 1, 2, 4):
            n = 1 << level
            face, i, j = rng.integers(0, 6, 30), *rng.integers(0, n, (2, 30))
            scale = np.pi / 2 / n
            low = np.stack([i, j]) * scale - np.pi / 4
            found = np.sqrt(nearest.chord_squared(face, np.tan(low), np.tan(low + scale)))
            size = FULL / n
            samples = direction_of(face[:, None], (i[:, None] + u) * size, (j[:, None] + v) * size)
            sampled = np.linalg.norm(samples - direction, axis=2).min(axis=1)
            assert np.all(found <= sampled + 1e-15)
            assert np.all(found >= sampled - scale / 40)
            assert np.all((found > 1e-12) | (sampled <= scale / 40))


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("altitude", [2.0, 1e4, 3.6e7])
def test_what_is_in_sight_is_covered_once(place, altitude):
    rng = np.random.default_rng(1)
    anchor = LatticeAnchor(PLACES[place], EARTH)
    limit = coverage(altitude, EARTH, 9000.0).half_angle_rad
    cells = select_rings(anchor, altitude, 0.0, EARTH, 0.05, 16, coverage_rad=limit)
    away = rng.normal(size=(400, 3))
    away -= (away @ anchor.direction)[:, None] * anchor.direction
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    angle = limit * np.append(10.0 ** rng.uniform(-7, 0, 399), 1.0)
    points = anchor.direction * np.cos(angle)[:, None] + away * np.sin(angle)[:, None]
    owners = np.zeros(len(points), int)
    leaves = {
        (int(f), int(l), int(a), int(b)) for f, l, a, b in zip(cells.face, cells.level, cells.i, cells.j, strict=True)
    }
    assert len(leaves) == len(cells)
    for level in range(cells.level.min(), cells.level.max() + 1):
        names = np.stack(cell_of(points, level), axis=1)
        owners += [(int(f), level, int(a), int(b)) in leaves for f, a, b in names]
    np.testing.assert_array_equal(owners, 1)
    far = np.linalg.norm(cell_center(cells.face, cells.level, cells.i, cells.j) - anchor.direction, axis=1)
    assert np.all(far <= 2 * np.sin(min(limit, np.pi) / 2) + np.pi / 2 * 2.0**-cells.level)


def test_too_many_cells_are_avoided_in_steps():
    anchor = LatticeAnchor((0.31, -0.52, 0.71), EARTH)
    free = select_rings(anchor, 100.0, 0.0, EARTH, 0.01, 16, 0.02)
    few = select_rings(anchor, 100.0, 0.0, EARTH, 0.01, 16, 0.02, max_cells=800)
    assert len(free) > 800 >= len(few) > 200
    assert free.spacing_angle_rad == 0.01
    steps = np.log2(few.spacing_angle_rad / 0.01) * 4
    assert steps == pytest.approx(round(steps), abs=1e-9)


def test_high_ground_near_the_proxy_is_refined():
    anchor = LatticeAnchor((1, 0, 0), EARTH)

    def tower(d):
        return np.where(d[:, 1] > 0, 90.0, -2000.0)

    flat = select_rings(anchor, 100.0, 0.0, EARTH, 0.02, 16, 0.02)
    rough = select_rings(anchor, 100.0, 0.0, EARTH, 0.02, 16, 0.02, height_at=tower)

    def finest_at(cells, side):
        middle = cell_center(cells.face, cells.level, cells.i, cells.j)
        near = (middle[:, 1] * side > 0) & (np.abs(middle[:, 1] * EARTH) < 150.0)
        return cells.level[near].max()

    assert finest_at(rough, 1) > finest_at(flat, 1)
    assert finest_at(rough, -1) <= finest_at(flat, -1)


def test_same_input_same_cells():
    a, b = (select_rings(LatticeAnchor((1, 2, 3), EARTH), 30.0, 5.0, EARTH, 0.02) for _ in range(2))
    np.testing.assert_array_equal(a.packed(), b.packed())
    packed = a.packed()
    np.testing.assert_array_equal(packed[:, 2] & 255, a.face)
    np.testing.assert_array_equal(packed[:, 2] >> 8, a.level)
    np.testing.assert_array_equal(packed[:, 3:].view(np.uint8), a.edge_delta)


@pytest.mark.parametrize("radius", [1e3, EARTH, 7e7])
def test_extremes_give_finite_cells(radius):
    for altitude in (0.01, 1e9):
        cells = select_rings((0, 0, 1), altitude, 0.0, radius, 0.05, 16, min_spacing_m=1e-6)
        assert 1 <= len(cells) < 20000
        assert cells.level.max() <= 26
        assert np.all(np.isfinite(cells.distance_m))


def test_nonsense_is_refused():
    good = {"altitude_above_ground_m": 1.0, "anchor_height_m": 0.0, "radius_m": 1e3, "spacing_angle_rad": 0.1}
    for change in ({"altitude_above_ground_m": 0.0}, {"radius_m": np.nan}, {"spacing_angle_rad": -1.0}, {"quads": 12}):
        with pytest.raises(ValueError, match=f"select_rings: {next(iter(change))}"):
            select_rings((0, 0, 1), **(good | change))
    with pytest.raises(ValueError, match="select_rings: anchor"):
        select_rings((0, np.nan, 1), **good)


def test_cells_are_found_in_another_selection():
    place = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    cells = select_rings(place, 900.0, 0.0, EARTH, 0.05, 16, 0.02)
    others = select_rings(place, 1500.0, 0.0, EARTH, 0.05, 16, 0.02)

    def names(of: CellSet) -> list[tuple[int, ...]]:
        return [tuple(row) for row in np.stack([of.face, of.level, of.i, of.j], axis=1).tolist()]

    rows, there = rows_in(cells, others), names(others)
    assert [there.index(name) if name in there else -1 for name in names(cells)] == rows.tolist()
    assert 0 < (rows >= 0).sum() < len(cells)
