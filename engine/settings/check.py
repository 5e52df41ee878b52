"""Rules of a component's fields, and the check of one value against one rule.

msgspec decides what is valid; this module makes its types from the knobs and says in words what was wrong.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Any, Literal

import msgspec
import numpy as np

from .suggest import did_you_mean

__all__ = [
    "FieldRule",
    "PresetError",
    "SettingError",
    "UnknownSettingError",
    "check_value",
    "format_number",
    "rules_of",
]


_PLACE = tuple[Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)], Annotated[float, msgspec.Meta(ge=-360.0, le=360.0)]]


class SettingError(ValueError):
    """A value that a setting can't have. The message names the setting, what is expected, what was found, a remedy."""


class UnknownSettingError(SettingError, AttributeError):
    """A setting that doesn't exist; the message names the nearest one that does."""


class PresetError(SettingError):
    """A preset file that can't be used. `problems` lists everything that is wrong with it, one text each."""

    def __init__(self, message: str, problems: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems) or (message,)


@dataclass(frozen=True)
class FieldRule:
    """What one field accepts. knob: its metadata.

    kind: "float", "int", "bool", "str", "vector" (length numbers), "rows" (any number of rows of length whole numbers),
    "function" (which no file can hold), "tables" (instances of `table`, a frozen dataclass with knobs of its own) or
    "list" (any number of components of one class, which is then the schema).
    """

    name: str
    kind: str
    length: int
    optional: bool
    knob: Any
    default: Any
    schema: Any
    table: type | None = None

    @property
    def expected(self) -> str:
        """The allowed values in words, e.g. "a number from 0 to 90 deg"."""
        if self.kind == "bool":
            text = "true or false"
        elif self.kind == "list":
            text = f"a list of {self.schema.__name__}"
        elif self.kind == "function":
            text = "a function"
        elif self.kind == "rows":
            low, high = format_number(self.knob.low), format_number(self.knob.high)
            text = f"rows of {self.length} whole numbers from {low} to {high}"
        elif self.kind == "str":
            choices = self.knob.choices
            text = f"one of {', '.join(map(repr, choices))}" if choices else "a text"
        elif self.kind == "tables":
            text = f"{self.knob.low} to {self.knob.high} tables with {', '.join(rules_of(self.table))}"
        elif self.knob.widget == "place":
            text = "a latitude from -90 to 90 and a longitude from -360 to 360 deg"
        else:
            noun = {"int": "a whole number", "float": "a number", "vector": f"{self.length} numbers"}[self.kind]
            low, high, unit = self.knob.low, self.knob.high, f" {self.knob.unit}" if self.knob.unit else ""
            if low is not None and high is not None:
                text = f"{noun} from {format_number(low)} to {format_number(high)}{unit}"
            elif low is not None:
                text = f"{noun}, at least {format_number(low)}{unit}"
            elif high is not None:
                text = f"{noun}, at most {format_number(high)}{unit}"
            else:
                text = f"{noun}{unit and f' in{unit}'}"
            if self.knob.power_of_two:
                text += ", a power of two"
            if self.knob.nonzero:
                text += ", not all zero"
        return f"{text}, or nothing" if self.optional else text


def format_number(value: float) -> str:
    """Short and exact enough to be typed again: 6371000, 0.004675, 1e+12."""
    return f"{value:.12g}"


@lru_cache(maxsize=256)
def rules_of(cls: type) -> dict[str, FieldRule]:
    """{field name: rule} for the fields of a dataclass that have a knob."""
    if not dataclasses.is_dataclass(cls):
        raise TypeError(f"{cls.__name__} is no dataclass, so it has no settings; decorate it with @dataclass")
    hints = typing.get_type_hints(cls)
    return {
        f.name: _rule(cls, f.name, hints[f.name], f.metadata["knob"], f.default)
        for f in dataclasses.fields(cls)
        if "knob" in f.metadata
    }


