"""The declared graph with names resolved: who creates, writes and reads what. Indices are declaration order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .declaration import PassDecl
from .errors import GraphError, did_you_mean
from .names import Names
from .resources import CreatedSpec, ImportSpec
from .sizes import Size
from .stages import STAGES


@dataclass(slots=True)
class GraphModel:
    """Resolved declaration; all names are qualified. `reads[i]` are this frame's inputs of pass i without those that it
    also writes; `after[i]` the declared predecessors; both with the absent optional ones left out. sizes: (w, h) of
    views that have their own; sized_by: resource -> view, for resources of those."""

    passes: tuple[PassDecl, ...]
    index: dict[str, int]
    imports: dict[str, ImportSpec]
    specs: dict[str, CreatedSpec]
    creator: dict[str, int]
    writers: dict[str, list[int]]
    readers: dict[str, list[int]]
    history_readers: dict[str, list[int]]
    reads: list[tuple[str, ...]]
    after: list[tuple[int, ...]]
    exports: tuple[str, ...]
    names: Names
    sizes: Mapping[int, Size]
    sized_by: dict[str, int]

    def name(self, index: int) -> str:
        """Name of a pass."""
        return self.passes[index].name

    def makers(self, resource: str) -> list[int]:
        """Creator (unless imported) and writers of a resource."""
        creator = self.creator.get(resource)
        return [*([] if creator is None else [creator]), *self.writers[resource]]


def build_model(
    passes: tuple[PassDecl, ...],
    imports: Mapping[str, ImportSpec],
    exports: tuple[str, ...],
    names: Names,
    sizes: Mapping[int, Size],
) -> GraphModel:
    """Resolve all names. Raises GraphError for unknown ones, misused history and writes that do not say their place."""
    specs = {spec.name: spec for decl in passes for spec in decl.creates}
    known = [*specs, *imports]
    model = GraphModel(
        passes=passes,
        index={decl.name: i for i, decl in enumerate(passes)},
        imports=dict(imports),
        specs=specs,
        creator={spec.name: i for i, decl in enumerate(passes) for spec in decl.creates},
        writers={name: [] for name in known},
        readers={name: [] for name in known},
        history_readers={name: [] for name in specs},
        reads=[],
        after=[],
        exports=exports,
        names=names,
        sizes=dict(sizes),
        sized_by=_sized_by(passes, sizes) if sizes else {},
    )
    for i, decl in enumerate(passes):
        _resolve(model, i, decl)
    for name in exports:
        if name not in model.writers:
            raise GraphError(f"export of {name!r}: no pass creates it and it is no import.{did_you_mean(name, known)}")
    if passes and not exports and not any(decl.side_effect for decl in passes):
        raise GraphError(
            "nothing is exported, so every pass would be culled; call builder.export(name) with the result that"
            " somebody looks at, or declare a pass with side_effect=True."
        )
    return model


def _sized_by(passes: tuple[PassDecl, ...], sizes: Mapping[int, Size]) -> dict[str, int]:
    views = [(decl.creates, decl.scope.view) for decl in passes]
    return {spec.name: view for specs, view in views if view is not None and view in sizes for spec in specs}


def _resolve(model: GraphModel, i: int, decl: PassDecl) -> None:
    where = f"pass {decl.name!r}"
    for name in decl.writes:
        if name not in model.writers:
            raise _unknown(model, where, "writes", name)
        if name in model.specs and not (decl.stage or decl.after or decl.after_optional):
            creator = model.name(model.creator[name])
            raise GraphError(
                f"{where} writes {name!r}, which pass {creator!r} creates, without saying when: add"
                f" after=({creator!r},) or the name of the writer that comes before, or give it a stage"
                f" (stage={STAGES[0]!r} and so on)."
            )
        model.writers[name].append(i)
    reads = [name for name in decl.reads if name not in decl.writes]
    for name in reads:
        if name not in model.readers:
            raise _unknown(model, where, "reads", name)
    reads += [n for n in decl.reads_optional if n in model.readers and n not in decl.writes and n not in reads]
    for name in reads:
        model.readers[name].append(i)
    model.reads.append(tuple(reads))

    for name in decl.history:
        spec = model.specs.get(name)
        if spec is None:
            if name in model.imports:
                raise GraphError(
                    f"{where} reads the history of {name!r}, which is an import: the graph keeps none of it."
                    " Copy it into a resource with lifetime='history' first."
                )
            raise _unknown(model, where, "reads the history of", name)
        if spec.lifetime != "history":
            raise GraphError(
                f"{where} reads the history of {name!r}, whose lifetime is {spec.lifetime!r}: give its spec in pass"
                f" {model.name(model.creator[name])!r} lifetime='history'."
            )
        model.history_readers[name].append(i)

    for name in decl.after:
        if name not in model.index:
            hint = did_you_mean(name, model.index)
            if name in model.writers:
                hint = " That is a resource; after= takes passes, reads= takes resources."
            raise GraphError(
                f"{where} is declared after {name!r}, but there is no such pass; for one that may be absent use"
                f" after_optional=.{hint}"
            )
    names = (*decl.after, *(n for n in decl.after_optional if n in model.index))
    model.after.append(tuple(model.index[n] for n in dict.fromkeys(names)))


def _unknown(model: GraphModel, where: str, verb: str, name: str) -> GraphError:
    if name in model.index:
        return GraphError(f"{where} {verb} {name!r}, which is a pass, not a resource; for order alone use after=.")
    hint = did_you_mean(name, model.writers)
    optional = " (or use reads_optional= if it may be absent)" if verb == "reads" else ""
    return GraphError(f"{where} {verb} {name!r}, but no pass creates it and it is no import{optional}.{hint}")
