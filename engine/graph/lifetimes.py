"""How long each resource lives in a frame, and which transients share one object."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from .culling import Culling
from .model import GraphModel
from .resources import CreatedSpec, Kind


@dataclass(frozen=True, slots=True)
class Shared:
    """The physical object that some transients share in turn."""

    number: int


@dataclass(frozen=True, slots=True)
class Own:
    """That of a persistent resource."""

    name: str


@dataclass(frozen=True, slots=True)
class History:
    """One of the two of a resource with a history, which change places every frame."""

    name: str
    parity: int


@dataclass(frozen=True, slots=True)
class Import:
    """What is lent from outside."""

    name: str


Key = Shared | Own | History | Import
"""Names a physical object. No named tuples: those of two kinds would be equal."""


class PoolKey(NamedTuple):
    """Which transients may share an object. view: whose size they follow, of those that are resized alone."""

    kind: Kind
    view: int | None


@dataclass(slots=True)
class Lifetimes:
    """span[name]: (first, last) place in the running order, last = number of passes when it must outlive the frame;
    spec[key]: what to create; shared[n]: the names that live in the shared object n, in turn."""

    span: dict[str, tuple[int, int]]
    spec: dict[Key, CreatedSpec]
    shared: list[list[str]]
    _shared_of: dict[str, int]
    _specs: dict[str, CreatedSpec]

    def key(self, name: str, parity: int) -> Key:
        """The physical object of a resource or import in frames of this parity."""
        spec = self._specs.get(name)
        if spec is None:
            return Import(name)
        if spec.lifetime == "history":
            return History(name, parity)
        if spec.lifetime == "persistent":
            return Own(name)
        return Shared(self._shared_of[name])


def find_lifetimes(model: GraphModel, culling: Culling) -> Lifetimes:
    """Spans over the passes that run; first fit over equal specs with disjoint spans, in order of birth."""
    count = len(culling.alive)
    span: dict[str, tuple[int, int]] = {}
    for place, i in enumerate(culling.alive):
        decl = model.passes[i]
        for spec in decl.creates:
            span[spec.name] = (place, place)
        for name in (*model.reads[i], *decl.writes):
            if name in span:
                span[name] = (span[name][0], place)
    for name in model.exports:
        if name in span:
            # Read after the frame by whoever asked for it: nothing may move into its memory.
            span[name] = (span[name][0], count)

    specs: dict[Key, CreatedSpec] = {}
    shared: list[list[str]] = []
    shared_of: dict[str, int] = {}
    free_from: list[int] = []
    pool: dict[PoolKey, list[int]] = {}
    for name, (first, last) in span.items():
        spec = model.specs[name]
        if spec.lifetime == "persistent":
            specs[Own(name)] = spec
        elif spec.lifetime == "history":
            specs[History(name, 0)] = specs[History(name, 1)] = spec
        else:
            # A view may be resized: what follows its size shares with that view's alone.
            view = model.sized_by.get(name) if spec.relative else None
            candidates = pool.setdefault(PoolKey(spec.pool_key(), view), [])
            # Strictly later: a pass never gets one object for what it reads and for what it creates.
            slot = next((s for s in candidates if free_from[s] < first), None)
            if slot is None:
                slot = len(shared)
                shared.append([])
                free_from.append(last)
                candidates.append(slot)
                specs[Shared(slot)] = spec
            shared[slot].append(name)
            shared_of[name] = slot
            free_from[slot] = last
    return Lifetimes(span, specs, shared, shared_of, model.specs)
