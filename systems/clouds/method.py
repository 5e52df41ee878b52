"""CloudMethod: how clouds get into the picture, and what shader contracts read of them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import ClassVar

from ...engine.frame import View
from ...engine.gpu import GpuScope
from ...engine.graph import PassIO
from ...engine.methods import Method
from ...engine.system import Setup

__all__ = ["CloudMethod"]


class CloudMethod(Method):
    """One of Clouds.method."""

    reads: ClassVar[tuple[str, ...]] = ()
    """Resources of the graph that its contracts sample."""
    moving: bool | None = None
    """See System.moving."""
    good = True
    """Whether the component says what can be; the system says so before each `update`. Else clouds stay as before."""

    def __init__(self, gpu: GpuScope, setup: Setup) -> None:
        super().__init__(gpu)
        self.world = setup.world

    @abstractmethod
    def bind_contract(self, io: PassIO) -> Callable[[], None]:
        """See engine.frame.contracts.ContractSource."""

    @abstractmethod
    def seen_in(self, view: View) -> bool:
        """Whether that view may show any cloud: else none of the picture's passes is in its graph."""
