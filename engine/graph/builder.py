"""Where systems declare their passes."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from .backend import GraphBackend
from .declaration import Bind, PassDecl, PassKind
from .errors import GraphError
from .resources import CreatedSpec, ImportKind, ImportSpec

if TYPE_CHECKING:
    from .analysis import Analysis
    from .plan import Plan


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
    """

    def __init__(self) -> None:
        self._passes: dict[str, PassDecl] = {}
        self._imports: dict[str, ImportSpec] = {}
        self._creators: dict[str, str] = {}
        self._exports: dict[str, None] = {}

    def import_(self, name: str, kind: ImportKind, help: str = "") -> ImportSpec:
        """Declare something that the graph does not own; the object is bound late with `Plan.bind_import`.

        Raises GraphError when the name is taken. Declaring the same import twice with one kind is fine: several
        systems may ask for it.
        """
        spec = ImportSpec(name, kind, help)
        known = self._imports.get(name)
        if known is not None and known.kind != kind:
            raise GraphError(f"import {name!r} was declared as a {known.kind} and now as a {kind}; use one kind.")
        if name in self._creators:
            raise GraphError(
                f"import {name!r} has the name of a resource that pass {self._creators[name]!r} creates; rename one."
            )
        return self._imports.setdefault(name, spec)

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
        when: Callable[[], object] | None = None,
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
            has to say its place among the other writers with after= (or after_optional=).
        after: passes that run earlier, whatever flows between them.
        history: resources with lifetime "history" whose content of the LAST frame is read.
        reads_optional, after_optional: as reads and after, but ignored when no such resource or pass is declared; for
            systems that may be absent. `io.has(name)` tells.
        when: () -> bool, each frame; False skips the pass and its persistent resources keep their content. A pass
            whose persistent resources are new (compile, resize) runs regardless, else their readers would see noise.
        side_effect: keep the pass although nobody reads what it makes.
        kind: "compute" for passes with storage writes: barriers are inserted behind them.

        Raises GraphError for what is wrong with this pass alone, a name that is taken, or a second creator.
        """
        decl = PassDecl(
            name=name,
            bind=bind,
            creates=_specs(name, creates),
            reads=_names(reads),
            reads_optional=_names(reads_optional),
            writes=_names(writes),
            after=_names(after),
            after_optional=_names(after_optional),
            history=_names(history),
            when=when,
            side_effect=bool(side_effect),
            kind=kind,
            system=system,
            help=help,
        )
        if name in self._passes:
            other = self._passes[name]
            raise GraphError(
                f"two passes are called {name!r} (systems {other.system!r} and {system!r}); rename one, or declare it"
                " once."
            )
        for spec in decl.creates:
            if spec.name in self._creators:
                raise GraphError(
                    f"pass {name!r} creates {spec.name!r}, but pass {self._creators[spec.name]!r} creates it already; a"
                    f" resource has one creator: put it into writes= with after=({self._creators[spec.name]!r},)."
                )
            if spec.name in self._imports:
                raise GraphError(f"pass {name!r} creates {spec.name!r}, which is an import; put it into writes=.")
        self._passes[name] = decl
        for spec in decl.creates:
            self._creators[spec.name] = name

    def export(self, name: str) -> None:
        """Name a result: a resource or import that somebody looks at after the frame. The walk back starts here."""
        if not isinstance(name, str):
            raise GraphError(f"export({name!r}): give the name of a resource.")
        self._exports[name] = None

    def analyse(self) -> Analysis:
        """Everything about the graph that needs no backend: order, culling, lifetimes, barriers, drawings."""
        from .analysis import analyse

        return analyse(tuple(self._passes.values()), self._imports, tuple(self._exports))

    def compile(self, backend: GraphBackend, size: tuple[int, int], previous: Plan | None = None) -> Plan:
        """Check, order and cull the passes, create what the survivors need, and bind them.

        size: (w, h) of the view in pixels. previous: a plan of the same backend that this one replaces: what has the
        same name, spec and size is taken over with its content (history stays valid), the rest is released, and
        `previous` cannot be used any more. When compile raises, nothing has been created and `previous` still works.
        """
        from .plan import Plan

        return Plan(backend, size, self.analyse(), previous)


def _names(value: Iterable[str]) -> tuple[str, ...]:
    # A bare string goes through unchanged so that the declaration's check can name it.
    if isinstance(value, str):
        return value  # pyright: ignore[reportReturnType]
    return tuple(dict.fromkeys(value))


def _specs(name: str, value: object) -> tuple[CreatedSpec, ...]:
    if isinstance(value, (tuple, list)):
        return tuple(value)
    raise GraphError(f"pass {name!r}: creates={value!r}; give a tuple of TextureSpec and BufferSpec: creates=(spec,).")
