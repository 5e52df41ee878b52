"""Shaders that later frames of a flight will need, made one a frame before they do."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import suppress

from .frame import Frame
from .gpu.errors import ShaderError
from .gpu.program import Program

__all__ = ["WarmUp"]


class WarmUp:
    """A list of makers, one of which is called in each frame of a view that goes on.

    A frame that has to wait for a compiler is a hitch; a first picture that waits for all shaders that a flight may
    want is late. Pictures by themselves (`Frame.one_shot`, `Frame.settling`) make nothing ahead. makers: each makes one
    program, or finds it there, and gives it back to be linked.
    """

    def __init__(self, makers: Iterable[Callable[[], object]]) -> None:
        self._left = list(makers)[::-1]

    @property
    def done(self) -> bool:
        """Whether all of them have been called."""
        return not self._left

    def step(self, frame: Frame) -> None:
        """Call the next one, if the frame is of a view that goes on. A shader that is broken just then is left to the
        frame that needs it, which may come after it is mended."""
        if self._left and not (frame.one_shot or frame.settling):
            with suppress(ShaderError):
                made = self._left.pop()()
                if isinstance(made, Program):
                    _ = made.mgl
