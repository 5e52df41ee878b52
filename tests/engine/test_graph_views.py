"""Several views and planets in one graph: whose a name is, what they share, sizes, and how people see it."""

from __future__ import annotations

from typing import Any

import pytest
from graph_kit import SIZE, Trail, idle, tex

from planetfall.engine.graph import (
    BufferSpec,
    GraphBuilder,
    GraphError,
    NullBackend,
    PassIO,
    Plan,
    base_name,
    qualified,
)
from planetfall.engine.graph.names import canonical, split

SMALL = (20, 10)


class Kept:
    """A bind that keeps what its pass found by bare names, under the pass's name."""

    def __init__(self, *names: str) -> None:
        self.names = names
        self.found: dict[str, tuple[Any, ...]] = {}

    def __call__(self, io: PassIO) -> Any:
        self.found[io.pass_name] = tuple(io.buffer(n) if n.startswith("b.") else io.texture(n) for n in self.names)
        return lambda: None


def frame_of(builder: GraphBuilder, draw: Any = idle, show: Any = idle) -> None:
    """What systems would declare for one view, whichever it is."""
    builder.import_("target", "framebuffer")
    builder.add_pass("clear", bind=idle, creates=(tex("depth", format="depth32f"), tex("color")), system="gbuffer")
    builder.add_pass("draw", bind=draw, writes=("depth", "color"), after=("clear",), system="terrain")
    builder.add_pass("show", bind=show, reads=("color", "depth"), writes=("target",), system="gbuffer")


def two_views(size: tuple[int, int] | None = SMALL, **binds: Any) -> GraphBuilder:
    builder = GraphBuilder()
    for view in (0, 1):
        of_view = builder.scope(view=view, size=size if view else None)
        frame_of(of_view, **binds)
        of_view.export("target")
    return builder


def compiled(builder: GraphBuilder, previous: Plan | None = None) -> Plan:
    return builder.compile(NullBackend() if previous is None else previous.backend, SIZE, previous)


def raises(builder: GraphBuilder, *parts: str) -> None:
    with pytest.raises(GraphError) as caught:
        builder.compile(NullBackend(), SIZE)
    for part in parts:
        assert part in str(caught.value)


# --- names ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("view", "planet", "name"),
    [
        (None, None, "a.b"),
        (0, 0, "a.b"),
        (1, 0, "a.b@view1"),
        (None, 2, "a.b@planet2"),
        (12, 3, "a.b@view12.planet3"),
    ],
)
def test_only_indices_above_zero_are_written(view: int | None, planet: int | None, name: str) -> None:
    assert qualified("a.b", view, planet) == name
    assert split(name) == ("a.b", view or None, planet or None)
    assert base_name(name) == "a.b" and canonical(name) == name


def test_zeros_and_order_do_not_matter_to_who_asks() -> None:
    assert canonical("x@view0") == canonical("x@planet0.view0") == "x"
    assert canonical("x@planet2.view1") == "x@view1.planet2"
    for strange in ("x@", "x@view", "x@view01", "x@1", "x@view1.view2", "x@view1@planet1", "x@view-1"):
        with pytest.raises(GraphError, match="behind @ stand a view and a planet"):
            split(strange)


# --- views ------------------------------------------------------------------------------------------------------------


def test_two_views_have_their_own_of_everything() -> None:
    draw = Kept("color", "depth")
    builder = two_views(draw=draw)
    plan = compiled(builder)
    assert plan.analysis.alive == ["clear", "draw", "show", "clear@view1", "draw@view1", "show@view1"]
    assert plan.resources == ("depth", "color", "depth@view1", "color@view1")
    first, second = draw.found["draw"], draw.found["draw@view1"]
    assert {t.size for t in first} == {SIZE} and {t.size for t in second} == {SMALL}
    assert [t.label for t in (*first, *second)] == ["color", "depth", "color@view1", "depth@view1"]
    plan.bind_import("target", "window")
    with pytest.raises(GraphError, match=r"'target@view1' .* pass 'show@view1'"):
        plan.execute()
    plan.bind_import("target@view1", "mirror")
    plan.execute()
    assert plan.resource("target@view0") == "window" and plan.resource("target@view1") == "mirror"


