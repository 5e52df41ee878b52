"""Shapes of stones as mesh files: worn balls, so that one sees them turn. The engine rolls the ball around each."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

KINDS = 4
_SHARP = 60.0
"""Of edges between two cuts: their radius is about 1 / 60 of the stone's."""


def stone_files(folder: Path) -> list[str]:
    """Writes the shapes (OBJ, radius 1) into the folder unless they are there; their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for kind in range(KINDS):
        file = folder / f"stone_{kind}.obj"
        if not file.exists():
            points, faces = worn_ball(kind)
            lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points]
            lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
            file.write_text("\n".join([*lines, ""]), encoding="ascii")
        files.append(str(file))
    return files


def worn_ball(seed: int, rings: int = 18) -> tuple[Floats, NDArray[np.int64]]:
    """A ball cut by planes, its edges worn: points (N, 3) within the unit ball, triangles (M, 3)."""
    rng = np.random.default_rng(seed)
    latitude = np.linspace(-0.5 * np.pi, 0.5 * np.pi, rings + 1)
    columns = 2 * rings
    longitude = 2.0 * np.pi * np.arange(columns) / columns
    lat, lon = np.meshgrid(latitude[1:-1], longitude, indexing="ij")
    ball = np.stack([np.cos(lat) * np.cos(lon), np.cos(lat) * np.sin(lon), np.sin(lat)], axis=-1).reshape(-1, 3)
    points = np.concatenate([[[0.0, 0.0, -1.0]], ball, [[0.0, 0.0, 1.0]]])
    cuts = rng.normal(size=(20, 3))
    cuts /= np.linalg.norm(cuts, axis=1)[:, None]
    depth = rng.uniform(0.74, 0.95, 20)
    reach = depth / np.maximum(points @ cuts.T, 1e-3)  # where each ray from the middle leaves each half space
    # A smooth minimum over all cuts and the ball itself: worn edges.
    radius = -np.log(np.exp(-_SHARP * np.minimum(reach, 2.0)).sum(axis=1) + np.exp(-_SHARP)) / _SHARP
    rough = rng.normal(0.0, 0.008, len(points))
    points = points * np.clip(radius + rough, 0.6, 1.0)[:, None]
    faces = []
    for ring in range(rings - 2):
        for k in range(columns):
            a, b = 1 + ring * columns + k, 1 + ring * columns + (k + 1) % columns
            faces += [(a, b, b + columns), (a, b + columns, a + columns)]
    top, last = len(points) - 1, 1 + (rings - 2) * columns
    for k in range(columns):
        faces += [(0, 1 + (k + 1) % columns, 1 + k), (top, last + k, last + (k + 1) % columns)]
    return points, np.array(faces, dtype=np.int64)
