"""Writers of one resource are ordered by their stages, and no system knows the passes of another."""

from __future__ import annotations

import ast
import itertools
import random
from pathlib import Path

import pytest
from graph_kit import compiled, idle, tex

from planetfall.engine.graph import STAGES, GraphBuilder, GraphError

ROOT = Path(__file__).parents[2]


def picture() -> GraphBuilder:
    builder = GraphBuilder()
    builder.add_pass("clear", bind=idle, creates=(tex("hdr"),))
    return builder


def order(builder: GraphBuilder) -> list[str]:
    return compiled(builder, "hdr").analysis.alive


def fails(builder: GraphBuilder, *parts: str) -> None:
    builder.export("hdr")
    with pytest.raises(GraphError) as caught:
        builder.analyse()
    for part in parts:
        assert part in str(caught.value)


@pytest.mark.parametrize("seed", range(20))
def test_writers_run_by_stage_however_they_are_declared(seed: int) -> None:
    rng = random.Random(seed)
    stages = [s for s in STAGES if rng.random() < 0.7] or [STAGES[0]]
    passes = [("clear", ""), *((s, s) for s in stages)]
    rng.shuffle(passes)
    builder = GraphBuilder()
    for name, stage in passes:
        how = {"writes": ("hdr",), "stage": stage} if stage else {"creates": (tex("hdr"),)}
        builder.add_pass(name, bind=idle, **how)  # type: ignore[arg-type]
    assert order(builder) == ["clear", *stages]


def test_a_reader_sees_all_stages_but_those_that_follow_it() -> None:
    builder = picture()
    builder.add_pass("late", bind=idle, reads=("copy",), writes=("hdr",), stage="overlay")
    builder.add_pass("copy", bind=idle, reads=("hdr",), creates=(tex("copy"),))
    builder.add_pass("show", bind=idle, reads=("hdr",), creates=(tex("out"),))
    builder.add_pass("early", bind=idle, writes=("hdr",), stage="opaque")
    plan = compiled(builder, "out")
    assert plan.analysis.alive == ["clear", "early", "copy", "late", "show"]
    assert "writes in stage 'overlay'" in plan.explain("late")
    assert "'late' writes 'hdr' after 'early' by its stage ('opaque' before 'overlay')" in plan.explain("late")


def test_stages_hold_for_all_planets_and_views_that_write_into_one_picture() -> None:
    builder = GraphBuilder()
    builder.add_pass("clear", bind=idle, creates=(tex("hdr"),))
    for planet in (0, 1):
        of_planet = builder.scope(planet=planet)
        of_planet.add_pass("sea", bind=idle, writes=("hdr",), stage="water")
        of_planet.add_pass("ground", bind=idle, writes=("hdr",), stage="opaque")
    builder.add_pass("stars", bind=idle, writes=("hdr",), stage="sky")
    assert order(builder) == ["clear", "ground", "ground@planet1", "sea", "sea@planet1", "stars"]


def test_stages_order_nothing_but_writers_of_one_resource() -> None:
    builder = picture()
    builder.add_pass("other", bind=idle, creates=(tex("depth"),))
    builder.add_pass("late", bind=idle, writes=("hdr",), stage="overlay")
    builder.add_pass("early", bind=idle, writes=("depth",), stage="opaque")
    builder.export("depth")
    assert order(builder) == ["clear", "other", "late", "early"]


def test_within_a_stage_after_decides() -> None:
    builder = picture()
    builder.add_pass("b", bind=idle, writes=("hdr",), stage="sky", after=("a",))
    builder.add_pass("a", bind=idle, writes=("hdr",), stage="sky")
    builder.add_pass("ground", bind=idle, writes=("hdr",), stage="opaque")
    assert order(builder) == ["clear", "ground", "a", "b"]


def test_an_order_that_follows_from_what_flows_is_enough_within_a_stage() -> None:
    builder = picture()
    builder.add_pass("b", bind=idle, reads=("x",), writes=("hdr",), stage="sky")
    builder.add_pass("a", bind=idle, writes=("hdr",), creates=(tex("x"),), stage="sky")
    assert order(builder) == ["clear", "a", "b"]


