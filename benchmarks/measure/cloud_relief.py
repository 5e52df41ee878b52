"""How much of a deck's relief pictures of clouds show while frames go on: against a mean of many rays through parts of
pixels."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter

from ... import Camera, Renderer, Scene, View, view
from ...components import Clouds, Ocean, Terrain
from ...quality import resolve_quality
from ..scenes import preset_scene

__all__ = [
    "FRAME_S",
    "SIZE",
    "Shown",
    "camera_of",
    "deck",
    "kept",
    "mean_light",
    "settled",
    "truth",
    "while_running",
]

Floats = NDArray[np.float64]
SIZE = (128, 64)
FRAME_S = 1.0 / 30.0
_FINER = 2
"""Pixels of the truth that one of the picture has a side."""


@dataclass(frozen=True)
class Shown:
    """light: (64, 128) of clouds, green, relative to its mean; frame_ms: processor time of one of its frames."""

    light: Floats
    frame_ms: float


def deck() -> tuple[Scene, View]:
    """View cloud_sea without ground and sea."""
    scene = preset_scene("earth", True)
    for kind in (Terrain, Ocean):
        scene.planet.remove(kind)
    scene.planet[Clouds].layers = ()
    return scene, view("cloud_sea", scene.planet)


def camera_of(seen: View, back_m: float = 0.0, away: bool = False) -> Camera:
    """128 x 64 of the view's 640 x 360 pixels, below its horizon; so many metres behind its place. away: it looks to
    the other side."""
    per_px = math.tan(math.radians(0.5 * seen.fov_y_deg)) / 180.0
    sides = [math.degrees(math.atan(px * per_px)) for px in (-90, 38, -110, -46)]
    place, forward = np.asarray(seen.position_m), np.asarray(seen.forward)
    up = place / np.linalg.norm(place)
    level = forward - (forward @ up) * up
    place = place - back_m * level / np.linalg.norm(level)
    ahead = forward - 2.0 * level if away else forward
    return Camera(place, ahead, seen.up, frustum_deg=sides, ev100=seen.ev100)


def _light(renderer: Renderer) -> Floats:
    """Green light of clouds in the last frame, relative to its mean."""
    found = _green(renderer)
    return found / found.mean()


def mean_light(renderer: Renderer) -> float:
    """Mean of the green light of clouds in the last frame."""
    return float(_green(renderer).mean())


def _green(renderer: Renderer) -> Floats:
    held = renderer.graph.resource("clouds.full")
    kind = np.float16 if held.dtype == "f2" else np.float32
    with renderer.current():
        return np.frombuffer(held.read(), kind).reshape(held.size[1], held.size[0], -1)[..., 1].astype(np.float64)


def truth() -> Floats:
    """(64, 128): a ray for each quarter of a pixel, four times, with the steps of medium."""
    scene, seen = deck()
    each = {"clouds.stride": 1, "clouds.samples": 4, "composite.antialiasing": "none"}
    with Renderer(scene, (SIZE[0] * _FINER, SIZE[1] * _FINER), "medium", each) as renderer:
        renderer.settle(camera_of(seen), 0.0, seen.sun)
        renderer.render(camera_of(seen), 0.0, seen.sun)
        found = _light(renderer)
    return found.reshape(SIZE[1], _FINER, SIZE[0], _FINER).mean(axis=(1, 3))


def _renderer(scene: Scene, quality: str) -> Renderer:
    """Whose picture of clouds has SIZE, be it coarser than the frame."""
    px = int(resolve_quality(quality)["clouds.picture_px"])
    return Renderer(scene, (SIZE[0] * px, SIZE[1] * px), quality)


def settled(quality: str) -> Shown:
    """A still camera's picture, which gathers its samples."""
    scene, seen = deck()
    with _renderer(scene, quality) as renderer:
        renderer.settle(camera_of(seen), 0.0, seen.sun)
        began = time.process_time()
        renderer.render(camera_of(seen), 0.0, seen.sun)
        return Shown(_light(renderer), 1e3 * (time.process_time() - began))


def while_running(quality: str, way_m: float, frames: int = 80) -> Shown:
    """After a cut, so many frames of a camera that flies way_m in each, while time runs."""
    scene, seen = deck()
    with _renderer(scene, quality) as renderer:
        renderer.settle(camera_of(seen, frames * way_m), -frames * FRAME_S, seen.sun)
        # A cut: a glance to the other side.
        renderer.render(camera_of(seen, frames * way_m, away=True), -frames * FRAME_S, seen.sun, dt_s=FRAME_S)
        began = time.process_time()
        for k in range(frames - 1, -1, -1):
            renderer.render(camera_of(seen, k * way_m), -k * FRAME_S, seen.sun, dt_s=FRAME_S)
        return Shown(_light(renderer), 1e3 * (time.process_time() - began) / frames)


def kept(found: Floats, exact: Floats) -> float:
    """Share of the truth's relief of 1.2 to 8 pixels that is there, at its place."""
    a, b = (gaussian_filter(x, 1.2) - gaussian_filter(x, 8.0) for x in (found, exact))
    return float((a * b).sum() / (b * b).sum())
