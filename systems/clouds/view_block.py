"""The clouds' uniform block: layers, and where their noise and weather lie around the anchor."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Any

from ...engine.blocks.bindings import CLOUD_VIEW_BLOCK
from ...engine.blocks.layout import Mat3, Vec3, array
from ...engine.gpu import GpuScope, UniformBlock

__all__ = [
    "CLOUD_VIEW", "MOST_INTERVALS", "MOST_LAYERS", "MOST_MAPS", "CloudFilter", "CloudKind", "CloudShadowMap",
    "CloudSpan", "CloudViewBlock", "CloudViewLayer", "CloudVolume", "cloud_view_uniforms",
]  # fmt: skip

CLOUD_VIEW = "clouds.view"
"""A view's block, lent to the graph."""
MOST_LAYERS = 4
MOST_MAPS = 6
MOST_INTERVALS = 8
"""Between heights at which maps of the shadow know how much sunlight is left."""


class CloudKind(IntEnum):
    """Which density a layer has. GLSL: CLOUD_CUMULUS, ..."""

    CUMULUS = 0
    """Billows and sheets, as the weather's cover, towers and depth have them."""
    CIRRUS = 1
    """Fibres, hooks and veils, as the weather's high cloud has them."""
    UNIFORM = 2
    """The whole shell alike, whatever the weather."""
    WATER, ICE = CUMULUS, CIRRUS
    """Other names of theirs, by what such clouds are of."""


@dataclass
class CloudViewLayer:
    """One layer with cloud: ``cloud_view.layers[i]``."""

    base_m: Annotated[float, "height"]
    top_m: Annotated[float, "height"]
    per_thickness: Annotated[float, "1/m: 1 / (top_m - base_m)"]
    extinction_per_m: Annotated[float, "where the cloud is densest"]
    albedo: float
    asymmetry: float
    kind: Annotated[int, "CLOUD_CUMULUS, CLOUD_CIRRUS or CLOUD_UNIFORM"]
    cover_scale: Annotated[float, "its cover over that of the weather's map"]
    relief: Annotated[float, "of billows on cumulus"]
    parabola: Annotated[float, "1: it thins out towards base and top as a parabola; 0: it does not"]
    model: Annotated[int, "its number in cloud_model.layers"]
    hooks: Annotated[float, "of cirrus: share of its fibres that begin in tufts"]
    veil: Annotated[float, "of cirrus: between its fibres"]
    bend: Annotated[float, "of cirrus: how far its fibres bend"]
    follows: Annotated[float, "1: towers and depth are the weather's; 0: of a kind by name, those that follow"]
    towers: Annotated[float, "as CloudWeather has it; 0 where the weather is followed"]
    deep: Annotated[float, "as CloudWeather has it; 0 where the weather is followed"]
    least_tall: Annotated[float, "how much of the thickness clouds fill that do not tower"]
    shallow: Annotated[float, "extinction of sheets against that of towers"]
    base: Annotated[float, "share of the height in which the base begins"]
    steep: Annotated[float, "how sharply cover ends at the top: 1 domes, 5 a lid"]
    anvil: Annotated[float, "cover of what spreads at the top, against that of the base"]
    rough: Annotated[float, "factor on the noise"]
    finer: Annotated[float, "whole number: how many times finer its noise is"]


@dataclass
class CloudVolume:
    """Where a volume of noise, which repeats, lies around the anchor."""

    origin: Annotated[Vec3, "the anchor's place, in periods"]
    per_m: Annotated[float, "1 / period"]


@dataclass
class CloudFilter:
    """How averaging takes a volume's variance away."""

    half_level: Annotated[float, "mip level at which half of it is gone"]
    per_level: Annotated[float, "share of it that goes with a level there"]


@dataclass
class CloudSpan:
    """Heights with cloud, as maps of the shadow divide them."""

    base_m: float
    per_thickness: Annotated[float, "1/m"]
    intervals: Annotated[float, "of height, so many"]


