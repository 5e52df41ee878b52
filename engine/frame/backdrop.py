"""What stands before the stars and behind a planet's own air: other planets, in one picture of the view's size.

Whoever draws them creates the resource LIGHT (radiance, and the share that they hide of what is behind) and tells
`view.planets_px`; who draws what is behind them, or puts them into the picture, reads both through `Backdrop`.
"""

from __future__ import annotations

import moderngl

from ..graph import PassIO
from .frame import View

__all__ = ["LIGHT", "SOURCE", "Backdrop"]

LIGHT = "companions.light"
"""Resource of the frame graph. rgb: radiance, W m^-2 sr^-1 nm^-1, before the air of the camera's planet; a: hidden."""
SOURCE = "companions.source"
"""World resource: who draws other planets; there where a scene has several."""


class Backdrop:
    """LIGHT as one pass reads it. io: of the pass, which has it in reads_optional. empty: a texture of one black texel,
    bound where there is nothing."""

    def __init__(self, io: PassIO, view: View, empty: moderngl.Texture) -> None:
        self._view, self._empty = view, empty
        self._light = io.texture(LIGHT) if io.has(LIGHT) else empty

    @property
    def rect(self) -> tuple[int, int, int, int] | None:
        """Where other planets are in this frame."""
        return self._view.planets_px

    def use(self, unit: int) -> bool:
        """Bind it; whether there is anything in it."""
        there = self.rect is not None
        (self._light if there else self._empty).use(unit)
        return there
