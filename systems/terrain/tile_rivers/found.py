"""Rivers and lakes of a grid of heights as features of a vector map (GeoJSON, RFC 7946)."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....engine.real_ground.height_grid import HeightGrid
from ....engine.real_ground.tile_files import TileError
from ..drainage.network import YEAR_S
from ..rivers.widths import WIDTH_BY_ROOT
from .cells import GridCells, cells_of
from .outlines import outline, simple_line
from .reaches import Reach, reaches_of
from .routes import LakeRules, Routes, routes_of

__all__ = ["FoundWater", "find_water", "springs_of", "write_water"]

Floats = NDArray[np.float64]

_LEAST_M2, _LEAST_CELLS = 5e6, 200
"""Catchment from which streams are drawn where nobody says: so much, or so many cells."""
_LEFT_OUT_CELLS, _SHORE_CELLS = 0.05, 0.5
"""What lines of rivers and shores of lakes may leave out. Rivers stay within half a cell of the cells' middles."""
_LEAST_WIDTH_M = 0.1


@dataclass(frozen=True, eq=False)
class FoundWater:
    """What `find_water` gives: `reaches` by river and downstream."""

    cells: GridCells
    routes: Routes
    reaches: list[Reach]
    runoff_m_year: float

    def discharge_m3_s(self, catchment_m2: float) -> float:
        """Mean of the year."""
        return catchment_m2 * self.runoff_m_year / YEAR_S

    def features(self) -> Iterator[dict[str, Any]]:
        """Of GeoJSON: rivers, then lakes."""
        grid = self.cells.grid
        for reach in self.reaches:
            points = reach.places
            kept = simple_line(grid, points, _LEFT_OUT_CELLS * _cell_m(grid))
            discharge = self.discharge_m3_s(reach.catchment_m2)
            properties: dict[str, Any] = {
                "kind": "river",
                "name": f"river {reach.river}",
                "river": reach.river,
                "order": reach.order,
                "width": round(max(WIDTH_BY_ROOT * discharge**0.5, _LEAST_WIDTH_M), 1),
                "discharge_m3_s": float(f"{discharge:.4g}"),
                "catchment_km2": float(f"{reach.catchment_m2 * 1e-6:.6g}"),
                "catchment_cut": reach.cut,
                "ends": f"river {reach.into}" if reach.into else reach.ends,
            }
            line = [
                [*_rounded(place), round(float(level), 2)]
                for place, level in zip(points[kept].tolist(), reach.level_m[kept], strict=True)
            ]
            yield _feature("LineString", line, properties)
        for number, lake in enumerate(self.routes.lakes):
            rings = outline(self.cells, lake.cells, _SHORE_CELLS * _cell_m(grid))
            if not rings:
                continue
            properties = {
                "kind": "lake",
                "name": f"lake {number + 1}",
                "level_m": round(lake.level_m, 2),
                "area_km2": float(f"{self.cells.area_m2[lake.cells].sum() * 1e-6:.6g}"),
                "catchment_km2": float(f"{self.routes.catchment_m2[lake.outlet] * 1e-6:.6g}"),
                "hollow": lake.hollow,
            }
            yield _feature("Polygon", [[_rounded(place) for place in ring.tolist()] for ring in rings], properties)

    def deepest_cut(self) -> tuple[float, float, float]:
        """How far streams cut below where a flood would leave the ground's hollows, m, and where: latitude, longitude
        of the deepest place."""
        on = np.unique(np.concatenate([reach.cells for reach in self.reaches])) if self.reaches else np.zeros(0, int)
        on = on[~self.cells.sea[on]]
        if not on.size:
            return 0.0, 0.0, 0.0
        deep = self.routes.filled_m[on] - self.routes.surface_m[on]
        worst = int(np.argmax(deep))
        longitude, latitude = self.cells.places(on[worst : worst + 1])[0]
        return float(deep[worst]), float(latitude), float(longitude)


def springs_of(grid: HeightGrid) -> float:
    """m2 of catchment from which streams are drawn by default."""
    middle = np.cos(np.radians(grid.latitude_deg[len(grid.latitude_deg) // 2]))
    return max(_LEAST_M2, _LEAST_CELLS * grid.step_m * grid.radius_m * grid.column_rad * float(middle))


def find_water(
    grid: HeightGrid,
    springs_m2: float,
    runoff_m_year: float,
    lakes: LakeRules | None = None,
    sea_m: float = 0.0,
    what: str = "rivers",
) -> FoundWater:
    """Rivers of catchments of springs_m2 and more, and with rules for them lakes. Water ends at heights that are not
    above sea_m, and at the data's border. runoff_m_year: of all land alike. TileError where there is no land."""
    cells = cells_of(grid, sea_m)
    if cells.sea.all():
        raise TileError(
            f"{what}: no land: of {cells.out:,} cells with a height none lies above {sea_m:g} m, where the sea is; "
            "give tiles or a box with some"
        )
    routes = routes_of(cells, runoff_m_year, lakes)
    return FoundWater(cells, routes, reaches_of(cells, routes, springs_m2), runoff_m_year)


def write_water(file: Path, found: FoundWater, progress: Callable[[int, int], None] | None = None) -> tuple[int, int]:
    """Write the features, one a line; how many rivers' lines and lakes there are."""
    counts = [0, 0]
    total = len(found.reaches) + len(found.routes.lakes)
    with file.open("w", encoding="utf-8", newline="\n") as out:
        out.write('{"type":"FeatureCollection","features":[')
        for number, feature in enumerate(found.features()):
            counts[feature["geometry"]["type"] == "Polygon"] += 1
            out.write(("\n" if number == 0 else ",\n") + json.dumps(feature, separators=(",", ":")))
            if progress is not None and number % 256 == 255:
                progress(number + 1, total)
        out.write("\n]}\n")
    return counts[0], counts[1]


def _cell_m(grid: HeightGrid) -> float:
    """The shorter side of a cell in the grid's middle."""
    middle = np.cos(np.radians(grid.latitude_deg[len(grid.latitude_deg) // 2]))
    return min(grid.step_m, grid.radius_m * grid.column_rad * float(middle))


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "Feature", "properties": properties, "geometry": {"type": kind, "coordinates": coordinates}}


def _rounded(place: list[float]) -> list[float]:
    return [round(place[0], 7), round(place[1], 7)]
