"""Whole frames: time in all and by pass, what was skipped, memory."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import moderngl
import numpy as np

from ... import Camera, Renderer, View
from ..timing import Timing, time_variants
from .motion import turned


class FinishTimers:
    """Timers for a frame graph on a software renderer, where GPU timestamps mean nothing: waits for each pass to end
    and reads the clock. Use through `time_passes`; it slows the frame."""

    def __init__(self, ctx: moderngl.Context, count: int) -> None:
        self._ctx = ctx
        self._began = [0.0] * count
        self._ms: list[float | None] = [None] * count

    def begin(self, slot: int) -> None:
        """Start of a pass."""
        self._ctx.finish()
        self._began[slot] = time.perf_counter()

    def end(self, slot: int) -> None:
        """End of a pass."""
        self._ctx.finish()
        self._ms[slot] = (time.perf_counter() - self._began[slot]) * 1e3

    def collect(self, out: list[float | None]) -> None:
        """End of a frame."""
        out[:] = self._ms
        self._ms = [None] * len(self._ms)

    def release(self) -> None:
        """Nothing to free."""


@dataclass(frozen=True)
class FrameTimes:
    """One view at one quality."""

    turning: Timing
    """The camera turns by 0.01 degrees a frame: culled and drawn, proxy held. What a flight's frame costs."""
    still: Timing
    """Nothing changes."""
    snapping: Timing
    """The proxy snaps in every frame: selection and vertices made anew as well."""
    python_ms: float
    """Median of Renderer.python_ms over the turning frames: the update before the graph."""


