"""The lattice of degrees that samples of a file in another system are interpolated at, and which part of it a file has.

Lattices are few, and the same wherever a survey goes on: m 2^k samples from pole to pole, m of 8 to 15, the next finer
one than what a file's pixels would make of the planet's circumference (by up to 12 %), counted in units of its own
system, so that neighbours, in a second zone of UTM, too, have the same. Where that system draws distances more than
5 % too large pixels count by what they are on the ground. Columns are as many as that until 60 degrees of latitude,
where half as many do, a quarter from 75.5, a sixteenth from 86.4, and so on towards a pole, by the latitude of a file
that is nearest to the equator.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .found import Found, TileError
from .geo_system import System
from .geo_tags import WARP_LINE, GeoHeader
from .lattice import Lattice

__all__ = ["lattice_count", "warped_place"]

Floats = NDArray[np.float64]

_SPARE = 1.01
"""Latitudes of an ellipsoid count as the sphere's, which changes distances by up to 0.7 %."""
_TRUE = 0.95, 1.25
"""Pixels on the ground over what their system says they are, within which the system's word is taken."""
_FEWER = (0, 1, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20)
"""Columns are fewer by these powers of two."""
_EDGE_PIXELS = 64
_MOST_EDGE = 512
_GRID = 129


def lattice_count(most_deg: float) -> int:
    """Samples around the world, no farther apart than that: m 2^k, m of 8 to 15."""
    least = 360.0 * _SPARE / most_deg
    power = max(math.floor(math.log2(least / 8.0)), 1)
    return math.ceil(least / 2.0**power) << power


def warped_place(file: Path, header: GeoHeader, system: System) -> Found:
    """Where the samples are that a file's pixels make. TileError says what is wrong."""
    longitude, latitude = system.place(*header.model(*_edge(header)))
    if np.isfinite(longitude).all() and np.isfinite(latitude).all():
        turned = np.unwrap(longitude, period=360.0)
    else:
        turned, latitude = _within(file, header, system)
    pole = _pole(header, system)
    lattice = _lattice(header, system, latitude, pole)
    # Next to a pole, where edges may pass, longitudes say nothing.
    near = np.abs(latitude) > 90.0 - 0.5 * lattice.step_deg
    seen = turned[~near] if (~near).any() else turned
    west, east = (-180.0, 180.0) if pole else (float(seen.min()), float(seen.max()))
    south, north = float(latitude.min()), float(latitude.max())
    if pole:
        south, north = (south, 90.0) if pole > 0 else (-90.0, north)
    turn = 0.0 if pole else 360.0 * math.floor((0.5 * (west + east) + 180.0) / 360.0)
    u, v = lattice.world(np.array([south, north]), np.array([west, east]) - turn)
    x, y = lattice.index(u, v)
    first_row, last_row = max(math.floor(y.min()) - 1, 0), min(math.ceil(y.max()) + 1, int(lattice.down) - 1)
    if pole or x[1] - x[0] > lattice.across - 4.0:
        first, last = 0, int(lattice.across) - 1
    else:
        first, last = math.floor(x[0]) - 1, math.ceil(x[1]) + 1
    return Found(lattice, first, first_row, last - first + 1, last_row - first_row + 1, warped=True)


def _edge(header: GeoHeader) -> tuple[Floats, Floats]:
    """Pixels along the border of a file's outer pixels, once around, close enough that what is between is straight."""
    high, wide = float(header.rows), float(header.columns)
    count = int(np.clip(max(high, wide) / _EDGE_PIXELS, 16, _MOST_EDGE))
    along = np.arange(count) / count
    columns = np.concatenate([along, np.ones(count), 1.0 - along, np.zeros(count), [0.0]])
    rows = np.concatenate([np.zeros(count), along, np.ones(count), 1.0 - along, [0.0]])
    return columns * wide - 0.5, rows * high - 0.5


def _within(file: Path, header: GeoHeader, system: System) -> tuple[Floats, Floats]:
    """Longitudes, without a jump, and latitudes of places in a file whose border leaves the planet, and around them."""
    columns, rows = np.linspace(-0.5, header.columns - 0.5, _GRID), np.linspace(-0.5, header.rows - 0.5, _GRID)
    longitude, latitude = system.place(*header.model(*(v.ravel() for v in np.meshgrid(columns, rows))))
    there = np.isfinite(longitude) & np.isfinite(latitude) & (np.abs(latitude) <= 90.0)
    if not there.any():
        raise _nowhere(file, header, system)
    order = np.sort(np.mod(longitude[there], 360.0))
    gaps = np.diff(np.append(order, order[0] + 360.0))
    first = order[(int(gaps.argmax()) + 1) % len(order)]
    turned, latitude = first + np.mod(longitude[there] - first, 360.0), latitude[there]
    # The border is up to a step of the grid away.
    more = 2.0 * float(np.ptp(latitude)) / _GRID, 2.0 * float(np.ptp(turned)) / _GRID
    west_east = turned.min() - more[1], turned.max() + more[1]
    south_north = np.clip([latitude.min() - more[0], latitude.max() + more[0]], -90.0, 90.0)
    return np.append(turned, west_east), np.append(latitude, south_north)


