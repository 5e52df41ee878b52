"""Whole frames of presets: what they cost, and how far they are from what quality `reference` shows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Renderer, Scene, View
from .flip import flip
from .scaling import FrameCost, turning_frames

__all__ = ["Picture", "WholeFrame", "picture_of", "reference_of", "whole_frame"]


@dataclass(frozen=True)
class Picture:
    """A settled view: colours (H, W, 3) u8 as shown, and radiance (H, W, 3) f64 before exposure."""

    color: NDArray[np.uint8]
    radiance: NDArray[np.float64]


@dataclass(frozen=True)
class WholeFrame:
    """One view at one quality."""

    cost: FrameCost
    mean_flip: float | None
    """To the reference; None without the package flip-evaluator."""
    worst_flip: float | None
    radiance_error: float
    """Mean of the absolute difference over the mean of the reference's radiance."""
    passes: int
    """That ran in a frame of a turning camera."""
    gpu_bytes: int
    """Textures and buffers of all systems and of the graph."""
    triangles: int


def picture_of(renderer: Renderer, seen: View) -> Picture:
    """What a view shows once everything has settled."""
    renderer.settle(seen)
    shown = renderer.render(seen, outputs=("color", "radiance"))
    return Picture(shown["color"], shown["radiance"].astype(np.float64))


def whole_frame(renderer: Renderer, seen: View, reference: Picture, runs: int) -> WholeFrame:
    """A view against the reference's picture of it, of the same size."""
    shown = picture_of(renderer, seen)
    try:
        off = flip(reference.color, shown.color)
        mean_flip, worst_flip = float(off.mean()), float(off.max())
    except ImportError:
        mean_flip = worst_flip = None
    apart = float(np.abs(shown.radiance - reference.radiance).mean() / max(reference.radiance.mean(), 1e-30))
    cost = turning_frames(renderer, seen, runs)
    passes = sum(report.ran for report in renderer.passes())
    statistics: dict[str, Any] = renderer.stats
    return WholeFrame(
        cost, mean_flip, worst_flip, apart, passes, sum(renderer.memory_bytes.values()), statistics.get("triangles", 0)
    )


def reference_of(scene: Scene, seen: View, size: tuple[int, int]) -> Picture:
    """The picture of quality `reference`, on a context of its own."""
    with Renderer(scene, size, "reference") as renderer:
        return picture_of(renderer, seen)
