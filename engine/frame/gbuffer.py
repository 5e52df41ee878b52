"""The G-buffer that all surfaces draw into, and the tiles of the picture that they are shaded by."""

from __future__ import annotations

from enum import IntEnum

from ..blocks.bindings import ATTRIBUTES_UNIT, DEPTH_UNIT, NORMAL_UNIT, SURFACE_UNIT
from ..graph import TextureSpec
from ..made_shaders import made_shader

__all__ = ["ATTACHMENTS", "GBUFFER", "GBUFFER_UNITS", "TILE_PX", "Surface", "tiles_of"]


class Surface(IntEnum):
    """What a pixel shows: values of gbuffer.surface and of the output `surface`. GLSL: SURFACE_NONE and so on, in
    ``generated/surfaces.glsl``."""

    NONE = 0
    TERRAIN = 1
    SEA = 2
    PROPS = 3
    COVER = 4


made_shader(
    "generated/surfaces.glsl",
    lambda: "".join(f"const uint SURFACE_{each.name} = {each.value}u;\n" for each in Surface),
)

ATTACHMENTS = (
    TextureSpec("gbuffer.depth", "depth32f", help="near / z, reversed: 0 is infinitely far"),
    TextureSpec("gbuffer.normal", "rg16_snorm", help="octahedral normal in planet axes"),
    TextureSpec(
        "gbuffer.attributes",
        "rgba8",
        help="ground: roughness, moisture, height; sea: depth in two; the vertices' spacing in alpha",
    ),
    TextureSpec("gbuffer.surface", "r8ui", help=", ".join(f"{each.value} {each.name.lower()}" for each in Surface)),
)
"""The depth buffer, and the colours in the order of their shader locations."""
GBUFFER = tuple(spec.name for spec in ATTACHMENTS[1:])
"""Names of the colour attachments of every surface pass."""
GBUFFER_UNITS = dict(
    zip(("gbuffer.depth", *GBUFFER), (DEPTH_UNIT, NORMAL_UNIT, ATTRIBUTES_UNIT, SURFACE_UNIT), strict=True)
)
"""The texture unit of each attachment, for what shades surfaces."""

TILE_PX = (16, 8)
"""Width and height of a tile. GLSL: ``generated/tiles.glsl``."""


def _tile_defines() -> str:
    # A layout(local_size_x = ...) of GLSL 4.30 takes no sums, only a number or a macro that is one.
    width, height = TILE_PX
    sizes = {"TILE_WIDTH": width, "TILE_HEIGHT": height}
    halves = {f"HALF_{name}": value // 2 for name, value in sizes.items()}
    defines = "".join(f"#define {name} {value}\n" for name, value in {**sizes, **halves}.items())
    return f"{defines}const ivec2 TILE_PX = ivec2(TILE_WIDTH, TILE_HEIGHT);\n"


made_shader("generated/tiles.glsl", _tile_defines)


def tiles_of(size: tuple[int, int]) -> tuple[int, int]:
    """How many tiles a picture of that size in pixels has across and down."""
    return -(-size[0] // TILE_PX[0]), -(-size[1] // TILE_PX[1])
