"""explain() and to_mermaid()."""

from __future__ import annotations

import re

import pytest
from graph_kit import compiled, idle, tex

from planetfall.engine.graph import BufferSpec, GraphBuilder, GraphError


def builder() -> GraphBuilder:
    made = GraphBuilder()
    made.import_("target", "framebuffer")
    made.import_("photo", "texture")
    specs = (BufferSpec("visible", 64),)
    made.add_pass("terrain.cull", bind=idle, kind="compute", creates=specs, system="terrain", help="cells in view")
    made.add_pass(
        "terrain.draw", bind=idle, reads=("visible", "photo"), creates=(tex("color"), tex("depth")), system="terrain"
    )
    made.add_pass("debug", bind=idle, reads=("depth",), creates=(tex("wire"),), system="debug")
    made.add_pass(
        "expose",
        bind=idle,
        reads=("color",),
        history=("exposure",),
        creates=(tex("exposure", lifetime="history", size=(1, 1)),),
    )
    made.add_pass("show", bind=idle, reads=("color", "exposure"), writes=("target",), when=lambda: True)
    made.export("target")
    return made


def test_explain_a_pass() -> None:
    plan = compiled(builder())
    plan.bind_import("target", 1)
    plan.bind_import("photo", 1)
    text = plan.explain("terrain.draw")
    assert text.startswith("pass 'terrain.draw' (system terrain, raster)")
    assert "runs as 2 of 4, because pass 'show' reads 'color'" in text
    assert "behind a storage barrier: 'visible' was stored by 'terrain.cull'" in text
    assert "creates 'color': transient texture rgba8, 64 x 32, 8192 bytes" in text
    assert "reads 'visible': transient buffer, 64 bytes" in text
    assert "reads 'photo': imported texture" in text
    assert "'terrain.draw' reads 'visible', which 'terrain.cull' creates" in text
    assert "skipped, no frame has been executed yet" in text
    plan.execute()
    assert re.search(r"last frame: \d+\.\d+ ms CPU", plan.explain("terrain.draw"))
    assert "cells in view" in plan.explain("terrain.cull")
    assert "last frame's 'exposure': history texture" in plan.explain("expose")
    assert "only in frames in which its when() says yes" in plan.explain("show")


def test_barriers_are_listed_with_the_hazards_that_they_close() -> None:
    text = builder().analyse().to_barriers()
    assert "before 'terrain.draw': a barrier for buffers\n    'visible' was stored by 'terrain.cull'" in text
    assert "before this pass stores over it" in text
    alone = GraphBuilder()
    alone.add_pass("a", bind=idle, creates=(tex("x"),))
    alone.export("x")
    assert alone.analyse().to_barriers() == "no pass stores from a compute shader: no barrier"


def test_explain_a_culled_pass() -> None:
    text = builder().analyse().explain("debug")
    assert "culled: nobody reads 'wire'" in text
    assert "creates 'wire': transient texture rgba8, 1.0 of the view, not allocated" in text


def test_explain_an_unknown_pass() -> None:
    with pytest.raises(GraphError, match=r"there is no pass 'shw'\. Did you mean 'show'"):
        builder().analyse().explain("shw")


def test_mermaid() -> None:
    assert compiled(builder()).to_mermaid() == (
        """flowchart LR
    subgraph s0["terrain"]
        p0["terrain.cull<br/>(compute)"]
        p1["terrain.draw"]
    end
    subgraph s1["debug"]
        p2["debug"]
    end
        p3["expose"]
        p4["show"]
    e0(["target"])
    e1(["photo"])
    p0 -->|"visible"| p1
    e1 -->|"photo"| p1
    p1 -.->|"depth"| p2
    p1 -->|"color"| p3
    p3 -.->|"last frame: exposure"| p3
    p1 -->|"color"| p4
    p3 -->|"exposure"| p4
    p4 -->|"target"| e0
    classDef culled stroke-dasharray: 5 5, color:#888
    class p2 culled
"""
    )


def test_mermaid_quotes_names() -> None:
    made = GraphBuilder()
    made.add_pass('a "<b>"', bind=idle, creates=(tex("x"),))
    made.export("x")
    assert 'p0["a &quot;&lt;b&gt;&quot;"]' in made.analyse().to_mermaid()
