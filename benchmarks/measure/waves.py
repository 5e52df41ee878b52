"""Waves as shaders compute them: places to ask at, true normals, pictures to compare with, times of passes."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ... import Camera, Composite, Exposure, Ocean, Renderer, Scene
from ...engine.waves import WaveSet, at_directions, displacement
from ...engine.waves.anchor import anchor_axes
from ..scenes import preset_scene
from ..timing import Timing
from .flip import flip
from .frames import FinishTimers

__all__ = [
    "OPEN_SEA",
    "SeaTimes",
    "against_printed",
    "around",
    "converged",
    "degrees_between",
    "height_error",
    "open_sea",
    "sea_scene",
    "sea_times",
    "true_normals",
]

Floats = NDArray[np.float64]

OPEN_SEA = (24.0, -78.4)
"""Latitude and longitude of deep water on Earth, far from land."""
_PITCH_DEG = {5.0: -5.0, 1000.0: -14.0, 1.0e4: -25.0, 4.0e5: -40.0}
_PASSES = ("ocean.displace", "ocean.gbuffer", "ocean.swell", "ocean.surface")


def open_sea(altitude_m: float) -> Camera:
    """A camera over deep water that looks along the swell and slightly down."""
    return Camera.at(*OPEN_SEA, altitude_m, heading_deg=270.0, pitch_deg=_PITCH_DEG[altitude_m])


def sea_scene(wave_count: int, method: str = "ours", ev100: float = 14.5) -> Scene:
    """Earth with so many waves, by day over OPEN_SEA, at an exposure that doesn't adapt, without anti-aliasing."""
    scene = preset_scene("earth")
    sea = scene.planet[Ocean]
    sea.wave_count, sea.method = wave_count, method
    scene.environment[Composite].antialiasing = "none"
    scene.environment.add(Exposure(mode="fixed", ev100=ev100))
    sun = scene.sun
    sun.elevation_deg, sun.azimuth_deg = 35.0, 230.0
    sun.latitude_deg, sun.longitude_deg = OPEN_SEA
    return scene


def around(anchor: Floats, radius_m: float, rng: np.random.Generator, count: int, reach_m: float = 1000.0) -> Floats:
    """Unit directions (count, 3) within reach of an anchor (3,), as many near it as far."""
    east, north = anchor_axes(anchor)
    distance, heading = reach_m * rng.uniform(0.0, 1.0, count), rng.uniform(0.0, 2.0 * np.pi, count)
    v = anchor + distance[:, None] / radius_m * (np.cos(heading)[:, None] * east + np.sin(heading)[:, None] * north)
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def true_normals(waves: WaveSet, v: Floats, time_s: float, step_m: float = 0.02) -> Floats:
    """Normals (N, 3) from central differences of float64 positions, which know nothing of tangents."""
    sides = []
    for axis in anchor_axes(v):
        ends = []
        for sign in (1.0, -1.0):
            w = v + sign * step_m / waves.radius_m * axis
            w = w / np.linalg.norm(w, axis=1, keepdims=True)
            # Relative to v's own place: differences of numbers of 1e7 m would leave 1e-9 m.
            ends.append((w - v) * waves.radius_m + displacement(waves, w, time_s))
        sides.append(ends[0] - ends[1])
    normal = np.cross(sides[0], sides[1])
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def degrees_between(a: Floats, b: Floats) -> Floats:
    """Angles (N,) between vectors (N, 3) and unit vectors (N, 3)."""
    a = a / np.linalg.norm(a, axis=1, keepdims=True)
    return np.degrees(2.0 * np.arcsin(np.clip(0.5 * np.linalg.norm(a - b, axis=1), 0.0, 1.0)))


def converged(
    camera: Camera, size: tuple[int, int], wave_count: int, time_s: float, finer: int = 4, quality: str = "medium"
) -> NDArray[np.uint8]:
    """The picture with finer x finer samples a pixel, (H, W, 3): none of them leaves out what it can show."""
    width, height = size
    overrides = {"ocean.footprint_px": 0.5, "terrain.edge_px": 4.0 * finer}
    with Renderer(sea_scene(wave_count), (width * finer, height * finer), quality, overrides) as renderer:
        picture = renderer.render(camera, time_s=time_s)["color"]
    mean = picture.reshape(height, finer, width, finer, 3).astype(np.float64).mean(axis=(1, 3))
    return np.round(mean).astype(np.uint8)


