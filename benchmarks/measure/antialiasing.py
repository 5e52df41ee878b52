"""Anti-aliasing against supersampled pictures: a still camera's convergence, shimmer along a path, ghosts.

The reference knows nothing of the jitter: it is rendered without anti-aliasing through off-axis cameras, each shifted
by a share of a pixel, and averaged as light of the display.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ... import Camera, Renderer
from ...engine.srgb import SRGB_STEPS, srgb_encode
from ..timing import Timing, time_variants
from .flip import flip

Light = NDArray[np.float32]
KINDS = ("none", "edge", "temporal")
FLOWN: Mapping[str, Mapping[str, Any]] = {
    **{kind: {"composite.antialiasing": kind} for kind in KINDS},
    "temporal, each pixel shaded": {"terrain.shade_every": 1, "ocean.shade_every": 1},
}


def display_light(color: NDArray[np.uint8]) -> Light:
    """Light of an sRGB display, 0..1 (IEC 61966-2-1), from u8 colours of any shape."""
    return SRGB_STEPS.astype(np.float32)[color]


def display_values(light: Light) -> Light:
    """The inverse: sRGB values 0..1 of linear light 0..1."""
    return srgb_encode(light).astype(np.float32)


def rms(a: Light, b: Light) -> float:
    """Root mean square difference of display values, in steps of an 8-bit picture."""
    return float(255.0 * np.sqrt(np.mean((display_values(a) - display_values(b)) ** 2)))


def shifted(state: Any, size: tuple[int, int], x_px: float, y_px: float) -> Camera:
    """The camera of a CameraState with its picture moved by a share of a pixel (x right, y up)."""
    x = x_px / size[0] * (state.tan_right - state.tan_left)
    y = y_px / size[1] * (state.tan_top - state.tan_bottom)
    tangents = (state.tan_left + x, state.tan_right + x, state.tan_bottom + y, state.tan_top + y)
    angles = tuple(float(a) for a in np.degrees(np.arctan(tangents)))
    return Camera(position_m=state.position_m, forward=state.forward, up=state.up, frustum_deg=angles)


def supersampled(renderer: Renderer, camera: Any, side: int = 8, **moment: Any) -> Light:
    """Mean light of side x side pictures of a renderer without anti-aliasing, (H, W, 3)."""
    state, size = renderer.camera_state(camera), renderer.size
    total = np.zeros((size[1], size[0], 3), np.float64)
    places = (np.arange(side) + 0.5) / side - 0.5
    for x in places:
        for y in places:
            total += display_light(renderer.render(shifted(state, size, x, y), **moment)["color"])
    return (total / side**2).astype(np.float32)


@dataclass(frozen=True)
class StillError:
    """A settled picture against the supersampled one. rms_steps: see rms(); flip: mean."""

    samples: int
    rms_steps: float
    flip: float


def still_errors(
    make: Callable[[Mapping[str, Any]], Renderer], camera: Any, samples: Sequence[int], side: int = 8, **moment: Any
) -> dict[str, StillError]:
    """Errors of "none", "edge" and of temporal pictures of so many samples ("temporal 9"). make(overrides): renderers
    whose exposure is fixed."""
    variants: dict[str, tuple[dict[str, Any], int]] = {k: ({"composite.antialiasing": k}, 1) for k in ("none", "edge")}
    for n in samples:
        variants[f"temporal {n}"] = ({"composite.antialiasing": "temporal", "composite.samples": n}, n)
    with make({"composite.antialiasing": "none"}) as plain:
        plain.settle(camera, **moment)
        reference = supersampled(plain, camera, side, **moment)
    shown = np.round(display_values(reference) * 255.0).astype(np.uint8)
    found: dict[str, StillError] = {}
    for name, (overrides, n) in variants.items():
        with make(overrides) as renderer:
            renderer.settle(camera, **moment)
            color = renderer.render(camera, **moment)["color"]
        found[name] = StillError(n, rms(display_light(color), reference), float(flip(shown, color).mean()))
    return found


@dataclass(frozen=True)
class Shimmer:
    """Pictures of a flight against supersampled ones, in steps of an 8-bit picture.

    shimmer_steps: standard deviation over time of a pixel's difference from the reference, rms over the pixels: what
    flickers although the reference doesn't, and constant differences that move past. rms_steps: the difference itself.
    worst_steps: the 99.9th percentile of its change from one frame to the next.
    """

    shimmer_steps: float
    rms_steps: float
    worst_steps: float


def shimmer(
    make: Callable[[Mapping[str, Any]], Renderer],
    cameras: Sequence[Any],
    warm_up: int = 8,
    side: int = 4,
    kinds: Mapping[str, Mapping[str, Any]] = FLOWN,
    **moment: Any,
) -> dict[str, Shimmer]:
    """Each kind along a path of cameras, one a frame; the first `warm_up` frames are not counted.

    kinds: overrides by name.
    """
    counted = cameras[warm_up:]
    with make({"composite.antialiasing": "none"}) as plain:
        plain.settle(cameras[0], **moment)
        references = [display_values(supersampled(plain, camera, side, **moment)) for camera in counted]
    found: dict[str, Shimmer] = {}
    for kind, overrides in kinds.items():
        with make(overrides) as renderer:
            renderer.settle(cameras[0], **moment)
            off = []
            for index, camera in enumerate(cameras):
                color = renderer.render(camera, dt_s=1.0 / 30.0, **moment)["color"]
                if index >= warm_up:
                    off.append(255.0 * (color / np.float32(255.0) - references[index - warm_up]))
        errors = np.stack(off)
        found[kind] = Shimmer(
            float(np.sqrt(np.mean(errors.var(axis=0)))),
            float(np.sqrt(np.mean(errors**2))),
            float(np.percentile(np.abs(np.diff(errors, axis=0)), 99.9)),
        )
    return found


def flight(camera: Any, state: Any, count: int, step_m: float, turn_deg: float = 0.0) -> list[Camera]:
    """`count` cameras that fly forwards by step_m a frame, level with the sphere, and turn to the right by turn_deg."""
    position, forward, up = state.position_m.copy(), state.forward.copy(), state.up.copy()
    radius = float(np.linalg.norm(position))
    cameras = []
    for _ in range(count):
        cameras.append(Camera(position_m=position.copy(), forward=forward, up=up, fov_y_deg=camera.fov_y_deg))
        zenith = position / np.linalg.norm(position)
        level = forward - zenith * (forward @ zenith)
        if step_m:
            position = position + step_m * level / np.linalg.norm(level)
            position *= radius / np.linalg.norm(position)
        a = np.radians(turn_deg)
        forward = np.cos(a) * forward + np.sin(a) * np.cross(forward, up)
    return cameras


@dataclass(frozen=True)
class Cost:
    """A turning camera's frame. cpu_ms: median time of all processors together, which a busy machine hardly changes."""

    timing: Timing
    cpu_ms: float


def cost(make: Callable[[Mapping[str, Any]], Renderer], camera: Any, runs: int, **moment: Any) -> dict[str, Cost]:
    """Frames of each kind into a framebuffer, taking turns; the camera turns to and fro by a tenth of a degree."""
    cpu: dict[str, list[float]] = {kind: [] for kind in KINDS}
    with ExitStack() as stack:
        frames: dict[str, Callable[[], None]] = {}
        for kind in KINDS:
            renderer = stack.enter_context(make({"composite.antialiasing": kind}))
            cameras = flight(camera, renderer.camera_state(camera), 2, 0.0, 0.1)
            renderer.settle(cameras[0], **moment)
            target = renderer.ctx.simple_framebuffer(renderer.size)

            def frame(
                kind: str = kind, renderer: Renderer = renderer, target: Any = target, turned: list[Camera] = cameras
            ) -> None:
                began = time.process_time()
                turned.reverse()
                renderer.render_to(target, turned[0], **moment)
                renderer.ctx.finish()
                cpu[kind].append(1e3 * (time.process_time() - began))

            frames[kind] = frame
        times = time_variants(frames, runs, 3)
    return {kind: Cost(times[kind], float(np.median(cpu[kind][3:]))) for kind in KINDS}
