"""Panels for turning knobs, and numbers over the picture. ImGui is imported when something is drawn, not before."""

from .history import Edit, History
from .hud import FrameHistory, HudData, draw_hud
from .list_editor import choose
from .log_lines import LogLines
from .panel import Change, Panel
from .passes import PassTime, draw_passes
from .profile import FrameProfile, percentiles
from .profiler import draw_budget, draw_memory, draw_percentiles, draw_stack
from .style import apply_style, icon
from .workbench import Store, Workbench

__all__ = [
    "Change",
    "Edit",
    "FrameHistory",
    "FrameProfile",
    "History",
    "HudData",
    "LogLines",
    "Panel",
    "PassTime",
    "Store",
    "Workbench",
    "apply_style",
    "choose",
    "draw_budget",
    "draw_hud",
    "draw_memory",
    "draw_passes",
    "draw_percentiles",
    "draw_stack",
    "icon",
    "percentiles",
]
