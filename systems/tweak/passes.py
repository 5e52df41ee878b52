"""The passes of a frame as a table: times, and what was skipped and why. Plain data in, ImGui out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ...engine.gpu.imgui_type import ImGui

__all__ = ["PassTime", "draw_passes"]

_QUIET = (0.55, 0.55, 0.55, 1.0)


@dataclass(frozen=True)
class PassTime:
    """A pass of the last frame; gpu_ms is None where it was not timed, skipped says why it did not run ("": it ran).

    culled: it is not part of the frame at all. help: one line.
    """

    name: str
    cpu_ms: float
    gpu_ms: float | None = None
    skipped: str = ""
    culled: bool = False
    help: str = ""


def draw_passes(passes: Sequence[PassTime], *, culled: bool = False) -> None:
    """Draw the table inside an ImGui window; the reason for a skipped pass shows while the pointer is on it."""
    from imgui_bundle import imgui

    shown = [entry for entry in passes if culled or not entry.culled]
    timed = any(entry.gpu_ms is not None for entry in shown)
    flags = imgui.TableFlags_.sizing_fixed_fit | imgui.TableFlags_.row_bg
    if not imgui.begin_table("passes", 3 if timed else 2, flags):
        return
    imgui.table_setup_column("pass", imgui.TableColumnFlags_.width_stretch)
    imgui.table_setup_column("CPU ms")
    if timed:
        imgui.table_setup_column("GPU ms")
    imgui.table_headers_row()
    for entry in shown:
        _row(imgui, entry, timed)
    _total(imgui, shown, timed)
    imgui.end_table()


def _row(imgui: ImGui, entry: PassTime, timed: bool) -> None:
    imgui.table_next_row()
    imgui.table_next_column()
    if entry.skipped:
        imgui.text_colored(imgui.ImVec4(*_QUIET), entry.name)
    else:
        imgui.text(entry.name)
    tip = ". ".join(text for text in (entry.help, entry.skipped and f"skipped: {entry.skipped}") if text)
    if tip:
        imgui.set_item_tooltip(tip)
    imgui.table_next_column()
    if entry.skipped:
        imgui.text_colored(imgui.ImVec4(*_QUIET), "skipped")
    else:
        imgui.text(f"{entry.cpu_ms:6.2f}")
    if timed:
        imgui.table_next_column()
        imgui.text("" if entry.gpu_ms is None or entry.skipped else f"{entry.gpu_ms:6.2f}")


def _total(imgui: ImGui, passes: Sequence[PassTime], timed: bool) -> None:
    ran = [entry for entry in passes if not entry.skipped]
    imgui.table_next_row()
    imgui.table_next_column()
    imgui.text(f"{len(ran)} passes")
    imgui.table_next_column()
    imgui.text(f"{sum(entry.cpu_ms for entry in ran):6.2f}")
    if timed:
        imgui.table_next_column()
        imgui.text(f"{sum(entry.gpu_ms or 0.0 for entry in ran):6.2f}")
