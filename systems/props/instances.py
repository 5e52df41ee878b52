"""Props as arrays: read from their components when one changed, and as a camera sees them, without a loop over them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...components import Shape, Transform
from ...engine.blocks.layout import StructLayout, Vec3
from ...engine.display import reflectance
from ...engine.made_shaders import made_shader
from ...engine.space import CameraState, frustum_planes, sphere_outside
from ...engine.wavelengths import Nanometres
from .meshes import Mesh, is_file

__all__ = ["SPHERE_LEVELS", "Props", "Visible", "read_props", "rotation_matrices", "seen_by"]

Floats = NDArray[np.float64]

SPHERE_LEVELS = 6
_SPHERE_PX = np.array([1.5, 6.0, 25.0, 100.0, 400.0])
"""Up to these radii in pixels a sphere of level 0, 1, ... is off by at most a third of a pixel."""
_SMALLEST_PX = 0.25
"""Props with a smaller radius than this are left out."""


@dataclass
class PropInstance:
    """A prop to be drawn, in planet axes. GLSL: ``generated/props.glsl``."""

    a_m: Annotated[Vec3, "the object's axes times its size"]
    b_m: Vec3
    c_m: Vec3
    place_m: Annotated[Vec3, "of its origin, from the camera"]
    color: Annotated[Vec3, "reflectance"]
    roughness: float
    back_a_m: Annotated[Vec3, "axes of the last frame minus those now"]
    back_b_m: Vec3
    back_c_m: Vec3
    back_m: Annotated[Vec3, "the same of its origin"]
    was_there: Annotated[float, "1, or 0 if it was not"]


@dataclass
class PropOccluder:
    """A prop that throws a shadow, in planet axes."""

    a_m: Annotated[Vec3, "half axes"]
    b_m: Vec3
    c_m: Vec3
    place_m: Annotated[Vec3, "of its middle, from the camera"]
    is_box: Annotated[float, "0 an ellipsoid, 1 a box"]


_INSTANCE, _OCCLUDER = StructLayout(PropInstance, "std430"), StructLayout(PropOccluder, "std430")
INSTANCE_DTYPE, OCCLUDER_DTYPE = _INSTANCE.dtype, _OCCLUDER.dtype
made_shader("generated/props.glsl", lambda: _INSTANCE.glsl + _OCCLUDER.glsl)


@dataclass
class Props:
    """N props. entities: (N,) their numbers. positions_m: (N, 3) f64, planet axes. axes: (N, 3, 3), columns the
    object's axes times its size.

    form: (N,) index into forms. radius_m: of a sphere around the position that holds it. center_m, half_m: its
    bounding box's middle (from the position) and half axes (N, 3, 3), columns. color: (N, 4) reflectance and roughness.
    """

    entities: NDArray[np.int64]
    positions_m: Floats
    axes: Floats
    form: NDArray[np.int64]
    forms: tuple[str, ...]
    radius_m: Floats
    center_m: Floats
    half_m: Floats
    color: Floats

    def __len__(self) -> int:
        return len(self.form)


def rotation_matrices(quaternions: Floats) -> Floats:
    """(N, 3, 3) of quaternions (N, 4) (x, y, z, w) of any length but zero."""
    x, y, z, w = (quaternions / np.linalg.norm(quaternions, axis=1)[:, None]).T
    return np.stack(
        [
            np.stack([1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)], axis=-1),
            np.stack([2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)], axis=-1),
            np.stack([2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)], axis=-1),
        ],
        axis=1,
    )


def read_props(
    found: Sequence[tuple[int, tuple[Transform, Shape]]], mesh_of: Callable[[str], Mesh], nm: Nanometres
) -> Props:
    """Arrays of the components; mesh_of gives the mesh of a file, nm: wavelengths of the reflectance."""
    transforms, shapes = [t for _, (t, _) in found], [s for _, (_, s) in found]
    names = [s.form for s in shapes]
    forms = tuple(sorted(set(names)))
    number = {name: k for k, name in enumerate(forms)}
    form = np.array([number[n] for n in names], dtype=np.int64)
    turn = rotation_matrices(np.array([t.orientation for t in transforms], dtype=np.float64).reshape(-1, 4))
    size = np.array([s.size_m for s in shapes], dtype=np.float64).reshape(-1, 3)
    axes = turn * size[:, None, :]
    bounds = [_bounds(name, mesh_of) for name in forms]
    middle = np.array([0.5 * (low + high) for low, high in bounds])[form]
    half = np.array([0.5 * (high - low) for low, high in bounds])[form]
    center = np.einsum("nij,nj->ni", axes, middle)
    half_axes = axes * half[:, None, :]
    round_ones = np.array([name == "sphere" for name in forms])[form]
    reach = np.where(round_ones, (size * half).max(axis=1), np.linalg.norm(size * half, axis=1))
    color = np.array([(*s.color, s.roughness) for s in shapes], dtype=np.float64).reshape(-1, 4)
    color[:, :3] = reflectance(color[:, :3], nm)
    positions = np.array([t.position_m for t in transforms], dtype=np.float64).reshape(-1, 3)
    entities = np.array([entity for entity, _ in found], dtype=np.int64)
    return Props(
        entities, positions, axes, form, forms, reach + np.linalg.norm(center, axis=1), center, half_axes, color
    )


def _bounds(form: str, mesh_of: Callable[[str], Mesh]) -> tuple[Floats, Floats]:
    if not is_file(form):
        return np.full(3, -0.5), np.full(3, 0.5)
    mesh = mesh_of(form)
    return mesh.low, mesh.high


@dataclass
class Visible:
    """instances: (V,) PropInstance, ordered by mesh. entities: (V,) their numbers. draws: (form, sphere's level, first,
    count). occluders: (C,) PropOccluder."""

    instances: NDArray[np.void]
    entities: NDArray[np.int64]
    draws: list[tuple[str, int, int, int]]
    occluders: NDArray[np.void]


def _way_back(instances: NDArray[np.void], props: Props, before: Props | None, rows: NDArray[np.int64]) -> None:
    """Write where the props of these rows came from: their axes and origins in `before` minus those now. before None:
    nothing has moved."""
    if before is None or before is props:
        instances["was_there"] = 1.0
        return
    order = np.argsort(before.entities, kind="stable")
    wanted = props.entities[rows]
    place = np.searchsorted(before.entities[order], wanted)
    was = order[np.minimum(place, len(order) - 1)] if len(order) else np.zeros(len(rows), np.int64)
    known = np.flatnonzero(before.entities[was] == wanted) if len(order) else np.zeros(0, np.int64)
    then, now = was[known], rows[known]
    moved = before.axes[then] - props.axes[now]
    for axis, name in enumerate(("back_a_m", "back_b_m", "back_c_m")):
        instances[name][known] = moved[:, :, axis]
    instances["back_m"][known] = before.positions_m[then] - props.positions_m[now]
    instances["was_there"][known] = 1.0


def seen_by(
    props: Props, camera: CameraState, height_px: int, shadow_radii: float, before: Props | None = None
) -> Visible:
    """What a camera sees, and what may throw a shadow into its picture: up to so many radii away from it. before: the
    props of the last frame, if they moved."""
    away = props.positions_m - camera.position_m  # the last step in double precision
    distance = np.linalg.norm(away, axis=1)
    pixel = camera.pixel_rad(height_px)
    size_px = props.radius_m / np.maximum(distance, props.radius_m) / pixel
    large = size_px > _SMALLEST_PX
    planes = frustum_planes(camera)
    seen = np.flatnonzero(large & ~sphere_outside(planes, away, props.radius_m))
    casts = np.flatnonzero(large & ~sphere_outside(planes, away, props.radius_m * shadow_radii))
    round_form = np.array([name == "sphere" for name in props.forms] or [False])
    round_ones = round_form[props.form[seen]]
    level = np.where(round_ones, np.searchsorted(_SPHERE_PX, size_px[seen]), 0)
    key = props.form[seen] * SPHERE_LEVELS + level
    order = np.argsort(key, kind="stable")
    seen, key = seen[order], key[order]
    firsts = np.flatnonzero(np.diff(key, prepend=-1))
    ends = np.append(firsts[1:], len(key))[: len(firsts)]  # none where none is seen
    draws = [
        (props.forms[k // SPHERE_LEVELS], int(k % SPHERE_LEVELS), int(a), int(b - a))
        for k, a, b in zip(key[firsts], firsts, ends, strict=True)
    ]
    instances, occluders = np.zeros(len(seen), INSTANCE_DTYPE), np.zeros(len(casts), OCCLUDER_DTYPE)
    for axis, name in enumerate(("a_m", "b_m", "c_m")):
        instances[name], occluders[name] = props.axes[seen, :, axis], props.half_m[casts, :, axis]
    instances["place_m"], occluders["place_m"] = away[seen], away[casts] + props.center_m[casts]
    instances["color"], instances["roughness"] = props.color[seen, :3], props.color[seen, 3]
    _way_back(instances, props, before, seen)
    occluders["is_box"] = np.array([name == "box" for name in props.forms] or [False])[props.form[casts]]
    return Visible(instances, props.entities[seen], draws, occluders)
