"""Executing a plan: gates, history, imports, failures, resizing, replacing, timing."""

from __future__ import annotations

import gc
import tracemalloc
from collections.abc import Callable
from typing import Any

import pytest
from graph_kit import SIZE, Trail, compiled, idle, tex

from planetfall.engine.graph import BufferSpec, GraphBuilder, GraphError, NullBackend, PassIO, Plan

# --- when ------------------------------------------------------------------------------------------------------------


def gated(trail: Trail, when: Callable[[], bool], size: float | tuple[int, int] = (8, 8)) -> GraphBuilder:
    builder = GraphBuilder()
    builder.add_pass("bake", bind=trail.bind, creates=(tex("map", lifetime="persistent", size=size),), when=when)
    builder.add_pass("use", bind=trail.bind, reads=("map",), creates=(tex("x"),))
    return builder


def test_when_skips_and_says_so() -> None:
    trail, wanted = Trail(), [True, False, True]
    plan = compiled(gated(trail, lambda: wanted.pop(0)), "x")
    assert trail.frame(plan) == ["bake", "use"]
    assert trail.frame(plan) == ["use"]
    bake = plan.passes[0]
    assert (bake.name, bake.ran, bake.skipped_why) == ("bake", False, "its when() said no")
    assert trail.frame(plan) == ["bake", "use"]
    assert plan.passes[0].skipped_why is None


def test_new_persistent_content_is_made_whatever_when_says() -> None:
    trail, asked = Trail(), []
    plan = compiled(gated(trail, lambda: bool(asked.append(1)), size=1.0), "x")
    assert trail.frame(plan) == ["bake", "use"]  # nothing had ever been written
    assert trail.frame(plan) == ["use"]
    plan.resize((10, 10))
    assert trail.frame(plan) == ["bake", "use"]
    assert trail.frame(plan) == ["use"]
    plan.invalidate_persistent()
    assert trail.frame(plan) == ["bake", "use"]
    assert len(asked) == 5  # asked every frame, also when overruled


def test_fixed_size_content_survives_a_resize() -> None:
    trail = Trail()
    plan = compiled(gated(trail, lambda: False), "x")
    trail.frame(plan)
    plan.resize((10, 10))
    assert trail.frame(plan) == ["use"]


@pytest.mark.parametrize(
    ("exports", "read_by"),
    [(["y"], {"shown"}), (["y", "z"], {"shown", "other"}), (["x", "y"], {"shown", ""})],
)
def test_a_pass_knows_who_reads_what_it_makes(exports: list[str], read_by: set[str]) -> None:
    """Those that run: a pass that nothing asks for is culled, and reads nothing."""
    builder, found = GraphBuilder(), []

    def bind(io: PassIO) -> Callable[[], None]:
        found.append(io.readers("x"))
        return lambda: None

    builder.add_pass("make", bind=bind, creates=(tex("x"),))
    builder.add_pass("shown", bind=idle, reads=("x",), creates=(tex("y"),))
    builder.add_pass("other", bind=idle, reads=("x",), creates=(tex("z"),))
    compiled(builder, *exports).execute()
    assert set(found) == {frozenset(read_by)}


# --- history ---------------------------------------------------------------------------------------------------------


class Accumulate:
    """creates "h" from last frame's "h"; notes (this frame's object, last frame's, validity) for each frame."""

    def __init__(self, size: float | tuple[int, int] = 1.0) -> None:
        self.seen: list[tuple[Any, Any, bool]] = []
        self.binds = 0
        self.builder = GraphBuilder()
        self.builder.add_pass(
            "accumulate", bind=self.bind, creates=(tex("h", lifetime="history", size=size),), history=("h",)
        )
        self.builder.export("h")

    def bind(self, io: PassIO) -> Callable[[], None]:
        self.binds += 1
        now, last, valid = io.texture("h"), io.history("h"), io.history_valid
        return lambda: self.seen.append((now, last, valid.value))