def time_frames(renderer: Renderer, camera: Camera, runs: int) -> FrameTimes:
    """Interleaved variants of a frame into a framebuffer, each ended by ctx.finish()."""
    renderer.render(camera)
    state = renderer.camera_state(camera)
    target = renderer.ctx.simple_framebuffer(renderer.size)
    cameras = turned(state, 0.01, 4)
    same = cameras[0]
    light = _light(renderer, camera)
    python_ms: list[float] = []

    def turning() -> None:
        cameras.append(cameras.pop(0))
        renderer.render_to(target, cameras[0], **light)
        python_ms.append(renderer.python_ms)

    def still() -> None:
        renderer.render_to(target, same, **light)

    def snapping() -> None:
        forget_proxy(renderer)
        renderer.render_to(target, same, **light)

    times = {}
    # One after the other: a snap would hold up whoever comes next, and a turn would not leave a still frame still.
    for name, frame in (("still", still), ("turning", turning), ("snapping", snapping)):
        few = max(runs // 3, 3) if name == "snapping" else runs
        times[name] = time_variants({name: frame}, few, 2, renderer.ctx.finish)[name]
    _release(renderer, target)
    return FrameTimes(**times, python_ms=float(np.median(python_ms)))


@dataclass(frozen=True)
class RunningFrame:
    """A frame of a flight: by the clock, and the processor time of all cores."""

    timing: Timing
    cpu_ms: float
    """Median."""


def turning(renderer: Renderer, seen: Camera | View) -> Callable[[], None]:
    """A settled view's frame, waited for, of a camera that turns to and fro: for turns with another renderer's."""
    renderer.settle(seen)
    target, light = renderer.ctx.simple_framebuffer(renderer.size), _light(renderer, seen)
    cameras = turned(renderer.camera_state(seen), 0.01, 4)

    def frame() -> None:
        cameras.append(cameras.pop(0))
        renderer.render_to(target, cameras[0], **light)
        renderer.ctx.finish()

    return frame


RUN_UP = 40
"""Frames after which what a jump to a view leaves to those that follow is done: meshes of the next snap for ground and
sea, their fading, and maps of the clouds' shadow, which come round in three times twelve."""


def time_running(renderer: Renderer, seen: View, runs: int) -> RunningFrame:
    """Frames of a camera that turns by 0.01 degrees and of time that goes on by a sixtieth of a second in each, after a
    run-up of such. The proxy is held."""
    renderer.render(seen)
    state, target = renderer.camera_state(seen), renderer.ctx.simple_framebuffer(renderer.size)
    light = _light(renderer, seen)
    start_s = light.pop("time_s", None) or 0.0
    wall_ms: list[float] = []
    used_ms: list[float] = []
    for number, camera in enumerate(turned(state, 0.01, RUN_UP + runs)):
        renderer.ctx.finish()
        began, began_used = time.perf_counter(), time.process_time()
        renderer.render_to(target, camera, time_s=start_s + number / 60.0, dt_s=1.0 / 60.0, **light)
        renderer.ctx.finish()
        wall_ms.append((time.perf_counter() - began) * 1e3)
        used_ms.append((time.process_time() - began_used) * 1e3)
    _release(renderer, target)
    return RunningFrame(Timing.of(wall_ms[-runs:]), float(np.median(used_ms[-runs:])))


def forget_proxy(renderer: Renderer) -> None:
    """The next frame makes a new proxy, and all that hangs on it, as a snap does."""
    renderer.views[0].placed = None


def time_passes(renderer: Renderer, camera: Camera, runs: int) -> dict[str, Timing]:
    """Time of each pass of a turning camera's frame, each waited for; and of those that run on a snap alone."""
    renderer.render(camera)
    state = renderer.camera_state(camera)
    target = renderer.ctx.simple_framebuffer(renderer.size)
    backend: Any = renderer.own.backend
    kept: Callable[[int], Any] = backend.create_timers
    samples: dict[str, list[float]] = {}
    light = _light(renderer, camera)
    backend.create_timers = lambda count: FinishTimers(renderer.ctx, count)
    try:
        renderer.render_to(target, camera, **light)
        renderer.graph.gpu_timing = True
        for turn in turned(state, 0.01, runs + 1):
            renderer.render_to(target, turn, **light)
            for report in renderer.passes():
                if report.gpu_ms is not None:
                    samples.setdefault(report.name, []).append(report.gpu_ms)
        always = set(samples)
        for _ in range(max(runs // 3, 2)):
            forget_proxy(renderer)
            renderer.render_to(target, camera, **light)
            for report in renderer.passes():
                if report.gpu_ms is not None and report.name not in always:
                    samples.setdefault(f"{report.name} (snap)", []).append(report.gpu_ms)
        renderer.graph.gpu_timing = False
    finally:
        backend.create_timers = kept
    _release(renderer, target)
    return {name: Timing.of(found[1:] or found) for name, found in samples.items()}


TIMERS_LATE = 3
"""Frames after which a GPU's timers are read, so that nobody waits for them."""


def gpu_passes_ms(renderer: Renderer, camera: Camera, runs: int) -> dict[str, float]:
    """Medians of the passes over a turning camera's frames, by the GPU's own timers."""
    renderer.render(camera)
    state, target = renderer.camera_state(camera), renderer.ctx.simple_framebuffer(renderer.size)
    samples: dict[str, list[float]] = {}
    light = _light(renderer, camera)
    renderer.render_to(target, camera, **light)  # whose graph it is that is timed
    renderer.graph.gpu_timing = True
    for turn in turned(state, 0.01, runs + TIMERS_LATE):
        renderer.render_to(target, turn, **light)
        renderer.ctx.finish()
        for report in renderer.passes():
            if report.gpu_ms is not None:
                samples.setdefault(report.name, []).append(report.gpu_ms)
    renderer.graph.gpu_timing = False
    _release(renderer, target)
    return {name: float(np.median(found)) for name, found in samples.items()}


@dataclass(frozen=True)
class Skipping:
    """What ran in a frame in which nothing had changed."""

    ran_again: tuple[str, ...]
    """Passes that select, upload or make vertices."""
    uploads: int
    skipped: int
    passes: int
    drawn_out_of_view: int
    """Triangles drawn by a camera that looks away from the planet."""


def skipping(renderer: Renderer, camera: Camera) -> Skipping:
    """An unchanged camera and time, twice; then a look away from the planet."""
    for _ in range(3):
        renderer.render(camera)
    work: Any = renderer.gpu.work
    before = work.uploads
    selection = _selections(renderer)
    renderer.render(camera)
    uploads = work.uploads - before
    reports = renderer.passes()
    ran = tuple(p.name for p in reports if p.ran and p.name.endswith((".vertices", ".cull")))
    if _selections(renderer) != selection:
        ran += ("selection",)
    state = renderer.camera_state(camera)
    zenith = state.direction
    # High enough that nothing of the planet is in a picture that looks straight up.
    away = Camera(zenith * (3.0 * renderer.scene.planet.radius_m), zenith, state.up)
    renderer.render(away)
    return Skipping(ran, uploads, sum(not p.ran for p in reports), len(reports), renderer.stats.get("triangles", 0))


def _selections(renderer: Renderer) -> tuple[int, ...]:
    found = []
    for name in ("terrain", "ocean"):
        system: Any = renderer.system(name)
        mesh = getattr(system, "drawn_mesh", lambda view: None)(renderer.views[0]) if system is not None else None
        found.append(-1 if mesh is None else mesh.selection)
    return tuple(found)


def _light(renderer: Renderer, camera: Camera) -> dict[str, Any]:
    """Sun and time of a view, for cameras that are made from it: else it would be night there, or noon."""
    placed = camera.in_scene(renderer.scene)
    return {"sun": placed.sun, "time_s": placed.time_s}


def _release(renderer: Renderer, target: moderngl.Framebuffer) -> None:
    renderer.gpu.leave(target)
    target.release()
