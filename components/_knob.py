"""Knob: what a settings panel, a preset file and a checked assignment need to know about a component's field.

It stands in one place, the field's own metadata; documentation, panels, TOML and validation are made from it.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

__all__ = ["Knob", "Vec3", "knob", "knobs"]

Vec3 = tuple[float, float, float]


@dataclass(frozen=True)
class Knob:
    """Limits and description of one field.

    low, high: inclusive limits, for every element of a vector (None: no limit). unit: "m", "deg", ... for messages and
    panels. help: one sentence. cost: what a higher value costs, "" for nothing. log: a slider moves logarithmically.
    group: heading in a panel. choices: allowed texts. aliases: further texts that stand for one of them.
    not_yet: texts that are known but not available in this version. nonzero: a vector of length zero is refused.
    excludes: fields that become None when this one is set.
    power_of_two: 1, 2, 4, ... only. widget: "color" for a linear RGB reflectance, "direction", "path" for a file or
    folder (in scene files relative to their own folder), "place" for latitude and longitude in degrees, or "" (chosen
    by type). check: for what limits can't say, a function of the value that returns what is wrong with it, or "".
    A tuple of dataclasses with knobs of their own is a list of tables; low and high then limit their number.
    """

    low: float | None = None
    high: float | None = None
    unit: str = ""
    help: str = ""
    cost: str = ""
    log: bool = False
    group: str = ""
    choices: tuple[str, ...] = ()
    aliases: tuple[str, ...] = ()
    not_yet: tuple[str, ...] = ()
    nonzero: bool = False
    excludes: tuple[str, ...] = ()
    widget: str = ""
    power_of_two: bool = False
    check: Callable[[Any], str] | None = None


def knob(
    default: Any,
    low: float | None = None,
    high: float | None = None,
    unit: str = "",
    help: str = "",
    cost: str = "",
    log: bool = False,
    group: str = "",
    *,
    choices: tuple[str, ...] = (),
    aliases: tuple[str, ...] = (),
    not_yet: tuple[str, ...] = (),
    nonzero: bool = False,
    excludes: tuple[str, ...] = (),
    widget: str = "",
    power_of_two: bool = False,
    check: Callable[[Any], str] | None = None,
) -> Any:
    """A dataclass field with its Knob as metadata["knob"]. Vectors are tuples, so a change is always an assignment."""
    described = Knob(
        low,
        high,
        unit,
        help,
        cost,
        log,
        group,
        choices,
        aliases,
        not_yet,
        nonzero,
        excludes,
        widget,
        power_of_two,
        check,
    )
    return dataclasses.field(default=default, metadata={"knob": described})


def knobs(component: Any) -> dict[str, Knob]:
    """{field name: Knob} of a component (class or instance), in the order of declaration."""
    return {f.name: f.metadata["knob"] for f in dataclasses.fields(component) if "knob" in f.metadata}
