"""Method: an interchangeable implementation of a system (a strategy), such as "ours" and "paper"; Methods: the one in
use.

A system asks in `setup`, and wherever a component may have changed, for the method that is wanted (`Methods.use`), and
hands its own calls on to it (`Methods.now`), under the same names.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from typing import ClassVar, Generic, TypeVar

from .frame import Frame, View, ViewInfo, Views
from .gpu import GpuScope
from .graph import GraphBuilder

__all__ = ["Method", "Methods"]


class Method(ABC):
    """Its calls are those of a System; what it keeps for views goes with it. gpu: a scope of its own."""

    contracts: ClassVar[Mapping[str, str]] = {}
    """Shader contracts that it provides, by name: files."""
    structure: int = 0
    """Raised when passes or sizes change."""

    def __init__(self, gpu: GpuScope) -> None:
        self.gpu = gpu

    @abstractmethod
    def update(self, frame: Frame) -> None:
        """See System.update."""

    @abstractmethod
    def declare(self, builder: GraphBuilder, view: ViewInfo) -> None:
        """See System.declare."""

    def settled(self, view: View) -> bool:
        """See System.settled."""
        return True

    def progress(self, view: View) -> float:
        """See System.progress."""
        return 1.0 if self.settled(view) else 0.0

    def refining(self, view: View) -> str:
        """See System.refining."""
        return ""

    def statistics(self) -> dict[str, int]:
        """See System.statistics."""
        return {}

    def release(self) -> None:
        """Free all GL objects."""
        self.gpu.release()


M = TypeVar("M", bound=Method)


class Methods(Generic[M]):
    """The method of one system. gpu: the system's scope, whose owner counts for its methods' objects."""

    def __init__(self, gpu: GpuScope, views: Views) -> None:
        self._gpu, self._views = gpu, views
        self._owner = f"{gpu.owner} method"
        self._now: M | None = None
        self._key: Hashable = None
        self._seen: Hashable = None

    @property
    def now(self) -> M:
        """The one that is used."""
        assert self._now is not None, "a system asks for a method when it is set up"
        return self._now

    def changed(self) -> bool:
        """Whether passes or sizes may be others than when this was asked last."""
        seen, self._seen = self._seen, (self._key, self.now.structure)
        return seen != self._seen

    def use(self, kind: type[M], make: Callable[[GpuScope], M], key: Hashable = None) -> bool:
        """A method of that kind from now on, made by `make` where it is another than before; key: what else makes it
        another. Whether it is. What raises leaves the one from before."""
        if (kind, key) == self._key:
            return False
        before, scope = self._now, self._gpu.beside(self._gpu.owner)
        # First: its shaders are compiled with its own contracts.
        self._provide(kind.contracts)
        try:
            made = make(scope)
        except BaseException:
            scope.release()
            self._provide({} if before is None else before.contracts)
            raise
        if before is not None:
            self._end(before)
        self._now, self._key = made, (kind, key)
        return True

    def _provide(self, contracts: Mapping[str, str]) -> None:
        shaders = self._gpu.shaders
        shaders.withdraw(self._owner)
        for contract, file in contracts.items():
            shaders.provide(contract, file, owner=self._owner)

    def _end(self, method: M) -> None:
        self._views.forget(method)
        method.release()

    def release(self) -> None:
        """Let go of the one that is used."""
        if self._now is not None:
            self._provide({})
            self._end(self._now)
        self._now = self._key = None
