"""Suite frame: whole frames at 640 x 360."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from typing import Any

from ... import ASSETS, Exposure, Renderer, View, view
from ...camera.views import views
from ..knobs import PAIRS, QUALITY_PAIRS, QUALITY_VIEW, SHADE_PAIRS
from ..machine import resident_bytes
from ..measure import antialiasing, frames
from ..measure.knobs import KnobCost, KnobMeter
from ..scenes import preset_scene
from ..session import Bench, Session
from ..target import at_most
from . import frame_budget, frame_descent, frame_skipping, frame_views

SIZE, QUICK_SIZE = (640, 360), (320, 180)
FULL_HD = (1920, 1080)
QUALITIES = ("low", "medium", "high")
TABLE_VIEWS = ("near", "high", "orbit")
PROMISED_MS = 50.0


def _total(session: Session) -> None:
    """Milliseconds a frame: camera turning, still, and the proxy snapping."""
    for quality in QUALITIES:
        with session.renderer("earth", SIZE, quality) as renderer:
            names = TABLE_VIEWS if session.small else views(renderer.scene.planet)
            for name in names:
                found = frames.time_frames(renderer, view(name), session.runs(15, 5))
                promised = quality == "medium" and name in TABLE_VIEWS
                statistics = renderer.stats
                session.row(
                    quality, name, SIZE, found.turning, target=at_most(PROMISED_MS, "ms") if promised else None,
                    target_on="ms", still_ms=found.still.ms, snap_ms=found.snapping.ms,
                    update_ms=found.python_ms, cells=statistics["cells"], triangles=statistics["triangles"],
                )  # fmt: skip


def _passes(session: Session) -> None:
    """Milliseconds by pass, each waited for: the parts add up to more than the whole."""
    for quality in ("medium",) if session.small else QUALITIES:
        with session.renderer("earth", SIZE, quality) as renderer:
            for name in (*TABLE_VIEWS, "waterfall"):
                for pass_name, timing in frames.time_passes(renderer, view(name), session.runs(9, 4)).items():
                    session.row(f"{quality}: {pass_name}", name, SIZE, timing)


def _full_hd(session: Session) -> None:
    """Frames of 1920 x 1080 with clouds, by the clock; and what their passes take by the GPU's own timers, where it is
    one."""
    for quality in ("low", "medium"):
        with session.renderer("earth", FULL_HD, quality, clouds=True) as renderer:
            for name in TABLE_VIEWS:
                renderer.settle(view(name))
                found = frames.time_frames(renderer, view(name), session.runs(24, 5))
                passes = frames.gpu_passes_ms(renderer, view(name), session.runs(20, 5))
                session.row(
                    quality, name, FULL_HD, found.turning, still_ms=found.still.ms, snap_ms=found.snapping.ms,
                    update_ms=found.python_ms, passes_ms=sum(passes.values()),
                )  # fmt: skip


def _memory(session: Session) -> None:
    """Memory of the GPU's objects and of the process."""
    for quality in QUALITIES:
        with session.renderer("earth", SIZE, quality) as renderer:
            for name in TABLE_VIEWS:
                renderer.render(view(name))
            counts = {kind: 0 for kind in ("texture", "buffer")}
            for kinds in renderer.gpu.counts().values():
                for kind in counts:
                    counts[kind] += kinds.get(kind, 0)
            session.row(quality, size=SIZE, error=renderer.graph.memory_bytes() / 2**20, error_unit="MiB in the graph",
                        resident_mib=resident_bytes() / 2**20, textures=counts["texture"],
                        buffers=counts["buffer"])  # fmt: skip


def _said(value: object) -> str:
    """A knob's value for the table; maps of ours by their place among the assets, which is the same on each machine."""
    return str(value).replace(f"{ASSETS}{os.sep}", "")


