"""Triangular patches of N = 2^n segments a side: vertices, triangles, and which vertices stand for which.

Vertex (p, q), p + q <= N, is p steps from corner 0 towards corner 1 and q towards corner 2; rows of constant q follow
one another, k = q (N + 1) - q (q - 1) / 2 + p. All triangles of a patch and of its parent have edges in the same three
directions, so the parent's vertices are those with p and q even, and each of the others lies on an edge of the parent's
triangles: what it is on the parent's mesh is the mean of two vertices.

Edge e runs from corner e to corner e + 1, t counts along it. A neighbour counts the other way, which changes nothing:
steps of 2^skip divide N. Rounding t down along a cycle means that of the two edges at a corner one rounds towards it
and one away from it, and so no triangle ever turns over (towards it on one side only: with two edges that round away
from a corner, a triangle as wide as both steps would cover vertices that stay where they are).

The twin of assets/shaders/terrain/tiles/triangle.glsl. Arrays broadcast.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Ints = NDArray[np.int64]


def vertex_count(segments: int) -> int:
    """Vertices of a patch."""
    return (segments + 1) * (segments + 2) // 2


def vertex_index(p: ArrayLike, q: ArrayLike, segments: int) -> Ints:
    """k of vertex (p, q)."""
    p, q = np.asarray(p, dtype=np.int64), np.asarray(q, dtype=np.int64)
    return q * (segments + 1) - q * (q - 1) // 2 + p


def vertex_place(k: ArrayLike, segments: int) -> tuple[Ints, Ints]:
    """(p, q) of vertex k."""
    # Rows grow by one from the last: triangular numbers from the end. The root's error is far below the 1e-3.
    behind = vertex_count(segments) - 1 - np.asarray(k, dtype=np.int64)
    row = (0.5 * np.sqrt(8.0 * behind + 1.0) - 0.5 + 1e-3).astype(np.int64)
    q = segments - row
    return segments - q - (behind - row * (row + 1) // 2), q


def patch_indices(segments: int) -> NDArray[np.uint32]:
    """(segments^2, 3) triangles, counter-clockwise seen from outside, row by row."""
    triangles = []
    for q in range(segments):
        p = np.arange(segments - q)
        upright = np.stack([vertex_index(p, q, segments), vertex_index(p + 1, q, segments),
                            vertex_index(p, q + 1, segments)], axis=1)  # fmt: skip
        p = p[1:]
        inverted = np.stack([vertex_index(p, q, segments), vertex_index(p, q + 1, segments),
                             vertex_index(p - 1, q + 1, segments)], axis=1)  # fmt: skip
        both = np.empty((2 * (segments - q) - 1, 3), np.int64)
        both[0::2], both[1::2] = upright, inverted
        triangles.append(both)
    return np.concatenate(triangles).astype(np.uint32)


def edge_of(p: ArrayLike, q: ArrayLike, segments: int) -> Ints:
    """The edge that a vertex lies on; -1 for inner vertices and for corners."""
    p, q = np.broadcast_arrays(np.asarray(p, dtype=np.int64), np.asarray(q, dtype=np.int64))
    r = segments - p - q
    corner = (p == segments) | (q == segments) | (r == segments)
    return np.where(corner, -1, np.where(q == 0, 0, np.where(r == 0, 1, np.where(p == 0, 2, -1))))


def along(p: ArrayLike, q: ArrayLike, edge: ArrayLike, segments: int) -> Ints:
    """t of a vertex on an edge."""
    p, q, edge = (np.asarray(x, dtype=np.int64) for x in (p, q, edge))
    return np.where(edge == 0, p, np.where(edge == 1, q, segments - q))


def on_edge(edge: ArrayLike, t: ArrayLike, segments: int) -> tuple[Ints, Ints]:
    """(p, q) of the vertex t along an edge."""
    edge, t = np.asarray(edge, dtype=np.int64), np.asarray(t, dtype=np.int64)
    return (
        np.where(edge == 0, t, np.where(edge == 1, segments - t, 0)),
        np.where(edge == 0, 0, np.where(edge == 1, t, segments - t)),
    )


def even_vertices(k: ArrayLike, edge: ArrayLike, skip: ArrayLike, segments: int) -> tuple[Ints, Ints]:
    """The two vertices of which the parent has the mean where vertex k is; both k where the parent has it.

    On an edge (edge >= 0) among the multiples of 2^skip; vertices between these are left alone.
    """
    k, edge, skip = np.broadcast_arrays(*(np.asarray(x, dtype=np.int64) for x in (k, edge, skip)))
    p, q = vertex_place(k, segments)
    odd_p, odd_q = p & 1, q & 1
    # Both odd: along the third direction, p + q constant.
    step_p, step_q = odd_p, np.where(odd_p == 1, -odd_q, odd_q)
    inner = vertex_index(p - step_p, q - step_q, segments), vertex_index(p + step_p, q + step_q, segments)
    t, step = along(p, q, edge, segments), np.int64(1) << skip
    step = np.where(t & (2 * step - 1) == step, step, 0)
    outer = (vertex_index(*on_edge(edge, t + s * step, segments), segments) for s in (-1, 1))
    return tuple(np.where(edge < 0, i, o) for i, o in zip(inner, outer, strict=True))  # pyright: ignore[reportReturnType]


def collapsed(k: ArrayLike, edge: ArrayLike, skip: ArrayLike, segments: int) -> Ints:
    """The vertex that stands for k on an edge with this skip; k itself inside (edge < 0)."""
    k, edge, skip = np.broadcast_arrays(*(np.asarray(x, dtype=np.int64) for x in (k, edge, skip)))
    p, q = vertex_place(k, segments)
    t = (along(p, q, edge, segments) >> skip) << skip
    return np.where(edge < 0, k, vertex_index(*on_edge(edge, t, segments), segments))


def assemble(
    vertices: NDArray[np.float32], morph: float, edge_skip: ArrayLike, edge_morph: ArrayLike, segments: int
) -> NDArray[np.float32]:
    """What is drawn of a patch's own vertices (V, C): terrain/tiles/assemble.comp in numpy, bit for bit.

    morph: 0 as it is, 1 as its parent; edge_skip (3,), edge_morph (3,): of the edges, the same as the neighbours'.
    """
    k = np.arange(vertex_count(segments))
    edge = edge_of(*vertex_place(k, segments), segments)
    inside = edge < 0
    skip = np.where(inside, 0, np.asarray(edge_skip, dtype=np.int64)[edge])
    factor = np.where(inside, np.float32(morph), np.asarray(edge_morph, dtype=np.float32)[edge])[:, None]
    low, high = even_vertices(k, edge, skip, segments)
    middle = np.float32(0.5) * (vertices[low] + vertices[high])
    moved = vertices * (np.float32(1) - factor) + middle * factor
    moved = np.where((low != high)[:, None] & (factor > 0), moved, vertices)
    return moved[collapsed(k, edge, skip, segments)]
