"""The flight's interface and its settings window, with the real renderer, clicked through synthetic events."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from desk_kit import SIZE, Desk, turn

import planetfall as pf
from planetfall.app.interface import length, place
from planetfall.engine.input import KeyEvent, MouseButton, MouseMove
from planetfall.render import renderer as renderer_module

pytestmark = pytest.mark.gpu


@pytest.fixture
def desk(gpu: Any) -> Iterator[Desk]:
    made = Desk(gpu)
    made.app.time_runs = False
    yield made
    made.release()


def test_numbers_help_and_panels_are_drawn(desk: Desk, gpu: Any) -> None:
    bare = desk.picture()
    shown = desk.app.shown
    shown.help = shown.numbers = True
    desk.frames(3)
    changed = np.abs(desk.pixels() - bare).max(axis=2) > 40
    assert changed[:100, :200].any() and changed[:200, 400:].any()
    assert shown.stats["triangles"] > 1000
    shown.help = shown.numbers = False
    desk.press("f3")
    desk.frames(2)
    assert (np.abs(desk.pixels() - bare).max(axis=2) > 20)[:, 400:].mean() > 0.5
    desk.window.events = [MouseMove(500, 300, 0, 0)]
    desk.frames()
    desk.window.events = [MouseButton("left", True, 500, 300)]
    desk.frames()
    assert not desk.window.mouse_exclusivity  # the panel took the click
    desk.window.events = [MouseButton("left", False, 500, 300), MouseMove(50, 400, 0, 0)]
    desk.frames()
    desk.window.events = [MouseButton("left", True, 50, 400)]
    desk.frames()
    assert desk.window.mouse_exclusivity
    # From input to picture: what moves before a frame shows in that frame.
    desk.app.shown.panels = False
    desk.rest()
    still = desk.pixels()
    desk.frames()
    assert (np.abs(desk.pixels() - still).max(axis=2) > 20).mean() < 0.001
    desk.window.events = [MouseMove(50, 400, 120, 0)]
    desk.frames(1)
    assert (np.abs(desk.pixels() - still).max(axis=2) > 20).mean() > 0.02
    assert gpu.ctx.error == "GL_NO_ERROR"


def test_without_anything_to_show_imgui_does_not_run(desk: Desk, gpu: Any) -> None:
    desk.frames(3)
    assert desk.interface.ui is None and "ui" not in gpu.counts()
    desk.press("f3")
    assert desk.interface.ui is not None
    desk.app.shown.panels = False
    desk.frames()
    ui = desk.interface.ui
    desk.interface.ui = None  # would be asked for, if it ran
    desk.frames(2)
    desk.interface.ui = ui


def test_who_does_nothing_sees_the_last_layout_drawn_again(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """Twenty layouts a second; in every frame where there is input, or something else to show."""
    desk.app.shown.numbers = True
    desk.frames(3)
    ui = desk.interface.ui
    laid_out: list[float] = []
    plain = ui.frame

    def frame(size: Any, dt_s: float, *arguments: Any, **given: Any) -> Any:
        laid_out.append(dt_s)
        return plain(size, dt_s, *arguments, **given)

    monkeypatch.setattr(ui, "frame", frame)
    desk.frames(30)
    assert len(laid_out) == 10 and sum(laid_out) == pytest.approx(0.5)
    before = desk.pixels()
    desk.frames(1)
    assert (np.abs(desk.pixels() - before)[:100, :200].max(axis=2) < 40).mean() > 0.9  # drawn in each frame
    laid_out.clear()
    desk.app.say("hello")
    desk.frames(2)
    assert len(laid_out) == 2
    desk.app.shown.panels = True
    desk.frames(40)
    laid_out.clear()
    desk.frames(30)
    assert len(laid_out) == 10
    for x in range(10):
        desk.window.events = [MouseMove(500, 300 + x, 0, 0)]
        desk.frames(1)
    assert len(laid_out) == 20
    desk.window.events = [KeyEvent("left_ctrl", True)]
    for _ in range(30):  # held, the keyboard is the settings' in frames between as well
        desk.frames(1)
        assert not desk.window.state.keys_held


def test_a_knob_changes_the_planet_in_the_next_frame_and_reset_brings_it_back(desk: Desk) -> None:
    desk.press("f3")
    before = desk.picture()
    turn(desk, "Terrain", "seed", 4)
    other = desk.picture()
    assert (np.abs(before - other).max(axis=2) > 30).mean() > 0.05
    desk.frames(2)
    desk.click("reset all")
    assert desk.scene.planet[pf.Terrain].seed != 4
    assert (before == desk.picture()).all()
    desk.click("undo")
    assert desk.scene.planet[pf.Terrain].seed == 4 and (other == desk.picture()).all()
    desk.click("undo")
    assert (before == desk.picture()).all()
    desk.click("redo")
    assert (other == desk.picture()).all()


def test_a_slider_is_dragged_and_undone_bit_for_bit(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the mouse alone: open Ocean, drag a slider, Ctrl Z."""
    from planetfall.systems.tweak import panel as module

    boxes: dict[str, tuple[float, float, float]] = {}
    original = module.edit

    def recorded(imgui: Any, rule: Any, value: Any) -> Any:
        low, width = imgui.get_cursor_screen_pos(), imgui.calc_item_width()
        boxes[rule.name] = (low.x, low.x + width, low.y + imgui.get_frame_height() / 2)
        return original(imgui, rule, value)

    monkeypatch.setattr(module, "edit", recorded)
    desk.app.go_to("coast")
    desk.press("f3")
    desk.rest()
    before = desk.picture()
    settings = desk.interface.settings
    settings.panel.search = "roughness ocean"
    desk.frames(3)
    sea = desk.scene.planet[pf.Ocean]
    first = sea.roughness
    x0, x1, y = boxes["roughness"]
    steps = len(settings.bench.history)
    desk.window.events = [MouseMove(x0 + 5, y, 0, 0)]
    desk.frames(2)
    desk.window.events = [MouseButton("left", True, x0 + 5, y)]
    desk.frames()
    seen = []
    for share in (0.2, 0.5, 0.8):
        desk.window.events = [MouseMove(x0 + share * (x1 - x0), y, 0, 0)]
        desk.frames()
        seen.append(sea.roughness)
    desk.window.events = [MouseButton("left", False, x0 + 0.8 * (x1 - x0), y)]
    desk.frames(2)
    assert first < seen[1] < seen[2] == sea.roughness
    assert len(settings.bench.history) == steps + 1
    rough = desk.picture()
    assert (before != rough).any()
    desk.window.events = [KeyEvent("left_ctrl", True), KeyEvent("z", True)]
    desk.frames()
    desk.window.events = [KeyEvent("z", False), KeyEvent("left_ctrl", False)]
    desk.frames(2)
    assert sea.roughness == first
    assert (before == desk.picture()).all()


