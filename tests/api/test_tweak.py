"""Panels and overlay without a window: the mouse is synthetic, the picture is looked at."""

# ruff: noqa: RUF009 - knob() is dataclasses.field() with metadata

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import imgui_bundle
import numpy as np
import pytest

from planetfall.components import Atmosphere, Exposure, Ocean, Planet, Sun, Terrain, TerrainQuality, knob
from planetfall.engine.gpu import GpuScope
from planetfall.engine.gpu.imgui_backend import ImguiBackend
from planetfall.engine.input import InputEvent, KeyEvent, MouseButton, MouseMove, Text
from planetfall.engine.settings import install
from planetfall.systems.tweak import Change, FrameHistory, HudData, Panel, PassTime, draw_hud, draw_passes

pytestmark = pytest.mark.gpu

SIZE = (480, 640)
Vector = tuple[float, float, float]


@dataclass
class Everything:
    """One field of each kind."""

    span: float = knob(2.0, 0.0, 10.0, "m", "A plain slider", cost="nothing")
    wide_m: float = knob(0.0, -1e5, 1e5, "m", "A drag")
    stretched: float = knob(1.0, 0.01, 100.0, "", "A logarithmic slider", log=True)
    huge_s: float = knob(5.0, -1e12, 1e12, "s", "Typed")
    count: int = knob(4, 1, 16, "", "A whole slider", group="numbers")
    seed: int = knob(1, 0, 2**31 - 1, "", "A whole field", group="numbers")
    power: int = knob(16, 4, 64, "", "A list of powers", group="numbers", power_of_two=True)
    on: bool = knob(True, help="A box")
    kind: str = knob("grid", help="A list", choices=("grid", "tree"), not_yet=("sphere",))
    name: str = knob("text", help="Free text")
    color: Vector = knob((0.2, 0.4, 0.6), 0.0, 1.0, "", "A colour", widget="color")
    place_m: Vector = knob((1.0, 2.0, 3.0), -100.0, 100.0, "m", "A vector")
    maybe_deg: float | None = knob(None, 10.0, 90.0, "deg", "May be off", excludes=("other",))
    other: float | None = knob(None, 0.0, 1.0, "", "Excluded by maybe_deg")
    cells: tuple[tuple[int, int], ...] = knob((), 0, 9, "", "Rows, given in Python")
    rule: Callable[[int], int] | None = knob(None, help="A function, given in Python")


install(Everything)


class Desk:
    """A panel with a mouse on it. `boxes` holds the screen rectangle of what was drawn for each field."""

    def __init__(self, scope: GpuScope, monkeypatch: pytest.MonkeyPatch) -> None:
        self.ui = ImguiBackend(scope)
        self.target = scope.framebuffer([scope.texture(SIZE, "rgba8")])
        self.panel = Panel()
        self.changes: list[Any] = []
        self.draw: Callable[[], Any] = lambda: None
        self.boxes: dict[str, tuple[float, float, float, float]] = {}
        from planetfall.systems.tweak import panel as module

        original = module.edit

        def recorded(imgui: Any, rule: Any, value: Any) -> Any:
            low = imgui.get_cursor_screen_pos()
            width, height = imgui.calc_item_width(), imgui.get_frame_height()
            self.boxes[rule.name] = (low.x, low.y, low.x + width, low.y + height)
            return original(imgui, rule, value)

        monkeypatch.setattr(module, "edit", recorded)

    def step(self, *events: InputEvent, frames: int = 2) -> None:
        for number in range(frames):
            with self.ui.frame(SIZE, 1 / 60, events=events if number == 0 else ()) as imgui:
                imgui.set_next_window_pos(imgui.ImVec2(0, 0))
                imgui.set_next_window_size(imgui.ImVec2(*SIZE))
                imgui.begin("panel", flags=imgui.WindowFlags_.no_decoration)
                found = self.draw()
                if found:
                    self.changes.append(found)
                imgui.end()

    def press(self, x: float, y: float) -> None:
        self.step(MouseMove(x, y, 0, 0), frames=3)
        self.step(MouseButton("left", True, x, y))

    def release(self, x: float, y: float) -> None:
        self.step(MouseMove(x, y, 0, 0))
        self.step(MouseButton("left", False, x, y))

    def click(self, x: float, y: float) -> None:
        self.press(x, y)
        self.release(x, y)

    def slide(self, field: str, start: float, end: float) -> None:
        """Drag along the field's widget, in shares of its width."""
        x0, y0, x1, y1 = self.boxes[field]
        y = (y0 + y1) / 2
        self.press(x0 + (x1 - x0) * start, y)
        self.release(x0 + (x1 - x0) * end, y)

    def reset(self, field: str) -> None:
        _x0, y0, x1, y1 = self.boxes[field]
        self.click(x1 + 16, (y0 + y1) / 2)

    def type_into(self, field: str, text: str) -> None:
        x0, y0, _x1, y1 = self.boxes[field]
        self.click(x0 + 10, (y0 + y1) / 2)
        self.step(KeyEvent("left_ctrl", True), KeyEvent("a", True), frames=4)
        self.step(KeyEvent("a", False), KeyEvent("left_ctrl", False), frames=4)
        self.step(Text(text), frames=3)
        self.step(KeyEvent("enter", True), KeyEvent("enter", False), frames=4)

    def pixels(self) -> np.ndarray[Any, Any]:
        self.target.use()
        self.target.clear()
        self.ui.render(self.target)
        return np.frombuffer(self.target.read(components=3), np.uint8).reshape(SIZE[1], SIZE[0], 3)[::-1]


