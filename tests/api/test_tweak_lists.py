"""Lists in the panel: explicit waves, layers of cloud and objects are added, changed, removed, and all of it undone."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from desk_kit import Desk as AppDesk
from desk_kit import Watching
from test_tweak import Desk, desk

import planetfall as pf
from planetfall.app.objects import upright
from planetfall.app.tweak_store import SceneStore
from planetfall.engine.input import MouseButton, MouseMove
from planetfall.systems.tweak import Edit, Workbench, list_editor
from planetfall.systems.tweak.list_editor import summary

__all__ = ["desk"]

pytestmark = pytest.mark.gpu


class Hands:
    """A panel with one component and a mouse that finds buttons by name."""

    def __init__(self, desk: Desk, monkeypatch: pytest.MonkeyPatch, part: Any) -> None:
        self.desk, self.part = desk, part
        self.boxes: dict[str, tuple[float, float]] = {}
        original = list_editor.draw_list
        from planetfall.systems.tweak import panel as module

        monkeypatch.setattr(module, "draw_list", lambda imgui, *rest: original(Watching(imgui, self.boxes), *rest))
        desk.panel.search = "wave" if isinstance(part, pf.Ocean) else "layers"
        desk.draw = lambda: desk.panel.draw(part)
        desk.step(frames=3)

    def click(self, label: str) -> None:
        self.desk.click(*self.boxes[label])
        self.desk.step(frames=2)


def test_waves_are_added_changed_copied_and_removed(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    sea = pf.Ocean()
    hands = Hands(desk, monkeypatch, sea)
    hands.click("add wave")
    assert sea.waves == (pf.Wave(),)
    hands.click("add wave")
    assert len(sea.waves) == 2 and "wave 2" in hands.boxes
    desk.slide("amplitude_m", 0.5, 0.52)  # a drag by some pixels of its own size
    assert sea.waves[0] == pf.Wave() and sea.waves[1].amplitude_m != 0.5
    changed = sea.waves[1]
    hands.click("copy wave")
    assert sea.waves == (pf.Wave(), changed, changed)
    hands.click("wave 1")
    hands.click("remove wave")
    assert sea.waves == (changed, changed)
    hands.click("reset wave")
    assert sea.waves == ()
    assert all(change.field == "waves" for found in desk.changes for change in found)


def test_a_list_that_would_not_fit_is_refused_with_its_reason(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    steep = pf.Wave(amplitude_m=5.0, wavelength_m=62.9, steepness=1.9)  # 0.95 of the steepness that there may be
    sea = pf.Ocean(waves=(steep,))
    hands = Hands(desk, monkeypatch, sea)
    hands.click("copy wave")
    assert sea.waves == (steep,)
    assert "intersects itself" in desk.panel.errors["Ocean", "waves"]


def test_a_thousand_waves_cost_no_more_than_ten(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn = []
    monkeypatch.setattr(list_editor, "summary", lambda item: drawn.append(item) or summary(item))
    sea = pf.Ocean(waves=tuple(pf.Wave(amplitude_m=1e-3, wavelength_m=50.0 + k) for k in range(1000)))
    Hands(desk, monkeypatch, sea)
    drawn.clear()
    desk.step(frames=1)
    assert 0 < len(drawn) < 12


def test_layers_of_cloud(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    clouds = pf.Clouds()
    hands = Hands(desk, monkeypatch, clouds)
    hands.click("add cloudlayer")
    first = clouds.layers[0]
    desk.slide("coverage", 0.6, 0.1)
    assert clouds.layers[0].coverage < 0.2 and first.coverage == 0.6, "the old layer is as it was, for undo"
    assert clouds.coverage == 0.6, "the first layer's own fields are others"


def test_undo_brings_back_a_list_bit_for_bit() -> None:
    with pf.load_scene("earth") as scene:
        bench = Workbench(SceneStore(scene))
        sea, before = scene.planet[pf.Ocean], scene.planet[pf.Ocean].waves
        sea.waves = (pf.Wave(amplitude_m=0.1 + 0.2),)
        assert bench.made("Ocean", [("waves", before, sea.waves)]) == ""
        kept = sea.waves
        assert bench.undo() == "Ocean.waves" and sea.waves == before
        assert bench.redo() == "Ocean.waves" and sea.waves == kept and sea.waves[0].amplitude_m == 0.1 + 0.2


@pytest.fixture
def flight(gpu: Any):
    made = AppDesk(gpu)
    made.app.time_runs = False
    made.app.go_to("near")
    yield made
    made.release()


def test_objects_are_added_moved_and_removed_with_undo(flight: AppDesk) -> None:
    app, scene = flight.app, flight.scene
    flight.press("f3")
    flight.click("Objects")
    flight.frames(2)
    bare = flight.picture()
    flight.click("add box")
    (box,) = scene.props
    assert box.name == "box 1" and box[pf.Shape].form == "box"
    seen = app.renderer.pick(app.camera, *(0.5 * n for n in app.renderer.size))
    assert seen is not None and seen[1] == "props", "it stands in the middle of the picture"
    assert (np.abs(flight.picture() - bare).max(axis=2) > 20).any()
    before = np.array(box[pf.Transform].position_m)
    flight.frames(2)
    flight.click("to the ground")
    up = before / np.linalg.norm(before)
    height = np.linalg.norm(box[pf.Transform].position_m) - scene.planet.radius_m
    assert height == pytest.approx(scene.planet.surface_height_m(up)[0] + 0.5 * box[pf.Shape].size_m[2], abs=0.01)
    flight.click("undo")
    np.testing.assert_array_equal(box[pf.Transform].position_m, before)
    flight.click("copy object")
    assert [prop.name for prop in scene.props] == ["box 1", "box 1"]
    flight.click("remove object")
    flight.frames(2)
    flight.click("remove object")
    assert scene.props == ()
    for count in (1, 2, 1, 0):
        flight.click("undo")
        assert len(scene.props) == count
    for count in (1, 2, 1, 0):
        flight.click("redo")
        assert len(scene.props) == count
    assert flight.window.ctx.error == "GL_NO_ERROR"


def test_fields_of_objects_are_undone_also_after_they_were_away() -> None:
    with pf.load_scene("moon") as scene:
        store = SceneStore(scene)
        bench = Workbench(store)
        prop = scene.add(pf.Transform((1.8e6, 0.0, 0.0)), pf.Shape("box"), name="hut")
        heading = store.object_heading(prop)
        assert store.object_heading(prop) == heading
        prop[pf.Shape].roughness = 0.3
        assert bench.made(f"{heading}/Shape", [("roughness", 0.8, 0.3)]) == ""
        from planetfall.app.tweak_store import PropParts, copied

        parts = PropParts("hut", tuple(copied(part) for part in prop.components()))
        assert bench.do([Edit(heading, "", parts, None)], "remove hut") == "" and scene.props == ()
        assert bench.undo() == "remove hut"
        (again,) = scene.props
        assert again[pf.Shape].roughness == 0.3 and again.name == "hut"
        assert bench.undo() == f"{heading}/Shape.roughness" and again[pf.Shape].roughness == 0.8
        scene.remove(again)  # the game's own doing
        assert bench.redo() and scene.props == ()


def test_upright_turns_z_to_the_vertical() -> None:
    rng = np.random.default_rng(5)
    for up in [*rng.normal(size=(20, 3)), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.0, -1.0])]:
        x, y, z, w = upright(up * 6e6)
        # The third column of the rotation matrix of a unit quaternion.
        turned = np.array([2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)])
        np.testing.assert_allclose(turned, up / np.linalg.norm(up), atol=1e-12)


def test_places_far_from_the_centre_are_typed_and_stay_exact(desk: Desk) -> None:
    where = pf.Transform((6371000.123456789, -12.5, 0.000244140625))
    desk.draw = lambda: desk.panel.draw(where)
    desk.step(frames=3)
    kept = where.position_m
    x0, y0, x1, y1 = desk.boxes["position_m"]
    desk.step(MouseMove(x0 + 20, (y0 + y1) / 2, 0, 0), frames=2)
    desk.step(MouseButton("left", True, x0 + 20, (y0 + y1) / 2))
    desk.step(MouseMove(x1 - 5, (y0 + y1) / 2, 0, 0), frames=2)
    desk.step(MouseButton("left", False, x1 - 5, (y0 + y1) / 2), frames=3)
    assert where.position_m == kept  # a drag marks text and moves no object
