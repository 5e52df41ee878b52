"""Settings: knobs read from component fields, checked assignment, presets in TOML, quality."""

from .assign import PartRevision, assign_many, install, latest_revision, revision, with_overrides
from .check import FieldRule, PresetError, SettingError, UnknownSettingError, check_value, rules_of
from .presets import build_components, functions_of, plain_table, read_toml, write_toml
from .quality import QualityKnobs, Settings
from .suggest import did_you_mean

__all__ = [
    "FieldRule",
    "PartRevision",
    "PresetError",
    "QualityKnobs",
    "SettingError",
    "Settings",
    "UnknownSettingError",
    "assign_many",
    "build_components",
    "check_value",
    "did_you_mean",
    "functions_of",
    "install",
    "latest_revision",
    "plain_table",
    "read_toml",
    "revision",
    "rules_of",
    "with_overrides",
    "write_toml",
]
