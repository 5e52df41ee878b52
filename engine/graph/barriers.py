"""Where storage barriers go. OpenGL orders everything by itself except stores of shaders.

Tracked per physical object, because two transients in turn may share one. A barrier stands before a pass that
- touches an object into which a compute pass has stored since the last barrier of that kind, or
- is a compute pass that writes an object which another pass has touched since then: a store must not overtake an
  earlier access (OpenGL core specification, "Shader Memory Access Synchronization": stores behind a barrier wait for
  all accesses before it).
Frames follow one another, so the walk goes round until nothing is added: the end of a frame meets the next one's start.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from .backend import BarrierKind
from .culling import Culling
from .lifetimes import Import, Key, Lifetimes
from .model import GraphModel
from .resources import BufferSpec

_FRAMES = 4
"""Both parities twice: what the last frame of a parity left meets the next one of it."""


@dataclass(frozen=True, slots=True)
class Hazard:
    """Two accesses to one object that only a barrier orders. resource: by the name that the later pass has for it.
    earlier, later: places in running order; `later` is the number of passes for readers of exports. stored: whether
    the earlier one stored; else it only read, and the later one stores."""

    resource: str
    kind: int
    earlier: int
    later: int
    stored: bool


@dataclass(slots=True)
class Barriers:
    """before[place]: BarrierKind bits as an int, 0 for none; at_end: behind the last pass, for readers of exports;
    because[place]: the hazards that they close, one a resource (place = number of passes for the end)."""

    before: list[int]
    at_end: int
    because: dict[int, list[Hazard]]


class _Touch(NamedTuple):
    """An access to an object. number, kind: the object's, and the barrier's that it needs; named: of the resource."""

    name: str
    number: int
    kind: int
    named: int
    stores: bool


@dataclass(slots=True)
class _Access:
    compute: bool
    gated: bool
    touches: tuple[list[_Touch], list[_Touch]]
    """In frames of either parity."""


def place_barriers(
    model: GraphModel, culling: Culling, lifetimes: Lifetimes, together: frozenset[int] = frozenset()
) -> Barriers:
    """Barriers of one plan; equal for both parities. together: passes that may be skipped as a group."""
    passes = _accesses(model, culling, lifetimes, together)
    placed = [0] * len(passes)
    because: dict[int, list[Hazard]] = {}
    known: set[tuple[int, str]] = set()
    added = any(access.compute for access in passes)
    while added:
        added = False
        for hazard in _walk(passes, placed):
            named = hazard.later, hazard.resource
            if named not in known:
                known.add(named)
                because.setdefault(hazard.later, []).append(hazard)
                placed[hazard.later] |= hazard.kind  # seen by the walk, which goes on from here
                added = True
    return Barriers(placed[:-1], placed[-1], because)


def open_hazards(
    model: GraphModel,
    culling: Culling,
    lifetimes: Lifetimes,
    barriers: Barriers,
    together: frozenset[int] = frozenset(),
) -> list[Hazard]:
    """Hazards that these barriers leave open; none for those of place_barriers."""
    placed = [*barriers.before, barriers.at_end]
    passes = _accesses(model, culling, lifetimes, together)
    return [h for h in _walk(passes, placed) if not placed[h.later] & h.kind]


def _accesses(model: GraphModel, culling: Culling, lifetimes: Lifetimes, together: frozenset[int]) -> list[_Access]:
    """Of the passes that run, and at last of whoever reads the exports."""
    numbers: dict[Key, int] = {}
    objects: list[dict[str, tuple[int, int, int]]] = [{}, {}]

    def touch(name: str, parity: int, stores: bool) -> _Touch:
        known = objects[parity].get(name)
        if known is None:
            key = lifetimes.key(name, parity)
            number = numbers.setdefault(key, len(numbers))
            known = objects[parity][name] = number, _kind_of_key(model, lifetimes, key), _kind(model, name)
        return _Touch(name, known[0], known[1], known[2], stores)

    passes = []
    for i in culling.alive:
        decl = model.passes[i]
        written = [*(spec.name for spec in decl.creates), *decl.writes]
        compute, stored = decl.kind == "compute", set(written)
        even, odd = (
            [touch(name, parity, compute and name in stored) for name in (*model.reads[i], *written)]
            + [touch(name, 1 - parity, False) for name in decl.history]
            for parity in (0, 1)
        )
        passes.append(_Access(compute, decl.when is not None or i in together, (even, odd)))
    exported = [name for name in model.exports if name in lifetimes.span or name in model.imports]
    even, odd = ([touch(name, parity, False) for name in exported] for parity in (0, 1))
    return [*passes, _Access(False, False, (even, odd))]


def _walk(passes: list[_Access], placed: list[int]) -> Iterator[Hazard]:
    """Some frames, with what is placed: every hazard, closed or open. Of what is placed while it goes on, too."""
    kinds = [int(kind) for kind in BarrierKind]
    stored: dict[int, dict[int, int]] = {kind: {} for kind in kinds}
    """By kind of barrier: objects, and the last pass that stored into them. accessed: that touched them."""
    accessed: dict[int, dict[int, int]] = {kind: {} for kind in kinds}
    for frame in range(_FRAMES):
        for place, access in enumerate(passes):
            touches = access.touches[frame & 1]
            for name, number, kind, named, stores in touches:
                if (earlier := stored[kind].get(number)) is not None:
                    yield Hazard(name, named, earlier, place, True)
                elif stores and (earlier := accessed[kind].get(number)) is not None:
                    yield Hazard(name, named, earlier, place, False)
            if placed[place] and not access.gated:
                # One that may be skipped together with its pass promises nothing to those behind it.
                for kind in kinds:
                    if placed[place] & kind:
                        stored[kind].clear()
                        accessed[kind].clear()
            for _, number, kind, _, stores in touches:
                accessed[kind][number] = place
                if stores:
                    stored[kind][number] = place


def _kind(model: GraphModel, name: str) -> int:
    spec = model.specs.get(name)
    is_buffer = isinstance(spec, BufferSpec) or (spec is None and model.imports[name].kind == "buffer")
    return int(BarrierKind.BUFFER if is_buffer else BarrierKind.TEXTURE)


def _kind_of_key(model: GraphModel, lifetimes: Lifetimes, key: Key) -> int:
    if isinstance(key, Import):
        return _kind(model, key.name)
    return int(BarrierKind.BUFFER if isinstance(lifetimes.spec[key], BufferSpec) else BarrierKind.TEXTURE)
