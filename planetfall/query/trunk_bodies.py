"""TrunkBodies: trunks as the static bodies of a physics engine, in a local frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..systems.cover.stand import Plants
from ..systems.cover.trunks import Trunks

__all__ = ["TrunkBodies"]

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class TrunkBodies:
    """N trunks as cylinders or capsules in a local frame, ready for a physics engine.

    origin_m, axes: the frame, as TerrainPatch has it: a point of the planet is origin_m + point @ axes. middles_m: of
    the cylinders, in the frame (N, 3). directions: unit, along them and up, in the frame (N, 3). radii_m: at breast
    height, 1.3 m, or half way up a shorter trunk (N,). half_lengths_m: from the middle to either end (N,), of which the
    lower one lies in the ground. foot_radii_m: of the cone that is drawn, at the ground (N,); its tip is at the upper
    end. names: of the trees (N, 5).
    """

    origin_m: Floats
    axes: Floats
    middles_m: Floats
    directions: Floats
    radii_m: Floats
    half_lengths_m: Floats
    foot_radii_m: Floats
    names: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.radii_m)

    def __repr__(self) -> str:
        return f"<TrunkBodies {len(self)} trunks>"

    @classmethod
    def of(cls, plants: Plants, origin_m: Floats, axes: Floats) -> TrunkBodies:
        """Of trees, in a frame."""
        trunks = Trunks.of(plants)
        middles = trunks.feet_m - origin_m + (0.5 * (trunks.lengths_m - trunks.roots_m))[:, None] * trunks.axes
        return cls(
            origin_m,
            axes,
            middles @ axes.T,
            trunks.axes @ axes.T,
            trunks.breast_radii_m(),
            0.5 * (trunks.lengths_m + trunks.roots_m),
            trunks.foot_radii_m,
            plants.names,
        )

    def rotations(self, axis: tuple[float, float, float] = (0.0, 1.0, 0.0)) -> Floats:
        """Quaternions (N, 4) (x, y, z, w) that turn an engine's own unit axis of capsules into `directions`."""
        own = np.asarray(axis, dtype=np.float64)
        found = np.concatenate([np.cross(own, self.directions), 1.0 + self.directions @ own[:, None]], axis=1)
        opposite = np.linalg.norm(found, axis=1) < 1e-8
        found[opposite] = (*np.eye(3)[int(np.argmin(np.abs(own)))], 0.0)
        found[opposite, :3] = np.cross(own, found[opposite, :3])
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    def to_planet(self, points: Floats) -> Floats:
        """Planet-centred metres (N, 3) of points (N, 3) of the frame."""
        return self.origin_m + points @ self.axes

    def to_frame(self, positions_m: Floats) -> Floats:
        """The frame's coordinates (N, 3) of planet-centred positions (N, 3)."""
        return (positions_m - self.origin_m) @ self.axes.T
