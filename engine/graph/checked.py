"""A checked graph as data: what was found out about it, without its words and drawings."""

from __future__ import annotations

from dataclasses import dataclass

from .barriers import Barriers
from .culling import Culling
from .errors import GraphError, did_you_mean
from .lifetimes import Lifetimes
from .model import GraphModel
from .names import canonical
from .order import Order


@dataclass(slots=True)
class Checked:
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
