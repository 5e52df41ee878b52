"""How large each view of a graph is, and with it every texture whose size follows a view."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from dataclasses import dataclass, replace

from .errors import GraphError
from .resources import CreatedSpec

Size = tuple[int, int]


@dataclass(frozen=True, slots=True)
class ViewSizes:
    """plan: (w, h) of all views without a size of their own; own: view -> (w, h); view_of: resource -> view, for those
    of views with a size of their own."""

    plan: Size
    own: Mapping[int, Size]
    view_of: Mapping[str, int]

    def of_view(self, view: int | None) -> Size:
        """(w, h) of a view in pixels; None: of what no view owns."""
        return self.plan if view is None else self.own.get(view, self.plan)

    def of(self, name: str) -> Size:
        """(w, h) of the view that a resource belongs to."""
        view = self.view_of.get(name)
        return self.plan if view is None else self.own[view]

    def resolve(self, spec: CreatedSpec) -> tuple[int, ...]:
        """Texels (w, h) or (w, h, d) of a texture, (bytes,) of a buffer."""
        return spec.resolve(self.of(spec.name) if self.view_of else self.plan)

    def changed(self, size: Size, view: int | None) -> ViewSizes:
        """With another size of one view, or of all that have none of their own."""
        return replace(self, plan=size) if view is None else replace(self, own={**self.own, view: size})


def checked_size(size: object, what: str = "size") -> Size:
    """(w, h) as ints. Raises GraphError for anything that isn't two whole numbers of pixels >= 1."""
    try:
        w, h = (operator.index(n) for n in size)  # type: ignore[union-attr]  # pyright: ignore[reportGeneralTypeIssues]
    except (TypeError, ValueError):
        raise GraphError(f"{what}={size!r}: give the view's (width, height) in whole pixels.") from None
    if w < 1 or h < 1:
        raise GraphError(
            f"{what}={size!r}: a view needs at least 1 x 1 pixels; do not render while a window is minimised."
        )
    return (w, h)
