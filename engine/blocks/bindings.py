"""The registry of binding points: which number of OpenGL's means what, for Python and for shaders.

Shaders get the same names from ``#include "generated/bindings.glsl"``. What only one shader declares and one pass binds
right before it runs is that pass's own: it counts from 0 within OWN and needs no name.
"""

from __future__ import annotations

__all__ = ["OWN", "POINTS", "Point", "glsl", "points", "table"]


class Point(int):
    """A binding point: a number, and what lies there."""

    kind: str
    meaning: str

    def __new__(cls, number: int, kind: str, meaning: str) -> Point:
        made = super().__new__(cls, number)
        made.kind, made.meaning = kind, meaning
        return made


def _block(number: int, meaning: str) -> Point:
    return Point(number, "uniform block", meaning)


def _buffer(number: int, meaning: str) -> Point:
    return Point(number, "storage buffer", meaning)


def _unit(number: int, meaning: str) -> Point:
    return Point(number, "texture unit", meaning)


def _image(number: int, meaning: str) -> Point:
    return Point(number, "image", meaning)


OWN = {"uniform block": range(15, 16), "storage buffer": range(8), "texture unit": range(8), "image": range(8)}
"""Numbers that a pass, a game's too, may bind as its own, wherever its shaders include nothing that has them."""

POINTS = {kind: 1 + max(own) for kind, own in OWN.items()} | {"texture unit": 21}
"""How many points of each kind are in use: what a host's state guard keeps."""

FRAME_BLOCK = _block(0, "the view's frame")
PLANET_BLOCK = _block(1, "its planet")
LATTICE_BLOCK = _block(2, "the anchor on the cube's lattice")
TERRAIN_GRID_BLOCK = _block(3, "the terrain's grid")
TERRAIN_TABLE_BLOCK = _block(4, "octaves of the terrain's height; with method paper_grid, the printed table")
AIR_BLOCK = _block(5, "the air")
OCEAN_BLOCK = _block(6, "the water")
MATERIAL_BLOCK = _block(7, "what the ground is made of")
AIR_VIEW_BLOCK = _block(8, "the air of a view")
SHADOW_MAP_BLOCK = _block(9, "where the shadows' clipmap lies")
TRIANGLE_BLOCK = _block(9, "the anchor on the icosphere, in passes that make vertices")
COVER_BLOCK = _block(10, "where the map of the trees' shadows lies")
AIR_NODES_BLOCK = _block(10, "directions to gather light from, while the air's tables are made")
CLOUD_BLOCK = _block(11, "the planet's clouds")
WAVE_BLOCK = _block(12, "the waves")
SEA_GRID_BLOCK = _block(13, "the sea's printed grid")
CLOUD_VIEW_BLOCK = _block(14, "the clouds of a view")

CELL_BUFFER = _buffer(0, "cells of a mesh")
PATCH_BUFFER = _buffer(0, "patches of a printed mesh")
QUESTION_BUFFER = _buffer(0, "what a probe asks")
PATH_RAY_BUFFER = _buffer(0, "clouds: rays that paths of light begin with")
TREE_BUFFER = _buffer(0, "trees")
SPRAY_BUFFER = _buffer(0, "falls whose spray is seen")
FLAG_BUFFER = _buffer(0, "flags of the picture's tiles")
CLOUD_SHADED_BUFFER = _buffer(0, "clouds: what of their shadow's maps is shaded")
TILE_ROW_BUFFER = _buffer(0, "tiles of ground to assemble")
TILE_REQUEST_BUFFER = _buffer(0, "tiles of ground to make")
VERTEX_BUFFER = _buffer(1, "vertices of a mesh")
ANSWER_BUFFER = _buffer(1, "what a probe is told")
TERRAIN_TILES_BUFFER = _buffer(1, "tiles of the picture that show ground")
WIDE_WATER_BUFFER = _buffer(1, "tiles too wide for a list of rivers")
SWELL_BUFFER = _buffer(1, "slopes of long waves in a tile")
SPRAY_LIGHT_BUFFER = _buffer(1, "light on the spray of falls")
INSTANCE_BUFFER = _buffer(1, "numbers of props or of trees")
VISIBLE_BUFFER = _buffer(2, "cells or patches that are seen")
SORTED_TILES_BUFFER = _buffer(2, "tiles of ground by what their light asks for")
WANTED_BUFFER = _buffer(2, "what vertices of a mesh may be left out")
FADE_START_BUFFER = _buffer(2, "where fading vertices come from")
SEA_TILES_BUFFER = _buffer(2, "tiles of the picture that show sea")
TILE_SLOT_BUFFER = _buffer(2, "heights of tiles of ground")
ARGUMENTS_BUFFER = _buffer(3, "indirect draws of a mesh")
COUNT_BUFFER = _buffer(3, "patches that are seen, by level")
COAST_MORE_BUFFER = _buffer(3, "tiles that the coast's line may still reach")
WATER_LINE_BUFFER = _buffer(3, "lines of rivers that pass a tile")
FADE_OLD_BUFFER = _buffer(3, "the mesh before a snap")
TILE_TABLE_BUFFER = _buffer(3, "places of a tile's rows and columns")
TILE_LIST_BUFFER = _buffer(3, "which rows are assembled")
TERRAIN_TABLE_BUFFER = _buffer(4, "TERRAIN_TABLE_BLOCK as a storage buffer")
FADE_BUFFER = _buffer(4, "cells that fade")
MOVED_CELLS_BUFFER = _buffer(4, "cells of the sea that waves move")
PATCH_ARGUMENTS_BUFFER = _buffer(4, "the indirect draw of a printed mesh")
BOUNDS_BUFFER = _buffer(5, "boxes around a mesh's cells")
COAST_LAND_BUFFER = _buffer(5, "land beside the coast's line")
NARROW_WATER_BUFFER = _buffer(5, "tiles with rivers narrower than a pixel")
EXPOSURE_BUFFER = _buffer(5, "the frame's exposure")
RANGE_BUFFER = _buffer(6, "index ranges of a mesh's variants")
INDEX_BUFFER = _buffer(6, "indices of a printed mesh")
COAST_LIST_BUFFER = _buffer(6, "pixels on the coast's line")
EXPOSURE_BEFORE_BUFFER = _buffer(6, "exposure of the frame before")
FADE_NEW_BUFFER = _buffer(6, "the mesh after a snap")
TILE_BUFFER = _buffer(7, "tiles of the screen that a pass shades")
LENS_BUFFER = _buffer(7, "light of the water around the lens")

