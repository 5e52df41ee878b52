"""Weather maps on the GPU: drawn tile by tile, a coarse one at once where time has jumped.

Those that a first picture waits for are kept on disk: drawing one takes a second without a GPU.
"""

from __future__ import annotations

import math
from time import perf_counter

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...engine.gpu import Compute, GpuScope
from ...engine.gpu.kept_maps import KeptMaps
from . import weather as w
from .charts import Chart, Charts
from .imported import IMPORT_BORDER

__all__ = ["BORDER", "WeatherMaps"]

BORDER = 16
"""Texels around the map that repeat what lies across its edges, so that five levels of it can be filtered."""
LEVELS = 5
_FILTER = (moderngl.LINEAR_MIPMAP_NEAREST, moderngl.LINEAR)
COARSER = 4
"""Texels of a map to one of the coarse map that stands in for it; BORDER is a multiple."""
_TILE = (256, 8)
"""Texels drawn at once: 1 to 2 ms on two cores without a GPU."""
_BUDGET_S = 3e-3
"""Of a frame, for drawing maps; where a tile takes longer, one tile. A GPU doesn't say how long it took: there the
number of tiles in a frame is the limit."""
_MOST_TILES = 16
_BALANCE_TEXELS = 256
_KEPT = 2
"""Maps that are written to disk after the weather has changed, those of one moment: a flight draws one after another,
and nobody asks for most of them again."""
_BALANCE_VERSION = 1
"""Of what is kept on disk; to be raised whenever `weather.balance_for` gives other values."""
_OCTAVES = 7
_SLOPE = 2.5
"""How sharply the map parts clear sky from cloud."""
_BROKEN_SLOPE = 0.5
"""Of broken convection over other weather's, without aggregation."""


