"""What the flight's panels work on: the scene's components and the quality knobs, as one store of parts by heading."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ._kinds import KINDS, PLANET_KINDS
from .components import Composite, Exposure, Planet, Sun, knob
from .engine.settings import install, rules_of
from .errors import SceneError
from .quality import _GROUPS as QUALITY_GROUPS
from .quality import QUALITY, resolve_quality
from .scene import Scene

__all__ = ["OPTIONAL", "QUALITY_HEADING", "QualityChoice", "SceneStore", "groups_of"]

REQUIRED = (Planet, Sun, Exposure, Composite)
OPTIONAL: tuple[type, ...] = tuple(kind for kind in KINDS.values() if kind not in REQUIRED)
"""Components that a scene can do without: they have a switch."""

QUALITY_HEADING = "Quality"


@dataclass
class QualityChoice:
    """Which preset the quality knobs start from."""

    preset: str = knob("high", help="Name of a quality preset: what all knobs are that aren't set by themselves")


for _kind in (QualityChoice, *QUALITY_GROUPS.values()):
    install(_kind)


def groups_of(values: Mapping[str, Any]) -> dict[str, Any]:
    """{heading: group of quality knobs} with these resolved values."""
    return {
        f"{QUALITY_HEADING}.{name}": kind(**{rule: values[f"{name}.{rule}"] for rule in rules_of(kind)})
        for name, kind in QUALITY_GROUPS.items()
    }


class SceneStore:
    """A scene's components by the names of their classes; quality as "Quality" (the preset) and "Quality.terrain" and
    so on. The quality parts are what is wanted: the app makes it so."""

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.quality: dict[str, Any] = {}
        self._kinds = {kind.__name__: kind for kind in KINDS.values()}
        self._planet = frozenset(PLANET_KINDS.values())

    def scene_parts(self) -> dict[str, Any]:
        """The scene's own parts."""
        handles = (self.scene.planet, self.scene.environment)
        found = {type(part): part for handle in handles for part in handle.components()}
        return {name: found[kind] for name, kind in self._kinds.items() if kind in found}

    def parts(self) -> dict[str, Any]:
        """See workbench.Store."""
        return {**self.scene_parts(), **self.quality}

    def put(self, heading: str, part: Any) -> None:
        """See workbench.Store."""
        if heading in self.quality:
            self.quality[heading] = part
        else:
            self._handle(self._kinds[heading]).add(part)

    def take(self, heading: str) -> None:
        """See workbench.Store."""
        self._handle(self._kinds[heading]).remove(self._kinds[heading])

    def _handle(self, kind: type) -> Any:
        return self.scene.planet if kind in self._planet else self.scene.environment

    def wrong(self) -> str:
        """What does not fit together; "" for nothing."""
        try:
            self.scene.validate()
        except SceneError as error:
            return str(error)
        return ""

    # -- quality -----------------------------------------------------------------------------------------------------

    def take_quality(self, preset: str, overrides: Mapping[str, Any]) -> None:
        """Start from what the renderer has."""
        self.quality = {QUALITY_HEADING: QualityChoice(preset), **groups_of(resolve_quality(preset, overrides))}

    @property
    def preset(self) -> str:
        return self.quality[QUALITY_HEADING].preset

    def preset_parts(self, preset: str) -> dict[str, Any]:
        """The quality parts of a preset without overrides."""
        return {QUALITY_HEADING: QualityChoice(preset), **groups_of(resolve_quality(preset))}

    def overrides(self, base: Mapping[str, Any], more: Mapping[str, Any]) -> dict[str, Any]:
        """What the quality parts have otherwise than `base`, and of `more` what is no quality knob."""
        own = {key: value for key, value in more.items() if key not in QUALITY.rules}
        for heading, group in self.quality.items():
            _, dot, name = heading.partition(".")
            if dot:
                for rule in rules_of(type(group)):
                    if getattr(group, rule) != getattr(base[heading], rule):
                        own[f"{name}.{rule}"] = getattr(group, rule)
        return own
