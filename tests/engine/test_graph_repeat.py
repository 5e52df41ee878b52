"""Showing the last frame once more: what runs, and when that can't be."""

from __future__ import annotations

from graph_kit import SIZE, Trail, tex

from planetfall.engine.graph import GraphBuilder, NullBackend


def shown(trail: Trail, after: bool = False) -> GraphBuilder:
    builder = GraphBuilder()
    builder.import_("target", kind="framebuffer")
    builder.add_pass("draw", bind=trail.bind, creates=(tex("x", lifetime="history"),))
    builder.add_pass("show", bind=trail.bind, reads=("x",), writes=("target",))
    if after:
        builder.add_pass("note", bind=trail.bind, reads=("x",), creates=(tex("y"),), after=("show",))
        builder.export("y")
    builder.export("target")
    return builder


def test_repeat_shows_the_last_frame_and_runs_nothing_else() -> None:
    trail = Trail()
    builder = shown(trail)
    plan = builder.compile(NullBackend(), SIZE)
    plan.bind_import("target", object())
    assert plan.repeat() is False, "there is no last frame"
    assert trail.frame(plan) == ["draw", "show"]
    kept = plan.resource("x")
    trail.ran.clear()
    assert plan.repeat() and plan.repeat()
    assert trail.ran == ["show", "show"]
    assert plan.resource("x") is kept, "history has not moved on"
    assert [p.ran for p in plan.passes] == [False, True]
    assert plan.passes[0].skipped_why == "nothing has changed: the last picture was shown again"
    assert trail.frame(plan) == ["draw", "show"] and plan.resource("x") is not kept
    plan.invalidate_history()
    assert plan.repeat() is False


def test_repeat_declines_where_inputs_may_be_gone() -> None:
    trail = Trail()
    plan = shown(trail, after=True).compile(NullBackend(), SIZE)
    plan.bind_import("target", object())
    trail.frame(plan)
    assert plan.repeat() is False
    plan.release()
    assert plan.repeat() is False


def test_what_a_system_lends_stays_as_its_passes_left_it() -> None:
    trail = Trail()
    builder = GraphBuilder()
    builder.import_("target", kind="framebuffer")
    builder.import_("map", kind="texture", lent=object())
    builder.add_pass("shadow", bind=trail.bind, writes=("map",))
    builder.add_pass("draw", bind=trail.bind, reads=("map",), creates=(tex("x"),))
    builder.add_pass("show", bind=trail.bind, reads=("x",), writes=("target",))
    builder.export("target")
    plan = builder.compile(NullBackend(), SIZE)
    plan.bind_import("target", object())
    assert trail.frame(plan) == ["shadow", "draw", "show"]
    trail.ran.clear()
    assert plan.repeat() and trail.ran == ["show"]
