"""Trees as the GPU has them, and which of them a camera sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.layout import StructLayout, Vec3
from ...engine.made_shaders import made_shader
from ...engine.space import CameraState
from .stand import Plants

__all__ = ["TREE_DTYPE", "seen", "tree_records"]

Floats = NDArray[np.float64]

_NEAREST = 0.72
"""Share of the reach within which all trees are drawn; each of the others has a distance of its own."""
_HIDDEN_SHARE, _HIDDEN_M = 1.0, 1.5
"""A tree whose foot is nearer to the eye than this share of its crown's radius and so many metres is not drawn: nothing
but its leaves would be seen."""
_GROWS = 0.1
"""Share of the reach over which a tree grows from nothing."""


@dataclass
class CoverTree:
    """A tree, in planet axes. GLSL: ``generated/cover.glsl``."""

    foot_m: Annotated[Vec3, "from the camera, or from the middle of a map"]
    height_m: float
    radius_m: Annotated[float, "of the crown"]
    species: Annotated[float, "Species"]
    turn: Annotated[float, "0..1 of a whole one"]
    tint: Annotated[float, "0..1"]


_LAYOUT = StructLayout(CoverTree, "std430")
TREE_DTYPE = _LAYOUT.dtype
made_shader("generated/cover.glsl", lambda: _LAYOUT.glsl)


def tree_records(plants: Plants, middle_m: Floats, grown: Floats | float = 1.0) -> NDArray[np.void]:
    """Records (N,) with places from middle_m (3,), planet-centred; grown: (N,) share of their full size."""
    out = np.zeros(len(plants), TREE_DTYPE)
    out["foot_m"] = plants.positions_m - middle_m
    out["height_m"], out["radius_m"] = plants.heights_m * grown, plants.radii_m * grown
    out["species"], out["turn"], out["tint"] = plants.species, plants.chance[:, 0], plants.chance[:, 1]
    return out


def seen(plants: Plants, camera: CameraState, reach_m: float) -> NDArray[np.void]:
    """Records of the trees in the picture, the nearest first: what lies behind is then rejected early."""
    offset = plants.positions_m - camera.position_m
    away = np.sqrt(np.einsum("ij,ij->i", offset, offset))
    own = reach_m * (_NEAREST + (1.0 - _NEAREST) * np.modf(plants.chance[:, 1] * 13.0)[0])
    grown = np.clip((own - away) / (_GROWS * reach_m), 0.0, 1.0)
    x, y, z = offset @ camera.right, offset @ camera.up, offset @ camera.forward
    size = plants.heights_m + plants.radii_m
    # The planes of the picture's edges, moved out by the tree's size.
    inside = (grown > 0.0) & (z > -size) & (away > np.minimum(_HIDDEN_SHARE * plants.radii_m + _HIDDEN_M, size))
    for part, low, high in ((x, camera.tan_left, camera.tan_right), (y, camera.tan_bottom, camera.tan_top)):
        inside &= part - high * z < size * np.hypot(1.0, high)
        inside &= low * z - part < size * np.hypot(1.0, low)
    which = np.flatnonzero(inside)
    which = which[np.argsort(away[which], kind="stable")]
    return tree_records(plants.only(which), camera.position_m, grown[which])
