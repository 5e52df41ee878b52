"""CloudField: where there is cloud and how dense it is, as shaders read it: layers, noise, weather of a moment."""

from __future__ import annotations

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...components import CloudLayer, Clouds
from ...engine.blocks.bindings import (
    CLOUD_BLOCK,
    CLOUD_CELLS_UNIT,
    CLOUD_FIBRES_UNIT,
    CLOUD_RIMS_UNIT,
    CLOUD_SHAPE_UNIT,
    CLOUD_SLAB_UNIT,
    WEATHER_FIRST_UNIT,
    WEATHER_SECOND_UNIT,
)
from ...engine.blocks.layout import zeros
from ...engine.gpu import GpuScope
from ...engine.settings import Settings
from .block import CloudBlock, cloud_block
from .fibres import fibres_texture
from .imported import imported_cover
from .layers import frames_at, has_cirrus, kind_of, layers_of, noise_places, write_filter, write_layers, write_noise
from .maps import BORDER, WeatherMaps
from .model import CloudModel
from .shell_probe import slab_texture
from .view_block import CloudKind, CloudViewBlock
from .volumes import make_volume

__all__ = ["CloudField"]

_SHAPE, _RIMS, _CELLS = 0, 1, 2


class CloudField:
    """What clouds/density.glsl and the light in clouds read: two uniform blocks, three volumes, three maps, one table.

    block: of the last `place`, for who draws to write into a buffer of its own, and to set what is its own in it
    before. layers: with cloud, lowest first. first: base
    and thickness of the layer that noise and maps of the shadow are measured by, in metres.
    """

    def __init__(self, gpu: GpuScope, settings: Settings) -> None:
        self._gpu = gpu
        self.block = zeros(CloudViewBlock)
        self._model_ubo = gpu.uniform_block(CloudBlock, CLOUD_BLOCK, "cloud_model")
        self._slabs: moderngl.Texture | None = None
        self._fibre_texels = int(settings["clouds.fibre_texels"])
        self._fibres = gpu.texture((1, 1), "rgba8", bytes(4))
        self._between_levels = False
        self._droplets: tuple[tuple[float, float], ...] = ()
        self.shape = make_volume(gpu, _SHAPE, int(settings["clouds.shape_texels"]))
        self.rims = make_volume(gpu, _RIMS, int(settings["clouds.rim_texels"]))
        # Four times wider than the shape, of twice as wide texels: what is finer is the shape's to show.
        self.cells = make_volume(gpu, _CELLS, int(settings["clouds.shape_texels"]) // 2)
        write_filter(self.block, self.shape, self.rims, self.cells)
        self.maps = WeatherMaps(gpu, int(settings["clouds.map_texels"]))
        self._textures: tuple[moderngl.Texture, moderngl.Texture] | None = None
        self.layers: list[CloudLayer] = []
        self.wind_m_s, self.first, self.mirrored = 0.0, (0.0, 1.0), True
        self.frames, self._radius_m = frames_at(0.0, 1.0, 0.0), 1.0

    def take(self, component: Clouds) -> None:
        """These clouds from now on. ValueError (MapError) for an imported map that can't be read: all stays."""
        cover = imported_cover(component.weather_map) if component.weather_map else None
        self.layers = layers_of(component)
        if has_cirrus(self.layers) and self._fibres.width == 1:
            self._gpu.free(self._fibres)
            self._fibres = fibres_texture(self._gpu, self._fibre_texels)
            if self._between_levels:
                self.filter_between_levels()
        cumulus = [layer for layer in self.layers if kind_of(layer) == CloudKind.CUMULUS]
        self.wind_m_s = float(component.wind_speed_m_s)
        first = cumulus[0] if cumulus else component
        self.first = float(first.base_m), float(first.top_m - first.base_m)
        coverage = float(first.coverage) or 0.6
        self.maps.take(coverage, cover, int(component.weather_seed), float(component.aggregation))
        present = [layer for layer in (component, *component.layers) if any(layer is one for one in self.layers)]
        numbers = [next(i for i, one in enumerate(present) if one is layer) for layer in self.layers]
        write_layers(self.block, self.layers, coverage, numbers, self.first[1])
        self.mirrored = bool(component.mirrored)
        block = self.block
        block.surface_shadows, block.surface_skylight = float(component.shadows), float(component.skylight)
        block.sea_clouds, block.thickness_spread = float(self.mirrored), float(component.thickness_spread)

    def light(self, model: CloudModel) -> None:
        """The model's block, and the table of light scattered more than once where the droplets are others."""
        self._model_ubo.write(cloud_block(model))
        droplets = tuple((layer.albedo, layer.asymmetry) for layer in model.present)
        if droplets != self._droplets or self._slabs is None:
            if self._slabs is not None:
                self._gpu.free(self._slabs)
            self._slabs, self._droplets = slab_texture(self._gpu, model), droplets

    @property
    def placed(self) -> bool:
        """Whether there is weather of any moment."""
        return self._textures is not None

    def places(self, points_m: NDArray[np.float64]) -> NDArray[np.float64]:
        """(N, 7, 4) of layers.noise_places, for points at the moment of the last `place`."""
        return noise_places(*self.frames, points_m, self.first[1], self._radius_m)

    def place(self, anchor_m: NDArray[np.float64], radius_m: float, time_s: float) -> None:
        """Noise and weather of a moment, around an anchor (planet-centred). Maps: those that `maps.charts` shows."""
        turn, tilt = self.frames = frames_at(self.wind_m_s, radius_m, time_s)
        self._radius_m = radius_m
        write_noise(
            self.block,
            turn,
            tilt,
            anchor_m,
            radius_m,
            self.first[1],
            self.shape.texture.size[0],
            self.cells.texture.size[0],
            self.rims.texture.size[0],
            self._fibre_texels,
        )
        texel_m = radius_m * np.sqrt(4.0 * np.pi) / self.maps.size
        block, maps = self.block, self.maps
        block.second_map_share, block.map_texels, block.map_border = maps.charts.share, maps.size, BORDER
        block.map_texel_m = texel_m
        self._textures = self.maps.shown

    def filter_between_levels(self) -> None:
        """Noise between two mip levels is interpolated, for who has no chance to decide for one of them ray by ray."""
        self._between_levels = True
        for texture in (self.shape.texture, self.rims.texture, self.cells.texture, self._fibres):
            texture.filter = (moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR)

    def bind(self) -> None:
        """Bind all but `block`."""
        assert self._slabs is not None and self._textures is not None
        self._model_ubo.bind()
        self._slabs.use(CLOUD_SLAB_UNIT)
        self.shape.texture.use(CLOUD_SHAPE_UNIT)
        self.rims.texture.use(CLOUD_RIMS_UNIT)
        self.cells.texture.use(CLOUD_CELLS_UNIT)
        self._textures[0].use(WEATHER_FIRST_UNIT)
        self._textures[1].use(WEATHER_SECOND_UNIT)
        self._fibres.use(CLOUD_FIBRES_UNIT)

    def textures(self) -> dict[str, tuple[moderngl.Texture, ...]]:
        """What it holds, by what it is for: to count memory."""
        return {
            "volumes of noise": (self.shape.texture, self.rims.texture, self.cells.texture),
            "trails of ice": (self._fibres,),
            "maps of weather": self.maps.textures,
            "table of light": () if self._slabs is None else (self._slabs,),
        }  # fmt: skip