def test_history_alternates_between_two_objects() -> None:
    case = Accumulate()
    plan = case.builder.compile(NullBackend(), SIZE)
    assert case.binds == 2  # once per parity
    for _ in range(4):
        plan.execute()
        assert plan.resource("h") is case.seen[-1][0]
    assert case.binds == 2
    (a, b, _), *_ = case.seen
    assert a is not b
    assert [(now is a, last is a) for now, last, _ in case.seen] == [(True, False), (False, True)] * 2
    assert [valid for *_, valid in case.seen] == [False, True, True, True]


def test_history_validity() -> None:
    case = Accumulate()
    plan = case.builder.compile(NullBackend(), SIZE)
    plan.execute()
    plan.execute()
    plan.invalidate_history()
    plan.execute()
    plan.execute()
    plan.resize((5, 5))
    plan.execute()
    plan.execute()
    assert [valid for *_, valid in case.seen] == [False, True, False, True, False, True]


def test_history_of_fixed_size_stays_valid_in_a_resize() -> None:
    case = Accumulate(size=(1, 1))
    plan = case.builder.compile(NullBackend(), SIZE)
    plan.execute()
    written = plan.resource("h")
    plan.resize((5, 5))
    plan.execute()
    assert case.seen[-1][1:] == (written, True)


def test_passes_without_history_are_bound_once() -> None:
    trail = Trail()
    builder = GraphBuilder()
    builder.add_pass("a", bind=trail.bind, creates=(tex("x"),))
    builder.add_pass("b", bind=trail.bind, reads=("x",), creates=(tex("h", lifetime="history"),))
    builder.add_pass("c", bind=trail.bind, reads=("h",), creates=(tex("y"),))
    compiled(builder, "y")
    assert trail.bound == ["a", "b", "b", "c", "c"]


def test_validity_of_several_histories() -> None:
    flags = []
    builder = GraphBuilder()

    def bind(io: PassIO) -> Callable[[], None]:
        both, fixed = io.history_valid, io.history_valid_for("fixed")
        return lambda: flags.append((both.value, fixed.value))

    specs = (tex("fixed", lifetime="history", size=(1, 1)), tex("full", lifetime="history"))
    builder.add_pass("a", bind=bind, creates=specs, history=("fixed", "full"))
    plan = compiled(builder, "full")
    plan.execute()
    plan.execute()
    plan.resize((5, 5))
    plan.execute()
    assert flags == [(False, False), (True, True), (False, True)]


# --- imports ---------------------------------------------------------------------------------------------------------


def presenting(seen: list[Any]) -> GraphBuilder:
    builder = GraphBuilder()
    builder.import_("target", "framebuffer")
    builder.import_("unused", "texture")

    def bind(io: PassIO) -> Callable[[], None]:
        slot = io.imported("target")
        return lambda: seen.append(slot.value)

    builder.add_pass("show", bind=bind, writes=("target",))
    return builder


def test_imports_are_bound_late() -> None:
    seen: list[Any] = []
    plan = compiled(presenting(seen), "target")
    plan.bind_import("target", "screen")
    plan.execute()
    plan.bind_import("target", "picture")
    plan.execute()
    assert seen == ["screen", "picture"]
    assert plan.resource("target") == "picture"


def test_what_a_system_lends_is_there_from_the_start_in_each_view_its_own() -> None:
    seen: list[Any] = []

    def declared(*lent: str) -> GraphBuilder:
        builder = GraphBuilder()
        for view, block in enumerate(lent):
            of_view = builder.scope(view=view)
            of_view.import_("block", "buffer", lent=block)

            def bind(io: PassIO) -> Callable[[], None]:
                slot = io.imported("block")
                return lambda: seen.append(slot.value)

            of_view.add_pass("draw", bind=bind, reads=("block",), side_effect=True)
        return builder

    backend = NullBackend()
    plan = declared("a", "b").compile(backend, SIZE)
    plan.execute()
    assert seen == ["a", "b"]
    assert "block" not in plan.to_mermaid() and "'block': imported buffer" in plan.explain("draw")
    seen.clear()
    declared("c", "b").compile(backend, SIZE, previous=plan).execute()
    assert seen == ["c", "b"], "what is lent now, not what the plan before was lent"


