"""Anchored offsets: the shader's function and its twins against extended precision; bit-equality on borders."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.lattice import FACE_AXES, FULL, HALF, canonical_lattice, locate
from planetfall.engine.surface.lattice_anchor import LatticeAnchor

LONG = np.longdouble
needs_long = pytest.mark.skipif(np.finfo(LONG).eps > 1e-18, reason="no extended precision on this machine")

ANCHORS = [
    (0, HALF, HALF),
    (4, HALF, HALF),  # the north pole
    (5, HALF, HALF),  # the south pole
    (4, HALF + 3, HALF - 1),
    (1, 0, HALF),
    (2, FULL, 300_000_000),
    (3, FULL, FULL),
    (4, 0, 0),
    (5, 1, 1),
    (0, FULL - 1, HALF),
    (2, 12345, FULL - 77),
    (1, 154_790_205, 883_629_045),
    (0, 1_018_604_588, 267_607_210),
    (3, 498_666_071, 78_687_329),
]


def exact_direction(face, i, j):
    step = np.arctan(LONG(1)) * 2 / LONG(FULL)
    x = np.tan((np.asarray(i, dtype=LONG) - HALF) * step)
    y = np.tan((np.asarray(j, dtype=LONG) - HALF) * step)
    axes = FACE_AXES[np.asarray(face)].astype(LONG)
    v = x[..., None] * axes[..., 0, :] + y[..., None] * axes[..., 1, :] + axes[..., 2, :]
    return v / np.sqrt((v * v).sum(axis=-1))[..., None]


def around(anchor: LatticeAnchor, count: int, seed: int):
    """Lattice points at all distances from the anchor, from one step to the antipode, and the exact offsets."""
    rng = np.random.default_rng(seed)
    away = rng.normal(size=(count, 3))
    away *= (10.0 ** rng.uniform(-9, 0.5, count) / np.linalg.norm(away, axis=1))[:, None]
    face, i, j = locate(anchor.direction + away)
    i, j = np.rint(i).astype(np.int64), np.rint(j).astype(np.int64)
    exact = (exact_direction(face, i, j) - exact_direction(anchor.face, anchor.i, anchor.j)) * LONG(anchor.radius_m)
    return face, i, j, exact


def relative(found, exact):
    size = np.sqrt((exact * exact).sum(axis=-1)).astype(float)
    error = np.sqrt(((found - exact) ** 2).sum(axis=-1)).astype(float)
    assert np.all(error[size == 0] == 0)
    return error[size > 0] / size[size > 0]


def bind(gpu, anchor):
    scope = gpu.scope("lattice test")
    buffer = scope.buffer(np.frombuffer(anchor.block.tobytes(), np.uint8))
    return scope, lambda _compute: buffer.bind_to_uniform_block(2)


def offsets(gpu, run_compute, anchor, face, i, j):
    scope, setup = bind(gpu, anchor)
    try:
        out = run_compute(
            "offset = lattice_foot_offset(f, p); dir = lattice_direction(f, p);",
            {"f": np.asarray(face), "p": np.stack([i, j], axis=-1)},
            {"offset": "vec3", "dir": "vec3"},
            header='#include "common/lattice.glsl"',
            setup=setup,
        )
    finally:
        scope.release()
    return out["offset"], out["dir"]


def test_block_layout():
    block = LatticeAnchor.at(0, HALF, HALF, 1.0).block
    assert len(block.tobytes()) == 320


def test_anchor_keeps_its_point_and_refuses_nonsense():
    anchor = LatticeAnchor.at(3, FULL, FULL, 10.0)
    assert (anchor.face, anchor.i, anchor.j) == tuple(int(a) for a in canonical_lattice(3, FULL, FULL))
    again = LatticeAnchor(anchor.direction, 10.0)
    assert (again.face, again.i, again.j) == (anchor.face, anchor.i, anchor.j)
    for bad in ((0, 0, 0), (np.nan, 0, 1), (1, 2)):
        with pytest.raises(ValueError, match="direction must be"):
            LatticeAnchor(bad, 1.0)
    with pytest.raises(ValueError, match="radius_m must be positive"):
        LatticeAnchor((1, 0, 0), -1.0)
    with pytest.raises(ValueError, match="expected face 0"):
        LatticeAnchor.at(6, 0, 0, 1.0)


@needs_long
@pytest.mark.parametrize("point", ANCHORS)
def test_twins_against_extended_precision(point):
    anchor = LatticeAnchor.at(*point, 6.371e6)
    face, i, j, exact = around(anchor, 1500, 3)
    # The reference itself is good to 1e-19 of the radius: 1e-10 of the smallest offsets.
    assert relative(anchor.foot_offset64(face, i, j), exact).max() < 5e-10
    assert relative(anchor.foot_offset32(face, i, j), exact).max() < 5e-7


@needs_long
@pytest.mark.gpu
@pytest.mark.parametrize("radius_m", [1e3, 6.371e6, 7e7])
def test_shader_offset(gpu, run_compute, radius_m):
    worst = []
    for number, point in enumerate(ANCHORS):
        anchor = LatticeAnchor.at(*point, radius_m)
        face, i, j, exact = around(anchor, 2000, number)
        found, directions = offsets(gpu, run_compute, anchor, face, i, j)
        error = relative(found, exact)
        worst.append((error.max(), np.quantile(error, 0.99)))
        np.testing.assert_allclose(directions, exact_direction(face, i, j).astype(float), atol=3e-7)
    assert np.max([w[0] for w in worst]) <= 5e-7
    assert np.max([w[1] for w in worst]) <= 3e-7


@pytest.mark.gpu
def test_shared_points_are_bit_equal(gpu, run_compute):
    rng = np.random.default_rng(5)
    along = np.concatenate([[0, 1, HALF, FULL - 1, FULL], rng.integers(0, FULL, 15)])
    zero, full = np.zeros_like(along), np.full_like(along, FULL)
    i = np.tile(np.concatenate([zero, full, along, along]), 6)
    j = np.tile(np.concatenate([along, along, zero, full]), 6)
    face = np.repeat(np.arange(6), len(i) // 6)
    names = np.stack(canonical_lattice(face, i, j), axis=-1)
    _, which = np.unique(names, axis=0, return_inverse=True)
    which = which.reshape(-1)
    assert len(np.unique(face[which == which[0]])) == 3  # the first point is a corner
    for point in ANCHORS[:8]:
        anchor = LatticeAnchor.at(*point, 6.371e6)
        found = np.concatenate(offsets(gpu, run_compute, anchor, face, i, j), axis=1).view(np.uint32)
        first = np.unique(which, return_index=True)[1]
        np.testing.assert_array_equal(found, found[first][which])


@pytest.mark.gpu
def test_shader_names_points_as_numpy_does(run_compute):
    rng = np.random.default_rng(6)
    face = rng.integers(0, 6, 4000)
    choice = np.array([0, 1, HALF, FULL - 1, FULL, 77_777_777])
    i, j = rng.choice(choice, (2, 4000))
    out = run_compute(
        "name = lattice_canonical(f, p);",
        {"f": face, "p": np.stack([i, j], axis=-1)},
        {"name": "ivec3"},
        header='#include "common/lattice.glsl"',
    )
    expected = canonical_lattice(face, i, j)
    np.testing.assert_array_equal(out["name"], np.stack([expected[1], expected[2], expected[0]], axis=-1))
