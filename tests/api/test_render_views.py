"""Several views of one planet: each draws what a renderer of its own would; tiles, tables and programs are shared."""

from __future__ import annotations

from collections import Counter
from typing import Any

import moderngl
import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.hosts.headless import create_headless

pytestmark = pytest.mark.gpu

SIZE, SMALL = (64, 36), (32, 32)
SUN = pf.Sun(elevation_deg=40.0, azimuth_deg=200.0, latitude_deg=37.7, longitude_deg=140.6)
MAIN = pf.view("coast")
MAP = pf.Camera.at(37.7, 140.6, 4.0e5, pitch_deg=-90.0)
OUTPUTS = ("color", "distance", "surface")


def scene_of(clouds: bool = False) -> pf.Scene:
    scene = pf.load_scene("earth")
    if clouds:
        scene.planet.add(pf.Clouds())
    place = MAIN.resolve(scene).position_m + 300.0 * MAIN.forward
    scene.add(pf.Transform(position_m=tuple(place)), pf.Shape("box", (50.0,) * 3))
    return scene


def bytes_of(renderer: pf.Renderer) -> Counter[str]:
    """Of all textures and buffers that the renderer holds, by owner; mipmaps left out."""
    total: Counter[str] = Counter()
    for scope in renderer.gpu._scopes:
        for kind, thing in scope._objects.values():
            if kind == "texture":
                total[scope.owner] += int(np.prod(thing.size)) * thing.extra.format.texel_bytes
            elif isinstance(thing, moderngl.Buffer):
                total[scope.owner] += thing.size
    return total


@pytest.mark.parametrize(
    ("backend", "clouds"),
    [("grid", False), ("quadtree", False), pytest.param("grid", True, marks=pytest.mark.slow),
     pytest.param("icosphere", True, marks=pytest.mark.slow)],
)  # fmt: skip
def test_each_view_is_as_if_it_were_alone(backend: str, clouds: bool) -> None:
    overrides = {"terrain.backend": backend, "exposure.mode": "fixed", "exposure.ev100": 14.0}
    alone: list[dict[str, Any]] = []
    with scene_of(clouds) as scene, pf.Renderer(scene, (4, 4), "low", overrides) as renderer:
        renderer.settle(MAIN, 0.0, sun=SUN)  # leaves tables on disk: those from a file are rounded, so all are
    for camera, size in ((MAIN, SIZE), (MAP, SMALL)):
        with scene_of(clouds) as scene, pf.Renderer(scene, size, "low", overrides) as renderer:
            renderer.settle(camera, 0.0, sun=SUN)
            alone.append(renderer.render(camera, 0.0, sun=SUN, outputs=OUTPUTS))
    with scene_of(clouds) as scene, pf.Renderer(scene, SIZE, "low", overrides) as renderer:
        above = renderer.add_view(SMALL)
        assert (above.size, renderer.size) == (SMALL, SIZE)
        renderer.settle(MAIN, 0.0, sun=SUN)
        above.settle(MAP, 0.0, sun=SUN)
        for _ in range(2):  # in turns
            for view, camera, wanted in ((renderer, MAIN, alone[0]), (above, MAP, alone[1])):
                found = view.render(camera, 0.0, sun=SUN, outputs=OUTPUTS)
                for name in ("distance", "surface"):
                    np.testing.assert_array_equal(found[name], wanted[name], err_msg=f"{name} of {view!r}")
                np.testing.assert_array_equal(found["color"], wanted["color"], err_msg=repr(view))
        below = MAIN.resolve(scene).position_m
        heights = [above.height_drawn(pf.direction([37.7], [140.6])), renderer.height_drawn(below)]
        field = scene.planet.height_field()
        assert field is not None
        assert abs(heights[0][0] - field.height(pf.direction([37.7], [140.6]))[0]) < 500.0  # as seen from 400 km
        assert np.isfinite(heights[1]).all()
        hit = above.pick(MAP, 16.0, 16.0)
        assert hit is not None and hit[1] in ("terrain", "sea")
        pixel, front = above.project(MAP, hit[0])
        assert front[0] and np.abs(pixel[0] - 16.5).max() < 1.0
        assert renderer.ctx.error == "GL_NO_ERROR"


