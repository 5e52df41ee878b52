"""Backend icosphere, method paper: it draws, as the recursion says, and on the same ground as ours."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.engine.surface.icosphere import direction_of
from planetfall.engine.surface.keys import container_of
from planetfall.engine.surface.triangle_paper import frustum_planes, select
from planetfall.engine.surface.triangle_patch import vertex_index, vertex_place

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
    radius = renderer.scene.planet.radius_m
    expected = select(backend.shape.scheme, view.table, radius, state.position_m, planes, finest, view.ground_m)
    np.testing.assert_array_equal(np.sort(view.keys), np.sort(expected.keys))
    assert backend.statistics()["triangles"] == len(view.keys) * backend.shape.segments**2
    assert (container_of(view.keys, np.sort(view.keys)) >= 0).all()


def test_a_still_camera_makes_no_vertices(renderer):
    view = pf.view("high")
    for _ in range(3):
        renderer.render(view)
    assert "terrain.vertices" not in {p.name for p in renderer.passes() if p.ran}


def test_vertices_at_the_end_of_their_morph_are_the_parents(renderer):
    """Farther away than where the parent is split, an odd vertex is the even one that its morph vector leads to, and
    nearer than half the level's range it is its own."""
    backend = renderer.system("terrain").backend
    camera = pf.Camera.at(10.0, 120.0, 2000.0, pitch_deg=-20.0)
    renderer.render(camera)
    view, shape = backend.view(renderer.views[0]), backend.shape
    with renderer.current():
        data = np.frombuffer(view.vertices.read(len(view.keys) * shape.vertices * 24), "<f4")
    data = data.reshape(-1, shape.vertices, 6)[:, :, :3]
    radius, split = renderer.scene.planet.radius_m + view.ground_m, view.table.split_m
    away = direction_of(*shape.points(view.keys)) * radius - renderer.camera_state(camera).position_m
    away = np.linalg.norm(away, axis=-1)
    level = np.maximum(shape.scheme.level(view.keys), 1)[:, None]
    p, q = vertex_place(np.arange(shape.vertices), shape.segments)
    odd = (p % 2 == 1) | (q % 2 == 1)
    step = np.where(q % 2 == 0, -(p % 2), p % 2), np.where(q % 2 == 0, 0, np.where(p % 2 == 0, 1, -1))
    target = vertex_index(p + step[0], q + step[1], shape.segments)
    inner = (p > 0) & (q > 0) & (p + q < shape.segments)  # on edges another root's numbers may be used: other bits
    same = (data == data[:, target]).all(axis=-1)
    ends = (away > split[level - 1] * 1.001) & odd & inner
    begins = (away < 0.5 * (split[level - 1] + split[level]) * 0.999) & odd
    assert ends.sum() > 100 and same[ends].all()
    assert begins.sum() > 100 and not same[begins].any()


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
