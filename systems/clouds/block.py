"""The clouds' uniform block (binding 11): what shaders read that march through clouds or ask for their shadow."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Any

from ...components import MOST_CLOUD_LAYERS
from ...engine.gpu.layout import array
from .model import CloudModel

__all__ = ["CloudBlock", "CloudModelLayer", "cloud_block"]


@dataclass
class CloudModelLayer:
    """One layer that takes light: ``cloud_model.layers[i]``."""

    base_m: Annotated[float, "height"] = 0.0
    top_m: Annotated[float, "height"] = 0.0
    per_thickness: Annotated[float, "1/m: 1 / (top_m - base_m)"] = 0.0
    extinction_per_m: Annotated[float, "where the cloud is densest"] = 0.0
    albedo: float = 0.0
    asymmetry: float = 0.0
    parabola: Annotated[bool, "it thins out towards base and top"] = False


@dataclass
class CloudBlock:
    """One planet's clouds. GLSL: ``#include "generated/cloud_model.glsl"``, instance ``cloud_model``.

    The defaults are no clouds.
    """

    radius_m: Annotated[float, "the planet's"] = 6.36e6
    layer_count: Annotated[int, "of those that take light; the first of the array"] = 0
    layers: Annotated[Any, array(CloudModelLayer, MOST_CLOUD_LAYERS)] = field(
        default_factory=lambda: [CloudModelLayer() for _ in range(MOST_CLOUD_LAYERS)]
    )


def cloud_block(model: CloudModel) -> CloudBlock:
    """The block of these clouds; layers that take no light are left out."""
    block = CloudBlock(model.radius_m, len(model.present))
    for k, layer in enumerate(model.present):
        block.layers[k] = CloudModelLayer(
            layer.base_m, layer.top_m, 1.0 / (layer.top_m - layer.base_m), layer.extinction_per_m, layer.albedo,
            layer.asymmetry, layer.height_profile == "parabola",
        )  # fmt: skip
    return block