DEPTH_UNIT = _unit(0, "G-buffer: depth")
NORMAL_UNIT = _unit(1, "G-buffer: normal")
ATTRIBUTES_UNIT = _unit(2, "G-buffer: attributes")
SURFACE_UNIT = _unit(3, "G-buffer: kind of surface")
SEA_MOVED_UNIT = _unit(4, "the sea's slopes and squeeze in a pixel")
LAND_WATER_UNIT = _unit(4, "terrain: rivers and lakes in a pixel")
SCENE_UNIT = _unit(5, "radiance that was shaded before")
SKY_MAP_UNIT = _unit(6, "the sky as the sea mirrors it")
GROUND_TILE_UNIT = _unit(5, "the printed grid's map of normals")
CONTINENTS_UNIT = _unit(6, "the printed grid's continents")
DEBUG_SOURCE_UNIT = _unit(0, "what a debug view shows")
CLOUD_SHAPE_UNIT = _unit(0, "clouds: volume of noise for shapes")
CLOUD_RIMS_UNIT = _unit(1, "clouds: volume of noise for rims")
WEATHER_FIRST_UNIT = _unit(2, "clouds: weather")
WEATHER_SECOND_UNIT = _unit(3, "clouds: weather that follows")
CLOUD_DEPTH_UNIT = _unit(4, "depth of what lies behind the clouds")
CLOUD_SUN_UNIT = _unit(5, "clouds: optical depth towards the sun")
WEATHER_STEEP_UNIT = _unit(6, "clouds: how steep weather is, for paths of light")
CLOUD_FIBRES_UNIT = _unit(7, "clouds: map of the trails of ice")
AIR_DEPTH_UNIT = _unit(8, "air: optical depth to the top")
AIR_MOMENTS_UNIT = _unit(9, "air: moments of its light")
AIR_FIRST_UNIT = _unit(10, "air of a view: light scattered once")
AIR_SECOND_UNIT = _unit(11, "air of a view: light scattered more often")
AIR_EXTINCTION_UNIT = _unit(12, "air of a view: mean extinction")
PAPER_TRANSMITTANCE_UNIT = _unit(8, "printed air: transmittance to the top")
PAPER_SCATTERING_UNIT = _unit(9, "printed air: light scattered, without haze's first order")
PAPER_MIE_UNIT = _unit(10, "printed air: haze's first order")
PAPER_IRRADIANCE_UNIT = _unit(11, "printed air: irradiance of the ground")
PAPER_BEFORE_UNIT = _unit(12, "printed air, while it is made: the order before")
PAPER_DENSITY_UNIT = _unit(13, "printed air, while it is made: density of scattering")
PAPER_FLOOR_UNIT = _unit(14, "printed air, while it is made: irradiance of the order before")
SHADOW_MAP_UNIT = _unit(13, "shadows: map of lowest altitudes of the sun")
COLOR_MAP_UNIT = _unit(14, "terrain: map of colours")
CLOUD_SLAB_UNIT = _unit(14, "clouds: light scattered more than once in a layer")
HEIGHT_MAP_UNIT = _unit(15, "terrain: map of heights")
CLOUD_SHADOW_UNIT = _unit(16, "clouds: maps of their shadow")
CLOUD_TILE_UNIT = _unit(16, "printed clouds: their volume")
CLOUD_SKY_UNIT = _unit(17, "clouds: light of the cloudy sky")
CLOUD_CELLS_UNIT = _unit(15, "clouds: volume of noise for cells and clusters")
RIVERS_UNIT = _unit(18, "terrain: rivers and lakes")
COVER_UNIT = _unit(19, "map of the trees' shadows")
WOODS_UNIT = _unit(20, "terrain: forests of a vector map")

RADIANCE_IMAGE = _image(0, "radiance of the view")
COAST_NORMAL_IMAGE = _image(0, "G-buffer's normal, where the coast is drawn or waves are")
COAST_ATTRIBUTES_IMAGE = _image(1, "G-buffer's attributes, there")
COAST_SURFACE_IMAGE = _image(2, "G-buffer's kind of surface, there")


def points() -> dict[str, Point]:
    """Every point by its name."""
    return {name: value for name, value in globals().items() if isinstance(value, Point)}


def glsl() -> str:
    """``generated/bindings.glsl``."""
    return "".join(f"#define {name} {int(point)}\n" for name, point in points().items())


def table() -> str:
    """The registry as tables in Markdown, by kind and number."""
    parts: list[str] = []
    for kind in OWN:
        named = sorted((int(point), name, point.meaning) for name, point in points().items() if point.kind == kind)
        rows = "".join(f"| {number} | `{name}` | {meaning} |\n" for number, name, meaning in named)
        parts.append(f"| {kind} | name | meaning |\n|---|---|---|\n{rows}")
    return "\n".join(parts)
