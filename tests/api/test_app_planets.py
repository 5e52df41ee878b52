"""Several planets in the settings window, clicked through synthetic events: knobs, orbits, planets that come and go."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from desk_kit import Desk

import planetfall as pf
from planetfall.app.planet_page import PlanetPage
from planetfall.engine.input import KeyEvent, MouseButton, MouseMove
from planetfall.scene.companions import bodies

pytestmark = pytest.mark.gpu

SIZE = (640, 480)
MOON_M = 1.7374e6


@pytest.fixture
def desk(gpu: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    """A globe of rock with a moon of rock and sea, which fills a third of the picture; nothing that takes long."""
    ground = pf.Terrain(highest_m=8000.0, lowest_m=-8000.0, layers=6, land_share=0.5)
    scene = pf.Scene("earth", {"planet": pf.Planet(), "terrain": ground}, preset="earth")
    rock = pf.Terrain(seed=7, highest_m=8000.0, lowest_m=-8000.0, layers=6, land_share=0.5)
    moon = pf.Scene("moon", {"planet": pf.Planet(radius_m=MOON_M), "terrain": rock, "ocean": pf.Ocean()})
    scene.companions.add(moon, pf.Orbit(distance_m=3e7, period_s=0.0))
    made = Desk(gpu, scene, {"composite.antialiasing": "none"})  # a picture rests at once
    made.app.time_runs = False
    camera = pf.Camera((1.5e7, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 0.0, 1.0), 30.0)
    made.app.place(camera, pf.Sun(direction=(-1.0, 0.3, 0.2)))
    from imgui_bundle import imgui

    heading = imgui.collapsing_header

    def recorded(label: str, *arguments: Any) -> Any:
        opened = heading(label, *arguments)
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        made.boxes["section " + label.rsplit("###", maxsplit=1)[-1]] = ((low.x + high.x) / 2, (low.y + high.y) / 2)
        return opened

    monkeypatch.setattr(imgui, "collapsing_header", recorded)
    made.press("f3")
    made.frames(2)
    yield made
    made.release()


def page_of(desk: Desk) -> PlanetPage:
    return desk.interface.settings.planets


def sections(desk: Desk) -> set[str]:
    return {name for name in desk.boxes if name.startswith("section ")}


def still(desk: Desk) -> np.ndarray[Any, Any]:
    """The picture without the interface, once the ground of both planets is there."""
    desk.rest()
    return desk.picture()


def moon_pixels(picture: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """Where something brighter than space is."""
    return picture.max(axis=2) > 25


def test_the_knobs_of_a_companion(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the mouse alone: choose the Moon, open its Orbit, drag a slider, see it, undo, reset."""
    from planetfall.systems.tweak import panel as module

    boxes: dict[str, tuple[float, float, float]] = {}
    original = module.edit

    def recorded(imgui: Any, rule: Any, value: Any) -> Any:
        low, width = imgui.get_cursor_screen_pos(), imgui.calc_item_width()
        boxes[rule.name] = (low.x, low.x + width, low.y + imgui.get_frame_height() / 2)
        return original(imgui, rule, value)

    monkeypatch.setattr(module, "edit", recorded)
    settings, orbit = desk.interface.settings, desk.scene.companions["moon"].orbit
    before = still(desk)
    assert moon_pixels(before).mean() > 0.05
    desk.click("##planet")
    desk.click("moon")
    assert page_of(desk).chosen == "moon"
    desk.click("section moon: Orbit")
    desk.frames(2)
    x0, x1, y = boxes["phase_deg"]
    desk.window.events = [MouseMove(0.5 * (x0 + x1), y, 0, 0)]
    desk.frames(2)
    desk.window.events = [MouseButton("left", True, 0.5 * (x0 + x1), y)]
    desk.frames()
    desk.window.events = [MouseMove(0.51 * x0 + 0.49 * x1, y, 0, 0)]
    desk.frames()
    desk.window.events = [MouseButton("left", False, 0.51 * x0 + 0.49 * x1, y)]
    desk.frames(2)
    assert orbit.phase_deg != 0.0 and len(settings.bench.history) == 1
    after = still(desk)
    assert (np.abs(after - before).max(axis=2) > 25).mean() > 0.02
    desk.window.events = [KeyEvent("left_ctrl", True), KeyEvent("z", True)]
    desk.frames()
    desk.window.events = [KeyEvent("z", False), KeyEvent("left_ctrl", False)]
    desk.frames(2)
    assert orbit.phase_deg == 0.0 and (still(desk) == before).all()
    desk.click("redo")
    assert orbit.phase_deg != 0.0 and (still(desk) == after).all()
    desk.click("copy")
    assert desk.window.clipboard.startswith('[[companions]]\nname = "moon"\n') and "phase_deg" in desk.window.clipboard
    desk.click("reset planet")
    assert orbit.phase_deg == 0.0 and (still(desk) == before).all()
    desk.click("Ocean")
    assert not desk.scene.planets["moon"].has(pf.Ocean)
    planets = desk.app.renderer.planets
    assert "ocean" not in planets["moon"].gpu.counts()
    assert (np.abs(still(desk) - before).max(axis=2) > 10).mean() > 0.01
    desk.click("Ocean")
    assert (still(desk) == before).all()


