"""Views: those of one renderer; ViewParts: what holds GL objects for one."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, TypeVar

from .frame import View

if TYPE_CHECKING:
    from ..gpu import GpuScope

__all__ = ["ViewParts", "Views"]

T = TypeVar("T")


class ViewParts:
    """Base of what is kept for one view and holds GL objects: `gpu` is a scope of its own, counted under the owner of
    `of`, and goes with the view."""

    def __init__(self, of: GpuScope) -> None:
        self.gpu = of.part()

    def release(self) -> None:
        """Free its GL objects."""
        self.gpu.release()


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

    def release(self, view: View) -> None:
        """A view is no more."""
        self._views.pop(view.index, None)
        view.release()

    def forget(self, *owners: object) -> None:
        """Release what these owners keep for any view: they are no more."""
        for view in self:
            for owner in owners:
                view.forget(owner)