def _rule(cls: type, name: str, hint: Any, knob: Any, default: Any) -> FieldRule:
    optional = False
    if typing.get_origin(hint) in (typing.Union, types.UnionType):
        others = [a for a in typing.get_args(hint) if a is not type(None)]
        optional, hint = True, others[0]
        # A TOML file leaves out what is None; that must mean the same when it is read back.
        if len(others) != 1 or default is not None:
            raise TypeError(f"{cls.__name__}.{name}: an optional knob is `X | None` with default None")
    limits = {key: limit for key, limit in (("ge", knob.low), ("le", knob.high)) if limit is not None}
    length, table = 0, None
    if hint in (float, int):
        kind, schema = hint.__name__, Annotated[hint, msgspec.Meta(**limits)]
    elif hint is bool:
        kind, schema = "bool", bool
    elif hint is str:
        kind, schema = "str", Literal[knob.choices + knob.aliases] if knob.choices else str
    elif typing.get_origin(hint) is tuple and set(typing.get_args(hint)) == {float}:
        kind, length = "vector", len(typing.get_args(hint))
        schema = tuple[(Annotated[float, msgspec.Meta(**limits)],) * length]  # type: ignore[misc]
        if knob.widget == "place":
            schema = _PLACE
    elif typing.get_origin(hint) is Callable and optional:
        kind, schema = "function", None
    elif _row_length(hint):
        kind, length = "rows", _row_length(hint)
        row = tuple[(Annotated[int, msgspec.Meta(**limits)],) * length]  # type: ignore[misc]
        schema = tuple[row, ...]  # type: ignore[valid-type]
    elif _is_list(hint):
        kind, schema = "list", typing.get_args(hint)[0]
        rules_of(schema)
    elif typing.get_origin(hint) is tuple and typing.get_args(hint)[1:] == (Ellipsis,):
        kind, table, schema = "tables", typing.get_args(hint)[0], None
        rules_of(table)
    else:
        raise TypeError(
            f"{cls.__name__}.{name}: knobs are float, int, bool, str, tuples of float, tuple[tuple[int, int], ...], "
            f"tuple[component, ...] or Callable | None, found {hint}"
        )
    return FieldRule(name, kind, length, optional, knob, default, schema, table)


def _row_length(hint: Any) -> int:
    """Of a tuple[tuple[int, int], ...], 2; of anything else 0."""
    parts = typing.get_args(hint)
    if typing.get_origin(hint) is not tuple or parts[1:] != (Ellipsis,) or typing.get_origin(parts[0]) is not tuple:
        return 0
    inner = typing.get_args(parts[0])
    return len(inner) if set(inner) == {int} else 0


def _is_list(hint: Any) -> bool:
    parts = typing.get_args(hint)
    whole = typing.get_origin(hint) is tuple and len(parts) == 2 and parts[1] is Ellipsis
    if not whole or not dataclasses.is_dataclass(parts[0]):
        return False
    made_as: Any = parts[0]
    return not made_as.__dataclass_params__.frozen  # a component


def check_value(rule: FieldRule, value: object, where: str) -> Any:
    """The value as it is to be stored (numpy scalars and arrays become plain numbers and tuples), or SettingError.

    where: how the message calls the setting, e.g. "Ocean.sea_level_m" or "my.toml: ocean.sea_level_m".
    """
    if value is None and rule.optional:
        return None
    if rule.kind == "list":
        return _checked_list(rule, value, where)
    if rule.kind == "tables":
        return _checked(rule, _tables(rule, value, where), where)
    if rule.kind == "function":
        if not callable(value):
            raise SettingError(f"{where}: expected {rule.expected}, found {_shown(value)}. Assign one in Python")
        return _checked(rule, value, where)
    if rule.kind == "rows":
        return _checked(rule, _rows(rule, value, where), where)
    plain = _plain(rule, value)
    try:
        checked = msgspec.convert(plain, rule.schema)
    except msgspec.ValidationError:
        raise SettingError(_complaint(rule, value, plain, where)) from None
    finite = math.isfinite(checked) if rule.kind == "float" else True
    if rule.kind == "vector":
        finite = all(map(math.isfinite, checked))
    uneven = rule.knob.power_of_two and (checked & (checked - 1)) != 0
    if not finite or uneven or (rule.knob.nonzero and not any(checked)):
        raise SettingError(_complaint(rule, value, plain, where))
    return _checked(rule, checked, where)


def _checked(rule: FieldRule, value: object, where: str) -> object:
    wrong = "" if rule.knob.check is None else rule.knob.check(value)
    if wrong:
        raise SettingError(f"{where}: {wrong}")
    return value


def _rows(rule: FieldRule, value: object, where: str) -> tuple[tuple[int, ...], ...]:
    """A list of rows or an array (N, length) of whole numbers, as tuples."""
    if isinstance(value, np.ndarray):
        value = value.tolist()
    try:
        return msgspec.convert(value, rule.schema)
    except msgspec.ValidationError:
        pass
    if not isinstance(value, list | tuple):
        raise SettingError(f"{where}: expected {rule.expected}, found {_shown(value)}. Give a list of rows")
    # Rows may be arrays of numpy's, whose numbers are no int; and what is wrong has a place.
    plain = [np.asarray(row).tolist() if isinstance(row, np.ndarray | list | tuple) else row for row in value]
    for number, row in enumerate(plain):
        try:
            msgspec.convert([row], rule.schema)
        except msgspec.ValidationError:
            whole = (
                f"{rule.length} whole numbers from {format_number(rule.knob.low)} to {format_number(rule.knob.high)}"
            )
            raise SettingError(f"{where}[{number}]: expected {whole}, found {_shown(value[number])}") from None
    return msgspec.convert(plain, rule.schema)


