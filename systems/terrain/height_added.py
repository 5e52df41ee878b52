"""What the height function adds to its noises, in numpy: craters and a height map."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.real_ground.real_ground import MOST_ROUGH
from .height_map import map_gradients, map_values
from .height_model import Model

__all__ = ["MOST_ROUGH", "added_gradients", "added_heights"]

Floats = NDArray[np.float64]


def added_heights(points: Floats, model: Model) -> tuple[Floats | float, Floats | float]:
    """Metres that craters and map add at points (3, N), and the map's own roughness; 0.0 where there are none."""
    added: Floats | float = model.craters.heights(points) if model.craters else 0.0
    rougher: Floats | float = 0.0
    if model.params.height_map:
        height, differences = map_values(model.params.height_map, points)
        added = added + height
        rougher = np.minimum(model.map_roughness * differences, MOST_ROUGH)
    return added, rougher


def added_gradients(points: Floats, model: Model, footprint_m: Floats | None) -> tuple[Any, Any, Any, Any]:
    """`added_heights`, each followed by its gradient (3, N)."""
    added, d_added = model.craters.heights_gradients(points, footprint_m) if model.craters else (0.0, 0.0)
    found = model.params.height_map
    if found is None:
        return added, d_added, 0.0, 0.0
    height, slope, rough, d_rough = map_gradients(found, points, model.params.radius_m, footprint_m)
    rough, d_rough = model.map_roughness * rough, model.map_roughness * d_rough
    below = rough < MOST_ROUGH
    return added + height, d_added + slope, np.where(below, rough, MOST_ROUGH), np.where(below, d_rough, 0.0)
