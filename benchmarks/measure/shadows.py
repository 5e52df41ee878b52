"""Shadows of the ground and its shelter from the sky, against rays through the ground in float64."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Renderer, TerrainSampler
from ...engine.blocks.bindings import SHADOW_MAP_UNIT
from ..evaluate import Evaluator

Floats = NDArray[np.float64]

TERRAIN = 1
_DISC = 24
_CHUNK = 400
_ASK = "light = light_visibility(point);"


@dataclass(frozen=True)
class Spots:
    """Places on the ground that a picture shows. points_m: (N, 3) planet-centred, on the true ground, a hair above it.
    seen_m: the same from the camera. normals: (N, 3), of the ground as wide as a pixel. sun: (3,)."""

    points_m: Floats
    seen_m: Floats
    normals: Floats
    sun: Floats
    radius_rad: float


def spots(renderer: Renderer, camera: Any, rng: np.random.Generator, count: int, sun: Any = None) -> Spots:
    """Random pixels of the ground, put where the ground truly is."""
    out = renderer.render(camera, sun=sun, outputs=("color", "position", "surface"))
    rows, columns = np.nonzero(out["surface"] == TERRAIN)
    chosen = rng.choice(len(rows), min(count, len(rows)), replace=False)
    seen = out["position"][rows[chosen], columns[chosen]].astype(np.float64)
    state = renderer.camera_state(camera)
    frame: Any = renderer.frame
    ground = TerrainSampler(renderer.scene)
    feet = state.position_m + seen
    feet /= np.linalg.norm(feet, axis=1, keepdims=True)
    pixel = state.pixel_rad(renderer.size[1])
    away = np.linalg.norm(seen, axis=1)
    heights = ground.height(feet)
    lift = 1e-3 + 0.1 * pixel * away  # a tenth of a pixel: a ray's first step is not the ground it stands on
    points = feet * (ground.radius_m + heights + lift)[:, None]
    footprint = np.maximum(pixel * away, 0.1)
    field: Any = renderer.scene.planet.height_field()
    _, gradient = field.height_gradient(feet, footprint)
    normals = feet - gradient
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Spots(points, points - state.position_m, normals, frame.sun.direction.copy(), frame.sun.angular_radius_rad)


def disc(direction: Floats, radius_rad: float, count: int = _DISC) -> Floats:
    """Directions (count, 3) spread evenly over the sun's disc."""
    helper = np.eye(3)[np.argmin(np.abs(direction))]
    a = np.cross(direction, helper)
    a /= np.linalg.norm(a)
    b = np.cross(direction, a)
    k = np.arange(count) + 0.5
    r, turn = radius_rad * np.sqrt(k / count), k * np.pi * (3.0 - np.sqrt(5.0))
    found = direction + (r * np.cos(turn))[:, None] * a + (r * np.sin(turn))[:, None] * b
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def seen_share(renderer: Renderer, places: Spots) -> Floats:
    """The share of the sun's disc that each place truly sees, (N,)."""
    ground = TerrainSampler(renderer.scene)
    towards = disc(places.sun, places.radius_rad)
    found = np.empty(len(places.points_m))
    reach = 20.0 * ground.radius_m
    for start in range(0, len(found), _CHUNK):
        part = places.points_m[start : start + _CHUNK]
        origins = np.repeat(part, len(towards), axis=0)
        hit = ground.raycast(origins, np.tile(towards, (len(part), 1)), reach)[0]
        found[start : start + _CHUNK] = 1.0 - hit.reshape(len(part), -1).mean(axis=1)
    return found


