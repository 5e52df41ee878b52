"""Where storage barriers go. OpenGL orders everything by itself except stores of shaders.

Tracked per physical object, because two transients in turn may share one. A barrier stands before a pass that
- touches an object into which a compute pass has stored since the last barrier of that kind, or
- is a compute pass that writes an object which another pass has touched since then: a store must not overtake an
  earlier access (OpenGL core specification, "Shader Memory Access Synchronization": stores behind a barrier wait for
  all accesses before it).
Frames follow one another, so the walk goes round until nothing is added: the end of a frame meets the next one's start.
"""

from __future__ import annotations

from dataclasses import dataclass

from .backend import BarrierKind
from .culling import Culling
from .lifetimes import Key, Lifetimes
from .model import GraphModel
from .resources import BufferSpec


@dataclass(slots=True)
class Barriers:
    """before[place]: BarrierKind bits as an int, 0 for none; at_end: behind the last pass, for readers of exports;
    because[place]: the resources that need it (place = number of passes for the end)."""

    before: list[int]
    at_end: int
    because: dict[int, list[str]]


@dataclass(slots=True)
class _Access:
    compute: bool
    gated: bool
    touched: list[str]
    written: set[str]


def place_barriers(
    model: GraphModel, culling: Culling, lifetimes: Lifetimes, together: frozenset[int] = frozenset()
) -> Barriers:
    """Barriers of one plan; equal for both parities. together: passes that may be skipped as a group."""
    passes: list[_Access] = []
    for i in culling.alive:
        decl = model.passes[i]
        written = [*(spec.name for spec in decl.creates), *decl.writes]
        gated = decl.when is not None or i in together
        passes.append(_Access(decl.kind == "compute", gated, [*model.reads[i], *written], set(written)))
    count = len(passes)
    placed = [0] * (count + 1)
    because: dict[int, list[str]] = {}
    passes.append(_Access(False, False, [n for n in model.exports if n in lifetimes.span or n in model.imports], set()))
    if not any(access.compute for access in passes):
        return Barriers(placed[:count], 0, because)

    history_of = [model.passes[i].history for i in culling.alive] + [()]
    added = True
    while added:
        added = False
        stored: set[Key] = set()
        accessed: set[Key] = set()
        for frame in range(4):
            for place, access in enumerate(passes):
                touches = [(name, lifetimes.key(name, frame & 1)) for name in access.touched]
                touches += [(name, lifetimes.key(name, 1 - frame & 1)) for name in history_of[place]]
                for name, key in touches:
                    hazard = key in stored or (access.compute and name in access.written and key in accessed)
                    kind = _kind(model, name)
                    if hazard and name not in because.setdefault(place, []):
                        because[place].append(name)
                        placed[place] |= kind
                        added = True
                if placed[place] and not access.gated:
                    # One that may be skipped together with its pass promises nothing to those behind it.
                    stored = {k for k in stored if not placed[place] & _kind_of_key(model, lifetimes, k)}
                    accessed = {k for k in accessed if not placed[place] & _kind_of_key(model, lifetimes, k)}
                for name, key in touches:
                    accessed.add(key)
                    if access.compute and name in access.written:
                        stored.add(key)
    because = {place: names for place, names in because.items() if names}
    return Barriers(placed[:count], placed[count], because)


def _kind(model: GraphModel, name: str) -> int:
    spec = model.specs.get(name)
    is_buffer = isinstance(spec, BufferSpec) or (spec is None and model.imports[name].kind == "buffer")
    return int(BarrierKind.BUFFER if is_buffer else BarrierKind.TEXTURE)


def _kind_of_key(model: GraphModel, lifetimes: Lifetimes, key: Key) -> int:
    if key[0] == "import":
        return _kind(model, str(key[1]))
    return int(BarrierKind.BUFFER if isinstance(lifetimes.spec[key], BufferSpec) else BarrierKind.TEXTURE)
