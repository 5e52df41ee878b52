"""Trunks as solids: cones along the zenith at their feet, as assets/shaders/cover/tree.glsl draws them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .species import Species
from .stand import Plants

__all__ = ["LOOK_M", "Trunks", "touch"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

COLUMN_TRUNK = 0.30
"""Radius of a column's stem over its whole one, arms and all: twin of the shader's constant."""
TREE_TRUNK, ACACIA_TRUNK, PALM_TRUNK = 0.022, 0.027, 0.016
"""Radius at the foot, over the tree's height, and those of acacias and palms: twins of the shader's constants."""
_END, _TALL_END = 0.8, 1.0
"""Where the cone has its tip, over the tree's height; of all but broadleaves."""
_ROOT = 0.05
"""How far the cone goes on below the foot, over the tree's height."""
_BREAST_M = 1.3
"""Where foresters measure the diameter of a trunk."""
LOOK_M = 5.0
"""Trunks farther than this from a sphere are none for it."""
_BLOCK = 200_000
"""Pairs of spheres and trunks looked at together: some 10 MB."""


@dataclass(frozen=True)
class Trunks:
    """N cones. Planet axes, metres."""

    feet_m: Floats
    """(N, 3) from the planet's centre: z = 0 of each"""
    axes: Floats
    """(N, 3) unit vectors from the foot to the tip"""
    lengths_m: Floats
    """(N,) from the foot to the tip"""
    foot_radii_m: Floats
    """(N,) at the foot"""
    roots_m: Floats
    """(N,) from the foot down to the cone's lower end, in the ground"""

    def __len__(self) -> int:
        return len(self.lengths_m)

    @classmethod
    def of(cls, plants: Plants) -> Trunks:
        """One for each tree; a column's stem ends round, where its cone has its tip."""
        axes = plants.positions_m / np.linalg.norm(plants.positions_m, axis=1, keepdims=True)
        tall = plants.heights_m
        forms = plants.forms
        acacia, palm, column = (forms == form for form in (Species.ACACIA, Species.PALM, Species.COLUMN))
        wide = tall * np.select([acacia, palm], [ACACIA_TRUNK, PALM_TRUNK], TREE_TRUNK)
        wide = np.where(column, COLUMN_TRUNK * plants.radii_m, wide)
        ends = np.where(acacia | palm | column | (forms == Species.CONIFER), _TALL_END, _END)
        return cls(plants.positions_m, axes, ends * tall, wide, _ROOT * tall)

    def breast_radii_m(self) -> Floats:
        """(N,) at breast height, or at half the length of a shorter trunk."""
        return self.foot_radii_m * (1.0 - np.minimum(_BREAST_M / self.lengths_m, 0.5))

    def distance(self, which: Ints, offsets_m: Floats) -> tuple[Floats, Floats]:
        """Signed distances (K,), negative inside, and unit normals (K, 3) of trunks `which` (K,) at places (K, 3) from
        their feet."""
        axis, length, wide = self.axes[which], self.lengths_m[which], self.foot_radii_m[which]
        z = np.einsum("ij,ij->i", offsets_m, axis)
        radial = offsets_m - z[:, None] * axis
        aside = np.linalg.norm(radial, axis=1)
        radial = np.where(aside[:, None] > 1e-9, radial / np.maximum(aside, 1e-9)[:, None], _any_across(axis))
        # In the plane of axis and place, (aside, z), a trunk is a triangle: its side goes from `low` to the tip.
        z_low = -self.roots_m[which]
        low = wide * (1.0 - z_low / length)
        side = np.hypot(low, length - z_low)
        out_aside, out_z = (length - z_low) / side, low / side
        along = np.clip((-(aside - low) * out_z + (z - z_low) * out_aside) / side, 0.0, 1.0)
        to_aside, to_z = aside - low * (1.0 - along), z - z_low - along * (length - z_low)
        away = np.hypot(to_aside, to_z)
        inside = (aside - low) * out_aside + (z - z_low) * out_z < 0.0
        below = inside & (z < z_low)  # under its lower end, deep in the ground
        edge = (away < 1e-9) | inside
        normal_aside = np.where(below, 0.0, np.where(edge, out_aside, to_aside / np.maximum(away, 1e-9)))
        normal_z = np.where(below, -1.0, np.where(edge, out_z, to_z / np.maximum(away, 1e-9)))
        found = np.where(below, z_low - z, np.where(inside, -away, away))
        return found, normal_aside[:, None] * radial + normal_z[:, None] * axis


def touch(trunks: Trunks, centers_m: Floats, radii_m: Floats) -> tuple[Floats, Floats]:
    """Depths (N,) of spheres in the trunk that each is deepest in, or nearest to, and normals (N, 3); -inf and the
    zenith where no trunk is within LOOK_M of the sphere."""
    depth = np.full(len(centers_m), -np.inf)
    normal = centers_m / np.linalg.norm(centers_m, axis=1, keepdims=True)
    if not len(trunks):
        return depth, normal
    # Near one of the spheres, where squares of lengths keep their digits.
    origin = centers_m[0]
    feet, centers = trunks.feet_m - origin, centers_m - origin
    tall = float((trunks.lengths_m + trunks.foot_radii_m + trunks.roots_m).max())
    rows = max(_BLOCK // len(trunks), 1)
    for first in range(0, len(centers), rows):
        block = slice(first, first + rows)
        some, radii = centers[block], radii_m[block]
        away_2 = (some**2).sum(axis=1)[:, None] + (feet**2).sum(axis=1) - 2.0 * (some @ feet.T)
        sphere, trunk = np.nonzero(away_2 < ((radii + (LOOK_M + tall)) ** 2)[:, None])
        if not len(sphere):
            continue
        away, out = trunks.distance(trunk, some[sphere] - feet[trunk])
        deep = radii[sphere] - away
        order = np.lexsort((deep, sphere))
        last = order[np.append(np.flatnonzero(np.diff(sphere[order])), len(order) - 1)]  # the deepest of each sphere
        last = last[away[last] - radii[sphere[last]] <= LOOK_M]
        depth[first + sphere[last]], normal[first + sphere[last]] = deep[last], out[last]
    return depth, normal


def _any_across(axis: Floats) -> Floats:
    """Unit vectors (N, 3) at right angles to unit axes (N, 3)."""
    helper = np.where(np.abs(axis[:, 2:]) < 0.7, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    across = np.cross(axis, helper)
    return across / np.linalg.norm(across, axis=1, keepdims=True)