@pytest.fixture
def desk(scope: GpuScope, monkeypatch: pytest.MonkeyPatch) -> Iterator[Desk]:
    made = Desk(scope, monkeypatch)
    yield made
    made.ui.release()


@pytest.fixture
def thing(desk: Desk) -> Everything:
    made = Everything()
    desk.draw = lambda: desk.panel.draw(made)
    desk.step(frames=3)
    assert desk.changes == []
    return made


def test_slider_and_reset(desk: Desk, thing: Everything) -> None:
    before = desk.pixels().copy()
    desk.slide("span", 0.2, 0.7)
    assert 6.0 < thing.span < 8.0
    assert all(isinstance(c, Change) and c.field == "span" for found in desk.changes for c in found)
    first, last = desk.changes[0][0], desk.changes[-1][0]
    assert (first.old, last.new) == (2.0, thing.span)
    after = desk.pixels().copy()
    x0, y0, x1, y1 = (int(v) for v in desk.boxes["span"])
    assert (before[y0:y1, x0:x1] != after[y0:y1, x0:x1]).any()  # the slider shows it
    amber = (after[y0:y1, :x0, 0] > 150) & (after[y0:y1, :x0, 2] < 120)
    assert amber.any()  # and the name is marked
    desk.slide("span", 0.7, 3.0)
    assert thing.span == 10.0  # never beyond its range
    desk.changes.clear()
    desk.reset("span")
    assert thing.span == 2.0
    assert desk.changes == [[Change("span", 10.0, 2.0)]]
    desk.step(MouseMove(400, 630, 0, 0), frames=30)
    assert not ((desk.pixels()[y0:y1, :x0, 0] > 150) & (desk.pixels()[y0:y1, :x0, 2] < 120)).any()


def test_logarithmic_slider_and_drag(desk: Desk, thing: Everything) -> None:
    desk.slide("stretched", 0.5, 0.75)
    assert 7.0 < thing.stretched < 14.0  # three quarters of four decades
    desk.slide("wide_m", 0.2, 0.7)
    assert 10.0 < thing.wide_m < 1000.0
    desk.slide("place_m", 0.1, 0.3)
    assert thing.place_m[0] > 1.0
    assert thing.place_m[1:] == (2.0, 3.0)


def test_typed_values(desk: Desk, thing: Everything) -> None:
    desk.type_into("huge_s", "123456789.5")
    assert thing.huge_s == 123456789.5
    desk.type_into("huge_s", "9e15")
    assert thing.huge_s == 1e12
    desk.type_into("name", "planet")
    assert thing.name == "planet"
    desk.type_into("seed", "77")
    assert thing.seed == 77


def test_whole_numbers_boxes_lists(desk: Desk, thing: Everything) -> None:
    desk.slide("count", 0.25, 0.99)
    assert thing.count in (15, 16)
    x0, y0, _x1, y1 = desk.boxes["on"]
    desk.click(x0 + 5, (y0 + y1) / 2)
    assert thing.on is False
    for field, row, expected in (("kind", 2, "tree"), ("power", 1, 4)):
        x0, y0, _x1, y1 = desk.boxes[field]
        height = y1 - y0
        desk.click(x0 + 20, (y0 + y1) / 2)
        desk.step(frames=3)
        desk.click(x0 + 20, y1 + height * (row - 0.4))
        assert getattr(thing, field) == expected, field


def test_optional_fields_exclude_each_other(desk: Desk, thing: Everything) -> None:
    thing.other = 0.5
    desk.step()
    x0, y0, _x1, y1 = desk.boxes["maybe_deg"]
    desk.click(x0 + 5, (y0 + y1) / 2)
    assert thing.maybe_deg == 10.0
    assert thing.other is None
    assert desk.changes == [[Change("maybe_deg", None, 10.0), Change("other", 0.5, None)]]
    desk.reset("maybe_deg")
    assert thing.maybe_deg is None


