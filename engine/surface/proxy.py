"""The camera proxy: a snapped position that stands in for the camera until the camera leaves its cell.

Everything that is expensive (the choice of cells, their vertices, the lattice cells of the noise) depends on the proxy
only, so it is done again when the proxy moves and not before (Michelic 2018, Michelic et al. 2019). The proxy's foot is
a lattice point of a level chosen by the altitude above ground, so that new sample points coincide with old ones; its
altitude goes in geometric steps. Holding has some slack, so a camera on a border doesn't switch to and fro.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..space import length
from .lattice import FULL_BITS, direction_of, snap
from .lattice_anchor import LatticeAnchor

Floats = NDArray[np.float64]
GroundHeight = Callable[[Floats], Floats]

COARSEST_LEVEL = 4
"""Proxies never are farther apart than the corners of this level's cells, however high the camera is."""
SLACK = 0.2
"""How far beyond its cell (as a fraction of it) a camera is still represented."""
LOWEST_ALTITUDE_M = 0.01
"""Altitudes above ground below this, the camera inside the ground among them, are taken as this."""


@dataclass(frozen=True, eq=False)
class ProxyCell:
    """A proxy and the camera positions that it stands for."""

    face: int
    i: int
    j: int
    """Its foot is the canonical lattice point (face, I, J)."""
    level: int
    """The level whose corners the foot was snapped to."""
    direction: Floats
    """(3,), of the foot, planet axes."""
    radius_m: float
    ground_height_m: float
    """The ground's height at the foot, above the reference sphere."""
    altitude_above_ground_m: float
    """The proxy's own, one of a geometric series."""
    max_sideways_rad: float
    """The largest central angle between the foot and a camera of the cell."""
    lowest_altitude_m: float
    highest_altitude_m: float
    """Cameras of the cell have altitudes above the reference sphere between these."""
    generation: int
    """Counts the snaps."""
    snap_distance_m: float
    """How far the proxy moved in the last snap; 0 for the first."""
    covered_altitude_m: float = -np.inf
    covered_sideways_rad: float = 0.0
    """The largest of a camera that is to see no end of what is made for the proxy; at least those of the cell."""

    def covering(self, altitude_m: float, sideways_rad: float) -> "ProxyCell":
        """The same, for cameras up to there too while the next proxy is not there."""
        altitude_m = max(altitude_m, self.covered_altitude_m)
        return replace(
            self, covered_altitude_m=altitude_m, covered_sideways_rad=max(sideways_rad, self.covered_sideways_rad)
        )

    @property
    def altitude_m(self) -> float:
        """The proxy's altitude above the reference sphere."""
        return self.ground_height_m + self.altitude_above_ground_m

    @property
    def position_m(self) -> Floats:
        """The proxy itself, (3,), planet-centred."""
        return self.direction * (self.radius_m + self.altitude_m)

    def anchor(self) -> LatticeAnchor:
        """The anchor at its foot."""
        return LatticeAnchor.at(self.face, self.i, self.j, self.radius_m)

    def contains(self, position_m: ArrayLike, slack: float = 1.0) -> bool:
        """Whether it stands for a camera at this position; `slack` < 1 asks for a place nearer its middle."""
        position = np.asarray(position_m, dtype=np.float64)
        distance = length(position)
        altitude = distance - self.radius_m
        sideways = _angle_between(position / distance, self.direction)
        middle = 0.5 * (self.lowest_altitude_m + self.highest_altitude_m)
        low, high = self.lowest_altitude_m, self.highest_altitude_m
        if math.isfinite(middle):
            low, high = middle + (low - middle) * slack, middle + (high - middle) * slack
        return sideways <= self.max_sideways_rad * slack and low <= altitude <= high


