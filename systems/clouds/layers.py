"""Layers of cloud as the GPU reads them, and where their noise lies around an anchor."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ...components import CloudLayer, Clouds
from ...engine.blocks.layout import zeros
from .kinds import finer_of, shape_of
from .view_block import MOST_LAYERS, CloudFilter, CloudKind, CloudViewBlock, CloudViewLayer, CloudVolume
from .volumes import NoiseVolume

__all__ = ["frames_at", "has_cirrus", "hidden_fit", "kind_of", "layers_of", "write_layers", "write_noise"]

Floats = NDArray[np.float64]

_THIN = 5.0
"""Optical depth of a whole layer below which its clouds are taken for cirrus, where nobody has said their kind."""
_BROAD_PERIOD = 6.4
"""Of the shape's volume, in thicknesses of the first layer: 16 km for 2.5 km."""
_WIDE, _FINE, _FINEST = 6.871, 0.1031, 0.01173
"""Further periods as shares of it; no small whole numbers are their ratios, so repeats never coincide."""
_THICKNESS = 183.0
"""Period of the noise of optical thickness, in thicknesses of the first layer: 550 km for 3 km. Of many a one with
which clouds over most of the named views are thick."""
_TRAILS = 600.0
"""Widest period of the map of cirrus' trails, in thicknesses of the first layer: 1500 km for 2.5 km."""
_TILT = np.array([[2.0, -1.0, 2.0], [2.0, 2.0, -1.0], [-1.0, 2.0, 2.0]]) / 3.0
"""A rotation about (1, 1, 1)."""


def layers_of(clouds: Clouds) -> list[CloudLayer]:
    """All layers of a Clouds component, lowest base first; those without cloud left out."""
    found = [layer for layer in (clouds, *clouds.layers) if layer.coverage > 0.0 and layer.extinction_per_m > 0.0]
    return sorted(found, key=lambda layer: (layer.base_m, layer.top_m))


def kind_of(layer: CloudLayer) -> CloudKind:
    """Which density a layer has."""
    if layer.density_model == "uniform":
        return CloudKind.UNIFORM
    if layer.kind == "auto":
        thin = layer.extinction_per_m * (layer.top_m - layer.base_m) < _THIN
        return CloudKind.CIRRUS if thin else CloudKind.CUMULUS
    return CloudKind.CIRRUS if layer.kind in ("cirrus", "ice") else CloudKind.CUMULUS


def has_cirrus(layers: list[CloudLayer]) -> bool:
    """Whether any of them is cirrus."""
    return any(kind_of(layer) == CloudKind.CIRRUS for layer in layers)


def frames_at(wind_m_s: float, radius_m: float, time_s: float) -> tuple[Floats, Floats]:
    """(3, 3) each: planet axes to the frame that drifts with the wind, and to the one of tilted noise."""
    angle = math.fmod(wind_m_s * time_s / radius_m, 2.0 * math.pi)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return turn, _TILT @ turn


def hidden_fit(deviations: tuple[float, ...]) -> CloudFilter:
    """How averaging takes the variance of noise away. deviations: of its mip levels."""
    gone = 1.0 - (np.asarray(deviations) / deviations[0]) ** 2
    levels = np.arange(len(gone), dtype=np.float64)
    half = float(np.interp(0.5, gone, levels))
    quarter, most = (float(np.interp(share, gone, levels)) for share in (0.2, 0.8))
    return CloudFilter(half, 0.6 / max(most - quarter, 0.1))


def write_layers(
    block: CloudViewBlock, layers: list[CloudLayer], map_coverage: float, numbers: list[int], thickness_m: float
) -> None:
    """The fields that follow from the component alone. numbers: of the layers in the model's block; thickness_m: of the
    layer that noise is measured by."""
    block.layers = [zeros(CloudViewLayer)] * MOST_LAYERS
    for row, layer in enumerate(layers[:MOST_LAYERS]):
        kind, shape, base, top = kind_of(layer), shape_of(layer), float(layer.base_m), float(layer.top_m)
        mean = 0.6 if kind == CloudKind.CIRRUS else map_coverage
        scale = 1.0 if kind == CloudKind.UNIFORM else layer.coverage / mean
        parabola = float(layer.height_profile == "parabola" and kind != CloudKind.CUMULUS)
        block.layers[row] = CloudViewLayer(
            base, top, 1.0 / (top - base), layer.extinction_per_m, layer.albedo, layer.asymmetry, kind, scale,
            layer.relief * shape.relief, parabola, numbers[row], layer.hooks, layer.veil, layer.bend, shape.follows,
            shape.towers, shape.deep, shape.least_tall, shape.shallow, shape.base, shape.steep, shape.anvil,
            shape.rough, finer_of(layer, _BROAD_PERIOD * thickness_m),
        )  # fmt: skip
    block.layer_count = len(layers)
    block.lowest_m = min((layer.base_m for layer in layers), default=0.0)
    block.highest_m = max((layer.top_m for layer in layers), default=0.0)


