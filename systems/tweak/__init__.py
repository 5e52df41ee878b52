"""Panels for turning knobs, and numbers over the picture. ImGui is imported when something is drawn, not before."""

from .history import Edit, History
from .hud import FrameHistory, HudData, draw_hud
from .panel import Change, Panel
from .passes import PassTime, draw_passes
from .style import apply_style, icon
from .workbench import Store, Workbench

__all__ = [
    "Change",
    "Edit",
    "FrameHistory",
    "History",
    "HudData",
    "Panel",
    "PassTime",
    "Store",
    "Workbench",
    "apply_style",
    "draw_hud",
    "draw_passes",
    "icon",
]
