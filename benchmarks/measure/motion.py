"""A camera that moves: jitter of fixed points, what a snap of the proxy changes, what a held one keeps."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Composite, Renderer
from ...engine.space import CameraState
from ...engine.surface.lattice import canonical_lattice, cell_edge_m
from ..evaluate import Evaluator
from .drawn import DrawnMesh, camera_coordinates, drawn_heights, screen
from .ground import NEAR_M, TERRAIN, on_screen_px

Floats = NDArray[np.float64]

SCREEN = (1920, 1080)

# The statements of terrain/gbuffer.vert.
_PROJECT = """
precise vec3 seen = position - frame.camera_offset_m;
float z = dot(seen, frame.camera_forward);
vec2 xy = vec2(dot(seen, frame.camera_right), dot(seen, frame.camera_up));
clip = vec4((xy - frame.projection_offset * z) / frame.projection_scale, frame.near_m, z);
"""


@dataclass(frozen=True)
class Jitter:
    """Fixed surface points against their true projection, at 1080 rows."""

    worst_px: float
    p99_px: float
    steps: int
    points: int
    snaps: int


def jitter(
    renderer: Renderer, cameras: list[Camera], rng: np.random.Generator, points: int = 2000, most_snaps: int = 1000
) -> Jitter:
    """Renders each camera (so small a picture that only its uniform blocks matter) and projects vertices on the GPU.

    The points are vertices of the mesh that is drawn at the time: a snap chooses new ones. Anti-aliasing is off for it:
    it moves the picture by fractions of a pixel on purpose.
    """
    renderer.scene.environment[Composite].antialiasing = "none"
    target = renderer.ctx.simple_framebuffer((16, 9))
    renderer.render_to(target, cameras[0])  # the systems' uniform blocks exist from the first frame on
    worst, errors, snaps = 0.0, [np.zeros(1)], -1
    mesh: DrawnMesh | None = None
    chosen = np.zeros((0, 3))
    with Evaluator(
        renderer.gpu, _PROJECT, {"position": "vec3"}, {"clip": "vec4"}, '#include "generated/frame.glsl"'
    ) as evaluate:
        for camera in cameras:
            renderer.render_to(target, camera)
            proxy_system: Any = renderer.system("proxy")
            generation = renderer.views[0].proxy.generation
            if mesh is None or generation != mesh.generation:
                snaps += 1
                if snaps > most_snaps:
                    break
                mesh = DrawnMesh.of(renderer)
                chosen = _points(mesh, renderer.camera_state(camera), rng, points)
            state = renderer.camera_state(camera)
            bind = partial(proxy_system.bind_anchor, renderer.views[0])
            clip = evaluate(bind, position=chosen)["clip"].astype(np.float64)
            local = camera_coordinates(state, chosen - (state.position_m - mesh.anchor_m))
            front = (local[:, 2] > 0.05) & (clip[:, 3] > 0.0)
            truth = screen(state, local[front], SCREEN)
            drawn = (clip[front, :2] / clip[front, 3:] * (0.5, -0.5) + 0.5) * SCREEN
            inside = ((truth >= 0.0) & (truth <= SCREEN)).all(axis=1)
            if inside.any():
                error = np.linalg.norm(drawn - truth, axis=1)[inside]
                worst = max(worst, float(error.max()))
                errors.append(error)
    renderer.gpu.leave(target)
    target.release()
    return Jitter(worst, float(np.quantile(np.concatenate(errors), 0.99)), len(cameras), points, max(snaps, 0))


def _points(mesh: DrawnMesh, state: CameraState, rng: np.random.Generator, count: int) -> Floats:
    """Vertices in front of the camera, as many near as far."""
    offsets = mesh.offsets_m.reshape(-1, 3)
    local = camera_coordinates(state, offsets - (state.position_m - mesh.anchor_m))
    front = np.flatnonzero(local[:, 2] > 0.05)
    away = np.linalg.norm(local[front], axis=1)
    # Spread evenly over the logarithm of the distance.
    order = front[np.argsort(away)]
    ranks = np.searchsorted(np.sort(away), np.geomspace(max(away.min(), 0.1), away.max(), count))
    return offsets[np.unique(order[np.minimum(ranks, len(order) - 1)])]


def along(camera: CameraState, step_m: float, steps: int) -> list[Camera]:
    """The camera moved sideways and forward in equal steps, level."""
    zenith = camera.direction
    way = camera.forward + camera.right
    way = way - zenith * float(way @ zenith)
    way = way / np.linalg.norm(way)
    return [Camera(camera.position_m + way * (step_m * k), camera.forward, camera.up) for k in range(steps)]


def turned(camera: CameraState, step_deg: float, steps: int) -> list[Camera]:
    """The camera turned about the vertical in equal steps."""
    zenith = camera.direction
    found = []
    for k in range(steps):
        angle = np.radians(step_deg * k)
        forward, up = (_rotate(v, zenith, angle) for v in (camera.forward, camera.up))
        found.append(Camera(camera.position_m, forward, up))
    return found


def _rotate(v: Floats, axis: Floats, angle: float) -> Floats:
    return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * float(axis @ v) * (1.0 - np.cos(angle))


@dataclass(frozen=True)
class Hold:
    """A proxy that is held."""

    identical: bool
    """All vertices kept their bits while the camera moved."""
    frames: int
    ran: tuple[str, ...]
    """Passes that ran although nothing at all had changed, of those that select or upload."""


@dataclass(frozen=True)
class Snap:
    """One snap of the proxy while the camera moved on."""

    distance_m: float
    shared: float
    """Share of the new grid's vertices within 1 km that the old grid had too, to 1e-3 of the local spacing."""
    drawn_shared: float
    """The same of the vertices that triangles use: cells that are foreshortened skip some."""
    on_lattice: float
    """Share that are points of the old grid's finest lattice, whether it had a vertex there or not."""
    finest_cell_m: float
    finest_spacing_m: float
    vertices: int
    p99_px: float
    worst_px: float
    """How far the drawn ground jumps on screen, at the renderer's own size."""


