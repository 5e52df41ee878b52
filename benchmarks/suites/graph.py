"""Suite graph: what the frame graph, the state guard and the Python around a frame cost."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from ...engine.graph import GraphBuilder, NullBackend, PassIO, Plan, TextureSpec
from ..child import answer_of
from ..display import display
from ..measure.demo_cost import SIZE as DEMO_SIZE
from ..session import Bench, Session
from ..target import at_most
from ..timing import Timing, time_variants

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
    """The frame graph's own Python in a frame, its passes doing nothing."""
    plans = {
        "all run": chain(PASSES).compile(NullBackend(), SIZE),
        "a third skipped": chain(PASSES, gated=True).compile(NullBackend(), SIZE),
    }
    times = time_variants({name: plan.execute for name, plan in plans.items()}, session.runs(40, 15), 5, inner=20)
    for name, timing in times.items():
        session.row(name, timing=timing, target=at_most(0.05, "ms"), target_on="ms", passes=PASSES)
    _release(plans)


def _compile(session: Session) -> None:
    """Declared passes to a plan."""
    builders = {n: chain(n) for n in (PASSES, 2 * PASSES)}
    times = time_variants(
        {str(n): lambda b=b: b.compile(NullBackend(), SIZE) for n, b in builders.items()}, session.runs(20, 6)
    )
    for name, timing in times.items():
        session.row(f"{name} passes", timing=timing, passes=int(name),
                    target=at_most(2.0, "ms") if int(name) == PASSES else None, target_on="ms")  # fmt: skip


def _resize(session: Session) -> None:
    """A plan for another size of picture."""
    plan = chain(PASSES).compile(NullBackend(), SIZE)
    sizes = [(640, 360), (1280, 720)]

    def swap() -> None:
        sizes.reverse()
        plan.resize(sizes[0])

    timing = time_variants({"resize": swap}, session.runs(20, 6))["resize"]
    session.row(timing=timing, passes=PASSES, bytes=plan.memory_bytes())
    plan.release()


def _guard(session: Session) -> None:
    """Keeping a host's OpenGL state and putting it back."""
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
    """A whole frame's Python, from the call to the driver's front end, in a process whose driver draws nothing."""
    runs = session.runs(300, 100)
    for name, found in _alone(session, "python_cost", runs).items():
        session.row(
            f"whole frame, {name}",
            "near",
            (160, 90),
            Timing(found["ms"], found["low"], found["high"], runs),
            target=at_most(1.0, "ms"),
            target_on="ms",
            update_ms=found["update_ms"],
            passes=int(found["passes"]),
        )


def _demo_python(session: Session) -> None:
    """A whole frame's Python of the demo in a window: events, flight, picture, interface, swap."""
    runs = session.runs(300, 100)
    with display() as where:
        found = _alone(session, "demo_cost", runs, where)
    for name, times in found.items():
        session.row(
            f"demo's frame, {name}",
            "near",
            DEMO_SIZE,
            Timing(times["ms"], times["low"], times["high"], runs),
            target=at_most(2.0, "ms"),
            target_on="laid_out_ms" if "knobs" in name else "cpu_ms",
            cpu_ms=times["cpu_ms"],
            cpu_p10_ms=times["cpu_p10_ms"],
            interface_ms=times["interface_ms"],
            laid_out_ms=times["laid_out_ms"],
            swap_ms=times["swap_ms"],
        )


def _alone(
    session: Session, module: str, runs: int, environment: Mapping[str, str] = MappingProxyType({})
) -> dict[str, dict[str, float]]:
    """What a module of benchmarks/measure prints, run by itself with a driver that draws nothing. What such a driver
    computes is nothing either: its tables are kept from the cache, where others would take them for true ones."""
    quiet = {"GALLIUM_NOOP": "1", "PLANETFALL_CACHE": ""} if session.gpu.caps.is_software else {}
    whole = f"planetfall.benchmarks.measure.{module}"
    return answer_of("-m", whole, str(runs), environment={**quiet, **environment})


def _release(plans: Mapping[str, Plan]) -> None:
    for plan in plans.values():
        plan.release()


BENCHES: Mapping[str, Bench] = {
    "execute": _execute,
    "compile": _compile,
    "resize": _resize,
    "guard": _guard,
    "frame_python": _frame_python,
    "demo_python": _demo_python,
}
