"""Which passes survive, and in which order they run."""

from __future__ import annotations

from graph_kit import idle, tex

from planetfall.engine.graph import GraphBuilder


def order(builder: GraphBuilder, *exports: str) -> list[str]:
    for name in exports:
        builder.export(name)
    return builder.analyse().alive


def test_declaration_order_where_nothing_else_is_said() -> None:
    builder = GraphBuilder()
    for name in ("c", "a", "b"):
        builder.add_pass(name, bind=idle, side_effect=True)
    assert order(builder) == ["c", "a", "b"]


def test_declared_in_any_order() -> None:
    builder = GraphBuilder()
    builder.add_pass("show", bind=idle, reads=("x",), creates=(tex("y"),))
    builder.add_pass("make", bind=idle, creates=(tex("x"),))
    assert order(builder, "y") == ["make", "show"]


def test_nobody_reads_it_nobody_runs_it() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("x"),))
    builder.add_pass("b", bind=idle, reads=("x",), creates=(tex("y"),))
    builder.add_pass("c", bind=idle, reads=("y",), creates=(tex("z"),))
    builder.add_pass("d", bind=idle)
    builder.export("x")
    found = builder.analyse()
    assert found.alive == ["a"]
    assert found.culled["b"] == "what uses 'y' is culled as well ('c')"
    assert found.culled["c"] == "nobody reads 'z'"
    assert "side_effect=True" in found.culled["d"]
    assert list(found.lifetimes.span) == ["x"]


def test_side_effect_keeps_a_pass_and_its_inputs() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("x"),))
    builder.add_pass("b", bind=idle, reads=("x",), side_effect=True)
    assert order(builder) == ["a", "b"]


def test_reader_runs_after_all_writers() -> None:
    builder = GraphBuilder()
    builder.add_pass("c", bind=idle, reads=("depth",), creates=(tex("z"),))
    builder.add_pass("a", bind=idle, creates=(tex("depth"),))
    builder.add_pass("b", bind=idle, writes=("depth",), after=("a",))
    assert order(builder, "z") == ["a", "b", "c"]


def test_writer_declared_after_a_reader_lets_it_see_the_earlier_version() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("depth"),))
    builder.add_pass("b", bind=idle, writes=("depth",), after=("early",))
    builder.add_pass("late", bind=idle, reads=("depth",), creates=(tex("l"),))
    builder.add_pass("early", bind=idle, reads=("depth",), creates=(tex("e"),))
    assert order(builder, "l", "e") == ["a", "early", "b", "late"]


def test_writer_that_nobody_sees_is_culled() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("depth"),))
    builder.add_pass("early", bind=idle, reads=("depth",), creates=(tex("e"),))
    builder.add_pass("b", bind=idle, writes=("depth",), after=("early",))
    builder.export("e")
    found = builder.analyse()
    assert found.alive == ["a", "early"]
    assert found.culled == {"b": "nobody reads 'depth' behind it"}


def test_ping_pong() -> None:
    builder = GraphBuilder()
    builder.add_pass("e", bind=idle, reads=("y",), creates=(tex("out"),))
    builder.add_pass("d", bind=idle, reads=("x",), writes=("y",), after=("c",))
    builder.add_pass("c", bind=idle, reads=("y",), writes=("x",), after=("b",))
    builder.add_pass("b", bind=idle, reads=("x",), creates=(tex("y"),))
    builder.add_pass("a", bind=idle, creates=(tex("x"),))
    assert order(builder, "out") == ["a", "b", "c", "d", "e"]


def test_order_through_data_counts_as_after() -> None:
    # d reads what c made from depth, so c saw depth before d changed it: nobody has to say so.
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("depth"),))
    builder.add_pass("d", bind=idle, reads=("z",), writes=("depth",), after=("a",))
    builder.add_pass("c", bind=idle, reads=("depth",), creates=(tex("z"),))
    builder.add_pass("b", bind=idle, writes=("depth",), after=("a",))
    assert order(builder, "depth") == ["a", "b", "c", "d"]


def test_chain_of_writers_survives_as_a_whole() -> None:
    builder = GraphBuilder()
    builder.import_("target", "framebuffer")
    builder.add_pass("ui", bind=idle, writes=("target",), after_optional=("show", "absent"))
    builder.add_pass("sky", bind=idle, writes=("hdr",), after_optional=("sea", "ground"))
    builder.add_pass("show", bind=idle, reads=("hdr",), writes=("target",))
    builder.add_pass("ground", bind=idle, writes=("hdr",), after=("clear",))
    builder.add_pass("clear", bind=idle, creates=(tex("hdr"),))
    assert order(builder, "target") == ["clear", "ground", "sky", "show", "ui"]


def test_order_holds_through_culled_passes() -> None:
    builder = GraphBuilder()
    builder.add_pass("z", bind=idle, creates=(tex("x"),), after=("middle",))
    builder.add_pass("middle", bind=idle, after=("y",))
    builder.add_pass("y", bind=idle, creates=(tex("w"),))
    assert order(builder, "x", "w") == ["y", "z"]


def test_history_keeps_its_makers_but_orders_nothing() -> None:
    builder = GraphBuilder()
    builder.add_pass("use", bind=idle, history=("h",), creates=(tex("x"),))
    builder.add_pass("make", bind=idle, reads=("x",), creates=(tex("h", lifetime="history"),))
    builder.add_pass("refine", bind=idle, writes=("h",), after=("make",))
    assert order(builder, "x") == ["use", "make", "refine"]


def test_optional_reads() -> None:
    builder = GraphBuilder()
    builder.add_pass("use", bind=idle, reads_optional=("shadow", "absent"), creates=(tex("x"),))
    builder.add_pass("shadow", bind=idle, creates=(tex("shadow"),))
    assert order(builder, "x") == ["shadow", "use"]
    assert "without 'absent', which nobody creates" in builder.analyse().explain("use")


def test_reading_an_import_needs_no_writer() -> None:
    builder = GraphBuilder()
    builder.import_("photo", "texture")
    builder.add_pass("use", bind=idle, reads=("photo",), creates=(tex("x"),))
    assert order(builder, "x") == ["use"]
