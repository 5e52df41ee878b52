"""Paths as users write them, which may name nothing that there could be."""

from __future__ import annotations

import os
from pathlib import Path

__all__ = ["place_of"]


def place_of(path: str | os.PathLike[str]) -> Path:
    """The path with `~` as the user's own folder, and `~name` as that of a user; where there is no such user it stays
    as it is, a name like any other, so that who opens it says that it isn't there."""
    return Path(os.path.expanduser(path))
