"""The tables of clear air in tests/data: columns as arrays, and cameras, suns and views from their angles."""

from __future__ import annotations

import csv
from functools import lru_cache
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
DATA = Path(__file__).parents[1] / "data"
NANOMETRES = ("680", "550", "440")


class Table:
    """One table; `table["column"]` is (N,), `table.triple("L1_disc")` the three wavelengths (N, 3)."""

    def __init__(self, name: str) -> None:
        with (DATA / f"{name}.csv").open(newline="") as file:
            self.rows = list(csv.DictReader(file))

    def __getitem__(self, column: str) -> Floats:
        return np.array([float(row[column]) for row in self.rows])

    def __len__(self) -> int:
        return len(self.rows)

    def triple(self, stem: str) -> Floats:
        return np.stack([self[f"{stem}_{nm}"] for nm in NANOMETRES], axis=1)

    def directions(self) -> Floats:
        """(N, 3) from the columns dir_x, dir_y, dir_z."""
        return np.stack([self[f"dir_{axis}"] for axis in "xyz"], axis=1)


@lru_cache(maxsize=16)
def table(name: str) -> Table:
    return Table(name)


def over_the_pole(altitude_m: ArrayLike, radius_m: float = 6_360_000.0) -> Floats:
    """Positions (N, 3) on the +Z axis."""
    h = np.asarray(altitude_m, dtype=float)
    return np.stack([np.zeros_like(h), np.zeros_like(h), radius_m + h], axis=1)


def towards(zenith_deg: ArrayLike, azimuth_deg: ArrayLike = 0.0) -> Floats:
    """Directions (N, 3) by their angles to +Z and from +X."""
    z, a = np.broadcast_arrays(np.radians(zenith_deg), np.radians(azimuth_deg))
    return np.stack([np.sin(z) * np.cos(a), np.sin(z) * np.sin(a), np.cos(z)], axis=1)
