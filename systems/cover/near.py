"""The trees around a camera: plots are made a few a frame, the nearest first, and kept while they are near."""

from __future__ import annotations

import time
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...engine.surface.lattice import FULL_BITS, cell_edge_m, cell_of, direction_of
from .felling import Felled
from .growth import Growing, GrowingGround
from .stand import TREES, Layer, Plants, Plot, plants_in, plot_level

__all__ = ["Near", "plots_within"]

Floats = NDArray[np.float64]

_WIDE_RAD = 0.7
"""A wider circle, as on an asteroid, is looked for among all plots of the planet."""
_FELLINGS = 8
"""How many are remembered one by one."""
_AT_ONCE = 4
"""Plots made together: as many again take 2 to 5 ms."""
_AT_ONCE_WAITED = 64
"""Where a picture waits for all of them: together they take a third of the time."""


def plots_within(direction: Floats, angle_rad: float, level: int) -> list[Plot]:
    """The plots that reach into a circle around a unit direction (3,), those with the nearest middle first."""
    step = float(cell_edge_m(level, 1.0)) * 0.5
    if angle_rad < _WIDE_RAD:
        # Half a cell apart on the tangent plane, which is nearer together on the sphere.
        count = int(np.ceil(np.tan(angle_rad + 2.0 * step) / step)) + 1
        helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
        x = np.cross(direction, helper)
        x /= np.linalg.norm(x)
        a, b = np.meshgrid(*[np.arange(-count, count + 1) * step] * 2, indexing="ij")
        around = direction + a.reshape(-1, 1) * x + b.reshape(-1, 1) * np.cross(direction, x)
        cells = np.unique(np.stack(cell_of(around, level), axis=1), axis=0)
    else:
        cells = np.stack([c.ravel() for c in np.indices((6, 1 << level, 1 << level))], axis=1)
    scale = 2.0 ** (FULL_BITS - level)
    middle = direction_of(cells[:, 0], (cells[:, 1] + 0.5) * scale, (cells[:, 2] + 0.5) * scale)
    away = np.linalg.norm(middle - direction, axis=1)
    order = np.argsort(away, kind="stable")
    # Half a diagonal, which is longest where a cell is a rhombus, near a corner of the cube.
    near = order[away[order] <= angle_rad + 1.6 * step]
    return [Plot(int(face), level, int(i), int(j)) for face, i, j in cells[near]]


@lru_cache(maxsize=4)
def _plot_at(direction: bytes, level: int) -> Plot:
    """The one that holds a unit direction (3,) f64: each layer asks for the same."""
    face, i, j = cell_of(np.frombuffer(direction), level)
    return Plot(int(face), level, int(i), int(j))


class Near:
    """A layer's plants in the plots near a place. What they follow from is `key`: another one forgets them all. Felled
    ones are no part of it: `plants` are those that still stand."""

    def __init__(self, layer: Layer = TREES) -> None:
        self.layer = layer
        self.key: object = None
        self.revision = 0
        """Raised whenever other trees are there"""
        self.plants = Plants.of([])
        self.complete = False
        self._plots: dict[Plot, Plants] = {}
        self._standing: dict[Plot, Plants] = {}
        self._felled = Felled()
        self._fellings: list[tuple[int, Plants]] = []
        """Trees that were felled or put up again, and the revision from then on; all since that of another change"""
        self._at: Plot | None = None
        self._wanted: list[Plot] = []

    def refresh(
        self,
        key: object,
        direction: Floats,
        reach_m: float,
        ground: GrowingGround,
        growing: Growing,
        cover: Cover,
        seed: int,
        budget_ms: float | None,
    ) -> None:
        """Make what is missing around a unit direction (3,), for as long as budget_ms (None: all of it)."""
        level = plot_level(ground.radius_m)
        if key != self.key:
            self.key, self._at = key, None
            self._plots.clear()
            self._standing.clear()
        other = self._fell(cover)
        at = _plot_at(direction.tobytes(), level)
        changed = False
        if at != self._at:
            self._at = at
            # A plot more, so that what is near enough is there before the camera comes to the plot's edge.
            angle = (reach_m + float(cell_edge_m(level, ground.radius_m))) / ground.radius_m
            self._wanted = plots_within(direction, angle, level)
            gone = self._plots.keys() - set(self._wanted)
            for plot in gone:
                del self._plots[plot], self._standing[plot]
            changed = bool(gone)
            self.complete = False
        if not self.complete:
            began = time.perf_counter()
            missing = [plot for plot in self._wanted if plot not in self._plots]
            at_once = _AT_ONCE_WAITED if budget_ms is None else _AT_ONCE
            while missing and (budget_ms is None or (time.perf_counter() - began) * 1e3 < budget_ms):
                some, missing = missing[:at_once], missing[at_once:]
                for plot, grown in zip(some, plants_in(some, ground, growing, cover, seed, self.layer), strict=True):
                    self._plots[plot], self._standing[plot] = grown, self._felled.standing(plot, grown)
                changed = True
            self.complete = not missing
        if changed or len(other) or self.key is None:
            self.plants = Plants.of(list(self._standing.values())) if changed else self._without(other)
            self.revision += 1
            self._fellings = [] if changed else [*self._fellings[-_FELLINGS:], (self.revision, other)]

    def _without(self, other: Plants) -> Plants:
        """`plants` after trees were felled or put up again: to leave a few out is quicker than to join all plots."""
        stay = np.ones(len(self.plants), bool)
        for name in other.names[:_FELLINGS]:
            stay &= (self.plants.names != name).any(axis=1)
        all_gone = len(other) <= _FELLINGS and len(stay) - np.count_nonzero(stay) == len(other)
        return self.plants.only(np.flatnonzero(stay)) if all_gone else Plants.of(list(self._standing.values()))

    def other_since(self, revision: int) -> Plants | None:
        """The plants that were felled, or put up again, since a revision, if nothing else has changed; else None."""
        if revision != self.revision and revision + 1 not in [of for of, _ in self._fellings]:
            return None
        return Plants.of([other for of, other in self._fellings if of > revision])

    def _fell(self, cover: Cover) -> Plants:
        """Follow Cover.felled; the trees that stood and do no more, or the other way round."""
        other = []
        for plot in self._felled.refresh(cover.felled) & self._plots.keys():
            grown, stood = self._plots[plot], self._standing[plot]
            self._standing[plot] = stands = self._felled.standing(plot, grown)
            both = np.isin(grown.names[:, 4], stood.names[:, 4]) ^ np.isin(grown.names[:, 4], stands.names[:, 4])
            other.append(grown.only(both))
        return Plants.of(other)

    def clear(self) -> None:
        """No trees."""
        if len(self.plants):
            self.plants = Plants.of([])
            self.revision += 1
        self._plots.clear()
        self._standing.clear()
        self._fellings = []
        self._at, self.complete = None, True
