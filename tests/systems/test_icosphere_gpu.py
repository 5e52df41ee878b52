"""The icosphere's lattice in the shader against extended precision, and equal bits across edges and corners."""

from __future__ import annotations

import numpy as np
import pytest

from planetfall.engine.surface.icosphere import CORNERS, FULL, ROOTS, direction_of, snap, vector_of
from planetfall.engine.surface.icosphere_anchor import TriangleAnchor
from planetfall.engine.surface.lattice_anchor import LatticeAnchor

LONG = np.longdouble
needs_long = pytest.mark.skipif(np.finfo(LONG).eps > 1e-18, reason="no extended precision on this machine")
STEP_RAD = 0.89 / FULL
"""Shortest distance of two lattice points on the unit sphere."""


def anchors() -> list[np.ndarray]:
    rng = np.random.default_rng(4)
    corners = CORNERS.astype(np.float64)
    edge = corners[ROOTS[7, 0]] + 0.3 * corners[ROOTS[7, 1]]
    some = [*rng.normal(size=(6, 3)), corners[0], corners[11], edge, corners[ROOTS[13]].sum(axis=0)]
    some += [np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])]
    return [LatticeAnchor(v, 1.0).direction for v in some]


def exact_direction(root, b, c):
    v = vector_of(root, b, c).astype(LONG)
    return v / np.sqrt((v * v).sum(axis=-1))[..., None]


def around(direction, count, seed, radius_m):
    """Lattice points at all distances, from one step to the antipode, and the exact offsets."""
    rng = np.random.default_rng(seed)
    away = rng.normal(size=(count, 3))
    away *= (10.0 ** rng.uniform(-9.2, 0.5, count) / np.linalg.norm(away, axis=1))[:, None]
    root, b, c = snap(direction + away)
    long = direction.astype(LONG)
    exact = (exact_direction(root, b, c) - long / np.sqrt((long * long).sum())) * LONG(radius_m)
    size = np.sqrt((exact * exact).sum(axis=-1)).astype(float)
    far = size > STEP_RAD * radius_m
    return root[far], b[far], c[far], exact[far], size[far]


def shader(gpu, run_compute, anchor, root, b, c):
    scope = gpu.scope("icosphere test")
    buffer = scope.buffer(np.frombuffer(anchor.block, np.uint8))
    try:
        return run_compute(
            """offset = triangle_foot_offset(r, p);
            Pair3 d = triangle_direction(r, p);
            high = d.high; low = d.low;""",
            {"r": np.asarray(root), "p": np.stack([b, c], axis=-1)},
            {"offset": "vec3", "high": "vec3", "low": "vec3"},
            header='#include "common/icosphere.glsl"',
            setup=lambda _: buffer.bind_to_uniform_block(9),
        )
    finally:
        scope.release()


@needs_long
@pytest.mark.gpu
@pytest.mark.parametrize("radius_m", [1e3, 6.371e6, 7e7])
def test_shader_offset(gpu, run_compute, radius_m):
    for number, direction in enumerate(anchors()):
        anchor = TriangleAnchor(direction, radius_m)
        root, b, c, exact, size = around(direction, 2000, number, radius_m)
        out = shader(gpu, run_compute, anchor, root, b, c)
        error = np.linalg.norm((out["offset"] - exact).astype(float), axis=1)
        # Each coordinate is rounded to float32 and multiplied by the radius, and directions are pairs of floats: a
        # step of the lattice is known to 2^-14 of it. A millimetre near the anchor would be 2^-36 of the largest.
        assert (error <= 2.1 * 2.0**-24 * size + 2.0**-44 * radius_m).all()
        found = out["high"].astype(np.float64) + out["low"]
        np.testing.assert_allclose(found, direction_of(root, b, c), rtol=0, atol=2.0**-44)


def border_points():
    """Points on all edges of all roots, corners among them: root, b, c."""
    rng = np.random.default_rng(5)
    along = np.concatenate([[0, 1, FULL // 2, FULL - 1, FULL], rng.integers(0, FULL, 12)])
    along = np.unique(np.concatenate([along, FULL - along]))  # roots run along an edge in opposite directions
    zero = np.zeros_like(along)
    b, c = np.concatenate([along, zero, along]), np.concatenate([zero, along, FULL - along])
    return np.repeat(np.arange(20), len(b)), np.tile(b, 20), np.tile(c, 20)


@pytest.mark.gpu
def test_shared_points_have_equal_bits(gpu, run_compute):
    root, b, c = border_points()
    names, which = np.unique(vector_of(root, b, c), axis=0, return_inverse=True)
    which = which.reshape(-1)
    both = [np.unique(root[which == k]) for k in range(len(names))]
    assert min(len(x) for x in both) >= 2 and sum(len(x) == 5 for x in both) == 12
    edges = {tuple(x) for x in both if len(x) == 2}
    assert len(edges) == 30
    for direction in anchors():
        out = shader(gpu, run_compute, TriangleAnchor(direction, 6.371e6), root, b, c)
        bits = np.concatenate([out["offset"], out["high"], out["low"]], axis=1).view(np.uint32)
        first = np.unique(which, return_index=True)[1]
        np.testing.assert_array_equal(bits, bits[first][which])


def test_anchor_refuses_nonsense():
    for bad in ((0, 0, 0), (np.nan, 0, 1), (1, 2)):
        with pytest.raises(ValueError, match="direction must be"):
            TriangleAnchor(bad, 1.0)
    with pytest.raises(ValueError, match="radius_m must be positive"):
        TriangleAnchor((1, 0, 0), -1.0)