def test_scenes_are_saved_and_loaded_as_one_step(desk: Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLANETFALL_PRESETS", str(tmp_path / "mine"))
    desk.press("f3")
    settings, app = desk.interface.settings, desk.app
    turn(desk, "Ocean", "roughness", 0.5)
    assert settings.save(app, "stormy") and (tmp_path / "mine/stormy.toml").exists()
    assert not settings.save(app, "earth") and "built-in" in app.shown.message
    assert not settings.save(app, "../x") and not settings.save(app, " ")
    turn(desk, "Ocean", "roughness", 0.25)
    assert settings.save(app, "stormy")
    assert "roughness = 0.5" in (tmp_path / "mine/stormy.toml.old").read_text()
    altitude = app.ship.altitude_m
    desk.click("##preset")
    desk.click("mars")
    assert not desk.scene.planet.has(pf.Ocean) and desk.scene.planet.radius_m == pytest.approx(3.39e6, rel=0.01)
    assert app.ship.altitude_m == pytest.approx(altitude, rel=1e-6)
    assert not any(name.startswith("ocean.") for name in desk.ran())
    assert settings.load(app, "stormy") and desk.scene.planet[pf.Ocean].roughness == 0.25
    desk.frames(2)
    desk.click("undo")
    desk.click("undo")
    assert desk.scene.planet[pf.Ocean].roughness == 0.25 and desk.scene.planet.radius_m > 6e6
    (tmp_path / "mine/two.toml").write_text("base = 'earth'\n[[companions]]\nbase = 'moon'\n")
    assert settings.load(app, "two") and app.shown.message == "loaded two" and list(desk.scene.planets)[1:] == ["moon"]
    (tmp_path / "mine/broken.toml").write_text("[ocean]\nroughness = 7.0\n")
    kept = settings.bench.copy()
    assert not settings.load(app, "broken") and "roughness" in settings.wrong
    assert settings.bench.copy() == kept


def test_what_differs_is_copied_as_toml(desk: Desk) -> None:
    desk.press("f3")
    desk.click("copy")
    assert desk.window.clipboard == "# nothing differs from the preset\n"
    turn(desk, "Ocean", "roughness", 0.5)
    desk.click("Stars")
    desk.click("copy")
    assert desk.window.clipboard == "# without [stars]\n[ocean]\nroughness = 0.5\n"
    desk.click("ab")
    turn(desk, "Ocean", "roughness", 0.75)
    desk.click("ab")
    assert desk.scene.planet[pf.Ocean].roughness == 0.5
    desk.click("ab")
    assert desk.scene.planet[pf.Ocean].roughness == 0.75


def test_parts_are_taken_off_and_put_back(desk: Desk) -> None:
    desk.press("f3")
    with_sea = desk.ran()
    desk.scene.planet[pf.Ocean].sea_level_m = 50.0
    desk.click("Ocean")
    assert not desk.scene.planet.has(pf.Ocean)
    assert not any(name.startswith("ocean.") for name in desk.ran())
    assert "ocean" not in desk.app.renderer.gpu.counts()
    desk.click("Ocean")
    assert desk.scene.planet[pf.Ocean].sea_level_m == 50.0  # as it was
    assert desk.ran() - {"ocean.vertices", "ocean.cull"} >= with_sea - {
        name for name in with_sea if name.endswith((".vertices", ".cull", "galaxy_map"))
    }


def test_debug_views_places_and_flights_are_chosen_from_lists(desk: Desk) -> None:
    desk.press("f3")
    desk.click("View")
    plain = desk.picture()
    desk.click("shows")
    desk.click("normals")
    assert desk.app.debug_view == "normals" and "debug.view" in desk.planned()
    assert (np.abs(plain - desk.picture()).max(axis=2) > 40).mean() > 0.2
    desk.click("shows")
    assert {"gbuffer.depth", "scene.radiance", "error_px", "wireframe"} <= set(desk.boxes)
    desk.click("off")
    assert "debug.view" not in desk.planned() and "debug" not in desk.app.renderer.gpu.counts()
    desk.click("go to")
    desk.click("space")
    assert desk.app.ship.altitude_m == pytest.approx(3.6e7, rel=1e-3)
    desk.click("play")
    desk.click("descent")
    assert desk.app.playing is not None
    desk.click("stop")
    assert desk.app.playing is None


def test_quality_is_changed_in_flight(desk: Desk) -> None:
    desk.press("f3")
    desk.frames(3)
    desk.click("Quality")
    few = desk.app.renderer.stats["vertices"]
    desk.click("preset")
    desk.click("medium")
    assert desk.app.quality == "medium" and desk.made[0].released
    desk.frames(2)
    assert desk.app.renderer.stats["vertices"] > few
    settings = desk.interface.settings
    turn(desk, "Quality.terrain", "edge_px", 30.0)
    desk.frames(2)
    assert desk.app.overrides == {"terrain.edge_px": 30.0}
    assert desk.app.renderer.settings["terrain.edge_px"] == 30.0
    desk.click("undo")
    assert desk.app.overrides == {} and desk.app.quality == "medium"
    desk.click("undo")
    assert desk.app.quality == "low" and settings.bench.base["Quality"].preset == "low"
    desk.click("redo")
    assert desk.app.quality == "medium"


def test_passes_are_listed_with_their_times(desk: Desk) -> None:
    desk.press("f3")
    desk.frames(2)
    desk.click("Profiler")
    desk.click("GPU times")
    desk.frames(5)
    assert desk.app.renderer.graph.gpu_timing
    assert any(report.gpu_ms is not None for report in desk.app.renderer.passes())


def test_values_that_do_not_fit_together_are_taken_back(desk: Desk) -> None:
    terrain = desk.scene.planet[pf.Terrain]
    terrain.lowest_m = 8999.0
    assert desk.app.validate()
    terrain.highest_m = 100.0
    assert not desk.app.validate()
    assert "has to be below highest_m" in desk.app.shown.message


def test_a_broken_shader_keeps_the_last_good_one_and_names_file_and_line(
    gpu: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assets = tmp_path / "assets"
    shutil.copytree(pf.ASSETS / "shaders", assets / "shaders")
    monkeypatch.setattr(renderer_module, "ASSETS", assets)
    desk = Desk(gpu)
    try:
        desk.app.time_runs = False
        good = desk.picture()
        shader = assets / "shaders/composite/tonemap.frag"
        text = shader.read_text()
        lines = text.splitlines()
        at = next(k for k, line in enumerate(lines) if line.startswith("void main"))
        shader.write_text("\n".join([*lines[: at + 1], "    float broken = ;", *lines[at + 1 :]]))
        desk.app.reload_shaders()
        desk.frames()
        assert f"composite/tonemap.frag:{at + 2}" in desk.app.shown.shader_errors[0]
        assert (np.abs(desk.pixels() - good).max(axis=2) > 8).mean() < 0.5  # the picture is still there, with a box
        desk.frames(2)
        red = desk.pixels()[SIZE[1] // 2 :]
        assert ((red[..., 0] - red[..., 1]) > 80).sum() > 100  # the overlay
        shader.write_text(text + "\n// mended\n")
        desk.app.reload_shaders()
        assert desk.app.shown.shader_errors == () and "tonemap.frag" in desk.app.shown.message
        assert (np.abs(desk.picture() - good).max(axis=2) > 2).mean() < 0.01
    finally:
        desk.release()


def test_pictures_carry_all_settings(desk: Desk, tmp_path: Path) -> None:
    from planetfall.systems.capture import read_png_settings

    desk.frames()
    target = desk.app.save_picture(tmp_path)
    assert target is not None
    settings = read_png_settings(target)
    assert settings["quality"] == "low" and settings["components"]["terrain"]["seed"] >= 0
    assert settings["components"]["sun"]["elevation_deg"] == desk.scene.sun.elevation_deg


def test_nothing_is_left_behind(gpu: Any) -> None:
    before = gpu.counts()
    desk = Desk(gpu)
    desk.frames(2)
    desk.release()
    assert gpu.counts() == before and gpu.ctx.error == "GL_NO_ERROR"


def test_texts() -> None:
    assert [length(m) for m in (1.75, 250, 12345, 3.6e7)] == ["1.8 m", "250 m", "12.3 km", "36 000 km"]
    assert place(0.0, -1.0, -1.0) == "45.0000 S  90.0000 W"
