"""z_s and the covered arc against extended precision, and whether a proxy's grid holds what its cameras see."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.coverage import coverage, proxy_coverage
from ...engine.surface.lattice import cell_of
from ...engine.surface.proxy import ProxyCell, snap_proxy
from ...engine.surface.selection import CellSet, select_rings
from .. import exact


@dataclass(frozen=True)
class ArcError:
    """Over many cases."""

    worst_arc_r: float
    """Covered arc minus the exact one, in radii of the sphere that hides."""
    worst_short_r: float
    """How much too short at worst: what is missing at the horizon."""
    not_finite: int
    cases: int


def arc_errors(rng: np.random.Generator, count: int) -> ArcError:
    """Random radii 1 km to 7e7 m, altitudes 0 to 1e9 m, peaks 0 to 0.1 r, ground down to -0.1 r."""
    worst = short = 0.0
    bad = 0
    for _ in range(count):
        radius = 10.0 ** rng.uniform(3.0, np.log10(7e7))
        altitude = 0.0 if rng.random() < 0.1 else 10.0 ** rng.uniform(-2.0, 9.0)
        highest = 0.0 if rng.random() < 0.2 else 0.1 * radius * 10.0 ** rng.uniform(-6.0, 0.0)
        lowest = 0.0 if rng.random() < 0.3 else -0.1 * radius * 10.0 ** rng.uniform(-6.0, 0.0)
        found = coverage(altitude, radius, highest, lowest)
        inner = radius + lowest
        half = float(exact.visible_half_angle(altitude - lowest, inner, highest - lowest))
        values = (found.half_angle_rad, found.z_s, found.grid_offset, found.arc_m)
        if not np.isfinite(values).all():
            bad += 1
            continue
        # z_s has to say the same as the angle: cot, measured as an angle.
        from_z_s = float(np.arctan2(1.0, found.z_s))
        for angle in (found.half_angle_rad, from_z_s):
            error = angle - min(half, np.pi)
            worst, short = max(worst, abs(error)), max(short, -error)
    return ArcError(worst, short, bad, count)


@dataclass(frozen=True)
class ProxyCoverage:
    """Whether the limit seen by cameras of a proxy's cell lies inside its grid."""

    worst_missing_r: float
    """The farthest that a camera sees beyond the covered angle, in radii; 0 or less: nothing is missing."""
    outside: int
    """Peaks at the limit of sight that no selected cell contains."""
    points: int


def proxy_covers(
    radius_m: float, altitude_m: float, highest_m: float, lowest_m: float, rng: np.random.Generator, cameras: int = 24
) -> ProxyCoverage:
    """Random cameras of one proxy's cell, each with peaks all around it at the limit of its sight."""
    ground_m = float(rng.uniform(lowest_m, min(highest_m, altitude_m)))

    def ground(directions: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.full(len(directions), ground_m)

    zenith = rng.normal(size=3)
    zenith /= np.linalg.norm(zenith)
    cell = snap_proxy(zenith * (radius_m + altitude_m), radius_m, ground, None)
    covered = proxy_coverage(cell.highest_altitude_m, cell.max_sideways_rad, radius_m, highest_m, lowest_m)
    cells = select_rings(
        cell.direction, cell.altitude_above_ground_m, ground_m, radius_m, 0.02, 16, covered.half_angle_rad, 0.5
    )
    missing, outside, points = -np.inf, 0, 0
    drop = min(lowest_m, 0.0)
    for camera in cameras_of(cell, rng, cameras):
        distance = float(np.linalg.norm(camera))
        sees = min(
            float(exact.visible_half_angle(distance - radius_m - drop, radius_m + drop, highest_m - drop)), np.pi
        )
        foot = camera / distance
        peaks = around(foot, sees, rng, 12)
        angle = exact.angle_between(peaks, np.broadcast_to(cell.direction, peaks.shape)).astype(float)
        missing = max(missing, float(angle.max()) - covered.half_angle_rad)
        outside += int((~inside_cells(cells, peaks)).sum())
        points += len(peaks)
    return ProxyCoverage(missing, outside, points)


def cameras_of(cell: ProxyCell, rng: np.random.Generator, count: int) -> list[NDArray[np.float64]]:
    """Positions that the proxy stands for, its corners among them."""
    low = cell.lowest_altitude_m
    high = cell.highest_altitude_m
    low = max(low if np.isfinite(low) else -high, -0.5 * cell.radius_m)
    found: list[NDArray[np.float64]] = []
    for number in range(20 * count):
        edge = number % 2 == 0
        sideways = cell.max_sideways_rad * (1.0 - 1e-9 if edge else np.sqrt(rng.random()))
        altitude = high if number % 3 == 0 else rng.uniform(low, high)
        foot = around(cell.direction, sideways, rng, 1)[0]
        position = foot * (cell.radius_m + altitude)
        if cell.contains(position):
            found.append(position)
        if len(found) == count:
            break
    return found


def around(
    direction: NDArray[np.float64], angle_rad: float, rng: np.random.Generator, count: int
) -> NDArray[np.float64]:
    """Unit directions (count, 3) at this angle from `direction`, at random azimuths."""
    helper = np.eye(3)[np.argmin(np.abs(direction))]
    u = np.cross(direction, helper)
    u /= np.linalg.norm(u)
    v = np.cross(direction, u)
    azimuth = rng.uniform(0.0, 2.0 * np.pi, count)[:, None]
    found = direction * np.cos(angle_rad) + (u * np.cos(azimuth) + v * np.sin(azimuth)) * np.sin(angle_rad)
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def inside_cells(cells: CellSet, directions: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether any of the cells contains each direction."""
    found = np.zeros(len(directions), bool)
    for level in np.unique(cells.level):
        of_level = cells.level == level
        keys = _key(cells.face[of_level], cells.i[of_level], cells.j[of_level])
        found |= np.isin(_key(*cell_of(directions, int(level))), keys)
    return found


def _key(face: NDArray[Any], i: NDArray[Any], j: NDArray[Any]) -> NDArray[np.int64]:
    return (face.astype(np.int64) << 60) ^ (i.astype(np.int64) << 30) ^ j.astype(np.int64)
