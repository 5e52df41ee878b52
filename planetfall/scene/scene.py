"""Scene: a world with a sun, a sky and planets, from a preset or a file and back into one."""

from __future__ import annotations

import logging
import os
import weakref
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType, TracebackType
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..components import Atmosphere, Clouds, Composite, Exposure, Ocean, Planet, Shape, Sun, Terrain, Transform
from ..engine.settings import SettingError, assign_many, did_you_mean, plain_table, revision, write_toml
from ..engine.world import MissingError, World
from ..errors import SceneError, UnknownNameError
from .checks import cloud_problems, planet_problems
from .companions import Companion, Companions
from .file import Description, describe, planets
from .kinds import KINDS, PLANET_KINDS, PROP_KINDS, SCENE_KINDS

if TYPE_CHECKING:
    from ..engine.surface.field import HeightField

__all__ = ["Handle", "PlanetHandle", "PropHandle", "Scene", "current_scene", "load_scene", "planets"]

log = logging.getLogger(__name__)

C = TypeVar("C")

_latest: weakref.ref[Scene] | None = None


class Handle:
    """An entity of a scene: its components by type. `handle[Ocean].sea_level_m = 10.0`, `Ocean in handle`."""

    def __init__(self, scene: Scene, entity: int, name: str) -> None:
        self.scene = scene
        self.entity = entity
        self.name = name

    def __getitem__(self, kind: type[C]) -> C:
        found = self.get(kind)
        if found is None:
            raise MissingError(self._missing(kind))
        return found

    def get(self, kind: type[C]) -> C | None:
        """The component of this type, or None."""
        return self.scene.world.try_get(self.entity, kind)

    def has(self, kind: type) -> bool:
        """Whether it has a component of this type."""
        return self.scene.world.has(self.entity, kind)

    __contains__ = has

    def add(self, component: C) -> C:
        """Give it this component, in place of one of the same type; returns the component."""
        kind = component if isinstance(component, type) else type(component)
        self._refuse_elsewhere(kind)
        self.scene.world.add(self.entity, component)
        return component

    def remove(self, kind: type[C]) -> C:
        """Take the component off and return it; what it drew costs nothing from the next frame on."""
        if not self.has(kind):
            raise MissingError(self._missing(kind))
        return self.scene.world.remove(self.entity, kind)

    def components(self) -> tuple[Any, ...]:
        """All its components."""
        return self.scene.world.components(self.entity)

    def _refuse_elsewhere(self, kind: type) -> None:
        if kind in PLANET_KINDS.values():
            raise SceneError(f"{kind.__name__} belongs to a planet; add it with scene.planet.add(...)")
        if kind in PROP_KINDS.values():
            raise SceneError(f"{kind.__name__} belongs to an object of its own: scene.add(pf.Transform(), pf.Shape())")

    def _missing(self, kind: type) -> str:
        has = ", ".join(type(c).__name__ for c in self.components()) or "nothing"
        if kind in SCENE_KINDS.values() and isinstance(self, PlanetHandle):
            place = "scene.sun" if kind is Sun else f"scene.environment[pf.{kind.__name__}]"
            return f"planet {self.name!r} has no {kind.__name__}; it belongs to the scene: {place}"
        return f"{self._what()} has no {kind.__name__}, only {has}; add one with add(pf.{kind.__name__}())"

    def _what(self) -> str:
        return f"the environment of scene {self.name!r}"

    def __repr__(self) -> str:
        has = ", ".join(type(c).__name__ for c in self.components())
        return f"<{type(self).__name__} {self.name!r}: {has}>"

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Handle) and (other.scene is self.scene) and other.entity == self.entity

    def __hash__(self) -> int:
        return hash((id(self.scene), self.entity))


class PlanetHandle(Handle):
    """A planet of a scene."""

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

    def _refuse_elsewhere(self, kind: type) -> None:
        if kind in SCENE_KINDS.values():
            place = "assign scene.sun" if kind is Sun else "add it with scene.environment.add(...)"
            raise SceneError(f"{kind.__name__} belongs to the scene, not to a planet; {place}")
        if kind in PROP_KINDS.values():
            raise SceneError(f"{kind.__name__} belongs to an object of its own: scene.add(pf.Transform(), pf.Shape())")

    def _what(self) -> str:
        return f"planet {self.name!r}"