def test_what_is_shared_is_made_once() -> None:
    """The same ground from another place: no tile, no table, no program is made again."""
    other = pf.Camera.at(37.684, 140.602, 1200.0, heading_deg=135.0, pitch_deg=-14.0, above="ground")
    with scene_of(clouds=True) as scene, pf.Renderer(scene, SIZE, "low", {"terrain.backend": "quadtree"}) as renderer:
        renderer.settle(MAIN, 0.0, sun=SUN)
        backend, air = renderer.system("terrain").backend, renderer.system("atmosphere").method.job  # type: ignore[union-attr]
        tiles, generation, programs = backend.made, air.generation, renderer.gpu.counts()
        first = bytes_of(renderer)
        assert min(first[owner] for owner in ("atmosphere", "clouds", "terrain")) > 100_000
        view = renderer.add_view(SIZE)
        view.settle(other, 0.0, sun=SUN)
        assert backend.made - tiles < 0.2 * tiles, "nearly all it needs is there"
        assert air.generation == generation
        after = renderer.gpu.counts()
        for owner in ("atmosphere", "clouds", "composite", "gbuffer", "light", "props"):
            assert after.get(owner, {}).get("program") == programs.get(owner, {}).get("program"), owner
        second = bytes_of(renderer)
        for owner in ("atmosphere", "clouds", "composite", "gbuffer", "sky", "stars"):
            assert second[owner] == first[owner], owner
        assert second["proxy"] == 2 * first["proxy"]  # the lattice around its anchor
        assert second["terrain"] < 1.2 * first["terrain"]  # its list of tiles; the tiles are shared
        assert second["graph"] - first["graph"] == pytest.approx(view.graph.memory_bytes(), rel=0.05)
        view.release()
        assert bytes_of(renderer)["graph"] == first["graph"]


@pytest.mark.parametrize("method", ["ours", "paper_2019"])
def test_blocks_that_hold_a_views_camera_are_its_own(method: str) -> None:
    """One view over another place writes into no other's, and finds its own after that one has drawn."""
    elsewhere = pf.Camera.at(-20.0, 30.0, 3000.0, pitch_deg=-10.0)
    names = ["atmosphere.camera", "clouds.view", "shadows.windows"]
    with scene_of(clouds=True) as scene, pf.Renderer(scene, SIZE, "low") as renderer:
        scene.planet[pf.Clouds].method = method

        def held(view: pf.Renderer | pf.RenderView) -> list[bytes]:
            with renderer.current():
                return [view.graph.resource(name).read() for name in names]

        renderer.settle(MAIN, 0.0, sun=SUN)
        renderer.render(MAIN, 0.0, sun=SUN)
        before = held(renderer)
        view = renderer.add_view(SIZE)
        view.settle(elsewhere, 0.0, sun=SUN)
        view.render(elsewhere, 0.0, sun=SUN)
        others = held(view)
        assert all(a != b for a, b in zip(before, others, strict=True))
        assert held(renderer) == before
        renderer.render(MAIN, 0.0, sun=SUN)
        assert held(renderer) == before and held(view) == others


