"""Quality: named sets of values for everything that trades time against error, resolved to one flat dict."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeAlias

from .check import FieldRule, PresetError, SettingError, UnknownSettingError, check_value, rules_of
from .presets import read_toml
from .suggest import did_you_mean

__all__ = ["QualityKnobs", "Settings"]

Settings: TypeAlias = Mapping[str, bool | int | float | str]
"""Resolved values by dotted key; what an override says of a component's field may also be a list (`with_overrides`)."""


class QualityKnobs:
    """The quality knobs there are, and how a preset's name and overrides become values.

    groups: {"": Render, "terrain": TerrainQuality, ...}: dataclasses whose knobs get the dotted key "terrain.edge_px"
    (the group "" has keys without a dot). components: {"terrain": Terrain, ...}: components whose knobs presets and
    overrides may name as well, such as "terrain.layers"; they are in the result only when one of them does.
    """

    def __init__(self, folder: Path, groups: Mapping[str, type], components: Mapping[str, type]) -> None:
        self.folder = folder
        self.rules: dict[str, FieldRule] = {}
        for group, cls in groups.items():
            for name, rule in rules_of(cls).items():
                self.rules[f"{group}.{name}" if group else name] = rule
        self.component_rules: dict[str, FieldRule] = {}
        for table, cls in components.items():
            for name, rule in rules_of(cls).items():
                key = f"{table}.{name}"
                if key in self.rules:
                    raise ValueError(f"{key} is a quality knob and a field of {cls.__name__}; rename one of them")
                self.component_rules[key] = rule

    def names(self) -> list[str]:
        """The presets there are, cheapest first as their files' `order` says."""
        return sorted(
            (p.stem for p in self.folder.glob("*.toml")), key=lambda n: (read_toml(self._path(n))["order"], n)
        )

    def about(self, name: str) -> str:
        """One sentence on the preset, from its file."""
        return str(read_toml(self._known(name)).get("about", ""))

    def resolve(self, name: str = "high", overrides: Mapping[str, object] | None = None) -> dict[str, Any]:
        """{key: value} for every quality knob, plus the component knobs that the preset or `overrides` names.

        Raises SettingError for an unknown preset, an unknown key (did you mean) or a value that is not allowed.
        """
        values = {key: rule.default for key, rule in self.rules.items()}
        values.update(self._preset(self._known(name)))
        for key, value in (overrides or {}).items():
            rule = self.rules.get(key) or self.component_rules.get(key)
            if rule is None:
                known = [*self.rules, *self.component_rules]
                raise UnknownSettingError(f"override {key!r} names no knob; {did_you_mean(key, known, 'knobs')}")
            values[key] = check_value(rule, value, f"override {key!r}")
        return values

    def _known(self, name: str) -> Path:
        names = [p.stem for p in self.folder.glob("*.toml")]
        if name not in names:
            raise SettingError(f"no quality {name!r}; {did_you_mean(name, names, 'qualities')}")
        return self._path(name)

    def _path(self, name: str) -> Path:
        return self.folder / f"{name}.toml"

    def _preset(self, path: Path) -> dict[str, Any]:
        values: dict[str, Any] = {}
        problems: list[str] = []
        for key, value in _flat(read_toml(path)).items():
            if key in ("about", "order"):
                continue
            rule = self.rules.get(key) or self.component_rules.get(key)
            if rule is None:
                problems.append(f"{key}: unknown key; {did_you_mean(key, self.rules, 'allowed')}")
                continue
            try:
                values[key] = check_value(rule, value, key)
            except SettingError as error:
                problems.append(str(error))
        if problems:
            raise PresetError(f"{os.fspath(path)}: " + "; ".join(problems), problems)
        return values


def _flat(data: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, Mapping):
            flat.update(_flat(value, f"{prefix}{key}."))
        else:
            flat[f"{prefix}{key}"] = value
    return flat
