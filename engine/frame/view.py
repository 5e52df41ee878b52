"""View: one picture of a scene, and the owner of what systems keep for it from frame to frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING, Any, Protocol, TypeVar, runtime_checkable

from ..world import MissingError
from .proxy import Proxy
from .seen import Seen
from .snapping import SnapAhead

if TYPE_CHECKING:
    from ..gpu import GpuScope

__all__ = ["View", "ViewParts", "Views"]

T = TypeVar("T")


@runtime_checkable
class _Releasable(Protocol):
    def release(self) -> None: ...


class ViewParts:
    """Base of what is kept for one view and holds GL objects: `gpu` is a scope of its own, counted under the owner of
    `of`, and goes with the view."""

    def __init__(self, of: GpuScope) -> None:
        self.gpu = of.part()

    def release(self) -> None:
        """Free its GL objects."""
        self.gpu.release()


class View:
    """One picture of a scene. index: 0 is the renderer's own, further ones take the lowest that is free.

    seen, snap and proxy are what all systems know of it. What is one system's own it keeps with `state`; it is released
    with the view, or when the system says `forget`.
    """

    def __init__(self, index: int = 0) -> None:
        self.index = index
        self._kept: dict[int, tuple[object, Any]] = {}
        self._begin()

    def _begin(self) -> None:
        self.seen = Seen()
        """What it may show of its planet."""
        self.snap = SnapAhead()
        """The next snap of its proxy."""
        self.placed: Proxy | None = None
        """Its camera's proxy, or None before the first frame."""
        self.planets_px: tuple[int, int, int, int] | None = None
        """Where its picture shows other planets in this frame: (x, y, width, height); None: nowhere."""

    @property
    def proxy(self) -> Proxy:
        """Its camera's proxy; MissingError before the first frame."""
        if self.placed is None:
            raise MissingError(f"view {self.index} has no proxy yet: ProxySystem places it in the view's first frame")
        return self.placed

    def state(self, owner: object, factory: Callable[[], T]) -> T:
        """What `owner` keeps for this view; made by `factory` when it is asked for first. One state an owner."""
        found = self._kept.get(id(owner))
        if found is None:
            found = self._kept[id(owner)] = (owner, factory())  # the owner is held, so that its id stays its own
        return found[1]

    def found(self, owner: object) -> object:
        """What `owner` keeps for this view, or None."""
        found = self._kept.get(id(owner))
        return None if found is None else found[1]

    def forget(self, owner: object) -> None:
        """Release what that owner keeps."""
        _release(self._kept.pop(id(owner), None))

    def release(self) -> None:
        """Release what everybody keeps; the view may be used again, and is then as new."""
        while self._kept:
            _release(self._kept.popitem()[1])
        self._begin()

    def __repr__(self) -> str:
        return f"<View {self.index}>"


def _release(kept: tuple[object, object] | None) -> None:
    if kept is not None and isinstance(kept[1], _Releasable):
        kept[1].release()


class Views:
    """The views of one renderer: systems that keep something for each find all of it here."""

    def __init__(self) -> None:
        self._views: dict[int, View] = {}

    def __getitem__(self, index: int) -> View:
        """The view of that index; made when it is asked for first."""
        view = self._views.get(index)
        if view is None:
            view = self._views[index] = View(index)
        return view

    def add(self, view: View) -> None:
        """A view that somebody else made, in place of one of its index."""
        self._views[view.index] = view

    def __iter__(self) -> Iterator[View]:
        return iter(list(self._views.values()))

    def states(self, owner: object, kind: type[T]) -> list[T]:
        """What `owner` keeps, of all views that it keeps something for."""
        return [found for view in self for found in (view.found(owner),) if isinstance(found, kind)]

    def found(self, index: int, owner: object, kind: type[T]) -> T | None:
        """What `owner` keeps for the view of that index, or None."""
        view = self._views.get(index)
        found = None if view is None else view.found(owner)
        return found if isinstance(found, kind) else None

    def release(self, index: int) -> None:
        """A view is no more."""
        view = self._views.pop(index, None)
        if view is not None:
            view.release()

    def forget(self, *owners: object) -> None:
        """Release what these owners keep for any view: they are no more."""
        for view in self:
            for owner in owners:
                view.forget(owner)
