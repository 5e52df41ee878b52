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

from ... import Camera, Renderer
from ...systems.terrain.backends.grid import GridBackend
from .snaps import OUTPUTS, moved_px

Floats = NDArray[np.float64]

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
    left_out: int
    """Pairs that could not be compared: the first camera had already left what was chosen for the second."""
    pixels: int


def popping(renderer: Renderer, cameras: Sequence[Camera], frame_s: float = 1.0 / 60.0) -> Popping:
    """Fly along cameras, a frame each. Streaming, morphing and fading go on as they do in flight: `frame_s` a frame."""
    found: list[Floats] = []
    left_out = changed = 0
    renderer.settle(cameras[0])
    before = renderer.render(cameras[0], outputs=OUTPUTS, dt_s=frame_s)
    grid = _is_grid(renderer)
    for here, there in itertools.pairwise(cameras):
        now = renderer.render(there, outputs=OUTPUTS, dt_s=frame_s)
        chosen = _proxy_generation(renderer)
        with frozen(renderer):
            again = renderer.render(here, outputs=OUTPUTS, dt_s=0.0)
        if grid and _proxy_generation(renderer) != chosen:
            left_out += 1  # another grid was made for looking back
        else:
            moved = moved_px(renderer.camera_state(here), before, again)
            changed += bool(len(moved) and moved.max() > _MOVES_PX)
            found.append(moved)
        before = now
    every = np.concatenate(found) if found else np.zeros(0)
    if not len(every):
        return Popping(0.0, 0.0, 0.0, 0.0, len(cameras) - 1, left_out, 0)
    p999, p99 = np.quantile(every, (0.999, 0.99))
    pairs = max(len(found), 1)
    return Popping(float(p999), float(p99), float(every.max()), changed / pairs, len(cameras) - 1, left_out, len(every))


@contextmanager
def frozen(renderer: Renderer) -> Iterator[None]:
    """Tiles are kept as they are while this lasts. The grid hangs on its proxy alone, which holds by itself."""
    system: Any = renderer.system("terrain")
    system.backend.hold = True
    try:
        yield
    finally:
        system.backend.hold = False


def _is_grid(renderer: Renderer) -> bool:
    system: Any = renderer.system("terrain")
    return isinstance(system.backend, GridBackend)


def _proxy_generation(renderer: Renderer) -> int:
    return int(renderer.scene.world.resource("proxy.0").generation)
