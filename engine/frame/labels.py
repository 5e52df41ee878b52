"""Labels of what a pixel shows: numbers of materials, and of things that stand on their own."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from ..made_shaders import made_shader

__all__ = ["FIRST_OF_GAMES", "FIRST_OF_GROUND", "LABELS", "MaterialId", "instances_of"]


class MaterialId(IntEnum):
    """What systems tell apart: values of the output `material`. GLSL: MATERIAL_NONE and so on, in
    ``generated/material_ids.glsl``."""

    NONE = 0
    WATER = 1
    FRESH_WATER = 2
    ICE = 3
    PROPS = 4
    LEAVES = 5
    WOOD = 6
    GROUND = 16


FIRST_OF_GROUND, FIRST_OF_GAMES = int(MaterialId.GROUND), 128
"""The ground's materials count from there in the order of the library's list, whose first is all ground; those that
games register by their places."""
LABELS = ("outputs.albedo", "outputs.instance")
"""Textures that several systems write, each the pixels of its own surfaces."""
_TREES = np.uint64(1 << 31)

made_shader(
    "generated/material_ids.glsl",
    lambda: "".join(f"const uint MATERIAL_{each.name} = {each.value}u;\n" for each in MaterialId),
)


def instances_of(names: NDArray[np.int64]) -> NDArray[np.uint32]:
    """Values (N,) of the output `instance` for the names (N, 5) of trees and shrubs: 2^31 and a hash of the name below
    it (the finaliser of MurmurHash3, a name's numbers one after another). The same tree has the same in all pictures.
    """
    found = np.zeros(len(names), np.uint64)
    for column in np.asarray(names, np.int64).reshape(-1, 5).T:
        found = (found ^ column.astype(np.uint64)) + np.uint64(0x9E3779B97F4A7C15)
        found = (found ^ (found >> np.uint64(33))) * np.uint64(0xFF51AFD7ED558CCD)
        found = (found ^ (found >> np.uint64(33))) * np.uint64(0xC4CEB9FE1A85EC53)
        found ^= found >> np.uint64(33)
    return (_TREES | (found >> np.uint64(33))).astype(np.uint32)
