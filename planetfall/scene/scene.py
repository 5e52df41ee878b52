"""Scene: a world with a sun, a sky and planets, from a preset or a file and back into one.

Companions are further planets of a scene, such as a moon, each a scene of its own on an orbit or at a place:

    scene = pf.load_scene("earth")
    moon = scene.companions.add("moon", pf.Orbit(distance_m=3.844e8, phase_deg=40.0))
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Atmosphere, Clouds, Composite, Exposure, Ocean, Orbit, Planet, Shape, Sun, Terrain, Transform
from ..engine.settings import did_you_mean, write_toml
from ..engine.world import MissingError, World
from ..errors import SceneError, UnknownNameError
from .checks import cloud_problems, planet_problems
from .file import FORMAT, Description, describe, planets
from .ground import HeightFields
from .handle import Handle
from .kinds import KINDS, PLANET_KINDS, SCENE_KINDS, refuse_elsewhere
from .moving import set_places
from .orbits import overlaps, places, reach_m
from .saving import left_out, scene_tables

if TYPE_CHECKING:
    from ..engine.surface.field import HeightField
    from ..query.drainage import River

__all__ = [
    "Companion",
    "Companions",
    "Handle",
    "PlanetHandle",
    "PropHandle",
    "Scene",
    "load_scene",
    "planets",
]

log = logging.getLogger(__name__)

C = TypeVar("C")


class PlanetHandle(Handle["Scene"]):
    """A planet of a scene."""

    _place = "planet"

    @property
    def planet(self) -> Planet:
        """Its Planet component."""
        return self[Planet]

    @property
    def radius_m(self) -> float:
        """Radius of its reference sphere."""
        return self[Planet].radius_m

    def height_field(self) -> HeightField | None:
        """The ground's heights in float64 on the CPU; None without Terrain."""
        return self.scene.height_field(self)

    def add(self, component: C) -> C:
        """Give it this component, in place of one of the same type; returns the component. SceneError for clouds that
        cannot be on this planet: what else only fits together or not is checked by Scene.validate, before drawing."""
        if isinstance(component, Clouds):
            problems = cloud_problems(component, self.planet, self.get(Atmosphere))
            if problems:
                raise SceneError(f"planet {self.name!r}: {'; '.join(problems)}")
        return super().add(component)

    def remove(self, kind: type[C]) -> C:
        if kind is Planet:
            raise SceneError(f"planet {self.name!r} can't be without its Planet component; everything stands on it")
        return super().remove(kind)

    def ground_height_m(self, directions: ArrayLike) -> NDArray[np.float64]:
        """Height of the solid ground above the reference sphere, (N,), at unit directions (N, 3); 0 without Terrain."""
        directions = np.atleast_2d(np.asarray(directions, dtype=np.float64))
        field = self.height_field()
        return np.zeros(len(directions)) if field is None else field.height(directions)

    def surface_height_m(self, directions: ArrayLike) -> NDArray[np.float64]:
        """The higher of ground and sea, (N,), at unit directions (N, 3)."""
        sea = self.get(Ocean)
        directions = np.atleast_2d(np.asarray(directions, dtype=np.float64))
        if sea is not None and not self.has(Terrain):
            return np.full(len(directions), sea.sea_level_m)
        ground = self.ground_height_m(directions)
        return ground if sea is None else np.maximum(ground, sea.sea_level_m)

    def _what(self) -> str:
        return f"planet {self.name!r}"


class PropHandle(Handle["Scene"]):
    """An object of a game's in a scene, made by `scene.add`: Transform, Shape and whatever else the game gave it."""

    _place = "prop"

    def add(self, component: C) -> C:
        """Give it this component, in place of one of the same type; returns the component. Checks as scene.add."""
        self.scene.check_prop((component,))
        return super().add(component)

    def _what(self) -> str:
        return f"the object {self.name!r}"


