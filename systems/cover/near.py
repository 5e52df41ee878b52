"""The trees around a camera: plots are made a few a frame, the nearest first, and kept while they are near."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...engine.surface.lattice import FULL_BITS, cell_edge_m, cell_of, direction_of
from .growth import Growing, GrowingGround
from .stand import TREES, Layer, Plants, Plot, plants_in, plot_level

__all__ = ["Near", "plots_within"]

Floats = NDArray[np.float64]

_WIDE_RAD = 0.7
"""A wider circle, as on an asteroid, is looked for among all plots of the planet."""
_AT_ONCE = 4
"""Plots made together: as many again take 2 to 5 ms."""


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


class Near:
    """A layer's plants in the plots near a place. What they follow from is `key`: another one forgets them all."""

    def __init__(self, layer: Layer = TREES) -> None:
        self.layer = layer
        self.key: object = None
        self.revision = 0
        """Raised whenever other trees are there"""
        self.plants = Plants.of([])
        self.complete = False
        self._plots: dict[Plot, Plants] = {}
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
        face, i, j = cell_of(direction, level)
        at = Plot(int(face), level, int(i), int(j))
        changed = False
        if at != self._at:
            self._at = at
            # A plot more, so that what is near enough is there before the camera comes to the plot's edge.
            angle = (reach_m + float(cell_edge_m(level, ground.radius_m))) / ground.radius_m
            self._wanted = plots_within(direction, angle, level)
            gone = self._plots.keys() - set(self._wanted)
            for plot in gone:
                del self._plots[plot]
            changed = bool(gone)
            self.complete = False
        if not self.complete:
            began = time.perf_counter()
            missing = [plot for plot in self._wanted if plot not in self._plots]
            while missing and (budget_ms is None or (time.perf_counter() - began) * 1e3 < budget_ms):
                some, missing = missing[:_AT_ONCE], missing[_AT_ONCE:]
                self._plots.update(zip(some, plants_in(some, ground, growing, cover, seed, self.layer), strict=True))
                changed = True
            self.complete = not missing
        if changed or self.key is None:
            self.plants = Plants.of(list(self._plots.values()))
            self.revision += 1

    def clear(self) -> None:
        """No trees."""
        if len(self.plants):
            self.plants = Plants.of([])
            self.revision += 1
        self._plots.clear()
        self._at, self.complete = None, True