def _tables(rule: FieldRule, value: object, where: str) -> tuple[object, ...]:
    """Tables or instances as checked instances."""
    assert rule.table is not None
    if not isinstance(value, list | tuple):
        raise SettingError(f"{where}: expected {rule.expected}, found {_shown(value)}. Give a list of tables")
    if not rule.knob.low <= len(value) <= rule.knob.high:
        noun = rule.table.__name__.lower()
        raise SettingError(f"{where}: expected {rule.knob.low} to {rule.knob.high} {noun}s, found {len(value)}")
    return tuple(_table(rule.table, entry, f"{where}[{number}]") for number, entry in enumerate(value))


def _table(cls: type, entry: Any, where: str) -> Any:
    rules = rules_of(cls)
    if isinstance(entry, cls):
        entry = {name: getattr(entry, name) for name in rules}
    if not isinstance(entry, Mapping):
        raise SettingError(f"{where}: expected a table with {', '.join(rules)}, found {_shown(entry)}")
    for key in entry:
        if key not in rules:
            raise UnknownSettingError(f"{where} has no setting {key!r}; {did_you_mean(key, rules, 'it has')}")
    return cls(**{key: check_value(rules[key], v, f"{where}.{key}") for key, v in entry.items()})


def _checked_list(rule: FieldRule, value: object, where: str) -> tuple[object, ...]:
    """A tuple of components; each may also be given as a table {field: value}."""
    if not isinstance(value, list | tuple):
        raise SettingError(f"{where}: expected {rule.expected}, found {_shown(value)}. Put even one in brackets")
    most = rule.knob.high
    if most is not None and len(value) > most:
        raise SettingError(f"{where}: expected at most {most:g}, found {len(value)}")
    return tuple(_checked_item(rule.schema, item, f"{where}[{k}]") for k, item in enumerate(value))


def _checked_item(cls: Any, item: Any, where: str) -> Any:
    rules = rules_of(cls)
    if type(item) is cls:
        return item
    if isinstance(item, cls):
        # A component that is one of these and more: only what is common may have been set.
        for name, rule in rules_of(type(item)).items():
            if name not in rules and getattr(item, name) != rule.default:
                raise SettingError(f"{where}: expected a {cls.__name__}, found a {type(item).__name__} with {name} set")
        return cls(**{name: getattr(item, name) for name in rules})
    if not isinstance(item, Mapping):
        raise SettingError(f"{where}: expected a {cls.__name__} or a table of its fields, found {_shown(item)}")
    checked = {}
    for key, value in item.items():
        if key not in rules:
            raise SettingError(f"{where}.{key}: unknown key; {did_you_mean(key, rules, 'allowed')}")
        checked[key] = check_value(rules[key], value, f"{where}.{key}")
    return cls(**checked)


def _plain(rule: FieldRule, value: object) -> object:
    if isinstance(value, np.ndarray):
        value = value.tolist()  # a 0-d array becomes a number
    elif isinstance(value, np.generic):
        value = value.item()
    if rule.kind == "vector" and isinstance(value, list | tuple):
        return tuple(v.item() if isinstance(v, np.generic) else v for v in value)
    return value


def _complaint(rule: FieldRule, value: object, plain: object, where: str) -> str:
    text = f"{where}: expected {rule.expected}, found {_shown(value)}"
    if rule.kind == "str" and isinstance(plain, str):
        if plain in rule.knob.not_yet:
            there = ", ".join(map(repr, rule.knob.choices))
            return f"{where}: {plain!r} is not available in this version, only {there}. Use {rule.knob.choices[0]!r}"
        return f"{text}; {did_you_mean(plain, rule.knob.choices, 'allowed')}"
    if rule.kind in ("float", "int") and isinstance(plain, int | float) and not isinstance(plain, bool):
        if not math.isfinite(plain):
            return f"{text}. Give a finite number"
        if rule.kind == "int" and isinstance(plain, float):
            return f"{text}. Give it without a decimal point"
        if rule.knob.power_of_two and rule.knob.low <= plain <= rule.knob.high:
            return f"{text}. The nearest allowed value below is {1 << (int(plain).bit_length() - 1)}"
        low, high = rule.knob.low, rule.knob.high
        nearest = low if low is not None and plain < low else high
        return f"{text}. The nearest allowed value is {format_number(nearest)}"
    if rule.kind == "vector":
        if not isinstance(plain, tuple) or len(plain) != rule.length:
            return f"{text}. Give {rule.length} numbers, such as {_example(rule)}"
        if any(isinstance(v, float) and not math.isfinite(v) for v in plain):
            return f"{text}. Give finite numbers"
        return f"{text}. Give numbers such as {_example(rule)}"
    return f"{text}. Give a value such as {_shown(rule.default if rule.default is not None else rule.knob.low)}"


_EXAMPLES = {2: (0.0, 1.0), 3: (1.0, 0.0, 0.0)}
"""By length, where the default says nothing: two numbers are a range, three a direction."""


def _example(rule: FieldRule) -> str:
    example = rule.default if rule.default is not None else _EXAMPLES.get(rule.length, (0.0,) * rule.length)
    return _shown(list(example))  # brackets: that is how Python and TOML files both take it


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    elif isinstance(value, np.generic):
        value = value.item()
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:77]}..."
