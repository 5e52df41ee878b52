"""What a snap of the proxy changes in the picture: the same camera before and after it, from the `position` output."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer
from ...engine.space import CameraState
from ...engine.surface.lattice import canonical_lattice

Floats = NDArray[np.float64]
TERRAIN = 1
_FLAT = 0.03
"""Neighbouring pixels whose distances differ by more than this lie on different ground, or are seen too flat."""


def moved_px(state: CameraState, before: dict[str, Any], after: dict[str, Any]) -> Floats:
    """How far the ground moved up or down on screen, (N,) pixels, at pixels that show ground in both pictures.

    A pixel's two points lie on its ray. Where the ground is smooth about the pixel, its height changed by the distance
    between them times the ratio of the ray's and the zenith's cosine to the ground's normal, which is that of the
    neighbouring points. Pixels on an outline are left out.
    """
    first, second = before["position"].astype(np.float64), after["position"].astype(np.float64)
    size = first.shape[:2]
    both = (before["surface"] == TERRAIN) & (after["surface"] == TERRAIN)
    distance = np.linalg.norm(second, axis=-1)
    right, down = second[1:-1, 2:] - second[1:-1, :-2], second[2:, 1:-1] - second[:-2, 1:-1]
    near = distance[1:-1, 1:-1]
    smooth = both[1:-1, 1:-1]
    for neighbour in (distance[1:-1, 2:], distance[1:-1, :-2], distance[2:, 1:-1], distance[:-2, 1:-1]):
        with np.errstate(invalid="ignore"):
            smooth = smooth & (np.abs(neighbour - near) < _FLAT * near)
    normal = np.cross(down, right)[smooth]
    ray = second[1:-1, 1:-1][smooth]
    length = near[smooth]
    ray = ray / length[:, None]
    up = state.position_m + second[1:-1, 1:-1][smooth]
    up /= np.linalg.norm(up, axis=1, keepdims=True)
    farther = length - np.linalg.norm(first[1:-1, 1:-1][smooth], axis=1)
    rise = farther * np.einsum("nk,nk->n", ray, normal) / np.einsum("nk,nk->n", up, normal)
    aside = np.sqrt(np.maximum(1.0 - np.einsum("nk,nk->n", ray, up) ** 2, 0.0))
    pixel = state.pixel_rad(size[0])
    return np.abs(rise) * aside / (length * pixel)


@dataclass
class Pops:
    """What snaps along a path moved, over all of them."""

    snaps: int = 0
    at_once: list[Floats] = field(default_factory=list)
    """Pixels that the ground moves between the last picture before the snap and the first after it."""
    a_frame: list[float] = field(default_factory=list)
    """For each snap the 99.9th percentile of the frame in which the ground moves most, until it rests."""
    in_all: list[Floats] = field(default_factory=list)
    """Pixels that it moves until it rests."""
    unpaired: list[float] = field(default_factory=list)
    """Share of the drawn vertices that move."""

    @staticmethod
    def quantile(values: list[Floats], q: float) -> float:
        """Over all snaps; 0 without any."""
        found = np.concatenate(values) if values else np.zeros(1)
        return float(np.quantile(found, q)) if len(found) else 0.0


OUTPUTS = ("position", "surface")


def pops(renderer: Renderer, cameras: Sequence[CameraState], most: int = 8, frames: int = 18) -> Pops:
    """Fly along cameras until `most` snaps have been seen. At each, the camera before it looks again: at once, then
    frame by frame until the ground rests (frames of 1/60 s, at most `frames`)."""
    found = Pops()
    flown = (Camera(c.position_m, c.forward, c.up) for c in cameras)
    previous: Camera | None = None
    generation = -1
    for camera in flown:
        if found.snaps >= most:
            break
        if previous is None:
            renderer.settle(camera)
            renderer.render(camera, outputs=OUTPUTS, dt_s=1.0)
        else:
            before = renderer.render(previous, outputs=OUTPUTS, dt_s=1.0)
            generation = _generation(renderer)
            renderer.render(camera, outputs=OUTPUTS, dt_s=0.0)
            if _generation(renderer) != generation:
                new = _generation(renderer)
                after = renderer.render(previous, outputs=OUTPUTS, dt_s=0.0)
                if _generation(renderer) == new:
                    _watch(renderer, previous, before, after, frames, found)
        previous = camera
    return found


def prepared_pops(renderer: Renderer, cameras: Sequence[CameraState], most: int = 8, frames: int = 18) -> Pops:
    """As pops, of snaps that were prepared over frames of 1/60 s: the camera stands still from the frame before such a
    snap until the ground rests, and then flies on."""
    found = Pops()
    for number, state in enumerate(cameras):
        if found.snaps >= most:
            break
        camera = Camera(state.position_m, state.forward, state.up)
        if number == 0:
            renderer.settle(camera)
        before = renderer.render(camera, outputs=OUTPUTS, dt_s=1.0 / 60.0)
        if renderer.views[0].snap.ready:
            after = renderer.render(camera, outputs=OUTPUTS, dt_s=0.0)
            _watch(renderer, camera, before, after, frames, found)
    return found


def _watch(
    renderer: Renderer, camera: Camera, before: dict[str, Any], after: dict[str, Any], frames: int, found: Pops
) -> None:
    state = renderer.camera_state(camera)
    found.snaps += 1
    found.at_once.append(moved_px(state, before, after))
    found.unpaired.append(_moving_share(renderer))
    last, steps = after, [found.at_once[-1]]
    for _ in range(frames):
        now = renderer.render(camera, outputs=OUTPUTS, dt_s=1.0 / 60.0)
        steps.append(moved_px(state, last, now))
        last = now
    rest = renderer.render(camera, outputs=OUTPUTS, dt_s=1.0)
    steps.append(moved_px(state, last, rest))
    found.a_frame.append(max(float(np.quantile(s, 0.999)) for s in steps if len(s)))
    found.in_all.append(moved_px(state, before, rest))


@dataclass(frozen=True)
class SharedMove:
    """What vertices did that were in the mesh before a snap and after it, over all snaps."""

    worst_px: float
    p999_px: float
    shared: float
    """Share of the vertices that triangles use after a snap; the median over snaps."""
    snaps: int
    vertices: int


def shared_vertices_move(renderer: Renderer, cameras: Sequence[Camera]) -> SharedMove:
    """Every snap along a path: all vertices of the new mesh that the old one had at the same lattice point, as seen
    from the camera, in pixels of the renderer's size."""
    from .drawn import DrawnMesh

    moved: list[Floats] = []
    shares: list[float] = []
    before: DrawnMesh | None = None
    vertices = 0
    for camera in cameras:
        renderer.render(camera, dt_s=1.0)
        if before is not None and _generation(renderer) == before.generation:
            continue
        after = DrawnMesh.of(renderer)
        if before is not None:
            state = renderer.camera_state(camera)
            old, new = _by_place(before), _by_place(after)
            at = np.minimum(np.searchsorted(old[0], new[0]), len(old[0]) - 1)
            same = old[0][at] == new[0]
            offset = after.anchor_m - before.anchor_m
            apart = np.linalg.norm(offset + new[1][same] - old[1][at[same]], axis=1)
            away = np.linalg.norm(new[1][same] - (state.position_m - after.anchor_m), axis=1)
            pixel = state.pixel_rad(renderer.size[1])
            moved.append(apart / np.maximum(away, 1e-6) / pixel)
            shares.append(float(same.mean()))
            vertices += int(same.sum())
        before = after
    found = np.concatenate(moved) if moved else np.full(1, np.nan)
    share = float(np.median(shares)) if shares else float("nan")
    return SharedMove(float(found.max()), float(np.quantile(found, 0.999)), share, len(shares), vertices)


