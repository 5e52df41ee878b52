"""A make-believe planet for the selection of tiles: facts of any node from a law, and tiles that arrive in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.surface.forest import Forest, NodeFacts, Selection
from ...engine.surface.keys import level_of
from ...engine.surface.scheme import Scheme

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Directions, phases and shares of the waves that the ground is made of; wavelengths from continents to kilometres.
_WAVES = np.array(
    [[3.1, -1.7, 2.3], [-7.9, 5.2, 4.4], [17, 23, -19], [-61, 37, 53], [151, -167, 173], [-911, 953, 887]]
)
_PHASES = np.array([0.1, 1.2, 2.3, 3.4, 4.5, 5.6])
_SHARES = np.array([0.45, 0.25, 0.15, 0.08, 0.05, 0.02])


class MadeGround:
    """Ground of a sum of waves with roughness below them, and what a measurement of a node would find.

    `radius_m`, `relief_m` (heights lie within plus and minus this), `segments` of a tile's side. Errors fall with the
    power 0.85 of the spacing, as those of fractal ground do, and vary by a factor of four from node to node.
    """

    def __init__(self, scheme: Scheme, radius_m: float = 6.371e6, relief_m: float = 9000.0, segments: int = 32) -> None:
        self.scheme, self.radius_m, self.relief_m, self.segments = scheme, radius_m, relief_m, segments

    def height(self, directions: Floats) -> Floats:
        """Heights (N,) at unit directions (N, 3)."""
        return self.relief_m * (np.sin(directions @ _WAVES.T + _PHASES) @ _SHARES)

    def facts(self, keys: Ints) -> NodeFacts:
        """The facts of nodes: a function of the key alone."""
        spacing_rad = self.scheme.spacing_rad(level_of(keys), self.segments)
        spacing = self.radius_m * spacing_rad
        # A hash of the key, in [0, 1).
        chance = ((keys.astype(np.uint64) * np.uint64(0x9E3779B97F4A7C15)) >> np.uint64(40)).astype(np.float64) / 2**24
        rough = np.minimum(0.02 * spacing**0.85, 0.3 * self.relief_m) * 2.0 ** (2.0 * chance - 1.0)
        sag = self.radius_m * spacing_rad**2 / 8.0
        middle = self.height(self.scheme.center(keys))
        size = 0.75 * self.segments * spacing_rad
        slope = self.relief_m * (np.abs(_SHARES) * np.linalg.norm(_WAVES, axis=1))
        # Each wave changes by its slope times the distance, but never by more than its height.
        change = np.minimum(slope * size[:, None], 2.0 * self.relief_m * _SHARES).sum(axis=1) + rough
        low = np.maximum(middle - change, -self.relief_m)
        high = np.minimum(middle + change, self.relief_m)
        return NodeFacts(low, high, rough + sag)

    def forest(self, **options: Any) -> Forest:
        """A forest on this ground."""
        return Forest(self.scheme, self.radius_m, -self.relief_m, self.relief_m, self.segments, **options)


def make_tiles(forest: Forest, ground: MadeGround, wanted: Ints, slots: int) -> int:
    """Make tiles as a backend does: drop what is not needed, and tell the facts. Returns how many were made."""
    wanted = wanted[~forest.knows(wanted)]
    over = len(forest.table) + len(wanted) - slots
    if over > 0:
        forest.forget(forest.droppable(over))
        wanted = wanted[: max(slots - len(forest.table), 0)]
    if len(wanted):
        facts = ground.facts(wanted)
        forest.set_facts(wanted, facts.low_m, facts.high_m, facts.error_m)
    return len(wanted)


def settle(
    forest: Forest, ground: MadeGround, select: Callable[[], Selection], slots: int = 1 << 20, most: int = 400
) -> Selection:
    """Select and make tiles until nothing is wanted."""
    for _ in range(most):
        selection = select()
        if not make_tiles(forest, ground, selection.wanted, slots):
            return selection
    raise RuntimeError(f"the selection was not settled after {most} rounds")


PIXEL_RAD = float(np.radians(60.0)) / 1080
"""Of a picture of 1080 rows and 60 degrees."""


@dataclass
class SelectionTimes:
    """Microseconds a call; tiles are made between the calls, outside the clock."""

    leaves: int
    tiles: int
    """Leaves that are not behind the horizon."""
    warm_us: list[float]
    """Moving sideways by 1 % of the altitude a frame: each call measures all nodes anew."""
    still_us: list[float]
    """Moving by a millionth of the altitude a frame: within the slack."""
    cold_us: list[float]
    """Nothing is left of an earlier selection but the facts."""
    facts_us: float
    """Telling the facts of a tile, in batches of 32."""
    revisions: int
    """By how many of the warm calls the selection was changed."""


def above(ground: MadeGround, altitude_m: float, direction: Floats) -> Floats:
    """A place (3,) so far above the ground in a direction (3,)."""
    up = direction / np.sqrt(direction @ direction)
    return up * (ground.radius_m + float(ground.height(up[None])[0]) + altitude_m)


def error_for(ground: MadeGround, eye: Floats, leaves: int) -> float:
    """The allowed error in pixels at which a selection has about so many leaves."""
    low, high = -8.0, 6.0
    for _ in range(12):
        middle = 0.5 * (low + high)
        forest = ground.forest()
        settle(forest, ground, lambda f=forest, e=2.0**middle: f.select(eye, PIXEL_RAD, e, max_tiles=2 * leaves))
        low, high = (middle, high) if len(forest.leaves()) > leaves else (low, middle)
    return 2.0**high


def time_selection(ground: MadeGround, altitude_m: float, leaves: int, runs: int) -> SelectionTimes:
    """Times of a selection of about `leaves` leaves at an altitude."""
    direction = np.array([0.3, -0.5, 0.8])
    eye = above(ground, altitude_m, direction)
    error_px = error_for(ground, eye, leaves)
    aside = np.cross(direction, [0.0, 0.0, 1.0])
    aside /= np.sqrt(aside @ aside)
    forest = ground.forest()
    clock = 0.0

    def timed(place: Floats) -> tuple[float, Selection]:
        started = perf_counter()
        selection = forest.select(place, PIXEL_RAD, error_px, clock)
        return 1e6 * (perf_counter() - started), selection

    def run(step_m: float, count: int) -> tuple[list[float], int]:
        nonlocal clock
        times: list[float] = []
        before = forest.select(eye, PIXEL_RAD, error_px, clock).revision
        for k in range(count):
            clock += 1.0 / 60.0
            elapsed, selection = timed(eye + (k + 1) * step_m * aside)
            times.append(elapsed)
            make_tiles(forest, ground, selection.wanted, 1 << 20)
        return times, forest.select(eye + count * step_m * aside, PIXEL_RAD, error_px, clock).revision - before

    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, error_px))
    found = len(forest.leaves()), len(forest.select(eye, PIXEL_RAD, error_px))
    run(0.01 * altitude_m, 5)
    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, error_px))
    warm, revisions = run(0.01 * altitude_m, runs)
    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, error_px))
    still, _ = run(1e-6 * altitude_m, runs)
    settle(forest, ground, lambda: forest.select(eye, PIXEL_RAD, error_px))
    keys = np.array(list(forest.table.rows), dtype=np.int64)
    facts = ground.facts(keys)
    cold: list[float] = []
    told = 0.0
    for _ in range(max(runs // 10, 5)):
        forest = ground.forest()
        clock = 0.0
        for first in range(0, len(keys), 32):
            part = slice(first, first + 32)
            started = perf_counter()
            forest.set_facts(keys[part], facts.low_m[part], facts.high_m[part], facts.error_m[part])
            told += perf_counter() - started
        cold.append(timed(eye)[0])
    return SelectionTimes(*found, warm, still, cold, 1e6 * told / (len(cold) * len(keys)), revisions)