def height_error(renderer: Renderer, camera: Camera, time_s: float, reach_m: float, waves: WaveSet) -> Floats:
    """Metres (N,) by which the drawn sea within reach is higher than the float64 sea there, pixel by pixel."""
    out = renderer.render(camera, time_s=time_s, outputs=("position", "surface"))
    near = (out["surface"] == 2) & (np.linalg.norm(out["position"], axis=2) < reach_m)
    points = renderer.camera_state(camera).position_m + out["position"][near].astype(np.float64)
    distance = np.linalg.norm(points, axis=1)
    calm, _, moved = at_directions(waves, points / distance[:, None], np.full(len(points), time_s))
    return distance - np.linalg.norm(calm * waves.radius_m + moved, axis=1)


@dataclass(frozen=True)
class SeaTimes:
    """Time of a frame of moving water: of the passes that make its shape, one by one, and of all of it."""

    shape: Timing
    """ocean.displace, gbuffer, swell and surface, each waited for."""
    frame: Timing


def sea_times(renderers: Mapping[str, Renderer], camera: Camera, runs: int) -> dict[str, SeaTimes]:
    """Renderers, each with a context of its own, take turns; the camera stands still and time goes on."""
    moments = (0.1 * turn for turn in itertools.count())
    targets: dict[str, moderngl.Framebuffer] = {}

    def draw(name: str) -> float:
        renderer = renderers[name]
        with renderer.ctx:
            if name not in targets:
                targets[name] = renderer.ctx.simple_framebuffer(renderer.size)
            renderer.ctx.finish()
            started = time.perf_counter()
            renderer.render_to(targets[name], camera, time_s=next(moments))
            renderer.ctx.finish()
            return (time.perf_counter() - started) * 1e3

    whole: dict[str, list[float]] = {name: [] for name in renderers}
    for turn in range(runs + 2):
        for name in renderers:
            elapsed = draw(name)
            if turn >= 2:
                whole[name].append(elapsed)
    shape = _shapes(renderers, draw, runs)
    for name, target in targets.items():
        with renderers[name].ctx:
            target.color_attachments[0].release()
            target.release()
    return {name: SeaTimes(Timing.of(shape[name]), Timing.of(whole[name])) for name in renderers}


SIDES: Mapping[str, tuple[str, Mapping[str, float]]] = {
    "paper": ("paper_2018", {}),
    "paper, edges of 4 px": ("paper_2018", {"terrain.edge_px": 4.0}),
    "ours": ("ours", {}),
    "ours, pixels of 3": ("ours", {"ocean.footprint_px": 3.0}),
    "ours, pixels of 8, edges of 30 px": ("ours", {"ocean.footprint_px": 8.0, "terrain.edge_px": 30.0}),
}
"""Method and knobs of what is compared."""


def against_printed(
    camera: Camera, size: tuple[int, int], waves: int, runs: int, time_s: float = 7.0
) -> tuple[dict[str, float], dict[str, SeaTimes]]:
    """Mean FLIP to a converged picture, and times, of each of SIDES."""
    wanted = converged(camera, size, waves, time_s, finer=3)
    with ExitStack() as stack:
        sides = {
            name: stack.enter_context(Renderer(sea_scene(waves, method), size, "medium", dict(knobs)))
            for name, (method, knobs) in SIDES.items()
        }
        seen = {}
        for name, renderer in sides.items():
            with renderer.ctx:
                seen[name] = float(flip(wanted, renderer.render(camera, time_s=time_s)["color"]).mean())
        return seen, sea_times(sides, camera, runs)


def _shapes(renderers: Mapping[str, Renderer], draw: Callable[[str], float], runs: int) -> dict[str, list[float]]:
    """Milliseconds of the passes that make the sea's shape, frame by frame."""
    found: dict[str, list[float]] = {name: [] for name in renderers}
    backends: dict[str, Any] = {name: r.own.backend for name, r in renderers.items()}
    kept = {name: backend.create_timers for name, backend in backends.items()}
    try:
        for name, renderer in renderers.items():
            backends[name].create_timers = lambda count, ctx=renderer.ctx: FinishTimers(ctx, count)
            with renderer.ctx:
                renderer.graph.gpu_timing = True
        for turn in range(runs + 2):
            for name, renderer in renderers.items():
                draw(name)
                times = [p.gpu_ms for p in renderer.passes() if p.name in _PASSES and p.gpu_ms is not None]
                if turn >= 2:
                    found[name].append(sum(times))
    finally:
        for name, renderer in renderers.items():
            with renderer.ctx:
                renderer.graph.gpu_timing = False
            backends[name].create_timers = kept[name]
    return found
