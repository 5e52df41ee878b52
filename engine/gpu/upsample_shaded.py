"""UpsampleShaded: the pixels between those that were shaded, where every second or every fourth is."""

from __future__ import annotations

from collections.abc import Iterable

import moderngl

from ..blocks.bindings import RADIANCE_IMAGE, TILE_BUFFER
from ..settings import Settings
from .program import Compute
from .scope import GpuScope

__all__ = ["UpsampleShaded"]


class UpsampleShaded:
    """Gives the pixels between their light, tile by tile, after shaders made with SHADE_EVERY 2 or 4
    (common/surface_tiles.glsl). The depth must be bound to DEPTH_UNIT and the surfaces to SURFACE_UNIT."""

    def __init__(self, gpu: GpuScope, surface: str, every: int, settings: Settings) -> None:
        """surface: its name in common/surfaces.glsl; every: SHADE_EVERY of its shaders."""
        stored = str(settings.get("sky.radiance_format", "rgba32f"))
        self._gpu, self._every = gpu, every
        self._defines: dict[str, int | str] = {"SURFACE": surface, "SHADE_EVERY": every, "SCENE_FORMAT": stored}
        self._programs: dict[bool, Compute] = {}
        self.program(False)

    def leaves_out(self, checkerboard: int | None) -> bool:
        """Whether there are pixels between, in a frame with these `Frame.checkerboard`."""
        return self._every > 2 or checkerboard is not None

    def run(self, radiance: moderngl.Texture, lists: Iterable[moderngl.Buffer], by_lens: bool = False) -> None:
        """radiance: the texture; lists: buffers of tiles with their dispatch, as the shading had them. by_lens: what is
        seen through water was shaded apart."""
        program = self.program(by_lens)
        self._gpu.barrier()
        radiance.bind_to_image(RADIANCE_IMAGE, read=True, write=True)
        with self._gpu.apart():  # pixels that were shaded are read, those between are stored
            for tiles in lists:
                tiles.bind_to_storage_buffer(TILE_BUFFER)
                program.run_indirect(tiles)

    def program(self, by_lens: bool) -> Compute:
        """The shader that run() uses; the one by the lens is made when it is first asked for."""
        if by_lens not in self._programs:
            defines = self._defines | ({"BY_LENS": 1} if by_lens else {})
            self._programs[by_lens] = self._gpu.compute("common/upsample_shaded.comp", defines)
        return self._programs[by_lens]
