"""Errors of the drawn ground: heights and normals of vertices, the picture's ground in pixels, edges on screen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer
from ...engine.blocks.bindings import TERRAIN_TABLE_BUFFER
from ...engine.space import CameraState
from ...systems.terrain.height import TerrainField, height_at_points
from ..evaluate import Evaluator
from .drawn import DrawnMesh, angles_deg, camera_coordinates, height_errors, screen, some, true_normals, vertex_normals

NEAR_M = 1000.0
TERRAIN = 1

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class HeightError:
    """Heights on the GPU against the f64 twin, in metres, worst."""

    near_m: float
    """All layers, at vertices within 1 km of the camera; NaN when there is no ground that near."""
    anywhere_m: float
    """All layers, at vertices of the whole selection."""
    by_distance: float
    """The same, of the distance from the anchor or a kilometre, whichever is more."""
    drawn_near_m: float
    """Vertices as drawn within 1 km: without the layers that the height function leaves out as too fine for their
    spacing."""
    drawn_m: float
    """Vertices as drawn, anywhere."""
    vertices: int
    near_vertices: int


def vertex_heights(renderer: Renderer, camera: Camera, rng: np.random.Generator, most: int = 20_000) -> HeightError:
    """Renders a frame and compares up to `most` vertices near the camera and as many anywhere."""
    renderer.render(camera)
    mesh, field = DrawnMesh.of(renderer), ground_of(renderer)
    position = renderer.camera_state(camera).position_m
    near = some(mesh.within(position, NEAR_M), rng, most)
    anywhere = some(np.ones_like(near), rng, most)

    def function(chosen: NDArray[np.bool_]) -> tuple[float, float]:
        if not chosen.any():
            return float("nan"), float("nan")
        heights, feet = gpu_heights(renderer, mesh, chosen)
        error = np.abs(heights - height_at_points(feet, field.model))
        away = np.linalg.norm(feet - mesh.anchor.direction * mesh.radius_m, axis=1)
        return float(error.max()), float((error / np.maximum(away, NEAR_M)).max())

    def drawn(chosen: NDArray[np.bool_]) -> float:
        return float(np.abs(height_errors(mesh, field, chosen)).max()) if chosen.any() else float("nan")

    near_m, _ = function(near)
    return HeightError(near_m, *function(anywhere), drawn(near), drawn(anywhere), int(anywhere.sum()), int(near.sum()))


def ground_of(renderer: Renderer) -> TerrainField:
    """The f64 ground of the renderer's planet. RuntimeError when it has none."""
    field = renderer.scene.planet.height_field()
    if not isinstance(field, TerrainField):
        raise RuntimeError("the planet has no Terrain: nothing to measure")
    return field


def gpu_heights(
    renderer: Renderer, mesh: DrawnMesh, chosen: NDArray[np.bool_], spacing_m: float = 1e-3
) -> tuple[Floats, Floats]:
    """The shader's heights (N,) with all layers, and the very feet (N, 3) it was asked for, planet-centred in f64.

    A foot is an f32 offset from the anchor: thousands of kilometres away it is off its lattice point by decimetres, and
    the vertex moves with it.
    """
    face, i, j = (a[chosen] for a in mesh.lattice)
    lattice: Any = renderer.system("proxy")

    def bind() -> None:
        lattice.bind_anchor(renderer.views[0])
        bind_octaves(renderer)

    with Evaluator(
        renderer.gpu,
        "foot = lattice_foot_offset(face, ij); dh = terrain_point(foot, spacing_m).dh;",
        {"face": "int", "ij": "ivec2", "spacing_m": "float"},
        {"dh": "float", "foot": "vec3"},
        '#include "common/lattice.glsl"\n#include "terrain/height.glsl"',
    ) as evaluate:
        found = evaluate(bind, face=face, ij=np.stack([i, j], axis=1), spacing_m=np.full(len(i), spacing_m))
    feet = mesh.anchor.direction * mesh.radius_m + found["foot"].astype(np.float64)
    return mesh.anchor_height_m + found["dh"].astype(np.float64), feet


