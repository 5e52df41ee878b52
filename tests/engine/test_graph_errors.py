"""Every mistake in a frame graph is named with the pass, the resource and the remedy."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from graph_kit import SIZE, idle, tex

from planetfall.engine.graph import BufferSpec, GraphBuilder, GraphError, ImportSpec, NullBackend, TextureSpec


def fails(builder: GraphBuilder, *parts: str) -> None:
    """Compiling raises a GraphError that contains all parts, and creates nothing."""
    backend = NullBackend()
    with pytest.raises(GraphError) as caught:
        builder.compile(backend, SIZE)
    for part in parts:
        assert part in str(caught.value)
    assert not backend.live


def declared(*passes: dict[str, Any], exports: tuple[str, ...] = ("x",)) -> GraphBuilder:
    builder = GraphBuilder()
    for arguments in passes:
        builder.add_pass(**({"bind": idle} | arguments))
    for name in exports:
        builder.export(name)
    return builder


def test_unknown_read_suggests_near_names() -> None:
    fails(
        declared({"name": "a", "creates": (tex("gbuffer.depth"),)}, {"name": "b", "reads": ("gbufer.depth",)}),
        "pass 'b' reads 'gbufer.depth'",
        "no pass creates it",
        "Did you mean 'gbuffer.depth'?",
    )


def test_reading_a_pass_is_told_apart() -> None:
    builder = declared({"name": "a", "creates": (tex("x"),)}, {"name": "b", "reads": ("a",)})
    fails(builder, "'a', which is a pass", "after=")


def test_unknown_write() -> None:
    fails(declared({"name": "a", "writes": ("x",), "after": ()}), "pass 'a' writes 'x'", "no pass creates it")


def test_unknown_after() -> None:
    fails(
        declared({"name": "clear", "creates": (tex("x"),)}, {"name": "b", "reads": ("x",), "after": ("cleer",)}),
        "pass 'b' is declared after 'cleer'",
        "Did you mean 'clear'?",
        "after_optional=",
    )
    fails(declared({"name": "a", "creates": (tex("x"),), "after": ("x",)}), "'x'", "That is a resource")


def test_unknown_export() -> None:
    builder = declared({"name": "a", "creates": (tex("depth"),)}, exports=("dept",))
    fails(builder, "export of 'dept'", "Did you mean 'depth'?")


def test_nothing_exported() -> None:
    fails(declared({"name": "a", "creates": (tex("x"),)}, exports=()), "nothing is exported", "builder.export(name)")


def test_two_unordered_writers() -> None:
    fails(
        declared(
            {"name": "a", "creates": (tex("x"),)},
            {"name": "b", "writes": ("x",), "after": ("a",)},
            {"name": "c", "writes": ("x",), "after": ("a",)},
        ),
        "passes 'b' and 'c' both write 'x'",
        "declare 'c' with after=('b',)",
    )


def test_two_unordered_writers_of_an_import() -> None:
    builder = declared({"name": "a", "writes": ("target",)}, {"name": "b", "writes": ("target",)}, exports=("target",))
    builder.import_("target", "framebuffer")
    fails(builder, "passes 'a' and 'b' both write 'target'")


def test_write_without_after() -> None:
    fails(
        declared({"name": "a", "creates": (tex("x"),)}, {"name": "b", "writes": ("x",)}),
        "pass 'b' writes 'x', which pass 'a' creates, without saying when",
        "after=('a',)",
    )


def test_read_before_any_write() -> None:
    fails(
        declared({"name": "a", "reads": ("x",)}, {"name": "b", "creates": (tex("x"),), "after": ("a",)}),
        "pass 'a' reads 'x' before any pass has written it",
        "pass 'b' creates it",
        "lifetime='history'",
    )


def test_cycle_names_every_step() -> None:
    fails(
        declared(
            {"name": "a", "creates": (tex("x"),), "reads": ("y",)},
            {"name": "b", "creates": (tex("y"),), "reads": ("x",)},
        ),
        "in a circle",
        "'b' reads 'x', which 'a' creates",
        "'a' reads 'y', which 'b' creates",
        "history=",
    )


def test_cycle_through_a_later_writer_says_how_to_read_the_earlier_version() -> None:
    # c reads x, so it runs after the writer b; but b reads z, which d changes after c.
    fails(
        declared(
            {"name": "a", "creates": (tex("x"), tex("z"))},
            {"name": "b", "writes": ("x",), "reads": ("z",), "after": ("a",)},
            {"name": "c", "reads": ("x",), "creates": (tex("y"),)},
            {"name": "d", "writes": ("z",), "reads": ("y",), "after": ("a",)},
        ),
        "in a circle",
        "If 'c' is to see 'x' before 'b' changes it, declare 'b' with after=('c',)",
    )


def test_history_of_other_lifetimes() -> None:
    fails(
        declared({"name": "a", "creates": (tex("x"),), "history": ("x",)}),
        "pass 'a' reads the history of 'x', whose lifetime is 'transient'",
        "lifetime='history'",
    )
    fails(declared({"name": "a", "creates": (tex("x"),), "history": ("xx",)}), "history of 'xx'", "Did you mean 'x'?")
    builder = declared({"name": "a", "creates": (tex("x"),), "history": ("target",)})
    builder.import_("target", "texture")
    fails(builder, "history of 'target', which is an import")


def raises(call: Callable[[], object], *parts: str) -> None:
    with pytest.raises(GraphError) as caught:
        call()
    for part in parts:
        assert part in str(caught.value)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        ({"name": ""}, ["non-empty string"]),
        ({"bind": None}, ["pass 'p'", "bind=None is not callable"]),
        ({"when": True}, ["pass 'p'", "when=True is not callable"]),
        ({"kind": "computer"}, ["pass 'p'", "kind='computer'", "Did you mean 'compute'?"]),
        ({"reads": "x"}, ["reads='x' is a string", "reads=('x',)"]),
        ({"after": "x"}, ["after='x' is a string"]),
        ({"reads": (1,)}, ["reads= holds 1"]),
        ({"creates": TextureSpec("x", "r8")}, ["creates=(spec,)"]),
        ({"creates": ("x",)}, ["creates= holds 'x'", "TextureSpec"]),
        ({"creates": (tex("x"), tex("x"))}, ["creates 'x' twice"]),
        ({"creates": (tex("x"),), "writes": ("x",)}, ["both creates and writes 'x'", "drop it from writes="]),
        ({"creates": (tex("x"),), "reads": ("x",)}, ["both creates and reads 'x'", "history="]),
        ({"after": ("p",)}, ["pass 'p' is declared after itself"]),
        (
            {"creates": (tex("x"),), "when": bool},
            ["pass 'p' has a when=", "'x'", "lifetime='transient'", "lifetime='persistent'"],
        ),
        ({"creates": (tex("x", lifetime="history"),), "when": bool}, ["lifetime='history'"]),
    ],
)
def test_a_pass_alone(arguments: dict[str, Any], parts: list[str]) -> None:
    raises(lambda: GraphBuilder().add_pass(**({"name": "p", "bind": idle} | arguments)), *parts)


def test_names_are_unique() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, creates=(tex("x"),), system="one")
    raises(lambda: builder.add_pass("a", bind=idle, system="two"), "two passes are called 'a'", "'one' and 'two'")
    raises(
        lambda: builder.add_pass("b", bind=idle, creates=(tex("x"),)),
        "pass 'b' creates 'x', but pass 'a' creates it already",
        "writes= with after=('a',)",
    )
    raises(lambda: builder.import_("x", "texture"), "import 'x'", "pass 'a' creates")
    builder.import_("target", "framebuffer")
    builder.import_("target", "framebuffer")
    raises(lambda: builder.import_("target", "texture"), "'target'", "framebuffer", "texture")
    raises(lambda: builder.add_pass("b", bind=idle, creates=(tex("target"),)), "'target', which is an import")
    assert builder.compile  # a refused declaration leaves the builder usable
    builder.export("x")
    assert builder.analyse().alive == ["a"]


@pytest.mark.parametrize(
    ("make", "parts"),
    [
        (lambda: TextureSpec("x", "rgba16"), ["texture 'x'", "unknown format 'rgba16'", "'rgba16f'"]),
        (lambda: tex("x", size=0.0), ["texture 'x'", "size=0.0", "> 0"]),
        (lambda: tex("x", size=float("nan")), ["size=nan"]),
        (lambda: tex("x", size=(0, 4)), ["size=(0, 4)", ">= 1"]),
        (lambda: tex("x", size=(4,)), ["size=(4,)"]),
        (lambda: tex("x", size=(4, 4, 4), layers=2), ["3D texture has no layers"]),
        (lambda: tex("x", levels=0), ["levels=0"]),
        (lambda: tex("x", filter="cubic"), ["filter='cubic'", "'nearest', 'linear'"]),
        (lambda: tex("x", wrap="mirror"), ["wrap='mirror'"]),
        (lambda: tex("x", lifetime="presistent"), ["Did you mean 'persistent' or"]),
        (lambda: tex(" x"), ["non-empty string without outer blanks"]),
        (lambda: BufferSpec("b", 0), ["buffer 'b'", "size_bytes=0"]),
        (lambda: BufferSpec("b", True), ["size_bytes=True"]),
        (lambda: ImportSpec("t", "image"), ["import 't'", "kind='image'"]),  # pyright: ignore[reportArgumentType]
    ],
)
def test_specs(make: Callable[[], object], parts: list[str]) -> None:
    raises(make, *parts)


@pytest.mark.parametrize("size", [(0, 4), (4, -1), (4.5, 4), (4,), None, "ab"])
def test_view_size(size: Any) -> None:
    builder = declared({"name": "a", "creates": (tex("x"),)})
    raises(lambda: builder.compile(NullBackend(), size), f"size={size!r}", "pixels")
    plan = builder.compile(NullBackend(), SIZE)
    raises(lambda: plan.resize(size), f"size={size!r}")
    assert plan.size == SIZE


def test_beyond_the_gpus_limit() -> None:
    builder = declared({"name": "a", "creates": (tex("x", size=2.0),)})
    backend = NullBackend(max_texture_size=100)
    raises(lambda: builder.compile(backend, (64, 32)), "texture 'x' would be (128, 64)", "limit is 100")
    assert not backend.counts["create_texture"]
