"""The projected grid's paper mode: its ground and its picture."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import grid_kept, ground, paper_grid
from planetfall.systems.terrain.height import TerrainParams
from planetfall.systems.terrain.paper_ground import TEXELS, PaperField, sample_continents

pytestmark = pytest.mark.gpu

EARTH = TerrainParams.from_component(pf.load_scene("earth").planet[pf.Terrain], 6.371e6)
BODY = "dh = paper_dh(d);"
HEADER = '#include "terrain/paper/ground.glsl"'


@pytest.fixture(scope="module")
def field():
    return PaperField(EARTH, 10)


@pytest.fixture(scope="module")
def paper():
    overrides = {"terrain.method": "paper"}
    with pf.Renderer(pf.load_scene("earth"), size=(320, 180), quality="medium", overrides=overrides) as made:
        yield made


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


# -- the ground ------------------------------------------------------------------------------------------------------


def test_the_texture_shows_the_scenes_continents(field, rng):
    directions = unit(rng.normal(size=(4000, 3)))
    truth = pf.TerrainSampler(pf.load_scene("earth")).height(directions)
    drawn = PaperField(EARTH, 0).height(directions)
    assert np.corrcoef(truth, drawn)[0, 1] > 0.95
    assert np.mean((truth > 0.0) == (drawn > 0.0)) > 0.95


def test_the_texture_is_read_at_its_texels_and_over_the_poles(field):
    row, column = 700, 1023
    latitude, longitude = ((row + 0.5) / TEXELS - 0.5) * np.pi, (column + 0.5) / TEXELS * 2 * np.pi
    here = np.array([[np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)]])
    around = field.continents[..., 0].astype(float)[row - 1 : row + 2][:, [1022, 1023, 0]]
    expected = np.array([1, 4, 1]) @ around @ np.array([1, 4, 1]) / 36.0
    assert sample_continents(field.continents, here)[0][0] == pytest.approx(expected, abs=1e-6)
    # Across a pole along a meridian: no jump between the two sides.
    beside = np.array([[1e-7, 0.0, 1.0], [-1e-7, 0.0, 1.0], [0.0, 1e-7, -1.0], [0.0, -1e-7, -1.0]])
    heights, _ = sample_continents(field.continents, beside)
    assert abs(heights[0] - heights[1]) < 0.1 and abs(heights[2] - heights[3]) < 0.1


def test_bounds_hold(field, rng):
    heights = field.height(unit(rng.normal(size=(20_000, 3))))
    assert field.lowest_m <= heights.min() and heights.max() <= field.highest_m


def test_layers_are_checked():
    with pytest.raises(ValueError, match="layers"):
        PaperField(EARTH, 11)


@pytest.mark.parametrize("direction", [(0.3, -0.5, 0.8), (1, 0, 0), (-1, 1e-9, 0), (0, 0, 1), (1e-5, 0, -1)])
def test_heights_on_the_gpu(field, run_compute, scope, rng, direction):
    up = np.array(direction) / np.linalg.norm(direction)
    anchor_m = round(float(field.height(up[None])[0]) * 16) / 16
    side = unit(np.cross(up, rng.normal(size=(3000, 3))))
    distance = 10.0 ** rng.uniform(0.0, np.log10(3.0 * 6.371e6), 3000)[:, None]
    angle = distance / 6.371e6
    d = (6.371e6 * (np.sin(angle) * side - 2.0 * np.sin(0.5 * angle) ** 2 * up)).astype(np.float32)
    table = scope.buffer(field.table(up, anchor_m).tobytes())
    texture = scope.texture((TEXELS, TEXELS), "rg32f", field.continents.tobytes())

    def bind(_):
        table.bind_to_uniform_block(4)
        texture.use(6)

    found = run_compute(BODY, {"d": d}, {"dh": "float"}, header=HEADER, setup=bind)["dh"]
    truth = field.height_at_feet(up * 6.371e6 + d.astype(np.float64)) - anchor_m
    off = np.abs(found - truth)
    # f32: heights of kilometres to 2^-24, and places to 1e-7 of their distance on slopes of about one.
    assert (off <= 2e-3 + 3e-7 * distance[:, 0]).all()


# -- the picture -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("view", ["near", "high", "orbit", "space", "ground", "pole"])
def test_vertices_are_where_float64_has_them(paper, rng, view):
    found = paper_grid.vertex_error(paper, pf.view(view), rng, most=4000)
    assert found.p99_px <= 1e-3
    # Heights of a kilometre of noise round to 0.2 mm: a tenth of a pixel at a vertex that is a metre from the eye.
    assert found.worst_px <= {"ground": 0.1, "near": 3e-3}.get(view, 1e-3)


@pytest.mark.parametrize("view", ["near", "high", "orbit", "space", "ground", "pole"])
def test_nothing_seen_is_dropped(paper, view):
    found = paper_grid.culling(paper, pf.view(view))
    assert found.dropped_seen == 0
    if view in ("near", "ground", "high"):
        assert found.drawn < 0.5 * found.patches


def test_no_holes_in_the_disc(paper):
    camera = pf.view("space")
    out = paper.render(camera, outputs=("surface",))
    state = paper.camera_state(camera)
    height, width = out["surface"].shape
    x = (np.arange(width) + 0.5) / width * (state.tan_right - state.tan_left) + state.tan_left
    y = state.tan_top - (np.arange(height) + 0.5) / height * (state.tan_top - state.tan_bottom)
    ray = state.forward + x[None, :, None] * state.right + y[:, None, None] * state.up
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    along = ray @ state.position_m
    closest = np.sqrt(state.position_m @ state.position_m - along**2)
    # Inside by more than two pixels: the limb itself is the mesh's chords.
    pixel = np.linalg.norm(state.position_m) * (state.tan_top - state.tan_bottom) / height
    assert (out["surface"][closest < 6.371e6 - 2 * pixel] > 0).all()


def test_drawn_ground_follows_its_own_truth(paper, rng):
    field = paper.world.resource("height_field")
    # Near the ground a cell of the grid is kilometres wide, and 64 is the most that it is cut into.
    for view, most in (("near", 6.0), ("high", 1.5), ("orbit", 0.2)):
        found = ground.picture_error(paper, pf.view(view), rng, 3000, field)
        assert found is not None and found.p99_px <= most, view


def test_a_flight_keeps_most_vertices():
    """The drawn mesh before a snap and after it: when the grid goes on by a cell, and when patches are cut anew."""
    scene = pf.load_scene("earth")
    with pf.Renderer(scene, size=(96, 54), quality="low", overrides={"terrain.method": "paper"}) as renderer:
        flight = grid_kept.level_cameras(renderer, 1e4, 0.1 * grid_kept.Sight(1e4).cell_m, 20)
        moves, cuts = grid_kept.flown(renderer, flight)
    assert moves and min(k.vertices for k in moves) >= 0.65
    assert cuts and min(k.vertices for k in cuts) >= 0.65
    assert all(k.points == 1.0 for k in cuts), "the grid itself stays where it is"


@pytest.mark.parametrize("view", ["space", "orbit"])
def test_coasts_have_no_lone_pixels(paper, view):
    """Relief narrower than a pixel would toss a coin for each: 0.4 % of the disc's pixels and 1 % of orbit's stood
    alone. An islet may happen to be as wide as a pixel."""
    surface = paper.render(pf.view(view), outputs=("surface",))["surface"]
    shifted = [np.roll(surface, (y, x), (0, 1)) for y in (-1, 0, 1) for x in (-1, 0, 1) if x or y]
    inner = np.all([other > 0 for other in shifted], axis=0) & (surface > 0)
    lone = inner & np.all([other != surface for other in shifted], axis=0)
    assert lone.sum() <= 5e-4 * inner.sum()


def test_a_held_proxy_makes_nothing(paper):
    paper.render(pf.view("near"))
    paper.render(pf.view("near"))
    ran = {p.name: p.ran for p in paper.passes()}
    assert not ran["terrain.vertices"] and not ran["terrain.cull"] and ran["terrain.gbuffer"]


def test_cameras_above_ground_stand_on_what_is_drawn(paper):
    state = paper.camera_state(pf.view("ground"))
    zenith = state.position_m / np.linalg.norm(state.position_m)
    drawn = paper.world.resource("height_field").height(zenith[None])[0]
    assert np.linalg.norm(state.position_m) - 6.371e6 - drawn == pytest.approx(2.0, abs=1e-6)
    truth = pf.TerrainSampler(paper.scene).height(zenith[None])[0]
    assert truth == pytest.approx(paper.scene.planet.ground_height_m(zenith[None])[0]), "queries tell of the scene"


def test_methods_change_while_running():
    with pf.Renderer(pf.load_scene("earth"), size=(96, 54), quality="low") as renderer:
        camera = pf.Camera.at(9.9, 38.1, 4000.0, 285.0, -20.0)
        before = renderer.render(camera, outputs=("distance",))["distance"]
        renderer.scene.planet[pf.Terrain].method = "paper"
        paper = renderer.render(camera, outputs=("distance",))["distance"]
        renderer.scene.planet[pf.Terrain].method = "ours"
        after = renderer.render(camera, outputs=("distance",))["distance"]
    assert np.array_equal(before, after, equal_nan=True)
    assert not np.array_equal(before, paper, equal_nan=True)


def test_quality_paper_chooses_it():
    assert pf.Renderer(pf.load_scene("moon"), size=(32, 18), quality="paper").settings["terrain.method"] == "paper"


@pytest.mark.parametrize("corners", [50, 200])
def test_other_grids(corners, rng):
    overrides = {"terrain.method": "paper", "terrain.paper_grid": corners, "terrain.paper_warp": 2}
    with pf.Renderer(pf.load_scene("moon"), size=(160, 90), quality="low", overrides=overrides) as renderer:
        found = paper_grid.vertex_error(renderer, pf.view("near"), rng, 2000)
        assert found.worst_px <= 1e-2
        assert len(paper_grid.PaperMesh.of(renderer).cut) == (corners - 1) ** 2


def test_triangles_on_the_gpu_are_those_of_the_tessellation(paper):
    paper.render(pf.view("near"))
    mesh = paper_grid.PaperMesh.of(paper)
    view = paper.system("terrain").backend.view(paper.views[0])
    with paper.current():
        counts = int(np.frombuffer(view.buffers["arguments"].read(4), "u4")[0])
        found = np.frombuffer(view.buffers["triangles"].read(4 * counts), "u4").astype(np.int64).reshape(-1, 3)
    a, b, c = found.T
    found = found[(a != b) & (b != c) & (c != a)]
    faces = mesh.cut.faces()
    expected = faces[mesh.drawn[mesh.patch[faces[:, 0]]]]
    assert len(found) == len(expected)
    order = [np.lexsort(t.T) for t in (found, expected)]
    assert np.array_equal(found[order[0]], expected[order[1]])


def test_height_drawn_is_that_of_the_picture(paper):
    out = paper.render(pf.view("near"), outputs=("position", "surface"))
    state = paper.camera_state(pf.view("near"))
    rows, columns = np.nonzero(out["surface"] == 1)
    chosen = np.random.default_rng(7).choice(len(rows), 40, replace=False)
    points = state.position_m + out["position"][rows, columns][chosen].astype(np.float64)
    found = paper.height_drawn(points / np.linalg.norm(points, axis=1, keepdims=True))
    away = np.linalg.norm(points - state.position_m, axis=1)
    # The position comes from a depth of 24 bits along the ray; rasterisers of GPUs snap vertices to 1/256 of a pixel.
    snapped = (
        0.0 if paper.gpu.caps.is_software else (state.tan_top - state.tan_bottom) / out["surface"].shape[0] / 256.0
    )
    assert (np.abs(found - (np.linalg.norm(points, axis=1) - 6.371e6)) <= 1e-3 + (1e-6 + snapped) * away).all()
    assert np.isnan(paper.height_drawn(-points[:1] / np.linalg.norm(points[0]))).all()