def test_unbound_import() -> None:
    plan = compiled(presenting([]), "target")
    with pytest.raises(GraphError, match=r"import 'target' \(framebuffer\) is not bound, but pass 'show' uses it"):
        plan.execute()
    with pytest.raises(GraphError, match=r"no such import\. Did you mean 'target'"):
        plan.bind_import("targt", 1)


# --- failures --------------------------------------------------------------------------------------------------------


def test_a_failing_pass_is_named_and_the_plan_goes_on() -> None:
    case = Accumulate()
    trouble = [False, True, False]
    trail = Trail()

    def bind(io: PassIO) -> Callable[[], None]:
        def run() -> None:
            if trouble.pop(0):
                raise ZeroDivisionError("oh")

        return run

    case.builder.add_pass("fragile", bind=bind, reads=("h",), side_effect=True, system="demo")
    case.builder.add_pass("behind", bind=trail.bind, after=("fragile",), side_effect=True)
    backend = NullBackend()
    plan = case.builder.compile(backend, SIZE)
    plan.execute()
    first = plan.resource("h")
    with pytest.raises(ZeroDivisionError) as caught:
        plan.execute()
    assert caught.value.__notes__ == ["in pass 'fragile' (system 'demo') of the frame graph"]
    assert [r.skipped_why for r in plan.passes] == [None] + ["pass 'fragile' raised ZeroDivisionError"] * 2
    assert plan.resource("h") is first  # the broken frame does not count
    plan.execute()
    assert case.seen[-1] == (case.seen[-2][0], first, True)
    assert [r.skipped_why for r in plan.passes] == [None] * 3
    assert backend.counts["begin_frame"] == backend.counts["end_frame"] == 3


def test_a_gate_that_raises_is_named_too() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, when=lambda: 1 // 0, side_effect=True)
    with pytest.raises(ZeroDivisionError) as caught:
        compiled(builder).execute()
    assert "in pass 'a'" in caught.value.__notes__[0]


def test_persistent_content_that_failed_halfway_is_made_in_the_next_frame() -> None:
    dirty, trouble, done = [True], [True], []

    def take() -> bool:
        return dirty.pop() if dirty else False

    def bind(io: PassIO) -> Callable[[], None]:
        return lambda: done.append(1 // (not trouble.pop() if trouble else 1))

    builder = GraphBuilder()
    builder.add_pass("bake", bind=bind, creates=(tex("map", lifetime="persistent"),), when=take)
    plan = compiled(builder, "map")
    with pytest.raises(ZeroDivisionError):
        plan.execute()
    plan.execute()
    plan.execute()
    assert done == [1]
    dirty.append(True)
    trouble.append(True)
    with pytest.raises(ZeroDivisionError):
        plan.execute()
    plan.execute()
    assert done == [1, 1]


def test_a_failing_bind_is_named_and_leaves_nothing_behind() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("x"),))
    builder.add_pass("b", bind=lambda io: 1 // 0, reads=("x",), creates=(tex("y"),), system="demo")  # type: ignore
    builder.export("y")
    backend = NullBackend()
    with pytest.raises(ZeroDivisionError) as caught:
        builder.compile(backend, SIZE)
    assert caught.value.__notes__ == ["while binding pass 'b' (system 'demo') of the frame graph"]
    assert not backend.live


def test_a_bind_has_to_return_a_function() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=lambda io: None, side_effect=True)  # type: ignore
    with pytest.raises(GraphError, match="bind of pass 'a' returned None"):
        compiled(builder)


def test_creation_that_fails_is_named_and_rolled_back() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("x"), BufferSpec("b", 4)))
    builder.export("x")
    backend = NullBackend()
    backend.fail_on = {"b"}
    with pytest.raises(MemoryError) as caught:
        builder.compile(backend, SIZE)
    assert "while the frame graph created 'b'" in caught.value.__notes__[0]
    assert not backend.live


