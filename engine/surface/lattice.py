"""The integer lattice on the tangent-warped cube: faces, cells, neighbours and canonical border points.

Each of the six faces carries the square grid of points (I, J) with I and J in [0, FULL]. With s = 2 I / FULL - 1 and
t = 2 J / FULL - 1 the direction of a point is normalize(tan(pi/4 s) x + tan(pi/4 t) y + z) in the face's own axes x, y,
z, so lattice steps are equal steps of angle along the face's middle lines. A cell (face, level, i, j) covers
I in [i, i + 1] * FULL / 2**level, J likewise. A point on a cube edge belongs to two or three faces; `canonical_lattice`
names it by the lowest of them, in integers, so that whoever computes it computes the same thing.

Everything is vectorised over leading dimensions: face, level, i, j, I, J broadcast against one another.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

FULL_BITS = 30
FULL = 1 << FULL_BITS
HALF = FULL >> 1
STEP_RAD = (np.pi / 2) / FULL
"""Angle of one lattice step in the face's own angles. On the sphere a step is 0.7 to 1 times radius * STEP_RAD long."""

FACES = ("+X", "-X", "+Y", "-Y", "+Z", "-Z")
FACE_AXES: Ints = np.array(
    [
        [[0, 0, 1], [0, -1, 0], [1, 0, 0]],
        [[0, 0, -1], [0, -1, 0], [-1, 0, 0]],
        [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
        [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
        [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
    ],
    dtype=np.int64,
)
"""(6, 3, 3): rows are the face's local x, local y and outward axis, in planet axes. All right-handed."""
FACE_AXES.setflags(write=False)
_AXES_F: Floats = FACE_AXES.astype(np.float64)


def angle_tangent(numerator: ArrayLike, denominator: ArrayLike) -> Floats:
    """tan(pi/4 (2 numerator / denominator - 1)), exactly -1, 0 and 1 where it should be."""
    s = np.asarray(numerator, dtype=np.float64) * (2.0 / np.asarray(denominator, dtype=np.float64)) - 1.0
    tangent = np.tan(s * (np.pi / 4))
    return np.where(np.abs(s) == 1.0, s, tangent)


def to_planet(face: ArrayLike, local: ArrayLike) -> Floats:
    """Turn vectors (..., 3) from face axes to planet axes. Exact: it only permutes and changes signs."""
    axes = _AXES_F[np.asarray(face)]
    vector = np.asarray(local, dtype=np.float64)
    return vector[..., 0:1] * axes[..., 0, :] + vector[..., 1:2] * axes[..., 1, :] + vector[..., 2:3] * axes[..., 2, :]


def to_face(face: ArrayLike, planet: ArrayLike) -> Floats:
    """Turn vectors (..., 3) from planet axes to face axes. Exact."""
    axes = _AXES_F[np.asarray(face)]
    return (axes * np.asarray(planet, dtype=np.float64)[..., None, :]).sum(axis=-1)


def direction_of(face: ArrayLike, i_full: ArrayLike, j_full: ArrayLike) -> Floats:
    """Unit directions (..., 3) of lattice points; I and J may be fractional.

    The same bits come out of each face that contains a border point: the vector is turned to planet axes before it is
    normalised.
    """
    x, y, face = np.broadcast_arrays(angle_tangent(i_full, FULL), angle_tangent(j_full, FULL), np.asarray(face))
    vector = to_planet(face, np.stack([x, y, np.ones_like(x)], axis=-1))
    squares = vector * vector
    return vector / np.sqrt(squares[..., 0] + squares[..., 1] + squares[..., 2])[..., None]


def locate(directions: ArrayLike) -> tuple[Ints, Floats, Floats]:
    """Face and fractional lattice coordinates (face, I, J) of directions (..., 3), which need not be unit vectors.

    A direction on a border is given to the lowest face. I and J are good to about 3e-7 of a lattice step.
    """
    vector = np.asarray(directions, dtype=np.float64)
    x, y, z = vector[..., 0], vector[..., 1], vector[..., 2]
    face = np.argmax(np.stack([x, -x, y, -y, z, -z], axis=-1), axis=-1)
    local = to_face(face, vector)
    i_full = (np.arctan2(local[..., 0], local[..., 2]) * (2 / np.pi) + 0.5) * FULL
    j_full = (np.arctan2(local[..., 1], local[..., 2]) * (2 / np.pi) + 0.5) * FULL
    return face, np.clip(i_full, 0, FULL), np.clip(j_full, 0, FULL)


def cell_of(directions: ArrayLike, level: ArrayLike) -> tuple[Ints, Ints, Ints]:
    """The cell (face, i, j) of a level that contains each direction."""
    face, i_full, j_full = locate(directions)
    count = np.int64(1) << np.asarray(level, dtype=np.int64)
    scale = count / FULL
    i = np.minimum(np.floor(i_full * scale).astype(np.int64), count - 1)
    j = np.minimum(np.floor(j_full * scale).astype(np.int64), count - 1)
    return face, i, j


def snap(directions: ArrayLike, level: ArrayLike) -> tuple[Ints, Ints, Ints]:
    """The nearest corner of the level's cells, as a canonical lattice point (face, I, J)."""
    face, i_full, j_full = locate(directions)
    size = np.int64(1) << (FULL_BITS - np.asarray(level, dtype=np.int64))
    i = np.rint(i_full / size).astype(np.int64) * size
    j = np.rint(j_full / size).astype(np.int64) * size
    return canonical_lattice(face, i, j)


def cell_edge_m(level: ArrayLike, radius_m: float) -> Floats:
    """Length of a cell's longest edge on the sphere: at most this, and at least 0.91 times this (0.78 on level 0)."""
    return radius_m * (np.pi / 2) * np.exp2(-np.asarray(level, dtype=np.float64))


def cell_corners(face: ArrayLike, level: ArrayLike, i: ArrayLike, j: ArrayLike) -> Floats:
    """Unit directions (..., 4, 3) of the corners (i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)."""
    size = np.int64(1) << (FULL_BITS - np.asarray(level, dtype=np.int64))[..., None]
    i_full = (np.asarray(i, dtype=np.int64)[..., None] + np.array([0, 1, 0, 1])) * size
    j_full = (np.asarray(j, dtype=np.int64)[..., None] + np.array([0, 0, 1, 1])) * size
    return direction_of(np.asarray(face)[..., None], i_full, j_full)


def cell_center(face: ArrayLike, level: ArrayLike, i: ArrayLike, j: ArrayLike) -> Floats:
    """Unit directions (..., 3) of the cells' middles in lattice coordinates."""
    size = np.exp2(FULL_BITS - np.asarray(level, dtype=np.float64))
    return direction_of(face, (np.asarray(i) + 0.5) * size, (np.asarray(j) + 0.5) * size)


_STEP_I = np.array([-1, 1, 0, 0])
_STEP_J = np.array([0, 0, -1, 1])


def neighbour(
    face: ArrayLike, level: ArrayLike, i: ArrayLike, j: ArrayLike, edge: ArrayLike
) -> tuple[Ints, Ints, Ints]:
    """The cell of the same level across an edge (0: i - 1, 1: i + 1, 2: j - 1, 3: j + 1), across cube edges too."""
    edge = np.asarray(edge, dtype=np.int64)
    new_i = np.asarray(i, dtype=np.int64) + _STEP_I[edge]
    new_j = np.asarray(j, dtype=np.int64) + _STEP_J[edge]
    face, new_i, new_j, count = (
        np.array(a) for a in np.broadcast_arrays(face, new_i, new_j, np.int64(1) << np.asarray(level, dtype=np.int64))
    )
    over = (new_i < 0) | (new_j < 0) | (new_i >= count) | (new_j >= count)
    if over.any():
        face[over], new_i[over], new_j[over] = _round_the_corner(face[over], new_i[over], new_j[over], count[over])
    return face, new_i, new_j


def _round_the_corner(face: Ints, i: Ints, j: Ints, count: Ints) -> tuple[Ints, Ints, Ints]:
    """Rename cells that lie one step beyond their face."""
    # Cell middles in doubled integers, as a point on the surface of the cube [-count, count]^3.
    # The point goes over the cube's edge to the side face, and lies half a cell below the edge there.
    u, v = np.clip(2 * i + 1 - count, -count, count), np.clip(2 * j + 1 - count, -count, count)
    new_face, new_u, new_v = _on_cube(face, u, v, count - 1, count)
    return new_face, (new_u + count - 1) >> 1, (new_v + count - 1) >> 1


def canonical_lattice(face: ArrayLike, i_full: ArrayLike, j_full: ArrayLike) -> tuple[Ints, Ints, Ints]:
    """Rename lattice points by the lowest face that contains them; points inside a face keep theirs. All integers."""
    face, i, j = (np.array(a, dtype=np.int64) for a in np.broadcast_arrays(face, i_full, j_full))
    border = (i == 0) | (i == FULL) | (j == 0) | (j == FULL)
    if border.any():
        half = np.full(int(border.sum()), HALF)
        face[border], u, v = _on_cube(face[border], i[border] - HALF, j[border] - HALF, half, half)
        i[border], j[border] = u + HALF, v + HALF
    return face, i, j


def _on_cube(face: Ints, u: Ints, v: Ints, w: Ints, half_width: Ints) -> tuple[Ints, Ints, Ints]:
    """The lowest face, and its local (u, v), of integer points given in face axes on the cube of this half width."""
    axes = FACE_AXES[face]
    point = u[..., None] * axes[..., 0, :] + v[..., None] * axes[..., 1, :] + w[..., None] * axes[..., 2, :]
    x, y, z = point[..., 0], point[..., 1], point[..., 2]
    on_face = np.stack([x, -x, y, -y, z, -z], axis=-1) == half_width[..., None]
    new_face = np.argmax(on_face, axis=-1)
    axes = FACE_AXES[new_face]
    return new_face, (point * axes[..., 0, :]).sum(axis=-1), (point * axes[..., 1, :]).sum(axis=-1)
