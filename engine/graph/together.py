"""Which passes of a group are skipped together: those whose results nobody outside of the group can see."""

from __future__ import annotations

from .culling import Culling
from .model import GraphModel

__all__ = ["find_together"]


def find_together(model: GraphModel, culling: Culling) -> frozenset[int]:
    """The passes whose only_while() is asked.

    What a skipped pass makes for one frame is undefined, so all who read it have to be skipped with it: to have an
    equal only_while. One that has a reader of another kind (a debug view, an export, last frame's content) runs always,
    and so does then what it reads.
    """
    users: dict[str, set[int]] = {}
    for i in culling.alive:
        decl = model.passes[i]
        for name in (*model.reads[i], *decl.writes, *decl.history):
            users.setdefault(name, set()).add(i)
    together = {i for i in culling.alive if model.passes[i].only_while is not None}
    changed = True
    while changed:
        changed = False
        for i in sorted(together):
            decl = model.passes[i]
            for spec in decl.creates:
                if spec.lifetime == "persistent":
                    continue
                seen_by = users.get(spec.name, set()) - {i}
                inside = all(j in together and model.passes[j].only_while == decl.only_while for j in seen_by)
                if spec.name in model.exports or spec.lifetime == "history" or not inside:
                    together.discard(i)
                    changed = True
                    break
    return frozenset(together)