def snap_proxy(
    position_m: ArrayLike,
    radius_m: float,
    ground_height_fn: GroundHeight,
    previous: ProxyCell | None,
    fraction: float = 0.25,
    may_update_early: bool = False,
    finest_step_m: float = 0.05,
) -> ProxyCell:
    """The proxy for a camera position: `previous` itself while it still stands for the camera, else a new one.

    position_m: (3,) planet-centred. ground_height_fn: unit directions (N, 3) to heights (N,); asked only on a snap, for
    the camera's and the proxy's foot. fraction: the size of a cell as a fraction of the altitude above ground, and the
    relative step of the altitude. may_update_early: the change could not be seen (a cut, a fast flight): then a
    proxy that is merely not the best one is replaced. finest_step_m: cells get no smaller than this.
    With previous=None the result is a function of the position alone. Raises ValueError for a position or radius that
    is not finite, or at the centre.
    """
    position = np.asarray(position_m, dtype=np.float64)
    distance = length(position)
    if position.shape != (3,) or not math.isfinite(distance) or distance == 0.0:
        raise ValueError(f"snap_proxy: expected a finite position_m (3,) away from the centre, found {position_m!r}")
    if not (math.isfinite(radius_m) and radius_m > 0):
        raise ValueError(f"snap_proxy: radius_m must be positive and finite, found {radius_m!r}")
    if not 0.0 < fraction <= 1.0:
        raise ValueError(f"snap_proxy: fraction must be in (0, 1], found {fraction!r}")
    if previous is not None and previous.radius_m != radius_m:
        previous = None
    if previous is not None and previous.contains(position, 1.0 / (1.0 + 2 * SLACK) if may_update_early else 1.0):
        return previous
    direction = position / distance
    altitude = distance - radius_m
    base = float(ground_height_fn(direction[None, :])[0])
    clearance = max(altitude - base, LOWEST_ALTITUDE_M)
    ratio = 1.0 + fraction
    step = max(round(np.log(clearance / LOWEST_ALTITUDE_M) / np.log(ratio)), 0)
    above_ground = LOWEST_ALTITUDE_M * ratio**step
    level = _level_for(max(fraction * above_ground, finest_step_m), radius_m)
    face, i, j = (int(a) for a in snap(direction, level))
    foot = direction_of(face, i, j)
    if previous is not None and (face, i, j) == (previous.face, previous.i, previous.j):
        foot = previous.direction
    size = (np.pi / 2) * 2.0**-level
    # Half a cell's diagonal, and the slack; never less than where the camera is now.
    sideways = max(np.sqrt(0.5) * size * (1.0 + 2 * SLACK), _angle_between(direction, foot) * (1.0 + 1e-9))
    half_step = ratio ** (0.5 + SLACK)
    lowest = base + above_ground / half_step if step else -np.inf
    highest = base + above_ground * half_step
    ground = float(ground_height_fn(foot[None, :])[0])
    cell = ProxyCell(
        face=face,
        i=i,
        j=j,
        level=level,
        direction=foot,
        radius_m=float(radius_m),
        ground_height_m=ground,
        altitude_above_ground_m=above_ground,
        max_sideways_rad=float(sideways),
        lowest_altitude_m=min(lowest, altitude),
        highest_altitude_m=max(highest, altitude),
        generation=0 if previous is None else previous.generation + 1,
        snap_distance_m=0.0,
        covered_altitude_m=max(highest, altitude),
        covered_sideways_rad=float(sideways),
    )
    if previous is None:
        return cell
    if _same_place(cell, previous) and previous.contains(position):
        return previous
    moved = float(np.linalg.norm(cell.position_m - previous.position_m))
    return replace(cell, snap_distance_m=moved)


def _same_place(a: ProxyCell, b: ProxyCell) -> bool:
    return (a.face, a.i, a.j, a.altitude_above_ground_m) == (b.face, b.i, b.j, b.altitude_above_ground_m)


def _angle_between(a: Floats, b: Floats) -> float:
    return 2.0 * math.atan2(length(a - b), length(a + b))


def _level_for(size_m: float, radius_m: float) -> int:
    """The coarsest level whose cells are no larger than this, within bounds."""
    level = int(np.ceil(np.log2(radius_m * (np.pi / 2) / size_m)))
    return int(np.clip(level, COARSEST_LEVEL, FULL_BITS))
