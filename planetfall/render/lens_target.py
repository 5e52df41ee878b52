"""A lens's picture into a host's framebuffer."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import moderngl

    from ..engine.gpu import Gpu

__all__ = ["LensTarget"]


class LensTarget:
    """Uploads a picture and draws it. The context is current in every call."""

    def __init__(self, gpu: Gpu) -> None:
        self._scope = gpu.scope("lens")
        self._present = self._scope.fullscreen("outputs/present.frag", {"SCALED": 1})
        self._plain = gpu.state(depth_test=False, cull=None, blend=None)
        self._texture: moderngl.Texture | None = None

    def draw(self, color: NDArray[np.uint8], target: moderngl.Framebuffer) -> None:
        """A picture (H, W, 3), row 0 on top, over all of the framebuffer's viewport."""
        height, width = color.shape[:2]
        pixels = np.full((height, width, 4), 255, np.uint8)
        pixels[..., :3] = color[::-1]
        if self._texture is not None and self._texture.size != (width, height):
            self._scope.free(self._texture)
            self._texture = None
        if self._texture is None:
            self._texture = self._scope.texture((width, height), "rgba8", pixels)
        else:
            self._texture.write(pixels.tobytes())
        target.use()
        self._plain.apply()
        self._texture.use(0)
        self._present.render()

    def release(self) -> None:
        """Free what it has."""
        self._scope.release()