def bind_octaves(renderer: Renderer) -> None:
    """The terrain system's octave table, where terrain/height.glsl looks for it."""
    view: Any = renderer.views[0].found(renderer.system("terrain"))
    view.octaves.bind_to_storage_buffer(TERRAIN_TABLE_BUFFER)


@dataclass(frozen=True)
class NormalError:
    """Angles against the f64 surface at the same footprint, within 1 km, in degrees."""

    median_deg: float
    p99_deg: float
    worst_deg: float
    vertices: int


def vertex_normals_error(
    renderer: Renderer, camera: Camera, rng: np.random.Generator, most: int = 20_000
) -> tuple[NormalError, NormalError]:
    """(drawn normals, normals from central differences of f32 heights half a spacing away)."""
    renderer.render(camera)
    mesh, field = DrawnMesh.of(renderer), ground_of(renderer)
    near = some(mesh.within(renderer.camera_state(camera).position_m, NEAR_M), rng, most)
    if not near.any():
        raise RuntimeError("no ground within 1 km of the camera")
    directions, spacing = mesh.directions(near), mesh.grid_spacing(near)
    truth = true_normals(field, mesh.radius_m, directions, spacing)
    drawn = vertex_normals(mesh, near)
    differences = finite_difference_normals(renderer, mesh, near, spacing)
    return _normal_error(drawn, truth), _normal_error(differences, truth)


def _normal_error(found: Floats, truth: Floats) -> NormalError:
    angle = angles_deg(found, truth)
    return NormalError(float(np.median(angle)), float(np.quantile(angle, 0.99)), float(angle.max()), len(angle))


