"""Which folders a map of tiles has, and what they are of: elevation, pictures of the ground, or where there is water.

A map is a folder, searched with all below it, or an index file (.toml) that names folders:

    [[tiles]]
    folder = "country"         # from the file's own folder
    kind = "heights"           # "colors": a picture of the ground, "water": where there is any; without it what the
                               # map is asked for
    png = "terrarium"          # what colours of PNG tiles say: "terrain-rgb" (the default) or "terrarium"
    geoid_m = 47.3             # added to its heights, for those above the ellipsoid or another datum

    [[tiles]]
    folder = "picture"
    kind = "colors"
    sun_azimuth_deg = 150.0    # where the sun stood, from north to east, if known
    sun_elevation_deg = 40.0

    [[tiles]]
    folder = "sea"
    kind = "water"
    depth_m = 5.0              # of the ground below the sea's level there
"""

from __future__ import annotations

import os
import tomllib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..user_paths import place_of
from .found import TileError
from .tile_files import ENDINGS, PNG_CODES

__all__ = ["COLORS", "HEIGHTS", "PICTURES", "WATER", "TileFolder", "tile_folders"]

_MOST_GEOID_M = 1e5
HEIGHTS, COLORS, WATER = "heights", "colors", "water"
_KEYS: dict[str, dict[str, tuple[float, float] | None]] = {
    HEIGHTS: {"png": None, "geoid_m": (-_MOST_GEOID_M, _MOST_GEOID_M)},
    COLORS: {"sun_azimuth_deg": (-360.0, 360.0), "sun_elevation_deg": (1.0, 90.0)},
    WATER: {"depth_m": (0.0, 1000.0)},
}
"""Of each kind what its entries may say: texts, or numbers between two."""
PICTURES = (".png", ".jpg", ".jpeg", ".tif", ".tiff")


@dataclass(frozen=True)
class TileFolder:
    """A folder of tiles, and how they are to be understood.

    sun_deg: azimuth and elevation of the sun in pictures; None: they aren't known. water: folders that say where there
    is water, of a map of heights.
    """

    folder: Path
    png: str = "terrain-rgb"
    geoid_m: float = 0.0
    kind: str = HEIGHTS
    sun_deg: tuple[float, float] | None = None
    depth_m: float = 5.0
    water: tuple[TileFolder, ...] = ()

    @property
    def endings(self) -> tuple[str, ...]:
        """Of the names of its tiles."""
        return ENDINGS if self.kind == HEIGHTS else PICTURES


def tile_folders(path: str, what: str, kind: str = HEIGHTS) -> list[TileFolder]:
    """The folders of the map at `path` that are of a kind. TileError says what is wrong with it."""
    place = place_of(path)
    if os.path.isdir(place):
        return [TileFolder(place, kind=kind)]
    if place.suffix.lower() != ".toml":
        raise TileError(f"{what}: {place} is neither a folder of tiles nor an index file (.toml)")
    try:
        table = tomllib.loads(place.read_text(encoding="utf-8"))
    except RecursionError as error:
        raise TileError(f"{what}: {place} has too many brackets in one another; correct the file") from error
    except (OSError, ValueError) as error:  # of TOML, of texts, of numbers of thousands of digits, of paths
        raise TileError(f"{what}: {place} can't be read: {error}; correct the file") from error
    entries = table.pop("tiles", None)
    if table or not isinstance(entries, list) or not entries:
        unknown = f", found {', '.join(map(repr, table))}" if table else ""
        raise TileError(f"{what}: {place}: expected tables [[tiles]] and nothing else{unknown}")
    found = [_entry(place, what, entry, kind) for entry in entries]
    if kind != HEIGHTS:
        return [each for each in found if each.kind == kind]
    water = tuple(each for each in found if each.kind == WATER)
    return [replace(each, water=water) for each in found if each.kind == HEIGHTS]


def _entry(place: Path, what: str, entry: Any, asked: str) -> TileFolder:
    if not isinstance(entry, dict):
        raise TileError(f"{what}: {place}: found {entry!r} in tiles; expected tables [[tiles]]")
    kind = entry.get("kind", asked)
    if not isinstance(kind, str) or kind not in _KEYS:
        raise TileError(f"{what}: {place}: kind = {kind!r}; expected {' or '.join(map(repr, _KEYS))}")
    known = {"folder": None, "kind": None, **_KEYS[kind]}
    for key, value in entry.items():
        if key not in known:
            raise TileError(
                f"{what}: {place}: unknown key {key!r} in [[tiles]] of kind {kind!r}; expected {', '.join(known)}"
            )
        expected = known[key]
        if not isinstance(value, str if expected is None else (int, float)) or isinstance(value, bool):
            raise TileError(
                f"{what}: {place}: {key} = {value!r}; expected a {'text' if expected is None else 'number'}"
            )
        if expected is not None and not expected[0] <= value <= expected[1]:
            unit = "degrees" if key.endswith("_deg") else "metres"
            raise TileError(f"{what}: {place}: {key} = {value!r}; expected {unit}, {expected[0]:g} to {expected[1]:g}")
    folder = place.parent / str(entry.get("folder", "."))
    if not os.path.isdir(folder):
        raise TileError(f"{what}: {place}: no folder {str(folder)!r}; correct the path")
    png = str(entry.get("png", "terrain-rgb"))
    if png not in PNG_CODES:
        raise TileError(f"{what}: {place}: png = {png!r}; expected {' or '.join(map(repr, PNG_CODES))}")
    sun = [entry[key] for key in ("sun_azimuth_deg", "sun_elevation_deg") if key in entry]
    if len(sun) == 1:
        raise TileError(
            f"{what}: {place}: the sun's azimuth or its elevation is missing; expected sun_azimuth_deg and "
            "sun_elevation_deg, or neither"
        )
    return TileFolder(
        folder, png, float(entry.get("geoid_m", 0.0)), kind, (float(sun[0]), float(sun[1])) if sun else None,
        float(entry.get("depth_m", 5.0)),
    )  # fmt: skip