def _pole(header: GeoHeader, system: System) -> int:
    """1 or -1 where the north or the south pole lies within a file, 0: neither does."""
    for sign in (1, -1):
        column, row = header.pixel(*system.model(np.array([0.0]), np.array([90.0 * sign])))
        if 0.5 < float(column[0]) < header.columns - 1.5 and 0.5 < float(row[0]) < header.rows - 1.5:
            # Some projections draw a pole as a line, or put one somewhere: there and back again.
            _, back = system.place(*header.model(column, row))
            if abs(float(back[0]) - 90.0 * sign) < 1e-6 and _winds(header, system, float(column[0]), float(row[0])):
                return sign
    return 0


def _winds(header: GeoHeader, system: System, column: float, row: float) -> bool:
    """Whether all longitudes are around a place."""
    turn = np.linspace(0.0, 2.0 * np.pi, 17)
    longitude, _ = system.place(*header.model(column + 0.5 * np.cos(turn), row + 0.5 * np.sin(turn)))
    return bool(abs(np.unwrap(longitude, period=360.0)[-1] - longitude[0]) > 180.0)


def _lattice(header: GeoHeader, system: System, edge_deg: Floats, pole: int) -> Lattice:
    a, b, _, d, e, _ = header.matrix
    steps = math.hypot(a, d) * system.unit, math.hypot(b, e) * system.unit
    if system.geographic and header.matrix[1] == header.matrix[3] == 0.0:
        # Its own columns and rows, a little moved.
        east, north = _to_degrees(system, steps[0]), _to_degrees(system, steps[1])
        return Lattice(False, float(lattice_count(east)), 0.5 * lattice_count(north), 0.5, 0.5)
    nominal = min(steps)
    nominal_deg = _to_degrees(system, nominal) if system.geographic else math.degrees(nominal / system.radius_m)
    share = _true_share(header, system, nominal_deg)
    if not _TRUE[0] <= share <= _TRUE[1]:
        nominal_deg *= 2.0 ** (0.5 * math.floor(2.0 * math.log2(share)))
    count = lattice_count(nominal_deg)
    low = 0.0 if edge_deg.min() < 0.0 < edge_deg.max() and not pole else float(np.abs(edge_deg).min())
    narrow = -math.log2(max(math.cos(math.radians(low)), 1e-9))
    fewer = max(k for k in _FEWER if k <= narrow + 1e-9)
    while count >> fewer < 16 or count % (1 << fewer):
        fewer -= 1
    return Lattice(False, float(count >> fewer), 0.5 * count, 0.5, 0.5)


def _to_degrees(system: System, step: float) -> float:
    """Of a step in a geographic system's own unit."""
    if system.label == "degrees":
        return step
    x = np.array([0.0, step / system.unit])
    longitude, latitude = system.place(x, np.zeros(2))
    found = math.hypot(longitude[1] - longitude[0], latitude[1] - latitude[0])
    return found if math.isfinite(found) and found > 0.0 else step


def _true_share(header: GeoHeader, system: System, nominal_deg: float) -> float:
    """The shorter side of pixels on the ground over what their system says it is, where it is least."""
    j, i = (v.ravel() for v in np.meshgrid(*(np.linspace(0.0, n - 1.0, 3) for n in (header.rows, header.columns))))
    places = [system.place(*header.model(i + dx, j + dy)) for dx, dy in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))]
    points = [_direction(*place) for place in places]
    sides = np.stack([np.linalg.norm(points[k] - points[0], axis=0) for k in (1, 2)])
    a, b, _, d, e, _ = header.matrix
    widths = np.array([math.hypot(a, d), math.hypot(b, e)])
    share = sides / (np.radians(nominal_deg) * widths / widths.min())[:, None]
    share = share[np.isfinite(share) & (share > 0.0)]
    return float(share.min()) if share.size else 1.0


def _direction(longitude_deg: Floats, latitude_deg: Floats) -> Floats:
    longitude, latitude = np.radians(longitude_deg), np.radians(latitude_deg)
    return np.stack([np.cos(latitude) * np.cos(longitude), np.cos(latitude) * np.sin(longitude), np.sin(latitude)])


def _nowhere(file: Path, header: GeoHeader, system: System) -> TileError:
    x, y = header.model(np.array([0.0, header.columns - 1.0]), np.array([0.0, header.rows - 1.0]))
    return TileError(
        f"{file} goes from ({x[0]:g}, {y[0]:g}) to ({x[1]:g}, {y[1]:g}) in {system.label} ({system.name}), where that "
        f"has no longitude and latitude; expected coordinates within its area: correct its header, or {WARP_LINE}"
    )
