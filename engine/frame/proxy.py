"""Proxy: the held, snapped stand-in for a view's camera, which levels of detail and the anchor depend on."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..surface.lattice_anchor import LatticeAnchor
from ..surface.proxy import ProxyCell

__all__ = ["Proxy"]


@dataclass(frozen=True, eq=False)
class Proxy:
    """The proxy of one view's camera. The proxy system places it, before others are updated: `frame.view.proxy`.

    cell: the snapped point, and the cameras that it stands for. lattice: the lattice around its foot; its `direction`,
    (3,) unit in planet axes, is the anchor's. anchor_height_m: of the anchor above the reference sphere. anchor_m: the
    anchor, (3,) f64 in planet axes; what the GPU gets is relative to it. ground_m: height of the ground at the foot.
    generation: another one with every snap.
    """

    cell: ProxyCell
    lattice: LatticeAnchor
    anchor_height_m: float
    anchor_m: NDArray[np.float64]
    ground_m: float
    generation: int
