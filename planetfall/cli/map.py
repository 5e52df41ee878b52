"""`planetfall map`: what folders of tiles hold, reading them before a scene does, the rivers in them."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from cyclopts import App, Parameter
from rich.console import Console
from rich.table import Table

from ..engine.settings import SettingError
from ..systems.capture import require_writable
from .map_rivers import rivers_command
from .progress import counted, written

__all__ = ["map_app"]

console = Console()
map_app = App(
    help="Elevation and pictures from tiles: what a folder holds, reading heights before a scene does, and the rivers "
    "that are in them."
)
map_app.command(rivers_command, name="rivers")

Folder = Annotated[str, Parameter(help="A folder of tiles, or an index file (.toml).")]
Map = Annotated[str, Parameter(help="A folder of tiles, an index file (.toml), or a vector map (.geojson, .json).")]
_VECTORS = (".geojson", ".json")
_SEA_LEVEL_RADIUS_M = 6.371e6


@map_app.command(name="info")
def info_command(
    folder: Map,
    *,
    kind: Literal["heights", "colors", "water"] | None = None,
    width_px: int = 1024,
    output: Annotated[Path | None, Parameter(name=["--output", "-o"])] = None,
) -> None:
    """Say what a folder of tiles holds, of elevation or of pictures: coverage, resolution, ranges and gaps; or what a
    GeoJSON file of water and forests does: features by kind, extent, and what is ignored and why.

    apart: samples, at the equator of the Earth. voids: samples without a height, pixels that show nothing. missing:
    tiles that the bounds have room for and that are not there. in: coordinate systems of files, how many are in each,
    and how well PROJ knows the way from there to WGS84.

    Parameters
    ----------
    kind
        What its tiles are, "heights", "colors" or "water"; without it what the first one looks like.
    width_px
        Of the picture's longer side.
    output
        A picture, PNG, in degrees, of pictures or of the heights lit from the north-west; where there are none it is
        dark blue. What lies on both sides of the date line is shown with that in the middle.
    """
    from ..engine.real_ground.color_survey import color_survey, kind_of
    from ..engine.real_ground.survey import survey
    from ..engine.real_ground.tile_index import open_tiles

    if width_px < 1:
        raise SettingError(f"width_px: {width_px}; expected 1 or more pixels")
    if folder.lower().endswith(_VECTORS):
        if output is not None or kind is not None:
            raise SettingError(f"{folder} is a vector map, of which only counts are printed; leave out -o and --kind")
        _say_vectors(folder)
        return
    if output is not None:
        require_writable(output)
    with counted("looking", 1) as progress:
        what: str = kind or kind_of(folder)
        sets = open_tiles(folder, "map", progress, what)
    longest_px = width_px if output is not None else 0
    found: list[Any]
    picture: Any
    with counted("reading", sum(map(len, sets))) as progress:
        if what == "heights":
            found, heights = survey(sets, longest_px, progress)
            picture = None if heights is None else _relief(heights)
        else:
            found, picture = color_survey(sets, longest_px, progress)
    table = Table("tiles", "apart", "south to north", "west to east", what, "voids", "missing", box=None)
    systems: Counter[tuple[str, str]] = Counter()
    for facts in found:
        south, west, north, east = facts.bounds_deg
        systems += facts.systems
        lattice = facts.tiles.lattice
        east -= 360.0 if east > 180.0 else 0.0
        table.add_row(
            f"{len(facts.tiles):,}", _apart(lattice.sample_m(_SEA_LEVEL_RADIUS_M)), f"{south:.3f} to {north:.3f}",
            f"{west:.3f} to {east:.3f}", _values(facts, what), f"{100.0 * facts.voids / max(facts.samples, 1):.2f} %",
            f"{facts.missing:,}",
        )  # fmt: skip
    console.print(table)
    for (label, note), count in sorted(systems.items()):
        console.print(f"in {label}: {count:,}" + (f" ({note})" if note else ""), markup=False, soft_wrap=True)
    for facts in found:
        for message in facts.broken:
            console.print(f"broken: {message}", markup=False, soft_wrap=True)
    if not any(facts.samples for facts in found):
        raise SettingError(f"{folder}: none of its tiles can be read, see above; fetch them again")
    if output is not None and picture is not None:
        from ..systems.capture import write_png

        write_png(output, picture)
        written(output)


def _say_vectors(path: str) -> None:
    from ..engine.real_ground.vector_file import vector_map

    found = vector_map(path, "map")
    table = Table("kind", "features", box=None)
    for kind, count in sorted(found.counts.items()):
        table.add_row(kind, f"{count:,}")
    console.print(table)
    points = found.points()
    if len(points):
        (west, south), (east, north) = points.min(axis=0), points.max(axis=0)
        console.print(
            f"{found.vertices:,} vertices, south to north {south:.4f} to {north:.4f}, west to east {west:.4f} to "
            f"{east:.4f}", soft_wrap=True,
        )  # fmt: skip
    if found.repaired:
        console.print(f"repaired: {found.repaired:,} rings that were not closed")
    for why, count in found.ignored.most_common():
        console.print(f"ignored: {count:,} ({why})", markup=False, soft_wrap=True)


@map_app.command(name="make")
def make_command(folder: Folder, *, kind: Literal["heights", "colors"] | None = None, memory_mb: float = 256.0) -> None:
    """Read tiles and keep what scenes need of them, so that these start at once. Heights that are cut off go on.

    Levels that don't fit into the memory are read page by page while a scene runs: those are "on disk".

    Parameters
    ----------
    kind
        What its tiles are, "heights" or "colors"; without it what the first one looks like.
    memory_mb
        As Terrain.height_map_most_mb, or color_map_most_mb, of the scenes, in MB.
    """
    from ..engine.real_ground.color_reading import make_colors
    from ..engine.real_ground.color_survey import kind_of
    from ..engine.real_ground.resident import make_ground
    from ..engine.wavelengths import DISPLAY_NM

    what: str = kind or kind_of(folder)
    if not 1.0 <= memory_mb <= 900.0:
        knob = "height_map_most_mb" if what == "heights" else "color_map_most_mb"
        raise SettingError(f"memory_mb: {memory_mb:g}; expected 1 to 900 MB, as Terrain.{knob}")
    most_bytes = int(1e6 * memory_mb)
    levels: list[tuple[float, int, int]]
    with counted("reading", 1) as progress:
        if what == "heights":
            ground, file = make_ground(folder, most_bytes, "map", progress, streams=True)
            levels = [_level(level, level.nbytes) for level in ground.levels]
        else:
            colors, file = make_colors(folder, DISPLAY_NM, most_bytes, "map", progress, streams=True)
            levels = [_level(level, level.nbytes) for each in colors.sets for level in each.levels]
    table = Table("level", "samples apart", "pages", "MB", box=None)
    for number, (apart_m, pages, size) in enumerate(levels):
        table.add_row(str(number), _apart(apart_m), f"{pages:,}", f"{size / 1e6:.1f}" if size else "on disk")
    console.print(table)
    written(file)


def _level(level: Any, size: int) -> tuple[float, int, int]:
    """How far apart samples are, pages, bytes."""
    return level.lattice.sample_m(_SEA_LEVEL_RADIUS_M), len(level.where), size


def _apart(sample_m: float) -> str:
    return f"{sample_m:,.1f} m" if sample_m < 100.0 else f"{sample_m:,.0f} m"


def _values(facts: Any, kind: str) -> str:
    if kind != "heights":
        return f"{facts.samples:,} pixels"
    return f"{facts.lowest_m:,.0f} to {facts.highest_m:,.0f} m" if facts.highest_m >= facts.lowest_m else "none"


def _relief(heights: Any) -> Any:
    """(rows, columns, 3) of 8 bits: green to brown to white by height, lit."""
    there = ~np.isnan(heights)
    low, high = (float(v) for v in (np.nanmin(heights), np.nanmax(heights))) if there.any() else (0.0, 1.0)
    share = np.where(there, (heights - low) / max(high - low, 1e-9), 0.0)
    rows, columns = np.gradient(np.where(there, share, 0.0)) if min(heights.shape) > 1 else (share * 0.0, share * 0.0)
    steep = max(float(np.quantile(np.abs(rows) + np.abs(columns), 0.98)), 1e-9)
    light = np.clip(0.75 + 0.25 * (rows + columns) / steep, 0.4, 1.1)
    stops = np.array([[0.36, 0.52, 0.30], [0.72, 0.66, 0.42], [0.52, 0.40, 0.30], [0.96, 0.96, 0.96]])
    at = np.stack([np.interp(share, np.linspace(0.0, 1.0, 4), stops[:, k]) for k in range(3)], axis=-1)
    picture = np.where(there[..., None], np.clip(at * light[..., None], 0.0, 1.0), np.array([0.03, 0.05, 0.15]))
    return np.rint(255.0 * picture).astype(np.uint8)