def test_what_is_given_in_python_is_counted_and_can_be_reset(desk: Desk, thing: Everything) -> None:
    before = desk.pixels().copy()
    thing.cells, thing.rule = ((1, 2), (3, 4)), abs
    desk.step(frames=3)
    after = desk.pixels().copy()
    for field in ("cells", "rule"):
        x0, y0, x1, y1 = (int(v) for v in desk.boxes[field])
        assert (before[y0:y1, x0:x1] != after[y0:y1, x0:x1]).any()
        desk.click(x0 + 5, (y0 + y1) / 2)
        assert desk.changes == []
    desk.reset("cells")
    desk.reset("rule")
    assert thing.cells == () and thing.rule is None


def test_color_keeps_untouched_digits(desk: Desk, thing: Everything) -> None:
    x0, y0, x1, y1 = desk.boxes["color"]
    y, third = (y0 + y1) / 2, (x1 - x0 - 25) / 3
    desk.press(x0 + 15, y)
    desk.release(x0 + 15 + third, y)
    assert thing.color[0] > 0.2
    assert thing.color[1:] == (0.4, 0.6)


def test_preset_is_what_reset_goes_back_to(desk: Desk) -> None:
    thing, preset = Everything(span=5.0), Everything(span=4.0)
    desk.draw = lambda: desk.panel.draw(thing, preset)
    desk.step(frames=3)
    desk.reset("span")
    assert thing.span == 4.0


def test_without_apply_nothing_is_assigned(desk: Desk) -> None:
    thing = Everything()
    desk.draw = lambda: desk.panel.draw(thing, apply=False)
    desk.step(frames=3)
    desk.slide("span", 0.2, 0.5)
    assert thing.span == 2.0
    assert desk.changes[-1][0].new > 3.0


def test_a_refused_value_is_shown_and_not_applied(desk: Desk) -> None:
    @dataclass
    class Direction:
        direction: Vector = knob((0.05, 0.0, 0.0), help="Where to", nonzero=True, widget="direction")

    install(Direction)
    thing = Direction()
    desk.draw = lambda: desk.panel.draw(thing)
    desk.step(frames=3)
    x0, y0, _x1, y1 = desk.boxes["direction"]
    y = (y0 + y1) / 2
    calm = desk.pixels().copy()
    # Dragging to exactly zero: the component says no.
    desk.press(x0 + 20, y)
    desk.step(MouseMove(x0 + 14, y, -6, 0))
    for x in np.arange(x0 + 14, x0 + 5, -0.5):
        desk.step(MouseMove(float(x), y, -1, 0))
        if desk.panel.errors:
            break
    assert desk.panel.errors
    assert thing.direction[0] != 0.0
    loud = desk.pixels()
    red = (loud[..., 0] > 180) & (loud[..., 2] < 140) & (calm[..., 0] < 180)
    assert red.any()


def test_search_and_only_changed(desk: Desk) -> None:
    things = {"first": Everything(), "second": Ocean(), "planet": Planet()}
    desk.draw = lambda: desk.panel.draw_all(things)
    desk.panel.search = "logarithmic"
    desk.step(frames=3)
    assert set(desk.boxes) == {"stretched"}
    desk.boxes.clear()
    desk.panel.search = "ocean sea level"
    desk.step(frames=2)
    assert set(desk.boxes) == {"sea_level_m"}
    desk.boxes.clear()
    desk.panel.search, desk.panel.only_changed = "", True
    things["second"].roughness = 0.5
    desk.step(frames=2)
    assert set(desk.boxes) == {"roughness"}
    desk.slide("roughness", 0.5, 0.9)
    assert desk.changes[-1]["second"][0].field == "roughness"


