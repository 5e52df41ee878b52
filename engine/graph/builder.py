"""Where systems declare their passes."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable
from dataclasses import replace
from enum import Enum
from typing import TYPE_CHECKING, Final

from .backend import GraphBackend
from .declaration import Bind, PassDecl, PassKind
from .declared import Declared
from .errors import GraphError
from .names import MARK, Scope, qualified
from .resources import BufferSpec, CreatedSpec, ImportKind, ImportSpec, TextureSpec
from .sizes import Size, checked_size

if TYPE_CHECKING:
    from .analysis import Analysis
    from .plan import Plan


class _Same(Enum):
    SAME = 0


SAME: Final = _Same.SAME
"""As in the scope that this one is made from."""


class GraphBuilder:
    """Collects passes, imports and exports; `compile` turns them into a `Plan`.

        builder = GraphBuilder()
        builder.import_("target", kind="framebuffer")
        builder.add_pass("clear", bind=bind_clear, creates=(TextureSpec("color", "rgba8"),))
        builder.add_pass("show", bind=bind_show, reads=("color",), writes=("target",))
        builder.export("target")
        plan = builder.compile(backend, size=(1280, 720))

    Passes may be declared in any order; names are resolved at compile. Errors of one pass alone are raised by
    `add_pass`, errors between passes by `compile`. docs/frame-graph.md has the rules.

    `scope` gives a builder for one view or planet: what is declared there is that view's (planet's) own, under the
    same names as everybody uses.
    """

    def __init__(self) -> None:
        self._declared = Declared()
        self._scope = Scope()
        self._origin = Scope()

    def scope(
        self,
        *,
        view: int | _Same | None = SAME,
        planet: int | _Same | None = SAME,
        home: int | _Same = SAME,
        size: Size | None = None,
    ) -> GraphBuilder:
        """A builder of the same graph whose passes, resources and imports belong to a view, a planet, or both.

            of_view = builder.scope(view=1, size=(320, 180))
            of_planet = of_view.scope(planet=2)
            shared = of_planet.scope(view=None)     # planet 2's, for all views

        view, planet: indices from 0; None: shared by all of them; what isn't given stays as in this scope. Names
        without an index mean this scope's: its view's, its planet's, or the shared one, however that name is owned.
        home: the planet meant in a scope without one. size: (w, h) in pixels of a view that doesn't have the plan's
        size. A pass that is shared by views may be declared once from each of them: the first one counts.

        Raises GraphError for an index that is none, or a second size of a view.
        """
        old = self._scope
        new = Scope(
            old.view if isinstance(view, _Same) else _index("view", view, optional=True),
            old.planet if isinstance(planet, _Same) else _index("planet", planet, optional=True),
            old.home if isinstance(home, _Same) else _index("home", home) or 0,
        )
        if size is not None:
            if new.view is None:
                raise GraphError(f"scope(size={size!r}) without a view: what views share follows the plan's size.")
            size = checked_size(size, f"scope(view={new.view}): size")
            if self._declared.sizes.setdefault(new.view, size) != size:
                raise GraphError(
                    f"scope(view={new.view}): size={size!r}, but that view has {self._declared.sizes[new.view]}"
                    " already; a view has one size."
                )
        made = copy.copy(self)
        made._scope = new
        made._origin = Scope(
            self._origin.view if new.view is None else new.view,
            self._origin.planet if new.planet is None else new.planet,
            new.home,
        )
        self._declared.indexed |= bool(new.view or new.planet or new.home)
        return made

    def import_(self, name: str, kind: ImportKind, help: str = "", lent: object = None) -> ImportSpec:
        """Declare something that the graph does not own; the object is bound late with `Plan.bind_import`, or is there
        from the start: lent by the system that owns it, such as a view's uniform block.

        Raises GraphError when the name is taken. Declaring the same import twice with one kind is fine: several
        systems may ask for it. It is a view's (planet's) own if all who ask are in a view (planet), else shared.
        """
        return self._declared.add_import(name, kind, help, lent, self._scope)

    def add_pass(
        self,
        name: str,
        *,
        bind: Bind,
        creates: Iterable[CreatedSpec] = (),
        reads: Iterable[str] = (),
        writes: Iterable[str] = (),
        after: Iterable[str] = (),
        history: Iterable[str] = (),
        reads_optional: Iterable[str] = (),
        after_optional: Iterable[str] = (),
        stage: str = "",
        when: Callable[[], object] | None = None,
        only_while: Callable[[], object] | None = None,
        side_effect: bool = False,
        kind: PassKind = "raster",
        system: str = "",
        help: str = "",
    ) -> None:
        """Declare a pass.

        bind: (io: PassIO) -> run. All look-ups happen in bind; run() is called each frame and must not allocate.
            Called at compile and after a resize, twice (once per parity) when the pass touches a history resource.
        creates: specs of the resources that this pass makes and fills; it writes every texel that it claims.
        reads: resources of other passes. Runs after all their writers, except those that are declared after this pass.
        writes: resources of other passes (or imports) that this pass modifies, which implies that it reads them. It
            has to say its place among the other writers: with stage=, or with after= (or after_optional=).
        stage: one of STAGES, the place of this pass among the writers of what it writes: behind those of earlier
            stages. Within a stage after= says which comes first.
        after: passes that run earlier, whatever flows between them.
        history: resources with lifetime "history" whose content of the LAST frame is read.
        reads_optional, after_optional: as reads and after, but ignored when no such resource or pass is declared; for
            systems that may be absent. `io.has(name)` tells.
        when: () -> bool, each frame; False skips the pass and its persistent resources keep their content. A pass
            whose persistent resources are new (compile, resize) runs regardless, else their readers would see noise.
        only_while: () -> bool, each frame, shared by a group of passes that are skipped together: what one of them
            makes for a frame may be read within the group alone. A pass that others read as well runs always. `when`
            is not asked while the group is skipped.
        side_effect: keep the pass although nobody reads what it makes.
        kind: "compute" for passes with storage writes: barriers are inserted behind them.

        Raises GraphError for what is wrong with this pass alone, a name that is taken, or a second creator.
        """
        scope = self._scope
        specs = _specs(name, creates)
        decl = PassDecl(
            name=qualified(name, scope.view, scope.planet) if isinstance(name, str) else name,
            bind=bind,
            creates=tuple(_owned(spec, scope) for spec in specs) if scope.view or scope.planet else specs,
            reads=_names(reads),
            reads_optional=_names(reads_optional),
            writes=_names(writes),
            after=_names(after),
            after_optional=_names(after_optional),
            stage=stage,
            history=_names(history),
            when=when,
            only_while=only_while,
            side_effect=bool(side_effect),
            kind=kind,
            system=system,
            help=help,
            scope=scope,
        )
        self._declared.add_pass(decl, name, [spec.name for spec in specs], self._origin)

    def export(self, name: str) -> None:
        """Name a result: a resource or import that somebody looks at after the frame. The walk back starts here.

        Outside of scopes, what the name doesn't say is index 0: "x" is also view 0's "x", view 1's is "x@view1".
        """
        if not isinstance(name, str):
            raise GraphError(f"export({name!r}): give the name of a resource.")
        inside = self._scope.view is not None or self._scope.planet is not None
        self._declared.indexed |= MARK in name
        self._declared.exports[name, self._scope if inside else None] = None

    def analyse(self) -> Analysis:
        """Everything about the graph that needs no backend: order, culling, lifetimes, barriers, drawings."""
        from .analysis import analyse

        passes, imports, exports = self._declared.resolved()
        return analyse(passes, imports, exports, self._declared.resources, self._declared.sizes)

    def compile(self, backend: GraphBackend, size: tuple[int, int], previous: Plan | None = None) -> Plan:
        """Check, order and cull the passes, create what the survivors need, and bind them.

        size: (w, h) in pixels of the view, or of all views without a size of their own. previous: a plan of the same
        backend that this one replaces: what has the same name, spec and size is taken over with its content (history
        stays valid), the rest is released, and `previous` cannot be used any more. When compile raises, nothing has
        been created and `previous` still works.
        """
        from .plan import Plan

        return Plan(backend, size, self.analyse(), previous)


def _index(what: str, value: object, optional: bool = False) -> int | None:
    if value is None and optional:
        return None
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        more = ", or None for what all share" if optional else ""
        raise GraphError(f"scope({what}={value!r}): give an index, 0 or above{more}.")
    return value


def _owned(spec: CreatedSpec, scope: Scope) -> CreatedSpec:
    if not isinstance(spec, (TextureSpec, BufferSpec)):
        return spec  # the declaration's check names it
    return replace(spec, name=qualified(spec.name, scope.view, scope.planet))


def _names(value: Iterable[str]) -> tuple[str, ...]:
    # A bare string goes through unchanged so that the declaration's check can name it.
    if isinstance(value, str):
        return value  # pyright: ignore[reportReturnType]
    return tuple(dict.fromkeys(value))


def _specs(name: str, value: object) -> tuple[CreatedSpec, ...]:
    if isinstance(value, (tuple, list)):
        return tuple(value)
    raise GraphError(f"pass {name!r}: creates={value!r}; give a tuple of TextureSpec and BufferSpec: creates=(spec,).")
