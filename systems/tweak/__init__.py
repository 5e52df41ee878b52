"""Panels for turning knobs, and numbers over the picture. ImGui is imported when something is drawn, not before."""

from .hud import FrameHistory, HudData, draw_hud
from .panel import Change, Panel
from .passes import PassTime, draw_passes

__all__ = ["Change", "FrameHistory", "HudData", "Panel", "PassTime", "draw_hud", "draw_passes"]
