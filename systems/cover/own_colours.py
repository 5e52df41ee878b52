"""A planet's own species as shaders have them: assets/shaders/cover/own_species.glsl."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...components import MOST_SPECIES, CoverSpecies
from ...engine.display import reflectance
from ...engine.wavelengths import Nanometres

__all__ = ["own_defines", "packed"]


def own_defines(species: Sequence[CoverSpecies]) -> dict[str, int]:
    """What shaders of plants are compiled with: nothing where the planet has none of its own."""
    return {"COVER_SPECIES": 1, "MOST_SPECIES": MOST_SPECIES} if species else {}


def packed(species: Sequence[CoverSpecies], nm: Nanometres) -> NDArray[np.float32]:
    """(3 MOST_SPECIES, 4): of each its albedo at three wavelengths and how closed its crown is, the albedo of leaves
    that have turned and its translucency, and whether it sheds them."""
    rows = np.zeros((MOST_SPECIES, 3, 4), dtype=np.float32)
    for row, each in zip(rows, species, strict=False):
        row[:2, :3] = reflectance(np.array([each.albedo, each.autumn_albedo]), nm)
        row[:, 3] = each.leaf_density, each.translucency, 0.0
        row[2, 0] = each.sheds
    return rows.reshape(-1, 4)
