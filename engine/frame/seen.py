"""Whether a view may show any of a planet, or of its ground: what passes are skipped by, all together, while not."""

from __future__ import annotations

from typing import Any

from ..settings import latest_revision
from ..world import World
from .frame import Frame

__all__ = ["PlanetSeen", "Unseen", "ground_seen", "planet_seen"]


class PlanetSeen:
    """Call it: whether the planet, its air and its clouds may be in the picture, or its ground and sea. Whoever places
    the camera says so, before others are updated."""

    def __init__(self) -> None:
        self.value = True

    def __call__(self) -> bool:
        return self.value


def planet_seen(world: World, view_index: int) -> PlanetSeen:
    """That of a view; the same object each time, which passes give as their only_while."""
    return _flag(world, f"planet_seen.{view_index}")


def ground_seen(world: World, view_index: int) -> PlanetSeen:
    """The same for ground and sea alone, for what only draws or shades them. Never so without planet_seen."""
    return _flag(world, f"ground_seen.{view_index}")


def _flag(world: World, name: str) -> PlanetSeen:
    found = world.try_resource(name)
    if not isinstance(found, PlanetSeen):
        found = PlanetSeen()
        world.set_resource(name, found)
    return found


class Unseen:
    """For a system of the planet: whether it may leave a frame alone, because nothing of the planet is in the view.

    kinds: components whose change it has to hear of all the same. Systems ask in every update; the answer is no in the
    first frame without the planet, so that they can let go of what is meant for it, and in single pictures.
    """

    def __init__(self, *kinds: type) -> None:
        self._kinds = kinds
        self._told: dict[int, Any] = {}

    def rests(self, frame: Frame) -> bool:
        """Whether the last frame of the view was told that the planet is not in it, and nothing else is new."""
        if planet_seen(frame.world, frame.view_index)() or frame.cut or frame.settling or frame.one_shot:
            self._told.pop(frame.view_index, None)
            return False
        told = (latest_revision(*self._kinds), frame.world.structure_revision, frame.size)
        rests = self._told.get(frame.view_index) == told
        self._told[frame.view_index] = told
        return rests
