"""All systems of a planet declared for two views in one frame graph: nothing collides, each view has its own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import planetfall as pf
from planetfall.components import Planet
from planetfall.engine.frame import ViewInfo
from planetfall.engine.graph import GraphBuilder, NullBackend, PassIO, Plan, qualified
from planetfall.render.outputs import read_texture

SIZE, SMALL = (96, 54), (40, 30)
EXPORTS = frozenset({"composite.ldr", "scene.radiance"})


class LookingBuilder(GraphBuilder):
    """Declares what systems declare, but each pass only looks up all that it has named, by the names it gave, so that
    a backend without a GPU will do. found: pass -> name as given -> object."""

    found: dict[str, dict[str, Any]]

    def add_pass(self, name: str, **arguments: Any) -> None:
        created = {spec.name: spec for spec in arguments.get("creates", ())}
        named = [n for part in ("reads", "writes", "history", "reads_optional") for n in arguments.get(part, ())]

        def bind(io: PassIO) -> Callable[[], None]:
            specs = self._declared.creators  # resources by qualified name; the rest is imported
            found = self.found[io.pass_name] = {}
            for n in dict.fromkeys((*created, *named)):
                if qualified(n, int("@view1" in io.pass_name), 0) not in specs:
                    if io.has(n):
                        found[n] = io.imported(n)
                    continue
                try:
                    found[n] = io.texture(n)
                except pf.GraphError:
                    found[n] = io.history(n) if n in arguments.get("history", ()) else io.buffer(n)
            return lambda: None

        super().add_pass(name, **{**arguments, "bind": bind})


@pytest.fixture(scope="module")
def renderer() -> Iterator[pf.Renderer]:
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, size=SIZE, quality="low") as made:
        made.render(pf.view("coast"))  # systems are set up, view 0 has cells
        yield made


def declared(renderer: pf.Renderer, builder: GraphBuilder, sizes: dict[int, tuple[int, int]]) -> GraphBuilder:
    """As Renderer does it, for several views; sizes: view -> (w, h)."""
    for index, size in sizes.items():
        view = ViewInfo(size, renderer.views[index], EXPORTS, renderer.scene.planet.entity)
        of_view = builder.scope(view=index, size=size)
        of_planet = of_view.scope(planet=0)
        for system in renderer.systems:
            if system in renderer.running:
                system.declare(of_planet if Planet in system.needs else of_view, view)
        for name in sorted(EXPORTS):
            of_view.export(name)
    return builder


def looked(renderer: pf.Renderer, sizes: dict[int, tuple[int, int]]) -> tuple[Plan, dict[str, dict[str, Any]]]:
    builder = LookingBuilder()
    builder.found = {}
    plan = declared(renderer, builder, sizes).compile(NullBackend(), SIZE)
    return plan, builder.found


def test_two_views_of_different_sizes_do_not_collide(renderer: pf.Renderer) -> None:
    alone, small = looked(renderer, {0: SIZE})[0], looked(renderer, {0: SMALL})[0]
    plan, found = looked(renderer, {0: SIZE, 1: SMALL})
    passes = alone.analysis.alive
    assert {"terrain.shade", "ocean.gbuffer", "composite.tonemap", "gbuffer.clear", "sky.shade"} <= set(passes)
    order = plan.analysis.alive
    assert [n for n in order if "@" not in n] == passes
    assert [n for n in order if "@" in n] == [f"{n}@view1" for n in passes]
    # A small view has fewer octaves of glare: each has what it would have alone.
    assert sorted(plan.resources) == sorted((*alone.resources, *(f"{n}@view1" for n in small.resources)))
    for mine, theirs, suffix in ((alone, SIZE, ""), (small, SMALL, "@view1")):
        assert [plan.texels(n + suffix) for n in mine.resources] == [mine.texels(n) for n in mine.resources]
        radiance = [found[n + suffix]["scene.radiance"] for n in ("sky.shade", "terrain.shade", "composite.tonemap")]
        assert radiance[0] is radiance[1] is radiance[2] and radiance[0].size == theirs

    # What lasts, and what has its view's size, is never held by passes of both views.
    specs = plan.analysis.model.specs
    held: tuple[set[int], set[int]] = (set(), set())
    for name, objects in found.items():
        for given, obj in objects.items():
            view = int(name.endswith("@view1"))
            spec = specs.get(qualified(given, view, None))
            if spec is not None and (spec.relative or spec.lifetime != "transient"):
                held[view].add(id(obj))
    assert len(held[0]) > 15 and len(held[1]) > 15 and not held[0] & held[1]
    for each in (plan, alone, small):
        each.release()


def test_near_names_of_real_systems_are_qualified(renderer: pf.Renderer) -> None:
    builder = LookingBuilder()
    builder.found = {}
    declared(renderer, builder, {0: SIZE, 1: SMALL})
    builder.scope(view=1).add_pass("mine", bind=lambda io: None, reads=("gbufer.depth",), side_effect=True)
    with pytest.raises(pf.GraphError, match=r"'mine@view1' reads 'gbufer.depth@view1'.*'gbuffer.depth@view1'"):
        builder.analyse()


def test_two_views_on_opengl(renderer: pf.Renderer) -> None:
    """The same camera at the same size twice: both views' passes run in one plan and make the same picture, with
    textures and buffers of their own, whose labels say whose they are."""
    shot = pf.view("coast")
    wanted = renderer.render(shot, outputs=("color",))["color"]
    frame = renderer.frame
    assert frame is not None
    running = list(renderer.running)
    with renderer.current():
        for index in (0, 1):
            view_frame = replace(frame, view=renderer.views[index])
            for system in running:
                system.update(view_frame)
        plan = declared(renderer, GraphBuilder(), {0: SIZE, 1: SIZE}).compile(renderer.own.backend, SIZE)
        try:
            with renderer.gpu.frame():
                plan.execute()
            first, second = plan.resource("composite.ldr"), plan.resource("composite.ldr@view1")
            assert first is not second and first.glo != second.glo
            np.testing.assert_array_equal(read_texture(first)[..., :3], wanted)
            np.testing.assert_array_equal(read_texture(second)[..., :3], wanted)
            vertices = [plan.resource(n) for n in ("terrain.vertices", "terrain.vertices@view1")]
            assert vertices[0].read() == vertices[1].read() and vertices[0].glo != vertices[1].glo
            if renderer.ctx.supports_labels:
                assert [v.label for v in vertices] == ["terrain.vertices", "terrain.vertices@view1"]
            assert renderer.ctx.error == "GL_NO_ERROR"
        finally:
            plan.release()
    renderer.own.first_view.plan_key = ()  # the systems' meshes look at the buffers of that plan: bind them again
    np.testing.assert_array_equal(renderer.render(shot, outputs=("color",))["color"], wanted)


def test_a_renderer_says_who_owns_what(renderer: pf.Renderer) -> None:
    renderer.render(pf.view("coast"))
    reports = {r.name: (r.view, r.planet) for r in renderer.passes()}
    assert reports["terrain.vertices"] == reports["ocean.shade"] == (0, 0)
    assert reports["gbuffer.clear"] == reports["composite.tonemap"] == (0, None)
    assert not [name for name in (*reports, *renderer.graph.resources) if "@" in name]
    assert renderer.graph.explain("sky.shade@view0") == renderer.graph.explain("sky.shade")
    picture = renderer.render(pf.view("coast"), outputs=("gbuffer.depth@view0", "gbuffer.depth"))
    np.testing.assert_array_equal(picture["gbuffer.depth"], picture["gbuffer.depth@view0"])
