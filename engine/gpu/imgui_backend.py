"""Dear ImGui (imgui-bundle 1.92 and later) drawn with moderngl, without PyOpenGL and without a window.

Every backend has an ImGui context of its own and makes it current only while it works, so that a host's own ImGui is
not disturbed. Input arrives as the neutral events of `engine.input`: windows and tests feed the same ones. imgui_bundle
is imported when the first backend is made, not before.
"""

from __future__ import annotations

import contextlib
import ctypes
import logging
from collections.abc import Callable, Iterable, Iterator
from typing import TYPE_CHECKING, Any

import moderngl
import numpy as np

from ..input import KEYS, Focus, InputEvent, KeyEvent, MouseButton, MouseMove, PointerLeft, Text, Wheel
from .errors import GpuError
from .imgui_type import ImGui

if TYPE_CHECKING:
    from .scope import GpuScope

__all__ = ["ImguiBackend"]

log = logging.getLogger(__name__)

_FAR_AWAY = -3.4e38  # ImGui's word for "no pointer": -FLT_MAX
_BUTTONS = {"left": 0, "right": 1, "middle": 2}
_ODD_KEYS = {"grave": "grave_accent", **{key: f"{key}_arrow" for key in ("left", "right", "up", "down")}}
_FIRST_BYTES = 1 << 16

_Command = tuple[int, tuple[int, int, int, int], int, int]
"""Texture, scissor, number of indices, the first of them."""


