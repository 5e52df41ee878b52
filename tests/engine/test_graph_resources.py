"""What passes can look up, what shares memory, and where storage barriers go."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from graph_kit import SIZE, compiled, idle, tex

from planetfall.engine.graph import (
    BarrierKind,
    BufferSpec,
    GraphBackend,
    GraphBuilder,
    GraphError,
    NullBackend,
    PassIO,
    TextureSpec,
)


def io_of(**arguments: Any) -> PassIO:
    """The PassIO of a pass "p" beside a pass "other" that creates "x" (texture), "b" (buffer), "small"."""
    found: list[PassIO] = []
    builder = GraphBuilder()
    builder.import_("target", "framebuffer")
    specs = (tex("x"), tex("z"), BufferSpec("b", 64), tex("small", size=0.5), tex("h", lifetime="history"))
    builder.add_pass("other", bind=idle, creates=specs)

    def bind(io: PassIO) -> Callable[[], None]:
        found.append(io)
        return lambda: None

    builder.add_pass("p", bind=bind, side_effect=True, **arguments)
    builder.compile(NullBackend(), SIZE)
    return found[0]


@pytest.mark.parametrize(
    ("look", "parts"),
    [
        (lambda io: io.texture("z"), ["pass 'p' looks up 'z' without declaring it", "reads="]),
        (lambda io: io.texture("xx"), ["pass 'p': texture('xx') is unknown", "Did you mean 'x'?"]),
        (lambda io: io.texture("b"), ["'b' is a buffer; use io.buffer('b')"]),
        (lambda io: io.buffer("x"), ["'x' is a texture; use io.texture('x')"]),
        (lambda io: io.texture("target"), ["is an import", "io.imported('target').value"]),
        (lambda io: io.imported("x"), ["is no import", "io.texture()"]),
        (lambda io: io.imported("targte"), ["unknown", "Did you mean 'target'?"]),
        (lambda io: io.imported("target"), ["without declaring it"]),
        (lambda io: io.texture("h"), ["has 'h' only in history=", "io.history('h')"]),
        (lambda io: io.history("x"), ["history of 'x' without declaring it"]),
        (lambda io: io.framebuffer(("x",)), ["attaches 'x' as a colour but only reads it", "writes="]),
        (lambda io: io.framebuffer("x"), ["is a string", "('x',)"]),
        (lambda io: io.framebuffer(), ["without attachments"]),
        (lambda io: io.framebuffer(("own", "own_small")), ["different sizes", "(64, 32)", "(32, 16)"]),
        (lambda io: io.resource_size("target"), ["is an import"]),
    ],
)
def test_lookups_outside_the_declaration(look: Callable[[PassIO], object], parts: list[str]) -> None:
    io = io_of(reads=("x", "b"), history=("h",), creates=(tex("own"), tex("own_small", size=0.5)))
    with pytest.raises(GraphError) as caught:
        look(io)
    for part in parts:
        assert part in str(caught.value)


def test_lookups() -> None:
    io = io_of(
        reads=("small", "b"), writes=("x", "target"), after=("other",), history=("h",), reads_optional=("z", "absent")
    )
    assert io.pass_name == "p"
    assert io.size == SIZE
    assert io.texture("x").size == SIZE
    assert io.texture("small").size == (32, 16)
    assert io.resource_size("small") == (32, 16)
    assert io.buffer("b").size_bytes == 64
    assert io.resource_size("b") == (64,)
    assert io.history("h").size == SIZE
    assert (io.has("z"), io.has("absent"), io.has("target")) == (True, False, True)
    assert io.imported("target").name == "target"
    framebuffer = io.framebuffer(("x",))
    assert framebuffer.colors == (io.texture("x"),)
    assert io.framebuffer(("x",)) is framebuffer
    assert io.framebuffer((), depth="x").depth is io.texture("x")
    with pytest.raises(GraphError, match="nothing in history="):
        _ = io_of(reads=("x",)).history_valid


def test_depth_may_be_attached_by_a_reader() -> None:
    io = io_of(reads=("x",), creates=(tex("own"),))
    assert io.framebuffer(("own",), depth="x").depth is io.texture("x")


# --- memory ----------------------------------------------------------------------------------------------------------


def test_sizes_and_bytes() -> None:
    assert TextureSpec("t", "rgba16f", size=0.5).resolve((5, 3)) == (3, 2)
    assert TextureSpec("t", "rgba16f", size=1 / 3).resolve((9, 1)) == (3, 1)
    assert TextureSpec("t", "r8", size=0.001).resolve((5, 3)) == (1, 1)
    mips = TextureSpec("t", "r32f", size=(4, 2), levels=9)
    assert mips.levels_for((4, 2)) == 3
    assert mips.bytes_for((4, 2)) == 4 * (8 + 2 + 1)
    assert TextureSpec("t", "rg8", size=(4, 4, 4)).bytes_for((4, 4, 4)) == 128
    assert TextureSpec("t", "rg8", size=(4, 4), layers=3).bytes_for((4, 4)) == 96


def chain(*specs: TextureSpec | BufferSpec) -> GraphBuilder:
    """Pass i creates specs[i] and reads specs[i - 1]."""
    builder = GraphBuilder()
    for i, spec in enumerate(specs):
        builder.add_pass(f"p{i}", bind=idle, creates=(spec,), reads=(specs[i - 1].name,) if i else ())
    return builder


def test_transients_share_memory_when_their_lives_do_not_meet() -> None:
    plan = compiled(chain(tex("a"), tex("b"), tex("c"), tex("d")), "d")
    a, b, c, d = (plan.resource(n) for n in "abcd")
    assert a is c
    assert b is d
    assert a is not b  # p1 reads a while it writes b
    assert plan.memory_bytes() == 2 * 64 * 32 * 4
    assert [r.bytes for r in plan.passes] == [64 * 32 * 4] * 4


def test_what_differs_is_not_shared() -> None:
    specs = (tex("a"), tex("b"), tex("c", size=(64, 32)), tex("d", filter="linear"), BufferSpec("e", 8192))
    plan = compiled(chain(*specs, BufferSpec("f", 8192), BufferSpec("g", 8192)), "g")
    assert len({id(plan.resource(n)) for n in "abcdef"}) == 6
    assert plan.resource("e") is plan.resource("g")


def test_exports_outlive_the_frame() -> None:
    plan = compiled(chain(tex("a"), tex("b"), tex("c"), tex("d")), "d", "a")
    assert plan.resource("a") is not plan.resource("c")


def test_persistent_and_history_are_never_shared() -> None:
    plan = compiled(chain(tex("a", lifetime="persistent"), tex("b", lifetime="history"), tex("c"), tex("d")), "d")
    assert len({id(plan.resource(n)) for n in "abcd"}) == 4
    assert plan.memory_bytes() == 5 * 64 * 32 * 4
    assert plan.passes[1].bytes == 2 * 64 * 32 * 4


def test_culled_resources_are_not_there() -> None:
    plan = compiled(chain(tex("a"), tex("b")), "a")
    assert plan.resources == ("a",)
    assert plan.culled == {"p1": "nobody reads 'b'"}
    assert plan.passes[1].skipped_why == "culled: nobody reads 'b'"
    with pytest.raises(GraphError, match="'b' is not allocated: pass 'p1', which creates it, is culled"):
        plan.resource("b")
    with pytest.raises(GraphError, match=r"there is no resource 'aa'\. Did you mean 'a'"):
        plan.resource("aa")


def test_null_backend_is_a_backend() -> None:
    assert isinstance(NullBackend(), GraphBackend)


# --- barriers --------------------------------------------------------------------------------------------------------

T, B = int(BarrierKind.TEXTURE), int(BarrierKind.BUFFER)


def barriers(builder: GraphBuilder, *exports: str) -> dict[str, int]:
    """{pass: kinds} of what stands before passes, and under "end" behind the last."""
    for name in exports:
        builder.export(name)
    found = builder.analyse()
    placed = dict(zip(found.alive, found.barriers.before, strict=True))
    return {name: kinds for name, kinds in (placed | {"end": found.barriers.at_end}).items() if kinds}


def test_raster_needs_no_barriers() -> None:
    builder = chain(tex("a"), tex("b"), tex("c"), tex("d"))
    assert barriers(builder, "d") == {}


def test_barrier_between_a_compute_writer_and_its_reader() -> None:
    builder = GraphBuilder()
    builder.add_pass("cull", bind=idle, kind="compute", creates=(BufferSpec("visible", 64),))
    builder.add_pass("sky", bind=idle, creates=(tex("sky"),))
    builder.add_pass("draw", bind=idle, reads=("visible", "sky"), creates=(tex("x"),))
    # draw of the last frame reads what cull is about to overwrite.
    assert barriers(builder, "x") == {"cull": B, "draw": B}


def test_one_barrier_serves_all_readers_behind_it() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, kind="compute", creates=(tex("x"), BufferSpec("b", 4)))
    builder.add_pass("first", bind=idle, reads=("x", "b"), creates=(tex("y"),))
    builder.add_pass("second", bind=idle, reads=("x", "y"), creates=(tex("z"),))
    assert barriers(builder, "z") == {"a": T | B, "first": T | B}


def test_compute_writer_behind_another_pass() -> None:
    builder = GraphBuilder()
    builder.add_pass("clear", bind=idle, creates=(tex("x", lifetime="persistent"),))
    builder.add_pass("shade", bind=idle, kind="compute", writes=("x",), after=("clear",))
    builder.add_pass("more", bind=idle, kind="compute", writes=("x",), after=("shade",))
    # At the end for who looks at the export; before shade and more, since stores must not overtake.
    assert barriers(builder, "x") == {"shade": T, "more": T, "end": T}


def test_history_written_by_compute_is_awaited_in_the_next_frame() -> None:
    builder = GraphBuilder()
    builder.add_pass("use", bind=idle, history=("h",), creates=(tex("x"),))
    builder.add_pass("make", bind=idle, kind="compute", reads=("x",), creates=(tex("h", lifetime="history"),))
    # make itself needs none: what it overwrites was read before the barrier in front of use.
    assert barriers(builder, "x") == {"use": T}


def test_a_barrier_that_may_be_skipped_serves_only_its_own_pass() -> None:
    builder = GraphBuilder()
    builder.add_pass("a", bind=idle, kind="compute", creates=(BufferSpec("b", 4),))
    builder.add_pass("maybe", bind=idle, reads=("b",), when=bool, side_effect=True)
    builder.add_pass("always", bind=idle, reads=("b",), side_effect=True)
    assert barriers(builder) == {"a": B, "maybe": B, "always": B}


def test_execute_calls_the_barriers() -> None:
    builder = GraphBuilder()
    events: list[str] = []
    backend = NullBackend()
    backend.barrier = lambda kinds: events.append(f"barrier {kinds}")  # type: ignore[method-assign]

    def bind(io: PassIO) -> Callable[[], None]:
        name = io.pass_name
        return lambda: events.append(name)

    builder.add_pass("a", bind=bind, kind="compute", creates=(BufferSpec("b", 4),))
    builder.add_pass("c", bind=bind, reads=("b",), creates=(tex("x"),))
    builder.export("x")
    builder.compile(backend, SIZE).execute()
    assert events == [f"barrier {B}", "a", f"barrier {B}", "c"]
