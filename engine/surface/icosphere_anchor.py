"""Points of the icosphere's lattice, measured from any direction: r (dir - u), by the shader in pairs of floats."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..blocks.bindings import TRIANGLE_BLOCK
from ..blocks.layout import StructLayout, Vec3
from ..made_shaders import made_shader
from ..space.vectors import split_pair

Floats = NDArray[np.float64]


@dataclass
class TriangleBlock:
    """GLSL: ``generated/triangle_anchor.glsl``, ``triangle_anchor``."""

    direction_high: Annotated[Vec3, "of the anchor, unit: high + low"]
    radius_m: float
    direction_low: Vec3


_LAYOUT = StructLayout(TriangleBlock)
made_shader("generated/triangle_anchor.glsl", lambda: _LAYOUT.block(TRIANGLE_BLOCK, "triangle_anchor"))


class AnchorKey(NamedTuple):
    """What a view's anchor is made for. proxy: its generation."""

    proxy: int
    radius_m: float


class TriangleAnchor:
    """A direction from which lattice points of the icosphere are measured, e.g. that of a `LatticeAnchor`.

    Parameters: `direction` (3,) float64, taken exactly as it is but for its length; `radius_m` of the reference sphere.
    `block` (bytes) is the uniform block `TriangleBlock`.
    """

    def __init__(self, direction: ArrayLike, radius_m: float) -> None:
        u = np.asarray(direction, dtype=np.float64)
        if u.shape != (3,) or not np.all(np.isfinite(u)) or not np.any(u):
            raise ValueError(f"TriangleAnchor: direction must be a finite, non-zero vector (3,), found {direction!r}")
        if not (np.isfinite(radius_m) and radius_m > 0):
            raise ValueError(f"TriangleAnchor: radius_m must be positive and finite, found {radius_m!r}")
        self.radius_m = float(radius_m)
        self.direction: Floats = u / np.linalg.norm(u)

    @property
    def block(self) -> bytes:
        record = np.zeros((), _LAYOUT.dtype)
        record["radius_m"] = self.radius_m
        record["direction_high"], record["direction_low"] = split_pair(self.direction)
        return record.tobytes()
