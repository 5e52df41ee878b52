"""DebugView: look at what lies behind the picture."""

from __future__ import annotations

from dataclasses import dataclass

from ._knob import knob

__all__ = ["DebugView"]


@dataclass
class DebugView:
    """Replaces the picture by a view of the frame's insides. "off" costs nothing: no passes, no GL objects."""

    view: str = knob(
        "off",
        help="off, normals, depth, distance, surface, slope, sunlit, albedo, material, instance, lod, hdr, wireframe, "
        "error_px, snap_overlay, holes, tiles, history, cloud_tiles, cloud_steps, cloud_history, or any resource of "
        "the graph by its name",
    )
    freeze: bool = knob(
        False,
        help="Keep what is drawn of the ground and of the grid's sea, tiles and frustum, to look at it from elsewhere",
    )