def test_view_0_is_called_the_same_with_and_without_others() -> None:
    alone = GraphBuilder()
    frame_of(alone.scope(view=0, planet=0))
    alone.export("target")
    flat = GraphBuilder()
    frame_of(flat)
    flat.export("target")
    assert alone.analyse().to_mermaid() == flat.analyse().to_mermaid()
    assert compiled(two_views()).analysis.alive[:3] == alone.analyse().alive


def test_a_second_view_leaves_the_first_ones_content_alone() -> None:
    def declared(views: int) -> GraphBuilder:
        builder = GraphBuilder()
        for view in range(views):
            specs = (tex("x", lifetime="persistent"), tex("h", lifetime="history"))
            builder.scope(view=view).add_pass("make", bind=idle, creates=specs, history=("h",))
            builder.scope(view=view).export("x")
        return builder

    plan = compiled(declared(1))
    plan.execute()
    before = plan.resource("x")
    plan = compiled(declared(2), plan)
    assert plan.resource("x") is before and plan.resource("x@view1") is not before
    assert [plan._state.valid[n].value for n in ("h", "h@view1")] == [True, False]
    plan.execute()
    plan.invalidate_history(view=1)
    assert [plan._state.valid[n].value for n in ("h", "h@view1")] == [True, False]
    plan = compiled(declared(1), plan)
    assert plan.resource("x") is before


def test_a_pass_may_name_another_views_resource() -> None:
    builder = two_views()
    inset = Kept("color@view1", "color")
    builder.scope(view=0).add_pass(
        "inset", bind=inset, reads=("color@view1",), writes=("color",), after=("draw",), help="a mirror"
    )
    found = compiled(builder)
    assert [t.label for t in inset.found["inset"]] == ["color@view1", "color"]
    order = found.analysis.alive
    assert order.index("draw@view1") < order.index("inset") < order.index("show")


def test_order_inside_a_view_is_its_own() -> None:
    builder = GraphBuilder()
    views = [builder.scope(view=view) for view in (0, 1)]
    for of_view in views:  # backwards: only after= and what flows can put it right
        of_view.add_pass("c", bind=idle, writes=("x",), after=("b",))
        of_view.add_pass("b", bind=idle, writes=("x",), after=("a",), reads_optional=("y",), after_optional=("d",))
        of_view.add_pass("a", bind=idle, creates=(tex("x"),))
        of_view.export("x")
    views[1].add_pass("d", bind=idle, creates=(tex("y"),))
    assert builder.analyse().alive == ["a", "b", "c", "a@view1", "d@view1", "b@view1", "c@view1"]


# --- sizes ------------------------------------------------------------------------------------------------------------


def test_a_view_is_resized_alone() -> None:
    plan = compiled(two_views())
    before = {name: plan.resource(name) for name in plan.resources}
    plan.resize((30, 10), view=1)
    for name, old in before.items():
        now = plan.resource(name)
        assert (now is old) == (not name.endswith("@view1"))
    assert plan.size == SIZE and plan.view_size(0) == SIZE and plan.view_size(1) == (30, 10)
    assert plan.texels("color@view1") == (30, 10) and plan.texels("color@view0") == SIZE
    plan.resize((40, 40))
    assert plan.view_size(0) == (40, 40) and plan.view_size(1) == (30, 10)
    with pytest.raises(GraphError, match=r"resize\(view=0\): that view has no size of its own"):
        plan.resize(SIZE, view=0)
    plan.release()
    assert not plan.backend.live


def test_views_of_one_size_share_memory_and_others_do_not() -> None:
    # Colour's life in view 0 ends with show, before view 1's begins.
    assert compiled(two_views(size=None)).analysis.lifetimes.shared == [
        ["depth", "depth@view1"],
        ["color", "color@view1"],
    ]
    assert [len(names) for names in compiled(two_views()).analysis.lifetimes.shared] == [1, 1, 1, 1]