class WeatherMaps:
    """What is shown of the weather: two textures and the share of the second. size: texels a side, no border."""

    def __init__(self, gpu: GpuScope, size: int) -> None:
        self._gpu, self.size, self._seed = gpu, size, 0
        self._cover: NDArray[np.float32] | None = None
        self._cover_texture: moderngl.Texture | None = None
        self._moment = gpu.uniform_block(w.WeatherBlock, 15, "weather")
        self._program = gpu.compute("clouds/weather.comp", self._defines())
        self._widen = gpu.compute("clouds/weather_widen.comp")
        side = size + 2 * BORDER
        self._textures = [gpu.texture((side, side), "rgba8", levels=LEVELS, filter="linear") for _ in range(3)]
        small = size // COARSER + 2 * BORDER // COARSER
        self._small = gpu.texture((small, small), "rgba8", filter="linear")
        self._columns, self._rows = math.ceil(side / _TILE[0]), math.ceil(side / _TILE[1])
        self._coverage, self._broken_slope = -1.0, _BROKEN_SLOPE
        self._balance = (0.0, 1.0)
        self._kept = KeptMaps(gpu)
        self._to_keep = _KEPT
        self.charts = Charts(self)
        self.tiles_drawn = self.made = 0

    @property
    def tiles(self) -> int:
        """See charts.ChartDrawing."""
        return self._columns * self._rows

    @property
    def shown(self) -> tuple[moderngl.Texture, moderngl.Texture]:
        """The two textures."""
        return self._textures[self.charts.first.slot], self._textures[self.charts.second.slot]

    @property
    def textures(self) -> tuple[moderngl.Texture, ...]:
        """All that is held."""
        imported = () if self._cover_texture is None else (self._cover_texture,)
        return (*self._textures, self._small, *imported)

    def texture_of(self, number: int) -> moderngl.Texture | None:
        """The map of this number, if it is held whole."""
        return next((self._textures[chart.slot] for chart in self.charts.all if chart.is_of(number)), None)

    def take(self, coverage: float, cover: NDArray[np.float32] | None, seed: int = 0, aggregation: float = 0.0) -> None:
        """From now on maps have this mean cover, or that of `cover` (imported.imported_cover).

        aggregation: 0..1, of broken convection (Clouds.aggregation).
        """
        broken_slope = _BROKEN_SLOPE + (1.0 - _BROKEN_SLOPE) * aggregation
        if seed != self._seed:
            self._seed, self._coverage = seed, -1.0
        if cover is not self._cover:
            self._cover = cover
            for made in (self._program, *((self._cover_texture,) if self._cover_texture is not None else ())):
                self._gpu.free(made)
            self._cover_texture = None
            if cover is not None:
                self._cover_texture = self._gpu.texture(cover.shape, "r16f", cover.astype(np.float16), filter="linear")
            self._program = self._gpu.compute("clouds/weather.comp", self._defines())
            self._coverage = -1.0
        if (coverage, broken_slope) == (self._coverage, self._broken_slope):
            return
        self._coverage, self._broken_slope, self._to_keep = coverage, broken_slope, _KEPT
        self.charts.forget()
        if cover is None:
            self._balance_to(coverage)

    def _balance_to(self, coverage: float) -> None:
        program = self._gpu.compute("clouds/weather.comp", {**self._defines(), "BALANCE": 1})
        moment = w.WeatherBlock.at(0.0, self._seed)
        by = (_BALANCE_VERSION, coverage, _SLOPE, self._broken_slope, _BALANCE_TEXELS, self.size)
        key = self._kept.key("balance", program.linked.key, moment, *by)
        held = self._kept.cache.load(key, {"balance": (2,)}, np.float64)
        if held is None:
            held = {"balance": np.array(self._balanced(program, coverage))}
            self._kept.cache.save(key, held)
        self._gpu.free(program)
        level, slope = held["balance"].tolist()
        self._balance = level, slope

    def _balanced(self, program: Compute, coverage: float) -> tuple[float, float]:
        texture = self._gpu.texture((_BALANCE_TEXELS, _BALANCE_TEXELS), "rgba32f")
        self._prepare(program, 0, 0.0)
        texture.bind_to_image(0, read=False, write=True)
        program.set("u_corner", (0, 0))
        program.run(_BALANCE_TEXELS // 8, _BALANCE_TEXELS // 8)
        self._gpu.ctx.memory_barrier()
        raw = np.frombuffer(texture.read(), np.float32).reshape(_BALANCE_TEXELS, _BALANCE_TEXELS, 4)[..., 0]
        self._gpu.free(texture)
        return w.balance_for(raw, w.octahedral_weights(_BALANCE_TEXELS), coverage, _SLOPE)

    def draw(self, chart: Chart, most: int | None) -> None:
        """See charts.ChartDrawing."""
        assert chart.number is not None
        texture = self._textures[chart.slot]
        waited_for = most is None and not chart.drawn
        if waited_for and self._kept.load(self._key(chart.number), texture):
            chart.drawn = self.tiles
            self._complete(chart)
            return
        self._prepare(self._program, BORDER, chart.number * w.STEP_S)
        texture.bind_to_image(0, read=False, write=True)
        left = self.tiles - chart.drawn
        count = left if most is None else min(left, most, _MOST_TILES)
        end = math.inf if most is None else perf_counter() + _BUDGET_S
        for _ in range(count):
            row, column = divmod(chart.drawn, self._columns)
            self._program.set("u_corner", (column * _TILE[0], row * _TILE[1]))
            self._program.run(_TILE[0] // 8, _TILE[1] // 8)
            chart.drawn += 1
            self.tiles_drawn += 1
            if perf_counter() > end:
                break
        if chart.drawn == self.tiles:
            self._filter(texture)
            self._complete(chart)
            if waited_for and self._to_keep:
                self._to_keep -= 1
                self._kept.save(self._key(chart.number), texture)

    def _complete(self, chart: Chart) -> None:
        self._textures[chart.slot].filter = _FILTER
        chart.complete = True
        self.made += 1

    def _key(self, number: float) -> str:
        """Of the map of this number on disk."""
        cover = b"" if self._cover is None else self._cover.tobytes()
        moment = w.WeatherBlock.at(number * w.STEP_S, self._seed)
        drawn = (moment, self._balance, self._broken_slope, self.size, BORDER, cover)
        return self._kept.key("weather", self._program.linked.key, *drawn)

    def draw_coarse(self, chart: Chart) -> None:
        """See charts.ChartDrawing."""
        assert chart.number is not None
        self._prepare(self._program, BORDER // COARSER, chart.number * w.STEP_S)
        self._small.bind_to_image(0, read=False, write=True)
        self._program.set("u_corner", (0, 0))
        self._program.run(-(-self._small.width // 8), -(-self._small.height // 8))
        self._gpu.ctx.memory_barrier()
        texture = self._textures[chart.slot]
        self._small.use(0)
        texture.bind_to_image(0, read=False, write=True)
        self._widen.run_over(*texture.size)
        self._filter(texture)
        texture.filter = _FILTER

    def _defines(self) -> dict[str, int]:
        imported = {} if self._cover is None else {"IMPORTED": 1}
        return {"CYCLONES": w.CYCLONES, "OCTAVES": _OCTAVES, **imported}

    def _filter(self, texture: moderngl.Texture) -> None:
        """Its coarser levels."""
        self._gpu.ctx.memory_barrier()
        texture.build_mipmaps(max_level=LEVELS - 1)

    def _prepare(self, program: Compute, border: int, time_s: float) -> None:
        program.set("u_border", border)
        if self._cover_texture is not None:
            self._cover_texture.use(0)
            program.set("u_cover_border", float(IMPORT_BORDER))
        elif program is self._program:
            level, slope = self._balance
            program.set("u_balance_level", level)
            program.set("u_balance_slope", slope)
        program.set("u_broken_slope", self._broken_slope)
        program.set("u_texel_rad", math.sqrt(4.0 * math.pi) / self.size)
        self._moment.write(w.WeatherBlock.at(time_s, self._seed))
        self._moment.bind()
