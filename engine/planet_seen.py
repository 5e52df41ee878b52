"""Whether a view may show any of a planet: what its passes are skipped by, all together, while it doesn't."""

from __future__ import annotations

from .world import World

__all__ = ["PlanetSeen", "planet_seen"]


class PlanetSeen:
    """Call it: whether the planet, its air and its clouds may be in the picture. Whoever places the camera says so,
    before others are updated."""

    def __init__(self) -> None:
        self.value = True

    def __call__(self) -> bool:
        return self.value


def planet_seen(world: World, view_index: int) -> PlanetSeen:
    """That of a view; the same object each time, which passes give as their only_while."""
    name = f"planet_seen.{view_index}"
    found = world.try_resource(name)
    if not isinstance(found, PlanetSeen):
        found = PlanetSeen()
        world.set_resource(name, found)
    return found
