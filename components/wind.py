"""Wind: the air's motion near the ground."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TypeVar

from ._knob import knob
from .clouds import Clouds
from .ocean import Ocean

__all__ = ["ALOFT", "Wind", "blown"]

ALOFT = 1.5
"""Wind that carries the weather over that 10 m above the ground."""

_T = TypeVar("_T", Ocean, Clouds)


@dataclass
class Wind:
    """Wind over a planet: bends grass and trees, raises the sea's waves and carries the weather eastwards, half as fast
    again aloft. A field of Ocean or Clouds that differs from its default is set, and wins. On a planet without the
    component each has its own, and a breeze as this one by default moves plants."""

    speed_m_s: float = knob(8.0, 0.0, 60.0, "m/s", "10 m above the ground; 8 moves leaves and grass, 20 is a gale")
    direction_deg: float = knob(
        70.0, -360.0, 360.0, "deg", "Heading that it blows towards at `at`: 0 north, 90 east", widget="angle"
    )
    at: tuple[float, float] = knob(
        (0.0, 0.0), unit="deg", help="Latitude and longitude for which the direction is given", widget="place"
    )
    gusts: float = knob(0.5, 0.0, 1.0, "", "How much stronger and weaker it becomes as gusts pass; 0: steady")


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
