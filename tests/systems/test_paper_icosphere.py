"""Backend icosphere, method paper: it draws, as the recursion says, and on the same ground as ours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure.icosphere_holes import HolePixels, borders, hole_pixels
from planetfall.engine.surface.icosphere import direction_of
from planetfall.engine.surface.keys import container_of
from planetfall.engine.surface.triangle_paper import frustum_planes, select
from planetfall.engine.surface.triangle_patch import vertex_index, vertex_place
from planetfall.systems.terrain.backends import paper_icosphere

PAPER = {"terrain.backend": "icosphere", "terrain.method": "paper"}


@pytest.fixture(scope="module")
def renderer():
    with pf.Renderer(pf.load_scene("earth"), size=(160, 90), quality="medium", overrides=PAPER) as made:
        yield made


@pytest.mark.parametrize("name", ("ground", "near", "high", "orbit", "space"))
def test_the_ground_is_where_ours_has_it(renderer, name):
    view = pf.view(name)
    found = renderer.render(view, outputs=("distance", "normal", "surface"))
    assert np.isfinite(found["normal"]).all()
    with pf.Renderer(pf.load_scene("earth"), size=(160, 90), quality="medium") as grid:
        truth = grid.render(view, outputs=("distance",))["distance"]
    both = np.isfinite(found["distance"]) & np.isfinite(truth)
    # Along silhouettes alone, within the 2 % of the pixels that lie there in the steepest of these views.
    assert (np.isfinite(found["distance"]) != np.isfinite(truth)).mean() < 0.02
    assert np.median(np.abs(found["distance"][both] / truth[both] - 1.0)) < 0.01


def test_what_is_drawn_is_what_the_recursion_leaves(renderer):
    camera = pf.Camera.at(40.0, 20.0, 5000.0, heading_deg=70.0, pitch_deg=-15.0)
    renderer.render(camera)
    backend = renderer.system("terrain").backend
    view, state = backend.view(renderer.views[0]), renderer.camera_state(camera)
    tangents = tuple(getattr(state, f"tan_{side}") for side in ("left", "right", "bottom", "top"))
    planes = frustum_planes(state.forward, state.up, tangents)
    finest = int(view.keys.size and backend.shape.scheme.level(view.keys).max())
    base, radius = backend.base_m(), renderer.scene.planet.radius_m
    above = view.ground_m + radius - base
    expected = select(backend.shape.scheme, view.table, base, state.position_m, planes, finest, above)
    np.testing.assert_array_equal(np.sort(view.keys), np.sort(expected.keys))
    assert backend.statistics()["triangles"] == len(view.keys) * backend.shape.segments**2
    assert (container_of(view.keys, np.sort(view.keys)) >= 0).all()


def test_a_still_camera_makes_no_vertices(renderer):
    view = pf.view("high")
    for _ in range(3):
        renderer.render(view)
    assert "terrain.vertices" not in {p.name for p in renderer.passes() if p.ran}


def test_vertices_at_the_end_of_their_morph_are_the_parents(renderer):
    """Beyond the end of its level's morph an odd vertex is the even one that its morph vector leads to, and before the
    morph begins it is its own."""
    backend = renderer.system("terrain").backend
    camera = pf.Camera.at(10.0, 120.0, 2000.0, pitch_deg=-20.0)
    renderer.render(camera)
    view, shape = backend.view(renderer.views[0]), backend.shape
    with renderer.current():
        data = np.frombuffer(view.vertices.read(len(view.keys) * shape.vertices * 24), "<f4")
    data = data.reshape(-1, shape.vertices, 6)[:, :, :3]
    radius = renderer.scene.planet.radius_m + view.ground_m
    away = direction_of(*shape.points(view.keys)) * radius - renderer.camera_state(camera).position_m
    away = np.linalg.norm(away, axis=-1)
    _, level, _, j = (x[:, None] for x in shape.scheme.unpack(view.keys))
    begin, end = view.table.morph_m[level].T
    p, q = vertex_place(np.arange(shape.vertices), shape.segments)
    odd = (p % 2 == 1) | (q % 2 == 1)
    sign = np.where((level + j) % 2 == 0, 1, -1)  # the patches beside one another twist the opposite way round
    step_p = sign * np.where(q % 2 == 0, -(p % 2), p % 2)
    step_q = sign * np.where(q % 2 == 0, 0, np.where(p % 2 == 0, 1, -1))
    target = vertex_index(p + step_p, q + step_q, shape.segments)
    inner = (p > 0) & (q > 0) & (p + q < shape.segments)  # on edges another root's numbers may be used: other bits
    same = (data == np.take_along_axis(data, target[..., None], axis=1)).all(axis=-1)
    far = away > end.T * 1.001  # both: heights are as smooth as the morph has got
    ends = far & np.take_along_axis(far, target, axis=1) & odd & inner & (level > 0)
    begins = (away < begin.T * 0.999) & odd
    assert ends.sum() > 100 and same[ends].all()
    assert begins.sum() > 100 and not same[begins].any()


VIEWS = ("near", "high", "orbit")


@pytest.fixture(scope="module")
def bare():
    """The printed icosphere and ours, without the sea, which would lie behind holes."""
    scene = pf.load_scene("earth")
    scene.planet.remove(pf.Ocean)
    with (
        pf.Renderer(scene, size=(160, 90), quality="low", overrides=PAPER) as printed,
        pf.Renderer(scene, size=(160, 90), quality="low", overrides={"terrain.backend": "icosphere"}) as ours,
    ):
        yield printed, ours


@pytest.mark.parametrize("name", VIEWS)
def test_cracks_are_along_the_edges_of_the_base_alone(bare, name):
    """Both sides of an edge have the same vertices, bit for bit, but where two of the icosahedron's triangles meet."""
    found = borders(bare[0], pf.view(name))
    assert found.inner > 50 and found.inner_open == 0, found
    assert found.base > 0 and found.base_open > 0, found  # the source leaves these
    assert found.base_px < 0.5


