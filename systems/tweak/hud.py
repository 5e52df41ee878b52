"""Numbers over the picture: frame rate, frame time with its history, what was drawn, passes, and the help for the keys.

Takes plain data, so that it knows neither the renderer nor the loop.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["FrameHistory", "HudData", "PassTime", "draw_hud"]

_MARGIN = 10.0
_SKIPPED = (0.55, 0.55, 0.55, 1.0)


class FrameHistory:
    """The last frame times in a ring: `add` one a frame."""

    def __init__(self, length: int = 120) -> None:
        self._ring: NDArray[np.float32] = np.zeros(length, np.float32)
        self._next = self._count = 0

    def add(self, frame_ms: float) -> None:
        self._ring[self._next] = frame_ms
        self._next = (self._next + 1) % len(self._ring)
        self._count = min(self._count + 1, len(self._ring))

    @property
    def values_ms(self) -> NDArray[np.float32]:
        """Oldest first."""
        return np.roll(self._ring, -self._next)[len(self._ring) - self._count :]

    @property
    def mean_ms(self) -> float:
        """Mean of the last 30 frames."""
        recent = self.values_ms[-30:]
        return float(recent.mean()) if len(recent) else 0.0

    @property
    def fps(self) -> float:
        mean = self.mean_ms
        return 1000.0 / mean if mean > 0.0 else 0.0


@dataclass(frozen=True)
class PassTime:
    """A pass of the last frame; gpu_ms is None where it was not timed, skipped says why it did not run ("": it ran)."""

    name: str
    cpu_ms: float
    gpu_ms: float | None = None
    skipped: str = ""


@dataclass
class HudData:
    """What the overlay shows; everything that is None or empty is left out.

    lines: further texts, such as altitude and speed. controls: (keys, what they do), shown as help.
    """

    fps: float | None = None
    frame_ms: float | None = None
    history_ms: Sequence[float] | NDArray[Any] = ()
    cells: int | None = None
    vertices: int | None = None
    triangles: int | None = None
    passes: Sequence[PassTime] = ()
    lines: Sequence[str] = ()
    message: str = ""
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


def draw_hud(data: HudData | Mapping[str, Any], *, numbers: bool = True, help: bool = False) -> None:
    """Draw the overlay inside an ImGui frame: numbers at the top left, help at the top right, the message below."""
    from imgui_bundle import imgui

    shown = HudData.of(data)
    size = imgui.get_io().display_size
    if numbers:
        _begin(imgui, "##numbers", _MARGIN, _MARGIN, 0.0, 0.0)
        _numbers(imgui, shown)
        imgui.end()
    if help and shown.controls:
        _begin(imgui, "##help", size.x - _MARGIN, _MARGIN, 1.0, 0.0)
        _table(imgui, "keys", shown.controls)
        imgui.end()
    if shown.message:
        _begin(imgui, "##message", size.x / 2.0, size.y - _MARGIN, 0.5, 1.0)
        imgui.text(shown.message)
        imgui.end()


def _begin(imgui: Any, name: str, x: float, y: float, pivot_x: float, pivot_y: float) -> None:
    """A window that is in nobody's way: it takes no input and sizes itself."""
    flags = imgui.WindowFlags_
    imgui.set_next_window_pos(imgui.ImVec2(x, y), imgui.Cond_.always, imgui.ImVec2(pivot_x, pivot_y))
    imgui.set_next_window_bg_alpha(0.45)
    imgui.begin(
        name,
        flags=flags.no_decoration
        | flags.no_inputs
        | flags.no_nav
        | flags.always_auto_resize
        | flags.no_focus_on_appearing
        | flags.no_bring_to_front_on_focus,
    )


def _numbers(imgui: Any, data: HudData) -> None:
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
    if data.passes:
        imgui.separator()
        _passes(imgui, data.passes)


def _passes(imgui: Any, passes: Sequence[PassTime]) -> None:
    if not imgui.begin_table("passes", 3, imgui.TableFlags_.sizing_fixed_fit):
        return
    for entry in passes:
        imgui.table_next_row()
        imgui.table_next_column()
        if entry.skipped:
            imgui.text_colored(imgui.ImVec4(*_SKIPPED), entry.name)
            imgui.table_next_column()
            imgui.text_colored(imgui.ImVec4(*_SKIPPED), entry.skipped)
            continue
        imgui.text(entry.name)
        imgui.table_next_column()
        imgui.text(f"{entry.cpu_ms:.2f} ms")
        imgui.table_next_column()
        if entry.gpu_ms is not None:
            imgui.text(f"GPU {entry.gpu_ms:.2f} ms")
    imgui.end_table()


def _table(imgui: Any, name: str, rows: Sequence[tuple[str, str]]) -> None:
    if not imgui.begin_table(name, 2, imgui.TableFlags_.sizing_fixed_fit):
        return
    for left, right in rows:
        imgui.table_next_row()
        imgui.table_next_column()
        imgui.text(left)
        imgui.table_next_column()
        imgui.text(right)
    imgui.end_table()
