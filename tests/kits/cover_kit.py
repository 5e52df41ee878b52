"""What tests of trees and grass share."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import planetfall as pf
from planetfall.systems.cover.stand import Plants

__all__ = ["PLACE", "names_of", "woods"]

PLACE = pf.direction(9.23, 29.98)
"""In a closed forest of Earth."""


@contextmanager
def woods() -> Iterator[pf.Scene]:
    """The scene without clouds, without plants of its own and rivers, for which somebody would have to wait."""
    with pf.load_scene("woods") as scene:
        scene.planet[pf.Terrain].rivers = 0.0
        scene.planet[pf.Cover].species = ()
        scene.planet.remove(pf.Clouds)
        yield scene


def names_of(trees: Plants) -> set[tuple[int, ...]]:
    return set(map(tuple, trees.names.tolist()))
