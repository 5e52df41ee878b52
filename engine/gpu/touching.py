"""What a device tells a listener of its commands (watch.py), where there is one."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import AbstractContextManager
from typing import Protocol, TypeVar

import moderngl

from ..graph.touches import PassWatch
from .shaders import LinkedProgram

__all__ = ["CommandWatch"]

T = TypeVar("T")


class CommandWatch(PassWatch, Protocol):
    """Hears draws, dispatches and barriers."""

    def dispatched(self, linked: LinkedProgram, indirect: moderngl.Buffer | None = None) -> None:
        """Right before a dispatch."""
        ...

    def drawn(self, linked: LinkedProgram, inputs: Iterable[object], indirect: moderngl.Buffer | None = None) -> None:
        """Right before a draw. inputs: vertex and index buffers."""
        ...

    def copied(self, source: moderngl.Framebuffer | None, target: moderngl.Framebuffer) -> None:
        """With a copy from one framebuffer to another. None: the target was cleared."""
        ...

    def barrier(self, textures: bool = True, buffers: bool = True) -> None:
        """Stores to objects of these kinds are seen by what follows."""
        ...

    def apart(self) -> AbstractContextManager[None]:
        """See Device.apart."""
        ...

    def follow(self, obj: T) -> T:
        """The same texture, buffer or framebuffer, whose own methods that move data are heard, too."""
        ...
