"""Kinds of trees and shrubs: those that every planet with Cover has, and a planet's own (`CoverSpecies`)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...components import Cover, CoverSpecies
from .growth import Climate, ramp

__all__ = ["OwnSpecies", "Species", "forms_of", "of_own", "tallest_m"]

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]


class Species(IntEnum):
    """Kinds of trees: values of `Plants.species`, and of a tree's record on the GPU. Of a planet's own, the k-th has 8
    (k + 1) more than the one that it is shaped like."""

    BROADLEAF = 0
    CONIFER = 1
    SHRUB = 2
    ACACIA = 3
    """Flat-topped, of the savanna"""
    PALM = 4
    """Along warm coasts"""
    DEAD = 5
    """A broadleaf tree that still stands"""
    COLUMN = 6
    """A shape of planets' own alone: a ribbed column with arms"""
    ROSETTE = 7
    """The same: fronds from the ground"""


_FORMS = {
    "broadleaf": Species.BROADLEAF, "conifer": Species.CONIFER, "flat": Species.ACACIA, "palm": Species.PALM,
    "column": Species.COLUMN, "shrub": Species.SHRUB, "rosette": Species.ROSETTE,
}  # fmt: skip
_EDGE = 0.05
"""Of warmth and humidity, to either side of where a species begins and ends."""
_MOST_CROWN = 0.6
"""Of those that are drawn as they stand: quads around trees hold no wider crown."""


def forms_of(species: NDArray[np.integer]) -> Ints:
    """What they (N,) are shaped like: values of Species."""
    return np.asarray(species, dtype=np.int64) & 7


def of_own(species: NDArray[np.integer]) -> Ints:
    """Which of `Cover.species` they (N,) are; -1: none of them."""
    return (np.asarray(species, dtype=np.int64) >> 3) - 1


def tallest_m(cover: Cover) -> float:
    """Height that hardly a tree of the planet is above."""
    return max(cover.height_m, *(each.height_m for each in cover.species), 0.0)


@dataclass(frozen=True)
class OwnSpecies:
    """A planet's own of one layer, with their numbers in `Cover.species`."""

    kinds: tuple[CoverSpecies, ...]
    codes: Ints
    """(S,) values of `Plants.species`"""

    @classmethod
    def of(cls, species: Sequence[CoverSpecies], low: bool) -> OwnSpecies:
        """low: of the shrubs' layer."""
        found = [k for k, each in enumerate(species) if each.low is low and each.share > 0.0]
        codes = [8 * (k + 1) + int(_FORMS[species[k].form]) for k in found]
        return cls(tuple(species[k] for k in found), np.array(codes, dtype=np.int64))

    def __len__(self) -> int:
        return len(self.kinds)

    @cached_property
    def aside_m(self) -> Floats:
        """(S,) how far from water they stand at most; 0: anywhere."""
        return np.array([each.waterside_m for each in self.kinds])

    @property
    def along_water(self) -> bool:
        """Whether some grow along water alone."""
        return bool(self.aside_m.any())

    @cached_property
    def shore_m(self) -> Floats:
        """(S,) how deep in the sea they stand at most; 0: on land."""
        return np.array([each.shore_m for each in self.kinds])

    @property
    def on_shores(self) -> bool:
        """Whether some grow in the sea's shallows."""
        return bool(self.shore_m.any())

    def reaches(self, from_water_m: Floats) -> NDArray[np.bool_]:
        """(S, N) which stand so far from water (N,)."""
        aside_m = self.aside_m[:, None]
        return (aside_m == 0.0) | (from_water_m < aside_m)

    def in_sea(self, above_sea_m: Floats, highest_m: float) -> NDArray[np.bool_]:
        """(S, N) which stand in the sea so far above its level (N,). highest_m: up to which those may."""
        shore_m = self.shore_m[:, None]
        return (shore_m > 0.0) & (above_sea_m > -shore_m) & (above_sea_m < highest_m)

    def shares(self, climate: Climate) -> Floats:
        """(S, *shape of the climate) of the places that have one of each, as far from water as they may stand."""
        parts = [each.share * self._fits(each, climate) for each in self.kinds]
        return np.stack(parts) if parts else np.zeros((0, *climate.warmth.shape))

    @staticmethod
    def _fits(kind: CoverSpecies, climate: Climate) -> Floats:
        found = np.ones_like(climate.warmth)
        for value, least, most in (
            (climate.warmth, kind.coldest, kind.warmest),
            (climate.humidity, kind.driest, kind.wettest),
        ):
            found *= ramp(least - _EDGE, least + _EDGE, value) if least > 0.0 else 1.0
            found *= ramp(most + _EDGE, most - _EDGE, value) if most < 2.0 else 1.0
        return found * (climate.warmth > 0.0)

    def sizes(self, which: Ints, chance: Floats) -> tuple[Floats, Floats]:
        """Heights and radii of crowns (N,), metres; which: (N,) of the kinds. chance: of [0, 1); few are grown."""
        tall, crown = (np.array([getattr(each, name) for each in self.kinds]) for name in ("height_m", "crown"))
        low = np.array([each.low for each in self.kinds])
        grown = np.where(low[which], 0.35 + 0.85 * chance**2, 0.45 + 0.65 * np.sqrt(chance))
        height = tall[which] * grown
        wide = np.where(low[which], crown[which], np.minimum(crown[which], _MOST_CROWN))
        return height, height * wide * (0.85 + 0.3 * np.modf(chance * 7.0)[0])
