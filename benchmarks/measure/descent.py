"""A flight from space to the ground, frame by frame: pops of the ground, steps of brightness, time and work."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer, Scene, Sun, path
from ...engine.space import CameraState, project
from .motion import turned
from .popping import compared_pairs

__all__ = [
    "Flight",
    "FrameWork",
    "Percentiles",
    "Step",
    "brightness_steps",
    "descent",
    "fly_timed",
    "most",
    "percentiles",
    "pops",
    "trend",
]

Floats = NDArray[np.float64]
OUTPUTS = ("position", "surface", "radiance")
_SAME_PLACE = 0.02
"""Points whose distances from a camera differ by less, relatively, are taken to be the same ground; the rest is hidden
in one of the two pictures."""
_TREND_FRAMES = 3
"""The smooth trend at a frame is the median over so many frames before and after it."""
_LEAST_SHARE = 0.02
"""Of a picture has to be seen again, or the pair says nothing about brightness."""


@dataclass(frozen=True)
class Flight:
    """Cameras of a scripted flight, one a frame, `frame_s` apart."""

    cameras: tuple[Camera, ...]
    frame_s: float
    sun: Sun | None
    altitudes_m: Floats
    """Above the reference sphere."""


def descent(
    scene: Scene, frames: int, first_s: float = 0.0, last_s: float | None = None, name: str = "descent"
) -> Flight:
    """`frames` cameras of a path, from first_s to last_s (None: its end) of its time. ValueError for fewer than 2."""
    if frames < 2:
        raise ValueError(f"a flight needs two frames or more, found {frames}")
    flown = path(name, scene)
    times_s = np.linspace(first_s, flown.duration_s if last_s is None else last_s, frames)
    cameras = tuple(flown.camera_at(float(t)) for t in times_s)
    radius_m = scene.planet.radius_m
    altitudes_m = np.array([float(np.linalg.norm(c.position_m)) - radius_m for c in cameras])
    return Flight(cameras, float(times_s[1] - times_s[0]), flown.sun, altitudes_m)


# -- pops of the ground ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Step:
    """What one pair of frames shows."""

    altitude_m: float
    p999_px: float
    worst_px: float
    brighter: float
    """Of the whole picture, camera held: logarithm of the ratio of mean radiances."""
    pixels: int


def pops(renderer: Renderer, flight: Flight, progress: Callable[[int], None] | None = None) -> list[Step]:
    """How far ground moves on screen and how much brighter the picture grows from each frame to the next, the camera's
    motion apart; see popping.py."""
    found = []
    for number, pair in enumerate(compared_pairs(renderer, flight.cameras, flight.frame_s, flight.sun)):
        moved = pair.moved_px
        worst = float(moved.max()) if len(moved) else 0.0
        p999 = float(np.quantile(moved, 0.999)) if len(moved) else 0.0
        found.append(Step(float(flight.altitudes_m[number + 1]), p999, worst, pair.brighter, len(moved)))
        if progress is not None:
            progress(number + 1)
    return found


# -- brightness -----------------------------------------------------------------------------------------------------


def brightness_steps(renderer: Renderer, flight: Flight) -> Floats:
    """(frames - 1,) by how much the same ground grows brighter from frame to frame: the logarithm of the ratio.

    Each picture's pixels are looked for in the picture before by their `position`; what both show counts. Radiance,
    before exposure. NaN where too little is seen twice (a fiftieth of the picture).
    """
    renderer.settle(flight.cameras[0], sun=flight.sun)
    found = np.full(len(flight.cameras) - 1, np.nan)
    before = shown_of(renderer, flight.cameras[0], flight)
    for number, (last, camera) in enumerate(itertools.pairwise(flight.cameras)):
        now = shown_of(renderer, camera, flight)
        found[number] = brighter(renderer.camera_state(last), before, renderer.camera_state(camera), now)
        before = now
    return found


def true_steps(renderer: Renderer, flight: Flight, pairs: NDArray[np.intp]) -> Floats:
    """As brightness_steps, of pictures that stand for themselves and know no frame before them; NaN but for `pairs`.

    What they do too, such as growing dark where the camera dives into a cloud, is no fault of the frames in a row.
    """
    found = np.full(len(flight.cameras) - 1, np.nan)
    held: tuple[int, dict[str, Any]] | None = None
    for number in np.unique(pairs):
        last, camera = flight.cameras[number : number + 2]
        first = held[1] if held is not None and held[0] == number else _alone(renderer, last, flight)
        second = _alone(renderer, camera, flight)
        found[number] = brighter(renderer.camera_state(last), first, renderer.camera_state(camera), second)
        held = (int(number) + 1, second)
    return found


def beyond(renderer: Renderer, flight: Flight, steps: Floats, limit: float) -> Floats:
    """How far each step of a flight among clouds is beyond the trend, and where that is more than the limit, beyond the
    true pictures' steps, if they are nearer: a camera that dives through a cloud leaves any trend."""
    off = np.abs(steps - trend(steps))
    pairs = np.nonzero(off > limit)[0][:, None] + (-1, 0, 1)
    truth = true_steps(renderer, flight, pairs[(pairs >= 0) & (pairs < len(steps))])
    return np.fmin(off, beyond_truth(steps, truth))


