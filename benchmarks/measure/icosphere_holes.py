"""Holes of the icosphere as printed, by what makes them: cracks between neighbours, triangles that culling drops."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer
from ...engine.space import pixel_rays
from ...engine.surface.keys import container_of
from ...engine.surface.triangle_patch import on_edge, vertex_index
from .holes import must_hit

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class HolePixels:
    """Pixels of a picture that show the background although ground lies there."""

    cracks: int
    """Where a drawn triangle covers the ground that should be seen."""
    dropped: int
    """Where none does: culling ended it or one above it."""


def hole_pixels(printed: Renderer, ours: Renderer, camera: Camera) -> HolePixels:
    """Both renderers have the same scene and size; `ours`, which has no holes, says where the ground is."""
    seen = printed.render(camera, outputs=("surface",))["surface"]
    distance = ours.render(camera, outputs=("distance",))["distance"].astype(np.float64)
    state, planet = printed.camera_state(camera), printed.scene.planet
    field = planet.height_field()
    assert field is not None
    must = must_hit(state, printed.size, planet.radius_m, field.lowest_m)
    missing = must & (seen == 0) & np.isfinite(distance)
    points = state.position_m + pixel_rays(state, printed.size)[missing] * distance[missing][:, None]
    scheme, leaves = _leaves(printed)
    deepest = int(scheme.level(leaves).max()) if len(leaves) else 0
    at = container_of(scheme.at(points, np.full(len(points), deepest)), np.sort(leaves))
    return HolePixels(int((at >= 0).sum()), int((at < 0).sum()))


@dataclass(frozen=True)
class Borders:
    """Edges of drawn triangles with a drawn neighbour of the same level or a coarser one, and those that are open."""

    inner: int
    inner_open: int
    inner_px: float
    """How far apart the two sides are at worst, in pixels of their distance from the camera."""
    base: int
    """Along the edges of the icosahedron's own triangles."""
    base_open: int
    base_px: float


def borders(renderer: Renderer, camera: Camera) -> Borders:
    """Compares the vertices along every edge as the GPU has them after a frame, bit by bit."""
    renderer.render(camera)
    backend, own = _backend(renderer)
    scheme, leaves = _leaves(renderer)
    shape, order = backend.shape, np.argsort(leaves)
    if not len(leaves):
        return Borders(0, 0, 0.0, 0, 0, 0.0)
    with renderer.current():
        data = np.frombuffer(own.vertices.read(len(leaves) * shape.vertices * 24), "<f4")
    places = data.reshape(len(leaves), shape.vertices, 6)[:, :, :3]
    state = renderer.camera_state(camera)
    eye = state.position_m - renderer.views[0].proxy.anchor_m
    pixel = (state.tan_top - state.tan_bottom) / renderer.size[1]
    count, gaps = np.zeros(2, int), ([], [])
    for row, key in enumerate(leaves):
        for edge in range(3):
            across, other_edge = scheme.across(key, edge)
            at = int(container_of(across[None], leaves[order])[0])
            if at < 0 or (leaves[order[at]] == across and across < key):
                continue  # nothing drawn there or finer triangles, or seen from its other side
            levels = int(scheme.level(key)) - int(scheme.level(leaves[order[at]]))
            base = int(int(scheme.unpack(key)[0]) != int(scheme.unpack(across)[0]))
            count[base] += 1
            mine = _along(places[row], edge, shape.segments)
            theirs = _along(places[order[at]], int(other_edge), shape.segments)[::-1]
            if levels:  # a part of the neighbour's edge, which is the ancestor's: the edge keeps its number or turns
                theirs = _part(places[order[at]], shape.segments, mine)
            if not np.array_equal(_distinct(mine), _distinct(theirs)):
                gaps[base].append(_apart(mine, theirs, eye) / pixel)
    worst = [max(found, default=0.0) for found in gaps]
    return Borders(int(count[0]), len(gaps[0]), worst[0], int(count[1]), len(gaps[1]), worst[1])


def _backend(renderer: Renderer) -> tuple[Any, Any]:
    system: Any = renderer.system("terrain")
    return system.backend, system.backend.view(renderer.views[0])


def _leaves(renderer: Renderer) -> tuple[Any, Ints]:
    backend, own = _backend(renderer)
    return backend.shape.scheme, own.keys


def _along(places: NDArray[np.float32], edge: int, segments: int) -> NDArray[np.float32]:
    return places[vertex_index(*on_edge(edge, np.arange(segments + 1), segments), segments)]


def _part(places: NDArray[np.float32], segments: int, mine: NDArray[np.float32]) -> NDArray[np.float32]:
    """What lies between the ends of `mine` on the edge of a coarser triangle, whichever of its edges that is. The whole
    edge, where it has no such ends."""
    longest = places
    for edge in range(3):
        line = _along(places, edge, segments)
        first, last = ((line == end).all(axis=1).nonzero()[0] for end in (mine[0], mine[-1]))
        if len(first) and len(last) and first[0] != last[0]:
            step = 1 if last[0] > first[0] else -1
            ends = (first[0], last[-1]) if step > 0 else (first[-1], last[0])
            return line[np.arange(ends[0], ends[1] + step, step)]
    return longest


def _distinct(line: NDArray[np.float32]) -> NDArray[np.float32]:
    """Without repetitions one after another: what has ended its morph."""
    return line[np.concatenate([[True], (line[1:] != line[:-1]).any(axis=1)])]


def _apart(mine: NDArray[np.float32], theirs: NDArray[np.float32], eye: Floats) -> float:
    """The largest angle (tangent) from the eye between a vertex of one line and the other line."""
    worst = 0.0
    for line, other in ((mine, theirs), (theirs, mine)):
        points, start = line.astype(np.float64), other[:-1].astype(np.float64)
        way = other[1:].astype(np.float64) - start
        square = np.maximum((way * way).sum(axis=1), 1e-30)
        part = np.clip(((points[:, None] - start) * way).sum(axis=2) / square, 0.0, 1.0)
        gap = np.linalg.norm(points[:, None] - start - way * part[..., None], axis=2).min(axis=1)
        worst = max(worst, float((gap / np.linalg.norm(points - eye, axis=1)).max()))
    return worst