@dataclass
class CloudShadowMap:
    """Where a map of the shadow lies: it is 2 wide and 2 long."""

    to_anchor_m: Annotated[Vec3, "from its middle to the anchor's foot, planet axes"]
    per_half_width: Annotated[float, "1/m"]
    u: Annotated[Vec3, "its axes, planet axes; this one divided by how many times longer than wide it is"]
    drawn: Annotated[float, "1 once it is"]
    v: Vec3


@dataclass
class CloudViewBlock:
    """One view's clouds. GLSL: ``#include "generated/cloud_view.glsl"``, instance ``cloud_view``.

    Noise is looked up in two frames: `turn`, which drifts with the wind, and `tilt`, turned against it out of all axes,
    so that repeats fall elsewhere.
    """

    layers: Annotated[Any, array(CloudViewLayer, MOST_LAYERS)]
    layer_count: int
    lowest_m: Annotated[float, "base of all layers"]
    highest_m: Annotated[float, "top of all layers"]
    turn: Annotated[Mat3, "planet axes to the frame that drifts with the wind"]
    tilt: Annotated[Mat3, "planet axes to the frame of the second volume"]
    broad: Annotated[CloudVolume, "shape, in the frame turn"]
    wide: Annotated[CloudVolume, "cells and clusters, in the frame tilt"]
    fine: Annotated[CloudVolume, "rims, in the frame tilt"]
    finest: Annotated[CloudVolume, "rims near the eye, in the frame turn"]
    north: Annotated[CloudVolume, "the map of cirrus' trails on the northern half, in the frame turn: x and y"]
    south: Annotated[CloudVolume, "the same on the southern half"]
    bend: Annotated[CloudVolume, "in radii, frame turn: from the planet's centre"]
    thickness_m: Annotated[float, "of the first layer"]
    broad_level: Annotated[float, "mip level for a footprint of 1 m"]
    wide_level: float
    fine_level: float
    finest_level: float
    thickness_spread: Annotated[float, "standard deviation of the logarithm of clouds' optical thickness"]
    thickness_periods: Annotated[float, "of its noise in a radian"]
    thickness_level: float
    fibre_levels: Annotated[float, "mip level of the map of trails at which it is one texel"]
    shape_filter: CloudFilter
    rim_filter: CloudFilter
    cell_filter: CloudFilter
    second_map_share: Annotated[float, "of the second of the two maps of weather"]
    map_texels: Annotated[float, "of a map of weather: inner ones a side"]
    map_border: Annotated[float, "texels"]
    map_texel_m: float
    shadow_height_m: Annotated[float, "reference height of the maps of the shadow"]
    shadow_map_count: int
    shadow_intervals: Annotated[int, "of height in them"]
    shadow_texels: Annotated[float, "a side"]
    finest_map: Annotated[float, "number of the first that is drawn"]
    surface_shadows: Annotated[float, "1 or 0: shadows on surfaces"]
    surface_skylight: Annotated[float, "1 or 0: light of the cloudy sky on them"]
    sea_clouds: Annotated[float, "1 or 0: clouds in the sea"]
    spans: Annotated[Any, array(CloudSpan, MOST_LAYERS)]
    """Lowest first."""
    shadow_maps: Annotated[Any, array(CloudShadowMap, MOST_MAPS)]
    """Finest first."""


def cloud_view_uniforms(gpu: GpuScope) -> UniformBlock:
    """The block's buffer; from then on shaders find its declaration, with the numbers that belong to it."""
    made = gpu.uniform_block(CloudViewBlock, CLOUD_VIEW_BLOCK)
    constants = {**{f"CLOUD_{kind.name}": kind.value for kind in CloudKind}, "CLOUD_VIEW_LAYERS": MOST_LAYERS,
                 "CLOUD_MOST_MAPS": MOST_MAPS, "CLOUD_MOST_INTERVALS": MOST_INTERVALS}  # fmt: skip
    text = "".join(f"const int {name} = {value};\n" for name, value in constants.items())
    gpu.shaders.add_virtual("generated/cloud_view.glsl", text + made.layout.block(CLOUD_VIEW_BLOCK, "cloud_view"))
    return made
