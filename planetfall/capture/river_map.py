"""A map of a planet's rivers: longitude across, latitude down."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from ..systems.terrain.drainage.climate import ClimateParams, temperature_c
from ..systems.terrain.drainage.network import YEAR_S, Network

__all__ = ["river_map"]

_SEA, _DRY, _WET, _SNOW, _BROOK, _WATER = (
    np.array(color, dtype=np.float64)
    for color in ((30, 60, 110), (205, 178, 120), (55, 115, 55), (235, 238, 240), (110, 150, 200), (25, 75, 190))
)
_GREEN_MM = 600.0
"""Runoff of a year where the map is at its greenest."""
_DRY_M_YEAR = 0.3
"""Where nothing rains lines are drawn as if so much ran off."""
_LEAST_M3_S, _DECADES = 60.0, 2.7
"""Rivers from this one up are drawn, stronger up to 500 times as much water."""


def river_map(network: Network, size: tuple[int, int], climate: ClimateParams) -> NDArray[np.uint8]:
    """(H, W, 3): land from dry to wet by what runs off it, white where the mean of the year freezes at sea level."""
    width, height = size
    longitude = ((np.arange(width) + 0.5) / width * 2.0 - 1.0) * np.pi
    latitude = (0.5 - (np.arange(height) + 0.5) / height) * np.pi
    level = np.cos(latitude)[:, None]
    directions = np.stack(
        np.broadcast_arrays(level * np.cos(longitude), level * np.sin(longitude), np.sin(latitude)[:, None]), axis=-1
    ).reshape(-1, 3)
    index = network.index[network.grid.locate(directions)]
    cell = np.maximum(index, 0)
    land = (index >= 0) & ~network.sea[cell]
    wet = np.sqrt(np.clip(network.runoff_mm[cell] / _GREEN_MM, 0.0, 1.0))[:, None]
    color = _DRY + (_WET - _DRY) * wet
    cold = np.clip(-0.25 * temperature_c(directions, np.zeros(len(directions)), climate), 0.0, 1.0)[:, None]
    color += (_SNOW - color) * cold
    picture = Image.fromarray(np.rint(np.where(land[:, None], color, _SEA)).astype(np.uint8).reshape(height, width, 3))
    _draw_rivers(picture, network)
    return np.asarray(picture)


def _draw_rivers(picture: Image.Image, network: Network) -> None:
    """Lines from cell to cell, those with more water over those with less, wider and bluer."""
    width, height = picture.size
    water = np.where(network.sea, 0.0, network.discharge_m3_s)
    if not water.any():  # a dry world shows its valleys, by the land that they drain
        water = np.where(network.sea, 0.0, network.catchment_m2 * (_DRY_M_YEAR / YEAR_S))
    drawn = np.flatnonzero(water >= _LEAST_M3_S)
    drawn = drawn[np.argsort(water[drawn], kind="stable")]
    strength = np.minimum(np.log10(water[drawn] / _LEAST_M3_S) / _DECADES, 1.0)
    ends = []
    for cell in (drawn, network.receiver[drawn]):
        x, y, z = network.places[cell].T
        across = (np.arctan2(y, x) / (2.0 * np.pi) + 0.5) * width
        ends.append(np.stack([across, (0.5 - np.arcsin(np.clip(z, -1.0, 1.0)) / np.pi) * height], axis=1) - 0.5)
    pen = ImageDraw.Draw(picture)
    for start, end, strong in zip(*ends, strength, strict=True):
        if abs(end[0] - start[0]) < 0.5 * width:  # not across the date line
            shade = _BROOK + (_WATER - _BROOK) * strong
            line = (*start.tolist(), *end.tolist())
            pen.line(line, fill=tuple(int(v) for v in shade), width=1 + int(strong * width / 1024.0))
