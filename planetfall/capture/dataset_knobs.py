"""Distributions that a plan's frames draw from, of cameras, suns and the knobs of components."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

import numpy as np

from ..engine.settings import PresetError, SettingError, check_value, did_you_mean
from ..engine.settings.check import FieldRule
from ..quality import QUALITY, resolve_quality
from ..scene.kinds import KINDS

__all__ = ["Bounds", "check_distribution", "drawn_knob", "drawn_value", "split_overrides"]


def _log_uniform(random: np.random.Generator, a: float, b: float) -> float:
    return float(np.exp(random.uniform(np.log(a), np.log(b))))


def _by_area(random: np.random.Generator, a: float, b: float) -> float:
    """Latitudes of places that are spread evenly over the sphere."""
    low, high = np.sin(np.radians([a, b]))
    return float(np.degrees(np.arcsin(random.uniform(low, high))))


_DRAW: Mapping[str, Callable[[np.random.Generator, float, float], float]] = {
    "uniform": lambda random, a, b: float(random.uniform(a, b)),
    "log": _log_uniform,
    "normal": lambda random, a, b: float(random.normal(a, b)),
    "area": _by_area,
}
_CHOICE = "choice"
_HUGE = 1e15
"""Beyond it are neither lengths, angles nor times; sums of such numbers are finite."""
_NAMES = (*_DRAW, _CHOICE)


@dataclass(frozen=True)
class Bounds:
    """What numbers a key takes, both ends included."""

    low: float = -_HUGE
    high: float = _HUGE

    def __str__(self) -> str:
        return "a number" if self.high == _HUGE else f"a number from {self.low:g} to {self.high:g}"


def drawn_value(value: Mapping[str, Any], bounds: Bounds, random: np.random.Generator) -> float:
    """One number of a distribution; none leaves the bounds."""
    ((kind, numbers),) = value.items()
    drawn = float(random.choice(numbers)) if kind == _CHOICE else _DRAW[kind](random, *numbers)
    return min(max(drawn, bounds.low), bounds.high)


def drawn_knob(key: str, value: Mapping[str, Any], random: np.random.Generator) -> object:
    """What a component's knob has in a frame: whole numbers are rounded, and none leaves the knob's range."""
    rule = QUALITY.component_rules[key]
    ((kind, values),) = value.items()
    if kind == _CHOICE:
        return check_value(rule, values[int(random.integers(len(values)))], key)
    low = -np.inf if rule.knob.low is None else rule.knob.low
    high = np.inf if rule.knob.high is None else rule.knob.high
    drawn = float(np.clip(_DRAW[kind](random, *values), low, high))
    return round(drawn) if rule.kind == "int" else drawn


def split_overrides(where: str, quality: str, table: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """(knobs that are the same for all frames, {"terrain.seed": distribution}) of a plan's [overrides]. PresetError,
    naming key, expected and found."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        # terrain.seed without quotes is a table to TOML.
        nested = "." not in key and isinstance(value, Mapping)
        flat |= {f"{key}.{name}": inner for name, inner in value.items()} if nested else {key: value}
    fixed = {key: value for key, value in flat.items() if not isinstance(value, Mapping)}
    varied = {key: value for key, value in flat.items() if isinstance(value, Mapping)}
    try:
        settings = resolve_quality(quality, fixed)
    except SettingError as error:
        raise PresetError(f"{where}: {error}") from error
    for key, value in flat.items():
        rule = QUALITY.component_rules.get(key)
        if key.startswith("sun.") and rule is not None and rule.knob.group == "position":
            told = "elevation_deg and azimuth_deg of [sun] say where each frame's sun stands"
            raise PresetError(f"{where}: overrides: {key}: {told}; found {value!r}")
    for key, value in varied.items():
        at, rule = f"{where}: overrides: {key}", QUALITY.component_rules.get(key)
        if key in QUALITY.rules:
            raise PresetError(
                f"{at}: a knob of quality has one value for all frames, found {value!r}; what may vary are knobs of "
                f"components: {', '.join(KINDS)}"
            )
        if rule is None:
            known = [*QUALITY.component_rules, *QUALITY.rules]
            raise PresetError(f"{at}: no such knob; {did_you_mean(key, known, 'knobs')}")
        if key in settings:
            raise PresetError(f"{at}: quality {quality!r} sets it itself; choose another quality")
        _check_knob(at, rule, value)
    return fixed, varied


def _check_knob(where: str, rule: FieldRule, value: Mapping[str, Any]) -> None:
    kinds = _NAMES if rule.kind in ("float", "int") and not rule.knob.power_of_two else (_CHOICE,)
    if rule.kind == "function":
        raise PresetError(f"{where}: expected {rule.expected}, which no file can hold; leave it out")
    if len(value) != 1 or next(iter(value)) not in kinds:
        raise PresetError(f"{where}: expected a value, or one of {{ {' | '.join(kinds)} = [...] }}, found {value!r}")
    ((kind, values),) = value.items()
    if kind != _CHOICE:
        check_distribution(where, value)
    elif not isinstance(values, list) or not values:
        raise PresetError(f"{where}: choice: expected a list of values, found {values!r}")
    for each in values[:1] if kind == "normal" else values:
        plain = round(each) if rule.kind == "int" and kind != _CHOICE else each
        try:
            check_value(rule, plain, f"{where}: {kind}")
        except SettingError as error:
            raise PresetError(str(error)) from error


def check_distribution(where: str, value: object, bounds: Bounds | None = None) -> None:
    """PresetError unless it is a number, or a distribution of numbers, within bounds."""
    bounds = bounds or Bounds()
    if _is_number(value):
        return _check_bounds(where, [value], bounds)
    if not isinstance(value, Mapping) or len(value) != 1 or next(iter(value)) not in _NAMES:
        raise PresetError(f"{where}: expected {bounds}, or one of {{ {' | '.join(_NAMES)} = [...] }}, found {value!r}")
    ((kind, numbers),) = value.items()
    fits = isinstance(numbers, list) and numbers and all(_is_number(n) for n in numbers)
    if not fits or (kind != _CHOICE and len(numbers) != 2):
        wanted = "numbers" if kind == _CHOICE else "two numbers"
        raise PresetError(f"{where}: {kind}: expected {wanted}, found {numbers!r}")
    if kind not in (_CHOICE, "normal") and not numbers[0] <= numbers[1]:
        raise PresetError(f"{where}: {kind}: expected the lower number first, found {numbers!r}")
    if kind == "log" and numbers[0] <= 0.0:
        raise PresetError(f"{where}: {kind}: expected numbers above 0, found {numbers!r}")
    if kind == "normal" and not 0.0 <= numbers[1] <= _HUGE:
        raise PresetError(f"{where}: {kind}: expected a mean and a deviation from 0 on, found {numbers!r}")
    if kind == "area" and not -90.0 <= numbers[0] <= numbers[1] <= 90.0:
        raise PresetError(f"{where}: {kind}: expected latitudes from -90 to 90, found {numbers!r}")
    _check_bounds(f"{where}: {kind}", numbers[:1] if kind == "normal" else numbers, bounds)


def _check_bounds(where: str, numbers: Sequence[float], bounds: Bounds) -> None:
    for number in numbers:
        if not bounds.low <= number <= bounds.high:
            raise PresetError(f"{where}: expected a number from {bounds.low:g} to {bounds.high:g}, found {number!r}")


def _is_number(value: object) -> TypeGuard[float]:
    whole = isinstance(value, int) and not isinstance(value, bool)  # which may be larger than any float
    return whole or (isinstance(value, float) and math.isfinite(value))
