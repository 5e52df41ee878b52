"""Shapes of the boat and the buoys as mesh files (OBJ, metres, +X ahead, +Z up, z = 0 the waterline)."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Faces = NDArray[np.int64]

LENGTH_M, BEAM_M, DRAFT_M, DECK_M = 9.0, 3.2, 0.55, 0.85
BUOY_M, BUOY_DRAFT_M, BUOY_FREEBOARD_M = 1.8, 0.3, 0.45


def hull_sections(stations: int = 15, points: int = 9) -> Floats:
    """Sections (stations, points, 3) from stern to bow, each from the port deck's edge over the keel to starboard."""
    along = np.linspace(0.0, 1.0, stations)
    beam = (
        0.5
        * BEAM_M
        * np.where(along < 0.45, 0.85 + 0.15 * along / 0.45, 1.0 - (np.maximum(along - 0.45, 0.0) / 0.55) ** 2.4)
    )
    keel = -DRAFT_M * (1.0 - np.clip((along - 0.6) / 0.4, 0.0, 1.0) ** 3)
    deck = DECK_M * (1.0 + 0.5 * along**3)
    side = np.linspace(-1.0, 1.0, points)
    y = beam[:, None] * np.sign(side) * np.abs(side) ** 0.6
    z = keel[:, None] + (deck - keel)[:, None] * np.abs(side) ** 3.0
    x = np.broadcast_to((along - 0.5)[:, None] * LENGTH_M, y.shape)
    return np.stack([x, y, z], axis=-1)


def hull_mesh() -> tuple[Floats, Faces]:
    """The closed hull: sides and bottom, transom and deck."""
    sections = hull_sections()
    stations, points = sections.shape[:2]
    vertices = sections.reshape(-1, 3)
    at = np.arange(stations * points).reshape(stations, points)
    a, b, c, d = at[:-1, :-1], at[:-1, 1:], at[1:, 1:], at[1:, :-1]
    faces = [np.stack(t, axis=-1).reshape(-1, 3) for t in ((a, b, c), (a, c, d))]
    # Decks between the edges, and the transom.
    port, starboard = at[:, 0], at[:, -1]
    faces.append(np.stack([port[:-1], port[1:], starboard[1:]], axis=-1))
    faces.append(np.stack([port[:-1], starboard[1:], starboard[:-1]], axis=-1))
    faces.append(np.stack([np.full(points - 2, at[0, 0]), at[0, 2:], at[0, 1:-1]], axis=-1))
    return vertices, _outward(vertices, np.concatenate(faces))


def drum_mesh(diameter_m: float, low_m: float, high_m: float, sides: int = 32) -> tuple[Floats, Faces]:
    """An upright cylinder."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = 0.5 * diameter_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    low, high = (np.column_stack([ring, np.full(sides, z)]) for z in (low_m, high_m))
    points = np.concatenate([low, high, [[0.0, 0.0, low_m], [0.0, 0.0, high_m]]])
    k = np.arange(sides)
    n = (k + 1) % sides
    faces = np.concatenate([
        np.stack(t, axis=-1)
        for t in ((k, n, n + sides), (k, n + sides, k + sides), (n, k, np.full(sides, 2 * sides)),
                  (k + sides, n + sides, np.full(sides, 2 * sides + 1)))
    ])  # fmt: skip
    return points, faces


def _outward(points: Floats, faces: Faces) -> Faces:
    """Faces turned to look away from the middle: the hull is nearly convex."""
    a, b, c = (points[faces[:, k]] for k in range(3))
    inward = ((a + b + c) / 3.0 - points.mean(axis=0)) * np.cross(b - a, c - a)
    return np.where((inward.sum(axis=1) < 0.0)[:, None], faces[:, [0, 2, 1]], faces)


def write(folder: Path) -> dict[str, str]:
    """The shapes as files in the folder; paths by name: hull, drum, band (the buoy's painted waterline)."""
    return _written(folder, {
        "hull": hull_mesh(),
        "drum": drum_mesh(BUOY_M, -BUOY_DRAFT_M, BUOY_FREEBOARD_M),
        "band": drum_mesh(BUOY_M + 0.02, 0.0, 0.1),
    })  # fmt: skip


def raft_files(folder: Path) -> dict[str, str]:
    """The same of a raft: log, lying along X, of length and diameter 1."""
    points, faces = drum_mesh(1.0, -0.5, 0.5, 16)
    return _written(folder, {"log": (points[:, [2, 0, 1]], faces)})


def _written(folder: Path, meshes: dict[str, tuple[Floats, Faces]]) -> dict[str, str]:
    folder.mkdir(parents=True, exist_ok=True)
    paths = {}
    for name, (points, faces) in meshes.items():
        lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points]
        lines += [f"f {a} {b} {c}" for a, b, c in faces + 1]
        file = folder / f"{name}.obj"
        file.write_text("\n".join([*lines, ""]), encoding="ascii")
        paths[name] = str(file)
    return paths
