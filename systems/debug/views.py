"""Which resource a debug view shows, and how. Data and choices, no GL."""

from __future__ import annotations

from dataclasses import dataclass

from ...engine.graph import base_name

__all__ = ["MEASURES", "MODES", "NAMED_VIEWS", "View", "mode_for_format"]

MODES = ("color", "range", "heat", "signed", "normal", "depth", "distance", "ids", "lod", "hdr", "px", "surface")
"""In the order of MODE in debug/view.frag."""
MEASURES = {"range": 0, "heat": 0, "hdr": 1, "depth": 2, "distance": 2}
"""What debug/range.comp has to measure for a mode (MEASURE there); modes that aren't here need no range."""


@dataclass(frozen=True)
class View:
    """resource: name in the frame graph. mode: one of MODES, or "" to choose by the texture's format."""

    resource: str
    mode: str = ""

    @property
    def needs_range(self) -> bool:
        """Whether the smallest and largest value have to be found first."""
        return self.mode in MEASURES


NAMED_VIEWS: dict[str, View] = {
    "normals": View("gbuffer.normal", "normal"),
    "depth": View("gbuffer.depth", "depth"),
    "distance": View("gbuffer.depth", "distance"),
    "surface": View("gbuffer.surface", "surface"),
    "lod": View("gbuffer.attributes", "lod"),
    "hdr": View("scene.radiance", "hdr"),
    "wireframe": View("debug.wireframe", "color"),
    "error_px": View("debug.error_px", "px"),
    "snap_overlay": View("debug.snap_overlay", "color"),
    "holes": View("debug.holes", "color"),
    "cloud_tiles": View("debug.cloud_tiles", "color"),
    "cloud_steps": View("debug.cloud_steps", "heat"),
}
"""The last six are drawn by the surface or the clouds that offer them: a pass that creates the resource."""


def mode_for_format(name: str, format: str, components: int) -> str:
    """How to show a resource that has no view of its own; of whichever view or planet."""
    name = base_name(name)
    if name == "gbuffer.normal":
        return "normal"
    if name == "gbuffer.surface":
        return "surface"
    if name == "scene.radiance":
        return "hdr"
    if format.startswith("depth"):
        return "depth"
    if format.endswith("ui"):
        return "ids"
    if format.endswith("snorm"):
        return "signed"
    if format.endswith("f"):
        return "heat" if components == 1 else "range"
    return "color"