def stashing(fail_at: list[tuple[int, int]]) -> tuple[GraphBuilder, dict[str, Any]]:
    """Passes that keep what they looked up outside their closure, one of which fails at some sizes."""
    stash: dict[str, Any] = {}

    def bind_first(io: PassIO) -> Callable[[], None]:
        stash["texture"] = io.texture("x")
        stash["framebuffer"] = io.framebuffer(("x",))
        return lambda: None

    def bind_second(io: PassIO) -> Callable[[], None]:
        if io.size in fail_at:
            raise ValueError("not at this size")
        return lambda: None

    builder = GraphBuilder()
    builder.add_pass("first", bind=bind_first, creates=(tex("x"),))
    builder.add_pass("second", bind=bind_second, reads=("x",), creates=(tex("y"),))
    builder.export("y")
    return builder, stash


def test_a_failed_resize_changes_nothing() -> None:
    builder, stash = stashing([(7, 7)])
    backend = NullBackend()
    plan = builder.compile(backend, SIZE)
    before = list(backend.live)
    with pytest.raises(ValueError, match="not at this size"):
        plan.resize((7, 7))
    assert plan.size == SIZE
    assert backend.live == before
    assert stash["texture"] is plan.resource("x")
    assert not stash["framebuffer"].released
    plan.execute()
    plan.resize((8, 8))
    assert plan.resource("y").size == (8, 8)


# --- resize and replace ----------------------------------------------------------------------------------------------


def test_resize_makes_only_what_is_relative() -> None:
    trail = Trail()
    builder = GraphBuilder()
    specs = (tex("full"), tex("half", size=0.5), tex("fixed", size=(4, 4)), BufferSpec("buffer", 16))
    builder.add_pass("a", bind=trail.bind, creates=specs)
    builder.add_pass("b", bind=trail.bind, reads=tuple(s.name for s in specs), creates=(tex("x"),))
    plan = compiled(builder, "x")
    old = {name: plan.resource(name) for name in plan.resources}
    plan.resize((33, 17))
    new = {name: plan.resource(name) for name in plan.resources}
    assert {name for name in old if new[name] is old[name]} == {"fixed", "buffer"}
    assert (new["full"].size, new["half"].size) == ((33, 17), (17, 9))
    assert [name for name in old if old[name].released] == ["full", "half", "x"]
    assert trail.bound == ["a", "b"] * 2
    plan.resize((33, 17))
    assert trail.bound == ["a", "b"] * 2  # nothing to do


def test_release_frees_all_and_says_so() -> None:
    case = Accumulate()
    backend = NullBackend()
    plan = case.builder.compile(backend, SIZE)
    plan.gpu_timing = True
    plan.release()
    plan.release()
    assert not backend.live
    assert backend.timers[0].released
    for use in (plan.execute, lambda: plan.resize((4, 4)), lambda: plan.resource("h")):
        with pytest.raises(GraphError, match="was released; compile the graph again"):
            use()


def replaceable(trail: Trail, extra: bool) -> GraphBuilder:
    builder = GraphBuilder()
    builder.import_("target", "framebuffer")
    builder.add_pass("bake", bind=trail.bind, creates=(tex("map", lifetime="persistent"),), when=lambda: False)
    specs = (tex("h", lifetime="history"), tex("x"))
    builder.add_pass("a", bind=trail.bind, reads=("map",), creates=specs, history=("h",))
    if extra:
        builder.add_pass("b", bind=trail.bind, writes=("x",), after=("a",), creates=(tex("y", format="r8"),))
    builder.add_pass("show", bind=trail.bind, reads=("x",), writes=("target",))
    builder.export("target")
    return builder


