"""What passes declare against what they do: for authors, where a backend watches them (PLANETFALL_VALIDATE=1)."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from .analysis import Analysis
from .binding import Step
from .declaration import PassDecl, Run
from .errors import GraphError
from .storage import Storage
from .touches import Identity, PassWatch, Touch

__all__ = ["Watching", "unused"]


class Watching:
    """One plan's: `steps` wraps what passes run."""

    def __init__(self, watch: PassWatch, analysis: Analysis) -> None:
        self._watch, self._analysis = watch, analysis
        self._seen: dict[str, dict[str, set[str]]] = {}
        self._holds: dict[Identity, set[str]] = {}
        self._objects: dict[tuple[str, int], Identity | None] = {}
        self._slots: Mapping[str, Any] = {}
        self._ran: set[str] = set()

    def install(self, storage: Storage, slots: Mapping[str, Any]) -> None:
        """The plan's objects are these from now on. slots: of the imports, by name."""
        self._slots, lifetimes = slots, self._analysis.lifetimes
        self._objects = {
            (name, parity): self._watch.identity(storage.objects[lifetimes.key(name, parity)])
            for name in lifetimes.span
            for parity in (0, 1)
        }
        self._holds = {}
        for (name, _), held in self._objects.items():
            if held is not None:
                self._holds.setdefault(held, set()).add(name)

    def steps(self, steps: tuple[list[Step], list[Step]]) -> tuple[list[Step], list[Step]]:
        """The same steps, watched: GraphError in the pass that touches what it has not declared."""
        decls = [self._analysis.model.passes[i] for i in self._analysis.culling.alive]
        even, odd = (
            [
                (self._step(decl, parity, run), gate, barrier)
                for decl, (run, gate, barrier) in zip(decls, half, strict=True)
            ]
            for parity, half in enumerate(steps)
        )
        return even, odd

    def _step(self, decl: PassDecl, parity: int, run: Run) -> Run:
        def watched() -> None:
            self._watch.begin()
            try:
                run()
            finally:
                touches = self._watch.end()
            self._ran.add(decl.name)
            self._check(decl, parity, touches)

        return watched

    def _check(self, decl: PassDecl, parity: int, touches: Iterable[Touch]) -> None:
        created = [spec.name for spec in decl.creates]
        reads = self._identities((*decl.reads, *decl.reads_optional), parity)
        writes = self._identities((*created, *decl.writes), parity)
        past = self._identities(decl.history, 1 - parity)
        seen = self._seen.setdefault(decl.name, defaultdict(set))
        imports = self._identities(self._analysis.model.imports, parity)
        for touch in touches:
            held = self._holds.get(touch.object) or imports.get(touch.object)
            written, read = writes.get(touch.object, set()), reads.get(touch.object, set())
            before = past.get(touch.object, set())
            if held and touch.writes and not written:
                raise self._undeclared(decl, "writes", held, touch, "writes=")
            if held and not (written or read or before):
                raise self._undeclared(decl, "reads", held, touch, "reads=")
            if touch.unordered_after:
                raise self._unordered(decl, touch)
            for name in written | read | before:
                seen[name] |= ({"reads"} if touch.reads else set()) | ({"writes"} if touch.writes else set())

    def declared(self) -> Iterator[tuple[str, str, str]]:
        """(pass, "reads" or "writes", resource) of those that have run."""
        known = {*self._analysis.lifetimes.span, *self._slots}
        for decl in self._analysis.model.passes:
            if decl.name in self._ran:
                yield from ((decl.name, "reads", name) for name in (*decl.reads, *decl.history) if name in known)
                writes = (*(spec.name for spec in decl.creates), *decl.writes)
                yield from ((decl.name, "writes", name) for name in writes if name in known)

    def touched(self) -> Iterator[tuple[str, str, str]]:
        """The same of what they really did."""
        for pass_name, resources in self._seen.items():
            for resource, kinds in resources.items():
                yield from ((pass_name, kind, resource) for kind in kinds)

    def _identities(self, names: Iterable[str], parity: int) -> dict[Identity, set[str]]:
        found: dict[Identity, set[str]] = {}
        for name in names:
            held = self._objects.get((name, parity))
            if held is None and name in self._slots:
                held = self._watch.identity(self._slots[name].value)
            if held is not None:
                found.setdefault(held, set()).add(name)
        return found

    def _unordered(self, decl: PassDecl, touch: Touch) -> GraphError:
        return GraphError(
            f"pass {decl.name!r} (system {decl.system!r}) touches an object ({touch.how}) to which "
            f"{touch.unordered_after} has stored with no barrier since; declare the write and the read to the graph, "
            "or call Gpu.barrier() between two commands of one pass."
        )

    def _undeclared(self, decl: PassDecl, does: str, held: set[str], touch: Touch, part: str) -> GraphError:
        names = " or ".join(repr(name) for name in sorted(held))
        return GraphError(
            f"pass {decl.name!r} (system {decl.system!r}) {does} {names} ({touch.how}) and has not declared it; "
            f"add it to {part}, or bind something else there."
        )


def unused(plans: Iterable[Watching]) -> list[str]:
    """What passes that ran have declared in some of these plans and touched in none, a sentence each. Frames of many
    kinds have to be seen first: what a pass does may hang on the view."""
    reads: set[tuple[str, str]] = set()
    writes: set[tuple[str, str]] = set()
    read: set[tuple[str, str]] = set()
    written: set[tuple[str, str]] = set()
    for plan in plans:
        for name, kind, resource in plan.declared():
            (reads if kind == "reads" else writes).add((name, resource))
        for name, kind, resource in plan.touched():
            (read if kind == "reads" else written).add((name, resource))
    found = [f"pass {name!r} declares that it reads {resource!r} and never does" for name, resource in reads - read]
    found += [
        f"pass {name!r} declares that it writes {resource!r} and never does" for name, resource in writes - written
    ]
    return sorted(found)
