"""TileView: what a backend of tiles keeps for each view, and what that was made for."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....engine.frame import View, ViewParts
from ....engine.gpu import GpuScope
from ....engine.space.camera import CameraStamp
from ....engine.surface.forest import Forest, Selection
from ....engine.surface.icosphere_anchor import AnchorKey
from ..tiles.mesh import TileMesh
from ..tiles.shape import TileShape
from .base import GroundRevision

__all__ = ["Asked", "ForestKey", "SplitBy", "TileInputs", "TileView", "TilesShown"]

Ints = NDArray[np.int64]


class SplitBy(NamedTuple):
    """What distances to split at are worked out for."""

    pixel_rad: float
    edge_px: float


class ForestKey(NamedTuple):
    """What a forest is made for. split: for one that splits by distance."""

    ground: GroundRevision
    hidden_below_m: float
    split: SplitBy | None


class Asked(NamedTuple):
    """terrain.error_px and terrain.edge_px."""

    error_px: float
    edge_px: float


class TileInputs(NamedTuple):
    """What an update depends on beside the place of the camera, components and where it looks. proxy: its
    generation."""

    ground: GroundRevision
    proxy: int
    pixel_rad: float
    asked: Asked
    min_spacing_m: float


class TilesShown(NamedTuple):
    """What the list of visible tiles depends on. selection: its revision; proxy: its generation."""

    selection: int
    proxy: int
    camera: CameraStamp
    keep_dh_m: tuple[float, float]


class TileView(ViewParts):
    """One view's forest and what of it is drawn."""

    def __init__(self, of: GpuScope, shape: TileShape, slots: int, view: View) -> None:
        super().__init__(of)
        self.of = view
        self.mesh = TileMesh(self.gpu, shape, slots)
        self.forest: Forest | None = None
        self.key: ForestKey | None = None
        self.inputs: TileInputs | None = None
        """Of the last update."""
        self.hidden_below_m = -np.inf  # tiles that lie below, under the sea, need no detail
        self.selection: Selection | None = None
        self.whole = False
        """Whether all that was wanted has been there since the forest was made."""
        self.queue: Ints = np.zeros(0, np.int64)  # tiles to make, most urgent first
        self.under_way: set[int] = set()  # of its tiles: facts were still to come in its last frame
        self.made = self.settled_at = 0  # tiles made for it, and when everything was there last
        self.at_once = self.frozen = False  # in its last frame
        self.revision = -1
        self.clock_s = 0.0
        self.eye_m: NDArray[np.float64] | None = None
        self.wanted: TilesShown | None = None
        self.culled: TilesShown | None = None
        self.keep_dh_m = (-3.0e38, 3.0e38)
        self.anchor: Any = None  # a block for what assembles, and what it was made for
        self.anchor_key: AnchorKey | None = None
        self.anchor_height_m = 0.0