def test_two_writers_in_one_stage_are_unordered() -> None:
    builder = picture()
    for name in "ab":
        builder.add_pass(name, bind=idle, writes=("hdr",), stage="clouds")
    fails(builder, "passes 'a' and 'b' both write 'hdr', in stage 'clouds'", "declare 'b' with after=('a',)",
          "or give it a stage other than 'clouds'")  # fmt: skip


def test_a_writer_without_a_stage_is_told_of_it() -> None:
    builder = picture()
    builder.add_pass("a", bind=idle, writes=("hdr",), stage="clouds")
    builder.add_pass("b", bind=idle, writes=("hdr",), after=("clear",))
    fails(builder, "both write 'hdr'", "or give it a stage, too, as 'a' has ('clouds')")
    builder = picture()
    builder.add_pass("b", bind=idle, writes=("hdr",))
    fails(builder, "without saying when", "after=('clear',)", "or give it a stage (stage='opaque'")


def test_an_unknown_stage() -> None:
    for stage, part in (("cluods", "Did you mean 'clouds'?"), ("xyz", f"The stages are {', '.join(STAGES)}.")):
        with pytest.raises(GraphError) as caught:
            picture().add_pass("a", bind=idle, writes=("hdr",), stage=stage)
        assert f"pass 'a': stage={stage!r} is no stage." in str(caught.value) and part in str(caught.value)


def test_a_stage_without_a_write() -> None:
    with pytest.raises(GraphError, match="pass 'a': stage='sky' is the place of a write, but writes= is empty"):
        GraphBuilder().add_pass("a", bind=idle, creates=(tex("hdr"),), stage="sky")


def test_after_against_the_stages_is_a_circle_that_names_both() -> None:
    builder = picture()
    builder.add_pass("ground", bind=idle, writes=("hdr",), stage="opaque", after=("clouds",))
    builder.add_pass("clouds", bind=idle, writes=("hdr",), stage="clouds")
    fails(builder, "in a circle", "'ground' is declared after 'clouds'",
          "'clouds' writes 'hdr' after 'ground' by its stage ('opaque' before 'clouds')",
          "Give one of the writers another stage")  # fmt: skip


def _passes() -> list[tuple[str, str, list[ast.expr]]]:
    """(file and line, name, what its after= and after_optional= hold) of each add_pass of the library and its games."""
    found = []
    for path in itertools.chain(*((ROOT / folder).rglob("*.py") for folder in ("systems", "games", "planetfall"))):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf8"))):
            if not isinstance(call, ast.Call) or not isinstance(call.func, ast.Attribute):
                continue
            if call.func.attr == "add_pass":
                name = call.args[0]
                assert isinstance(name, ast.Constant) and isinstance(name.value, str), (path, call.lineno)
                behind = [k.value for k in call.keywords if k.arg in ("after", "after_optional")]
                found.append((f"{path.relative_to(ROOT)}:{call.lineno}", name.value, behind))
    return found


def test_no_system_names_another_systems_pass() -> None:
    """By the part before the dot, which is the system's: so that a system can be added without the lists of others."""
    passes = _passes()
    assert len(passes) > 50
    assert sum(bool(behind) for _, _, behind in passes) > 5
    for where, name, behind in passes:
        for value in behind:
            assert isinstance(value, ast.Tuple), f"{where}: write the names out"
            for item in value.elts:
                assert isinstance(item, ast.Constant), f"{where}: write the names out"
                other = str(item.value)
                own = [text.partition(".")[0] for text in (other, name)]
                assert own[0] == own[1], f"{where}: {name} names {other}; give it a stage"


def test_the_page_lists_the_stages_in_their_order() -> None:
    page = (ROOT / "docs" / "frame-graph.md").read_text(encoding="utf8")
    rows = page.split("\n## Stages\n")[1].split("\n## ")[0].splitlines()
    assert [row.split("`")[1] for row in rows if row.startswith("| `")] == list(STAGES)
