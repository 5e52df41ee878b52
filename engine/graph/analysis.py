"""Everything about a graph that needs no backend, in the order in which it is found out."""

from __future__ import annotations

from collections.abc import Mapping

from . import inspect
from .barriers import place_barriers
from .checked import Checked
from .culling import cull
from .declaration import PassDecl
from .lifetimes import find_lifetimes
from .model import build_model
from .names import Names
from .order import order_passes
from .resources import ImportSpec
from .sizes import Size
from .together import find_together


class Analysis(Checked):
    """A checked graph: names, running order, culling, lifetimes, barriers."""

    __slots__ = ()

    def explain(self, pass_name: str) -> str:
        """Why a pass runs or not, where, and what it touches; several lines."""
        return inspect.explain(self, pass_name)

    def to_barriers(self) -> str:
        """Every storage barrier in running order, and which accesses it keeps apart; several lines."""
        return inspect.barriers(self)

    def to_mermaid(self) -> str:
        """The graph as a mermaid flowchart: passes as boxes, resources on the arrows, culled passes dashed."""
        return inspect.to_mermaid(self)


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