def test_every_component_can_be_drawn(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(imgui_bundle.imgui, "is_rect_visible", lambda size: True)
    kinds = (Atmosphere, Exposure, Ocean, Planet, Sun, Terrain, TerrainQuality)
    things = {kind.__name__: kind() for kind in kinds}
    desk.panel.search = " "
    desk.draw = lambda: [desk.panel.draw(thing) for thing in things.values() if desk.panel.draw(thing)]
    desk.step(frames=3)
    assert desk.changes == []
    assert {"radius_m", "seed", "direction", "rock_albedo", "ev100"} <= set(desk.boxes)
    assert desk.pixels().max() > 200


def test_rows_out_of_sight_take_their_room_without_being_drawn(desk: Desk, monkeypatch: pytest.MonkeyPatch) -> None:
    imgui, terrain, ends = imgui_bundle.imgui, Terrain(), []

    def draw() -> None:
        desk.panel.draw(terrain)
        ends.append(imgui.get_cursor_pos_y())

    desk.draw = draw
    desk.boxes.clear()
    desk.step(frames=3)
    few = set(desk.boxes)
    monkeypatch.setattr(imgui, "is_rect_visible", lambda size: True)
    desk.step(frames=3)
    assert few < set(desk.boxes) and len(set(ends[1:])) == 1


def test_numbers_of_many_sizes_are_dragged_by_a_part_of_their_size(desk: Desk) -> None:
    air = Atmosphere()
    before = air.rayleigh_scattering_per_m
    desk.draw = lambda: desk.panel.draw(air)
    desk.step(frames=3)
    desk.slide("rayleigh_scattering_per_m", 0.9, 0.99)  # along the third number
    assert before[2] < air.rayleigh_scattering_per_m[2] < 10 * before[2]
    assert air.rayleigh_scattering_per_m[:2] == before[:2]


def test_tooltip_tells_help_and_cost(desk: Desk, thing: Everything) -> None:
    x0, y0, _x1, y1 = desk.boxes["span"]
    bare = desk.pixels().copy()
    desk.step(MouseMove(x0 + 30, (y0 + y1) / 2, 0, 0), frames=60)
    shown = desk.pixels()
    assert (bare[int(y1) + 4 : int(y1) + 60] != shown[int(y1) + 4 : int(y1) + 60]).mean() > 0.05
    assert desk.changes == []


def test_hud_shows_what_it_is_given(desk: Desk) -> None:
    history = FrameHistory(8)
    for n in range(12):
        history.add(10.0 + n % 2)
    assert list(history.values_ms) == [10, 11] * 4
    assert history.fps == pytest.approx(1000 / 10.5)
    data = HudData(
        fps=history.fps,
        frame_ms=history.mean_ms,
        history_ms=history.values_ms,
        cells=120,
        vertices=34680,
        triangles=1234567,
        lines=["altitude 2.0 m"],
        controls=[("W A S D", "fly"), ("F1", "this help")],
        message="saved",
    )
    draws: dict[str, tuple[Any, bool, bool]] = {
        "all": (data, True, True),
        "none": (data, False, False),
        "help": ({"controls": [("F1", "help")]}, False, True),
        "plain": ({"fps": 60.0, "frame_ms": 16.7}, True, False),
        "broken": ({"errors": ["shader a.frag:3: no", "x" * 5000]}, False, False),
    }
    pictures = {}
    for name, (what, numbers, help_on) in draws.items():
        for _ in range(3):
            with desk.ui.frame(SIZE):
                draw_hud(what, numbers=numbers, help=help_on)
        pictures[name] = desk.pixels().copy()
        assert not desk.ui.wants_mouse

    def ink(name: str, left: bool) -> int:
        half = SIZE[0] // 2
        part = pictures[name][: SIZE[1] - 60]
        return int((part[:, :half] if left else part[:, half + 60 :]).max())

    assert ink("all", True) > 200
    assert ink("all", False) > 200
    assert ink("none", True) == ink("none", False) == 0
    assert pictures["none"][-60:].max() > 200  # the message
    red = pictures["broken"][-60:].reshape(-1, 3).astype(int)
    assert (red[:, 0] - red[:, 1]).max() > 80
    assert ink("help", True) == 0
    assert ink("help", False) > 200
    assert ink("plain", True) > 200
    with pytest.raises(TypeError, match="unknown cels; known are cells"):
        HudData.of({"cels": 3})


def test_passes_are_a_table(desk: Desk) -> None:
    passes = [
        PassTime("terrain.gbuffer", 0.5, 1.25, help="draws it"),
        PassTime("terrain.vertices", 0.0, skipped="unchanged"),
        PassTime("debug.wireframe", 0.0, skipped="culled: nobody reads it", culled=True),
    ]

    def ink(entries: list[PassTime], culled: bool) -> int:
        for _ in range(3):
            with desk.ui.frame(SIZE) as imgui:
                imgui.set_next_window_pos(imgui.ImVec2(0, 0))
                imgui.set_next_window_size(imgui.ImVec2(*SIZE))
                imgui.begin("passes")
                draw_passes(entries, culled=culled)
                imgui.end()
        return int((desk.pixels().max(axis=2) > 120).sum())

    assert 0 < ink([], False) < ink(passes, False) < ink(passes, True)


def test_mouse_captured_by_the_game(desk: Desk, thing: Everything) -> None:
    x0, y0, x1, y1 = desk.boxes["span"]
    x, y = (x0 + x1) / 2, (y0 + y1) / 2
    for events in ([MouseMove(x, y, 0, 0)], [MouseButton("left", True, x, y)], [], []):
        with desk.ui.frame(SIZE, events=events, mouse=False) as imgui:
            imgui.begin("panel")
            desk.panel.draw(thing)
            imgui.end()
    assert thing.span == 2.0
    assert not desk.ui.wants_mouse