class ImguiBackend:
    """An ImGui context with its renderer.

        with ui.frame(size, dt_s, events=state.events) as imgui:
            imgui.text("hello")
        ui.render(framebuffer)

    Args:
        scope: owner of the GL objects.
        scale: size of text and widgets, in window units relative to a 96 dpi screen (Window.ui_scale).
        clipboard: functions that read and write the clipboard; without them copying works inside this context only.
        font_size: height of the text in window units at scale 1.
    """

    def __init__(
        self,
        scope: GpuScope,
        scale: float = 1.0,
        clipboard: tuple[Callable[[], str], Callable[[str], None]] | None = None,
        font_size: float = 15.0,
    ) -> None:
        try:
            from imgui_bundle import imgui
        except ImportError as error:
            raise GpuError(
                f"the user interface needs imgui-bundle 1.92 or later ({error}). Install it with `pip install "
                "'imgui-bundle>=1.92'`; on Debian also `apt install libgl1 libx11-6`."
            ) from error
        if not hasattr(imgui.BackendFlags_, "renderer_has_textures"):
            raise GpuError(f"the user interface needs imgui-bundle 1.92 or later, found {imgui.get_version()}")
        self.imgui: ImGui = imgui
        self.wants_mouse = self.wants_keyboard = self.wants_text = False
        self._scope = scope
        self._gpu = scope.gpu
        self._textures: dict[int, moderngl.Texture] = {}
        self._own_textures: set[int] = set()
        self._modifiers: set[str] = set()
        self._mouse = True
        self._released = False
        self._draw_data: Any = None
        self._commands: list[_Command] | None = None
        self._extent = (0, 0)
        self._scale = 1.0
        self.keys = {key: getattr(imgui.Key, _imgui_name(key)) for key in KEYS}
        previous = imgui.get_current_context()
        self._context = imgui.create_context()
        imgui.set_current_context(self._context)
        try:
            io = imgui.get_io()
            io.set_ini_filename("")
            io.set_log_filename("")
            io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
            platform = imgui.get_platform_io()
            limit = min(self._gpu.caps.max_texture_size, 8192)
            platform.renderer_texture_max_width = platform.renderer_texture_max_height = limit
            if clipboard is not None:
                read, write = clipboard
                platform.platform_get_clipboard_text_fn = lambda _context: read()
                platform.platform_set_clipboard_text_fn = lambda _context, text: write(text)
            if hasattr(io.fonts, "add_font_default_vector"):  # sharp at every size; the other one is a bitmap
                io.fonts.add_font_default_vector()
            style = imgui.get_style()
            imgui.style_colors_dark(style)
            style.font_size_base = font_size
            style.window_rounding = style.frame_rounding = style.grab_rounding = 4.0
            style.window_border_size = 0.0
            self.scale = scale
        finally:
            self._restore_context(previous)
        self._program = scope.program("ui/imgui.vert", "ui/imgui.frag")
        self._sampler = scope.sampler(filter="linear", wrap="clamp")
        self._state = self._gpu.state(blend="alpha")
        self._vertices = scope.buffer(reserve=_FIRST_BYTES, dynamic=True)
        self._indices = scope.buffer(reserve=_FIRST_BYTES, dynamic=True)
        self._array = scope.vertex_array(self._program, self._content(), self._indices, 4)

    # -- context -----------------------------------------------------------------------------------------------------
    @contextlib.contextmanager
    def current(self) -> Iterator[ImGui]:
        """Make this context ImGui's current one for a block; yields the imgui module."""
        if self._released:
            raise GpuError("this ImGui backend was released")
        previous = self.imgui.get_current_context()
        self.imgui.set_current_context(self._context)
        try:
            yield self.imgui
        finally:
            self._restore_context(previous)

    def _restore_context(self, previous: Any) -> None:
        imgui = self.imgui
        if previous is not None:
            imgui.set_current_context(previous)
        else:
            # "None current" cannot be set from Python, and matters: a context that a host creates later becomes
            # current only if no other one is. Destroying the current context leaves none.
            nobody = imgui.create_context()  # 3 us
            imgui.set_current_context(nobody)
            imgui.destroy_context(nobody)

    @property
    def scale(self) -> float:
        """Size of text and widgets relative to a 96 dpi screen."""
        return self._scale

    @scale.setter
    def scale(self, scale: float) -> None:
        if scale <= 0.0 or scale == self._scale:
            return
        with self.current() as imgui:
            style = imgui.get_style()
            style.scale_all_sizes(scale / self._scale)
            style.font_scale_dpi = scale
        self._scale = scale

    # -- input -------------------------------------------------------------------------------------------------------
    def feed(self, events: Iterable[InputEvent]) -> None:
        """Take in events; they count from the next frame on."""
        with self.current() as imgui:
            io = imgui.get_io()
            for event in events:
                self._feed_one(io, event)

    def _feed_one(self, io: Any, event: InputEvent) -> None:
        if isinstance(event, MouseMove):
            io.add_mouse_pos_event(event.x, event.y)
        elif isinstance(event, MouseButton):
            io.add_mouse_pos_event(event.x, event.y)
            io.add_mouse_button_event(_BUTTONS[event.button], event.pressed)
        elif isinstance(event, Wheel):
            io.add_mouse_wheel_event(event.dx, event.dy)
        elif isinstance(event, KeyEvent):
            side, _, modifier = event.key.partition("_")
            if side in ("left", "right") and modifier in ("ctrl", "shift", "alt", "super"):
                (self._modifiers.add if event.pressed else self._modifiers.discard)(event.key)
                held = bool({f"left_{modifier}", f"right_{modifier}"} & self._modifiers)
                io.add_key_event(getattr(self.imgui.Key, f"mod_{modifier}"), held)
            io.add_key_event(self.keys[event.key], event.pressed)
        elif isinstance(event, Text):
            io.add_input_characters_utf8(event.text)
        elif isinstance(event, Focus):
            io.add_focus_event(event.focused)
            if not event.focused:
                self._modifiers.clear()
        elif isinstance(event, PointerLeft):
            io.add_mouse_pos_event(_FAR_AWAY, _FAR_AWAY)

    # -- frame -------------------------------------------------------------------------------------------------------
    @contextlib.contextmanager
    def frame(
        self,
        size: tuple[int, int],
        dt_s: float = 1.0 / 60.0,
        pixel_ratio: float = 1.0,
        events: Iterable[InputEvent] = (),
        mouse: bool = True,
    ) -> Iterator[ImGui]:
        """A frame of user interface; yields the imgui module. `size` in window units, `pixel_ratio` pixels per unit.

        mouse: False while the game has captured the pointer: the user interface then sees no mouse at all.
        Afterwards `wants_mouse`, `wants_keyboard` and `wants_text` say what the user interface kept for itself, and
        `render` draws it. On an exception the frame is dropped.
        """
        with self.current() as imgui:
            io = imgui.get_io()
            io.display_size = imgui.ImVec2(float(size[0]), float(size[1]))
            io.display_framebuffer_scale = imgui.ImVec2(pixel_ratio, pixel_ratio)
            io.delta_time = max(float(dt_s), 1e-5)
            if not mouse and self._mouse:  # captured now: let go of what it was doing
                for button in _BUTTONS.values():
                    io.add_mouse_button_event(button, False)
                io.add_mouse_pos_event(_FAR_AWAY, _FAR_AWAY)
            self._mouse = mouse
            for event in events:
                if mouse or not isinstance(event, MouseMove | MouseButton | Wheel):
                    self._feed_one(io, event)
            imgui.new_frame()
            self.wants_mouse = bool(io.want_capture_mouse)
            self.wants_keyboard = bool(io.want_capture_keyboard)
            self.wants_text = bool(io.want_text_input)
            start = imgui.internal.ErrorRecoveryState()
            imgui.internal.error_recovery_store_state(start)
            try:
                yield imgui
            except BaseException:
                self._drop_frame(io, start)
                raise
            imgui.render()
            self._draw_data, self._commands = imgui.get_draw_data(), None

    def _drop_frame(self, io: Any, start: Any) -> None:
        """Close what an exception left open (windows, groups, pushed styles) and end the frame without a picture."""
        imgui = self.imgui
        self._draw_data = self._commands = None
        settings = io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log
        io.config_error_recovery_enable_assert = io.config_error_recovery_enable_debug_log = False
        imgui.internal.error_recovery_try_to_recover_state(start)
        io.config_error_recovery_enable_assert, io.config_error_recovery_enable_debug_log = settings
        imgui.end_frame()

    def render(self, framebuffer: moderngl.Framebuffer) -> None:
        """Draw the last frame over the whole framebuffer; may be called again for the same one. Leaves it bound, with
        default render state."""
        if self._draw_data is None:
            return
        if self._commands is None:
            with self.current():
                self._commands = self._take(self._draw_data)
        width, height = self._extent
        if width < 1 or height < 1:
            return
        viewport = framebuffer.viewport
        framebuffer.use()
        framebuffer.viewport = (0, 0, width, height)
        with self._gpu.frame():
            self._state.apply()
            self._sampler.use(0)
            self._draw(framebuffer, self._commands)
            self._sampler.clear(0)
        target: Any = framebuffer  # its type does not know that None turns the scissor off
        target.scissor, target.viewport = None, viewport

    def _take(self, data: Any) -> list[_Command]:
        """Take over a frame that was laid out: textures, vertices, and what to draw of them."""
        for texture in data.textures:
            if texture.status != self.imgui.ImTextureStatus.ok:
                self._update_texture(texture)
        size, scale, place = data.display_size, data.framebuffer_scale, data.display_pos
        scale_x, scale_y, x0, y0 = scale.x, scale.y, place.x, place.y
        self._extent = width, height = round(size.x * scale_x), round(size.y * scale_y)
        found: list[_Command] = []
        if width < 1 or height < 1:
            return found
        unit_x, unit_y = 2.0 / size.x, -2.0 / size.y
        self._program.set("u_scale", (unit_x, unit_y))
        self._program.set("u_offset", (-1.0 - x0 * unit_x, 1.0 - y0 * unit_y))
        for first, command in self._upload(data):
            left, top, right, bottom = command.clip_rect
            left, right = max(int((left - x0) * scale_x), 0), min(int((right - x0) * scale_x), width)
            top, bottom = max(int((top - y0) * scale_y), 0), min(int((bottom - y0) * scale_y), height)
            count = command.elem_count
            if right > left and bottom > top and count:
                scissor = (left, height - bottom, right - left, bottom - top)
                found.append((command.tex_ref.get_tex_id(), scissor, count, first + command.idx_offset))
        return found

    def _draw(self, framebuffer: moderngl.Framebuffer, commands: list[_Command]) -> None:
        bound = None
        for name, scissor, count, first in commands:
            texture = self._textures.get(name)
            if texture is None:  # forgotten while it was still shown: without it
                continue
            if texture is not bound:
                texture.use(0)
                bound = texture
            framebuffer.scissor = scissor
            self._array.render(moderngl.TRIANGLES, vertices=count, first=first)

    def _content(self) -> list[tuple[Any, ...]]:
        return [(self._vertices, "2f 2f 4f1", "in_position", "in_uv", "in_color")]

    def _upload(self, data: Any) -> list[tuple[int, Any]]:
        """All draw lists in one vertex and one index buffer; returns (first index of its list, command)."""
        vertices, indices, commands = [], [], []
        base_vertex = first = 0
        for draw_list in data.cmd_lists:
            vertex_count, index_count = draw_list.vtx_buffer.size(), draw_list.idx_buffer.size()
            if not index_count:
                continue
            vertices.append(_view(draw_list.vtx_buffer, vertex_count * self.imgui.VERTEX_SIZE))
            own = _view(draw_list.idx_buffer, index_count * self.imgui.INDEX_SIZE).view(f"u{self.imgui.INDEX_SIZE}")
            indices.append(own.astype(np.uint32) + np.uint32(base_vertex))
            commands += [(first, command) for command in draw_list.cmd_buffer]
            base_vertex += vertex_count
            first += index_count
        if not commands:
            return []
        vertex_data, index_data = np.concatenate(vertices), np.concatenate(indices)
        if vertex_data.nbytes > self._vertices.size or index_data.nbytes > self._indices.size:
            self._grow(vertex_data.nbytes, index_data.nbytes)
        self._vertices.orphan()
        self._indices.orphan()
        self._gpu.upload(self._vertices, vertex_data)
        self._gpu.upload(self._indices, index_data)
        return commands

    def _grow(self, vertex_bytes: int, index_bytes: int) -> None:
        old = self._vertices, self._indices
        if vertex_bytes > self._vertices.size:
            self._vertices = self._scope.buffer(reserve=2 * vertex_bytes, dynamic=True)
        if index_bytes > self._indices.size:
            self._indices = self._scope.buffer(reserve=2 * index_bytes, dynamic=True)
        self._array.set_buffers(self._content(), self._indices, 4)
        for buffer in old:
            if buffer not in (self._vertices, self._indices):
                self._scope.free(buffer)

    # -- textures ----------------------------------------------------------------------------------------------------
    def _update_texture(self, texture: Any) -> None:
        status = self.imgui.ImTextureStatus
        if texture.status == status.want_create:
            pixels = np.ascontiguousarray(texture.get_pixels_array()).tobytes()
            made = self._scope.texture((texture.width, texture.height), "rgba8", pixels, filter="linear")
            self._textures[made.glo] = made
            self._own_textures.add(made.glo)
            texture.set_tex_id(made.glo)
            texture.set_status(status.ok)
        elif texture.status == status.want_updates:
            pixels = texture.get_pixels_array().reshape(texture.height, texture.width, texture.bytes_per_pixel)
            target = self._textures[texture.tex_id]
            for r in texture.updates:
                part = np.ascontiguousarray(pixels[r.y : r.y + r.h, r.x : r.x + r.w])
                target.write(part.tobytes(), viewport=(r.x, r.y, r.w, r.h))
            texture.set_status(status.ok)
        elif texture.status == status.want_destroy and texture.unused_frames > 0:
            self._destroy_texture(texture)

    def _destroy_texture(self, texture: Any) -> None:
        made = self._textures.pop(texture.tex_id, None)
        self._own_textures.discard(texture.tex_id)
        if made is not None:
            self._scope.free(made)
        texture.set_tex_id(0)
        texture.set_status(self.imgui.ImTextureStatus.destroyed)

    def show(self, texture: moderngl.Texture) -> Any:
        """A reference for imgui.image(ref, size) to a 2D texture of somebody else's; `forget` it before its release."""
        self._textures[texture.glo] = texture
        return self.imgui.ImTextureRef(texture.glo)

    def forget(self, texture: moderngl.Texture) -> None:
        """Stop showing a texture."""
        if texture.glo not in self._own_textures:
            self._textures.pop(texture.glo, None)

    # -- end ---------------------------------------------------------------------------------------------------------
    def release(self) -> None:
        """Free the GL objects and the ImGui context."""
        if self._released:
            return
        with self.current() as imgui:
            self._draw_data = None
            for texture in imgui.get_platform_io().textures:
                if texture.ref_count == 1:
                    self._destroy_texture(texture)
            imgui.get_io().backend_flags &= ~imgui.BackendFlags_.renderer_has_textures
        self._released = True
        self.imgui.destroy_context(self._context)
        for thing in (self._array, self._vertices, self._indices, self._sampler, self._program):
            self._scope.free(thing)
        self._textures.clear()


def _imgui_name(key: str) -> str:
    if key.isdigit():
        return f"_{key}"
    return _ODD_KEYS.get(key, key.replace("numpad_", "keypad_" if not key[-1].isdigit() else "keypad"))


def _view(vector: Any, size: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    """The bytes of an ImVector, without a copy."""
    return np.frombuffer(memoryview((ctypes.c_ubyte * size).from_address(vector.data_address())), np.uint8)