def hold(renderer: Renderer, camera: Camera, frames: int = 5) -> Hold:
    """Moves within the proxy's cell and compares the vertices bit by bit; then holds still."""
    renderer.render(camera)
    first = DrawnMesh.of(renderer)
    state = renderer.camera_state(camera)
    identical, seen = True, 0
    for moved in along(state, 1e-3, frames + 1)[1:]:
        renderer.render(moved)
        mesh = DrawnMesh.of(renderer)
        if mesh.generation != first.generation:
            break
        seen += 1
        identical &= mesh.vertices.tobytes() == first.vertices.tobytes() and bool((mesh.record == first.record).all())
    last = Camera(state.position_m, state.forward, state.up)
    renderer.render(last)
    renderer.render(last)
    ran = tuple(p.name for p in renderer.passes() if p.ran and p.name.endswith((".vertices", ".cull")))
    return Hold(identical, seen, ran)


def snap(renderer: Renderer, cameras: list[Camera], rng: np.random.Generator, points: int = 1500) -> Snap | None:
    """The first snap along the cameras: the frame before and the frame after, seen from the latter. None: no snap."""
    previous = cameras[0]
    renderer.render(previous)
    before = DrawnMesh.of(renderer)
    for camera in cameras[1:]:
        # What the old mesh shows from here has to be known before the new one replaces it.
        if renderer.views[0].proxy.cell.contains(renderer.camera_state(camera).position_m):
            previous = camera
            continue
        out = renderer.render(previous, outputs=("position", "surface"))
        before, old_state = DrawnMesh.of(renderer), renderer.camera_state(previous)
        rows, columns = np.nonzero(out["surface"] == TERRAIN)
        chosen = rng.choice(len(rows), min(points, len(rows)), replace=False)
        seen = out["position"][rows[chosen], columns[chosen]].astype(np.float64)
        feet = old_state.position_m + seen
        zenith = feet / np.linalg.norm(feet, axis=1, keepdims=True)
        old_heights = drawn_heights(before, zenith)
        state = renderer.camera_state(camera)
        renderer.render(camera)
        after = DrawnMesh.of(renderer)
        if after.generation == before.generation:
            previous = camera
            continue
        new_heights = drawn_heights(after, zenith)
        old_point = zenith * (after.radius_m + old_heights)[:, None] - state.position_m
        new_point = zenith * (after.radius_m + new_heights)[:, None] - state.position_m
        known = np.isfinite(old_heights) & np.isfinite(new_heights)
        moved = on_screen_px(state, old_point[known], new_point[known], renderer.size)
        shared, on_lattice, count = shared_vertices(before, after, state.position_m)
        drawn_shared = shared_vertices(before, after, state.position_m, drawn_only=True)[0]
        level = int(after.record["level"].max())
        return Snap(
            distance_m=float(renderer.views[0].proxy.cell.snap_distance_m),
            shared=shared,
            drawn_shared=drawn_shared,
            on_lattice=on_lattice,
            finest_cell_m=float(cell_edge_m(level, after.radius_m)),
            finest_spacing_m=float(cell_edge_m(level, after.radius_m)) / after.quads,
            vertices=count,
            p99_px=float(np.quantile(moved, 0.99)),
            worst_px=float(moved.max()),
        )
    return None