def test_a_size_that_cannot_be() -> None:
    builder = GraphBuilder()
    builder.scope(view=1, size=SMALL)
    builder.scope(view=1, size=SMALL)
    for wrong, part in (
        (lambda: builder.scope(view=1, size=SIZE), r"has \(20, 10\) already"),
        (lambda: builder.scope(size=SIZE), "without a view"),
        (lambda: builder.scope(view=2, size=(0, 4)), r"scope\(view=2\): size=\(0, 4\)"),
        (lambda: builder.scope(view=-1), r"view=-1.*index"),
        (lambda: builder.scope(planet=True), "planet=True"),
        (lambda: builder.scope(home="earth"), "home='earth'"),  # type: ignore[arg-type]
    ):
        with pytest.raises(GraphError, match=part):
            wrong()


# --- shared -----------------------------------------------------------------------------------------------------------


def test_what_views_share_is_made_once() -> None:
    table, draw, trail = Kept("table"), Kept("table"), Trail()
    builder = GraphBuilder()
    for view in (0, 1):
        of_view = builder.scope(view=view, planet=0)  # as a system gets it
        of_view.scope(view=None).add_pass(
            "make", bind=trail.bind, creates=(tex("table", size=(8, 8), lifetime="persistent"),), system="air"
        )
        of_view.add_pass("draw", bind=draw, reads=("table",), creates=(tex("color"),), after=("make",))
        of_view.export("color")
    plan = compiled(builder)
    assert plan.analysis.alive == ["make", "draw", "draw@view1"]
    assert draw.found["draw"] == draw.found["draw@view1"] and draw.found["draw"][0].label == "table"
    assert trail.frame(plan) == ["make"] and not table.found


def test_what_is_shared_must_be_declared_alike_and_once_a_view() -> None:
    builder = GraphBuilder()

    def share(view: int, side: int) -> None:
        shared = builder.scope(view=view).scope(view=None)
        shared.add_pass("make", bind=idle, creates=(tex("table", size=(side, side)),))

    share(0, 8)
    with pytest.raises(GraphError, match=r"'make' is shared, but creates=.*\(9, 9\).*before.*\(8, 8\)"):
        share(1, 9)
    share(1, 8)
    with pytest.raises(GraphError, match="two passes are called 'make'"):
        share(1, 8)


def test_a_name_has_one_kind_of_owner() -> None:
    builder = GraphBuilder()
    builder.add_pass("make", bind=idle, creates=(tex("x"),))
    for view in (0, 1):
        with pytest.raises(GraphError, match="resource 'x' is declared by view here and shared by all views"):
            builder.scope(view=view).add_pass("other", bind=idle, creates=(tex("x"),))
        with pytest.raises(GraphError, match="pass 'make' is declared by view and by planet here and shared"):
            builder.scope(view=view, planet=0).add_pass("make", bind=idle)
    builder.export("x")
    assert builder.analyse().alive == ["make"]


def test_an_import_belongs_to_what_all_who_ask_have_in_common() -> None:
    builder = GraphBuilder()
    for view in (0, 1):
        of_view = builder.scope(view=view)
        of_view.scope(planet=0).import_("target", "framebuffer")
        of_view.import_("target", "framebuffer")
        of_view.import_("photo", "texture")
        of_view.add_pass("show", bind=idle, reads=("photo",), writes=("target",))
        of_view.export("target")
    assert list(compiled(builder).analysis.model.imports) == ["target", "target@view1", "photo", "photo@view1"]
    builder.import_("photo", "texture")
    plan = compiled(builder)
    assert list(plan.analysis.model.imports) == ["target", "target@view1", "photo"]
    assert plan.analysis.model.reads == [("photo",), ("photo",)]


