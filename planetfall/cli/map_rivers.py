"""`planetfall map rivers`: rivers and lakes found in tiles of elevation, as a vector map."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter
from rich.console import Console
from rich.table import Table

from ..engine.settings import SettingError
from ..systems.capture import require_writable
from .progress import counted, written

__all__ = ["rivers_command"]

console = Console()
_RADIUS_M = 6.371e6
_LISTED = 8
_DEEP_CUT_M = 15.0


def rivers_command(
    folder: Annotated[str, Parameter(help="A folder of tiles, or an index file (.toml).")],
    *,
    output: Annotated[Path, Parameter(name=["--output", "-o"])],
    box: tuple[float, float, float, float] | None = None,
    spacing: float | None = None,
    springs: float | None = None,
    runoff: float = 300.0,
    sea: float = 0.0,
    lakes: bool = False,
    lake_area: float = 0.1,
    lake_depth: float = 30.0,
) -> None:
    """Find the rivers in tiles of elevation, and lakes, and write them as GeoJSON, which Terrain.vector_map reads.

    Water goes down the steepest way from cell to cell, out of hollows over their lowest pass, to the sea or to the
    border of the data. Rivers are as wide as the planet's own, 7.2 m by the root of m3/s. "catchment_cut" says that
    some of a river's catchment may lie beyond the data.

    Parameters
    ----------
    output
        The vector map, .geojson.
    box
        West, south, east and north in degrees: tiles outside are not read.
    spacing
        Metres between cells; without it as fine as the finest tiles, or as 4 million cells allow.
    springs
        Catchment from which on a stream is drawn, km2; without it 5 km2, or 200 cells where that is more.
    runoff
        Water of a year that runs off the land, mm; 300 is the mean of the Earth's land.
    sea
        Water ends at heights up to this, m.
    lakes
        Find lakes, too: flat places, and hollows that are deep enough and whose rivers fill them. Without them rivers
        cut through the rims of all hollows.
    lake_area
        Least area of a lake, km2.
    lake_depth
        Least depth of a hollow that holds a lake, m. Shallower ones are mostly gorges that cells are too wide to show.
    """
    from ..engine.real_ground.height_grid import height_grid
    from ..systems.capture.files import written_beside
    from ..systems.terrain.tile_rivers.found import find_water, springs_of, write_water
    from ..systems.terrain.tile_rivers.routes import LakeRules

    for name, value in (("spacing", spacing), ("springs", springs), ("runoff", runoff), ("lake-area", lake_area),
                        ("lake-depth", lake_depth)):  # fmt: skip
        if value is not None and not (0.0 < value < math.inf):
            raise SettingError(f"--{name}: {value:g}; expected more than 0")
    if not math.isfinite(sea):
        raise SettingError(f"--sea: {sea}; expected metres")
    if output.suffix.lower() not in (".geojson", ".json"):
        raise SettingError(f"--output: {output}; expected a name that ends in .geojson, as Terrain.vector_map reads it")
    require_writable(output)
    with counted("reading", 1) as progress:
        grid = height_grid(folder, "map rivers", _RADIUS_M, box, spacing, progress=progress)
    springs_m2 = springs_of(grid) if springs is None else 1e6 * springs
    rules = LakeRules(1e6 * lake_area, lake_depth) if lakes else None
    found = find_water(grid, springs_m2, 1e-3 * runoff, rules, sea, "map rivers")
    with counted("writing", 1) as progress, written_beside(output) as beside:
        lines, areas = write_water(beside, found, progress)
    rows, columns = grid.height_m.shape
    coarser = f", {grid.step_m / grid.own_m:.0f} of the tiles' {grid.own_m:.0f} m" if grid.step_m > grid.own_m else ""
    console.print(
        f"{columns:,} x {rows:,} cells, {grid.step_m:.0f} m apart{coarser}; streams from {springs_m2 * 1e-6:.3g} km2 "
        f"on, {runoff:g} mm of runoff a year", soft_wrap=True, highlight=False,
    )  # fmt: skip
    table = Table("river", "water", "catchment", "level", "ends in", box=None)
    named = {reach.river: reach for reach in found.reaches}
    for number in sorted(named)[:_LISTED]:
        reach = named[number]  # the last of them, at its lower end
        table.add_row(
            str(number), f"{found.discharge_m3_s(reach.catchment_m2):,.2f} m3/s",
            f"{reach.catchment_m2 * 1e-6:,.1f} km2{' and more' if reach.cut else ''}",
            f"{reach.level_m[-1]:,.0f} m", f"river {reach.into}" if reach.into else f"the {reach.ends}",
        )  # fmt: skip
    console.print(table)
    console.print(f"{len(named):,} rivers in {lines:,} lines, {areas:,} lakes", highlight=False)
    depth_m, latitude, longitude = found.deepest_cut()
    if depth_m > _DEEP_CUT_M:
        console.print(
            f"the deepest hollow that a river cuts through is {depth_m:.0f} m deep, at {latitude:.4f}, {longitude:.4f}"
            + ("" if lakes else "; --lakes fills such hollows"), soft_wrap=True, highlight=False,
        )  # fmt: skip
    written(output)
