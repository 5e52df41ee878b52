"""What systems keep for a view is the view's own: one view's state costs the others nothing, and goes with it."""

from __future__ import annotations

from typing import Any

import pytest

import planetfall as pf
from planetfall.engine.frame import View, ViewParts, Views
from planetfall.engine.gpu import Gpu

SIZE, SMALL = (96, 54), (48, 48)
SUN = pf.Sun(elevation_deg=40.0, azimuth_deg=200.0, latitude_deg=37.7, longitude_deg=140.6)
ABOVE = pf.Camera.at(35.0, 170.0, 5.0, heading_deg=20.0, pitch_deg=8.0)
BELOW = pf.Camera.at(35.0, 170.0, -3.0, heading_deg=20.0, pitch_deg=8.0)


class _Kept:
    def __init__(self) -> None:
        self.released = 0

    def release(self) -> None:
        self.released += 1


def test_state_is_made_once_for_each_view_and_owner_and_released_with_the_view() -> None:
    views, one, other = Views(), object(), object()
    first = views[0].state(one, _Kept)
    assert views[0].state(one, _Kept) is first
    assert views[1].state(one, _Kept) is not first
    assert views[0].state(other, _Kept) is not first
    assert views[0].found(one) is first and views[2].found(one) is None
    assert len(views.states(one, _Kept)) == 2
    views.release(views[0])
    views.release(views[0])
    assert first.released == 1 and views[0].found(one) is None
    assert len(views.states(one, _Kept)) == 1
    second = views[1].state(one, _Kept)
    views.forget(one)
    assert second.released == 1 and views.states(one, _Kept) == []
    assert len(views.states(other, _Kept)) == 0
    assert View(3).index == 3 and views[1].state(other, int) == 0


@pytest.mark.gpu
def test_parts_of_a_view_are_counted_under_their_owner_and_freed_with_either(gpu: Gpu) -> None:
    scope, view, other = gpu.scope("sea"), View(1), View(2)
    for each in (view, other):
        each.state(scope, lambda: ViewParts(scope)).gpu.buffer(reserve=64)
    assert gpu.memory_bytes()["sea"] == 128
    view.release()
    assert gpu.memory_bytes()["sea"] == 64
    scope.release()
    assert "sea" not in gpu.memory_bytes()
    other.release()  # the owner was first


def _held(renderer: pf.Renderer) -> tuple[dict[str, int], dict[str, dict[str, int]]]:
    return renderer.memory_bytes, renderer.gpu.counts()


@pytest.mark.gpu
@pytest.mark.parametrize(
    ("backend", "method"),
    [("grid", "ours"), ("quadtree", "ours"), ("icosphere", "ours"), ("grid", "paper"), ("icosphere", "paper")],
)
def test_a_released_view_leaves_nothing(backend: str, method: str) -> None:
    scene = pf.load_scene("earth")
    scene.planet[pf.Terrain].method = method
    coast = pf.Camera.at(37.7, 140.6, 900.0, pitch_deg=-20.0, planet=scene.planet)
    place = tuple(coast.position_m + 300.0 * coast.forward)
    scene.add(pf.Transform(position_m=place), pf.Shape("box", (50.0,) * 3))
    renderer = pf.Renderer(scene, SIZE, "low", {"terrain.backend": backend})

    def add_and_release() -> None:
        with renderer.add_view(SMALL) as view:
            view.render(coast, 0.0, sun=SUN)
            assert sum(renderer.memory_bytes.values()) > sum(before[0].values())

    with scene, renderer:
        renderer.settle(coast, 0.0, sun=SUN)
        before: Any = _held(renderer)
        add_and_release()  # programs and meshes that are made when first needed are shared
        before = _held(renderer)
        for _ in range(3):
            add_and_release()
        assert _held(renderer) == before


@pytest.mark.gpu
def test_a_thousand_views_that_come_and_go_leave_nothing() -> None:
    scene = pf.load_scene("earth")
    camera = pf.Camera.at(37.7, 140.6, 900.0, pitch_deg=-20.0)
    with scene, pf.Renderer(scene, SIZE, "low") as renderer:
        renderer.settle(camera, 0.0, sun=SUN)
        with renderer.add_view(SMALL) as view:
            view.render(camera, 0.0, sun=SUN)
        before = _held(renderer)
        for count in range(1000):
            with renderer.add_view(SMALL) as view:
                if count % 200 == 0:
                    view.render(camera, 0.0, sun=SUN)
        assert _held(renderer) == before


@pytest.mark.gpu
def test_a_view_under_water_leaves_the_clouds_of_the_other_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    from planetfall.engine.graph import GraphBuilder

    compiled: list[int] = []
    compile_ = GraphBuilder.compile

    def counted(self: GraphBuilder, *args: Any, **kwargs: Any) -> Any:
        compiled.append(1)
        return compile_(self, *args, **kwargs)

    scene = pf.load_scene("earth")
    scene.planet.add(pf.Clouds())
    with scene, pf.Renderer(scene, SMALL, "low") as renderer, renderer.add_view(SMALL) as diver:
        pairs = ((renderer, ABOVE), (diver, BELOW))

        def frame(number: int) -> None:
            for view, camera in pairs:
                view.render(camera, number / 60.0, sun=SUN, dt_s=1.0 / 60.0)

        for number in range(3):
            frame(number)
        monkeypatch.setattr(GraphBuilder, "compile", counted)
        plans = [view.graph for view, _ in pairs]
        for number in range(3, 8):
            frame(number)
        assert [view.graph for view, _ in pairs] == plans and not compiled
        ran = [{p.name for p in view.passes() if p.ran} for view, _ in pairs]
        assert "clouds.march" in ran[0] and "clouds.march" not in ran[1]
        clouds = renderer.system("clouds").method
        assert clouds is not None
        past: Any = renderer.views[0].found(clouds).history
        assert past.mode != 0, "the frame before was lost"


@pytest.mark.gpu
def test_views_that_take_turns_do_not_write_each_others_blocks() -> None:
    """Over the same still scene: what depends on a view's place is in blocks of its own."""
    with pf.load_scene("earth") as scene:
        first = pf.Camera.at(37.7, 140.6, 900.0, pitch_deg=-20.0, planet=scene.planet)
        second = pf.Camera.at(37.69, 140.62, 1100.0, pitch_deg=-20.0, planet=scene.planet)
        with pf.Renderer(scene, SIZE, "low") as renderer, renderer.add_view(SIZE) as view:
            for _ in range(3):
                renderer.gpu.work.reset()
                renderer.render(first, 0.0, sun=SUN)
                view.render(second, 0.0, sun=SUN)
            assert renderer.gpu.work.uploads == 2  # the frame's own block, with the camera in it