def test_a_shared_pass_has_to_say_whose() -> None:
    builder = two_views()
    builder.add_pass(
        "compare", bind=Kept("color", "color@view1"), reads=("color@view0", "color@view1"), side_effect=True
    )
    raises(builder, "pass 'compare': 'color' alone is not enough", "say 'color@view0', 'color@view1'")
    builder = two_views()
    kept = Kept("color@view0", "color@view1")
    builder.add_pass("compare", bind=kept, reads=("color@view0", "color@view1"), after=("show",), side_effect=True)
    plan = compiled(builder)
    assert plan.analysis.alive[-1] == "compare"  # behind the show of every view
    assert [t.label for t in kept.found["compare"]] == ["color", "color@view1"]


# --- planets ----------------------------------------------------------------------------------------------------------


def sky_of_two(home: int = 0) -> tuple[GraphBuilder, Kept, Kept]:
    """Two planets in view 0, and in view 1 too: their ground into one depth buffer, their air into one picture."""
    ground, picture = Kept("b.vertices", "depth"), Kept("b.air", "radiance")
    builder = GraphBuilder()
    for view in (0, 1):
        of_view = builder.scope(view=view, home=home)
        of_view.add_pass("sky", bind=picture, creates=(tex("radiance"),), reads=("b.air", "depth"))
        of_view.add_pass("clear", bind=idle, creates=(tex("depth", format="depth32f"),))
        of_view.add_pass("stars", bind=idle, writes=("radiance",), after=("sky",), after_optional=("shade",))
        for planet in (0, 1):
            of_planet = of_view.scope(planet=planet)
            of_planet.add_pass("draw", bind=ground, reads=("b.vertices",), writes=("depth",), after=("clear",))
            of_planet.add_pass(
                "make", bind=idle, creates=(BufferSpec("b.vertices", 64, "persistent"),), system="terrain"
            )
            of_planet.scope(view=None).add_pass("air", bind=idle, creates=(BufferSpec("b.air", 16, "persistent"),))
            of_planet.add_pass("shade", bind=idle, reads=("depth",), writes=("radiance",), after=("sky",))
        of_view.export("radiance")
    return builder, ground, picture


def test_planets_of_a_view_take_turns_at_what_they_share() -> None:
    builder, ground, picture = sky_of_two()
    plan = compiled(builder)
    order = plan.analysis.alive
    names = ["draw", "draw@planet1", "draw@view1", "draw@view1.planet1"]
    for name in names:
        assert ground.found[name][0].label == name.replace("draw", "b.vertices")
    # Two grounds of one view meet in one depth buffer, in the order of the planets, before anybody reads it.
    for view in ("", "@view1"):
        first, second = f"draw{view}", f"draw{view}.planet1" if view else "draw@planet1"
        readers = [n for n in order if n == f"sky{view}" or (n.startswith("shade") and ("view1" in n) == bool(view))]
        assert len(readers) == 3
        assert order.index(f"clear{view}") < order.index(first) < order.index(second) < min(map(order.index, readers))
        assert order.index(f"stars{view}") > max(map(order.index, readers))  # after_optional= of all planets
    assert ground.found["draw"][1] is ground.found["draw@planet1"][1]
    assert picture.found["sky"][0].label == picture.found["sky@view1"][0].label == "b.air"
    assert order.count("air") == 1 and "air@planet1" in plan.culled  # nobody's home
    assert "writes 'depth' in its turn after 'draw', of another view or planet" in plan.explain("draw@planet1")


def test_a_name_of_a_planet_means_the_home_planet() -> None:
    builder, _, picture = sky_of_two(home=1)
    plan = compiled(builder)
    assert picture.found["sky"][0].label == picture.found["sky@view1"][0].label == "b.air@planet1"
    assert "air" in plan.culled


def test_turns_do_not_hide_two_writers_of_one_planet() -> None:
    builder, _, _ = sky_of_two()
    for view, planet in ((0, 0), (0, 1), (1, 0), (1, 1)):
        of_planet = builder.scope(view=view, planet=planet)
        of_planet.add_pass("props", bind=idle, writes=("depth",), after=("clear",))
    raises(builder, "passes 'draw' and 'props' both write 'depth' and nothing says which comes first")


# --- errors and what people see ---------------------------------------------------------------------------------------