class PropHandle(Handle):
    """An object of a game's in a scene, made by `scene.add`: Transform, Shape and whatever else the game gave it."""

    def _refuse_elsewhere(self, kind: type) -> None:
        if kind in PLANET_KINDS.values():
            raise SceneError(f"{kind.__name__} belongs to a planet; add it with scene.planet.add(...)")
        if kind in SCENE_KINDS.values():
            raise SceneError(f"{kind.__name__} belongs to the scene; add it with scene.environment.add(...)")

    def add(self, component: C) -> C:
        """Give it this component, in place of one of the same type; returns the component. Checks as scene.add."""
        self.scene._check_prop((component,))
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
        self._handles = {name: self.planet}
        self.planets: Mapping[str, PlanetHandle] = _Planets(self._handles)
        self.companions = Companions(self)
        """Further planets, such as a moon: `scene.companions.add("moon", pf.Orbit(...))`."""
        self.accompanies: Scene | None = None
        """The scene of which this one is a companion."""
        self._fields: dict[int, tuple[tuple[int, int], HeightField]] = {}
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
        planet = planet or self.planet
        terrain = planet.get(Terrain)
        if terrain is None:
            return None
        stamp = (revision(terrain), revision(planet[Planet], "radius_m"))
        known = self._fields.get(planet.entity)
        if known is not None and known[0] == stamp:
            return known[1]
        from ..systems.terrain.height import TerrainField, TerrainParams

        try:
            params = TerrainParams.from_component(terrain, planet.radius_m)
        except ValueError as error:
            if known is not None:
                log.error("Terrain stays as it was: %s", error)
                self._fields[planet.entity] = (stamp, known[1])
                return known[1]
            raise SceneError(f"Terrain on a planet of {planet.radius_m:g} m cannot be: {error}") from error
        field: HeightField = TerrainField(params)
        self._fields[planet.entity] = (stamp, field)
        return field

    def validate(self, settings: Mapping[str, Any] = MappingProxyType({})) -> None:
        """Check what single values can't show; SceneError lists everything that doesn't fit. Needs no GPU.

        settings: {"terrain.highest_m": ...}, values that stand in for those of components, as a renderer's overrides.
        """
        problems: list[str] = []
        sun = self.environment.get(Sun) or Sun()
        for handle in self.planets.values():
            problems += planet_problems(handle, sun, settings)
        problems += self.companions.problems()
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
        self._check_prop(components)
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
        transforms = [prop[Transform] for prop in props]
        places, turned = _rows("positions_m", positions_m, len(props), 3), None
        if orientations is not None:
            turned = _rows("orientations", orientations, len(props), 4)
            zero = next((k for k, q in enumerate(turned) if not any(q)), None)
            if zero is not None:
                raise SettingError(f"move: orientations[{zero}] is all zero; no rotation has that quaternion")
        assign_many(transforms, "position_m", places)
        if turned is not None:
            assign_many(transforms, "orientation", turned)

    def _check_prop(self, components: Sequence[Any]) -> None:
        for component in components:
            kind = component if isinstance(component, type) else type(component)
            if kind in (*PLANET_KINDS.values(), *SCENE_KINDS.values()):
                place = "scene.planet" if kind in PLANET_KINDS.values() else "scene.environment"
                raise SceneError(f"{kind.__name__} belongs to no object of a game's; add it with {place}.add(...)")
            if isinstance(component, Shape):
                from ..systems.props import is_file, load_mesh

                if is_file(component.form):
                    load_mesh(component.form)
            if isinstance(component, Transform) and self.planets[component.planet or self.name] is not self.planet:
                raise SceneError(
                    f"Transform.planet: {component.planet!r} is a companion: its objects belong to its own scene; "
                    f"write scene.companions[{component.planet!r}].scene.add(...)"
                )

    # -- files --------------------------------------------------------------------------------------------------------

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the scene as TOML; `load_scene(path)` gives an equal one. Written beside, then renamed."""
        self.validate()
        data: dict[str, Any] = {"name": self.name}
        if self.about:
            data["about"] = self.about
        if self.preset is not None:
            data["like"] = self.preset
        for table, kind in KINDS.items():
            component = (self.planet if table in PLANET_KINDS else self.environment).get(kind)
            if component is not None:
                data[table] = plain_table(component)
        tables = {kind: table for table, kind in PROP_KINDS.items()}
        if self._props:
            data["props"] = [
                {"name": p.name, **{tables[type(c)]: plain_table(c) for c in p.components() if type(c) in tables}}
                for p in self.props
            ]
        if self.companions:
            data["companions"] = [companion_table(companion) for companion in self.companions.values()]
        handles = (self.planet, self.environment, *self.props)
        known = {*KINDS.values(), *tables}
        left_out = sorted({type(c).__name__ for h in handles for c in h.components()} - {k.__name__ for k in known})
        if left_out:
            log.warning("%s: not saved, as scene files don't know these components: %s", path, ", ".join(left_out))
        write_toml(path, data)

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


def _rows(name: str, values: ArrayLike, count: int, width: int) -> list[tuple[float, ...]]:
    """Checked rows of an array as tuples of plain floats."""
    rows = np.asarray(values, dtype=np.float64)
    if rows.shape != (count, width):
        raise SettingError(f"move: {name}: expected shape ({count}, {width}), found {rows.shape}")
    bad = np.flatnonzero(~np.isfinite(rows).all(axis=1))
    if bad.size:
        raise SettingError(f"move: {name}[{bad[0]}]: expected finite numbers, found {rows[bad[0]].tolist()}")
    return list(map(tuple, rows.tolist()))


def companion_table(companion: Companion) -> dict[str, Any]:
    """A companion as a table of a scene file: whole, without a preset that it would change."""
    own = companion.scene
    table: dict[str, Any] = {"name": companion.name, "like": own.preset} if own.preset else {"name": companion.name}
    table["orbit"] = plain_table(companion.orbit)
    for key, kind in PLANET_KINDS.items():
        component = own.planet.get(kind)
        if component is not None:
            table[key] = plain_table(component)
    return table


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
    global _latest  # noqa: PLW0603
    scene = scene_of(source)
    _latest = weakref.ref(scene)
    return scene


def scene_of(source: str | os.PathLike[str] | Description) -> Scene:
    """As load_scene, but cameras without a scene don't come to mean this one."""
    found = source if isinstance(source, Description) else describe(source)
    try:
        scene = Scene(found.name, found.components, preset=found.preset, about=found.about)
        for name, components in found.props:
            scene.add(*components, name=name)
        for told, orbit in found.companions:
            scene.companions.add(scene_of(told), orbit)
    except (SceneError, UnknownNameError) as error:
        raise SceneError(f"{found.path}: {error}") from None
    return scene


def current_scene() -> Scene | None:
    """The scene that was loaded last, if it still lives: what cameras without a planet refer to until rendered."""
    scene = _latest() if _latest is not None else None
    return None if scene is None or scene.world.closed else scene