@pytest.mark.parametrize("frames", [1, 2])
def test_replacing_a_plan_keeps_content(frames: int) -> None:
    trail, backend = Trail(), NullBackend()
    old = replaceable(trail, extra=False).compile(backend, SIZE)
    old.bind_import("target", "screen")
    for _ in range(frames):
        old.execute()
    content = {name: old.resource(name) for name in ("h", "map", "x")}
    valid: list[bool] = []
    builder = replaceable(trail, extra=True)

    def bind(io: PassIO) -> Callable[[], None]:
        last, flag = io.history("h"), io.history_valid
        return lambda: valid.append(flag.value and last is content["h"])

    builder.add_pass("check", bind=bind, history=("h",), side_effect=True)
    plan = builder.compile(backend, SIZE, previous=old)
    assert plan.resource("h") is content["h"]
    assert plan.resource("map") is content["map"]
    assert backend.counts["create_texture"] == 4 + 1  # map, h twice, x; then only y
    assert trail.frame(plan) == ["a", "b", "show"]  # the import is still bound and bake has nothing to do
    assert valid == [True]
    with pytest.raises(GraphError, match="was released"):
        old.execute()
    plan.release()
    assert not backend.live


def test_replacing_that_fails_leaves_the_old_plan() -> None:
    builder, stash = stashing([(7, 7)])
    backend = NullBackend()
    old = builder.compile(backend, SIZE)
    live = list(backend.live)
    with pytest.raises(ValueError, match="not at this size"):
        builder.compile(backend, (7, 7), previous=old)
    old.execute()
    assert backend.live == live
    assert stash["texture"] is old.resource("x")
    with pytest.raises(GraphError, match="another backend"):
        builder.compile(NullBackend(), SIZE, previous=old)
    new = builder.compile(backend, (7, 8), previous=old)
    assert new.resource("x").size == (7, 8)
    new.release()
    assert not backend.live


# --- timing ----------------------------------------------------------------------------------------------------------


def chain(count: int) -> Plan:
    builder = GraphBuilder()
    builder.add_pass("p0", bind=idle, creates=(tex("x0"),))
    for i in range(1, count):
        builder.add_pass(f"p{i}", bind=idle, reads=(f"x{i - 1}",), creates=(tex(f"x{i}"),))
    return compiled(builder, f"x{count - 1}")


def test_cpu_times_are_there_after_a_frame() -> None:
    plan = chain(5)
    assert [r.skipped_why for r in plan.passes] == ["no frame has been executed yet"] * 5
    plan.execute()
    assert all(r.ran and r.cpu_ms > 0 and r.gpu_ms is None for r in plan.passes)


def test_gpu_times_are_opt_in_and_late() -> None:
    plan = chain(3)
    assert not plan.gpu_timing
    plan.gpu_timing = True
    for frame in range(5):
        assert [r.gpu_ms for r in plan.passes] == [None if frame < 4 else 0.0] * 3
        plan.execute()
    plan.resize((5, 5))
    plan.execute()
    assert plan.passes[0].gpu_ms == 0.0
    plan.gpu_timing = False
    plan.execute()
    assert plan.passes[0].gpu_ms is None


def test_gpu_timers_survive_a_failing_pass() -> None:
    trouble = [True]
    builder = GraphBuilder()
    builder.add_pass("a", bind=lambda io: lambda: 1 // (not trouble[0]), side_effect=True)
    plan = compiled(builder)
    plan.gpu_timing = True
    with pytest.raises(ZeroDivisionError):
        plan.execute()
    trouble[0] = False
    for _ in range(4):
        plan.execute()
    assert plan.passes[0].gpu_ms == 0.0


def test_execute_keeps_no_memory_and_touches_no_backend() -> None:
    plan = chain(30)
    for _ in range(3):
        plan.execute()
    backend = plan.backend
    assert isinstance(backend, NullBackend)
    calls = len(backend.calls)
    gc.collect()
    tracemalloc.start()
    try:
        before = tracemalloc.take_snapshot()
        for _ in range(50):
            plan.execute()
        after = tracemalloc.take_snapshot()
    finally:
        tracemalloc.stop()
    grown = [d for d in after.compare_to(before, "filename") if "plan.py" in str(d.traceback) and d.size_diff > 2000]
    assert not grown
    assert len(backend.calls) == calls
