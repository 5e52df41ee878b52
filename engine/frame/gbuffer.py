"""The G-buffer that all surfaces draw into, and the tiles of the picture that they are shaded by."""

from __future__ import annotations

from ..blocks.bindings import ATTRIBUTES_UNIT, DEPTH_UNIT, NORMAL_UNIT, SURFACE_UNIT
from ..graph import TextureSpec

__all__ = ["ATTACHMENTS", "GBUFFER", "GBUFFER_UNITS", "TILE_PX", "tiles_of"]

ATTACHMENTS = (
    TextureSpec("gbuffer.depth", "depth32f", help="near / z, reversed: 0 is infinitely far"),
    TextureSpec("gbuffer.normal", "rg16_snorm", help="octahedral normal in planet axes"),
    TextureSpec(
        "gbuffer.attributes",
        "rgba8",
        help="ground: roughness, moisture, height; sea: depth in two; the vertices' spacing in alpha",
    ),
    TextureSpec("gbuffer.surface", "r8ui", help="0 none, 1 terrain, 2 sea, 3 props"),
)
"""The depth buffer, and the colours in the order of their shader locations."""
GBUFFER = tuple(spec.name for spec in ATTACHMENTS[1:])
"""Names of the colour attachments of every surface pass."""
GBUFFER_UNITS = dict(
    zip(("gbuffer.depth", *GBUFFER), (DEPTH_UNIT, NORMAL_UNIT, ATTRIBUTES_UNIT, SURFACE_UNIT), strict=True)
)
"""The texture unit of each attachment, for what shades surfaces."""

TILE_PX = (16, 8)
"""Width and height of a tile: the workgroup of common/surface_tiles.glsl, TILE_PX of common/surfaces.glsl."""


def tiles_of(size: tuple[int, int]) -> tuple[int, int]:
    """How many tiles a picture of that size in pixels has across and down."""
    return -(-size[0] // TILE_PX[0]), -(-size[1] // TILE_PX[1])
