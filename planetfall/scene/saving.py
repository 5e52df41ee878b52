"""A scene as plain tables, as its file has them, and what no file can hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

from ..components import Orbit
from ..engine.settings import functions_of, plain_table
from .handle import Parts
from .kinds import KINDS, PLANET_KINDS, PROP_KINDS

__all__ = ["companion_table", "left_out", "prop_tables", "scene_tables"]


class Entity(Parts, Protocol):
    """What a file tells of an entity."""

    name: str

    def components(self) -> tuple[object, ...]: ...


class Accompanying(Protocol):
    """What a companion's table tells."""

    @property
    def name(self) -> str: ...
    @property
    def scene(self) -> Saved: ...
    @property
    def orbit(self) -> Orbit: ...


class Saved(Protocol):
    """What a scene's file tells."""

    preset: str | None

    @property
    def planet(self) -> Entity: ...
    @property
    def environment(self) -> Entity: ...
    @property
    def props(self) -> Sequence[Entity]: ...
    @property
    def companions(self) -> Mapping[str, Accompanying]: ...


def scene_tables(scene: Saved) -> dict[str, Any]:
    """The content of its file below the name: components, objects and companions."""
    data: dict[str, Any] = {}
    for table, kind in KINDS.items():
        component = (scene.planet if table in PLANET_KINDS else scene.environment).get(kind)
        if component is not None:
            data[table] = plain_table(component)
    if scene.props:
        data["props"] = prop_tables(scene)
    if scene.companions:
        data["companions"] = [companion_table(companion) for companion in scene.companions.values()]
    return data


def prop_tables(scene: Saved) -> list[dict[str, Any]]:
    """Its objects, each with a name and tables of its components."""
    tables = {kind: table for table, kind in PROP_KINDS.items()}
    found: list[dict[str, Any]] = []
    for prop in scene.props:
        own = {tables[type(c)]: plain_table(c) for c in prop.components() if type(c) in tables}
        if own.get("transform", {}).get("planet"):
            own["transform"]["planet"] = ""  # always its scene's own one, which may be called otherwise as a companion
        found.append({"name": prop.name, **own})
    return found


def companion_table(companion: Accompanying) -> dict[str, Any]:
    """A companion as a table of a scene file: whole, without a preset that it would change."""
    own = companion.scene
    table: dict[str, Any] = {"name": companion.name, "like": own.preset} if own.preset else {"name": companion.name}
    table["orbit"] = plain_table(companion.orbit)
    for key, kind in PLANET_KINDS.items():
        component = own.planet.get(kind)
        if component is not None:
            table[key] = plain_table(component)
    if own.props:
        table["props"] = prop_tables(own)
    return table


def left_out(scene: Saved) -> tuple[list[str], list[str]]:
    """(names of components that files don't know, names of knobs that hold a function, which no file can)."""
    known = {*KINDS.values(), *PROP_KINDS.values()}
    parts = [part for handle in _handles(scene) for part in handle.components()]
    unknown = sorted({type(part).__name__ for part in parts if type(part) not in known})
    return unknown, [name for part in parts for name in functions_of(part)]


def _handles(scene: Saved) -> Iterator[Entity]:
    yield from (scene.planet, scene.environment, *scene.props)
    for companion in scene.companions.values():
        yield from (companion.scene.planet, *companion.scene.props)
