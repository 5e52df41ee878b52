"""Popping along a flight: how far the ground moves on screen from one frame to the next, the camera's motion apart.

Every backend is asked in the same way, by what the `position` output shows. After each
frame the camera of the frame before looks again, at the ground that was chosen for the new one.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, DebugView, Renderer, Sun
from ...engine.space import CameraState, project
from .snaps import moved_px

Floats = NDArray[np.float64]

OUTPUTS = ("position", "surface", "radiance")
_MOVES_PX = 1e-3
"""Less is rounding of the `position` output."""


@dataclass(frozen=True)
class Popping:
    """Pixels of ground over all pairs of frames of a flight."""

    p999_px: float
    p99_px: float
    worst_px: float
    changed: float
    """Share of the pairs of frames in which any ground moved."""
    frames: int
    pixels: int


def popping(renderer: Renderer, cameras: Sequence[Camera], frame_s: float = 1.0 / 60.0) -> Popping:
    """Fly along cameras, a frame each. Streaming, morphing and fading go on as they do in flight: `frame_s` a frame."""
    found = [pair.moved_px for pair in compared_pairs(renderer, cameras, frame_s)]
    changed = sum(bool(len(moved) and moved.max() > _MOVES_PX) for moved in found)
    every = np.concatenate(found) if found else np.zeros(0)
    if not len(every):
        return Popping(0.0, 0.0, 0.0, 0.0, len(cameras) - 1, 0)
    p999, p99 = np.quantile(every, (0.999, 0.99))
    return Popping(float(p999), float(p99), float(every.max()), changed / len(found), len(cameras) - 1, len(every))


@dataclass(frozen=True)
class Pair:
    """What looking back shows of a pair of frames."""

    moved_px: Floats
    """How far the ground of each pixel moved that both cameras see, (N,)."""
    brighter: float
    """Logarithm of the ratio of the pictures' mean radiance, after over before, where both show the same kind of
    surface: what the second camera doesn't see was not drawn for the first to look at."""


def compared_pairs(
    renderer: Renderer, cameras: Sequence[Camera], frame_s: float, sun: Sun | None = None
) -> Iterator[Pair]:
    """For each pair of frames: the camera of the first before and after the second was drawn."""
    with _freezable(renderer) as shown:
        renderer.settle(cameras[0], sun=sun)
        before = renderer.render(cameras[0], sun=sun, outputs=OUTPUTS, dt_s=frame_s)
        for here, there in itertools.pairwise(cameras):
            now = renderer.render(there, sun=sun, outputs=OUTPUTS, dt_s=frame_s)
            shown.freeze = True
            again = renderer.render(here, sun=sun, outputs=OUTPUTS, dt_s=0.0)
            shown.freeze = False
            first, second = renderer.camera_state(here), renderer.camera_state(there)
            both = both_see(second, first, before) & both_see(second, first, again)
            hidden = {**before, "surface": np.where(both, before["surface"], 0)}
            yield Pair(moved_px(first, hidden, again), _brighter(before, again))
            before = now


def both_see(second: CameraState, first: CameraState, out: dict[str, Any]) -> NDArray[np.bool_]:
    """(H, W): whether the second camera has in its picture what the first one's pixels show. What it doesn't see was
    not drawn for the first to look at: where a camera leaps, it would see through to other ground."""
    height, width = out["surface"].shape
    points = out["position"].reshape(-1, 3).astype(np.float64) + first.position_m
    pixels, front = project(second, points, (width, height))
    with np.errstate(invalid="ignore"):
        inside = front & (pixels >= 0.0).all(axis=1) & (pixels <= np.array([width, height])).all(axis=1)
    return inside.reshape(height, width)


def _brighter(before: dict[str, Any], after: dict[str, Any]) -> float:
    same = before["surface"] == after["surface"]
    old, new = (float(out["radiance"][same].sum(dtype=np.float64)) for out in (before, after))
    return float(np.log(new / old)) if old > 0.0 and new > 0.0 else 0.0


@contextmanager
def _freezable(renderer: Renderer) -> Iterator[DebugView]:
    """The scene's DebugView, which holds the ground while another camera looks at it; one of our own for a while where
    there is none."""
    environment = renderer.scene.environment
    own = DebugView not in environment
    if own:
        environment.add(DebugView())
    try:
        yield environment[DebugView]
    finally:
        environment[DebugView].freeze = False
        if own:
            environment.remove(DebugView)
