"""Shader files that code of the project makes, the same for every renderer: `#include` finds them like files.

What differs between renderers is a virtual file of theirs instead (`ShaderLibrary.add_virtual`), which goes first.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

__all__ = ["MADE", "made_shader"]

MADE: dict[str, Callable[[], str]] = {}
"""Name, such as "generated/terrain_surface.glsl" -> its text, made at the first call."""


def made_shader(name: str, make: Callable[[], str]) -> None:
    """Make `#include "name"` mean what `make` returns."""
    MADE[name] = cache(make)