class Scene:
    """What is rendered: a sun, a sky, the way to a picture, and planets. Made by `load_scene`.

    world: the truth, entities and components. planet: its own planet. planets: that and its companions', by name.
    environment: what belongs to the whole scene (Sun, Stars, Exposure, Composite). preset: whose named views apply.
    Changes take effect with the next frame. Not thread-safe against its renderer.
    """

    def __init__(self, name: str, components: Mapping[str, Any], *, preset: str | None = None, about: str = "") -> None:
        """components: {table name: component}, such as {"planet": Planet(), "terrain": Terrain()}."""
        unknown = [key for key in components if key not in KINDS]
        if unknown:
            raise UnknownNameError(f"no component table {unknown[0]!r}; {did_you_mean(unknown[0], KINDS, 'tables')}")
        self.name = name
        self.about = about
        self.preset = preset
        self.world = World(name)
        needed: dict[str, Any] = {"sun": Sun(), "exposure": Exposure(), "composite": Composite()}
        own = needed | {key: c for key, c in components.items() if key in SCENE_KINDS}
        body = {"planet": Planet()} | {key: c for key, c in components.items() if key in PLANET_KINDS}
        self.environment = Handle(self, self.world.create(*own.values()), name)
        self.planet = PlanetHandle(self, self.world.create(*body.values()), name)
        planets = {name: self.planet}
        self.planets: Mapping[str, PlanetHandle] = _Planets(planets)
        self.companions = Companions(self, planets)
        """Further planets, such as a moon: `scene.companions.add("moon", pf.Orbit(...))`."""
        self.accompanies: Scene | None = None
        """The scene of which this one is a companion."""
        self._fields = HeightFields()
        self._props: dict[int, PropHandle] = {}
        self.validate()

    # -- what is in it ------------------------------------------------------------------------------------------------

    @property
    def sun(self) -> Sun:
        """The one sun; assign a new Sun or change this one."""
        return self.environment[Sun]

    @sun.setter
    def sun(self, sun: Sun) -> None:
        if not isinstance(sun, Sun):
            raise SceneError(
                f"scene.sun: expected a pf.Sun, found {sun!r}. Write scene.sun = pf.Sun(direction=(x, y, z))"
            )
        self.environment.add(sun)

    def height_field(self, planet: PlanetHandle | None = None) -> HeightField | None:
        """The ground's heights in float64 on the CPU, as the renderer draws them; None without Terrain. Cached.

        A change that can't be (a map that can't be read) leaves the last good ones, as it does the renderer's ground.
        """
        return self._fields.of(planet or self.planet)

    def rivers(
        self,
        count: int = 20,
        planet: PlanetHandle | None = None,
        *,
        progress: Callable[[float], None] | None = None,
    ) -> list[River]:
        """The largest rivers of a planet's land by their water, the largest first; none without Terrain.

        Solved from the broad shape of the ground (20 s for a planet like Earth), and kept in the user's cache folder;
        those of the preset earth are part of the package. progress(share) follows. ValueError for a planet without
        land or without sea level.
        """
        from ..query.drainage import network_below, rivers_of

        handle = planet or self.planet
        return rivers_of(network_below(handle, progress=progress), count) if handle.get(Terrain) else []

    def validate(self, settings: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Check what single values can't show; SceneError lists everything that doesn't fit. Needs no GPU.

        settings: {"terrain.highest_m": ...}, values that stand in for those of components, as a renderer's overrides.
        """
        problems: list[str] = []
        sun = self.environment.get(Sun) or Sun()
        for handle in self.planets.values():
            problems += planet_problems(handle.name, handle, sun, settings)
        problems += self.companions.problems()
        if self.name in self.companions:  # it may have been renamed since
            problems.append("a companion has the scene's own name, which no file can tell apart; rename the scene")
        exposure = self.environment.get(Exposure)
        if exposure is not None and exposure.min_ev100 > exposure.max_ev100:
            problems.append(
                f"Exposure.min_ev100 ({exposure.min_ev100:g}) is above max_ev100 ({exposure.max_ev100:g}); swap them"
            )
        if problems:
            raise SceneError(f"scene {self.name!r}: " + "; ".join(problems))

    # -- a game's own objects -----------------------------------------------------------------------------------------

    def add(self, *components: Any, name: str = "") -> PropHandle:
        """A new object: scene.add(pf.Transform(position_m), pf.Shape("box", color=(0.6, 0.2, 0.1))).

        One with both Transform and Shape is drawn; further components are the game's own. A scene may have thousands.
        Raises SceneError for components that belong elsewhere and for mesh files that can't be used.
        """
        self.check_prop(components)
        entity = self.world.create(*components)
        handle = PropHandle(self, entity, name or f"prop {entity}")
        self._props[entity] = handle
        return handle

    def remove(self, prop: PropHandle) -> None:
        """Take an object out of the scene."""
        if prop.scene is not self or prop.entity not in self._props:
            raise MissingError(f"{prop.name!r} is not in scene {self.name!r} (any more)")
        del self._props[prop.entity]
        self.world.delete(prop.entity)

    @property
    def props(self) -> tuple[PropHandle, ...]:
        """The objects that were added, in that order."""
        return tuple(self._props.values())

    def move(self, props: Sequence[PropHandle], positions_m: ArrayLike, orientations: ArrayLike | None = None) -> None:
        """Set many Transforms at once: positions (N, 3) in planet axes, quaternions (N, 4) (x, y, z, w).

        The same as assigning each of them, ten times as fast: what a physics engine gives back each frame.
        """
        set_places([prop[Transform] for prop in props], positions_m, orientations)

    def check_prop(self, components: Sequence[Any]) -> None:
        """Raises SceneError for components that no object of this scene can have, as `add` does."""
        for component in components:
            refuse_elsewhere(component, "prop")
            if isinstance(component, Shape):
                from ..systems.props import is_file, load_mesh

                if is_file(component.form):
                    load_mesh(component.form)
            there = component.planet if isinstance(component, Transform) else ""
            if there and self.planets[there] is not self.planet:
                raise SceneError(
                    f"Transform.planet: {there!r} is a companion: its objects belong to its own scene; "
                    f"write scene.companions[{there!r}].scene.add(...)"
                )

    # -- files --------------------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene as TOML; `load_scene(path)` gives an equal one. Written beside, then renamed.

        Maps and meshes that are named from the current folder are named from the file's; those with whole paths stay.
        """
        self.validate()
        data: dict[str, Any] = {"format": FORMAT, "name": self.name}
        if self.about:
            data["about"] = self.about
        if self.preset is not None:
            data["like"] = self.preset
        data |= scene_tables(self)
        from .shared import count_from

        count_from(data, Path(path).parent)
        unknown, functions = left_out(self)
        if unknown:
            log.warning("%s: not saved, as scene files don't know these components: %s", path, ", ".join(unknown))
        if functions:
            log.warning(
                "%s: not saved, as no file can hold a function: %s; assign it again after load_scene",
                path,
                ", ".join(functions),
            )
        write_toml(path, data)

    def share(self, path: str | os.PathLike[str]) -> Path:
        """Write the scene and the maps that it names into one file, which opens elsewhere: `load_scene(path)`.

        path: ends in .planetfall. Written beside, then renamed; returned. PresetError when that can't be.
        """
        import tempfile

        from .shared import pack

        with tempfile.TemporaryDirectory() as folder:
            self.save(Path(folder) / "scene.toml")
            return pack(Path(folder) / "scene.toml", Path(path))

    # -- life ---------------------------------------------------------------------------------------------------------

    def release(self) -> None:
        """Delete the world. A renderer of this scene has to be released before."""
        self.companions.release()
        self._fields.clear()
        self._props.clear()
        self.world.close()

    def __enter__(self) -> Scene:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()

    def __repr__(self) -> str:
        return f"<Scene {self.name!r}: {self.planet!r}, {self.environment!r}>"


@dataclass(frozen=True, eq=False)
class Companion:
    """A planet beside a scene's own. name: as in `scene.planets`. scene: its own scene, whose planet it is, with its
    ground, sea, air, clouds and objects; sun, stars, exposure and composite are those of the scene that it accompanies.
    orbit: where it is; change its fields at any time."""

    name: str
    scene: Scene
    orbit: Orbit

    def __repr__(self) -> str:
        return f"<Companion {self.name!r}: {self.orbit!r}>"


class Companions(Mapping[str, Companion]):
    """The companions of a scene by name; `add` and `remove` take effect with the next frame."""

    def __init__(self, scene: Scene, planets: dict[str, PlanetHandle]) -> None:
        """planets: what `scene.planets` shows, kept up to date here."""
        self._scene, self._planets = scene, planets
        self._found: dict[str, Companion] = {}
        self._kept: list[Scene] = []

    def add(self, planet: Scene | str | os.PathLike[str], orbit: Orbit | None = None, name: str = "") -> Companion:
        """One more planet: a scene, or what `load_scene` takes. orbit: None is the Moon's distance. name: of the planet
        from then on; left out, the scene's.

        Raises SceneError, and adds nothing, for a name that is taken, a scene that is in use already or has companions
        itself, an orbit through another planet; UnknownNameError and PresetError as load_scene.
        """
        own = planet if isinstance(planet, Scene) else scene_of(planet)
        companion = Companion(name or own.name, own, Orbit() if orbit is None else orbit)
        try:
            self._check(companion)
        except BaseException:
            if own is not planet:
                own.release()
            raise
        self.join(companion)
        return companion

    def join(self, companion: Companion) -> None:
        """Take in a companion, or one that was removed before, unchecked: `Scene.validate` says what doesn't fit."""
        self._found[companion.name] = companion
        companion.scene.companions._call(companion.name)
        companion.scene.accompanies = self._scene
        self._planets[companion.name] = companion.scene.planet
        self.share_environment()

    def _call(self, name: str) -> None:
        """Give this scene's own planet another name. Its objects follow it."""
        planet, before = self._scene.planet, next(iter(self._planets))
        for prop in self._scene.props:
            place = prop.get(Transform)
            if place is not None and place.planet in (before, planet.name):
                place.planet = name
        self._planets[name] = self._planets.pop(before)
        planet.name = name

    def keep(self, scene: Scene) -> None:
        """Have a scene released with the one that these accompany, whether it is a companion then or not."""
        self._kept.append(scene)

    def remove(self, name: str) -> Companion:
        """Take a planet out of the scene; its own scene stays. UnknownNameError for one that isn't there."""
        companion = self[name]
        del self._found[name], self._planets[name]
        companion.scene.accompanies = None
        return companion

    def release(self) -> None:
        """Release all their scenes, with the scene that they accompany."""
        for scene in (*(companion.scene for companion in self._found.values()), *self._kept):
            if not scene.world.closed:
                scene.release()
        self._found.clear()
        self._kept.clear()

    def share_environment(self) -> None:
        """Give every companion the scene's own stars, exposure and composite; done again when those are replaced."""
        shared = {type(part): part for part in self._scene.environment.components()}
        for companion in self._found.values():
            theirs = companion.scene.environment
            for kind, part in shared.items():
                if kind is not Sun and theirs.get(kind) is not part:
                    companion.scene.world.add(theirs.entity, part)
            for kind in SCENE_KINDS.values():
                if kind not in shared and kind is not Sun and theirs.has(kind):
                    companion.scene.world.remove(theirs.entity, kind)

    def problems(self) -> list[str]:
        """What doesn't fit together, at time 0."""
        if not self._found:
            return []
        own, others = self._scene.planet, {name: found.scene.planet for name, found in self._found.items()}
        orbits = [(found.orbit, found.scene.planet.planet) for found in self._found.values()]
        there = places(self._scene.sun, own.planet, orbits, 0.0)
        reaches = [(name, at, reach_m(planet)) for (name, planet), (at, _) in zip(others.items(), there, strict=True)]
        return overlaps([(own.name, np.zeros(3), reach_m(own)), *reaches])

    def _check(self, companion: Companion) -> None:
        where = f"companion {companion.name!r} of scene {self._scene.name!r}"
        if not isinstance(companion.orbit, Orbit):
            raise SceneError(f"{where}: orbit: expected a pf.Orbit, found {companion.orbit!r}")
        if self._scene.accompanies is not None:
            raise SceneError(
                f"{where}: that scene accompanies {self._scene.accompanies.name!r} itself, and companions have no "
                "companions; add both to the same scene"
            )
        if companion.name in (*self._scene.planets, self._scene.name):
            there = ", ".join(self._scene.planets)
            raise SceneError(f"{where}: the scene has a planet of that name ({there}); give another: add(..., name=)")
        if companion.scene is self._scene or companion.scene.accompanies is not None:
            raise SceneError(f"{where}: its scene is in use already; load another one for it")
        if companion.scene.companions:
            raise SceneError(f"{where}: it has companions itself; add all of them to {self._scene.name!r}")
        self._found[companion.name] = companion
        try:
            problems = self.problems()
        finally:
            del self._found[companion.name]
        if problems:
            raise SceneError(f"{where}: {'; '.join(problems)}")

    def __getitem__(self, name: str) -> Companion:
        try:
            return self._found[name]
        except KeyError:
            hint = did_you_mean(name, self._found, "its companions")
            raise UnknownNameError(f"scene {self._scene.name!r} has no companion {name!r}; {hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._found)

    def __len__(self) -> int:
        return len(self._found)


class _Planets(Mapping[str, PlanetHandle]):
    """Planets by name; a wrong name says which there are."""

    def __init__(self, handles: dict[str, PlanetHandle]) -> None:
        self._handles = MappingProxyType(handles)

    def __getitem__(self, name: str) -> PlanetHandle:
        try:
            return self._handles[name]
        except KeyError:
            hint = did_you_mean(name, self._handles, "its planets")
            raise UnknownNameError(f"the scene has no planet {name!r}; {hint}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._handles)

    def __len__(self) -> int:
        return len(self._handles)


def load_scene(source: str | os.PathLike[str] = "earth") -> Scene:
    """A scene from the name of a planet preset, or from a path to a TOML file (anything with .toml or a separator).

    Everything is checked here, before any GPU work. Raises UnknownNameError (with the nearest preset), PresetError
    (naming file, key, expected and found) or SceneError (parts that don't fit together).
    """
    return scene_of(source)


def scene_of(source: str | os.PathLike[str] | Description) -> Scene:
    """As load_scene, also from what was read already."""
    found = source if isinstance(source, Description) else describe(source)
    try:
        scene = Scene(found.name, found.components, preset=found.preset, about=found.about)
        for name, components in found.props:
            scene.add(*components, name=name)
        for described, orbit in found.companions:
            scene.companions.add(scene_of(described), orbit)
    except (SceneError, UnknownNameError) as error:
        raise SceneError(f"{found.path}: {error}") from None
    return scene