def shared_vertices(
    old: DrawnMesh, new: DrawnMesh, position_m: Floats, drawn_only: bool = False
) -> tuple[float, float, int]:
    """(share that the old grid had, share on its lattice, how many) of the new grid's vertices within 1 km.

    A vertex is shared when the old grid had one at the same lattice point, and both lie within 1e-3 of the new spacing
    of one another in space.
    """
    near, around = new.within(position_m, NEAR_M), old.within(position_m, 1.5 * NEAR_M)
    if drawn_only:
        near, around = near & new.used, around & old.used
    new_key, new_level, new_place = _keyed(new, near)
    old_key, old_level, old_place = _keyed(old, around)
    if not len(new_key):
        return 1.0, 1.0, 0
    order = np.argsort(old_key, kind="stable")
    at = np.minimum(np.searchsorted(old_key[order], new_key), len(order) - 1)
    same = old_key[order][at] == new_key
    apart = np.linalg.norm((new.anchor_m - old.anchor_m) + new_place - old_place[order][at], axis=1)
    spacing = cell_edge_m(new_level, new.radius_m) / new.quads
    shared = same & (apart <= 1e-3 * spacing)
    # The finest lattice that the old grid had within the same kilometre contains all coarser ones.
    finest = int(old_level.max())
    on_lattice = shared | (new_level <= finest)
    return float(shared.mean()), float(on_lattice.mean()), len(new_key)


def _keyed(mesh: DrawnMesh, chosen: NDArray[np.bool_]) -> tuple[NDArray[np.uint64], NDArray[np.int64], Floats]:
    """Canonical lattice point as a number, level and offset of vertices, each point once, by its finest cell."""
    face, i, j = canonical_lattice(*(a[chosen] for a in mesh.lattice))
    # 3 bits of face, 31 of I; J is folded in by a multiplication, so that all fits into 64 bits.
    key = ((face.astype(np.uint64) << np.uint64(31) | i.astype(np.uint64)) << np.uint64(30)) ^ (
        j.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    )
    level = np.broadcast_to(mesh.record["level"].astype(np.int64)[:, None], chosen.shape)[chosen]
    order = np.lexsort((-level, key))
    unique = order[np.concatenate([[True], key[order][1:] != key[order][:-1]])] if len(order) else order
    return key[unique], level[unique], mesh.offsets_m[chosen][unique]
