"""Where a raster's samples lie on the world: rows and columns in degrees, or of a Mercator map, around the whole of it.

Sample (column, row) of a lattice lies at

    u = (column + phase_x) / across,   v = (row + phase_y) / down

u = (longitude + 180) / 360 goes east; v goes south from 0 at the north pole to 1 at the south pole: (90 - latitude) /
180 in degrees, (1 - asinh(tan(latitude)) / pi) / 2 of a Mercator map, whose ends are at 85.0511 degrees. A phase of 0
is a sample on the date line, 0.5 the middle of a pixel. Tiles with the same lattice are one set.

Latitudes are those printed on maps (WGS84, measured by the plumb line) and count as the sphere's own, so that a place
is where its numbers say. North-south distances are those of the sphere then: between 0.6 % too long at the equator and
0.4 % too short at the poles for a radius of 6371 km.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["MERCATOR_SIDE_M", "Lattice", "directions_at", "sphere_place"]

Floats = NDArray[np.float64]

MERCATOR_SIDE_M = 2.0 * np.pi * 6378137.0
"""Of the square that EPSG:3857 has metres on."""
_SAME_STEP, _SAME_PHASE = 1e-7, 1e-3


@dataclass(frozen=True)
class Lattice:
    """Samples around the world. across, down: of the whole circle and from pole to pole, no whole numbers where a
    step divides neither."""

    mercator: bool
    across: float
    down: float
    phase_x: float
    phase_y: float

    @property
    def step_deg(self) -> float:
        """Between rows at the equator."""
        return (360.0 if self.mercator else 180.0) / self.down

    @property
    def period(self) -> int:
        """Columns around the world; 0 where they do not meet again."""
        whole = round(self.across)
        return whole if abs(self.across - whole) < 1e-6 * self.across else 0

    def sample_m(self, radius_m: float) -> float:
        """Between rows at the equator, on a planet of that radius."""
        return float(np.radians(self.step_deg)) * radius_m

    def same(self, other: Lattice) -> bool:
        """Whether both are the same samples."""
        if self.mercator != other.mercator:
            return False
        steps = abs(self.across / other.across - 1.0) + abs(self.down / other.down - 1.0)
        return steps < _SAME_STEP and all(
            abs((a - b + 0.5) % 1.0 - 0.5) < _SAME_PHASE
            for a, b in ((self.phase_x, other.phase_x), (self.phase_y, other.phase_y))
        )

    def world(self, latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> tuple[Floats, Floats]:
        """(u, v) of places."""
        u = np.asarray(longitude_deg, dtype=np.float64) / 360.0 + 0.5
        latitude = np.asarray(latitude_deg, dtype=np.float64)
        if not self.mercator:
            return u, 0.5 - latitude / 180.0
        # Beyond the poles of the map, where it has no rows.
        y = np.arcsinh(np.tan(np.radians(np.clip(latitude, -89.99, 89.99)))) / np.pi
        return u, 0.5 - 0.5 * y

    def index(self, u: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Columns and rows, as fractions, of places of the world."""
        return u * self.across - self.phase_x, v * self.down - self.phase_y

    def place(self, column: ArrayLike, row: ArrayLike) -> tuple[Floats, Floats]:
        """Latitude and longitude of samples, degrees."""
        u = (np.asarray(column, dtype=np.float64) + self.phase_x) / self.across
        v = (np.asarray(row, dtype=np.float64) + self.phase_y) / self.down
        latitude = np.degrees(np.arctan(np.sinh(np.pi * (1.0 - 2.0 * v)))) if self.mercator else 90.0 - 180.0 * v
        return latitude, 360.0 * u - 180.0

    def coarser(self, factor: int) -> Lattice:
        """The lattice of blocks of factor x factor samples, each in the middle of its block."""
        shift = 0.5 * (factor - 1)
        return Lattice(
            self.mercator,
            self.across / factor,
            self.down / factor,
            (self.phase_x + shift) / factor,
            (self.phase_y + shift) / factor,
        )


def directions_at(latitude_deg: ArrayLike, longitude_deg: ArrayLike) -> Floats:
    """Unit vectors (3, ...) of places."""
    latitude, longitude = np.broadcast_arrays(np.radians(latitude_deg), np.radians(longitude_deg))
    flat = np.cos(latitude)
    return np.stack([flat * np.cos(longitude), flat * np.sin(longitude), np.sin(latitude)])


def sphere_place(points: Floats) -> tuple[Floats, Floats]:
    """Latitude and longitude (N,) in degrees of points (3, N)."""
    x, y, z = points
    return np.degrees(np.arctan2(z, np.hypot(x, y))), np.degrees(np.arctan2(y, x))
