"""Everything about a graph that needs no backend, in the order in which it is found out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from .barriers import Barriers, place_barriers
from .culling import Culling, cull
from .declaration import PassDecl
from .errors import GraphError, did_you_mean
from .lifetimes import Lifetimes, find_lifetimes
from .model import GraphModel, build_model
from .names import Names, canonical
from .order import Order, order_passes
from .resources import ImportSpec
from .sizes import Size
from .together import find_together


@dataclass(slots=True)
class Analysis:
    """A checked graph: names, running order, culling, lifetimes, barriers."""

    model: GraphModel
    order: Order
    culling: Culling
    lifetimes: Lifetimes
    barriers: Barriers
    together: frozenset[int]
    """Passes whose only_while is asked; see together.py."""

    @property
    def alive(self) -> list[str]:
        """Names of the passes that run, in running order."""
        return [self.model.name(i) for i in self.culling.alive]

    @property
    def culled(self) -> dict[str, str]:
        """Culled passes and why."""
        return {self.model.name(i): why for i, why in self.culling.why_culled.items()}

    def find(self, pass_name: str) -> int:
        """Index of a pass. Raises GraphError for an unknown one."""
        found = self.model.index.get(canonical(pass_name))
        if found is None:
            raise GraphError(f"there is no pass {pass_name!r}.{did_you_mean(pass_name, self.model.index)}")
        return found

    def explain(self, pass_name: str) -> str:
        """Why a pass runs or not, where, and what it touches; several lines."""
        from .inspect import explain

        return explain(self, pass_name)

    def to_mermaid(self) -> str:
        """The graph as a mermaid flowchart: passes as boxes, resources on the arrows, culled passes dashed."""
        from .inspect import to_mermaid

        return to_mermaid(self)


def analyse(
    passes: tuple[PassDecl, ...],
    imports: Mapping[str, ImportSpec],
    exports: tuple[str, ...],
    names: Names,
    sizes: Mapping[int, Size],
) -> Analysis:
    """Check and analyse a declared graph. names: already resolved; sizes: of views that have their own.

    Raises GraphError.
    """
    model = build_model(passes, imports, exports, names, sizes)
    order = order_passes(model)
    culling = cull(model, order)
    lifetimes = find_lifetimes(model, culling)
    together = find_together(model, culling)
    barriers = place_barriers(model, culling, lifetimes, together)
    return Analysis(model, order, culling, lifetimes, barriers, together)
