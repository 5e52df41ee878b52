"""The clouds' uniform block: what shaders read that march through clouds or ask for their shadow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

from ...components import MOST_CLOUD_LAYERS
from ...engine.blocks.layout import array, zeros
from .model import CloudModel

__all__ = ["CloudBlock", "CloudModelLayer", "cloud_block"]


@dataclass
class CloudModelLayer:
    """One layer that takes light: ``cloud_model.layers[i]``."""

    base_m: Annotated[float, "height"]
    top_m: Annotated[float, "height"]
    per_thickness: Annotated[float, "1/m: 1 / (top_m - base_m)"]
    extinction_per_m: Annotated[float, "where the cloud is densest"]
    albedo: float
    asymmetry: float
    parabola: Annotated[bool, "it thins out towards base and top"]


@dataclass
class CloudBlock:
    """One planet's clouds. GLSL: ``#include "generated/cloud_model.glsl"``, instance ``cloud_model``."""

    radius_m: Annotated[float, "the planet's"]
    layer_count: Annotated[int, "of those that take light; the first of the array"]
    layers: Annotated[Any, array(CloudModelLayer, MOST_CLOUD_LAYERS)]


def cloud_block(model: CloudModel) -> CloudBlock:
    """The block of these clouds; layers that take no light are left out."""
    layers = [
        CloudModelLayer(
            layer.base_m, layer.top_m, 1.0 / (layer.top_m - layer.base_m), layer.extinction_per_m, layer.albedo,
            layer.asymmetry, layer.height_profile == "parabola",
        )
        for layer in model.present
    ]  # fmt: skip
    none = [zeros(CloudModelLayer)] * (MOST_CLOUD_LAYERS - len(layers))
    return CloudBlock(model.radius_m, len(layers), layers + none)
