"""Trees that a game has cut down: Cover.felled by plot, so that one more costs a plot and not all of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from ...components import Cover
from ...engine.settings import revision
from .stand import Plants, Plot

__all__ = ["Felled", "grows"]

_SEEN = (
    "felled", "season", "snow", "grass", "grass_m", "flowers", "broadleaf_albedo", "conifer_albedo", "bark_albedo",
)  # fmt: skip
_GROWS = tuple(name for name in Cover.__dataclass_fields__ if name not in (*_SEEN, "species"))
_OF_SPECIES = attrgetter("form", "share", "height_m", "crown", "coldest", "warmest", "driest", "wettest")


def grows(cover: Cover) -> tuple[object, ...]:
    """Trees are made anew when this changes: colours and felled trees are no part of it."""
    return (revision(cover, *_GROWS), *map(_OF_SPECIES, cover.species))


Name = tuple[int, int, int, int, int]


class Felled:
    """Which trees are felled. `refresh` takes over the list of a component."""

    def __init__(self) -> None:
        self._list: tuple[Name, ...] = ()
        self._numbers: dict[Plot, set[int]] = {}

    def __contains__(self, name: Name) -> bool:
        *plot, number = name
        return number in self._numbers.get(Plot(*plot), ())

    def refresh(self, felled: tuple[Name, ...]) -> set[Plot]:
        """Take over Cover.felled; the plots in which something changed."""
        before = self._list
        if felled is before:
            return set()
        self._list = felled
        if felled[: len(before)] == before:  # a game that fells one more
            return set(self._add(felled[len(before) :]))
        old, new = set(before), set(felled)
        gone = set()
        for *plot, number in old - new:
            gone.add(Plot(*plot))
            self._numbers[Plot(*plot)].discard(number)
        return gone | set(self._add(new - old))

    def standing(self, plot: Plot, grown: Plants) -> Plants:
        """Of the trees that have grown in a plot those that still stand."""
        numbers = self._numbers.get(plot)
        if not numbers or not len(grown):
            return grown
        down: NDArray[np.bool_] = np.isin(grown.names[:, 4], list(numbers))
        return grown.only(~down) if down.any() else grown

    def _add(self, names: Iterable[Name]) -> Iterator[Plot]:
        for face, level, i, j, number in names:
            plot = Plot(face, level, i, j)
            self._numbers.setdefault(plot, set()).add(number)
            yield plot