def beyond_truth(steps: Floats, truth: Floats) -> Floats:
    """How far each step is outside of those of the true pictures in the frame before it, in its own and in the one
    after: a frame late is no fault either. NaN where none is known."""
    around = np.stack([np.r_[np.nan, truth[:-1]], truth, np.r_[truth[1:], np.nan]])
    known = np.isfinite(around).any(axis=0)
    least, most = (choose(np.where(known, around, 0.0), axis=0) for choose in (np.nanmin, np.nanmax))
    return np.where(known, np.maximum(np.maximum(least - steps, steps - most), 0.0), np.nan)


def _alone(renderer: Renderer, camera: Camera, flight: Flight) -> dict[str, Any]:
    return renderer.render(camera, sun=flight.sun, outputs=OUTPUTS)


def shown_of(renderer: Renderer, camera: Camera, flight: Flight) -> dict[str, Any]:
    """A frame of the flight, with the arrays that frames are compared by."""
    return renderer.render(camera, sun=flight.sun, outputs=OUTPUTS, dt_s=flight.frame_s)


def brighter(last: CameraState, before: dict[str, Any], state: CameraState, now: dict[str, Any]) -> float:
    """The logarithm of how much brighter ground is that both frames show; NaN where that is too little of them."""
    rows, columns = np.nonzero(now["surface"] > 0)
    points = now["position"][rows, columns].astype(np.float64) + state.position_m
    height, width = now["surface"].shape
    pixels, front = project(last, points, (width, height))
    inside = front & (pixels >= 0.5).all(axis=1) & (pixels <= np.array([width, height]) - 0.5).all(axis=1)
    # Nearest pixels: a blend of neighbours would be darker along every bright edge.
    at = np.clip(np.floor(np.where(inside[:, None], pixels, 0.0)).astype(int), 0, (width - 1, height - 1))
    there = before["position"][at[:, 1], at[:, 0]].astype(np.float64)
    distance = np.linalg.norm(points - last.position_m, axis=1)
    with np.errstate(invalid="ignore"):
        same = inside & (np.abs(np.linalg.norm(there, axis=1) - distance) < _SAME_PLACE * distance)
    same &= before["surface"][at[:, 1], at[:, 0]] == now["surface"][rows, columns]
    if same.sum() < _LEAST_SHARE * width * height:
        return float("nan")
    new = now["radiance"][rows[same], columns[same]].astype(np.float64).mean()
    old = before["radiance"][at[same, 1], at[same, 0]].astype(np.float64).mean()
    return float(np.log(new / old)) if new > 0.0 and old > 0.0 else float("nan")


def trend(steps: Floats) -> Floats:
    """The smooth trend of a series: at each place the median over three places before and after it, NaN left out."""
    padded = np.pad(steps, _TREND_FRAMES, mode="reflect") if len(steps) > _TREND_FRAMES else steps
    if len(padded) == len(steps):
        return np.full(len(steps), np.nanmedian(steps))
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * _TREND_FRAMES + 1)
    seen = np.isfinite(windows).any(axis=1)
    found = np.full(len(steps), np.nan)
    found[seen] = np.nanmedian(windows[seen], axis=1)
    return found


# -- time and work --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class FrameWork:
    """One frame: its time, and what was asked of the GPU in it."""

    ms: float
    cpu_ms: float
    draws: int
    dispatches: int
    uploads: int
    upload_bytes: int
    programs_built: int


def fly_timed(renderer: Renderer, flight: Flight) -> list[FrameWork]:
    """Every frame of a flight into a framebuffer, each waited for. The first is settled, and looked around from for
    half a second, before the clock runs."""
    target = renderer.ctx.simple_framebuffer(renderer.size)
    work: Any = renderer.gpu.work
    found = []
    try:
        renderer.settle(flight.cameras[0], sun=flight.sun)
        for looking in turned(renderer.camera_state(flight.cameras[0]), 0.01, 30):
            renderer.render_to(target, looking, sun=flight.sun, dt_s=1.0 / 60.0)
        renderer.ctx.finish()
        for camera in flight.cameras:
            before = work.snapshot()
            began, used = time.perf_counter(), time.process_time()
            renderer.render_to(target, camera, sun=flight.sun, dt_s=flight.frame_s)
            renderer.ctx.finish()
            ms, cpu_ms = (time.perf_counter() - began) * 1e3, (time.process_time() - used) * 1e3
            after = work.snapshot()
            found.append(FrameWork(ms, cpu_ms, **{name: after[name] - before[name] for name in before}))
    finally:
        renderer.gpu.leave(target)
        target.release()
    return found


@dataclass(frozen=True)
class Percentiles:
    """Of the frames of a flight after its first second."""

    p50_ms: float
    p99_ms: float
    worst_ms: float

    @property
    def p99_over_median(self) -> float:
        return self.p99_ms / self.p50_ms

    @property
    def worst_over_median(self) -> float:
        return self.worst_ms / self.p50_ms


def percentiles(frames: Sequence[FrameWork], frame_s: float, cpu: bool = False) -> Percentiles:
    """cpu: of the processor time of all cores instead of the clock's."""
    late = list(frames)[int(np.ceil(1.0 / frame_s)) :] or list(frames)
    ms = [f.cpu_ms if cpu else f.ms for f in late]
    return Percentiles(*(float(v) for v in np.quantile(ms, (0.5, 0.99, 1.0))))


def most(frames: Sequence[FrameWork]) -> dict[str, Any]:
    """The most of each that any frame had, by the names of FrameWork."""
    return {f.name: max(getattr(frame, f.name) for frame in frames) for f in fields(FrameWork)}
