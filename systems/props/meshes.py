"""Meshes of props: spheres by level of detail, a box, and meshes from files, each of unit size.

A mesh is (vertices (N, 6) float32: position and normal, indices (M, 3) uint32). Files are read by trimesh (the extra
`props`), in metres, in the file's own axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.settings import SettingError

__all__ = ["FORMS", "Mesh", "MeshError", "box", "is_file", "load_mesh", "sphere"]

Floats = NDArray[np.float64]

FORMS = ("sphere", "box")
"""What needs no file."""
MOST_TRIANGLES = 2_000_000
_CREASE = np.cos(np.radians(40.0))
"""Faces that meet at a smaller angle than this are shaded as one smooth surface."""


class MeshError(SettingError):
    """A mesh file that can't be used; the message names the file, what is wrong and a remedy."""


@dataclass(frozen=True, eq=False)
class Mesh:
    """vertices: (N, 6) f32, indices: (M, 3) u32. low, high: bounds (3,) of the positions."""

    vertices: NDArray[np.float32]
    indices: NDArray[np.uint32]

    @property
    def low(self) -> Floats:
        return self.vertices[:, :3].min(axis=0).astype(np.float64)

    @property
    def high(self) -> Floats:
        return self.vertices[:, :3].max(axis=0).astype(np.float64)


@lru_cache(maxsize=8)
def sphere(level: int) -> Mesh:
    """A sphere of diameter 1: the icosahedron, each triangle cut into four `level` times."""
    golden = (1.0 + 5.0**0.5) / 2.0
    corners = [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0)]
    points: Floats = np.array([p[k:] + p[:k] for k in (0, 2, 1) for p in corners], dtype=np.float64)
    points /= np.linalg.norm(points[0])
    faces = _hull_of_icosahedron(points)
    for _ in range(level):
        edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
        unique, inverse = np.unique(edges, axis=0, return_inverse=True)
        middles = points[unique].sum(axis=1)
        middles /= np.linalg.norm(middles, axis=1)[:, None]
        ab, bc, ca = (inverse.reshape(3, -1) + len(points)).astype(np.int64)
        a, b, c = faces.T
        faces = np.concatenate([np.stack(t, axis=1) for t in ((a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca))])
        points = np.concatenate([points, middles])
    return Mesh(np.concatenate([0.5 * points, points], axis=1).astype(np.float32), faces.astype(np.uint32))


def _hull_of_icosahedron(points: Floats) -> NDArray[np.int64]:
    """Its 20 faces: triples of corners one edge apart, counter-clockwise from outside."""
    near = np.linalg.norm(points[:, None] - points[None], axis=-1) < 1.1
    count = len(points)
    faces = []
    for a in range(count):
        for b in range(a + 1, count):
            for c in range(b + 1, count):
                if near[a, b] and near[b, c] and near[a, c]:
                    outward = np.dot(np.cross(points[b] - points[a], points[c] - points[a]), points[a]) > 0.0
                    faces.append((a, b, c) if outward else (a, c, b))
    return np.array(faces, dtype=np.int64)


@lru_cache(maxsize=1)
def box() -> Mesh:
    """A box 1 long on each side, with flat faces."""
    vertices, indices = [], []
    for axis in range(3):
        for side in (-1.0, 1.0):
            normal, u = np.zeros(3), np.zeros(3)
            normal[axis], u[(axis + 1) % 3] = side, 1.0
            v = np.cross(normal, u)
            first = len(vertices)
            for s, t in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
                vertices.append([*(0.5 * (normal + s * u + t * v)), *normal])
            indices += [[first, first + 1, first + 2], [first, first + 2, first + 3]]
    return Mesh(np.array(vertices, np.float32), np.array(indices, np.uint32))


def is_file(form: str) -> bool:
    """Whether a Shape's form names a file."""
    return form not in FORMS


def load_mesh(path: str) -> Mesh:
    """The mesh of a file; read again when the file changes. MeshError says what is wrong with it."""
    file = Path(path)
    if not file.suffix:
        raise MeshError(f"Shape.form: expected {', '.join(map(repr, FORMS))} or a mesh file, found {path!r}")
    if not file.is_file():
        raise MeshError(f"{path}: no such mesh file (looked from {Path.cwd()})")
    return _load(path, file.stat().st_mtime_ns, file.stat().st_size)


@lru_cache(maxsize=64)
def _load(path: str, _changed: int, _size: int) -> Mesh:
    try:
        import trimesh
    except ImportError:
        raise MeshError(
            f"{path}: reading mesh files needs trimesh; install it with pip install 'planetfall[props]'"
        ) from None
    try:
        # What readers raise for a broken file is anything at all: ValueError, IndexError, KeyError, struct.error ...
        loaded: Any = trimesh.load(path, force="mesh", process=False)
        vertices = np.asarray(loaded.vertices, dtype=np.float64)
        faces = np.asarray(loaded.faces, dtype=np.int64)
    except Exception as error:
        raise MeshError(f"{path}: can't be read as a mesh: {type(error).__name__}: {error}") from error
    if vertices.ndim != 2 or faces.ndim != 2 or not len(vertices) or not len(faces):
        raise MeshError(f"{path}: there are no triangles in it")
    if len(faces) > MOST_TRIANGLES:
        raise MeshError(f"{path}: {len(faces)} triangles are too many ({MOST_TRIANGLES}); simplify it")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise MeshError(f"{path}: a triangle names vertex {faces.max()}, but there are {len(vertices)}")
    if not np.isfinite(vertices).all():
        raise MeshError(f"{path}: vertex {int(np.flatnonzero(~np.isfinite(vertices).all(axis=1))[0])} is not finite")
    if np.abs(vertices).max() > 1e7:
        raise MeshError(f"{path}: it reaches {np.abs(vertices).max():g} m from its origin; 1e7 is the most")
    try:
        return mesh_of(vertices, faces)
    except MeshError as error:
        raise MeshError(f"{path}: {error}") from None


def mesh_of(vertices: Floats, faces: NDArray[np.int64]) -> Mesh:
    """A mesh with normals that are smooth except across creases."""
    _, same = np.unique(vertices, axis=0, return_inverse=True)  # files with flat faces repeat their vertices
    same = same.reshape(-1)
    a, b, c = vertices[faces].swapaxes(0, 1)
    area = np.cross(b - a, c - a)  # twice the area along the normal
    length = np.linalg.norm(area, axis=1)
    kept = length > 0.0
    if not kept.any():
        raise MeshError("its triangles are all without area")
    faces, area, length = faces[kept], area[kept], length[kept]
    unit = area / length[:, None]
    # Each corner's normal: the mean of the faces around its vertex that bend away less than a crease does.
    owner = same[faces].ravel()
    order = np.argsort(owner, kind="stable")
    starts = np.searchsorted(owner[order], owner)
    counts = np.searchsorted(owner[order], owner, side="right") - starts
    corner = np.repeat(np.arange(len(owner)), counts)
    within = np.arange(len(corner)) - np.repeat(np.cumsum(counts) - counts, counts)
    other = order[np.repeat(starts, counts) + within] // 3
    smooth = (unit[corner // 3] * unit[other]).sum(axis=1) > _CREASE
    normals = np.zeros((len(owner), 3))
    np.add.at(normals, corner[smooth], area[other[smooth]])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    corners = np.concatenate([vertices[faces].reshape(-1, 3), normals], axis=1).astype(np.float32)
    shared, index = np.unique(corners, axis=0, return_inverse=True)
    return Mesh(shared, index.reshape(-1, 3).astype(np.uint32))
