"""Wind as the default of what blows with it: the component's values where those of waves and weather are not set."""

from __future__ import annotations

import dataclasses
from typing import TypeVar

from ..components import Clouds, Ocean, Wind
from ..engine.settings import revision
from ..engine.world import World

__all__ = ["ALOFT", "blown", "wind_of", "wind_revision"]

ALOFT = 1.5
"""Wind that carries the weather over that 10 m above the ground."""

_T = TypeVar("_T", Ocean, Clouds)


def wind_of(world: World, planet: int) -> Wind | None:
    """That of a planet, if it has one."""
    return world.try_get(planet, Wind)


def wind_revision(wind: Wind | None) -> int:
    """Differs whenever the wind does; -1: there is none."""
    return -1 if wind is None else revision(wind)


def blown(component: _T, wind: Wind | None) -> _T:
    """An Ocean, or Clouds, as the wind drives it: a changed copy, or itself where nothing changes.

    A field that differs from its default is set, and stays: of the Ocean speed and direction of its wind, of Clouds
    the speed of the weather.
    """
    if wind is None:
        return component
    if isinstance(component, Ocean):
        given = {
            "wind_speed_m_s": wind.speed_m_s,
            "wind_direction_deg": wind.direction_deg,
            "wind_at": tuple(wind.at),
        }
        # A heading means nothing without the place that it is given for.
        if _is_set(component, "wind_direction_deg") or _is_set(component, "wind_at"):
            del given["wind_direction_deg"], given["wind_at"]
    else:
        given = {"wind_speed_m_s": ALOFT * wind.speed_m_s}
    changes = {
        name: value
        for name, value in given.items()
        if not _is_set(component, name) and value != getattr(component, name)
    }
    return dataclasses.replace(component, **changes) if changes else component


def _is_set(component: object, name: str) -> bool:
    (field,) = (f for f in dataclasses.fields(component) if f.name == name)  # type: ignore[arg-type]
    value = getattr(component, name)
    return (tuple(value) if isinstance(value, list) else value) != field.default
