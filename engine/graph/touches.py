"""What a backend that is asked to watch tells of a pass's commands (watching.py)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

__all__ = ["Identity", "PassWatch", "Touch"]

Identity = tuple[str, int]
"""A backend's name for an object: ("texture", 7)."""


@dataclass(frozen=True)
class Touch:
    """Some command of a pass reads or writes an object. how: by what, for messages ("u_depth of clouds/sky.comp")."""

    object: Identity
    reads: bool
    writes: bool
    how: str
    unordered_after: str = ""
    """By what the object was stored to before, with no barrier since: the touch may come too early. "": all is well."""


class PassWatch(Protocol):
    """A backend's ear on its own commands."""

    def begin(self) -> None:
        """From here on commands are a pass's."""
        ...

    def end(self) -> list[Touch]:
        """What commands since begin() have touched."""
        ...

    def identity(self, obj: object) -> Identity | None:
        """Of an object of the graph or an import; None for what is no object of the backend's."""
        ...