@pytest.mark.parametrize("backend", ["grid", "quadtree"])
def test_what_changes_in_one_view_compiles_no_others_graph(backend: str) -> None:
    """Other cells, larger buffers, clouds out of sight, another size: none is the other view's affair."""
    places = [
        pf.Camera.at(-20.0, 30.0, 3000.0, pitch_deg=-10.0),
        pf.Camera.at(-20.0, 30.0, 3000.0, pitch_deg=89.0),
        pf.Camera.at(37.684, 140.602, 2.0, above="ground"),
        pf.Camera.at(0.0, 0.0, 2e7, pitch_deg=-90.0),
        pf.Camera.at(0.0, 0.0, 2e7, pitch_deg=89.0),
    ]
    with scene_of(clouds=True) as scene, pf.Renderer(scene, SIZE, "low", {"terrain.backend": backend}) as renderer:
        renderer.settle(MAIN, 0.0, sun=SUN)
        renderer.render(MAIN, 0.0, sun=SUN)
        view, own = renderer.add_view(SIZE), renderer.graph
        seen = set()
        for place in places:
            view.settle(place, 0.0, sun=SUN)
            seen.add(id(view.graph))
            renderer.render(MAIN, 0.0, sun=SUN)
            assert renderer.graph is own, place
        assert len(seen) > 1, "its own was compiled again"
        view.resize((200, 300))
        view.render(MAIN, 0.0, sun=SUN)
        renderer.render(MAIN, 0.0, sun=SUN)
        assert renderer.graph is own
        scene.planet[pf.Clouds].shafts = not scene.planet[pf.Clouds].shafts  # what is all views'
        renderer.render(MAIN, 0.0, sun=SUN)
        assert renderer.graph is not own


def test_views_come_and_go() -> None:
    with scene_of() as scene, pf.Renderer(scene, SIZE, "low") as renderer:
        before = renderer.render(MAIN, 0.0, sun=SUN)["color"]
        first = renderer.add_view(SMALL)
        second = renderer.add_view((20, 10))
        assert (first.index, second.index) == (1, 2)
        counts = []
        for _ in range(4):
            first.render(MAP, sun=SUN)
            second.render(MAP, sun=SUN)
            first.release()
            first.release()
            first = renderer.add_view(SMALL)
            assert first.index == 1
            counts.append(renderer.gpu.counts())
        assert counts[1] == counts[2] == counts[3]  # nothing grows
        with pytest.raises(pf.SizeError):
            renderer.add_view((0, 5))
        # The world changes: every view hears of it.
        first.render(MAP, sun=SUN)
        scene.planet.remove(pf.Ocean)
        assert 2 not in np.unique(renderer.render(MAIN, 0.0, sun=SUN, outputs=("surface",))["surface"])
        assert 2 not in np.unique(first.render(MAP, sun=SUN, outputs=("surface",))["surface"])
        assert 2 not in np.unique(second.render(MAP, sun=SUN, outputs=("surface",))["surface"])
        scene.planet.add(pf.Ocean())
        assert renderer.render(MAIN, 0.0, sun=SUN)["color"].shape == before.shape
        assert 2 in np.unique(second.render(MAP, sun=SUN, outputs=("surface",))["surface"])
    with pytest.raises(pf.SettingError, match="released"):
        first.render(MAP)


def test_split_screen_and_a_map_in_a_hosts_framebuffer() -> None:
    ctx = create_headless()
    target = ctx.framebuffer([ctx.texture((96, 54), 4)], ctx.depth_renderbuffer((96, 54)))
    with scene_of() as scene, pf.Renderer(scene, (48, 54), "low", ctx=ctx) as renderer:
        right, above = renderer.add_view((48, 54)), renderer.add_view((16, 16))
        back = pf.Camera(MAIN.resolve(renderer.scene).position_m, -MAIN.forward, MAIN.up)
        for _ in range(3):
            renderer.render_to(target, MAIN, 0.0, SUN, viewport=(0, 0, 48, 54), dt_s=0.02)
            right.render_to(target, back, 0.0, SUN, viewport=(48, 0, 48, 54), dt_s=0.02)
            above.render_to(target, MAP, 0.0, SUN, viewport=(78, 36, 16, 16), dt_s=0.02)
        picture = np.frombuffer(target.read(components=3), np.uint8).reshape(54, 96, 3)
        assert picture.reshape(-1, 3).max(axis=1).min() > 0  # no gap
        assert renderer.size == right.size == (48, 54)
        assert above.size == (16, 16)
        assert np.abs(picture[:, :48].astype(int) - picture[:, 48:]).mean() > 5.0
    target.release()
    assert ctx.error == "GL_NO_ERROR"
    ctx.release()
