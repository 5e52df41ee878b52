"""Settings: knobs read from component fields, checked assignment, presets in TOML, quality."""

from .assign import install, revision, with_overrides
from .check import FieldRule, PresetError, SettingError, UnknownSettingError, check_value, rules_of
from .presets import build_components, plain_table, read_toml, write_toml
from .quality import QualityKnobs
from .suggest import did_you_mean

__all__ = [
    "FieldRule",
    "PresetError",
    "QualityKnobs",
    "SettingError",
    "UnknownSettingError",
    "build_components",
    "check_value",
    "did_you_mean",
    "install",
    "plain_table",
    "read_toml",
    "revision",
    "rules_of",
    "with_overrides",
    "write_toml",
]
