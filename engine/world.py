"""World: entities and their components, on an esper world of our own inside a process that may use esper too.

esper keeps one current world per process in module globals. A library that is embedded in somebody's game must never
leave its own world current, so each call here switches to ours, does its work and gives the host's world back, also
when an exception passes through. One lock serves all worlds because the thing it protects is process-wide.
"""

from __future__ import annotations

import copy
import itertools
import threading
import weakref
from collections import ChainMap
from collections.abc import Callable, Iterator, MutableMapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar, overload

import esper

__all__ = ["Key", "MissingError", "World"]

T = TypeVar("T")
C1 = TypeVar("C1")
C2 = TypeVar("C2")
C3 = TypeVar("C3")
C4 = TypeVar("C4")

_numbers = itertools.count(1)
_lock = threading.RLock()


def _has(entity: int, kinds: tuple[type, ...]) -> bool:
    return esper.entity_exists(entity) and esper.has_components(entity, *kinds)


class Key(str, Generic[T]):
    """The name of a world resource that is known to be a T. A plain name does as well, for anything."""

    __slots__ = ()


class MissingError(LookupError):
    """An entity, component or resource was asked for that isn't there (or isn't there any more)."""


def _delete_esper_world(name: str) -> None:
    with _lock:
        if name in esper.list_worlds() and esper.current_world != name:
            esper.delete_world(name)


_NOTHING = object()


class _Layered(ChainMap[str, Any]):
    """Two mappings, of which the first goes before; ChainMap's own `get` takes ten times as long for any number."""

    def get(self, key: str, default: Any = None) -> Any:
        own, shared = self.maps
        found = own.get(key, _NOTHING)
        return shared.get(key, default) if found is _NOTHING else found


@dataclass(eq=False)
class _Life:
    """What changes of a world as a whole; one for all that show its entities."""

    open: bool = True
    revision: int = 0


