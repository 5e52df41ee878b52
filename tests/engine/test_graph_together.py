"""Passes that are skipped together: only_while."""

from __future__ import annotations

import pytest
from graph_kit import Trail, compiled, tex

from planetfall.engine.graph import GraphBuilder, GraphError


class Gate:
    """A group's only_while; counts how often it was asked."""

    def __init__(self) -> None:
        self.open = True

    def __call__(self) -> bool:
        return self.open


def group(trail: Trail, gate: Gate, asked: list[int] | None = None) -> GraphBuilder:
    """Lists are made and read within the group; the picture is made outside of it and painted by it."""
    builder = GraphBuilder()

    def when() -> bool:
        if asked is not None:
            asked.append(1)
        return False

    builder.add_pass("clear", bind=trail.bind, creates=(tex("picture"),))
    builder.add_pass("keep", bind=trail.bind, creates=(tex("kept", lifetime="persistent", size=(8, 8)),), when=when,
                     only_while=gate)  # fmt: skip
    builder.add_pass("list", bind=trail.bind, creates=(tex("tiles"),), only_while=gate)
    builder.add_pass("paint", bind=trail.bind, reads=("tiles", "kept"), writes=("picture",), after=("clear",),
                     only_while=gate)  # fmt: skip
    builder.add_pass("show", bind=trail.bind, reads=("picture",), creates=(tex("out"),), after=("paint",))
    return builder


def test_a_group_is_skipped_as_one():
    trail, gate, asked = Trail(), Gate(), []
    plan = compiled(group(trail, gate, asked), "out")
    assert trail.frame(plan) == ["clear", "keep", "list", "paint", "show"]
    gate.open = False
    assert trail.frame(plan) == ["clear", "show"]
    assert len(asked) == 1, "when() of a group that is skipped is not asked"
    skipped = {p.name: p.skipped_why for p in plan.passes if not p.ran}
    assert set(skipped) == {"keep", "list", "paint"}
    assert all("only_while() said no" in str(why) for why in skipped.values())
    assert "skipped with its group" in plan.explain("list")
    gate.open = True
    assert trail.frame(plan) == ["clear", "list", "paint", "show"]


def test_what_persists_is_made_once_even_then():
    trail, gate = Trail(), Gate()
    gate.open = False
    plan = compiled(group(trail, gate), "out")
    assert trail.frame(plan) == ["clear", "keep", "show"], "readers outside would see noise"
    assert trail.frame(plan) == ["clear", "show"]


def test_who_is_read_from_outside_runs_always_and_so_does_what_it_reads():
    trail, gate = Trail(), Gate()
    builder = group(trail, gate)
    builder.add_pass("sort", bind=trail.bind, reads=("tiles",), creates=(tex("sorted"),), only_while=gate)
    builder.add_pass("look", bind=trail.bind, reads=("sorted",), creates=(tex("seen"),))
    plan = compiled(builder, "out", "seen")
    gate.open = False
    trail.frame(plan)
    assert set(trail.frame(plan)) == {"clear", "show", "list", "sort", "look"}
    assert "were it not read outside of its group" in plan.explain("sort")


def test_an_export_and_another_group_are_outside_too():
    trail, gate = Trail(), Gate()
    gate.open = False
    plan = compiled(group(trail, gate), "out", "tiles")
    trail.frame(plan)
    assert "list" in trail.frame(plan) and "paint" not in trail.frame(plan)
    other = Gate()
    builder = group(trail, gate)
    builder.add_pass("theirs", bind=trail.bind, reads=("tiles",), writes=("picture",), after=("paint",),
                     only_while=other)  # fmt: skip
    plan = compiled(builder, "out")
    trail.frame(plan)
    assert {"list", "theirs"} <= set(trail.frame(plan))


def test_what_is_no_function_is_refused():
    with pytest.raises(GraphError, match="only_while=3 is not callable"):
        GraphBuilder().add_pass("x", bind=Trail().bind, creates=(tex("y"),), only_while=3)  # type: ignore[arg-type]
