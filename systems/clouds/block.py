"""The clouds' uniform block (binding 11): what shaders read that march through clouds or ask for their shadow."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from ...components import MOST_CLOUD_LAYERS
from ...engine.gpu.layout import IVec4, Vec4, array
from .model import CloudModel

__all__ = ["CloudBlock", "cloud_block"]


def _none() -> Any:
    return np.zeros((MOST_CLOUD_LAYERS, 4), np.float32)


@dataclass
class CloudBlock:
    """One planet's clouds. GLSL: ``#include "generated/cloud_model.glsl"``, instance ``cloud_model``.

    The defaults are no clouds.
    """

    planet: Vec4 = (6.36e6, 1.0, 0.0, 0.0)
    """(radius, lowest base, highest top, unused), metres; the layers that are present lie between the two"""
    counts: IVec4 = (0, 0, 0, 0)
    """x: layers that are present, the first of the arrays below"""
    shells: Annotated[Any, array(Vec4, MOST_CLOUD_LAYERS)] = field(default_factory=_none)
    """(base, top, 1 / thickness, extinction per metre where densest)"""
    droplets: Annotated[Any, array(Vec4, MOST_CLOUD_LAYERS)] = field(default_factory=_none)
    """(albedo, asymmetry, 1 for a parabola over the height, 1 for weather)"""
    weather: Annotated[Any, array(Vec4, MOST_CLOUD_LAYERS)] = field(default_factory=_none)
    """(coverage, number among the component's layers, unused, unused)"""


def cloud_block(model: CloudModel) -> CloudBlock:
    """The block of these clouds; layers that take no light are left out."""
    shells, droplets, weather = _none(), _none(), _none()
    for k, layer in enumerate(model.present):
        shells[k] = layer.base_m, layer.top_m, 1.0 / (layer.top_m - layer.base_m), layer.extinction_per_m
        droplets[k] = (
            layer.albedo, layer.asymmetry, layer.height_profile == "parabola", layer.density_model == "weather",
        )  # fmt: skip
        weather[k] = layer.coverage, model.layers.index(layer), 0.0, 0.0
    count = len(model.present)
    low, high = (model.lowest_m, model.highest_m) if count else (1.0, 0.0)
    return CloudBlock((model.radius_m, low, high, 0.0), (count, 0, 0, 0), shells, droplets, weather)
