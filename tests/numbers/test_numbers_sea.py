"""Numbers that the project promises for the sea as it is drawn, against float64."""

from __future__ import annotations

import numpy as np
import pytest

import planetfall as pf
from planetfall.benchmarks.measure import sea

pytestmark = pytest.mark.gpu


@pytest.fixture(scope="module")
def earth():
    """Without waves: where the sea's level meets the ground, and how round it is."""
    scene = pf.load_scene("earth")
    scene.planet.remove(pf.Cover)
    scene.planet[pf.Ocean].wind_speed_m_s = scene.planet[pf.Ocean].swell_height_m = 0.0
    with pf.Renderer(scene, size=(320, 180), quality="high") as made:
        yield made


@pytest.fixture
def rng():
    return np.random.default_rng(17)


@pytest.mark.parametrize("name", ["space", "orbit", "high", "coast", "beach", "sea", "limb", "under"])
def test_coast_and_limb_are_within_a_pixel_of_the_true_ones(earth, rng, name):
    """As the ground itself: 99 % within one pixel. (Of the whole picture it is more: few pixels lie along an edge.)"""
    found = sea.sea_error(earth, pf.view(name), rng, most=1000, most_edge=700)
    assert found.edge.pixels >= 300
    assert found.edge.wrong_beyond <= 0.01
    # Fewer than a tenth of the pixels lie along edges: a tenth of the limit above.
    assert found.sampled.wrong_beyond <= 0.001
    # A line that is e pixels beside the true one puts e of every two pixels along it on the wrong side.
    assert found.edge.wrong <= 0.5, "on average less than a pixel off"
    # Two meshes cross within one triangle, and the longest edges are to be below 20 pixels.
    assert found.worst_off_px <= 20.0


@pytest.mark.parametrize("name", ["space", "orbit", "coast", "beach", "sea", "limb", "under"])
def test_the_sea_lies_at_its_level(earth, rng, name):
    """Within the pixel that the ground is allowed, and for nearly all of it within half of one: unseen."""
    found = sea.sea_error(earth, pf.view(name), rng, most=1500, most_edge=0)
    assert found.sea_pixels >= 100
    assert found.p99_px <= 0.5 and found.worst_px <= 1.0


def test_the_bed_stays_ground_under_water(earth, rng):
    """Where bed and surface meet far away, the bed is below the sea and in front of it."""
    found = sea.sea_error(earth, pf.view("under"), rng, most=1500)
    assert found.lost == 0


def test_ridges_do_not_turn_into_sea():
    """Next to a ridge pixels see water behind it: what is drawn as land and is land must not be coloured by that."""
    view = pf.view("beach")
    with pf.Renderer(pf.load_scene("earth"), size=(640, 360), quality="high") as renderer:
        surface = renderer.render(view, outputs=("surface",))["surface"]
        truth = sea.Truth(renderer, renderer.camera_state(view))
    rows, columns = np.nonzero(sea.edges(surface) & (surface == sea.SEA))
    true, _ = truth.look(np.stack([columns + 0.5, rows + 0.5], axis=1))
    # A coast e pixels towards the land turns e of the pixels along it into sea.
    assert len(rows) >= 500 and (true == sea.TERRAIN).mean() <= 0.125, "an eighth of a pixel on average"


def _cut_along(surface, truth, columns):
    """Where land and water meet along these columns' left edges: how many pixels of one side are truly of the other
    kind, three deep; and how many such places there are."""
    left, right = surface[:, columns - 1], surface[:, columns]
    both = np.isin(left, (sea.TERRAIN, sea.SEA)) & np.isin(right, (sea.TERRAIN, sea.SEA))
    rows, at = np.nonzero((left != right) & both)
    cut = np.zeros(len(rows), bool)
    for side, way in ((-1, -1), (0, 1)):
        wrong = np.ones(len(rows), bool)
        for deep in range(3):
            x = columns[at] + side + way * deep
            true, _ = truth.look(np.stack([x + 0.5, rows + 0.5], axis=1))
            wrong &= (true != surface[rows, x]) & np.isin(true, (sea.TERRAIN, sea.SEA))
        cut |= wrong
    return int(cut.sum()), len(rows)


def test_no_lake_ends_along_a_tile():
    """Coasts are asked tile by tile (16 pixels wide): what the meshes miss goes on past a tile's border."""
    places = (0.9786, -0.2042, 0.0248), (-0.0906, 0.2679, 0.9592), (-0.6902, -0.2271, 0.6871)
    with pf.Renderer(pf.load_scene("earth"), (640, 360), "medium", {"composite.antialiasing": "none"}) as renderer:
        cut = {name: np.zeros(2, int) for name in ("border", "inside")}
        for place in places:
            up = np.array(place) / np.linalg.norm(place)
            camera = pf.Camera(up * (6.371e6 + 8.0e5), -up, np.cross(up, [0.0, 0.0, 1.0]))
            renderer.settle(camera)
            surface = renderer.render(camera, outputs=("surface",))["surface"]
            truth = sea.Truth(renderer, renderer.camera_state(camera))
            for name, first in (("border", 16), ("inside", 8)):
                cut[name] += np.array(_cut_along(surface, truth, np.arange(first, 640, 16)))
    assert cut["border"][1] >= 1000
    assert cut["border"][0] <= cut["inside"][0] + 5


def test_a_wrong_picture_is_noticed(earth, rng, monkeypatch):
    """The measure itself: the same picture moved by three pixels, and a sea that is 2 m too high."""
    view = pf.view("beach")
    right = earth.render(view, outputs=("position", "surface"))
    moved = {name: np.concatenate([values[:3], values[:-3]]) for name, values in right.items()}
    monkeypatch.setattr(earth, "render", lambda *_, **__: moved)
    found = sea.sea_error(earth, view, rng, most=300, most_edge=100)
    assert found.edge.wrong_beyond > 0.3 and 2.0 <= found.worst_off_px <= 8.0
    raised = right["position"] + 2.0 * earth.camera_state(view).direction.astype(np.float32)
    monkeypatch.setattr(earth, "render", lambda *_, **__: {**right, "position": raised})
    found = sea.sea_error(earth, view, rng, most=500, most_edge=0)
    assert found.worst_px > 10.0


def test_truth_without_relief():
    """On a planet that is all sea the truth is the sphere alone: the limb where the tangent from the camera has it."""
    scene = pf.load_scene("earth")
    scene.planet[pf.Ocean].sea_level_m = 2e4
    with scene, pf.Renderer(scene, size=(64, 36), quality="low") as renderer:
        state = renderer.camera_state(pf.view("space"))
        truth = sea.Truth(renderer, state)
        angle = np.arcsin(truth.sea_radius_m / np.linalg.norm(state.position_m))
        rows = 18.0 + np.tan(angle) / (state.tan_top - state.tan_bottom) * 36.0 + np.array([-0.01, 0.01])
        found, distance = truth.look(np.stack([np.full(2, 32.0), rows], axis=1))
    assert found.tolist() == [sea.SEA, sea.NOTHING]
    assert distance[0] == pytest.approx(np.linalg.norm(state.position_m) * np.cos(angle), rel=1e-2)
    assert np.isinf(distance[1])


def test_dry_planets_are_refused(rng):
    with (
        pf.Renderer(pf.load_scene("moon"), size=(64, 36), quality="low") as renderer,
        pytest.raises(RuntimeError, match="no Ocean"),
    ):
        sea.sea_error(renderer, pf.view("space", renderer.scene.planet), rng)