class World:
    """Entities with components, kept apart from every other world of the process.

    Several worlds may live at once. Structural changes (create, add, remove, delete) raise `structure_revision`, which
    is how a renderer sees that its frame graph may have to be compiled again; changes of a field's value don't.
    Costs: a call switches esper's world twice (0.5 us); enter `active()` once around bulk work to pay it once.
    Components and queries that were asked for before come from a cache until the structure changes.

    Close it when done; a forgotten world is freed with its object.
    """

    def __init__(self, name: str | None = None) -> None:
        self.name = f"planetfall:{name or 'world'}#{next(_numbers)}"
        self._life = _Life()
        self.resources: MutableMapping[str, Any] = {}
        """What is published, by key; `resource()` reads it with a message when it is missing."""
        self._sorted: dict[tuple[type, ...], list[Any]] = {}
        self._known: dict[tuple[int, type], Any] = {}
        self._listed: dict[int, tuple[object, ...]] = {}
        with self.active():
            pass  # switching to a new name makes the esper world
        self._finalizer = weakref.finalize(self._life, _delete_esper_world, self.name)

    # -- life -------------------------------------------------------------------------------------------------------

    @contextmanager
    def active(self) -> Iterator[World]:
        """Make this world esper's current one inside the `with`; the previous one comes back at its end.

        May be nested, with itself and with other worlds. Inside, plain esper queries act on this world, but structural
        changes belong on the World, or `structure_revision` doesn't hear of them.
        """
        if not self._life.open:
            raise RuntimeError(f"world {self.name} is closed: its entities are gone; make a new World")
        with _lock:
            before = esper.current_world
            if before == self.name:
                yield self
                return
            esper.switch_world(self.name)
            try:
                yield self
            finally:
                esper.switch_world(before)

    def _read(self, function: Callable[..., T], *arguments: object) -> T:
        """function(*arguments) while this world is esper's: as `active()`, at a third of its cost, which a frame pays a
        hundred times."""
        if not self._life.open:
            raise RuntimeError(f"world {self.name} is closed: its entities are gone; make a new World")
        with _lock:
            before = esper.current_world
            if before == self.name:
                return function(*arguments)
            esper.switch_world(self.name)
            try:
                return function(*arguments)
            finally:
                esper.switch_world(before)

    @property
    def closed(self) -> bool:
        return not self._life.open

    def close(self) -> None:
        """Delete everything in this world. A second call does nothing.

        Raises RuntimeError inside `active()` of this world, because the ground under that block would vanish.
        """
        with _lock:
            if not self._life.open:
                return
            if esper.current_world == self.name:
                raise RuntimeError(f"world {self.name} can't be closed inside its own active() block; leave it first")
            self._life.open = False
            self._sorted.clear()
            self._known.clear()
            self._listed.clear()
            self.resources.clear()
            self._finalizer()

    # -- entities and components --------------------------------------------------------------------------------------

    @property
    def structure_revision(self) -> int:
        """Goes up with every create, add, remove and delete; never with a change of a field's value."""
        return self._life.revision

    def create(self, *components: object) -> int:
        """Make an entity with these components; returns its number (1, 2, ... in order of creation)."""
        kinds = [type(component) for component in components]
        for component in components:
            self._refuse_class(component)
        if len(set(kinds)) != len(kinds):
            twice = next(kind for kind in kinds if kinds.count(kind) > 1)
            raise ValueError(f"create() got two {twice.__name__} components; an entity holds one of each type")
        with self.active():
            made = esper.create_entity(*components)
            self._changed()
            return made

    def exists(self, entity: int) -> bool:
        with self.active():
            return esper.entity_exists(entity)

    def delete(self, entity: int) -> None:
        """Delete an entity and its components at once. Raises MissingError when there is no such entity."""
        with self.active():
            self._require(entity, "delete")
            esper.delete_entity(entity, immediate=True)
            self._changed()

    def add(self, entity: int, component: object) -> None:
        """Give the entity a component; one of the same type is replaced."""
        self._refuse_class(component)
        with self.active():
            self._require(entity, f"add a {type(component).__name__} to")
            esper.add_component(entity, component)
            self._changed()

    def remove(self, entity: int, kind: type[C1]) -> C1:
        """Take the component of this type off the entity and return it; MissingError when it has none."""
        with self.active():
            self._require(entity, f"remove {kind.__name__} from")
            if not esper.has_component(entity, kind):
                raise MissingError(self._no_component(entity, kind))
            component = esper.remove_component(entity, kind)
            self._changed()
            return component

    def get(self, entity: int, kind: type[C1]) -> C1:
        """The entity's component of this type; MissingError says what the entity does have."""
        found = self.try_get(entity, kind)
        if found is None:
            with self.active():
                self._require(entity, f"get {kind.__name__} of")
                raise MissingError(self._no_component(entity, kind))
        return found

    def try_get(self, entity: int, kind: type[C1]) -> C1 | None:
        """The entity's component of this type, or None when there is no such entity or component."""
        key = (entity, kind)
        try:  # what a frame asks for a hundred times; emptied with every structural change
            return self._known[key]
        except KeyError:
            with _lock:
                found = self._known[key] = self._read(esper.try_component, entity, kind)
                return found

    def has(self, entity: int, *kinds: type) -> bool:
        """Whether the entity exists and has all these components."""
        return self._read(_has, entity, kinds)

    def components(self, entity: int) -> tuple[object, ...]:
        """All components of the entity, in the order in which they were added."""
        found = self._listed.get(entity)
        if found is None:
            with self.active():
                self._require(entity, "list the components of")
                found = self._listed[entity] = tuple(esper.components_for_entity(entity))
        return found

    @overload
    def query(self, a: type[C1], /) -> list[tuple[int, tuple[C1]]]: ...
    @overload
    def query(self, a: type[C1], b: type[C2], /) -> list[tuple[int, tuple[C1, C2]]]: ...
    @overload
    def query(self, a: type[C1], b: type[C2], c: type[C3], /) -> list[tuple[int, tuple[C1, C2, C3]]]: ...
    @overload
    def query(
        self, a: type[C1], b: type[C2], c: type[C3], d: type[C4], /
    ) -> list[tuple[int, tuple[C1, C2, C3, C4]]]: ...
    @overload
    def query(self, *kinds: type) -> list[tuple[int, tuple[Any, ...]]]: ...
    def query(self, *kinds: type) -> list[Any]:
        """All entities that have every one of these types: [(entity, (component, ...)), ...], sorted by entity.

        The list is cached and shared: read it, don't change it. Adding and removing while looping over it is fine
        (the loop goes on over the old list).
        """
        if not kinds:
            raise TypeError("query() needs at least one component type")
        found = self._sorted.get(kinds)
        if found is None:
            with _lock:
                # esper's own order is that of a set; frames have to be the same in every run.
                found = self._sorted[kinds] = sorted(self._read(esper.get_components, *kinds), key=lambda row: row[0])
        return found

    # -- resources ----------------------------------------------------------------------------------------------------

    def with_own_resources(self) -> World:
        """The same entities for one of several renderers: what its systems publish there they share among themselves
        alone, and what is published here they read too."""
        theirs = copy.copy(self)
        theirs.resources = _Layered({}, self.resources)
        return theirs

    @overload
    def set_resource(self, key: Key[T], value: T) -> None: ...
    @overload
    def set_resource(self, key: str, value: object) -> None: ...
    def set_resource(self, key: str, value: object) -> None:
        """Publish something that belongs to the world and not to an entity, e.g. "height_field" or "sea_top_m"."""
        self.resources[key] = value

    @overload
    def resource(self, key: Key[T]) -> T: ...
    @overload
    def resource(self, key: str) -> Any: ...
    def resource(self, key: str) -> object:
        """What was published under this key; MissingError lists the keys there are."""
        try:
            return self.resources[key]
        except KeyError:
            known = ", ".join(sorted(self.resources)) or "none yet"
            raise MissingError(
                f"world resource {key!r} was not set; set so far: {known}. The system that publishes it has to be "
                f"active and to have run before"
            ) from None

    @overload
    def try_resource(self, key: Key[T]) -> T | None: ...
    @overload
    def try_resource(self, key: str) -> Any | None: ...
    def try_resource(self, key: str) -> object:
        """The same, or None where nothing was published."""
        return self.resources.get(key)

    def remove_resource(self, key: str) -> None:
        """Withdraw a published thing; nothing happens when it isn't there."""
        self.resources.pop(key, None)

    def _changed(self) -> None:
        """The structure is another one now."""
        self._life.revision += 1
        self._known.clear()
        self._listed.clear()
        self._sorted.clear()

    # -- guards --------------------------------------------------------------------------------------------------------

    @staticmethod
    def _refuse_class(component: object) -> None:
        if isinstance(component, type):
            raise TypeError(f"got the class {component.__name__}, expected a component: write {component.__name__}()")

    def _require(self, entity: int, what: str) -> None:
        # esper accepts a missing entity for deletion and then fails in every later call.
        if not esper.entity_exists(entity):
            raise MissingError(f"can't {what} entity {entity}: world {self.name} has no such entity (any more)")

    @staticmethod
    def _no_component(entity: int, kind: type) -> str:
        has = ", ".join(sorted(type(c).__name__ for c in esper.components_for_entity(entity))) or "no components"
        return f"entity {entity} has no {kind.__name__}; it has {has}. Add one with add({kind.__name__}())"
