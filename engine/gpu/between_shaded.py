"""BetweenShaded: the pixels between those that were shaded, where one of a block of 2 x 2 is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from .scope import GpuScope

__all__ = ["BetweenShaded"]


class BetweenShaded:
    """Interpolates the radiance of one surface's pixels, tile by tile, after shaders made with SHADE_PX 2
    (common/surface_tiles.glsl). The depth must be bound to texture unit 0 and the surfaces to unit 3."""

    def __init__(self, gpu: GpuScope, surface: str, settings: Mapping[str, Any]) -> None:
        """surface: its name in common/surfaces.glsl."""
        stored = str(settings.get("sky.radiance_format", "rgba32f"))
        self._gpu = gpu
        self._program = gpu.compute("common/between_shaded.comp", {"SURFACE": surface, "SCENE_FORMAT": stored})

    def run(self, radiance: Any, lists: Iterable[Any]) -> None:
        """radiance: the texture; lists: buffers of tiles with their dispatch, as the shading had them."""
        self._gpu.gpu.barrier()
        radiance.bind_to_image(0, read=True, write=True)
        for tiles in lists:
            tiles.bind_to_storage_buffer(7)
            self._program.run_indirect(tiles)