def on_chart(points_m: Floats, side: float, radius_m: float) -> Floats:
    """(N, 3) metres on the plane of a half of the planet (side 1: northern, -1: southern), z 0, of points (N, 3).

    Stereographic from the other half's pole (Snyder 1987, 21-2 to 21-4), lengths right at the half's own pole and twice
    as long at the equator. Points close to the other pole are somewhere.
    """
    rise = np.linalg.norm(points_m, axis=1) + side * points_m[:, 2]
    flat = 2.0 * radius_m * points_m[:, :2] / np.maximum(rise, 1e-9 * radius_m)[:, None]
    return np.concatenate([flat, np.zeros((len(flat), 1))], axis=1)


def noise_places(turn: Floats, tilt: Floats, points_m: Floats, thickness_m: float, radius_m: float) -> Floats:
    """(N, 7, 4): the place of points (N, 3) in the period of each volume, 0..1, and 1 / period: broad, wide, fine,
    finest, north, south as in CloudViewBlock; then bend: the place in radii, 1 / radius. points_m: planet-centred. In
    float64: noise is the same from anywhere."""
    period = _BROAD_PERIOD * thickness_m
    turned, tilted = points_m @ turn.T, points_m @ tilt.T
    found = np.empty((len(points_m), 7, 4))
    for row, (at, share) in enumerate((
        (turned, 1.0), (tilted, _WIDE), (tilted, _FINE), (turned, _FINEST),
        (on_chart(turned, 1.0, radius_m), _TRAILS / _BROAD_PERIOD),
        (on_chart(turned, -1.0, radius_m), _TRAILS / _BROAD_PERIOD),
    )):  # fmt: skip
        found[:, row, :3], found[:, row, 3] = np.mod(at / (period * share), 1.0), 1.0 / (period * share)
    found[:, 6, :3], found[:, 6, 3] = turned / radius_m, 1.0 / radius_m
    return found


def write_noise(
    block: CloudViewBlock,
    turn: Floats,
    tilt: Floats,
    anchor_m: Floats,
    radius_m: float,
    thickness_m: float,
    shape_texels: int,
    cell_texels: int,
    rim_texels: int,
    fibre_texels: int,
) -> None:
    """Where noise lies around the anchor: places in periods, formed in float64."""
    period = _BROAD_PERIOD * thickness_m
    block.turn, block.tilt = turn.T, tilt.T
    rows = noise_places(turn, tilt, anchor_m[None], thickness_m, radius_m)[0]
    block.broad, block.wide, block.fine, block.finest, block.north, block.south, block.bend = (
        CloudVolume(row[:3], row[3]) for row in rows
    )
    block.thickness_m, block.fibre_levels = thickness_m, math.log2(fibre_texels)
    block.thickness_periods = radius_m / (_THICKNESS * thickness_m)
    block.thickness_level = math.log2(cell_texels / (_THICKNESS * thickness_m))
    block.broad_level = math.log2(shape_texels / period)
    block.wide_level = math.log2(cell_texels / (period * _WIDE))
    block.fine_level = math.log2(rim_texels / (period * _FINE))
    block.finest_level = math.log2(rim_texels / (period * _FINEST))


def write_filter(block: CloudViewBlock, shape: NoiseVolume, rims: NoiseVolume, cells: NoiseVolume) -> None:
    """How averaging takes the noise's variance away."""
    block.shape_filter, block.rim_filter = hidden_fit(shape.deviations), hidden_fit(rims.deviations)
    block.cell_filter = hidden_fit(cells.deviations)