def _by_place(mesh: Any) -> tuple[NDArray[np.uint64], Floats]:
    """Numbers of the lattice points of all vertices that triangles use, sorted, and where they are drawn."""
    face, i, j = canonical_lattice(*(a[mesh.used] for a in mesh.lattice))
    # 3 bits of face, 31 of I; J is folded in by a multiplication, so that all fits into 64 bits.
    key = ((face.astype(np.uint64) << np.uint64(31) | i.astype(np.uint64)) << np.uint64(30)) ^ (
        j.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    )
    unique, first = np.unique(key, return_index=True)
    return unique, mesh.offsets_m[mesh.used][first]


def _generation(renderer: Renderer) -> int:
    return int(renderer.views[0].proxy.generation)


def _moving_share(renderer: Renderer) -> float:
    """Share of the drawn vertices that move by anything, of those that triangles of the overlay use."""
    system: Any = renderer.system("terrain")
    view: Any = system.backend.view(renderer.views[0])
    fade = getattr(view, "fade", None)
    if fade is None or not fade.running:
        return float("nan")
    with renderer.current():
        changed, starts = fade.read_changed(), fade.read_starts().astype(np.float64)
        ends = fade.mesh.read_vertices()["position_m"].astype(np.float64)
        visible = fade.mesh.read_visible().astype(np.int64)
        record = fade.mesh.read_cells()
    from .drawn import DrawnMesh

    proxy = renderer.views[0].proxy
    mesh = DrawnMesh(
        record=record, vertices=fade.mesh.read_vertices(), visible=visible, quads=fade.mesh.quads,
        radius_m=proxy.cell.radius_m, anchor=proxy.lattice, anchor_height_m=proxy.anchor_height_m,
        anchor_m=proxy.anchor_m, generation=proxy.generation, spacing=view.choice.spacing,
    )  # fmt: skip
    used = np.zeros(mesh.vertices.size, bool)
    used[mesh.triangles(visible).ravel()] = True
    used = used.reshape(mesh.vertices.shape)
    moving = changed[:, None] & (starts != ends).any(axis=-1)
    return float((moving & used).sum() / max(used.sum(), 1))


def forward_path(state: CameraState, step_m: float, steps: int) -> Iterator[CameraState]:
    """Level flight along the camera's heading."""
    up = state.position_m / np.linalg.norm(state.position_m)
    level = state.forward - up * (state.forward @ up)
    level /= np.linalg.norm(level)
    for k in range(steps):
        yield state.moved(state.position_m + level * (step_m * k))