def test_near_names_are_qualified() -> None:
    builder = two_views()
    builder.scope(view=1).add_pass("more", bind=idle, reads=("colr",), side_effect=True)
    raises(builder, "pass 'more@view1' reads 'colr@view1', but no pass creates it", "'color@view1'")
    builder = two_views()
    builder.scope(view=1).add_pass("more", bind=idle, reads=("color",), after=("drw",), side_effect=True)
    raises(builder, "pass 'more@view1' is declared after 'drw@view1'", "'draw@view1'")


def test_another_views_resource_is_never_taken_instead() -> None:
    builder = two_views()
    builder.scope(view=0).add_pass("debug", bind=idle, creates=(tex("wireframe"),))
    builder.scope(view=1).add_pass("more", bind=idle, reads=("wireframe",), side_effect=True)
    raises(builder, "pass 'more@view1' reads 'wireframe@view1', but no pass creates it", "Did you mean 'wireframe'")

    found = []

    def bind(io: PassIO) -> Any:
        found.append(io.has("wireframe"))
        return lambda: None

    for view in (0, 1):
        builder = two_views()
        builder.scope(view=0).add_pass("debug", bind=idle, creates=(tex("wireframe"),))
        builder.scope(view=view).add_pass("more", bind=bind, reads_optional=("wireframe",), side_effect=True)
        compiled(builder)
    assert found == [True, False]


def test_lookups_of_a_pass_are_named_with_their_view() -> None:
    for name, part in (
        ("wire", "texture('wire@view1') is unknown"),
        ("target", "texture('target@view1') is an import"),
        ("depth", "pass 'more@view1' looks up 'depth@view1' without declaring it"),
        ("color@view0", "looks up 'color' without declaring it"),
    ):
        builder = two_views()
        builder.scope(view=1).add_pass("more", bind=Kept(name), reads=("color",), side_effect=True)
        raises(builder, part)


def test_an_index_is_not_part_of_a_declared_name() -> None:
    builder = GraphBuilder()
    for wrong in (
        lambda: builder.add_pass("a@view1", bind=idle),
        lambda: builder.add_pass("a", bind=idle, creates=(tex("x@view1"),)),
        lambda: builder.import_("x@view1", "texture"),
    ):
        with pytest.raises(GraphError, match="bare name"):
            wrong()


def test_asking_for_passes_and_resources() -> None:
    plan = compiled(two_views())
    assert plan.explain("draw@view0") == plan.explain("draw")
    text = plan.explain("draw@view1")
    assert text.startswith("pass 'draw@view1' (system terrain, raster)") and "  of view 1\n" in text
    assert "writes 'color@view1': transient texture rgba8, 20 x 10, 800 bytes" in text
    with pytest.raises(GraphError, match=r"there is no pass 'drw@view1'\. Did you mean 'draw@view1'"):
        plan.explain("drw@view1")
    with pytest.raises(GraphError, match=r"there is no resource 'color@view2'\. Did you mean .*'color@view1'"):
        plan.resource("color@view2")
    with pytest.raises(GraphError, match=r"no such import\. Did you mean .*'target@view1'"):
        plan.bind_import("target@view2", 1)
    reports = [(r.name, r.view, r.planet) for r in plan.passes]
    assert reports[2:4] == [("show", 0, None), ("clear@view1", 1, None)]
    assert plan.bytes_of("color@view1") == plan.bytes_of("color@planet0.view1") == 20 * 10 * 4


def test_exports_inside_and_outside_of_a_view() -> None:
    builder = two_views()
    builder.scope(view=1).export("color")
    builder.export("depth")
    builder.export("depth@view1")
    exports = builder.analyse().model.exports
    assert exports == ("target", "target@view1", "color@view1", "depth", "depth@view1")
    builder.export("depth@view3")
    raises(builder, "export of 'depth@view3'", "'depth@view1'")


def test_mermaid_tells_views_apart() -> None:
    text = compiled(two_views()).to_mermaid()
    for part in ('["gbuffer"]', '["gbuffer@view1"]', '["draw@view1"]', '(["target@view1"])', '-->|"color@view1<br/>'):
        assert part in text
    assert text.count("subgraph") == 4