def finite_difference_normals(renderer: Renderer, mesh: DrawnMesh, chosen: NDArray[np.bool_], step_m: Floats) -> Floats:
    """What a shader without derivatives would do: heights in f32 on both sides, half a step away."""
    directions = mesh.directions(chosen)
    face, i, j = (a[chosen] for a in mesh.lattice)
    foot = mesh.anchor.foot_offset64(face, i, j)
    helper = np.eye(3)[np.argmin(np.abs(directions), axis=1)]
    u = np.cross(directions, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(directions, u)
    with Evaluator(
        renderer.gpu,
        """
        float h = 0.5 * step_m;
        float du = terrain_point(D + u * h, step_m).dh - terrain_point(D - u * h, step_m).dh;
        float dv = terrain_point(D + v * h, step_m).dh - terrain_point(D - v * h, step_m).dh;
        normal = normalize(zenith - (u * du + v * dv) / step_m * to_sphere);
        """,
        {"D": "vec3", "u": "vec3", "v": "vec3", "zenith": "vec3", "step_m": "float", "to_sphere": "float"},
        {"normal": "vec3"},
        '#include "terrain/height.glsl"',
    ) as evaluate:
        found = evaluate(
            lambda: bind_octaves(renderer),
            D=foot,
            u=u,
            v=v,
            zenith=directions,
            step_m=step_m,
            to_sphere=np.full(len(foot), mesh.radius_m / (mesh.radius_m + mesh.anchor_height_m)),
        )["normal"]
    return found.astype(np.float64)


@dataclass(frozen=True)
class PictureError:
    """Ground in a picture: how far the drawn surface is from the true one, as pixels on screen."""

    median_px: float
    p99_px: float
    worst_px: float
    p99_m: float
    pixels: int


def picture_error(
    renderer: Renderer, camera: Camera, rng: np.random.Generator, most: int = 20_000, field: Any = None
) -> PictureError | None:
    """From the position output against the f64 heights (the scene's, or those of another field): every pixel's point
    is moved up or down to the true ground and the way that it moves on screen is counted. None when no ground is in
    the picture."""
    out = renderer.render(camera, outputs=("position", "surface"))
    rows, columns = np.nonzero(out["surface"] == TERRAIN)
    if not len(rows):
        return None
    if len(rows) > most:
        chosen = rng.choice(len(rows), most, replace=False)
        rows, columns = rows[chosen], columns[chosen]
    state = renderer.camera_state(camera)
    seen = out["position"][rows, columns].astype(np.float64)
    radius = renderer.scene.planet.radius_m
    point = state.position_m + seen
    distance = np.linalg.norm(point, axis=1)
    zenith = point / distance[:, None]
    truth = (ground_of(renderer) if field is None else field).height(zenith)
    off = truth - (distance - radius)
    moved = seen + zenith * off[:, None]
    pixels = on_screen_px(state, seen, moved, renderer.size)
    return PictureError(
        float(np.median(pixels)), float(np.quantile(pixels, 0.99)), float(pixels.max()),
        float(np.quantile(np.abs(off), 0.99)), len(pixels),
    )  # fmt: skip


def on_screen_px(state: CameraState, a: Floats, b: Floats, size: tuple[int, int]) -> Floats:
    """Distances on screen between camera-relative points; one behind the camera counts as the whole picture."""
    first, second = camera_coordinates(state, a), camera_coordinates(state, b)
    behind = (first[:, 2] <= 0.0) | (second[:, 2] <= 0.0)
    first[behind, 2] = second[behind, 2] = 1.0
    away = np.linalg.norm(screen(state, first, size) - screen(state, second, size), axis=1)
    return np.where(behind, float(max(size)), away)


@dataclass(frozen=True)
class EdgeLengths:
    """Edges of triangles that are seen, in pixels."""

    median_px: float
    p99_px: float
    worst_px: float
    edges: int
    vertices_drawn: int
    triangles_drawn: int
    all_median_px: float
    """Hidden ones and those that face away included."""


def edge_lengths(renderer: Renderer, camera: Camera) -> EdgeLengths:
    """Every edge in the picture whose middle is not hidden, and that belongs to a triangle facing the camera."""
    out = renderer.render(camera, outputs=("distance",))
    mesh, state, size = DrawnMesh.of(renderer), renderer.camera_state(camera), renderer.size
    triangles = mesh.triangles(mesh.visible)
    seen = mesh.offsets_m.reshape(-1, 3) - (state.position_m - mesh.anchor_m)
    local = camera_coordinates(state, seen)
    pixels = screen(state, np.where(local[:, 2:] > 0.0, local, 1.0), size)
    in_front = local[:, 2] > 0.0
    corner = seen[triangles]
    faces_camera = np.einsum("nk,nk->n", np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]),
                             corner[:, 0]) < 0.0  # fmt: skip
    edges = np.concatenate([triangles[:, (0, 1)], triangles[:, (1, 2)], triangles[:, (2, 0)]])
    facing = np.tile(faces_camera, 3)
    # Each edge once; it faces the camera when one of its triangles does.
    edges, first = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    faces = np.zeros(len(edges), bool)
    np.logical_or.at(faces, first.ravel(), facing)
    middle = camera_coordinates(state, seen[edges].mean(axis=1))
    inside = in_front[edges].all(axis=1)
    inside &= ((pixels[edges] >= 0.0) & (pixels[edges] <= np.array(size))).all(axis=(1, 2))
    edges, faces, middle = edges[inside], faces[inside], middle[inside]
    length = np.linalg.norm(pixels[edges[:, 0]] - pixels[edges[:, 1]], axis=1)
    where = np.minimum(screen(state, middle, size).astype(np.int64), np.array(size) - 1)
    shown = out["distance"][where[:, 1], where[:, 0]].astype(np.float64)
    # Within a triangle's own depth of what the pixel shows.
    visible = faces & (np.linalg.norm(middle, axis=1) <= shown * 1.01 + 1e-3)
    statistics = renderer.stats
    found = length[visible]
    return EdgeLengths(
        float(np.median(found)), float(np.quantile(found, 0.99)), float(found.max()), len(found),
        statistics["vertices"], statistics["triangles"], float(np.median(length)),
    )  # fmt: skip
