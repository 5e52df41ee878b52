"""All that a builder and its scopes have collected, and how its names are resolved once everybody has declared."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace

from .declaration import PassDecl
from .errors import GraphError
from .names import MARK, Names, Scope, canonical, qualified
from .resources import ImportKind, ImportSpec
from .sizes import Size

_NAMED = ("reads", "reads_optional", "writes", "history")
_ORDER = ("after", "after_optional")
_SAME = ("creates", *_NAMED, *_ORDER, "stage", "side_effect", "kind", "system")


@dataclass(slots=True)
class _Import:
    kind: ImportKind
    help: str
    scopes: dict[Scope, object]


@dataclass(slots=True)
class Declared:
    """Shared by a GraphBuilder and all its scopes. passes: by qualified name; creators: resource -> pass, both
    qualified; imports: by bare name; sizes: views with a size of their own."""

    passes: dict[str, PassDecl] = field(default_factory=dict)
    creators: dict[str, str] = field(default_factory=dict)
    imports: dict[str, _Import] = field(default_factory=dict)
    exports: dict[tuple[str, Scope | None], None] = field(default_factory=dict)
    sizes: dict[int, Size] = field(default_factory=dict)
    resources: Names = field(default_factory=lambda: Names("resource"))
    pass_names: Names = field(default_factory=lambda: Names("pass"))
    indexed: bool = False
    """Some scope or name has an index other than 0: names have to be resolved. Else every name means itself."""
    _created: dict[str, str] = field(default_factory=dict)
    _origins: dict[str, list[Scope]] = field(default_factory=dict)

    def add_import(self, name: str, kind: ImportKind, help: str, lent: object, scope: Scope) -> ImportSpec:
        """See GraphBuilder.import_."""
        spec = ImportSpec(name, kind, help, lent)
        if MARK in name:
            raise GraphError(f"import {name!r}: declare it by its bare name, in builder.scope(view=, planet=).")
        known = self.imports.get(name)
        if known is not None and known.kind != kind:
            raise GraphError(f"import {name!r} was declared as a {known.kind} and now as a {kind}; use one kind.")
        if name in self._created:
            raise GraphError(
                f"import {name!r} has the name of a resource that pass {self._created[name]!r} creates; rename one."
            )
        if known is None:
            known = self.imports[name] = _Import(kind, help, {})
        known.scopes[scope] = lent
        return spec

    def add_pass(self, decl: PassDecl, bare: str, created: Iterable[str], origin: Scope) -> None:
        """Take a pass in. bare, created: its name and its resources' without indices. origin: the scope of the view
        that declares it, which may be narrower than the pass's own. See GraphBuilder.add_pass."""
        name = decl.name
        if name in self.passes and self._repeated(decl, origin):
            return
        self.pass_names.check(bare, decl.scope)
        if name in self.passes:
            other = self.passes[name]
            raise GraphError(
                f"two passes are called {name!r} (systems {other.system!r} and {decl.system!r}); rename one, or declare"
                " it once."
            )
        for spec, base in zip(decl.creates, created, strict=True):
            if base in self.imports:
                raise GraphError(f"pass {name!r} creates {spec.name!r}, which is an import; put it into writes=.")
            self.resources.check(base, decl.scope)
            if spec.name in self.creators:
                raise GraphError(
                    f"pass {name!r} creates {spec.name!r}, but pass {self.creators[spec.name]!r} creates it already; a"
                    f" resource has one creator: put it into writes= with after=({self.creators[spec.name]!r},)."
                )
        self.passes[name] = decl
        self._origins[name] = [origin]
        self.pass_names.add(bare, decl.scope)
        for spec, base in zip(decl.creates, created, strict=True):
            self.resources.add(base, decl.scope)
            self.creators[spec.name] = self._created[base] = name
        if not self.indexed:
            for names in (decl.reads, decl.writes, decl.after, decl.history, decl.reads_optional, decl.after_optional):
                for n in names:
                    if MARK in n:
                        self.indexed = True

    def _repeated(self, decl: PassDecl, origin: Scope) -> bool:
        """Whether this is a shared pass, declared again for another view or planet: the first one counts."""
        other, origins = self.passes[decl.name], self._origins[decl.name]
        own = (decl.scope.view, decl.scope.planet)
        if own != (other.scope.view, other.scope.planet) or own == (origin.view, origin.planet) or origin in origins:
            return False
        if other.system != decl.system:
            return False
        for part in _SAME:
            if getattr(other, part) != getattr(decl, part):
                raise GraphError(
                    f"pass {decl.name!r} is shared, but {part}={getattr(decl, part)!r} here is not what was declared"
                    f" before: {getattr(other, part)!r}; what views or planets share must not depend on one of them."
                )
        origins.append(origin)
        return True

    def resolved(self) -> tuple[tuple[PassDecl, ...], dict[str, ImportSpec], tuple[str, ...]]:
        """Passes, imports and exports with qualified names. Raises GraphError for a name that means several."""
        imports = self._resolved_imports()
        if not self.indexed:
            return tuple(self.passes.values()), imports, tuple(dict.fromkeys(name for name, _ in self.exports))
        exports = (
            canonical(name) if scope is None else self.resources.find(name, scope) for name, scope in self.exports
        )
        return tuple(map(self._resolved, self.passes.values())), imports, tuple(dict.fromkeys(exports))

    def _resolved(self, decl: PassDecl) -> PassDecl:
        try:
            named = {
                part: tuple(dict.fromkeys(self.resources.find(n, decl.scope) for n in getattr(decl, part)))
                for part in _NAMED
            }
            for part in _ORDER:
                found = (name for n in getattr(decl, part) for name in self.pass_names.find_all(n, decl.scope))
                named[part] = tuple(dict.fromkeys(found))
        except GraphError as error:
            raise GraphError(f"pass {decl.name!r}: {error}") from None
        return replace(decl, **named)

    def _resolved_imports(self) -> dict[str, ImportSpec]:
        """An import belongs to what all have in common who asked for it: a view's own only if all are in a view."""
        specs: dict[str, ImportSpec] = {}
        for base, known in self.imports.items():
            by_view = all(scope.view is not None for scope in known.scopes)
            by_planet = all(scope.planet is not None for scope in known.scopes)
            self.resources.drop(base)
            for scope, lent in known.scopes.items():
                owner = Scope(scope.view if by_view else None, scope.planet if by_planet else None)
                self.resources.add(base, owner)
                name = qualified(base, owner.view, owner.planet)
                specs.setdefault(name, ImportSpec(name, known.kind, known.help, lent))
        return specs
