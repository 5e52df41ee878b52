"""Which passes are needed: the walk back from what is exported."""

from __future__ import annotations

from dataclasses import dataclass

from .model import GraphModel
from .order import Order


@dataclass(slots=True)
class Culling:
    """alive: the passes that run, in running order; why_alive and why_culled: one line for each pass index."""

    alive: list[int]
    why_alive: dict[int, str]
    why_culled: dict[int, str]


def cull(model: GraphModel, order: Order) -> Culling:
    """Walk back from exports and side effects. A reader needs the creator of what it reads and those writers that run
    before it; a reader of history needs all of them."""
    why: dict[int, str] = {}
    work: list[int] = []

    def need(makers: list[int], reason: str) -> None:
        for i in makers:
            if i not in why:
                why[i] = reason
                work.append(i)

    for i, decl in enumerate(model.passes):
        if decl.side_effect:
            need([i], "it has a side effect")
    for name in model.exports:
        need(model.makers(name), f"{name!r} is exported")
    while work:
        i = work.pop()
        decl = model.passes[i]
        for name in model.reads[i]:
            need(order.seen[i, name], f"pass {decl.name!r} reads {name!r}")
        for name in decl.writes:
            need(order.seen[i, name], f"pass {decl.name!r} modifies {name!r}")
        for name in decl.history:
            need(model.makers(name), f"pass {decl.name!r} reads the history of {name!r}")

    alive = [i for i in order.sequence if i in why]
    culled = {i: _why_culled(model, order, i) for i in order.sequence if i not in why}
    return Culling(alive, why, culled)


def _why_culled(model: GraphModel, order: Order, i: int) -> str:
    decl = model.passes[i]
    outputs = [*(spec.name for spec in decl.creates), *decl.writes]
    if not outputs:
        return "it creates and writes nothing; declare side_effect=True if it must run anyway"
    reasons = []
    for name in outputs:
        users = [
            *model.readers[name],
            *(w for w in model.writers[name] if w != i),
            *model.history_readers.get(name, ()),
        ]
        later = [u for u in users if order.position[u] > order.position[i] or u in model.history_readers.get(name, ())]
        if later:
            names = ", ".join(repr(model.name(u)) for u in dict.fromkeys(later))
            reasons.append(f"what uses {name!r} is culled as well ({names})")
        elif users:
            reasons.append(f"nobody reads {name!r} behind it")
        else:
            reasons.append(f"nobody reads {name!r}")
    return "; ".join(reasons)