def _knobs(session: Session) -> None:
    """What each knob costs and what it shows: both pictures of its pair. Quick: small, without colours, which cost
    nothing, and without quality knobs."""
    size, runs = QUICK_SIZE if session.small else SIZE, session.runs(9, 3)

    def row(key: str, planet: str, name: str, found: KnobCost) -> None:
        session.row(
            key, name if planet == "earth" else f"{planet}: {name}", size, found.on, error=found.mean_flip,
            error_unit="FLIP", off_ms=found.off.ms, on_over_off=found.ratio, apart=found.apart,
            worst_flip=found.worst_flip, on=_said(found.on_value), off=_said(found.off_value),
        )  # fmt: skip

    session.release()
    with KnobMeter(size) as meter:
        for key, pair in PAIRS.items():
            if not (session.small and key.endswith("_albedo")):
                row(key, pair.planet, pair.view, meter.knob(key, pair, runs))
        for key, values in () if session.small else QUALITY_PAIRS.items():
            row(f"quality {key}", *QUALITY_VIEW, meter.quality_knob(key, values, QUALITY_VIEW, runs))
        for key, (name, *shaded) in () if session.small else SHADE_PAIRS.items():
            row(f"quality {key}", "earth", name, meter.quality_knob(key, (shaded[0], shaded[1]), ("earth", name), runs))


FLIGHTS = (("valley", 5.0, 0.0), ("valley", 0.5, 0.0), ("near", 0.0, 0.23), ("high", 60.0, 0.05), ("coast", 10.0, 0.1))
"""View, metres forward and degrees to the right a frame."""
SAMPLES = (1, 3, 5, 9, 17, 33, 65)


def _antialiasing(session: Session) -> None:
    """What it costs, how near a still picture comes to a supersampled one, what flickers along a flight."""
    session.release()

    def of(seen: View, size: tuple[int, int]) -> Callable[[Mapping[str, Any]], Renderer]:
        def make(overrides: Mapping[str, Any]) -> Renderer:
            scene = preset_scene("earth")
            exposure = scene.environment[Exposure]
            exposure.mode, exposure.ev100 = "fixed", seen.ev100
            return Renderer(scene, size, "medium", overrides)

        return make

    for name in TABLE_VIEWS:
        seen = view(name)
        size = QUICK_SIZE if session.small else SIZE
        costs = antialiasing.cost(of(seen, size), seen, session.runs(15, 5), sun=seen.sun, time_s=seen.time_s)
        for kind, found in costs.items():
            more = found.cpu_ms - costs["none"].cpu_ms
            session.row(f"turning, {kind}", name, size, found.timing, cpu_ms=found.cpu_ms, added_cpu_ms=more)
    small = (160, 90) if session.small else QUICK_SIZE
    for name in ("valley",) if session.small else ("valley", "coast", "limb", "space"):
        seen = view(name)
        errors = antialiasing.still_errors(
            of(seen, small), seen, SAMPLES[::2] if session.small else SAMPLES, 8, sun=seen.sun, time_s=seen.time_s
        )
        for kind, error in errors.items():
            session.row(f"still, {kind}", name, small, error=error.rms_steps, error_unit="steps rms", flip=error.flip)
    for name, step_m, turn_deg in FLIGHTS[:3] if session.small else FLIGHTS:
        seen = view(name)
        make, size = of(seen, (160, 90)), (160, 90)
        with make({}) as renderer:
            cameras = antialiasing.flight(seen, renderer.camera_state(seen), 24, step_m, turn_deg)
        found = antialiasing.shimmer(make, cameras, 10, sun=seen.sun, time_s=seen.time_s)
        for kind, flicker in found.items():
            session.row(
                f"{step_m:g} m and {turn_deg:g} degrees a frame, {kind}", name, size, error=flicker.shimmer_steps,
                error_unit="steps of shimmer", rms_steps=flicker.rms_steps,
                worst_steps=flicker.worst_steps,
            )  # fmt: skip


BENCHES: Mapping[str, Bench] = {
    "total": _total,
    "views": frame_views.bench,
    "passes": _passes,
    "full_hd": _full_hd,
    "skipping": frame_skipping.bench,
    "descent": frame_descent.bench,
    "budget": frame_budget.bench,
    "memory": _memory,
    "knobs": _knobs,
    "antialiasing": _antialiasing,
}
