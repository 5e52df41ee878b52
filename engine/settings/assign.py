"""Checked assignment: a component refuses a bad value where it is assigned, and remembers that it was changed."""

from __future__ import annotations

import dataclasses
import functools
import itertools
from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple, TypeVar

from .check import SettingError, UnknownSettingError, check_value, rules_of
from .suggest import did_you_mean

__all__ = ["assign_many", "install", "latest_revision", "revision", "with_overrides"]

T = TypeVar("T")

# One counter for all: a component that replaces another one never shows a revision that was seen before.
_revisions = itertools.count(1)
_latest: dict[type, int] = {}
_CHANGED = "_changed_at"
_LAST = "_changed_last"


def install(cls: type[T]) -> type[T]:
    """Make assignment to the fields of this dataclass checked, construction included. Calling it again does nothing.

    After that a value of the wrong type, out of range or NaN raises SettingError, a name that is no field raises
    UnknownSettingError, also where it is constructed, and `revision` goes up with each assignment that changes
    something. Names that begin with an underscore stay free. Costs about 2 us an assignment; reading costs nothing.
    """
    rules_of(cls)  # finds mistakes in the declaration now
    _check_names(cls)
    # What a subclass inherits looks at the object's own class.
    if getattr(cls, "__planetfall_checked__", False):
        return cls
    plain_setattr = cls.__setattr__

    def checked_setattr(self: Any, name: str, value: object) -> None:
        kind = type(self)
        rule = rules_of(kind).get(name)
        if rule is None:
            if not name.startswith("_") and not hasattr(kind, name) and name not in _field_names(kind):
                where = f"{kind.__name__} has no setting {name!r}"
                raise UnknownSettingError(f"{where}; {did_you_mean(name, _field_names(kind), 'it has')}")
            plain_setattr(self, name, value)
            if name in _field_names(kind):
                _touch(self, name)
            return
        value = check_value(rule, value, f"{kind.__name__}.{name}")
        fresh = name not in self.__dict__
        if value is not None:
            for other in rule.knob.excludes:
                if self.__dict__.get(other) is None:
                    continue
                if fresh:  # still in __init__, where no order of assignment says which one is meant
                    raise SettingError(f"{kind.__name__}: {other} and {name} exclude each other; give only one of them")
                plain_setattr(self, other, None)
                _touch(self, other)
        if fresh or self.__dict__[name] != value:
            plain_setattr(self, name, value)
            _touch(self, name)

    cls.__setattr__ = checked_setattr  # type: ignore[method-assign]
    cls.__planetfall_checked__ = True  # type: ignore[attr-defined]
    return cls


def _check_names(cls: type) -> None:
    """Make construction of the dataclass name the nearest field for a keyword that it has not."""
    made: Any = cls.__dict__.get("__init__")
    if made is None or hasattr(made, "__wrapped__"):
        return
    known = frozenset(field.name for field in dataclasses.fields(cls) if field.init)

    @functools.wraps(made)
    def checked_init(self: Any, *values: Any, **named: Any) -> None:
        for name in named.keys() - known:
            where = f"{cls.__name__} has no setting {name!r}"
            raise UnknownSettingError(f"{where}; {did_you_mean(name, known, 'it has')}")
        made(self, *values, **named)

    cls.__init__ = checked_init  # type: ignore[misc]


def revision(component: object, *fields: str) -> int:
    """A number that changes with every change of the component (or of these fields only). Compare it for equality.

    No two component objects share one, so a replaced component counts as changed. A field that is a list of components
    changes with each of them.
    """
    if not fields and not _list_fields(type(component)):  # as nearly all are asked for, each frame
        return component.__dict__.get(_LAST, 0)
    changed: Mapping[str, int] = component.__dict__.get(_CHANGED, {})
    lists = _list_fields(type(component))
    inner = [revision(item) for name in lists if not fields or name in fields for item in getattr(component, name)]
    if fields:
        known = _field_names(type(component))
        for name in fields:
            if name not in known:
                what = f"{type(component).__name__} has no setting {name!r}"
                raise UnknownSettingError(f"{what}; {did_you_mean(name, known, 'it has')}")
        return max((*(changed.get(name, 0) for name in fields), *inner), default=0)
    return max((*changed.values(), *inner), default=0)


class PartRevision(NamedTuple):
    """Which component, by its id, and its revision: differs for another one of a class that isn't checked, too."""

    part: int
    revision: int

    @classmethod
    def of(cls, component: object) -> PartRevision:
        """Of a component as it is now."""
        return cls(id(component), revision(component))


def latest_revision(*kinds: type) -> int:
    """The revision of the component of these classes that changed last: while it stays, none of them has changed."""
    return max([_latest.get(kind, 0) for kind in kinds], default=0)


def assign_many(components: Sequence[object], name: str, values: Sequence[object]) -> None:
    """Set a field of many components (checked classes) at once: ten times faster than one by one.

    The caller has checked `values`: they are what `check_value` would give, such as tuples of finite floats.
    """
    latest = next(_revisions)
    for component, value in zip(components, values, strict=True):
        fields = component.__dict__
        fields[name] = value
        fields[_CHANGED] = {**fields.get(_CHANGED, {}), name: latest}
        fields[_LAST] = latest
        _latest[type(component)] = latest


def with_overrides(component: T, table: str, settings: Mapping[str, object]) -> T:
    """The component with the overrides "table.field" of `settings` applied: a changed copy, or itself when none apply.

    For quality overrides that name a component's knob, such as {"terrain.layers": 4}; the scene stays as it is.
    """
    changes = {name: settings[key] for key, name in _keys(type(component), table) if key in settings}
    return dataclasses.replace(component, **changes) if changes else component  # type: ignore[type-var]


def _touch(component: object, name: str) -> None:
    # A new dict each time, so that a shallow copy doesn't share it.
    latest = _latest[type(component)] = next(_revisions)
    component.__dict__[_CHANGED] = {**component.__dict__.get(_CHANGED, {}), name: latest}
    component.__dict__[_LAST] = latest


@lru_cache(maxsize=256)
def _keys(cls: type, table: str) -> tuple[tuple[str, str], ...]:
    """(dotted key, field) of all fields."""
    return tuple((f"{table}.{name}", name) for name in _field_names(cls))


@lru_cache(maxsize=256)
def _list_fields(cls: type) -> tuple[str, ...]:
    return tuple(rule.name for rule in rules_of(cls).values() if rule.kind == "list")


def _field_names(cls: type) -> Mapping[str, object]:
    return cls.__dataclass_fields__  # type: ignore[attr-defined]
