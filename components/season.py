"""The time of year that a planet's ground and trees show."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from .cover import Cover
from .terrain import Terrain

__all__ = ["in_season", "seasonal", "winter_at", "year_of"]

_TROPICS, _TEMPERATE = 0.391, 0.643
"""Sines of latitudes, 23 and 40 degrees, below which there are no seasons, and from which they are whole; as SEASONAL
of assets/shaders/common/season.glsl."""


def in_season(cover: Cover, terrain: Terrain) -> Cover:
    """The trees with the time of year of their ground where that has one, or their own if it differs from its default.

    A changed copy, or itself.
    """
    (own,) = (f.default for f in dataclasses.fields(Cover) if f.name == "season")
    if terrain.season is None or cover.season != own:
        return cover
    return dataclasses.replace(cover, season=terrain.season)


def year_of(season: float, south: NDArray[np.bool_] | bool) -> NDArray[np.float64]:
    """Time of year of either half, 0..1 from its midwinter on."""
    return np.mod(season + np.where(south, 0.5, 0.0), 1.0)


def seasonal(sine: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """0 in the tropics .. 1 where broadleaves shed all their leaves. sine: of latitudes (N,)."""
    return np.clip((np.abs(sine) - _TROPICS) / (_TEMPERATE - _TROPICS), 0.0, 1.0)


def winter_at(season: float | None, sine: NDArray[np.float64]) -> NDArray[np.float64]:
    """(N,) how far it is winter: 0 in the summer half of the year and in the tropics, 1 in midwinter where leaves fall.
    sine: of latitudes (N,). season: None: never."""
    if season is None:
        return np.zeros(len(sine))
    return seasonal(sine) * np.maximum(np.cos(2.0 * np.pi * year_of(season, sine < 0.0)), 0.0)
