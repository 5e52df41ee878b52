"""Wind: the air's motion near the ground."""

from __future__ import annotations

from dataclasses import dataclass

from ._knob import knob

__all__ = ["Wind"]


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
