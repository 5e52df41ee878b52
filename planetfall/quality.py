"""Quality: the presets low, medium, high, ultra and reference, and overrides of single knobs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .components import (
    AtmosphereQuality,
    CloudQuality,
    CompositeQuality,
    CoverQuality,
    LightQuality,
    MemoryQuality,
    OceanQuality,
    ProxyQuality,
    ShadowQuality,
    SkyQuality,
    TerrainQuality,
)
from .engine.settings import QualityKnobs, SettingError, check_value, did_you_mean
from .scene.kinds import KINDS, PRESETS

__all__ = ["LIVE", "QUALITY", "checked_live", "qualities", "resolve_quality"]

GROUPS = {
    "terrain": TerrainQuality,
    "proxy": ProxyQuality,
    "sky": SkyQuality,
    "light": LightQuality,
    "composite": CompositeQuality,
    "atmosphere": AtmosphereQuality,
    "ocean": OceanQuality,
    "shadows": ShadowQuality,
    "clouds": CloudQuality,
    "cover": CoverQuality,
    "memory": MemoryQuality,
}

QUALITY = QualityKnobs(PRESETS / "quality", GROUPS, KINDS)
"""All quality knobs by dotted key; `QUALITY.rules` describes them for panels and help texts."""

LIVE = ("terrain.edge_px", "terrain.error_px", "terrain.min_spacing_m", "clouds.fine_steps", "clouds.step_growth",
        "clouds.sun_steps")  # fmt: skip
"""Knobs that are read each frame: a renderer may change them without making anything anew."""


def checked_live(changes: Mapping[str, Any]) -> dict[str, Any]:
    """The changes as they are to be stored. SettingError for a knob that isn't LIVE, or a value it can't have."""
    other = [key for key in changes if key not in LIVE]
    if other:
        raise SettingError(
            f"{other[0]!r} can't be changed in a running renderer; {did_you_mean(other[0], LIVE, 'live')}"
        )
    return {key: check_value(QUALITY.rules[key], value, key) for key, value in changes.items()}


def qualities() -> list[str]:
    """Names of the quality presets, cheapest first."""
    return QUALITY.names()


def resolve_quality(name: str = "high", overrides: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """{key: value} for every quality knob of a preset, with overrides such as {"terrain.edge_px": 8.0} applied.

    Presets and overrides may also name knobs of components ("terrain.layers"); those are in the result only then, and
    `engine.settings.with_overrides` applies them to a copy of the component. Raises SettingError (did you mean).
    """
    return QUALITY.resolve(name, overrides)
