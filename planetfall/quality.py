"""Quality: the presets low, medium, high, ultra and reference, and overrides of single knobs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ._kinds import KINDS, PRESETS
from .components import (
    AtmosphereQuality,
    CloudQuality,
    CompositeQuality,
    OceanQuality,
    ProxyQuality,
    ShadowQuality,
    SkyQuality,
    TerrainQuality,
)
from .engine.settings import QualityKnobs

__all__ = ["QUALITY", "qualities", "resolve_quality"]

_GROUPS = {
    "terrain": TerrainQuality,
    "proxy": ProxyQuality,
    "sky": SkyQuality,
    "composite": CompositeQuality,
    "atmosphere": AtmosphereQuality,
    "ocean": OceanQuality,
    "shadows": ShadowQuality,
    "clouds": CloudQuality,
}

QUALITY = QualityKnobs(PRESETS / "quality", _GROUPS, KINDS)
"""All quality knobs by dotted key; `QUALITY.rules` describes them for panels and help texts."""


def qualities() -> list[str]:
    """Names of the quality presets, cheapest first."""
    return QUALITY.names()


def resolve_quality(name: str = "high", overrides: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """{key: value} for every quality knob of a preset, with overrides such as {"terrain.edge_px": 8.0} applied.

    Presets and overrides may also name knobs of components ("terrain.layers"); those are in the result only then, and
    `engine.settings.with_overrides` applies them to a copy of the component. Raises SettingError (did you mean).
    """
    return QUALITY.resolve(name, overrides)