def open_share(renderer: Renderer, places: Spots, count: int = 192) -> Floats:
    """Light of an even sky that truly reaches each place past the ground, as a share of what its slope would get."""
    ground = TerrainSampler(renderer.scene)
    k = np.arange(count) + 0.5
    found = np.empty(len(places.points_m))
    for i, (point, normal) in enumerate(zip(places.points_m, places.normals, strict=True)):
        up = point / np.linalg.norm(point)
        helper = np.eye(3)[np.argmin(np.abs(normal))]
        a = np.cross(normal, helper)
        a /= np.linalg.norm(a)
        b = np.cross(normal, a)
        r, turn = np.sqrt(k / count), k * np.pi * (3.0 - np.sqrt(5.0))
        rays = (
            (r * np.cos(turn))[:, None] * a + (r * np.sin(turn))[:, None] * b + np.sqrt(1.0 - r * r)[:, None] * normal
        )
        sky = rays @ up > 0.0
        hit = ground.raycast(np.repeat(point[None], sky.sum(), axis=0), rays[sky], 0.1 * ground.radius_m)[0]
        found[i] = 1.0 - hit.mean()
    return found


class LightProbe:
    """Asks the shader contract sun_visibility as the last frame bound it."""

    def __init__(self, renderer: Renderer) -> None:
        self._renderer = renderer
        self._evaluate = Evaluator(
            renderer.gpu, _ASK, {"point": "vec3"}, {"light": "vec2"}, '#include "contract/sun_visibility.glsl"'
        )

    def __call__(self, seen_m: Floats) -> Floats:
        """(N, 2): share of the disc, share of the sky, at points (N, 3) seen from the camera."""
        renderer = self._renderer
        shadows: Any = renderer.system("shadows")

        def before() -> None:
            if shadows is not None and shadows.on:
                renderer.graph.resource("shadows.map").use(SHADOW_MAP_UNIT)
                found: Any = renderer.views[0].found(shadows)
                found.ubo.bind()

        return self._evaluate(before, point=seen_m)["light"].astype(np.float64)

    def release(self) -> None:
        self._evaluate.release()

    def __enter__(self) -> LightProbe:
        return self

    def __exit__(self, *_: object) -> None:
        self.release()


@dataclass(frozen=True)
class ShadowError:
    """Of ground that faces the sun. wrong: share of places that are off by more than half. mean: mean difference.
    shadowed: share of places that are truly hidden by half or more."""

    wrong: float
    mean: float
    shadowed: float
    places: int


def shadow_error(
    renderer: Renderer, camera: Any, rng: np.random.Generator, count: int = 1000, sun: Any = None
) -> ShadowError:
    """The contract against rays to the sun's disc, at random pixels of a settled picture."""
    renderer.settle(camera, sun=sun)
    places = spots(renderer, camera, rng, count, sun)
    with LightProbe(renderer) as probe:
        ours = probe(places.seen_m)[:, 0]
    facing = places.normals @ places.sun > 0.0
    true = seen_share(renderer, places)
    apart = np.abs(ours - true)[facing]
    if not apart.size:
        return ShadowError(0.0, 0.0, 0.0, 0)
    return ShadowError(float((apart > 0.5).mean()), float(apart.mean()), float((true[facing] < 0.5).mean()), apart.size)


@dataclass(frozen=True)
class Steadiness:
    """How the light at fixed places of the ground changes from frame to frame while the camera flies. p999, worst: of
    the share of the sun's disc that is seen, of places that both frames show."""

    p999: float
    p99: float
    worst: float
    mean: float
    frames: int


def steadiness(
    renderer: Renderer,
    cameras: list[Any],
    rng: np.random.Generator,
    count: int = 4000,
    sun: Any = None,
    dt_s: float = 1 / 30,
) -> Steadiness:
    """Along cameras, a frame each; the first is settled. The ground's own height decides, not the triangles'."""
    renderer.settle(cameras[0], sun=sun)
    changes: list[Floats] = []
    with LightProbe(renderer) as probe:
        held: tuple[Floats, Floats] | None = None
        for camera in cameras:
            renderer.render(camera, sun=sun, dt_s=dt_s)
            state = renderer.camera_state(camera)
            if held is not None:
                seen = held[0] - state.position_m
                changes.append(np.abs(probe(seen)[:, 0] - held[1]))
            places = spots(renderer, camera, rng, count, sun)
            held = places.points_m, probe(places.seen_m)[:, 0]
    every = np.concatenate(changes)
    p99, p999 = np.quantile(every, [0.99, 0.999])
    return Steadiness(float(p999), float(p99), float(every.max()), float(every.mean()), len(cameras))