def test_what_is_searched_for_is_found_on_all_planets(desk: Desk) -> None:
    """And the button that flies to the chosen one."""
    page = page_of(desk)
    page.panel.search = "terrain seed"
    desk.boxes.clear()
    desk.frames(2)
    assert sections(desk) == {"section Terrain", "section moon: Terrain"}
    page.panel.search = ""
    page.panel.only_changed = True
    desk.scene.planets["moon"][pf.Terrain].seed = 8
    desk.boxes.clear()
    desk.frames(2)
    assert sections(desk) == {"section moon: Terrain"}
    desk.click("##planet")
    desk.click("moon")
    desk.click("fly to planet")
    assert desk.app.planets.crossing is not None and desk.app.planets.crossing.target == "moon"


def test_planets_come_and_go_with_their_passes_and_objects(desk: Desk) -> None:
    app, planets = desk.app, desk.app.renderer.planets
    desk.frames(2)
    before, picture = desk.app.renderer.memory_bytes, desk.picture()
    desk.click("add planet")
    desk.click("add asteroid")
    assert list(desk.scene.planets) == ["earth", "moon", "asteroid"] and page_of(desk).chosen == "asteroid"
    desk.frames(2)
    member = planets["asteroid"]
    assert member.gpu.counts() and sum(app.renderer.memory_bytes.values()) > sum(before.values())
    there = bodies(desk.scene, app.time_s)[2].centre_m
    assert desk.app.camera.forward @ there > 0.5 * np.linalg.norm(there)  # in front of the flight
    desk.click("remove planet")
    desk.frames(2)
    assert list(desk.scene.planets) == ["earth", "moon"] and page_of(desk).chosen == "earth"
    assert member.gpu.counts() == {}
    assert (desk.picture() == picture).all()
    desk.click("undo")
    desk.frames()
    assert "asteroid" in planets and planets["asteroid"] is not member
    desk.click("undo")
    desk.frames()
    assert list(planets) == ["earth", "moon"]
    # The last one takes with it what made the scene one of several: its passes.
    assert any(name.startswith("companions.") for name in desk.planned())
    desk.click("##planet")
    desk.click("moon")
    desk.click("remove planet")
    desk.frames(2)
    assert list(planets) == ["earth"] and not any(name.startswith("companions.") for name in desk.planned())
    assert not moon_pixels(desk.picture()).any()
    desk.click("reset all")
    desk.frames(2)
    assert (desk.picture() == picture).all()
    assert desk.window.ctx.error == "GL_NO_ERROR"


def test_objects_of_all_planets_are_listed_placed_and_removed(desk: Desk) -> None:
    """Grouped by their planets; new ones are those of the planet below."""
    scene, app = desk.scene, desk.app
    moon = scene.companions["moon"].scene
    hut = scene.add(pf.Transform((0.0, 7e6, 0.0)), pf.Shape("box", (100.0, 100.0, 100.0)), name="hut")
    rover = moon.add(pf.Transform((0.0, 2e6, 0.0)), pf.Shape("box", (50.0, 50.0, 50.0)), name="rover")
    desk.click("Objects")
    desk.frames(2)
    assert desk.boxes["hut"][1] < desk.boxes["rover"][1]
    desk.click("rover")
    desk.frames(2)
    desk.click("to the ground")
    up = np.array([0.0, 1.0, 0.0])
    height = np.linalg.norm(rover[pf.Transform].position_m) - MOON_M
    assert height == pytest.approx(moon.planet.surface_height_m(up)[0] + 25.0, abs=0.01)
    desk.click("undo")
    assert rover[pf.Transform].position_m == (0.0, 2e6, 0.0)
    desk.click("copy object")
    assert [prop.name for prop in moon.props] == ["rover", "rover"] and scene.props == (hut,)
    for left in (1, 0):
        desk.frames(2)
        desk.click("remove object")
        assert len(moon.props) == left and scene.props == (hut,)
    for button, counts in (("undo", (1, 2, 1)), ("redo", (2, 1, 0)), ("undo", (1,))):
        for count in counts:
            desk.click(button)
            assert len(moon.props) == count and scene.props == (hut,)
    desk.frames(2)
    desk.click("rover")
    desk.frames(2)
    desk.click("fly there")
    assert app.planets.crossing is not None and app.planets.crossing.target == "moon"
    app.place(pf.Camera.at(10.0, 20.0, 3e5, 0.0, -89.0, planet="moon"), pf.Sun(direction=(-1.0, 0.3, 0.2)))
    desk.frames(2)
    assert app.planets.name == "moon"
    desk.click("add box")
    assert [prop.name for prop in moon.props] == ["rover", "box 1"] and scene.props == (hut,)
    seen = app.renderer.pick(app.camera, *(0.5 * n for n in app.renderer.size))
    assert seen is not None and seen[1] == "props", "it stands in the middle of the picture"
    assert desk.window.ctx.error == "GL_NO_ERROR"
