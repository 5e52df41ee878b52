"""Which cells the projected grid has for a proxy, and how their vertices are to be made."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....components import Ocean, Planet
from ....engine.frame import Frame
from ....engine.surface.coverage import proxy_coverage
from ....engine.surface.selection import CellSet, chord_limit_m, select_rings, spacing_angle
from .base import Ground

__all__ = ["Choice", "choose"]

_DECIMATED_SHARE = 0.8  # of edge_px: larger ones save vertices, but the ground jumps more at a snap
_FINEST_M = 0.02
_MOST_CELLS = 12000  # a telephoto lens near the ground would ask for ten times as many: its triangles get longer


@dataclass
class Choice:
    """A selection and what its vertices depend on."""

    cells: CellSet | None = None
    eye_m: tuple[float, ...] = (0.0, 0.0, 0.0)
    """The proxy, from its anchor."""
    edge_rad: float = 0.01
    chord_m: float = 1.0
    spacing: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)
    """What the block of the grid says of it."""
    anchor_m: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    anchor_height_m: float = 0.0

    def foot_m(self, radius_m: float) -> NDArray[np.float64]:
        """The anchor's on the reference sphere, from the planet's centre."""
        return self.anchor_m * (radius_m / (radius_m + self.anchor_height_m))


def choose(frame: Frame, ground: Ground, proxy: Any, quads: int, edge_px: float, pixel_angle: float) -> Choice:
    """The grid for a proxy: a function of it and of settings, whatever the camera does."""
    radius_m = frame.world.get(frame.planet, Planet).radius_m
    angle_rad = spacing_angle(edge_px, pixel_angle, proxy.cell.altitude_m, proxy.cell.radius_m)
    # Above the ground, even for a camera (or an anchor) under water.
    above_ground = max(proxy.cell.altitude_m - proxy.ground_m, 0.01)
    # Facets may not rise above an eye that is nearer to the ground than they are wide.
    smallest = min(float(frame.settings["terrain.min_spacing_m"]), max(above_ground, _FINEST_M))
    sea = frame.world.try_get(frame.planet, Ocean)
    lowest = ground.field.lowest_m if sea is None else max(ground.field.lowest_m, sea.sea_level_m)
    if proxy.cell.altitude_m < lowest:
        lowest = ground.field.lowest_m  # under water the bed is what hides
    cells = select_rings(
        proxy.lattice,
        above_ground,
        proxy.ground_m,
        radius_m,
        angle_rad,
        quads,
        coverage_rad=proxy_coverage(
            proxy.cell.covered_altitude_m, proxy.cell.covered_sideways_rad, radius_m, ground.field.highest_m, lowest
        ).half_angle_rad,
        min_spacing_m=smallest,
        max_cells=_MOST_CELLS,
        height_at=ground.field.height,
    )
    return Choice(
        cells,
        tuple(proxy.lattice.direction * (proxy.ground_m + above_ground - proxy.anchor_height_m)),
        _DECIMATED_SHARE * angle_rad,
        chord_limit_m(pixel_angle, proxy.cell.radius_m),
        (angle_rad, smallest, above_ground, 0.0),
        proxy.anchor_m.copy(),
        proxy.anchor_height_m,
    )
