"""Which resource a debug view shows, and how. Data and choices, no GL."""

from __future__ import annotations

from dataclasses import dataclass

from ...engine.graph import base_name

__all__ = ["MEASURES", "MODES", "NAMED_VIEWS", "View", "mode_for_format"]

MODES = (
    "color",
    "range",
    "heat",
    "signed",
    "normal",
    "depth",
    "distance",
    "ids",
    "lod",
    "hdr",
    "px",
    "surface",
    "history",
    "slope",
    "share",
    "albedo",
    "material",
)
"""In the order of MODE in debug/view.frag."""
MEASURES = {"range": 0, "heat": 0, "hdr": 1, "depth": 2, "distance": 2}
"""What debug/range.comp has to measure for a mode (MEASURE there); modes that aren't here need no range."""


@dataclass(frozen=True)
class View:
    """resource: name in the frame graph. mode: one of MODES, or "" to choose by the texture's format. help: what its
    colours mean."""

    resource: str
    mode: str = ""
    help: str = ""

    @property
    def needs_range(self) -> bool:
        """Whether the smallest and largest value have to be found first."""
        return self.mode in MEASURES


NAMED_VIEWS: dict[str, View] = {
    "normals": View("gbuffer.normal", "normal", "normals in planet axes: x red, y green, z blue, 0 is half"),
    "depth": View("gbuffer.depth", "depth", "distance along the view: near dark, far bright; a line at each doubling"),
    "distance": View("gbuffer.depth", "distance", "distance from the camera, as depth"),
    "surface": View("gbuffer.surface", "surface", "green ground, blue sea, red objects"),
    "slope": View("outputs.normal", "slope", "slope: level black, over red at 45 degrees to white at a wall; sky grey"),
    "sunlit": View("outputs.sunlit", "share", "share of the sun's disc that is seen: black none, white all of it"),
    "albedo": View("outputs.albedo", "albedo", "share of light that is thrown back, without any light"),
    "material": View("outputs.albedo", "material", "a colour for each material; docs/labels.md has their numbers"),
    "instance": View("outputs.instance", "ids", "a colour for each object, tree and shrub"),
    "lod": View("gbuffer.attributes", "lod", "a colour for each doubling of the vertices' distance"),
    "hdr": View("scene.radiance", "hdr", "luminance in stops, over the range of the picture"),
    "wireframe": View("debug.wireframe", "color", "edges of all triangles, a colour for each level"),
    "error_px": View("debug.error_px", "px", "drawn ground against the height function: black 0.01 pixel, white 10"),
    "snap_overlay": View("debug.snap_overlay", "color", "grids before and after the last snap"),
    "holes": View("debug.holes", "color", "background where there has to be ground"),
    "tiles": View("debug.tiles", "color", "green ground, brighter near, blue sea, orange both, pink props"),
    "history": View("composite.resolved", "history", "frames that light is gathered over: red 1, yellow 4, green 16"),
    "cloud_tiles": View("debug.cloud_tiles", "color", "tiles of cloud rays: dark nothing, blue air only, else cloud"),
    "cloud_steps": View("debug.cloud_steps", "heat", "places that the march through clouds looks at"),
    "cloud_history": View("debug.cloud_history", "color", "the last frame's: green kept, yellow held back, red none"),
}  # fmt: skip
"""The last of them but history are drawn by the system that offers them: a pass that creates the resource."""


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
