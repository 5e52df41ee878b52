"""Trees asked for again and again around the same places, as by a game's physics: plots and trunks are kept."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...engine.surface.lattice import FULL_BITS, cell_edge_m, cell_of, direction_of
from .felling import Felled
from .growth import Growing, GrowingGround
from .near import plots_within
from .species import tallest_m
from .stand import LAYERS, TREES, Layer, Plants, Plot, plants_in, plot_level
from .trunks import LOOK_M, Trunks, touch

__all__ = ["MOST_RADIUS_M", "Grown"]

Floats = NDArray[np.float64]
_Cell = tuple[int, int, int, float]

MOST_RADIUS_M = 1000.0
"""Of a sphere."""
_KEPT = 200_000
"""Plants kept by plot, and trunks by cell: some 20 MB each."""
_LEAST_REACH_M = 8.0
"""What is looked for around a cell; further ones are twice as far, each."""
_WIDEST = 0.3
"""More than any trunk is wide, over the height of the tallest species."""
_AT_ONCE = 128
"""Plots made at once: some 60 MB."""


class TrunkGround(GrowingGround, Protocol):
    @property
    def highest_m(self) -> float: ...
    @property
    def lowest_m(self) -> float: ...


class Grown:
    """Trees and shrubs by place. They follow from the arguments alone; felled ones are as `fell` said last."""

    def __init__(self, ground: TrunkGround, growing: Growing, cover: Cover, seed: int) -> None:
        self._ground, self._growing, self._cover, self._seed = ground, growing, cover, seed
        self.level = plot_level(ground.radius_m)
        self.felled = Felled()
        self._plots: OrderedDict[tuple[Layer, Plot], Plants] = OrderedDict()
        self._cells: OrderedDict[_Cell, tuple[frozenset[Plot], Trunks]] = OrderedDict()
        self._plants = self._trunks = 0

    def fell(self, felled: tuple[tuple[int, int, int, int, int], ...]) -> None:
        """Take over Cover.felled."""
        changed = self.felled.refresh(felled)
        if changed:
            for key, (plots, trunks) in list(self._cells.items()):
                if not changed.isdisjoint(plots):
                    self._trunks -= len(trunks)
                    del self._cells[key]

    def within(self, direction: Floats, radius_m: float) -> Plants:
        """Those that stand within radius_m along the ground of a unit direction (3,)."""
        angle = radius_m / self._ground.radius_m
        plots = plots_within(direction, angle, self.level)
        parts = []
        for first in range(0, len(plots), _AT_ONCE):
            some = plots[first : first + _AT_ONCE]
            found = Plants.of([plants for layer in LAYERS for plants in self.standing(some, layer)])
            parts.append(found.only(_angles(found.positions_m, direction) <= angle))
        return Plants.of(parts)

    def standing(self, plots: Sequence[Plot], layer: Layer) -> list[Plants]:
        """A layer's plants in each plot that still stand."""
        missing = [plot for plot in plots if (layer, plot) not in self._plots]
        made = plants_in(missing, self._ground, self._growing, self._cover, self._seed, layer)
        for plot, plants in zip(missing, made, strict=True):
            self._plots[layer, plot] = plants
            self._plants += len(plants)
        found = []
        for plot in plots:
            self._plots.move_to_end((layer, plot))
            found.append(self.felled.standing(plot, self._plots[layer, plot]))
        while self._plants > _KEPT:
            self._plants -= len(self._plots.popitem(last=False)[1])
        return found

    def contact(self, centers_m: Floats, radii_m: Floats) -> tuple[Floats, Floats]:
        """As trunks.touch() of all trees: centres (N, 3), none at the planet's; radii (N,) up to MOST_RADIUS_M."""
        far = np.linalg.norm(centers_m, axis=1)
        depth, normal = np.full(len(centers_m), -np.inf), centers_m / far[:, None]
        ground, tall = self._ground, 2.0 * tallest_m(self._cover)
        above = far - ground.radius_m
        near = (above < ground.highest_m + tall + radii_m + LOOK_M) & (above > ground.lowest_m - tall - radii_m)
        rows = np.flatnonzero(near)
        if not len(rows):
            return depth, normal
        # A trunk's axis is a line through the planet's centre: what is so far from it is seen from there beside it.
        beside = radii_m[rows] + LOOK_M + _WIDEST * tallest_m(self._cover)
        angle = np.arcsin(np.minimum(beside / far[rows], 1.0))
        steps = np.ceil(np.log2(np.maximum(angle * ground.radius_m / _LEAST_REACH_M, 1.0)))
        keys = np.stack([*cell_of(normal[rows], self.level), steps.astype(np.int64)], axis=1)
        cells, which = np.unique(keys, axis=0, return_inverse=True)
        for k, (face, i, j, step) in enumerate(cells.tolist()):
            some = rows[which.ravel() == k]
            trunks = self._around(face, i, j, _LEAST_REACH_M * 2.0**step)
            depth[some], normal[some] = touch(trunks, centers_m[some], radii_m[some])
        return depth, normal

    def _around(self, face: int, i: int, j: int, reach_m: float) -> Trunks:
        """Of a cell and what lies within reach_m of it."""
        key = (face, i, j, reach_m)
        found = self._cells.get(key)
        if found is not None:
            self._cells.move_to_end(key)
            return found[1]
        scale, radius = 2.0 ** (FULL_BITS - self.level), self._ground.radius_m
        middle = direction_of(face, (i + 0.5) * scale, (j + 0.5) * scale).reshape(3)
        # Half a diagonal, as plots_within() has it.
        angle = 0.8 * float(cell_edge_m(self.level, 1.0)) + reach_m / radius
        plots = plots_within(middle, angle, self.level)
        plants = Plants.of(self.standing(plots, TREES))
        trunks = Trunks.of(plants.only(_angles(plants.positions_m, middle) <= angle))
        self._cells[key] = (frozenset(plots), trunks)
        self._trunks += len(trunks)
        while self._trunks > _KEPT and len(self._cells) > 1:
            self._trunks -= len(self._cells.popitem(last=False)[1][1])
        return trunks


def _angles(positions_m: Floats, direction: Floats) -> Floats:
    """(N,) between positions (N, 3) and a unit direction (3,)."""
    away = positions_m / np.linalg.norm(positions_m, axis=1, keepdims=True) - direction
    return 2.0 * np.arcsin(np.minimum(0.5 * np.linalg.norm(away, axis=1), 1.0))
