"""What the flight's panels work on: the scene's components and the quality knobs, as one store of parts by heading."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ._kinds import KINDS, PLANET_KINDS
from .components import Composite, Exposure, Planet, Sun, knob
from .engine.settings import install, rules_of
from .errors import SceneError
from .quality import _GROUPS as QUALITY_GROUPS
from .quality import QUALITY, resolve_quality
from .scene import PropHandle, Scene

__all__ = ["OPTIONAL", "QUALITY_HEADING", "PropParts", "QualityChoice", "SceneStore", "copied", "groups_of"]

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


@dataclass
class PropParts:
    """An object of a scene's: what it takes to add it again."""

    name: str
    components: tuple[Any, ...]


def copied(component: Any) -> Any:
    """A component that later changes leave as it is; a game's own kinds that are no dataclasses stay the same."""
    return dataclasses.replace(component) if hasattr(component, "__dataclass_fields__") else component


class SceneStore:
    """A scene's components by the names of their classes; quality as "Quality" (the preset) and "Quality.terrain" and
    so on. The quality parts are what is wanted: the app makes it so.

    Objects of the scene (props) are no parts of a state that can be gone back to, because games move them all the time.
    Single edits of theirs can be undone, by the heading that `object_heading` gives.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.quality: dict[str, Any] = {}
        self._kinds = {kind.__name__: kind for kind in KINDS.values()}
        self._planet = frozenset(PLANET_KINDS.values())
        self._props: dict[str, PropHandle] = {}

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
        if isinstance(part, PropParts):
            copies = (copied(component) for component in part.components)
            self._props[heading] = self.scene.add(*copies, name=part.name)
        elif heading in self.quality:
            self.quality[heading] = part
        else:
            self._handle(self._kinds[heading]).add(part)

    def take(self, heading: str) -> None:
        """See workbench.Store."""
        if heading in self._props:
            prop = self._props[heading]
            if prop in self.scene.props:  # the game may have taken it off
                self.scene.remove(prop)
            return
        self._handle(self._kinds[heading]).remove(self._kinds[heading])

    def find(self, heading: str) -> Any:
        """See workbench.Store: "object 3/Shape" is that component of an object."""
        name, _, kind = heading.partition("/")
        prop = self._props.get(name)
        if prop is None or prop not in self.scene.props:
            return None
        return next((part for part in prop.components() if type(part).__name__ == kind), None)

    def object_heading(self, prop: PropHandle) -> str:
        """What edits call an object: the same for one that was taken off and put back."""
        known = next((heading for heading, held in self._props.items() if held == prop), None)
        return known if known is not None else self._remember(prop)

    def new_object_heading(self) -> str:
        """For an object that is to be added."""
        return f"object {len(self._props) + 1}"

    def _remember(self, prop: PropHandle) -> str:
        heading = self.new_object_heading()
        self._props[heading] = prop
        return heading

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