def test_open_borders_are_seen(bare, monkeypatch):
    """The measure itself: levels that morph twice as near leave cracks everywhere."""
    made = paper_icosphere.tables

    def nearer(*given):
        table = made(*given)
        return replace(table, morph_m=table.morph_m / 2)

    monkeypatch.setattr(paper_icosphere, "tables", nearer)
    scene = bare[0].scene
    with pf.Renderer(scene, size=(160, 90), quality="low", overrides=PAPER) as printed:
        found = borders(printed, pf.view("near"))
        assert found.inner_open > 50 and found.inner_px > 1.0
        assert hole_pixels(printed, bare[1], pf.view("near")).cracks > 0


@pytest.mark.parametrize("name", VIEWS)
def test_no_pixel_is_missing(bare, name):
    assert hole_pixels(*bare, pf.view(name)) == HolePixels(cracks=0, dropped=0)


def test_dropped_triangles_are_seen(bare, monkeypatch):
    """The measure itself: half of the triangles, side by side, leave a hole that is no crack but for its rim."""
    chosen = paper_icosphere.select

    def half(*given):
        found = chosen(*given)
        return replace(found, keys=np.sort(found.keys)[: len(found.keys) // 2])

    monkeypatch.setattr(paper_icosphere, "select", half)
    with pf.Renderer(bare[0].scene, size=(160, 90), quality="low", overrides=PAPER) as printed:
        found = hole_pixels(printed, bare[1], pf.view("high"))
    assert found.dropped > 500 and found.cracks < 0.05 * found.dropped


def test_the_height_drawn_is_near_the_truth(renderer):
    camera = pf.Camera.at(45.0, 10.0, 3000.0, pitch_deg=-80.0, above="ground")
    renderer.render(camera)
    foot = renderer.camera_state(camera).direction[None]
    drawn, truth = renderer.height_drawn(foot)[0], pf.TerrainSampler(renderer.scene).height(foot)[0]
    assert abs(drawn - truth) < 100.0  # spacing is about 100 m there, slopes below 1


def test_nothing_is_left_behind():
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, size=(64, 36), quality="low", overrides={"terrain.backend": "icosphere"}) as made:
        made.render(pf.view("near"))
        scene.planet[pf.Terrain].method = "paper"
        made.render(pf.view("near"))
        made.release()
        assert made.gpu.counts() == {}
