"""The ImGui backend without a window: synthetic events in, pixels out."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import moderngl
import numpy as np
import pytest

from planetfall.engine.gpu import Gpu, GpuScope
from planetfall.engine.gpu.imgui_backend import ImguiBackend
from planetfall.engine.input import KEYS, Focus, InputEvent, KeyEvent, MouseButton, MouseMove, PointerLeft, Text, Wheel

pytestmark = pytest.mark.gpu

SIZE = (320, 200)


class Screen:
    """A backend, a framebuffer and a draw function: `step` runs one frame of it."""

    def __init__(self, scope: GpuScope, **options: Any) -> None:
        self.ui = ImguiBackend(scope, **options)
        self.target = scope.framebuffer([scope.texture(SIZE, "rgba8")])
        self.draw: Callable[[Any], None] = lambda imgui: None

    def step(self, *events: InputEvent, frames: int = 1) -> None:
        for number in range(frames):
            with self.ui.frame(SIZE, 1 / 60, events=events if number == 0 else ()) as imgui:
                imgui.set_next_window_pos(imgui.ImVec2(0, 0))
                imgui.set_next_window_size(imgui.ImVec2(*SIZE))
                imgui.begin("test", flags=imgui.WindowFlags_.no_decoration)
                self.draw(imgui)
                imgui.end()

    def click(self, x: float, y: float) -> None:
        self.step(MouseMove(x, y, 0, 0), frames=3)
        self.step(MouseButton("left", True, x, y), frames=2)
        self.step(MouseButton("left", False, x, y), frames=2)

    def pixels(self) -> np.ndarray[Any, Any]:
        self.target.use()
        self.target.clear()
        self.ui.render(self.target)
        return np.frombuffer(self.target.read(components=4), np.uint8).reshape(SIZE[1], SIZE[0], 4)[::-1]


@pytest.fixture
def screen(scope: GpuScope) -> Iterator[Screen]:
    made = Screen(scope)
    yield made
    made.ui.release()


def test_text_and_shapes_reach_the_pixels(screen: Screen) -> None:
    def draw(imgui: Any) -> None:
        imgui.text("Planetfall")
        imgui.get_window_draw_list().add_rect_filled(
            imgui.ImVec2(100, 100), imgui.ImVec2(200, 150), imgui.get_color_u32(imgui.ImVec4(1, 0, 0, 1))
        )

    screen.draw = draw
    screen.step(frames=2)
    picture = screen.pixels()
    assert (picture[110:140, 110:190, :3] == (255, 0, 0)).all()
    assert tuple(picture[99, 150, :3]) != (255, 0, 0)
    assert tuple(picture[151, 150, :3]) != (255, 0, 0)
    assert picture[:30, :110, :3].max() > 200  # glyphs
    assert len(np.unique(picture[:30, :110, 0])) > 10  # anti-aliased


def test_click_slider_and_text(screen: Screen) -> None:
    state: dict[str, Any] = {"clicks": 0, "value": 0.5, "text": ""}
    boxes: dict[str, tuple[float, float, float, float]] = {}

    def draw(imgui: Any) -> None:
        def remember(name: str) -> None:
            low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
            boxes[name] = (low.x, low.y, high.x, high.y)

        state["clicks"] += bool(imgui.button("press"))
        remember("button")
        imgui.set_next_item_width(200)
        _, state["value"] = imgui.slider_float("value", state["value"], 0.0, 1.0)
        remember("slider")
        _, state["text"] = imgui.input_text("text", state["text"])
        remember("text")

    screen.draw = draw
    screen.step(frames=2)
    x0, y0, x1, y1 = boxes["button"]
    screen.click((x0 + x1) / 2, (y0 + y1) / 2)
    assert state["clicks"] == 1
    x0, y0, _x1, y1 = boxes["slider"]
    y = (y0 + y1) / 2
    screen.step(MouseMove(x0 + 100, y, 0, 0), frames=2)
    screen.step(MouseButton("left", True, x0 + 100, y), frames=2)
    assert screen.ui.wants_mouse
    screen.step(MouseMove(x0 + 500, y, 400, 0), frames=2)
    screen.step(MouseButton("left", False, x0 + 500, y), frames=2)
    assert state["value"] == 1.0
    x0, y0, _x1, y1 = boxes["text"]
    screen.click(x0 + 5, (y0 + y1) / 2)
    assert screen.ui.wants_keyboard and screen.ui.wants_text
    screen.step(Text("héllo"), frames=3)
    screen.step(KeyEvent("backspace", True), KeyEvent("backspace", False), frames=3)
    assert state["text"] == "héll"
    screen.step(PointerLeft(), Wheel(0, 1), Focus(False), frames=2)


def test_clipboard(scope: GpuScope) -> None:
    board = {"text": "pasted"}
    screen = Screen(scope, clipboard=(lambda: board["text"], lambda text: board.update(text=text)))
    state = {"text": ""}

    def draw(imgui: Any) -> None:
        imgui.set_keyboard_focus_here()
        _, state["text"] = imgui.input_text("text", state["text"])

    screen.draw = draw
    screen.step(frames=3)
    screen.draw = lambda imgui: state.update(text=imgui.input_text("text", state["text"])[1])
    screen.step(KeyEvent("left_ctrl", True), KeyEvent("v", True), frames=4)
    screen.step(KeyEvent("v", False), frames=2)
    assert state["text"] == "pasted"
    screen.step(KeyEvent("a", True), KeyEvent("a", False), frames=4)
    screen.step(KeyEvent("x", True), KeyEvent("x", False), KeyEvent("left_ctrl", False), frames=4)
    assert (state["text"], board["text"]) == ("", "pasted")
    screen.ui.release()


def test_every_neutral_key_is_known(screen: Screen) -> None:
    """imgui takes one event of each key a frame; a key held is told from all others."""
    names = screen.ui.keys
    assert set(names) == KEYS and len({int(key) for key in names.values()}) == len(KEYS)
    down: set[str] = set()
    screen.draw = lambda imgui: down.update(key for key, name in names.items() if imgui.is_key_down(name))
    screen.step(*(KeyEvent(key, True) for key in sorted(KEYS)), frames=3)
    assert down == KEYS


def test_many_vertices_and_clipping(screen: Screen) -> None:
    def draw(imgui: Any) -> None:
        lines = imgui.get_window_draw_list()
        white = imgui.get_color_u32(imgui.ImVec4(1, 1, 1, 1))
        for i in range(30000):  # more than 16-bit indices and the first buffers hold
            x, y = i % 150, i // 150
            lines.add_rect_filled(imgui.ImVec2(x, y), imgui.ImVec2(x + 1, y + 1), white)
        lines.push_clip_rect(imgui.ImVec2(200, 50), imgui.ImVec2(250, 60))
        lines.add_rect_filled(imgui.ImVec2(160, 0), imgui.ImVec2(400, 400), white)
        lines.pop_clip_rect()

    screen.draw = draw
    screen.step()
    picture = screen.pixels()
    assert (picture[:200, :150, :3] == 255).mean() > 0.99
    outside = picture[:, 160:].copy()
    inside = outside[50:60, 40:90].copy()
    outside[50:60, 40:90] = 0
    assert (inside == 255).all()
    assert outside[..., :3].max() < 255


def test_pictures_of_others(screen: Screen, scope: GpuScope) -> None:
    texture = scope.texture((2, 1), "rgba8", bytes([0, 255, 0, 255, 0, 0, 255, 255]))
    reference = screen.ui.show(texture)
    screen.draw = lambda imgui: imgui.image(reference, imgui.ImVec2(100, 100))
    screen.step()
    picture = screen.pixels()
    assert tuple(picture[60, 20, :3]) == (0, 255, 0)
    assert tuple(picture[60, 100, :3]) == (0, 0, 255)
    screen.ui.forget(texture)
    screen.step()
    assert tuple(screen.pixels()[60, 20, :3]) != (0, 255, 0)


def test_scale_makes_text_larger(screen: Screen) -> None:
    widths = []
    screen.draw = lambda imgui: widths.append(imgui.calc_text_size("Planetfall").x)
    screen.step()
    screen.ui.scale = 2.0
    screen.step(frames=2)
    assert widths[-1] == pytest.approx(2 * widths[0], rel=0.1)
    screen.pixels()


def test_a_hosts_own_imgui_is_not_disturbed(scope: GpuScope) -> None:
    from imgui_bundle import imgui

    assert imgui.get_current_context() is None
    ours = Screen(scope)
    ours.step(frames=2)
    assert imgui.get_current_context() is None
    theirs = imgui.create_context()  # as a host does it: no other one is current, so this one is
    try:
        assert imgui.get_current_context() == theirs
        io = imgui.get_io()
        io.set_ini_filename("")
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        io.display_size = imgui.ImVec2(10, 10)
        imgui.new_frame()
        frame = imgui.get_frame_count()
        other = Screen(scope)
        ours.step(MouseMove(5, 5, 5, 5), frames=3)
        other.step(frames=2)
        ours.pixels()
        assert imgui.get_current_context() == theirs
        assert imgui.get_frame_count() == frame
        assert imgui.get_io().mouse_pos.x < 0
        imgui.end_frame()
        other.ui.release()
        ours.ui.release()
        assert imgui.get_current_context() == theirs
    finally:
        imgui.get_io().backend_flags &= ~imgui.BackendFlags_.renderer_has_textures
        imgui.destroy_context(theirs)


def test_exception_inside_a_frame(screen: Screen) -> None:
    from imgui_bundle import imgui

    with pytest.raises(ZeroDivisionError), screen.ui.frame(SIZE):
        imgui.begin("open")
        raise ZeroDivisionError
    assert imgui.get_current_context() is None
    screen.step(frames=2)
    assert screen.pixels().max() > 0


def test_release_frees_everything(gpu: Gpu) -> None:
    before = gpu.counts()
    scope = gpu.scope("ui test")
    screen = Screen(scope)
    screen.draw = lambda imgui: imgui.text("text")
    screen.step(frames=2)
    screen.pixels()
    scope.free(screen.target)
    screen.ui.release()
    screen.ui.release()
    assert set(gpu.counts().get("ui test", {})) <= {"texture"}  # the test's own colour texture
    scope.release()
    assert gpu.counts() == before
    assert gpu.ctx.error == "GL_NO_ERROR"


def test_size_zero_is_no_work(gpu: Gpu, screen: Screen) -> None:
    with screen.ui.frame((0, 0)):
        pass
    gpu.work.reset()
    screen.ui.render(screen.target)
    assert gpu.work.draws == 0


def test_state_afterwards_is_default(gpu: Gpu, screen: Screen) -> None:
    screen.draw = lambda imgui: imgui.text("text")
    screen.step()
    screen.pixels()
    for capability in (0x0BE2, 0x0C11, 0x0B71):
        assert gpu.gl.integer(capability) == 0
    assert screen.target.viewport == (0, 0, *SIZE)
    assert isinstance(gpu.ctx, moderngl.Context)


def test_planetfall_does_not_import_imgui() -> None:
    code = (
        "import sys, planetfall, planetfall.engine.hosts.window, planetfall.engine.hosts.foreign\n"
        "import planetfall.engine.gpu, planetfall.engine.gpu.imgui_backend, planetfall.systems.tweak\n"
        "bad = {'imgui_bundle', 'glfw', 'pyglet', 'moderngl_window'} & set(sys.modules)\n"
        "assert not bad, bad"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
