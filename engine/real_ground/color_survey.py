"""What tiles of pictures hold, all of them read once: gaps, broken ones, and a picture of all."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from .color_files import read_color_tile
from .found import TileError, middle_piece, pieces
from .survey import SetFacts, begin_survey
from .survey_picture import SetPicture
from .tile_folders import COLORS, HEIGHTS, tile_folders
from .tile_index import TileSet, first_tiles

__all__ = ["color_survey", "kind_of"]

_MOST_RED = 16
"""Of the heights that colours of terrain-RGB say: 100 km and more are none."""
_NOTHING = np.array([8, 13, 38], np.uint8)


def kind_of(path: str) -> str:
    """What the map at `path` is of, COLORS or HEIGHTS, as its first whole tile says; an index file may."""
    try:
        folders = tile_folders(path, "map", COLORS)
    except TileError:  # its entries say what heights mean, or what reads it says what is wrong
        return HEIGHTS
    for file, where in (found for folder in folders for found in first_tiles(folder)):
        try:
            pixels = read_color_tile(file, middle_piece(where))
        except (TileError, OSError):
            continue
        grey = bool((pixels[..., 0] == pixels[..., 2]).all())
        if file.suffix.lower() in (".tif", ".tiff"):
            return HEIGHTS if grey else COLORS
        seen = pixels[pixels[..., 3] > 0][..., 0]
        return COLORS if file.suffix.lower() != ".png" or seen.max(initial=0) > _MOST_RED else HEIGHTS
    return HEIGHTS


def color_survey(
    sets: Sequence[TileSet], longest_px: int = 0, progress: Callable[[int, int], None] | None = None
) -> tuple[list[SetFacts], NDArray[np.uint8] | None]:
    """Facts of each set, without heights, and a picture (rows, columns, 3) in degrees, north on top, whose longer side
    has longest_px; None for 0. The finest set lies on top."""
    found, shape, corner, scale = begin_survey(sets, longest_px)
    picture = np.tile(_NOTHING, (*shape, 1)) if longest_px else None
    total, done = sum(map(len, sets)), 0
    for facts in reversed(found):
        drawn = None
        if picture is not None:
            drawn = SetPicture(picture.shape, facts.tiles.lattice, corner, scale, smooth=False)
        for number in range(len(facts.tiles)):
            file, where = facts.tiles.tile(number)
            try:
                for piece in pieces(where):
                    pixels = read_color_tile(file, piece)
                    there = pixels[..., 3] > 0
                    facts.count(file, piece, there)
                    if drawn is not None:
                        drawn.draw(pixels[..., :3], there, (piece.column, piece.row))
                facts.see(file, where)
            except (TileError, OSError) as error:
                facts.broken.append(str(error))
                continue
            done += 1
            if progress is not None:
                progress(done, total)
        if picture is not None and drawn is not None:
            drawn.onto(picture)
    return found, picture
