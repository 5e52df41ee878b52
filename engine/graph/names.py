"""Names with a view and a planet in them: how they are written, who owns them, and which one a bare name means.

A pass or resource is declared by a bare name ("gbuffer.depth") in a scope: of a view, of a planet, of both, or of
neither (shared by all). Its qualified name says so: "gbuffer.depth@view1", "terrain.vertices@view1.planet2". Index 0 is
not written, so with one view and one planet all names are bare.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from .errors import GraphError

MARK = "@"
_PART = re.compile(r"(view|planet)(0|[1-9][0-9]*)")


@dataclass(frozen=True, slots=True)
class Scope:
    """Whose a declaration is. None: no view's (or planet's) in particular, so shared by all.

    home: the planet whose resources a bare name means in a scope without a planet: the one that the camera is on.
    """

    view: int | None = None
    planet: int | None = None
    home: int = 0


def qualified(base: str, view: int | None, planet: int | None) -> str:
    """The name with its indices: base, base@view1, base@planet2, base@view1.planet2. 0 and None are not written."""
    if not view and not planet:
        return base
    parts = [*([f"view{view}"] if view else []), *([f"planet{planet}"] if planet else [])]
    return f"{base}{MARK}{'.'.join(parts)}"


def split(name: str) -> tuple[str, int | None, int | None]:
    """(base, view, planet) of a name; None for an index that it doesn't say. Raises GraphError behind a strange @."""
    base, mark, suffix = name.partition(MARK)
    if not mark:
        return base, None, None
    said: dict[str, int] = {}
    for part in suffix.split("."):
        found = _PART.fullmatch(part)
        if found is None or found[1] in said:
            raise GraphError(
                f"name {name!r}: behind {MARK} stand a view and a planet, as in {base + '@view1'!r} or"
                f" {base + '@view1.planet2'!r}."
            )
        said[found[1]] = int(found[2])
    return base, said.get("view"), said.get("planet")


def canonical(name: str) -> str:
    """A name from outside all scopes as the graph writes it: "x@view0" is "x", what isn't said is 0."""
    return name if MARK not in name else qualified(*split(name))


def base_name(name: str) -> str:
    """The name without its view and planet: what a system calls it."""
    return name.partition(MARK)[0]


@dataclass(slots=True)
class _Owner:
    by_view: bool
    by_planet: bool
    places: dict[tuple[int | None, int | None], None] = field(default_factory=dict)

    def words(self) -> str:
        if not (self.by_view or self.by_planet):
            return "shared by all views and planets"
        return " and ".join([*(["by view"] if self.by_view else []), *(["by planet"] if self.by_planet else [])])


class Names:
    """The declared names of one kind ("resource" or "pass"), and who owns each: a bare name has one kind of owner in
    the whole graph, so that it never means a view's own in one place and a shared one in another."""

    def __init__(self, what: str) -> None:
        self._what = what
        self._owners: dict[str, _Owner] = {}

    def check(self, base: str, scope: Scope) -> None:
        """Raises GraphError for a name that cannot be declared in a scope, as others own it differently."""
        if MARK in base:
            raise GraphError(
                f"{self._what} {base!r}: {MARK} in a name stands before its view and planet, which come from"
                " builder.scope(view=, planet=); declare it there by its bare name."
            )
        owner = self._owners.get(base)
        by_view, by_planet = scope.view is not None, scope.planet is not None
        if owner is not None and (owner.by_view != by_view or owner.by_planet != by_planet):
            raise GraphError(
                f"{self._what} {base!r} is declared {_Owner(by_view, by_planet).words()} here and"
                f" {owner.words()} elsewhere: one name has one kind of owner; rename one, or declare both in like"
                " scopes (builder.scope)."
            )

    def add(self, base: str, scope: Scope) -> None:
        """Take in a name that is declared in a scope and has passed `check`."""
        owner = self._owners.get(base)
        if owner is None:
            owner = self._owners[base] = _Owner(scope.view is not None, scope.planet is not None)
        owner.places[scope.view, scope.planet] = None

    def drop(self, base: str) -> None:
        """Forget a name, to add it anew."""
        self._owners.pop(base, None)

    def find(self, name: str, scope: Scope) -> str:
        """The qualified name that a name means in a scope: indices that it doesn't say are the scope's.

        A name that nobody declares comes out as if the scope owned it. Raises GraphError where a pass without a view
        names what several views have.
        """
        base, view, planet = split(name)
        owner = self._owners.get(base)
        if owner is None:
            return qualified(base, scope.view if view is None else view, scope.planet if planet is None else planet)
        if owner.by_view and view is None:
            view = scope.view
            if view is None:
                views = sorted({v for v, _ in owner.places if v is not None})
                if len(views) > 1:
                    owners = ", ".join(repr(f"{base}{MARK}view{v}") for v in views)
                    raise GraphError(f"{name!r} alone is not enough outside a view, as several have one: say {owners}.")
                view = views[0]
        if owner.by_planet and planet is None:
            planet = scope.home if scope.planet is None else scope.planet
        return qualified(base, view, planet)

    def find_all(self, name: str, scope: Scope) -> tuple[str, ...]:
        """As find, but of all views (planets) where neither the name nor the scope says one; for orders."""
        base, view, planet = split(name)
        owner = self._owners.get(base)
        if owner is None:
            return (self.find(name, scope),)
        view = scope.view if view is None else view
        planet = scope.planet if planet is None else planet
        found = [
            qualified(base, v, p)
            for v, p in owner.places
            if (view is None or v is None or v == view) and (planet is None or p is None or p == planet)
        ]
        # Nobody's: named as find would, so that the message does.
        return tuple(found) or (qualified(base, view if owner.by_view else None, planet if owner.by_planet else None),)
