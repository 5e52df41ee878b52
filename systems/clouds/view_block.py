"""The clouds' uniform block (binding 14): layers, and where their noise and weather lie around the anchor."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from enum import IntEnum
from typing import Annotated, Any

import numpy as np

from ...engine.gpu import GpuScope, UniformBlock
from ...engine.gpu.bindings import CLOUD_VIEW_BLOCK
from ...engine.gpu.layout import Vec4, array

__all__ = [
    "MOST_INTERVALS", "MOST_LAYERS", "MOST_MAPS", "CloudKind", "CloudViewBlock",
    "cloud_view_uniforms",
]  # fmt: skip

MOST_LAYERS = 4
MOST_MAPS = 6
MOST_INTERVALS = 8
"""Between heights at which maps of the shadow know how much sunlight is left."""


class CloudKind(IntEnum):
    """Which density a layer has. GLSL: CLOUD_WATER, ..."""

    WATER = 0
    """Billows and sheets, as the weather's cover, towers and depth have them."""
    ICE = 1
    """Streaks and veils along the winds aloft, as the weather's high cloud has them."""
    UNIFORM = 2
    """The whole shell alike, whatever the weather."""


def _rows(count: int) -> Callable[[], Any]:
    return lambda: np.zeros((count, 4), np.float32)


@dataclass
class CloudViewBlock:
    """One view's clouds. GLSL: ``#include "generated/cloud_view.glsl"``, instance ``cloud_view``."""

    shell: Annotated[Any, array(Vec4, MOST_LAYERS)] = field(default_factory=_rows(MOST_LAYERS))
    """(base, top as heights, 1 / thickness, extinction per metre where the cloud is densest)"""
    droplets: Annotated[Any, array(Vec4, MOST_LAYERS)] = field(default_factory=_rows(MOST_LAYERS))
    """(albedo, asymmetry, CloudKind, coverage over that of the map)"""
    shape: Annotated[Any, array(Vec4, MOST_LAYERS)] = field(default_factory=_rows(MOST_LAYERS))
    """(1 for a profile like a parabola, number of the layer in CloudBlock, 0, 0)"""
    counts: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """(layers, lowest base, highest top, 0)"""
    turn: Annotated[Any, array(Vec4, 3)] = field(default_factory=_rows(3))
    """Columns: planet axes to the frame that drifts with the wind."""
    tilt: Annotated[Any, array(Vec4, 3)] = field(default_factory=_rows(3))
    """The same, turned out of all axes: the second volume's frame, so that its repeats fall elsewhere."""
    broad: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """(the anchor's place in the volume's period, 1 / period): shape, in the frame `turn`"""
    wide: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """shape once more, in the frame `tilt`"""
    fine: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """rims, in the frame `tilt`"""
    finest: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """rims near the eye, in the frame `turn`"""
    fibre: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """the shape's volume for streaks, in the frame `turn`, after its axes have been stretched"""
    veil: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """the same, wider"""
    bend: Vec4 = (0.0, 0.0, 0.0, 1.0)
    """(the anchor's place in the frame `turn`, in radii, 1 / radius): where the winds aloft meander"""
    stretch: Vec4 = (1.0, 1.0, 1.0, 0.0)
    """of those axes: less across the poles' axis, so that streaks lie along the winds; w: way through one
    cloud of those that are too small to be told apart, in metres"""
    hiding: Vec4 = (0.0, 1.0, 0.0, 1.0)
    """level of the shape's and of the rims' volume at which half of the variance is gone, with the slopes there"""
    weather: Vec4 = (0.0, 1.0, 0.0, 1.0)
    """(share of the second map, inner texels a side, border in texels, size of a texel in metres)"""
    fade: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """(levels of the shape's volume for a footprint of 1 m: broad, wide, fine, finest)"""
    shadow: Vec4 = (0.0, 0.0, 0.0, 0.0)
    """(reference height of the maps of the shadow, how many there are, intervals of height in them, texels a side)"""
    casts: Vec4 = (1.0, 1.0, 1.0, 0.0)
    """(shadows on surfaces, light of the cloudy sky on them, clouds in the sea: 1 or 0 each; 0)"""
    spans: Annotated[Any, array(Vec4, MOST_LAYERS)] = field(default_factory=_rows(MOST_LAYERS))
    """heights with cloud, lowest first: (base, 1 / thickness, intervals of height, 0)"""
    shadow_from: Annotated[Any, array(Vec4, MOST_MAPS)] = field(default_factory=_rows(MOST_MAPS))
    """(from each map's middle to the anchor's foot in planet axes, 1 / its half width)"""
    shadow_u: Annotated[Any, array(Vec4, MOST_MAPS)] = field(default_factory=_rows(MOST_MAPS))
    """each map's axes; w of the first: 1 once it is drawn, of the second: the finest that is"""
    shadow_v: Annotated[Any, array(Vec4, MOST_MAPS)] = field(default_factory=_rows(MOST_MAPS))


def cloud_view_uniforms(gpu: GpuScope) -> UniformBlock:
    """The block's buffer; from then on shaders find its declaration, with the numbers that belong to it."""
    made = gpu.uniform_block(CloudViewBlock, CLOUD_VIEW_BLOCK)
    constants = {**{f"CLOUD_{kind.name}": kind.value for kind in CloudKind}, "CLOUD_VIEW_LAYERS": MOST_LAYERS,
                 "CLOUD_MOST_MAPS": MOST_MAPS, "CLOUD_MOST_INTERVALS": MOST_INTERVALS}  # fmt: skip
    text = "".join(f"const int {name} = {value};\n" for name, value in constants.items())
    gpu.gpu.shaders.add_virtual("generated/cloud_view.glsl", text + made.layout.block(CLOUD_VIEW_BLOCK, "cloud_view"))
    return made
