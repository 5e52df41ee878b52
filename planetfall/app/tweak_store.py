"""What the flight's panels work on: the components of a scene and of its companions, and the quality knobs, as one
store of parts by heading."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from ..components import Composite, Exposure, Orbit, Planet, Sun, knob
from ..engine.settings import install, rules_of
from ..errors import SceneError
from ..quality import GROUPS as QUALITY_GROUPS
from ..quality import QUALITY, resolve_quality
from ..scene.kinds import KINDS, PLANET_KINDS
from ..scene.scene import Companion, PropHandle, Scene

__all__ = [
    "OPTIONAL",
    "QUALITY_HEADING",
    "PropParts",
    "QualityChoice",
    "SceneStore",
    "copied",
    "groups_of",
    "of_companion",
]

REQUIRED = (Planet, Sun, Exposure, Composite)
OPTIONAL: tuple[type, ...] = tuple(kind for kind in KINDS.values() if kind not in REQUIRED)
"""Components that a scene can do without: they have a switch."""

QUALITY_HEADING = "Quality"
_OF = ": "


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
    """An object of a scene's: what it takes to add it again. planet: whose, by name; "" for the scene's own."""

    name: str
    components: tuple[Any, ...]
    planet: str = ""


def of_companion(name: str, kind: type) -> str:
    """The heading of a companion's part, such as "moon: Terrain"."""
    return f"{name}{_OF}{kind.__name__}"


T = TypeVar("T")


def copied(component: T) -> T:
    """A component that later changes leave as it is; a game's own kinds that are no dataclasses stay the same."""
    return dataclasses.replace(component) if dataclasses.is_dataclass(component) else component  # type: ignore[type-var]


class SceneStore:
    """A scene's components by the names of their classes, a companion's as "moon: Terrain"; quality as "Quality" (the
    preset) and "Quality.terrain" and so on. The quality parts are what is wanted: the app makes it so.

    A companion is in the scene while "moon: Orbit" is among the parts. One that was taken out leaves its scene behind,
    with its objects and whatever a game holds of it, but without its parts; it is the same when they are put back.

    origins: parts of companions that were added here, as they were then: what "reset" goes back to.

    Objects (props) of the scene and of its companions are no parts of a state that can be gone back to, because games
    move them all the time. Single edits of theirs can be undone, by the heading that `object_heading` gives.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.quality: dict[str, Any] = {}
        self._kinds = {kind.__name__: kind for kind in KINDS.values()}
        self._planet = frozenset(PLANET_KINDS.values())
        self._props: dict[str, PropHandle] = {}
        self._known: dict[str, Companion] = {}
        self.origins: dict[str, Any] = {}

    def scene_parts(self) -> dict[str, Any]:
        """The parts of the scene's own planet, and what belongs to the whole scene."""
        handles = (self.scene.planet, self.scene.environment)
        found = {type(part): part for handle in handles for part in handle.components()}
        return {name: found[kind] for name, kind in self._kinds.items() if kind in found}

    def companion_parts(self, name: str) -> dict[str, Any]:
        """The parts of one companion."""
        companion = self.scene.companions[name]
        self._known[name] = companion
        return _parts_of(name, companion)

    def parts(self) -> dict[str, Any]:
        """See workbench.Store."""
        found = self.scene_parts()
        for name in self.scene.companions:
            found |= self.companion_parts(name)
        return {**found, **self.quality}

    def put(self, heading: str, part: Any) -> None:
        """See workbench.Store."""
        if isinstance(part, PropParts):
            copies = (copied(component) for component in part.components)
            self._props[heading] = self._scene_of(part.planet).add(*copies, name=part.name)
        elif heading in self.quality:
            self.quality[heading] = part
        else:
            name, _, kind = heading.rpartition(_OF)
            if kind == Orbit.__name__:
                self._join(name, part)
                return
            # Unchecked: what doesn't fit may be mended by the next part of the same step, and is told after that.
            handle = self._companion(name).scene.planet if name else self._handle(self._kinds[kind])
            handle.scene.world.add(handle.entity, part)

    def take(self, heading: str) -> None:
        """See workbench.Store."""
        if heading in self._props:
            prop = self._props[heading]
            if _there(prop):  # the game may have taken it off
                prop.scene.remove(prop)
            return
        name, _, kind = heading.rpartition(_OF)
        if not name:
            self._handle(self._kinds[kind]).remove(self._kinds[kind])
        elif kind == Orbit.__name__:
            if name in self.scene.companions:  # the game may have taken it out
                self._known[name] = self.scene.companions.remove(name)
        elif self._kinds[kind] not in REQUIRED:
            planet = self._companion(name).scene.planet
            if planet.has(self._kinds[kind]):
                planet.remove(self._kinds[kind])

    def find(self, heading: str) -> Any:
        """See workbench.Store: "object 3/Shape" is that component of an object."""
        name, _, kind = heading.partition("/")
        prop = self._props.get(name)
        if prop is None or not _there(prop):
            return None
        return next((part for part in prop.components() if type(part).__name__ == kind), None)

    # -- companions --------------------------------------------------------------------------------------------------

    def expect(self, name: str, planet: Scene, orbit: Orbit) -> dict[str, Any]:
        """The parts that bring a planet into the scene under this name, once they are put. planet: a scene of its own,
        from now on released with this one."""
        if name not in self.scene.companions:
            self._known[name] = Companion(name, planet, orbit)
        self.scene.companions.keep(planet)
        parts = {heading: copied(part) for heading, part in _parts_of(name, Companion(name, planet, orbit)).items()}
        self.origins.update(parts)
        return {heading: copied(part) for heading, part in parts.items()}

    def free_name(self, name: str) -> str:
        """A name that no planet of the scene has: this one, or with a number behind it."""
        tries = (name, *(f"{name} {k}" for k in range(2, len(self.scene.planets) + 2)))
        return next(tried for tried in tries if tried not in self.scene.planets)

    def _scene_of(self, planet: str) -> Scene:
        """The scene that a planet's objects are in."""
        return self.scene if planet in ("", self.scene.planet.name) else self._companion(planet).scene

    def _companion(self, name: str) -> Companion:
        """A companion that is in the scene, or was or will be."""
        held = self.scene.companions.get(name) or self._known.get(name)
        if held is None or held.scene.world.closed or held.scene.accompanies not in (None, self.scene):
            held = Companion(name, Scene(name, {}), Orbit())  # a game has taken it away
            self.scene.companions.keep(held.scene)
        self._known[name] = held
        return held

    def _join(self, name: str, orbit: Orbit) -> None:
        companion = self._companion(name)
        for field in rules_of(Orbit):
            setattr(companion.orbit, field, getattr(orbit, field))
        self.scene.companions.join(companion)

    # -- objects -----------------------------------------------------------------------------------------------------

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


def _there(prop: PropHandle) -> bool:
    return not prop.scene.world.closed and prop in prop.scene.props


def _parts_of(name: str, companion: Companion) -> dict[str, Any]:
    planet = companion.scene.planet
    kinds = (kind for kind in PLANET_KINDS.values() if planet.has(kind))
    own = {of_companion(name, kind): planet[kind] for kind in kinds}
    return {of_companion(name, Orbit): companion.orbit, **own}
