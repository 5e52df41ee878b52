"""Numbers over the picture: frame rate, frame time with its history, what was drawn, errors, and help for the keys.

Takes plain data, so that it knows neither the renderer nor the loop.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.gpu.imgui_type import ImGui

__all__ = ["FrameHistory", "HudData", "draw_hud"]

_MARGIN = 10.0
_ERROR_COLOR = (1.0, 0.5, 0.45, 1.0)
_ERROR_ALPHA = 0.85
_LONGEST_ERROR = 2000


class FrameHistory:
    """The last frame times in a ring: `add` one a frame."""

    def __init__(self, length: int = 120) -> None:
        # Twice, so that all of them lie in a row wherever the ring begins.
        self._ring: NDArray[np.float32] = np.zeros(2 * length, np.float32)
        self._length = length
        self._next = self._count = 0

    def add(self, frame_ms: float) -> None:
        self._ring[self._next] = self._ring[self._next + self._length] = frame_ms
        self._next = (self._next + 1) % self._length
        self._count = min(self._count + 1, self._length)

    @property
    def values_ms(self) -> NDArray[np.float32]:
        """Oldest first; good until the next `add`."""
        end = self._next + self._length
        return self._ring[end - self._count : end]

    @property
    def mean_ms(self) -> float:
        """Mean of the last 30 frames."""
        recent = self.values_ms[-30:].tolist()
        return sum(recent) / len(recent) if recent else 0.0

    @property
    def fps(self) -> float:
        mean = self.mean_ms
        return 1000.0 / mean if mean > 0.0 else 0.0


@dataclass
class HudData:
    """What the overlay shows; everything that is None or empty is left out.

    lines: further texts, such as altitude and speed. refining: what is still being made. message: what happened, in
    passing. errors: texts of one or more lines that stay. controls: (keys, what they do), shown as help.
    """

    fps: float | None = None
    frame_ms: float | None = None
    history_ms: Sequence[float] | NDArray[Any] = ()
    cells: int | None = None
    vertices: int | None = None
    triangles: int | None = None
    lines: Sequence[str] = ()
    refining: Sequence[str] = ()
    message: str = ""
    errors: Sequence[str] = ()
    controls: Sequence[tuple[str, str]] = ()

    @classmethod
    def of(cls, data: HudData | Mapping[str, Any]) -> HudData:
        """From a mapping with these names; unknown names are a TypeError that lists the known ones."""
        if isinstance(data, HudData):
            return data
        known = {f.name for f in dataclasses.fields(cls)}
        unknown = sorted(set(data) - known)
        if unknown:
            raise TypeError(f"HUD data: unknown {', '.join(unknown)}; known are {', '.join(sorted(known))}")
        return cls(**data)


def draw_hud(
    data: HudData | Mapping[str, Any], *, numbers: bool = True, help: bool = False, right: float = 0.0
) -> None:
    """Draw the overlay inside an ImGui frame: numbers at the top left, help at the top right, the rest below.

    right: width in window units that something else has at the right edge.
    """
    from imgui_bundle import imgui

    shown = HudData.of(data)
    size = imgui.get_io().display_size
    width = max(size.x - right, 0.3 * size.x)
    if numbers:
        _begin(imgui, "##numbers", _MARGIN, _MARGIN, 0.0, 0.0)
        _numbers(imgui, shown)
        imgui.end()
    if help and shown.controls:
        _begin(imgui, "##help", width - _MARGIN, _MARGIN, 1.0, 0.0)
        _table(imgui, "keys", shown.controls)
        imgui.end()
    bottom = size.y - _MARGIN
    if numbers and shown.refining:
        _begin(imgui, "##refining", _MARGIN, bottom, 0.0, 1.0)
        imgui.text("refining: " + ", ".join(shown.refining))
        imgui.end()
    if shown.message:
        _begin(imgui, "##message", width / 2.0, bottom, 0.5, 1.0)
        imgui.push_text_wrap_pos(0.9 * width)
        imgui.text(shown.message)
        imgui.pop_text_wrap_pos()
        bottom -= imgui.get_window_height() + _MARGIN
        imgui.end()
    if shown.errors:
        _begin(imgui, "##errors", width / 2.0, bottom, 0.5, 1.0, alpha=_ERROR_ALPHA)
        imgui.push_text_wrap_pos(0.9 * width)
        for error in shown.errors:
            imgui.text_colored(imgui.ImVec4(*_ERROR_COLOR), error[:_LONGEST_ERROR])
        imgui.pop_text_wrap_pos()
        imgui.end()


def _begin(imgui: ImGui, name: str, x: float, y: float, pivot_x: float, pivot_y: float, alpha: float = 0.6) -> None:
    """A window that is in nobody's way: it takes no input and sizes itself."""
    imgui.set_next_window_pos(imgui.ImVec2(x, y), imgui.Cond_.always, imgui.ImVec2(pivot_x, pivot_y))
    imgui.set_next_window_bg_alpha(alpha)
    imgui.begin(name, flags=_window_flags())


@cache
def _window_flags() -> int:
    from imgui_bundle import imgui

    flags = imgui.WindowFlags_
    return int(
        flags.no_decoration
        | flags.no_inputs
        | flags.no_nav
        | flags.always_auto_resize
        | flags.no_focus_on_appearing
        | flags.no_bring_to_front_on_focus
    )


def _numbers(imgui: ImGui, data: HudData) -> None:
    parts = []
    if data.fps is not None:
        parts.append(f"{data.fps:.0f} fps")
    if data.frame_ms is not None:
        parts.append(f"{data.frame_ms:.1f} ms")
    if parts:
        imgui.text("   ".join(parts))
    history = np.ascontiguousarray(data.history_ms, np.float32)
    if history.size > 1:
        em = imgui.get_font_size()
        top = max(float(history.max()) * 1.1, 1.0)
        imgui.plot_lines("##history", history, scale_min=0.0, scale_max=top, graph_size=imgui.ImVec2(14 * em, 2.5 * em))
    for name, count in (("cells", data.cells), ("vertices", data.vertices), ("triangles", data.triangles)):
        if count is not None:
            imgui.text(f"{count:,} {name}".replace(",", " "))
    for line in data.lines:
        imgui.text(line)


def _table(imgui: ImGui, name: str, rows: Sequence[tuple[str, str]]) -> None:
    if not imgui.begin_table(name, 2, imgui.TableFlags_.sizing_fixed_fit):
        return
    for left, right in rows:
        imgui.table_next_row()
        imgui.table_next_column()
        imgui.text(left)
        imgui.table_next_column()
        imgui.text(right)
    imgui.end_table()
