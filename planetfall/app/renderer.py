"""The renderer of a flight's window: what it draws at when nobody says."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from ..engine.gpu.caps import is_software
from ..render.renderer import Renderer
from ..scene.scene import Scene

if TYPE_CHECKING:
    from ..engine.hosts.window import Window
    from .flight import RendererMaker

__all__ = ["SOFTWARE", "USUAL", "renderer_maker", "usual_quality"]

log = logging.getLogger(__name__)

USUAL = ("high", 1.0)
SOFTWARE = ("low", 0.5)
"""Quality, and rows drawn for each row of the window: on a GPU, and where the processor draws. There a flight in all
pixels would be a row of stills."""


def usual_quality(driver: str) -> tuple[str, float]:
    """For a driver's name (GL_RENDERER)."""
    return SOFTWARE if is_software(driver) else USUAL


def renderer_maker(scene: Scene, window: Window, quality: str | None) -> tuple[str, RendererMaker]:
    """The quality to begin with, and what makes a renderer for the window at a quality. quality: None for the usual
    one, which the first renderer has at its scale; whoever then chooses another has all pixels of it."""
    first = usual_quality(window.ctx.info["GL_RENDERER"]) if quality is None else (quality, 1.0)
    if quality is None and first == SOFTWARE:
        log.info("no GPU: quality %s at half the window's width and height; the Quality page changes it", first[0])
    scales = [first[1]]

    def make(quality: str, overrides: Mapping[str, Any]) -> Renderer:
        # The window may come out larger or smaller than asked for.
        scale = scales.pop() if scales else 1.0
        width, height = (max(round(scale * side), 1) for side in window.framebuffer_size)
        # The window is ours: nobody waits for its GL state to be given back, which takes an eighth of a frame's Python.
        made = Renderer(scene, (width, height), quality, overrides, ctx=window.ctx, guard=False)
        made.render_scale = scale
        made.tolerant = True  # a system that fails is shown, and the flight goes on
        return made

    return first[0], make
