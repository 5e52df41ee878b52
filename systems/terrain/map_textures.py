"""The GPU's copies of height map, colour map, rivers and forests, bound where the height function and the ground's
light read them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...engine.blocks.bindings import COLOR_MAP_UNIT, HEIGHT_MAP_UNIT, RIVERS_UNIT, WOODS_UNIT
from ...engine.gpu import GpuScope
from ...engine.real_ground.color_ground import ColorGround
from ...engine.real_ground.real_ground import RealGround
from ...engine.real_ground.streamed_colors import StreamedColors
from ...engine.real_ground.streamed_ground import StreamedGround
from ...engine.surface.cube_map import CubeMap
from .color_stream import ColorStream
from .height_map import HeightMap
from .real_colors import color_texels, pictured_width_bits
from .real_stream import RealStream
from .real_texture import fixed_unit_m, real_texels
from .rivers.table import RiverTable
from .rivers.texture import river_texels
from .woods_map import WoodsMap

__all__ = ["MapTextures"]


class MapTextures:
    """Textures of the maps in use; none, and no cost, without maps."""

    def __init__(self, gpu: GpuScope) -> None:
        self._gpu = gpu
        self._shown: list[Any] = [None, None, None, None]
        self._textures: list[Any] = [None, None, None, None]
        self._radius_m = 0.0
        self.stream: RealStream | None = None
        """Brings the pages of real ground that streams."""
        self.color_stream: ColorStream | None = None
        """Brings those of pictures."""

    @property
    def streams(self) -> list[RealStream | ColorStream]:
        """What brings pages."""
        return [each for each in (self.stream, self.color_stream) if each is not None]

    def release(self) -> None:
        """What the scope doesn't own."""
        for each in self.streams:
            each.release()
        self.stream = self.color_stream = None

    def show(
        self,
        height: HeightMap | RealGround | None,
        color: CubeMap | ColorGround | None,
        rivers: RiverTable | None = None,
        woods: WoodsMap | None = None,
        radius_m: float = 0.0,
        highest_m: float = 0.0,
    ) -> None:
        """Make the textures of these, unless they are there already, and free those of others. radius_m: of the
        planet, highest_m: of its ground, for tiles."""
        for k, tiles in enumerate((height, color)):
            if isinstance(tiles, (RealGround, ColorGround)) and radius_m != self._radius_m:
                self._shown[k] = None  # its places are counted on the sphere
        self._radius_m = radius_m
        for k, found in enumerate((height, color, rivers, woods)):
            if found is self._shown[k]:
                continue
            if self._textures[k] is not None:
                self._gpu.free(self._textures[k])
            if k == 0 and self.stream is not None:
                self.stream.release()
                self.stream = None
            if k == 1 and self.color_stream is not None:
                self.color_stream.release()
                self.color_stream = None
            self._shown[k], self._textures[k] = found, None
            if isinstance(found, HeightMap):
                picture = found.cube.atlas()
                self._textures[k] = self._gpu.texture(picture.shape[1::-1], "rg32f", picture)
            elif isinstance(found, StreamedGround):
                self.stream = RealStream(self._gpu, found, radius_m)
                self._textures[k] = self.stream.texture
            elif isinstance(found, RealGround):
                words = real_texels(found, fixed_unit_m(radius_m), radius_m)
                self._textures[k] = self._gpu.texture(words.shape[::-1], "r32ui", words)
            elif isinstance(found, StreamedColors):
                self.color_stream = ColorStream(self._gpu, found, radius_m, highest_m)
                self._textures[k] = self.color_stream.texture
            elif isinstance(found, ColorGround):
                words = color_texels(found, radius_m)
                self._textures[k] = self._gpu.texture(words.shape[::-1], "r32ui", words)
            elif isinstance(found, RiverTable):
                _, texels = river_texels(found)
                self._textures[k] = self._gpu.texture(texels.shape[1::-1], "rgba32ui", texels.view(np.uint32))
            elif isinstance(found, WoodsMap):
                size = found.share.shape[::-1]
                levels = max(size).bit_length()
                self._textures[k] = self._gpu.texture(size, "r8", found.share, levels, filter="trilinear")
            elif found is not None:
                picture = found.atlas()
                roots = np.full((*picture.shape[:2], 4), 255, dtype=np.uint8)  # square roots: even steps for the eye
                roots[:, :, :3] = np.rint(255.0 * np.sqrt(np.clip(picture, 0.0, 1.0)))
                self._textures[k] = self._gpu.texture(picture.shape[1::-1], "rgba8", roots)

    def write_color(self, table: NDArray[Any], strength: float) -> None:
        """The colour map's part of the height function's table."""
        color = self._shown[1]
        if isinstance(color, ColorGround):
            table["color"] = (0, pictured_width_bits(color), strength)
        elif color is not None:
            table["color"] = (color.cells, len(color.levels), strength)

    def bind(self) -> None:
        units = HEIGHT_MAP_UNIT, COLOR_MAP_UNIT, RIVERS_UNIT, WOODS_UNIT
        for texture, unit in zip(self._textures, units, strict=True):
            if texture is not None:
                texture.use(unit)
