"""Drawing of a profile: stacked history of passes (ImPlot), percentiles of frame times, memory by resource."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...engine.gpu.imgui_type import ImGui
from .hud import FrameHistory
from .profile import FrameProfile, percentiles
from .style import AMBER, BAD

__all__ = ["BAND_COLORS", "draw_budget", "draw_memory", "draw_percentiles", "draw_stack"]

Color = tuple[float, float, float, float]

BAND_COLORS: tuple[Color, ...] = (
    (0.36, 0.68, 0.94, 1.0),
    (0.98, 0.65, 0.30, 1.0),
    (0.45, 0.80, 0.50, 1.0),
    (0.86, 0.46, 0.55, 1.0),
    (0.66, 0.56, 0.90, 1.0),
    (0.93, 0.84, 0.42, 1.0),
    (0.36, 0.78, 0.78, 1.0),
    (0.80, 0.60, 0.42, 1.0),
    (0.50, 0.54, 0.60, 1.0),
)
"""Of the bands from the bottom up; the last is that of the others."""


def draw_stack(imgui: ImGui, profile: FrameProfile, budget_ms: float | None = None, height_em: float = 11.0) -> None:
    """The last frames as bands on one another, with a line for a budget."""
    from imgui_bundle import implot

    if implot.get_current_context() is None:
        implot.create_context()
    bands = profile.stacked(len(BAND_COLORS) - 1)
    em = imgui.get_font_size()
    flags = implot.Flags_
    if not implot.begin_plot(
        "##passes", imgui.ImVec2(-1.0, height_em * em), flags.no_menus | flags.no_box_select | flags.no_mouse_text
    ):
        return
    axis = implot.AxisFlags_
    implot.setup_axes("", "ms", axis.no_tick_labels | axis.no_grid_lines | axis.no_tick_marks, axis.none)
    top = float(bands[-1][2].max()) if bands else 1.0
    implot.setup_axes_limits(
        0.0, float(profile.frames - 1), 0.0, 1.15 * max(top, budget_ms or 0.0), implot.Cond_.always
    )
    implot.setup_legend(implot.Location_.north_west)
    first = profile.frames - len(profile)
    frames = np.arange(first, profile.frames, dtype=np.float32)
    for number, (name, lower, upper) in enumerate(bands):
        color = BAND_COLORS[-1] if name == "others" else BAND_COLORS[number]
        spec = implot.Spec()
        spec.fill_color = imgui.ImVec4(*color)
        spec.fill_alpha = 0.75
        implot.plot_shaded(name, frames, np.ascontiguousarray(lower), np.ascontiguousarray(upper), spec)
    if budget_ms is not None:
        spec = implot.Spec()
        spec.line_color = imgui.ImVec4(*AMBER)
        ends = np.array([0.0, profile.frames - 1.0], np.float32)
        implot.plot_line("budget", ends, np.full(2, budget_ms, np.float32), spec)
    implot.end_plot()


def draw_percentiles(imgui: ImGui, history: FrameHistory) -> None:
    """A line of numbers: what frames take in the middle, and what the worst of them take."""
    found = percentiles(history.values_ms)
    if found is None:
        imgui.text_disabled("no frames yet")
        return
    if not imgui.begin_table("percentiles", 5, imgui.TableFlags_.sizing_stretch_same):
        return
    numbers = (
        ("fps", 1e3 / max(found.median, 1e-3), "%.0f"),
        ("median", found.median, "%.1f ms"),
        ("95 %", found.p95, "%.1f ms"),
        ("99 %", found.p99, "%.1f ms"),
        ("worst", found.worst, "%.1f ms"),
    )
    for name, value, shape in numbers:
        imgui.table_next_column()
        imgui.text_disabled(name)
        imgui.text(shape % value)
    imgui.end_table()


def draw_budget(
    imgui: ImGui, owners: Mapping[str, int], budget_mib: int, lowered: Mapping[str, tuple[Any, Any]]
) -> None:
    """GPU memory in all against its budget (0: none), by owner, and which knobs have given way (chosen, taken)."""
    used = sum(owners.values()) / 2**20
    if budget_mib:
        over = used > budget_mib
        if over:
            imgui.push_style_color(imgui.Col_.plot_histogram, imgui.ImVec4(*BAD))
        imgui.progress_bar(min(used / budget_mib, 1.0), imgui.ImVec2(-1.0, 0.0), f"{used:.0f} of {budget_mib} MiB")
        if over:
            imgui.pop_style_color()
    else:
        imgui.text(f"GPU memory: {used:.0f} MiB, no budget")
    lines = "\n".join(
        f"{size / 2**20:8.1f} MiB  {owner}" for owner, size in sorted(owners.items(), key=lambda e: -e[1])
    )
    imgui.set_item_tooltip(f"{lines}\nThe budget is the quality knob memory.budget_mib")
    for key, (chosen, taken) in lowered.items():
        imgui.text_disabled(f"{key}: {_short(taken)} for {_short(chosen)}, to fit into the budget")


def _short(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def draw_memory(imgui: ImGui, resources: Sequence[tuple[str, int, str]], owners: Sequence[tuple[str, int]]) -> None:
    """resources: (name, bytes, what it is), largest first. owners: (who, GL objects)."""
    total = sum(size for _, size, _ in resources)
    flags = imgui.TableFlags_.row_bg | imgui.TableFlags_.sizing_fixed_fit
    if imgui.tree_node(f"memory: {total / 2**20:.1f} MiB in {len(resources)} resources###memory"):
        if imgui.begin_table("memory", 3, flags):
            imgui.table_setup_column("resource", imgui.TableColumnFlags_.width_stretch)
            for name, size, what in resources:
                imgui.table_next_row()
                imgui.table_next_column()
                imgui.text(name)
                imgui.table_next_column()
                imgui.text_disabled(what)
                imgui.table_next_column()
                imgui.text(f"{size / 2**20:8.2f} MiB" if size >= 10_000 else f"{size:8d} B")
            imgui.end_table()
        imgui.tree_pop()
    if owners and imgui.tree_node(f"GL objects: {sum(count for _, count in owners)}###objects"):
        for name, count in owners:
            imgui.text(f"{count:5d}  {name}")
        imgui.tree_pop()
