"""How time grows with a count: the exponent of a power law, fitted to a series of frames."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from ... import Camera, Renderer, Sun, View
from ...render.view import RenderView
from ..timing import Timing, time_variants
from .motion import turned

__all__ = [
    "FrameCost",
    "PowerLaw",
    "beside_alone",
    "fit_power_law",
    "turning_frames",
    "turning_in_turns",
    "turning_views",
]


_STEADY_FRAMES = 12
"""So many frames without a new program: all are there."""


@dataclass(frozen=True)
class PowerLaw:
    """ms = fixed_ms + factor x count^exponent, fitted in the logarithm to what grows."""

    exponent: float
    fixed_ms: float
    """What a frame takes whatever the count."""
    worst: float
    """Largest ratio between a measured time and the law's, from 1 up."""


def fit_power_law(counts: Sequence[float], ms: Sequence[float]) -> PowerLaw:
    """From three counts above 0 or more, with times above 0; the share that doesn't grow is found by trying.

    Raises ValueError for fewer, and for numbers that are not positive.
    """
    x, y = np.asarray(counts, np.float64), np.asarray(ms, np.float64)
    if len(x) < 3 or len(x) != len(y) or not ((x > 0.0).all() and (y > 0.0).all()):
        raise ValueError(f"a power law needs three positive pairs or more, found counts {counts} and ms {ms}")
    found: list[tuple[float, PowerLaw]] = []
    for fixed in np.concatenate([[0.0], np.linspace(0.0, 0.99, 100) * y.min()]):
        slope, start = np.polyfit(np.log(x), np.log(y - fixed), 1)
        law = fixed + np.exp(start) * x**slope
        misfit = float(np.square(np.log(law / y)).sum())
        worst = float(np.exp(np.abs(np.log(law / y)).max()))
        found.append((misfit, PowerLaw(float(slope), float(fixed), worst)))
    return min(found, key=lambda pair: pair[0])[1]


@dataclass(frozen=True)
class FrameCost:
    """A frame of a turning camera: wall clock, and processor time of all cores together."""

    timing: Timing
    cpu_ms: float


def _programs(renderer: Renderer) -> int:
    return sum(kinds.get("program", 0) for kinds in renderer.gpu.counts().values())


def turning_frames(renderer: Renderer, seen: Camera, runs: int, sun: Sun | None = None) -> FrameCost:
    """Frames whose camera turns by 0.01 degrees each; the proxy is held, nothing is taken over from the last frame.
    sun: None is the view's, or the scene's."""
    return turning_views(renderer, seen, 1, runs, sun)


def turning_in_turns(
    renderers: Sequence[Renderer], seen: View | Camera, runs: int, warm_up: int, sun: Sun | None = None
) -> list[FrameCost]:
    """`turning_frames` of several renderers that take turns: a machine that slows down slows all alike. cpu_ms is the
    mean, in which work that is spread over frames counts with its share."""
    placed = seen.in_scene(renderers[0].scene)
    moment: dict[str, Any] = {"sun": placed.sun if sun is None else sun, "time_s": placed.time_s}
    used: list[list[float]] = [[] for _ in renderers]
    frames: dict[str, Callable[[], None]] = {}
    with ExitStack() as stack:
        for renderer, own in zip(renderers, used, strict=True):
            renderer.render(seen, **moment)
            target = renderer.ctx.simple_framebuffer(renderer.size)
            stack.callback(target.release)
            stack.callback(renderer.gpu.leave, target)
            cameras = turned(renderer.camera_state(seen), 0.01, 4)

            def frame(
                renderer: Renderer = renderer, own: list[float] = own, target: Any = target, cameras: Any = cameras
            ) -> None:
                cameras.append(cameras.pop(0))
                before = time.process_time()
                renderer.render_to(target, cameras[0], **moment)
                renderer.ctx.finish()
                own.append((time.process_time() - before) * 1e3)

            frames[str(len(frames))] = frame
        timings = time_variants(frames, runs, warm_up)
    return [FrameCost(timing, float(np.mean(own[-runs:]))) for timing, own in zip(timings.values(), used, strict=True)]


def turning_views(renderer: Renderer, seen: Camera, count: int, runs: int, sun: Sun | None = None) -> FrameCost:
    """The same for several views of one renderer, the renderer's own first, each of them of its size. Every view has
    settled: tables, tiles and shadows are there, and shaders compiled, before the first frame that counts."""
    placed = seen.in_scene(renderer.scene)
    moment: dict[str, Any] = {"sun": placed.sun if sun is None else sun, "time_s": placed.time_s}
    views: list[Renderer | RenderView] = [renderer]
    views += [renderer.add_view(renderer.size) for _ in range(count - 1)]
    for one in views:
        one.settle(seen, **moment)
    target = renderer.ctx.simple_framebuffer(renderer.size)
    cameras = turned(renderer.camera_state(seen), 0.01, 4)
    used: list[float] = []

    def frame() -> None:
        cameras.append(cameras.pop(0))
        before = time.process_time()
        for one in views:
            one.render_to(target, cameras[0], **moment)
        renderer.ctx.finish()
        used.append((time.process_time() - before) * 1e3)

    # Frames that go on compile what later ones may need, one shader each: that is no frame's own time.
    steady = 0
    while steady < _STEADY_FRAMES:
        programs = _programs(renderer)
        frame()
        steady = steady + 1 if _programs(renderer) == programs else 0
    timing = time_variants({"turning": frame}, runs, 2, renderer.ctx.finish)["turning"]
    renderer.gpu.leave(target)
    target.release()
    for one in views[1:]:
        one.release()
    return FrameCost(timing, float(np.median(used[-runs:])))


def beside_alone(
    alone: Sequence[tuple[Renderer | RenderView, Camera]],
    together: Sequence[tuple[Renderer | RenderView, Camera]],
    sun: Sun,
    moving: bool,
    runs: int,
) -> tuple[FrameCost, FrameCost]:
    """A frame of each of several pictures, (from renderers of their own, as views of one renderer), by turns; medians.
    Cameras turn by 0.01 degrees a frame. moving: time runs."""
    used: dict[str, list[float]] = {"alone": [], "together": []}
    steps = dict.fromkeys(used, 0)

    def frame(name: str, pairs: Sequence[tuple[Renderer | RenderView, Camera]]) -> Callable[[], None]:
        shown = [(one, turned(one.camera_state(camera), 0.01, 4)) for one, camera in pairs]

        def draw() -> None:
            steps[name] += 1
            time_s = steps[name] / 60.0 if moving else 0.0
            before = time.process_time()
            for one, cameras in shown:
                one.render(cameras[steps[name] % 4], time_s, sun=sun, dt_s=1.0 / 60.0)
            used[name].append((time.process_time() - before) * 1e3)

        return draw

    timings = time_variants({"alone": frame("alone", alone), "together": frame("together", together)}, runs, 40)
    found = [FrameCost(timings[name], float(np.median(used[name][-runs:]))) for name in used]
    return found[0], found[1]
