"""Suite graph: what the frame graph, the state guard and the Python around a frame cost."""

from __future__ import annotations

import cProfile
from collections.abc import Callable, Mapping

import numpy as np

from ...engine.graph import GraphBuilder, NullBackend, PassIO, Plan, TextureSpec
from ..session import Bench, Session
from ..target import at_most
from ..timing import time_variants

SIZE = (640, 360)
PASSES = 30


def chain(passes: int, gated: bool = False) -> GraphBuilder:
    """A graph of that many passes: a chain whose passes each read the two before, with every kind of resource in it.

    gated: every third pass is persistent and skips itself after the first frame.
    """
    builder = GraphBuilder()
    for k in range(passes):
        reads = tuple(f"r{j}" for j in (k - 2, k - 1) if j >= 0)
        often = not gated or k % 3
        lifetime = "transient" if often else "persistent"
        history = k % 10 == 5
        builder.add_pass(
            f"p{k}",
            bind=_idle,
            creates=(TextureSpec(f"r{k}", "rgba16f", 1.0 if k % 4 else 0.5, "history" if history else lifetime),),
            reads=reads,
            history=(f"r{k}",) if history else (),
            kind="compute" if k % 5 == 2 else "raster",
            when=None if often or history else _first_time(),
        )
    builder.export(f"r{passes - 1}")
    return builder


def _idle(io: PassIO) -> Callable[[], None]:
    return _nothing


def _nothing() -> None:
    return None


def _first_time() -> Callable[[], bool]:
    left = [True]

    def gate() -> bool:
        wanted, left[0] = left[0], False
        return wanted

    return gate


def _execute(session: Session) -> None:
    plans = {
        "all run": chain(PASSES).compile(NullBackend(), SIZE),
        "a third skipped": chain(PASSES, gated=True).compile(NullBackend(), SIZE),
    }
    times = time_variants({name: plan.execute for name, plan in plans.items()}, session.runs(40, 15), 5, inner=20)
    for name, timing in times.items():
        session.row(name, timing=timing, target=at_most(0.05, "ms"), target_on="ms", passes=PASSES)
    _release(plans)


def _compile(session: Session) -> None:
    builders = {n: chain(n) for n in (PASSES, 2 * PASSES)}
    times = time_variants(
        {str(n): lambda b=b: b.compile(NullBackend(), SIZE) for n, b in builders.items()}, session.runs(20, 6)
    )
    for name, timing in times.items():
        session.row(f"{name} passes", timing=timing, passes=int(name),
                    target=at_most(2.0, "ms") if int(name) == PASSES else None, target_on="ms")  # fmt: skip


def _resize(session: Session) -> None:
    plan = chain(PASSES).compile(NullBackend(), SIZE)
    sizes = [(640, 360), (1280, 720)]

    def swap() -> None:
        sizes.reverse()
        plan.resize(sizes[0])

    timing = time_variants({"resize": swap}, session.runs(20, 6))["resize"]
    session.row(timing=timing, passes=PASSES, bytes=plan.memory_bytes())
    plan.release()


def _guard(session: Session) -> None:
    from ...engine.gpu.guard import StateGuard

    gpu = session.gpu
    guards = {
        "16 texture units, 8 of the rest": StateGuard(gpu),
        "8 texture units, 8 of the rest": StateGuard(gpu, 8, 8, 8, 8),
    }

    def around(guard: StateGuard) -> Callable[[], None]:
        def run() -> None:
            with guard:
                pass

        return run

    times = time_variants({n: around(g) for n, g in guards.items()}, session.runs(60, 20), 5, gpu.ctx.finish, inner=5)
    for name, timing in times.items():
        session.row(f"save and restore, {name}", timing=timing, target=at_most(0.2, "ms"), target_on="ms")


def _frame_python(session: Session) -> None:
    """The demo's frame on a picture so small, and a view so empty, that next to nothing but Python is left.

    What the driver's own functions take of it is measured apart, by the profiler, and taken off.
    """
    from ... import Camera

    with session.renderer("earth", (16, 9), "medium") as renderer:
        target = renderer.ctx.simple_framebuffer((16, 9))
        cameras = [Camera.at(20.0, 12.0, 3.0e7, pitch_deg=60.0), Camera.at(20.0, 12.0, 3.0e7, pitch_deg=61.0)]
        still = cameras[0]
        before_graph: list[float] = []

        def turning() -> None:
            cameras.reverse()
            renderer.render_to(target, cameras[0])
            before_graph.append(renderer.python_ms)

        def unmoved() -> None:
            renderer.render_to(target, still)

        frames = {"camera turns": turning, "camera still": unmoved}
        times = time_variants(frames, session.runs(60, 20), 5, renderer.ctx.finish)
        driver = {name: _driver_ms(frame, session.runs(60, 20)) for name, frame in frames.items()}
        reports = renderer.passes()
        for name, timing in times.items():
            session.row(
                f"whole frame, {name}",
                timing=timing,
                size=(16, 9),
                target=at_most(1.0, "ms"),
                target_on="python_ms",
                python_ms=timing.ms - driver[name],
                driver_ms=driver[name],
                before_graph_ms=float(np.median(before_graph)) if name == "camera turns" else None,
                passes=len(reports),
                ran=sum(report.ran for report in reports),
            )
        renderer.gpu.leave(target)
        target.release()


def _driver_ms(frame: Callable[[], None], runs: int) -> float:
    """Milliseconds a frame inside moderngl's and ctypes' C functions, which are the driver's."""
    profile = cProfile.Profile()
    profile.enable()
    for _ in range(runs):
        frame()
    profile.disable()
    total = 0.0
    for entry in profile.getstats():
        name = entry.code if isinstance(entry.code, str) else ""
        if "mgl." in name or "CFunction" in name:
            total += entry.inlinetime
    return 1e3 * total / runs


def _release(plans: Mapping[str, Plan]) -> None:
    for plan in plans.values():
        plan.release()


BENCHES: Mapping[str, Bench] = {
    "execute": _execute,
    "compile": _compile,
    "resize": _resize,
    "guard": _guard,
    "frame_python": _frame_python,
}
